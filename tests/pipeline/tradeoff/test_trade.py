"""Speed against accuracy, measured on a small scene."""

import csv

import pytest

import pipeline
from pipeline.constants import PRESET_BOUNDS
from pipeline.figures.studies import draw_trade
from pipeline.tradeoff import trade as tradeoff
from pipeline.tradeoff.trade import trade
from tests.helpers.accuracy_scenes import PAPER
from tests.helpers.entries import changed
from tests.helpers.heard import Heard
from tests.helpers.scenes import SCENE
from tribo import PRESETS, ConvergenceError, Grid, SelfAffineRoughness

SMALL = changed(
    PAPER,
    loads=(200.0,),
    pixels=Grid((48, 24), (8e-6, 8e-6)),
    roughness=SelfAffineRoughness(0.27e-6, 0.8, (16e-6, 16e-6), seed=0),
)


@pytest.fixture(scope="module")
def measured():
    said = Heard()
    table = trade(SMALL, progress=said.hear)
    assert said[0].startswith(f"{len(table.choices)} choices at 1 place")
    assert said[1] == f"1 of {len(table.choices)}: reference"
    assert len(said) == 1 + len(table.choices)
    assert said[-1].startswith("{0} of {0}: ".format(len(table.choices)))
    return table


def named(table, name):
    return next(choice for choice in table.choices if choice.name == name)


def test_presets_err_by_less_than_their_bounds(measured):
    for name in PRESETS:
        assert named(measured, name).velocity_error < PRESET_BOUNDS[name]
    assert named(measured, "reference").velocity_error == 0


def test_a_choice_that_does_not_converge_is_named_and_left_out(monkeypatch):
    def probe(sweep, fidelity, *arguments, **options):
        if fidelity.increments == PRESETS["standard"].increments:
            raise ConvergenceError("the contact did not converge", None)
        return tried(sweep, fidelity, *arguments, **options)

    tried = tradeoff.probe
    monkeypatch.setattr(tradeoff, "probe", probe)
    table = trade(SMALL, presets=("standard", "fine"))
    assert table.not_converged == ("standard: the contact did not converge",)
    assert {"fine", "reference"} < {choice.name for choice in table.choices}
    assert "standard" not in {choice.name for choice in table.choices}
    assert "standard: the contact did not converge" in str(table)


def test_none_of_the_front_is_beaten(measured):
    assert measured.front[-1] is measured.reference
    for one in measured.front:
        assert not any(
            other.seconds < one.seconds and other.velocity_error < one.velocity_error
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
    assert f"{point.load:g} N {point.velocity:.3g} m/s" in said
    choices = {one.name: one for one in measured.choices}
    with (tmp_path / "trade.csv").open() as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    assert rows.keys() == choices.keys() == {one["name"] for one in document}
    for told in document:
        one = choices[told["name"]]
        assert one.velocity_error == max(map(abs, one.velocity_errors))
        assert told["velocity error [%]"] == pytest.approx(100 * one.velocity_error)
        assert told["error at any load [%]"] == pytest.approx(100 * one.error_at_any_load)
        assert told["seconds [s]"] == one.seconds
        assert told["share of fine"] == pytest.approx(one.seconds / choices["fine"].seconds)
        for head, value in told.items():
            if head != "name":
                assert float(rows[one.name][head]) == pytest.approx(value, rel=1e-5)


def test_the_figure_shows_presets_the_scenes_own_choice_and_the_front(measured):
    (axes,) = draw_trade(measured).axes
    drawn = {line.get_gid(): line for line in axes.lines}
    assert set(drawn) == {"front", "presets", "the scene's own"}
    presets = [choice for choice in measured.choices[:-1] if choice.name in PRESETS]
    assert list(drawn["presets"].get_xdata()) == [choice.seconds for choice in presets]
    assert list(drawn["presets"].get_ydata()) == [
        max(choice.velocity_error, 1e-4) for choice in presets
    ]
    words = {text.get_text() for text in axes.texts}
    assert words == {"standard", "fine", "the scene's own fidelity"}
