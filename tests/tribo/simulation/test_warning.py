"""Warnings that a point carries (tribo/simulation/warning.py)."""

from collections import deque
from dataclasses import replace

import pytest

from tests.helpers.scenes import small_scene
from tribo import Grid, Ramp, WarningKind, simulate, warnings


def last(states):
    return deque(states, maxlen=1).pop()


def test_contact_at_the_window_s_edge_warns():
    scene = replace(small_scene(), pixels=Grid((12, 16), (8e-6, 8e-6)))
    assert "x edge" in warnings(scene, last(simulate(scene, 750.0, 1.25)))[0].text
    assert warnings(small_scene(), last(simulate(small_scene(), 100.0, 1.25))) == []


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
    assert kinds == [WarningKind.FEW_NODES] * told
    assert not told or "take smaller elements" in warnings(scene, state)[0].text


@pytest.mark.parametrize(
    ("changes", "velocity", "told"),
    [
        ({}, 0.05, True),
        ({}, 0.2, False),  # where the present heat is hardly too warm
        ({}, 0.0, False),
        ({"heat_model": "history"}, 0.05, False),
    ],
)
def test_the_present_heat_warns_where_a_contact_grows_slowly(changes, velocity, told):
    scene = small_scene(**changes)
    kinds = [each.kind for each in warnings(scene, last(simulate(scene, 600.0, velocity)))]
    assert kinds == [WarningKind.PRESENT_HEAT] * told


def test_the_present_heat_does_not_warn_long_after_a_contact_has_grown():
    loading = Ramp(rate=150.0, reference_load=600.0, hold=50.0, hold_steps=1)
    scene = replace(small_scene(), loading=loading)
    assert warnings(scene, last(simulate(scene, 600.0, 0.05))) == []
