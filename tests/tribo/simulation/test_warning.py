"""Warnings that a point carries (tribo/simulation/warning.py)."""

from collections import deque
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, small_scene
from tribo import Ball, Grid, Ramp, WarningKind, Wear, simulate, start, warnings
from tribo.simulation.warning import ordered_nodes

BALL = Ball(8e-3, STEEL)


def last(states):
    return deque(states, maxlen=1).pop()


def test_contact_at_the_window_s_edge_warns():
    scene = replace(small_scene(), pixels=Grid((12, 16), (8e-6, 8e-6)))
    assert "x edge" in warnings(scene, last(simulate(scene, 750.0, 1.25)))[0].text
    assert warnings(small_scene(), last(simulate(small_scene(), 400.0, 1.25))) == []


def test_kinds_keep_the_bits_that_stores_have():
    assert {kind.label: kind.value for kind in WarningKind} == {
        "unstable wear": 1,
        "contact at edge": 2,
        "few nodes": 4,
        "few steps": 8,
        "present heat": 16,
    }


def touching(scene, places):
    """A state of a scene that touches at some places, without a temperature."""
    state = start(scene)
    pressure = np.zeros_like(state.pressure)
    pressure[places] = 1e9
    return replace(state, pressure=pressure, normal_load=100.0, time=1.0, index=5)


@pytest.mark.parametrize(
    ("place", "named"),
    [
        ((0, 5), "x edge"),
        ((-1, 5), "x edge"),
        ((5, 0), "y edge"),
        ((5, -1), "y edge"),
        ((0, 0), "x edge and y edge"),
        ((1, 1), None),
        ((-2, -2), None),
    ],
)
def test_each_free_edge_is_looked_at(place, named):
    scene = replace(small_scene(periodic=(False, False)), pin=BALL)
    told = [each for each in warnings(scene, touching(scene, place)) if "edge" in each.text]
    assert len(told) == bool(named)
    assert not named or f"the window's {named} at 100 N" in told[0].text


def test_an_edge_beyond_which_the_patch_goes_on_is_none():
    scene = small_scene()
    assert warnings(scene, touching(scene, (5, 0))) == []


@pytest.mark.parametrize(("nodes", "told"), [(0, False), (1, True), (399, True), (400, False)])
def test_from_400_elements_on_there_are_enough(nodes, told):
    scene = replace(small_scene(pixels_per_element=2), pixels=Grid((96, 64), (4e-6, 4e-6)))
    state = touching(scene, np.unravel_index(np.arange(nodes) + 48, scene.grid.shape))
    assert ordered_nodes(scene, state) == nodes
    texts = [warning.text for warning in warnings(scene, state)]
    assert len(texts) == told
    assert not told or f"only {nodes} elements" in texts[0]


def test_in_a_plane_elements_count_as_many_times():
    scene = small_scene(roughness=False)
    assert scene.is_plane
    assert ordered_nodes(scene, touching(scene, np.s_[3:10])) == 49


@pytest.mark.parametrize(
    ("wear", "depth", "rows", "counted"),
    [
        (Wear(1e-13), 10.1, 40, 400),  # squared elements twice as long and wide as these
        (Wear(1e-13), 10.1, 39, 361),
        (Wear(1e-13), 9.9, 39, 39 * 32),
        (Wear(1e-13), 10.1, 3, 1),
        (None, 10.1, 39, 39 * 32),
    ],
)
def test_rows_count_where_wear_has_fitted_the_pin(wear, depth, rows, counted):
    scene = small_scene(pixels_per_element=2)
    scene = replace(scene, wear=wear, pixels=Grid((96, 64), (4e-6, 4e-6)))
    heights = scene.separation(scene.heights()) - scene.pin.profile(scene.grid)
    state = touching(scene, np.s_[4 : 4 + rows])
    worn = np.zeros_like(state.pressure)
    worn[5:] = depth * heights.std()
    assert ordered_nodes(scene, replace(state, wear_depth=worn)) == counted
    # A pin that rolls loses as much all around, which leaves its shape.
    assert ordered_nodes(scene, replace(state, wear_depth=worn + worn.max())) == counted
    even = np.full_like(worn, worn.max())
    assert ordered_nodes(scene, replace(state, wear_depth=even)) == rows * 32
    texts = [each.text for each in warnings(scene, replace(state, wear_depth=worn))]
    assert len(texts) == (counted < 400)
    assert not texts or f"only {rows} rows of elements touch a pin that wear" in texts[0]


@pytest.mark.parametrize(
    ("scheme", "steps", "told"),
    [
        ("implicit", 0, None),
        ("implicit", 1, "reached in a single step"),
        ("implicit", 2, "reached in 2 steps"),
        ("implicit", 3, None),
        ("sdirk2", 1, "reached in a single step"),
        ("sdirk2", 2, None),
    ],
)
def test_wear_in_few_steps_warns(scheme, steps, told):
    scene = small_scene(wear_scheme=scheme)
    state = replace(touching(scene, np.s_[5:40]), index=steps)
    texts = [warning.text for warning in warnings(scene, state)]
    assert len(texts) == bool(told)
    assert not told or told in texts[0]
    for unworn in (replace(scene, wear=None), replace(scene, wear=Wear(0.0))):
        assert warnings(unworn, state) == []


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"pixels_per_element": 2}, True),
        ({"history_coarsening": 2}, False),  # which a point of few nodes does without
        ({}, False),  # each pixel is an element: there are no smaller ones
        ({"pixels_per_element": 2, "roughness": False}, True),  # eight in a line
    ],
)
def test_few_nodes_warn_where_smaller_elements_would_differ(changes, told):
    scene = replace(small_scene(**changes), pixels=Grid((96, 64), (4e-6, 4e-6)))
    state = last(simulate(scene, 50.0, 1.25))
    kinds = [warning.kind for warning in warnings(scene, state)]
    assert (WarningKind.FEW_NODES in kinds) is told
    assert not told or "take smaller elements" in warnings(scene, state)[0].text


@pytest.mark.parametrize(
    ("changes", "velocity", "told"),
    [
        ({"pixels_per_element": 2}, 0.05, None),  # by 0.9 %, where elements are not the pixels
        ({"pixels_per_element": 2}, 0.02, "about 1.2 % too warm"),
        ({}, 0.2, "about 0.6 % too warm"),
        ({}, 1.0, None),  # by 0.3 %
        ({}, 0.0, None),
        ({"heat_model": "history"}, 0.02, None),
    ],
)
def test_the_present_heat_warns_where_a_contact_has_grown_slowly(changes, velocity, told):
    scene = replace(small_scene(**changes), pixels=Grid((96, 64), (4e-6, 4e-6)))
    found = [
        each.text
        for each in warnings(scene, last(simulate(scene, 600.0, velocity)))
        if each.kind == WarningKind.PRESENT_HEAT
    ]
    assert len(found) == bool(told)
    assert not told or told in found[0]


def test_the_present_heat_does_not_warn_long_after_a_contact_has_grown():
    loading = Ramp(rate=150.0, reference_load=600.0, hold=50.0, hold_steps=1)
    scene = replace(small_scene(), loading=loading)
    assert warnings(scene, last(simulate(scene, 600.0, 0.05))) == []
