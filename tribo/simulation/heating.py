"""Temperature of a state, from its present friction heat or from all heat so far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tribo.convolution import Convolution
from tribo.grid import Grid
from tribo.simulation.invariants import check_heat, within_range
from tribo.simulation.kernels import heat_spectrum
from tribo.simulation.scene import Scene
from tribo.simulation.state import Heat, State
from tribo.thermal.conduction import settling_time
from tribo.thermal.duhamel import Conductor, HeatHistory, partition_with_history
from tribo.thermal.partition import HeatPartition, partition_heat
from tribo.thermal.quantiles import contact_quantiles
from tribo.types import Mask

__all__ = ["heat", "heated_since"]


@within_range("the temperature of a contact")
def heat(scene: Scene, state: State, velocity: float) -> Heat:
    """Temperature of a state, at friction coefficient 1 and with both bodies' bulk equal.

    The present friction heat is taken to act since time 0 (Bosman & de Rooij), whatever the heat
    model of the fidelity.
    """
    contact = state.pressure > 0
    return _summary(scene, _partition(scene, state, velocity, contact), contact)


def heated_since(scene: Scene, history: HeatHistory, state: State, velocity: float) -> State:
    """Give a state the temperature that it owes to all heat so far, its own step included."""
    contact = state.pressure > 0
    split, heat_history = partition_with_history(
        scene.grid,
        *_bodies(scene, velocity),
        history,
        state.time,
        abs(velocity) * state.pressure,
        contact,
        method=scene.fidelity.partition,
        tolerance=scene.fidelity.heat_tolerance,
        spectrum_of=heat_spectrum,
    )
    _check_split(scene, state, velocity, contact, split)
    summary = _summary(scene, split, contact) if contact.any() else None
    return replace(state, heat=summary, heat_history=heat_history)


def _summary(scene: Scene, split: HeatPartition, contact: Mask) -> Heat:
    on_contact = split.rise[contact]
    # Quantiles interpolate between the nodes, so each row that a plane stands for has to count.
    rows = scene.rows_per_element
    return Heat(
        rise=split.rise,
        rise_quantile=contact_quantiles(split.rise.repeat(rows, 1), contact.repeat(rows, 1)),
        max_rise=float(on_contact.max()),
        mean_rise=float(on_contact.mean()),
        pin_heat_share=split.pin_share,
        iterations=split.iterations,
    )


def _partition(scene: Scene, state: State, velocity: float, contact: Mask) -> HeatPartition:
    grid = scene.grid
    if velocity == 0 or not scene.friction_heat:
        return HeatPartition(np.zeros(grid.shape), np.zeros(grid.shape), np.nan, 0, 0.0)
    pin, disk = (_conductor(grid, body, state.time) for body in _bodies(scene, velocity))
    split = partition_heat(
        pin,
        disk,
        abs(velocity) * state.pressure,
        contact,
        method=scene.fidelity.partition,
        tolerance=scene.fidelity.heat_tolerance,
    )
    _check_split(scene, state, velocity, contact, split)
    return split


def _check_split(
    scene: Scene,
    state: State,
    velocity: float,
    contact: Mask,
    split: HeatPartition,
) -> None:
    local = scene.fidelity.partition == "local"
    tolerance = scene.fidelity.heat_tolerance if local else np.inf
    check_heat(abs(velocity) * state.pressure, contact, split, tolerance)


def _bodies(scene: Scene, velocity: float) -> tuple[Conductor, Conductor]:
    """Pin and disk."""
    length = scene.heated_length
    return Conductor(scene.pin.material, 0.0, length), Conductor(scene.disk, velocity, length)


def _conductor(grid: Grid, body: Conductor, time: float) -> Convolution:
    """The thermal map of a body, which after a while no longer depends on the time."""
    settled = min(time, settling_time(grid, body.material, body.velocity))
    return Convolution(grid, heat_spectrum(grid, body, (0.0, settled), (1.0, 1.0)))
