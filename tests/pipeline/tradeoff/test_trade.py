"""Speed against accuracy, measured on a small scene."""

import csv

import numpy as np
import pytest

import pipeline
from pipeline.figures.studies import draw_trade
from pipeline.sweep.plan import run_point
from pipeline.tradeoff import trade as tradeoff
from pipeline.tradeoff.trade import trade
from tests.helpers.accuracy_scenes import PAPER
from tests.helpers.heard import Heard
from tests.helpers.scenes import SCENE
from tribo import PRESETS, ConvergenceError, Grid, SelfAffineRoughness

SMALL = PAPER.changed(
    pixels=Grid((48, 24), (8e-6, 8e-6)),
    roughness=SelfAffineRoughness(0.27e-6, 0.8, (16e-6, 16e-6), seed=0),
)


@pytest.fixture(scope="module")
def measured():
    said = Heard()
    table = trade(SMALL, loads=(200.0,), progress=said.hear)
    assert said[0] == f"1 of {len(table.choices)}: reference"
    assert len(said) == len(table.choices)
    assert said[-1].startswith("{0} of {0}: ".format(len(table.choices)))
    return table


def named(table, name):
    return next(choice for choice in table.choices if choice.name == name)


def test_errors_and_costs_go_opposite_ways_from_draft_to_reference(measured):
    presets = [named(measured, name) for name in ("draft", "standard", "fine", "reference")]
    errors = [choice.velocity_error for choice in presets]
    assert all(error < bound for error, bound in zip(errors[:3], (0.08, 0.03, 0.01), strict=True))
    assert errors == sorted(errors, reverse=True)
    assert errors[3] == 0
    works = [choice.work for choice in presets]
    assert works == sorted(works)
    assert presets[0].saving > 10
    assert presets[1].saving > 5
    assert presets[2].saving > 2


def test_a_choice_that_does_not_converge_is_named_and_left_out(monkeypatch):
    def probe(sweep, fidelity, *arguments, **options):
        if fidelity.increments == PRESETS["draft"].increments:
            raise ConvergenceError("the contact did not converge", None)
        return tried(sweep, fidelity, *arguments, **options)

    tried = tradeoff.probe
    monkeypatch.setattr(tradeoff, "probe", probe)
    table = trade(SMALL, presets=("draft", "standard"), loads=(200.0,))
    assert table.not_converged == ("draft: the contact did not converge",)
    assert {"standard", "reference"} < {choice.name for choice in table.choices}
    assert "draft" not in {choice.name for choice in table.choices}
    assert "draft: the contact did not converge" in str(table)


def test_every_choice_says_what_it_costs_and_where_it_errs(measured):
    for choice in measured.choices:
        assert choice.seconds > 0
        assert choice.convolutions > 0
        assert choice.peak_bytes > 1e5
        assert len(choice.velocity_errors) == 1
        assert max(map(abs, choice.velocity_errors)) == choice.velocity_error
    # Of a rise that is known to 1 %, the velocity is known to 1 % over its exponent, about 0.6; but
    # the point whose rise errs most need not lie at the boundary.
    draft = named(measured, "draft")
    assert draft.velocity_error > draft.rise_error / 2 > 0
    assert 0 < draft.share_error < 1
    coarsest = named(measured, "as in the scene")
    assert coarsest.area_error > 0
    assert coarsest.fidelity == SMALL.scene.fidelity


def test_it_names_the_cheapest_within_an_error_and_none_of_the_front_is_beaten(measured):
    loose = measured.cheapest(0.1)
    assert loose.velocity_error <= 0.1
    assert loose.work == min(c.work for c in measured.choices if c.velocity_error <= 0.1)
    assert measured.cheapest(0.0) is measured.front[-1] is measured.reference
    for one in measured.front:
        assert not any(
            other.work < one.work and other.velocity_error < one.velocity_error
            for other in measured.choices
        )


def test_the_command_prints_the_errors_of_the_points_against_the_reference(
    measured, irg, monkeypatch, tmp_path
):
    monkeypatch.setattr(pipeline, "trade", lambda *_, **__: measured)  # it takes a while
    (tmp_path / "scene.toml").write_text(SCENE)
    document = irg("trade", tmp_path / "scene.toml", "--json")
    said = irg("trade", tmp_path / "scene.toml", "-o", tmp_path / "trade.csv")
    (point,) = measured.points
    assert document["points"] == [{"load": point.load, "velocity": point.velocity}]
    assert f"{point.load:g} N {point.velocity:.3g} m/s" in said

    def end(fidelity):
        columns = run_point(SMALL.changed(fidelity=fidelity), *point[:2]).columns
        return {name: float(np.ravel(values)[-1]) for name, values in columns.items()}

    true = end(measured.reference.fidelity)
    choices = {one["name"]: one for one in document["choices"]}
    for name in ("draft", "as in the scene"):
        here, one = end(named(measured, name).fidelity), choices[name]
        for error, value in (
            ("width_error", "contact_width"),
            ("area_error", "contact_fraction"),
            ("pressure_error", "mean_pressure"),
        ):
            assert abs(one[error]) == pytest.approx(abs(here[value] / true[value] - 1), abs=1e-9)
    reference = document["choices"][-1]
    with (tmp_path / "trade.csv").open() as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    assert rows.keys() == choices.keys()
    heads = {"velocity error [%]": 100.0, "rise error [%]": 100.0, "width error [%]": 100.0}
    heads |= {"share error": 1.0, "area error [%]": 100.0, "pressure error [%]": 100.0}
    heads |= {"saturated error": 1.0, "seconds [s]": 1.0, "speedup": 1.0, "saving": 1.0}
    heads |= {"convolutions": 1.0, "peak bytes [MB]": 1e-6}
    lines = {line.split("  ")[0]: line.split() for line in said.splitlines() if "  " in line}
    for name, one in choices.items():
        assert one["saving"] == pytest.approx(reference["work"] / one["work"])
        assert one["speedup"] == pytest.approx(reference["seconds"] / one["seconds"])
        assert one["velocity_error"] == max(map(abs, one["velocity_errors"]))
        for head, factor in heads.items():
            value = factor * one[head.partition(" [")[0].replace(" ", "_")]
            assert float(rows[name][head]) == pytest.approx(value, rel=1e-5), (name, head)
            assert f"{value:.4g}" in lines[name], (name, head, lines[name])
    for bound, name in document["cheapest_within"].items():
        within = [one for one in choices.values() if one["velocity_error"] <= float(bound)]
        assert choices[name]["work"] == min(one["work"] for one in within)
        assert f"cheapest within {100 * float(bound):g} %: {name}" in said


def test_the_figure_shows_presets_the_scenes_own_choice_and_the_front(measured):
    (axes,) = draw_trade(measured).axes
    drawn = {line.get_gid(): line for line in axes.lines}
    assert set(drawn) == {"front", "presets", "the scene's own"}
    presets = [choice for choice in measured.choices[:-1] if choice.name in PRESETS]
    assert list(drawn["presets"].get_xdata()) == [100 / choice.saving for choice in presets]
    assert list(drawn["presets"].get_ydata()) == [choice.velocity_error for choice in presets]
    words = {text.get_text() for text in axes.texts}
    assert words == {"draft", "standard", "fine", "as in the scene"}
