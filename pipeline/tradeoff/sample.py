"""How long a scene's steps take here and now, from a few of them."""

from __future__ import annotations

import functools
import itertools
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from pipeline.sweep.model import Sweep
from tribo import (
    ConductingHalfSpace,
    Grid,
    Scene,
    TriboError,
    advance,
    forget_kernels,
    partition_heat,
    simulate,
    start,
)

__all__ = ["Sample", "busy_cores", "elimination_seconds", "sampled"]

T = TypeVar("T")

_ENOUGH_ELEMENTS = 120  # along x, to count convolutions on; they hardly depend on it
_AREA_EXPONENT = 0.4  # of the contact's area over the size of elements, on the shipped scene
_SECONDS = 2.0  # that counting may take
_TIMED_FOR, _TIMED_AT_MOST = 0.5, 25  # seconds and times that a step is repeated
_NODES = 640  # of the elimination that is timed


@dataclass(frozen=True, slots=True)
class Sample:
    """What was counted and timed.

    Attributes
    ----------
    convolutions_per_contact, convolutions_per_temperature : float
        Counted along the ramp to the highest load, on larger elements.
    where : str
        On which elements that was counted, if not on the scene's own.
    contact_fraction, contact_rows : float
        Shares of the window in contact, and of its rows between the first and the last that are,
        at the end of that ramp.
    seconds_per_convolution : tuple of float
        With all that goes with it, timed in a step on the grid of the history and on the scene's
        own; wall time.
    kernel_seconds : tuple of float
        To make a thermal kernel, of the pin and of the disk.
    surface_seconds : float
        To make the surface and the kernels of the contact, once for each worker.
    """

    convolutions_per_contact: float
    convolutions_per_temperature: float
    where: str
    contact_fraction: float
    contact_rows: float
    seconds_per_convolution: tuple[float, float]
    kernel_seconds: tuple[float, float]
    surface_seconds: float


def sampled(sweep: Sweep) -> Sample:
    """Count on a coarse copy of a sweep's scene, and time a step of the scene itself.

    Raises
    ------
    TriboError
        If the scene's first step has no solution.
    """
    load = max(sweep.loads)
    moving = sorted(abs(velocity) for velocity in sweep.velocities if velocity)
    velocity = moving[len(moving) // 2] if moving else 0.0
    coarse = _coarse(sweep)
    contacts, temperature, fraction, rows = _counts(sweep, coarse, load, velocity)
    own_grid = replace(sweep, fidelity=replace(sweep.fidelity, history_coarsening=1))
    of_history = next(sweep.levels())
    forget_kernels()
    surface, own = _stepped(own_grid, load, velocity)
    history = own if sweep.coarsening == 1 else _stepped(of_history, load, velocity)[1]
    time_at_load = list(sweep.stations(load))[-1].time
    pin, disk = (
        _timed(functools.partial(ConductingHalfSpace, sweep.grid, material, speed, time_at_load))[0]
        if velocity
        else 0.0
        for material, speed in ((sweep.pin.material, 0.0), (sweep.disk, velocity))
    )
    return Sample(
        convolutions_per_contact=contacts,
        convolutions_per_temperature=temperature,
        where=" on larger elements" if coarse.grid != sweep.grid else "",
        contact_fraction=fraction,
        contact_rows=rows,
        seconds_per_convolution=(history, own),
        kernel_seconds=(pin, disk),
        surface_seconds=surface,
    )


def busy_cores() -> float:
    """How many cores were busy in the last minute; 0 where that is not known."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0


def elimination_seconds(sweep: Sweep, nodes: float) -> float:
    """Duration of a direct heat partition with so many nodes in contact, from two small ones."""
    small, large = (_eliminated(sweep, number) for number in (_NODES, 2 * _NODES))
    # Rows are divided n² times and added n³ times.
    cubic = max(0.0, (large - 4 * small) / 4)
    square = max(0.0, small - cubic)
    return square * (nodes / _NODES) ** 2 + cubic * (nodes / _NODES) ** 3


def _eliminated(sweep: Sweep, nodes: int) -> float:
    columns = 16
    grid = Grid((nodes // columns, columns), sweep.grid.spacing, periodic=(False, False))
    body = ConductingHalfSpace(grid, sweep.disk, 0.0, 1.0)
    flux = np.ones(grid.shape)
    return _timed(functools.partial(partition_heat, body, body, flux, flux > 0, method="direct"))[0]


def _counts(
    sweep: Sweep, coarse: Scene, load: float, velocity: float
) -> tuple[float, float, float, float]:
    """Convolutions of a contact and of a temperature; shares of the window, and of its rows."""
    contacts: list[float] = []
    temperature = fraction = rows = 0.0
    began = time.perf_counter()
    ratio = sweep.fidelity.pixels_per_element / coarse.fidelity.pixels_per_element
    finer = ratio**_AREA_EXPONENT if sweep.roughness else 1.0
    try:
        for state in simulate(coarse, load, velocity):
            contacts.append(float(state.iterations))
            fraction = float(np.count_nonzero(state.pressure)) / state.pressure.size * finer
            touched = np.flatnonzero(state.pressure.any(axis=1))
            rows = float(np.ptp(touched) + 1) / len(state.pressure) if touched.size else 0.0
            if state.heat:
                temperature = float(state.heat.iterations)
            if time.perf_counter() - began > _SECONDS:
                break
    except TriboError:  # of the coarse copy alone
        pass
    return float(np.mean(contacts or [0.0])), temperature, fraction, rows


def _coarse(sweep: Sweep) -> Scene:
    """The scene on elements as large as counting allows, throughout."""
    fidelity = replace(sweep.fidelity, history_coarsening=1)
    if fidelity.partition == "direct":
        fidelity = replace(fidelity, partition="local")
    nx, ny = sweep.pixels.shape
    largest = max(fidelity.pixels_per_element, nx // _ENOUGH_ELEMENTS)
    block = next(n for n in range(largest, 0, -1) if nx % n == ny % n == 0)
    return replace(sweep, fidelity=replace(fidelity, pixels_per_element=block))


def _stepped(scene: Scene, load: float, velocity: float) -> tuple[float, float]:
    """Seconds to begin, with all that every step needs, and of each convolution of a step."""
    first, *others = itertools.islice(scene.stations(load), 2)
    unloaded = start(scene)
    to_begin, begun = _timed(functools.partial(advance, scene, unloaded, first, velocity))
    before, station = (begun, others[0]) if others else (unloaded, first)
    step = functools.partial(advance, scene, before, station, velocity)
    times: list[float] = []
    while sum(times) < _TIMED_FOR and len(times) < _TIMED_AT_MOST:
        seconds, state = _timed(step)
        times.append(seconds)
    usual = float(np.median(times))
    return max(0.0, to_begin - usual), usual / max(1.0, float(state.iterations))


def _timed(function: Callable[[], T]) -> tuple[float, T]:
    began = time.perf_counter()
    result = function()
    return time.perf_counter() - began, result
