"""Friction that depends on the velocity, between the velocities of a sweep."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.answers.scene_words import verdict_conditions
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
from tests.helpers.entries import bare_test
from tests.helpers.sweeps import with_fields

FALLING = tribo.Corrections(
    friction=tribo.Friction(by_velocity=((0.5, 1.6), (2.0, 0.9), (6.0, 0.55)))
)
BACK = tribo.Corrections(friction=tribo.Friction(by_velocity=((0.5, 4.0), (2.0, 0.9), (6.0, 0.2))))


def swept(corrections):
    conditions = replace(synthetic.conditions(), corrections=corrections)
    return synthetic.sweep(velocities=[0.5, 2.0, 6.0], tests=(), conditions=conditions)


def temperature(corrections, load, velocity):
    factor = corrections.friction.at(np.asarray(velocity))
    return 298.15 + 0.1 * factor * synthetic.rise(load, velocity, 0.9)


def test_friction_is_that_of_the_place_and_not_interpolated():
    ds = swept(FALLING)
    for load, velocity in ((600.0, 1.0), (625.0, 1.0), (300.0, 3.5)):
        margin = asked(ds, load, velocity)
        expected = temperature(FALLING, load, velocity)
        assert margin.governing_temperature == pytest.approx(expected, abs=1e-6)


def test_a_test_is_compared_at_the_friction_that_it_measured():
    tests = [
        bare_test(600.0, 4.0, 0.1),
        bare_test(600.0, 4.0),
        bare_test(500.0, 2.0, 0.11),
        bare_test(600.0, 1.0, 0.1, outcome="mild"),
    ]
    conditions = replace(synthetic.conditions(), corrections=FALLING)

    def rise(load, velocity, quantile=1.0):
        return synthetic.rise(load, velocity, quantile)

    ds = synthetic.sweep(tests=tests, conditions=conditions)
    temperatures = pipeline.compare_tests(ds)["governing_temperature"].values
    for test, hot in zip(tests, temperatures, strict=True):
        friction = test.friction or 0.1 * float(FALLING.friction.at(test.velocity))
        warm = 298.15 + friction * float(rise(test.normal_load, test.velocity, 0.9))
        assert hot == pytest.approx(warm, rel=2e-3)


def test_wear_that_is_mild_again_at_a_higher_velocity_turns_at_all_places_of_the_closed_form():
    ds = with_fields(swept(BACK), model_bias=0.0, model_scatter=0.001, preset="reference")
    crossings = pipeline.boundary(ds)
    assert (crossings["outcome_along_velocity"] == 5).any()
    fine = np.geomspace(0.5, 6.0, 20001)
    for load in (200.0, 250.0, 600.0):
        severe = temperature(BACK, load, fine) > 418.15
        turns = fine[1:][severe[1:] != severe[:-1]]
        line = crossings.sel(load=load)
        assert np.isnan(line["critical_velocity"].item()) == severe[0]
        assert line["crossings_along_velocity"].dropna("crossing").values == pytest.approx(
            turns, rel=1e-3
        )
        for velocity in (0.51, 1.0, 2.5, 4.0, 5.9):
            margin = asked(ds, load, velocity)
            first = np.nan if severe[0] else turns[0]
            assert margin.critical_velocity == pytest.approx(first, rel=1e-3, nan_ok=True)
            if np.abs(np.log(turns / velocity)).min() > 0.1:
                is_severe = temperature(BACK, load, velocity) > 418.15
                assert margin.verdict == ("severe" if is_severe else "mild")


def test_a_coefficient_in_the_scene_and_one_given_afterwards_are_told_apart():
    table = [{"velocity": "1 m/s", "coefficient": 0.12}, {"velocity": "4 m/s", "coefficient": 0.06}]
    entries = {"friction.by_velocity": table}
    scaled = pipeline.load_scene("first_try", overrides=entries).conditions
    scaled = replace(scaled, friction=0.12)
    sweep = pipeline.load_scene("first_try", overrides=entries | {"friction.coefficient": 0.12})
    assert scaled.friction_at(4.0) == pytest.approx(0.072)
    assert sweep.conditions.friction_at(4.0) == pytest.approx(0.06)
    for conditions, factors in ((scaled, "0.6 to 1.2"), (sweep.conditions, "0.5 to 1")):
        statement = f"friction by velocity, measured, {factors} times the coefficient"
        assert verdict_conditions(conditions).endswith(statement)
