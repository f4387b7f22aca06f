"""How a fidelity is picked for an accuracy; whether it keeps that, is seen in `test_promise`."""

import json
import math
from dataclasses import replace

import pytest

import pipeline
from pipeline.sweep.plan import Point
from pipeline.sweep.selection import Selection
from pipeline.tradeoff import choose as accuracy_module
from pipeline.tradeoff.choose import at_accuracy, choose_fidelity, stored_selection
from tests.helpers import tiny
from tests.helpers.kept import PAPER, SCENES
from tribo import PRESETS, Fidelity, InputError


def test_it_picks_the_first_that_is_good_enough_and_says_why():
    changed = at_accuracy(PAPER, 0.05)
    selection = changed.selection
    assert changed.fidelity == selection.fidelity == selection.trials[-1].fidelity
    assert all(trial.error > 0.05 for trial in selection.trials[:-1])
    assert selection.error <= 0.05
    assert selection.seconds > 0
    said = str(selection)
    for word in ("accuracy 5 %", f"picked {selection.name}", "errs by", "the probe took"):
        assert word in said
    assert selection.as_dict()["points"][0] == {
        "load": 200.0,
        "velocity": selection.points[0][1],
    }
    assert Selection.from_dict(json.loads(json.dumps(selection.as_dict()))) == selection
    assert changed.preset == (selection.name if selection.name in PRESETS else None)


def test_the_choice_is_the_same_every_time():
    first, second = (choose_fidelity(SCENES["no wear"], 0.03) for _ in range(2))
    assert replace(first, seconds=0.0) == replace(second, seconds=0.0)


def test_what_the_scene_asks_to_see_is_kept():
    sweep = replace(SCENES["no wear"], fidelity=Fidelity(temperature_interval=5))
    assert choose_fidelity(sweep, 0.1).fidelity.temperature_interval == 5


def test_an_accuracy_may_be_asked_for_at_one_point():
    selection = choose_fidelity(SCENES["no wear"], 0.03, points=(Point(300.0, 1.5),))
    assert selection.points == ((300.0, 1.5),)
    assert selection.error <= 0.03


@pytest.mark.parametrize("accuracy", [0.0, 1.0, -0.1, math.nan])
def test_an_accuracy_is_a_share(accuracy):
    with pytest.raises(InputError, match="between 0 and 1"):
        choose_fidelity(PAPER, accuracy)


def test_without_friction_there_is_nothing_to_be_accurate_about():
    without = replace(PAPER, conditions=replace(PAPER.conditions, friction=0.0))
    with pytest.raises(InputError, match="without friction"):
        choose_fidelity(without, 0.02)


def test_a_store_says_why_it_has_its_fidelity_and_goes_on_without_another_probe(
    tmp_path, monkeypatch
):
    out = tmp_path / "out.zarr"
    small = replace(tiny.sweep(), loads=(250.0, 600.0), velocities=(1.0, 1.5))
    begun = at_accuracy(small, 0.1, store=out)  # not there yet
    pipeline.run_sweep(begun, out, workers=1)
    assert stored_selection(out) == begun.selection
    assert pipeline.open_sweep(out).attrs["selection"]["name"] == begun.selection.name

    def refused(*_):
        raise AssertionError("another probe")

    monkeypatch.setattr(accuracy_module, "choose_fidelity", refused)
    grown = replace(small, velocities=(1.0, 1.25, 1.5))
    for accuracy in (0.1, 0.3):
        again = at_accuracy(grown, accuracy, store=out)
        assert (again.fidelity, again.selection) == (begun.fidelity, begun.selection)
    outcome = pipeline.run_sweep(again, out, workers=1)
    assert (outcome.computed, outcome.done) == (2, 6)
    # Without --accuracy, but with the same fidelity, the reasons stay.
    pipeline.run_sweep(replace(again, selection=None), out, workers=1)
    assert stored_selection(out) == begun.selection
    stricter = begun.selection.error / 2
    with pytest.raises(pipeline.StoreMismatchError, match=r"errs by .* another store"):
        at_accuracy(grown, stricter, store=out)
    # What the scene asks to see is its own, and not to be taken from the store.
    more = replace(grown, fidelity=replace(grown.fidelity, temperature_interval=2))
    with pytest.raises(pipeline.StoreMismatchError, match="temperature_interval"):
        pipeline.run_sweep(at_accuracy(more, 0.1, store=out), out, workers=1)


def test_at_rest_there_is_nothing_to_be_accurate_about():
    with pytest.raises(InputError, match="at velocity 0"):
        choose_fidelity(PAPER, 0.02, points=(Point(300.0, 0.0),))
