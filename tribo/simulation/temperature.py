"""Temperature of a state from its present friction heat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tribo.material import Material
from tribo.simulation.cache import heat_map
from tribo.simulation.group_correlation import jackknife_quality
from tribo.simulation.invariants import check_heat, guard_range
from tribo.simulation.scene import Scene
from tribo.simulation.state import Heat, State
from tribo.simulation.surface_groups import surface_groups
from tribo.thermal import (
    ConductingHalfSpace,
    HeatPartition,
    contact_quantiles,
    partition_heat,
    rises_without_groups,
    settling_time,
)
from tribo.types import Array, Indices, Mask

_HeatMaps = tuple[ConductingHalfSpace, ConductingHalfSpace]
_ROWS = 8  # divisor of the number of rows, for fast transforms


@guard_range("the temperature of a contact")
def heat(scene: Scene, state: State, velocity: float, is_sampled: bool = False) -> Heat:
    """Temperature rises of a state, per unit friction coefficient; `InputError` if nothing touches.

    The present friction heat is taken to act since time 0 (Bosman & de Rooij). The rise is then too
    high, since the load was lower before; see `tribo.simulation.elapsed_heat`.

    The temperature depends on pressure and time of the contact, but not on earlier wear. Thermal
    constants, elements and velocity [m/s] may therefore differ from those used for the contact.
    If `is_sampled`, the result also has `Heat.sampling`.

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> f"{0.1 * heat(scene, state, velocity=0.13).max_rise:.1f} K at friction 0.1"
    '13.8 K at friction 0.1'
    """
    scene = refined_scene(scene, state)
    pressures = [state.pressure, *state.passing]
    maps = _heat_maps(scene, state, velocity)
    groups = surface_groups(scene) if is_sampled and scene.roughness is not None else None
    heats = [_present_heat(scene, maps, velocity, state.pressure, groups)]
    if scene.wears_by_strips and state.passing:
        # No other temperature of these positions is needed than that of the contact.
        rows = _touching_rows(pressures)
        shape = rows.stop - rows.start, scene.grid.shape[1]
        maps = maps[0].cropped(shape), maps[1].cropped(shape)
        groups = None if groups is None else groups[rows]
        pressures = [pressure[rows] for pressure in pressures]
    heats += [_present_heat(scene, maps, velocity, pressure, groups) for pressure in pressures[1:]]
    mean = mean_heat(heats)
    return mean if groups is None else replace(mean, jackknife=jackknife_quality(scene))


def _touching_rows(pressures: Sequence[Array]) -> slice:
    """Rows of elements along x that touch under any of the pressures; their number is even."""
    touching = np.flatnonzero(np.any([pressure.any(axis=1) for pressure in pressures], axis=0))
    first, last, n = int(touching[0]), int(touching[-1]), len(pressures[0])
    size = min(math.ceil((last + 1 - first) / _ROWS) * _ROWS, n)
    start = min(first, n - size)
    return slice(start, start + size)


def mean_heat(heats: Sequence[Heat]) -> Heat:
    """`Heat` with mean values over positions of the disk, from the `heats` at each position.

    The array `Heat.rise` is that at the first position, and `Heat.iterations` is the sum over
    positions. A group of elements is left out at all positions.
    """
    first, *further_heats = heats
    if not further_heats:
        return first

    def mean(name: str) -> Any:
        return np.mean([getattr(position_heat, name) for position_heat in heats], axis=0)

    return replace(
        first,
        max_rise=float(mean("max_rise")),
        mean_rise=float(mean("mean_rise")),
        pin_heat_share=float(mean("pin_heat_share")),
        rise_quantile=mean("rise_quantile"),
        iterations=sum(position_heat.iterations for position_heat in heats),
        quantile_without=None if first.quantile_without is None else mean("quantile_without"),
    )


def _present_heat(
    scene: Scene, maps: _HeatMaps, velocity: float, pressure: Array, groups: Indices | None
) -> Heat:
    """Rises per unit friction by the present heat since time 0, and the pin's share of the heat."""
    contact = pressure > 0
    split = _partition(scene, maps, friction_heat(scene, pressure, velocity), contact)
    return _heat_summary(scene, split, contact, groups)


def refined_scene(scene: Scene, state: State) -> Scene:
    """Scene with the elements of a state, which may differ in size from the scene's own."""
    block = scene.pixels.shape[0] // len(state.pressure)
    if block == scene.fidelity.pixels_per_element:
        return scene
    changed = replace(scene.fidelity, pixels_per_element=block, history_coarsening=1)
    return replace(scene, fidelity=changed)


def _heat_summary(
    scene: Scene, split: HeatPartition, contact: Mask, groups: Indices | None
) -> Heat:
    contact_rise = split.rise[contact]
    # Quantiles interpolate between elements, so that a plane's element counts once for each row.
    rows = scene.rows_per_element
    leave_one_out = None
    if groups is not None:
        leave_one_out = rises_without_groups(split.rise, contact, groups)
    return Heat(
        rise=split.rise,
        rise_quantile=contact_quantiles(split.rise.repeat(rows, 1), contact.repeat(rows, 1)),
        max_rise=float(contact_rise.max()),
        mean_rise=float(contact_rise.mean()),
        pin_heat_share=split.pin_share,
        iterations=split.iterations,
        quantile_without=leave_one_out,
    )


def _partition(scene: Scene, maps: _HeatMaps, friction: Array, contact: Mask) -> HeatPartition:
    if not friction.any():
        return HeatPartition(np.zeros(contact.shape), np.zeros(contact.shape), np.nan, 0, 0.0)
    split = partition_heat(*maps, friction, contact, tolerance=scene.fidelity.heat_tolerance)
    check_heat(friction, contact, split, scene.fidelity.heat_tolerance)
    return split


def friction_heat(scene: Scene, pressure: Array, velocity: float) -> Array:
    """Friction heat of each element per unit friction coefficient [W/m²], shape (nx, ny).

    It is |velocity| times pressure, or 0 in a scene without friction heat.
    """
    return abs(velocity) * pressure * scene.friction_heat


def _heat_maps(scene: Scene, state: State, velocity: float) -> _HeatMaps:
    """Maps from heat flux to temperature rise of pin and disk, for a flux constant since time 0."""
    velocities = scene.velocities_at(velocity)

    def body(material: Material, body_velocity: float) -> ConductingHalfSpace:
        time = min(state.time, settling_time(scene.grid, material, body_velocity))
        return heat_map(scene.grid, material, body_velocity, time, scene.heated_length)

    return body(scene.pin.material, velocities.pin), body(scene.disk, velocities.disk)
