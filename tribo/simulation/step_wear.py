"""Wear of the pin in one step of a loading, and the parts into which deep wear cuts a step.

The rate is constant, or that of a user's law. A step is cut into parts if it would leave too deep
an imprint of the roughness in the pin. A pin that wears point by point becomes the negative of the
area that it faces. Most of this happens within a few steps. The depth of a step's imprint depends
only on the velocity and the wear rate, and the rate on the state before the step. So loads that
share a ramp have the same parts of its steps. Under strips of the disk, all steps of a preset have
equally many parts, so that the rise does not jump between two velocities.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tribo.constants import (
    END_IMPRINT,
    END_PARTS,
    MAX_END_RATIO,
    MOST_PARTS_OF_STEP,
    RESOLVING_STEPS,
)
from tribo.loading import LoadStep
from tribo.simulation.disk_positions import imprint_ratio
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


def step_parts(
    scene: Scene, before: State, load_step: LoadStep, velocity: float, ends_hold: bool = False
) -> Iterator[LoadStep]:
    """Cut a step into parts; yield time and load at the end of each part.

    The step leads from the state `before` to `load_step`, which is yielded last. The step has so
    many parts of equal duration that in each the roughness wears only a shallow imprint into the
    pin, but at most 4, and only one with 25 steps or more. A dense contact has more parts, see
    `tribo.simulation.element_size`. If the step `ends_hold`, a hold of a pin at rest, the parts
    become shorter towards its end.
    """
    distance = abs(velocity) * (load_step.time - before.time)
    if ends_hold and load_step.holding and scene.wears_by_strips and distance:
        shares = _end_shares(scene, before, distance, velocity)
    else:
        count = 1 if load_step.holding or not scene.wears else scene.fidelity.parts
        count *= _part_count(scene, before, distance / count, velocity)
        shares = [part / count for part in range(1, count)]
    for part, share in enumerate(shares):
        yield replace(interpolate_step(before, load_step, share), part=part)
    yield replace(load_step, part=len(shares)) if shares else load_step


def _end_shares(scene: Scene, before: State, distance: float, velocity: float) -> list[float]:
    """Ends of the parts of a hold's last step, without the last, as shares of its duration.

    A long step would wear the imprint of its last strips as deep as the roughness. So each part is
    half of what remains, until the imprint of the rest is shallow. The rest has equal parts.
    """
    wear = step_wear(scene, before, distance, velocity)
    imprint = imprint_ratio(scene, wear, distance) / END_IMPRINT if wear else 0.0
    halvings = math.ceil(math.log2(min(max(imprint, 1.0), MAX_END_RATIO)))
    rest, count = 0.5**halvings, END_PARTS * scene.fidelity.parts
    halves = [1 - 0.5**number for number in range(1, halvings + 1)]
    return halves + [1 - rest * (1 - part / count) for part in range(1, count)]


def _part_count(scene: Scene, before: State, distance: float, velocity: float) -> int:
    if not (scene.fidelity.imprint and distance) or scene.sweeps_over or scene.wears_by_strips:
        return 1
    wear = step_wear(scene, before, distance, velocity)
    if wear is None:
        return 1
    fidelity = scene.fidelity
    resolving_parts = math.ceil(RESOLVING_STEPS / (fidelity.increments * fidelity.parts))
    imprint = imprint_ratio(scene, wear, distance) / fidelity.imprint
    return math.ceil(min(max(imprint, 1.0), MOST_PARTS_OF_STEP, resolving_parts))


def interpolate_step(before: State, load_step: LoadStep, share: float) -> LoadStep:
    """Time and load after a `share` of a step's duration, if the load changes linearly within it.

    The step leads from the state `before` to `load_step`.
    """
    begin, end = before.normal_load, load_step.normal_load
    load = begin + share * (end - begin)
    # 0 for an unloaded step.
    impulse_share = share * (begin + load) / (begin + end) if begin + end else 0.0
    impulse = impulse_share * (load_step.impulse - before.impulse)
    return replace(
        load_step,
        normal_load=load,
        time=before.time + share * (load_step.time - before.time),
        on_trunk=False,
        impulse=before.impulse + impulse,
    )
