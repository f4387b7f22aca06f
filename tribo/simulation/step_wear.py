"""Wear of the pin in one step of a loading: a constant rate, that of Archard or of a user's law."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Mask
from tribo.wear import RollingWear, Wear, evaluate_wear


def step_wear(scene: Scene, before: State, distance: float, velocity: float) -> Wear | None:
    """Wear of the pin in a step, at a constant rate; None if the scene has no wear.

    The step begins with the state `before`, and slides over `distance` [m] at the sliding
    `velocity` [m/s], which also decides whether the pin rolls. On coarser and finer grids the rate
    is the same, if `before` is a copy of the same state.
    """
    if scene.wear is None or scene.contact_pattern is None:
        return None
    if isinstance(scene.wear, Wear):
        wear = scene.wear
    else:
        start_distance = before.sliding_distance
        pressure = nominal_pressure(scene, before)
        wear = evaluate_wear(
            scene.wear, start_distance, start_distance + distance, pressure, abs(velocity)
        )
    wear = replace(wear, pattern=scene.contact_pattern)
    windows = scene.windows_worn(velocity) if scene.motion else 1.0
    if windows == 1:
        return wear
    return RollingWear(wear.specific_wear_rate, wear.pattern, min(1.0, 1 / windows))


def nominal_pressure(scene: Scene, state: State) -> float:
    """Load over the area that the contact spans [Pa]; 0 if nothing touches.

    A line contact spans its width along x times the length of the pin, a point contact the ellipse
    of its widths along x and y. Unlike the mean pressure on the touching elements, this pressure
    hardly depends on their size: in the system of Bosman & de Rooij at 400 N, elements of 1, 2 and
    4 pixels have 5.3, 4.6 and 3.7 GPa where they touch, and a nominal pressure of 522 MPa.

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> width = tribo.measures(scene, state)["contact_width"]  # of a circle, under a ball
    >>> f"{nominal_pressure(scene, state) * math.pi / 4 * width**2:.1f} N"
    '10.0 N'
    """
    contact = state.pressure > 0
    if not contact.any():
        return 0.0
    # With the window's size in pixels, which is exactly the same for elements of any size.
    width_x, width_y = (_span(contact, axis) * scene.pixels.size[axis] for axis in (0, 1))
    length = scene.pin.length
    return state.normal_load / (
        math.pi / 4 * width_x * width_y if length is None else width_x * length
    )


def _span(contact: Mask, axis: int) -> float:
    """Share of the window, along an axis, from the first to the last element that touches."""
    indices = np.flatnonzero(contact.any(axis=1 - axis))
    return float((indices[-1] - indices[0] + 1) / contact.shape[axis])
