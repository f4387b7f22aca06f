"""A guard of certified results: what rounding may hide of a residual, and when to give up.

No closed form notices a fault here, since the solver still returns a pressure.
"""

import math

import numpy as np
import pytest

from tribo import Grid
from tribo.contact import ElasticHalfSpace, rounding
from tribo.contact.iteration import Limits, iterate
from tribo.contact.problem import Iterate, Problem, judge
from tribo.contact.rounding import (
    LowestResidual,
    lost_by_transform,
    lost_by_updates,
    restored,
)

GRID = Grid((16, 8), (2e-6, 2e-6))
SOLID = ElasticHalfSpace(GRID, 115e9)
HEIGHTS = np.broadcast_to(GRID.coordinates(0)[:, None] ** 2 / (2 * 2e-3), GRID.shape)
TOTAL = 4e9
PROBLEM = Problem.of(SOLID, HEIGHTS, TOTAL, math.inf)
EPSILON = float(np.finfo(float).eps)


@pytest.fixture(scope="module")
def solved():
    """The solution, its displacement computed."""
    result = iterate(PROBLEM, np.full(GRID.shape, TOTAL / HEIGHTS.size), Limits(1e-10, 1000))
    assert result.converged
    return Iterate(result.pressure, SOLID(result.pressure), 0.0, HEIGHTS, 10.0)


# What may be lost, against numbers worked out by hand.


@pytest.mark.parametrize("updates", [1, 7, 40])
def test_updates_of_a_displacement_cost_less_than_is_allowed_for(solved, updates):
    random = np.random.default_rng(updates)
    displacement, pressure = solved.displacement.copy(), solved.pressure.copy()
    for _ in range(updates):
        step = random.normal(size=GRID.shape) * pressure.max()
        pressure += step
        displacement += SOLID(step)
    largest = rounding.largest(displacement)
    lost = rounding.largest(displacement - SOLID(pressure))
    assert 0 < lost < lost_by_updates(updates, EPSILON, largest)


def test_a_transform_loses_less_than_is_allowed_for():
    pressure = np.random.default_rng(0).uniform(size=GRID.shape)
    displacement = SOLID(pressure)
    # Along y, where the patch repeats, a pressure that is moved moves its displacement.
    moved = np.roll(SOLID(np.roll(pressure, 3, axis=1)), -3, axis=1)
    lost = rounding.largest(moved - displacement)
    assert 0 < lost <= 2 * lost_by_transform(EPSILON, rounding.largest(displacement))


# What is done about it.


def slack_that_just_suffices(iterate, judged):
    largest = rounding.largest(iterate.displacement)
    return lost_by_updates(iterate.updates, EPSILON, largest) / judged.unit


@pytest.mark.parametrize("updates", [1, 6, 30])
def test_an_updated_displacement_is_computed_where_its_loss_exceeds_the_slack(solved, updates):
    updated = solved._replace(updates=updates, displacement=solved.displacement * (1 + 1e-13))
    judged = judge(PROBLEM, updated)
    enough = slack_that_just_suffices(updated, judged)
    assert restored(PROBLEM, updated, judged, 1.001 * enough, exhausted=False) is None
    better = restored(PROBLEM, updated, judged, 0.999 * enough, exhausted=False)
    assert np.array_equal(better.displacement, SOLID(solved.pressure))
    assert better.pressure is solved.pressure
    assert (better.updates, better.convolutions) == (0, solved.convolutions + 1)


def test_a_residual_that_is_no_number_is_computed_again(solved):
    updated = solved._replace(updates=1)
    better = restored(PROBLEM, updated, judge(PROBLEM, updated), math.nan, exhausted=False)
    assert better.updates == 0


def test_a_computed_displacement_is_not_computed_again(solved):
    judged = judge(PROBLEM, solved)
    assert restored(PROBLEM, solved, judged, -1.0, exhausted=False) is None


def test_a_load_that_is_off_is_put_right_while_convolutions_are_left(solved):
    off = solved._replace(pressure=solved.pressure * (1 + 3e-12))
    judged = judge(PROBLEM, off)
    better = restored(PROBLEM, off, judged, 1.0, exhausted=False)
    assert off.load_error(TOTAL) > 1e-12 > better.load_error(TOTAL)
    assert restored(PROBLEM, off, judged, 1.0, exhausted=True) is None


def test_a_far_datum_is_shifted_to_the_contact_but_not_for_ever(solved):
    away = HEIGHTS + 1.0
    problem = Problem.of(SOLID, away, TOTAL, math.inf)
    far = solved._replace(separation=away)
    better = restored(problem, far, judge(problem, far), 1.0, exhausted=False)
    level = judge(PROBLEM, solved).level
    assert better.datum == pytest.approx(1.0 + level, rel=1e-12)
    assert better.separation == pytest.approx(HEIGHTS - level, abs=1e-15)
    assert (better.shifts, better.convolutions) == (1, solved.convolutions)
    often = far._replace(shifts=3)
    assert restored(problem, often, judge(problem, often), 1.0, exhausted=False) is None


# When to give up.


@pytest.mark.parametrize(
    ("waited", "times_rounding", "idle", "stalled"),
    [
        (40, 1.0, 0, False),
        (41, 31.0, 0, True),
        (41, 33.0, 0, False),
        (41, 33.0, 20, False),
        (41, 33.0, 21, True),
        (1000, 33.0, 0, False),
        (1001, 33.0, 0, True),
    ],
)
def test_an_iteration_stalls_sooner_at_rounding_than_above_it(
    solved, waited, times_rounding, idle, stalled
):
    judged = judge(PROBLEM, solved)
    size = rounding.largest(solved.displacement) + abs(judged.level)
    lowest = times_rounding * EPSILON * size / judged.unit
    progress = LowestResidual(lowest, convolutions=solved.convolutions - waited)
    assert progress.has_stalled(PROBLEM, solved, judged, idle) is stalled


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_no_result_violates_more_than_its_residual_says(tolerance):
    random = np.random.default_rng(1)
    heights = HEIGHTS + 1e-9 * random.normal(size=GRID.shape)
    problem = Problem.of(SOLID, heights, TOTAL, math.inf)
    result = iterate(problem, random.uniform(size=GRID.shape), Limits(tolerance, 1000))
    gap = SOLID(result.pressure) + heights - result.approach
    wrong = np.where(result.pressure > 0, np.abs(gap), np.maximum(-gap, 0.0)).max()
    unit = SOLID.self_influence * result.pressure.max()
    assert wrong / unit <= result.residual <= tolerance
