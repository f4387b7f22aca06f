"""What campaigns conclude, and which figures on the page are older than the code."""

import json

import numpy as np
import pytest

from tests import measured, mutants
from tests.promises import errors, front, goals, inputs, laboratories, loads, realizations, truth
from tests.promises.families import FAMILIES, case_of, cases
from tests.sources import measure
from tribo import PRESETS


def test_each_row_of_the_evidence_is_one_of_at_most_seventeen_that_are_measured():
    page, figures = measured.PAGE.read_text(encoding="utf-8"), measured.figures()
    assert measured.page_of(page, figures) == page, (
        "write it again: python -m tests.measured --page"
    )
    assert figures.keys() <= measured.ROWS.keys()
    assert len(measured.ROWS) <= 17


def test_a_row_is_older_after_a_change_of_its_code_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(measure, "ROOT", tmp_path)
    (tmp_path / "tribo").mkdir()
    code = tmp_path / "tribo" / "a.py"
    code.write_text("x = 1  # of old\n")
    figure = {"code": measure.code_digest("tribo")}
    assert not measured.is_old("presets", figure)
    code.write_text('"""A new word."""\n# and another\nx = 1  # of old\n')
    assert not measured.is_old("presets", figure)
    code.write_text("x = 2  # of old\n")
    assert measured.is_old("presets", figure)


def test_forty_changes_that_tests_have_to_notice_can_be_made():
    changes = mutants.mutants()
    assert len({*changes}) == len(changes) >= 40
    for change in changes:
        assert change.new in change.applied()
        assert all((mutants.ROOT / test).exists() for test in change.tests.split())


# The front of the presets


def test_the_truth_is_that_of_scenes_of_the_families_and_of_all_that_judge():
    assert len(FAMILIES) == 12
    known = json.loads(truth.TRUTH.read_text())
    scenes = {case.digest: case for case in cases(range(front.NUMBERS))}
    assert known.keys() <= scenes.keys()
    for digest, rises in known.items():
        velocities = [float(velocity.split()[0]) for velocity in scenes[digest].velocities]
        assert [float(text) for text in rises] == velocities
        assert {len(row) for row in rises.values()} == {len(scenes[digest].loads)}
    judging = {case.digest: case for case in cases(range(1, front.NUMBERS, 2))}
    assert judging.keys() <= known.keys()
    assert sum(len(case.loads) * len(case.velocities) for case in judging.values()) >= 900


@pytest.mark.parametrize(
    ("name", "family", "number"),
    [
        ("standard", "tops", 1),
        pytest.param("standard", "stages", 7, marks=pytest.mark.slow),
        ("standard", "local", 1),
        pytest.param("fine", "tops", 1, marks=pytest.mark.slow),
    ],
)
def test_presets_keep_their_promises_on_a_scene_on_which_none_was_chosen(name, family, number):
    case = case_of(family, number)
    result = front.errors(case, PRESETS[name])
    errors, warned = (np.array(result[key]) for key in ("errors", "warned"))
    bound = front.bound_of(name, result["under_strips"])
    over = np.abs(errors[~warned]) / (bound / result["over"])
    assert np.sum(over > 1) <= 1  # a bound is that of 99 % of places
    assert over.max() <= 1.5
    assert warned.mean() < 0.5


@pytest.mark.slow
def test_sets_of_realizations_agree_with_the_others_within_what_they_state():
    name = "line, across 30 µm"
    rows, held, ratios = realizations.judge_scene(name, 8, **{"sweep.loads": ["200 N", "500 N"]})
    assert {size: sets.shape for size, sets in held.items()} == {
        "1": (8, 2),
        "2": (4, 2),
        "4": (2, 2),
    }
    assert len(rows) == 2
    assert held["1"].mean() >= 0.75
    assert held["2"].mean() >= 0.75
    assert (ratios > 0.6).all()
    assert (ratios < realizations.MAX_STATED).all()


def test_bounds_that_fail_on_more_realizations_or_scenes_than_by_chance_are_wrong():
    right = [(0.95, 20)] * 17
    for further, is_right in (
        ([(0.95, 20)] * 3, True),
        ([(1.0, 20)] * 3, True),
        ([(0.8, 20), (1.0, 20), (1.0, 20)], True),  # one scene fails by chance
        ([(0.8, 20)] * 3, False),
        ([(0.55, 20)] * 2, False),
    ):
        assert realizations.are_right(right + further) == is_right
    assert not realizations.are_right([(0.88, 20)] * 20)
    assert realizations.are_right([(0.93, 20)] * 20)


def test_stated_errors_break_their_promise_by_more_misses_than_a_sample_has_by_chance():
    for count, covered_share, over, is_right in (
        (255, "93.3%", "1.0", True),
        (255, "91.4%", "1.0", False),
        (2550, "93.3%", "1.0", False),
        (2550, "95.0%", "1.0", True),
        (255, "99.6%", "4.5", False),
    ):
        line = "fine, without a warning, share 0.1", 5, count, "1%", "1%", "1%", over, covered_share
        assert errors.are_covered([line]) == is_right


@pytest.mark.parametrize(
    ("held", "is_right"), [([1.0] * 4, True), ([0.9, 1.0] * 10, True), ([0.8, 1.0] * 100, False)]
)
def test_planes_are_wrong_whose_errors_hold_at_fewer_loads_than_by_chance(held, is_right):
    for shares in ([held, [1.0] * len(held)], [[1.0] * len(held), held]):
        assert loads.kind_row("planes", np.transpose(shares))[1] == is_right


# Tests of a laboratory


@pytest.mark.parametrize("kind", laboratories.KINDS)
def test_intervals_of_the_bias_hold_it_and_verdicts_are_wrong_as_often_as_they_say(kind):
    inside, mild, severe = laboratories.judged(kind, 4, 6)
    assert inside >= 0.65  # 6 laboratories: ± 12 points for one standard deviation
    assert max(mild, severe) <= 0.12  # of some 15 and 30 points, ± 3 to 5


# Uncertain inputs


@pytest.mark.slow
def test_the_linear_rule_for_uncertain_inputs_holds_on_simulated_draws(monkeypatch):
    scene, _, points = inputs.SCENES["flagship"]
    narrower = {"window.pixels": [288, 120], "window.pixel_size": ["1.632 um", "1.9 um"]}
    monkeypatch.setitem(inputs.SCENES, "narrower", (scene, narrower, points))
    row = inputs.computed(("narrower", 1, 0.2, 8))
    assert row["refused"] == []
    assert len(row["inputs"]) == 11
    simulated, linear = (np.array(row[key]) for key in ("simulated", "linear"))
    assert np.corrcoef(simulated, linear)[0, 1] > 0.97
    assert inputs.is_right([row])


def test_a_linear_rule_that_errs_by_more_than_by_chance_is_wrong():
    draws = np.random.default_rng(0).standard_normal(200)
    for simulated, is_right in ((draws, True), (1.04 * draws, True), (1.08 * draws, False),
                                (draws + 0.3, False)):  # fmt: skip
        row = {"size": 0.2, "simulated": simulated.tolist(), "linear": draws.tolist()}
        assert inputs.is_right([row]) == is_right
        assert inputs.is_right([row | {"size": 0.4}])  # which is not promised


def test_errors_of_probabilities_by_the_linear_rule_are_those_that_many_draws_count():
    linear = np.random.default_rng(0).standard_normal(400_000)
    simulated = linear - 0.05 * linear**2 + 0.02 * linear
    counted = [(simulated > x).mean() - (linear > x).mean() for x in inputs.OFFSETS]
    row = {"simulated": simulated[:200].tolist(), "linear": linear[:200].tolist()}
    *_, error, _ = inputs.compared(row)
    assert error == pytest.approx(np.abs(counted).max(), rel=0.15)


# Accuracies that are asked for


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    """Points of a scene that the campaign draws."""
    case = next(case for _, case in goals.drawn(40) if case.name == "coarse pixels 7")
    path = tmp_path_factory.mktemp("goals") / "points.json"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(goals, "REALIZATIONS", 16)
        yield goals.Planes(goals.scene(case), path)


@pytest.mark.slow
def test_an_accuracy_holds_at_each_load(planes):
    result = planes.errors(0.05)
    assert [load for load, *_ in result["errors"]] == planes.loads.tolist()
    assert all(abs(error) <= allowed for *_, error, allowed in result["errors"])
    assert all(0.05 <= allowed < 0.06 for *_, allowed in result["errors"])


def test_more_scenes_that_err_than_a_sample_has_by_chance_break_a_promise():
    right, wrong = [200.0, 1.0, 0.04, 0.05], [200.0, 1.0, -0.06, 0.05]
    for misses, best, is_right in (
        (0, 0.03, True),
        (2, 0.03, True),  # of 10, 0.5 by chance
        (4, 0.03, False),
        (4, 0.06, True),  # which a run refuses
    ):
        errors = [[right] * 4] * (10 - misses) + [[wrong] * 4] * misses
        results = [{"5": {"best": best, "points": 30, "errors": rows}} for rows in errors]
        rows = [{"name": "a", "accuracy": result} for result in results]
        assert goals.report(rows, [5.0])[1] == is_right
