"""Steps of the search for the boundary: what is known, how it bends, and which points come next.

From 0.5 to 8 m/s the axis of the search has the nodes 0.5 · 2^(k/2): 0.5, 0.7071, 1, 1.4142 … 8.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from pipeline.run.boundary_search import BoundarySearch, boundary_search, results_of
from pipeline.store.create import writing
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord, points, run_point
from tests.helpers import tiny
from tests.helpers.entries import changed, rows
from tests.helpers.stores import opened
from tribo import Corrections, Friction


def search(**values):
    usual = {"loads": (200.0, 400.0, 750.0), "lowest": 0.5, "highest": 8.0, "limit": 1200.0}
    return BoundarySearch(**usual | {"tolerance": 0.01} | values)


def test_known_are_the_rises_above_0_in_the_range_of_a_load_without_their_friction():
    at_200 = {0.4: 1.0, 8.0: 1500.0, 0.5: 0.5, 1.0: 0.0, 9.0: 2000.0}
    rises = {Point(200.0, velocity): rise for velocity, rise in at_200.items()}
    rises[Point(400.0, 1.0)] = 900.0
    assert search()._row(rises, 200.0) == [(0.5, 0.5), (8.0, 1500.0)]
    double = search(factor=lambda velocities: np.full_like(velocities, 2.0))
    assert double._row(rises, 200.0) == [(0.5, 0.25), (8.0, 750.0)]


def bend(velocities, rises):
    """|d²ln r/d(ln V)²|/(d ln r/d ln V) of the parabola through three points."""
    x, y = np.log(velocities), np.log(rises)
    return 2 * abs(np.polyfit(x, y, 2)[0]) / ((y[2] - y[0]) / (x[2] - x[0]))


SPEEDS = np.array([3.0, 4.0, 5.0, 6.3])


@pytest.mark.parametrize(
    ("rises", "of"),
    [
        ([900.0, 1150.0, 1300.0, 1420.0], [(0, 1, 2), (1, 2, 3)]),  # crossing in the middle
        ([900.0, 1000.0, 1150.0, 1300.0], [(1, 2, 3)]),
        ([1100.0, 1300.0, 1420.0, 1500.0], [(0, 1, 2)]),
    ],
)
def test_a_bend_is_that_of_each_three_velocities_about_the_crossing(rises, of):
    row = [*zip(SPEEDS.tolist(), rises, strict=True)]
    rises = np.array(rises)
    bends = [bend(SPEEDS[list(three)], rises[list(three)]) for three in of]
    assert len({round(one, 3) for one in bends}) == len(of)
    found = search()._curvature({200.0: row})
    assert found == pytest.approx(max(0.2, 1.5 * max(bends)), rel=1e-9)
    straight = [(velocity, 400 * velocity**0.7) for velocity in SPEEDS.tolist()]
    assert search()._curvature({200.0: row, 400.0: straight}) == found
    assert search()._curvature({200.0: straight, 400.0: row}) == found


def test_two_velocities_or_a_rise_on_one_side_tell_no_bend_and_a_sharp_one_is_limited():
    assert search()._curvature({200.0: [(1.0, 900.0), (1.3, 1500.0)]}) == 0.5
    assert search()._curvature({200.0: [(1.0, 500.0), (1.3, 600.0), (1.5, 900.0)]}) == 0.5
    assert search()._curvature({200.0: [(1.0, 1300.0), (1.3, 1400.0), (1.5, 1900.0)]}) == 0.5
    falling = [(1.0, 1199.0), (1.3, 1201.0), (1.5, 900.0)]
    assert search()._curvature({200.0: falling}) == 100.0
    level = [(1.0, 1199.0), (1.3, 1201.0), (1.5, 1199.0)]
    assert search()._curvature({200.0: level}) == 100.0


@pytest.mark.parametrize(
    ("row", "guess", "curvature", "asked"),
    [
        ({}, 1.2, 0.5, [1.0, 1.41421]),
        ({}, 1.02, 0.5, [0.707107, 1.0, 1.41421]),  # near a node: beyond it, too
        ({}, 1.39, 0.5, [1.0, 1.41421, 2.0]),
        ({}, 0.3, 0.5, [0.5, 0.707107]),  # at an end, and so on a node
        ({1.0: 900.0}, 20.0, 0.5, [5.65685, 8.0]),
        ({1.0: 1100.0}, 1.01, 0.5, [1.41421]),
        ({2.0: 1300.0}, 1.99, 0.5, [1.41421]),
        ({1.0: 900.0, 2.0: 1300.0}, 1.45, 0.5, [1.41421]),
        ({1.0: 900.0, 2.0: 1300.0}, 0.6, 0.5, [1.41421]),  # no guess is below the bracket
        ({1.0: 900.0, 1.41421: 1300.0}, 1.2, 0.5, []),  # 0.5 · 0.347² / 8 is below 1 %
        ({1.0: 900.0, 1.41421: 1300.0}, 1.2, 1.0, [1.18921]),  # on an axis twice as fine
        ({1.0: 900.0, 1.41421: 1300.0}, 1.2, 0.7, [1.18921]),  # 0.7 · 0.347² / 8 is 1.05 %
        ({1.1: 900.0, 1.41421: 1300.0}, 1.2, 2.0, [1.18921]),
        ({1.0: 900.0, 1.18921: 1300.0}, 1.1, 4.0, [1.09051]),  # four times as fine
        ({0.5: 1300.0}, 0.5, 0.5, []),  # severe throughout
        ({8.0: 900.0}, 8.0, 0.5, []),  # mild throughout
        ({0.5: 900.0, 8.0: 1300.0}, 2.1, 0.5, [2.0, 2.82843]),
    ],
)
def test_asked_are_nodes_about_the_guess_until_a_straight_line_is_good_enough(
    row, guess, curvature, asked
):
    found = search()._next([*row.items()], math.log(guess), curvature)
    assert sorted(found) == pytest.approx(asked, rel=1e-9)


def test_scenes_that_share_contacts_ask_at_the_same_product_of_wear_rate_and_velocity():
    shared = search(scale=2.0)
    assert sorted(shared._next([], math.log(1.2), 0.5)) == [1.0, 1.414215]
    for load in (200.0, 400.0, 750.0):
        first = search()._first_node(load)
        assert shared._first_node(load) == pytest.approx(first, rel=1e-5)  # six figures
    # A node beside an end, as 0.707107/√2 and 11.3137/√2, is the end.
    beside = search(scale=2**0.5)
    assert [beside._node(number, 0) for number in (1, 9)] == [0.5, 8.0]
    assert search(scale=2**1.5)._node(3, 0) == 0.5


@pytest.mark.parametrize(
    ("factor", "turns"),
    [
        (lambda v: np.ones_like(v), {2.0: 1200.0}),  # the heat is 600 K · V
        (lambda v: 8 / v**2, {4.0: 2400.0}),  # severe below
        (lambda v: np.where(v < 1.0, 8.0, np.where(v < 3.0, 0.2, 1.0)),
         {0.5 * 16 ** (k / 511): heat for k, heat in ((127, 150.0), (330, 6000.0))}),
    ],
)  # fmt: skip
def test_turns_are_where_heat_and_friction_pass_the_limit_and_there_is_no_other(factor, turns):
    found = search(factor=factor)._turns([(1.0, 600.0), (4.0, 2400.0)])
    assert len(found) == len(turns)
    step = 1.01 * math.log(16) / 511
    for (turn, heat), (velocity, expected) in zip(found.items(), turns.items(), strict=True):
        assert turn == pytest.approx(math.log(velocity), abs=step)
        assert heat == pytest.approx(expected, rel=2 * step)


def test_a_load_without_a_point_is_asked_in_the_middle_and_one_that_never_turns_at_its_ends():
    bent = search(loads=(200.0, 400.0), factor=lambda v: np.ones_like(v))
    rises = {Point(200.0, 1.0): 60.0, Point(200.0, 2.0): 120.0}
    first = Point(400.0, bent._first_node(400.0))
    assert set(bent.wanted(rises)) == {Point(200.0, 0.5), Point(200.0, 8.0), first}
    ends = [Point(400.0, 0.5), Point(400.0, 8.0)]
    assert bent.wanted(rises, [first, Point(200.0, 0.5), Point(200.0, 8.0)]) == tuple(ends)


# On a store

SWEEP = tiny.full()


def test_a_search_begins_with_the_rises_of_a_store(alone):
    rises, failed = results_of(opened(alone), SWEEP)
    assert failed == set()
    assert rises.keys() == set(points(SWEEP))
    for point in (Point(150.0, 0.5), Point(600.0, 1.5)):
        decisive = run_point(SWEEP, *point[:2]).verdict(SWEEP.conditions).decisive_temperature
        assert rises[point] == pytest.approx((decisive - 298.15) / 0.1, rel=1e-9)
    fewer, _ = results_of(opened(alone), changed(SWEEP, loads=(150.0, 250.0)))
    assert fewer == {point: rise for point, rise in rises.items() if point.load < 600.0}


def test_points_that_failed_are_asked_for_again_if_the_user_says_so(path):
    further = boundary_search(SWEEP, 0.01)
    first = further(None).chosen
    assert sorted(point.load for point in first) == [150.0, 250.0, 600.0]
    with writing(path, changed(SWEEP, chosen=first)) as store:
        store.commit(PointRecord(point, None, "out of memory") for point in first)
        assert results_of(store, SWEEP) == ({}, first)
        assert further(store).chosen == first
        again = further(store, retry_failed=True).chosen
    assert again == first


def test_a_failed_point_leaves_its_load_the_ends_of_the_range_unless_it_is_tried_again(path):
    """Where friction by velocity may turn wear several times."""
    curve = Corrections(friction=Friction(by_velocity=((0.5, 1.2), (1.5, 0.8))))
    sweep = changed(SWEEP, conditions=replace(SWEEP.conditions, corrections=curve))
    further = boundary_search(sweep, 0.01)
    first = further(None).chosen
    assert len(first) == 3
    failed = min(first)
    with writing(path, changed(sweep, chosen=first)) as store:
        store.commit([PointRecord(failed, None, "out of memory")])
        ends = {Point(failed.load, velocity) for velocity in (0.5, 1.5)}
        assert further(store).chosen == first | ends
        assert further(store, retry_failed=True).chosen == first


def test_scenes_of_the_same_points_are_asked_for_them_together():
    """Friction acts after the simulation; another radius is another simulation."""
    oils = {"dry": {}, "oiled": {"conditions": replace(SWEEP.conditions, friction=0.05)}}
    thick = {"thick": {"pin": replace(SWEEP.scene.pin, radius=12e-3)}}
    several = changed(SWEEP, variants=rows("oil", oils | thick))
    chosen = boundary_search(several, 0.01)(None).chosen
    asked = {
        oil: {point[:2] for point in chosen if dict(point.variant)["oil"] == oil}
        for oil in ("dry", "oiled", "thick")
    }
    alone = {point[:2] for point in boundary_search(SWEEP, 0.01)(None).chosen}
    assert asked == dict.fromkeys(asked, alone)
