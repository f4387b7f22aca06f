"""The search for the boundary, on rises that are known in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pipeline.analysis.curve import Curve
from pipeline.analysis.field import along_friction
from pipeline.run.boundary_search import BoundarySearch
from pipeline.sweep.model import Point
from tests.helpers import synthetic
from tests.helpers.answers import crossings
from tribo import Corrections, Friction

LOADS = tuple(float(load) for load in range(200, 751, 50))
LIMIT = 1200.0


def bent(load, velocity, bend=0.1):
    """Rise [K] similar to the shipped scene's, with an exponent that grows from 0.5 to 0.65."""
    x = math.log(velocity / 1.16)
    return LIMIT * (load / 750) ** 0.45 * math.exp(0.5 * x + bend / 2 * x**2)


def searched(rise, tolerance=0.01, loads=LOADS, lowest=0.5, highest=5.0, rises=None):
    """Rises of all points that a search asks for, and its points by round."""
    search = BoundarySearch(loads, lowest, highest, LIMIT, tolerance)
    rises = dict(rises or {})
    rounds = []
    while asked := search.wanted(rises):
        assert not set(asked) & set(rises)
        rises |= {point: rise(*point[:2]) for point in asked}
        rounds.append(asked)
        assert len(rounds) < 30
    return rises, rounds


def boundary_of(rises, load):
    row = sorted((point.velocity, rise) for point, rise in rises.items() if point.load == load)
    return next(iter(crossings(Curve(*np.array(row).T), LIMIT)), math.nan)


@pytest.mark.parametrize(("tolerance", "bend"), [(0.05, -0.05), (0.01, 0.4), (0.0005, 0.1)])
def test_the_boundary_is_found_within_the_tolerance_at_every_load(tolerance, bend):
    rises, _ = searched(lambda load, v: bent(load, v, bend), tolerance)
    for load in LOADS:
        fine = np.geomspace(0.5, 5, 2000)
        (true,) = crossings(Curve(fine, np.array([bent(load, v, bend) for v in fine])), LIMIT)
        assert boundary_of(rises, load) == pytest.approx(true, rel=tolerance)


def test_where_rises_are_powers_of_the_velocity_two_points_a_load_are_enough():
    rises, _ = searched(lambda load, v: 50 * load**0.45 * v**0.55, loads=(200.0, 750.0))
    assert len(rises) == 4


@pytest.mark.parametrize(("factor", "end"), [(0.1, 5.0), (10.0, 0.5)])
def test_without_a_crossing_it_ends_at_the_end_of_the_range(factor, end):
    rises, _ = searched(lambda load, v: factor * bent(load, v))
    for load in LOADS:
        assert Point(load, end) in rises
    assert len(rises) < 5 * len(LOADS)


def test_what_has_failed_is_not_asked_for_again():
    search = BoundarySearch(LOADS, 0.5, 5.0, LIMIT, 0.01)
    failed, rises = set(), {}
    while asked := search.wanted(rises, failed):
        assert not failed & set(asked)
        bad = {point for point in asked if point.load == 400.0}
        failed |= bad
        rises |= {point: bent(*point[:2]) for point in asked if point not in bad}
        assert len(rises) < 100
    assert 0 < len(failed) < 10
    assert all(boundary_of(rises, load) > 0 for load in LOADS if load != 400.0)


def test_friction_that_bends_between_two_velocities_hides_no_boundary():
    """Friction falls by a quarter from 1.6 to 1.8 m/s; the rise passes the limit three times."""
    falling = Corrections(
        friction=Friction(by_velocity=((1.0, 1.3), (1.6, 1.3), (1.8, 1.0), (4.0, 0.95)))
    )
    loads = (200.0, 400.0, 750.0)
    sweep = synthetic.scene(
        conditions=replace(synthetic.conditions(), corrections=falling),
        loads=loads,
        velocities=(0.5, 5.0),
    )

    def rise(load, velocity):
        return bent(load, velocity) * falling.friction.at(np.asarray(velocity)).item()

    search, rises = BoundarySearch.of(sweep, 0.01), {}
    assert search.limit == LIMIT
    while asked := search.wanted(rises):
        rises |= {point: rise(*point[:2]) for point in asked}
    fine = np.geomspace(0.5, 5.0, 2000)
    factors = falling.friction.at(fine)
    for load in loads:
        rising = factors * [bent(load, velocity) for velocity in fine]
        row = np.array(sorted((at.velocity, rise) for at, rise in rises.items() if at.load == load))
        found = crossings(Curve(*along_friction(*row.T, falling.friction.at)), LIMIT)
        assert found == pytest.approx(crossings(Curve(fine, rising), LIMIT), rel=0.01)


def test_bands_are_found_whose_ends_no_first_crossing_tells():
    """Wear is severe, mild, severe and mild again; at one load severe only inside the range."""
    bands = Friction(by_velocity=((0.8, 2.0), (1.6, 0.8), (3.0, 1.2), (4.5, 0.4)))
    sweep = synthetic.scene(
        conditions=replace(synthetic.conditions(), corrections=Corrections(friction=bands)),
        loads=(200.0, 400.0, 750.0),
        velocities=(0.8, 4.5),
    )
    search, rises = BoundarySearch.of(sweep, 0.01), {}
    while asked := search.wanted(rises):
        rises |= {p: bent(*p[:2]) * float(bands.at(np.array(p.velocity))) for p in asked}
    assert len(rises) < 40
    fine = np.geomspace(0.8, 4.5, 4000)
    turns = {}
    for load in sweep.plane.loads:
        rising = bands.at(fine) * [bent(load, velocity) for velocity in fine]
        turns[load] = crossings(Curve(fine, rising), LIMIT)
        row = np.array(sorted((at.velocity, rise) for at, rise in rises.items() if at.load == load))
        found = crossings(Curve(*along_friction(*row.T, bands.at)), LIMIT)
        assert found == pytest.approx(turns[load], rel=0.01)
    assert max(map(len, turns.values())) > 1
