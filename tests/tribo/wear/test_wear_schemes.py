"""Schemes by which wear advances over a step (tribo/wear/archard.py)."""

import functools
import itertools
from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL, last, small_scene
from tribo.simulation import advance, start

LOAD, VELOCITY = 750.0, 1.25  # the paper's severest point


def plane(**fidelity):
    """Scene with the paper's wear under a smooth pin, whose elements are rows."""
    choices = {"pixels_per_element": 1, "contact_tolerance": 1e-9} | fidelity
    return tribo.Scene(
        pin=tribo.Cylinder(2e-3, 3.4e-3, STEEL),
        disk=STEEL,
        pixels=tribo.Grid((120, 1), (3.264e-6, 456e-6)),
        loading=tribo.Ramp(150.0, 750.0),
        wear=tribo.Wear(1.2e-15, "swept"),
        fidelity=tribo.Fidelity(**choices),
    )


@functools.cache
def end(scene):
    state = start(scene)
    for load_step in scene.load_steps(LOAD):
        state = advance(scene, state, load_step, VELOCITY)
    return state


# The load falls in steps to 0 and below, and rises and falls between two steps of the simulation.
RECORD = tribo.MeasuredLoad(
    np.array([0.0, 0.7, 1.0, 1.2, 2.0, 2.6, 2.65, 2.7, 3.5, 4.0]),
    np.array([-5.0, 300.0, 20.0, 400.0, 0.0, -30.0, 500.0, 0.0, 0.0, 750.0]),
)
LOADINGS = {
    "ramp": tribo.Ramp(150.0, 750.0),
    "ramp and hold": tribo.Ramp(150.0, 750.0, hold=3.0),
    "record": RECORD,
    "record that rises at once": tribo.MeasuredLoad(
        np.array([0.0, 1e-9, 2.0]), np.array([9.0, 400.0, 750.0])
    ),
}


def work_of(loading):
    """Integral of the positive load over time, from triangles and trapezia."""
    if isinstance(loading, tribo.Ramp):
        return LOAD * (LOAD / loading.rate / 2 + loading.hold)
    total = 0.0
    for (t0, t1), (F0, F1) in zip(
        itertools.pairwise(loading.times), itertools.pairwise(loading.loads), strict=True
    ):
        crosses = F0 * F1 < 0
        above = max(F0, F1) / abs(F1 - F0) if crosses else 1.0  # share of time with load above 0
        total += above * (t1 - t0) * (max(F0, 0.0) + max(F1, 0.0)) / 2
    return total


@pytest.mark.parametrize("increments", [1, 10])
@pytest.mark.parametrize("name", LOADINGS)
def test_the_worn_volume_is_that_of_the_load_on_its_way(name, increments):
    scene = plane(increments=increments, contact_tolerance=1e-3)
    scene = replace(scene, loading=LOADINGS[name], pixels=tribo.Grid((48, 1), (8e-6, 456e-6)))
    state = end(scene)
    expected = 1.2e-15 * VELOCITY * work_of(scene.loading)
    assert tribo.measures(scene, state)["wear_volume"] == pytest.approx(expected, rel=1e-10)


def test_worn_depth_converges_at_second_order():
    """Depth has a kink in time where the edge of the contact passes, and a lower order.

    So the order is tested in the middle of the contact, and on average.
    """
    exact = end(plane(increments=160)).wear_depth
    middle = slice(48, 72)
    counts = [5, 10, 20, 40]
    depths = [end(plane(increments=n)).wear_depth for n in counts]
    for errors in (
        [np.abs(depth - exact)[middle].max() for depth in depths],
        [np.abs(depth - exact).mean() for depth in depths],
    ):
        assert 1.8 < -np.polyfit(np.log(counts), np.log(errors), 1)[0] < 2.2


def test_contacts_under_local_wear_are_solved_to_three_percent_at_least():
    def worn(pattern, tolerance):
        scene = small_scene(pattern, contact_tolerance=tolerance)
        return tribo.measures(scene, last(scene, LOAD, VELOCITY))["mean_pressure"]

    assert worn("local", 0.5) == worn("local", 0.03)
    assert worn("local", 0.03) != worn("local", 0.003)
    assert worn("swept", 0.5) != worn("swept", 0.03)
