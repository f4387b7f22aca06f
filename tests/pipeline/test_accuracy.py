"""The promise of an accuracy, on scenes that we keep."""

import functools
import math
from dataclasses import replace

import pytest

from pipeline.accuracy import at_accuracy, choose_fidelity
from pipeline.plan import Point
from pipeline.probe import fitted, near_the_boundary, probe
from tests.pipeline.kept import PAPER, SCENES
from tribo import PRESETS, Fidelity, InputError


@functools.cache
def truth(name):
    """The reference at every load of a scene, and where that is."""
    sweep = SCENES[name]
    points, exponents = near_the_boundary(sweep, sweep.loads)
    return points, exponents, probe(sweep, fitted(sweep, PRESETS["reference"]), points)


@functools.cache
def true_error(name, fidelity):
    points, exponents, reference = truth(name)
    found = probe(SCENES[name], fidelity, points)
    return max(
        abs(math.log(one.rise / true.rise)) / exponent
        for one, true, exponent in zip(found.readings, reference.readings, exponents, strict=True)
    )


@pytest.mark.parametrize("name", SCENES)
def test_the_true_error_is_within_what_was_asked_for(name):
    saved = []
    for accuracy in (0.05, 0.02) if name in ("finer pixels", "low loads") else (0.02,):
        selection = choose_fidelity(SCENES[name], accuracy)
        assert true_error(name, selection.fidelity) <= selection.error + 1e-9 <= accuracy + 1e-9
        saved.append(selection.saving)
    assert saved == sorted(saved, reverse=True)  # what may err more costs no more


def test_it_picks_the_first_that_is_good_enough_and_says_why():
    changed, selection = at_accuracy(PAPER, 0.05)
    assert changed.fidelity == selection.fidelity == selection.trials[-1].fidelity
    assert all(trial.error > 0.05 for trial in selection.trials[:-1])
    assert selection.error <= 0.05
    assert selection.seconds > 0
    said = str(selection)
    for word in ("accuracy 5 %", f"picked {selection.name}", "errs by", "the probe took"):
        assert word in said
    assert selection.as_dict()["points"][0] == {
        "load": 200.0,
        "velocity": selection.points[0].velocity,
    }
    assert changed.preset == (selection.name if selection.name in PRESETS else None)


def test_the_choice_is_the_same_every_time():
    first, second = (choose_fidelity(SCENES["no wear"], 0.03) for _ in range(2))
    assert replace(first, seconds=0.0) == replace(second, seconds=0.0)


def test_what_the_scene_asks_to_see_is_kept():
    sweep = replace(SCENES["no wear"], fidelity=Fidelity(temperature_interval=5))
    assert choose_fidelity(sweep, 0.1).fidelity.temperature_interval == 5


def test_an_accuracy_may_be_asked_for_at_one_point():
    selection = choose_fidelity(SCENES["no wear"], 0.03, points=(Point(300.0, 1.5),))
    assert selection.points == (Point(300.0, 1.5),)
    assert selection.error <= 0.03


@pytest.mark.parametrize("accuracy", [0.0, 1.0, -0.1, math.nan])
def test_an_accuracy_is_a_share(accuracy):
    with pytest.raises(InputError, match="between 0 and 1"):
        choose_fidelity(PAPER, accuracy)


def test_without_friction_there_is_nothing_to_be_accurate_about():
    without = replace(PAPER, conditions=replace(PAPER.conditions, friction=0.0))
    with pytest.raises(InputError, match="without friction"):
        choose_fidelity(without, 0.02)
