"""Temperature of a state from its present friction heat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tribo.material import Material
from tribo.simulation.cache import heat_map
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
from tribo.types import Array, Mask


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
    passing = (replace(state, pressure=pressure) for pressure in state.passing)
    return mean_heat(
        [_present_heat(scene, contact, velocity, is_sampled) for contact in (state, *passing)]
    )


def mean_heat(heats: Sequence[Heat]) -> Heat:
    """`Heat` with mean values over positions of the disk, from the `heats` at each position.

    The array `Heat.rise` is that at the first position, and `Heat.iterations` is the sum over
    positions.
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


def _present_heat(scene: Scene, state: State, velocity: float, is_sampled: bool) -> Heat:
    """Rises per unit friction by the present heat since time 0, and the pin's share of the heat."""
    contact = state.pressure > 0
    return _heat_summary(scene, _partition(scene, state, velocity, contact), contact, is_sampled)


def refined_scene(scene: Scene, state: State) -> Scene:
    """Scene with the elements of a state, which may differ in size from the scene's own."""
    block = scene.pixels.shape[0] // len(state.pressure)
    if block == scene.fidelity.pixels_per_element:
        return scene
    changed = replace(scene.fidelity, pixels_per_element=block, history_coarsening=1)
    return replace(scene, fidelity=changed)


def _heat_summary(scene: Scene, split: HeatPartition, contact: Mask, is_sampled: bool) -> Heat:
    contact_rise = split.rise[contact]
    # Quantiles interpolate between elements, so that a plane's element counts once for each row.
    rows = scene.rows_per_element
    leave_one_out = None
    if is_sampled and scene.roughness is not None:
        leave_one_out = rises_without_groups(split.rise, contact, surface_groups(scene))
    return Heat(
        rise=split.rise,
        rise_quantile=contact_quantiles(split.rise.repeat(rows, 1), contact.repeat(rows, 1)),
        max_rise=float(contact_rise.max()),
        mean_rise=float(contact_rise.mean()),
        pin_heat_share=split.pin_share,
        iterations=split.iterations,
        quantile_without=leave_one_out,
    )


def _partition(scene: Scene, state: State, velocity: float, contact: Mask) -> HeatPartition:
    grid, friction = scene.grid, friction_heat(scene, state, velocity)
    if not friction.any():
        return HeatPartition(np.zeros(grid.shape), np.zeros(grid.shape), np.nan, 0, 0.0)
    split = partition_heat(
        *_heat_maps(scene, state, velocity),
        friction,
        contact,
        tolerance=scene.fidelity.heat_tolerance,
    )
    check_heat(friction, contact, split, scene.fidelity.heat_tolerance)
    return split


def friction_heat(scene: Scene, state: State, velocity: float) -> Array:
    """Friction heat of each element per unit friction coefficient [W/m²], shape (nx, ny).

    It is |velocity| times pressure, or 0 in a scene without friction heat.
    """
    return abs(velocity) * state.pressure * scene.friction_heat


def _heat_maps(
    scene: Scene, state: State, velocity: float
) -> tuple[ConductingHalfSpace, ConductingHalfSpace]:
    """Maps from heat flux to temperature rise of pin and disk, for a flux constant since time 0."""
    velocities = scene.velocities_at(velocity)

    def body(material: Material, body_velocity: float) -> ConductingHalfSpace:
        time = min(state.time, settling_time(scene.grid, material, body_velocity))
        return heat_map(scene.grid, material, body_velocity, time, scene.heated_length)

    return body(scene.pin.material, velocities.pin), body(scene.disk, velocities.disk)
