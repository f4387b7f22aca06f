"""What would count severe wear mild, or understate an error."""

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import boundary, margin
from pipeline.analysis.laboratory import compared
from pipeline.analysis.margin import NOT_DECIDED
from pipeline.sweep.measurement import Measurement
from tests.helpers import synthetic
from tribo import Corrections, Friction, WarningKind

FALLING = Corrections(friction=Friction(by_velocity=((0.5, 1.0), (4.0, 0.8))))
TESTS = (Measurement(600.0, 1.5), Measurement(400.0, 1.2, outcome="severe"))


def critical(load):
    return synthetic.critical_velocity(load, synthetic.limit())


@pytest.mark.parametrize("corrections", [None, FALLING])
def test_a_velocity_of_0_in_a_sweep_changes_no_answer_from_the_lowest_moving_one_on(corrections):
    law = replace(synthetic.conditions(), corrections=corrections)
    moving, rest = (
        synthetic.sweep(velocities=v, measured=TESTS, conditions=law, preset="draft")
        for v in ((1.0, 1.6, 2.5), (0.0, 1.0, 1.6, 2.5))
    )
    for load in (200.0, 310.0, 600.0):
        for velocity in (1.0, 1.3, 2.5):
            one, other = (asdict(margin(ds, load, velocity)) for ds in (moving, rest))
            np.testing.assert_equal(one, other)
    both = [boundary(ds).drop_attrs() for ds in (moving, rest)]
    xr.testing.assert_identical(*both)


def test_an_error_that_one_surface_does_not_know_decides_nothing():
    ds = synthetic.sweep(measured=(), preset="draft")
    unstable = ds.copy(deep=True)
    unstable["warning_flags"][:] = int(WarningKind.UNSTABLE_WEAR)
    assert margin(ds, 400.0, 0.75).verdict == "mild"
    for surfaces in ([ds, unstable], [unstable, ds]):
        both = xr.concat(surfaces, xr.Variable("realization", range(2)), combine_attrs="override")
        found = margin(both, 400.0, 0.75)
        assert (found.temperature_error, found.verdict) == (None, NOT_DECIDED)


PLACES = {
    "load": np.repeat([200.0, 380.0, 700.0], 9),
    "velocity": np.tile(np.geomspace(0.6, 3.9, 9), 3),
}


def drawn_test(rng, outcome):
    """A random test with its own conditions, and ln(its velocity/computed velocity)."""
    load, friction = rng.uniform(200.0, 750.0), rng.choice([None, 0.07, 0.12])
    bulk = rng.choice([None, 320.0])
    limit = synthetic.limit(friction or 0.1, bulk or 298.15)
    velocity = rng.uniform(0.5, 4.0)
    distance = math.log(velocity / synthetic.critical_velocity(load, limit))
    own = {"bulk_temperature": bulk, "outcome": outcome}
    return Measurement(load, velocity, friction, **own), distance


def drawn_outcome(rng, is_right):
    """A random test whose outcome agrees with the model if `is_right`, else contradicts it."""
    while True:
        outcome = rng.choice(["mild", "severe"])
        held, distance = drawn_test(rng, outcome)
        if ((distance > 0) == (outcome == "severe")) is is_right and abs(distance) > 1e-2:
            return held


def chances(tests):
    ds = synthetic.sweep(
        loads=[200.0, 400.0, 750.0], velocities=[0.5, 1.0, 2.0, 4.0], measured=tuple(tests)
    )
    return margin(ds, PLACES)["probability"].values


@pytest.mark.parametrize("seed", range(8))
def test_no_wrong_outcome_narrows_the_error_or_makes_the_other_outcome_likelier(seed):
    rng = np.random.default_rng(seed)
    held = [drawn_test(rng, rng.choice([None, "mild", "severe"]))[0] for _ in range(seed % 8)]
    wrong, right = (drawn_outcome(rng, is_right) for is_right in (False, True))
    before, after = chances(held), chances([*held, wrong])
    towards = 1 if wrong.outcome == "severe" else -1
    assert (towards * (after - before)).min() > -1e-12  # rounding
    np.testing.assert_array_equal(chances([*held, right]), before)  # agreement changes nothing


def test_a_test_within_the_numerical_error_neither_agrees_nor_contradicts():
    load = 400.0
    tests = [
        Measurement(load, share * critical(load), outcome=outcome)
        for share in (0.5, 0.98, 1.02, 1.5)
        for outcome in ("mild", "severe")
    ]
    found = compared(pipeline.results(synthetic.sweep(measured=tuple(tests), preset="draft")))
    assert [*found["agrees"]] == [
        "yes", "no", *[NOT_DECIDED] * 4, "no", "yes"
    ]  # fmt: skip
    assert np.isfinite(found["decisive temperature [°C]"]).all()
