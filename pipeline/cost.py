"""What a sweep will cost, before it runs."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.plan import step_count
from pipeline.sweep import Sweep
from tribo import QUANTILES, ElasticHalfSpace, contact_modulus

__all__ = ["Estimate", "estimate"]

# Counted on the shipped scene; `irg run` stores the true numbers as `iterations`.
_CONVOLUTIONS_PER_CONTACT = 14.0
_CONVOLUTIONS_PER_REFINEMENT = 35.0  # of a point's last step, from the grid of the history
_CONVOLUTIONS_PER_TEMPERATURE = 30.0
_WORKER_BYTES = 115e6  # interpreter and libraries
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_STORED_COLUMNS = 15


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cost of a sweep.

    Attributes
    ----------
    points, steps, temperatures : int
        Points of the diagram; contacts and heat partitions to solve for them.
    workers : int
    seconds : float
        Wall time, from the time of a convolution measured here and now.
    worker_bytes, disk_bytes : float
        Memory of each worker, and size of the store.
    left_out : tuple of str
        What the scene does not require, and why.
    """

    points: int
    steps: int
    temperatures: int
    workers: int
    seconds: float
    worker_bytes: float
    disk_bytes: float
    left_out: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)


def estimate(sweep: Sweep, workers: int | None = None) -> Estimate:
    """Estimate the cost of a whole sweep.

    Parameters
    ----------
    sweep : Sweep
    workers : int, optional
        One for each core if not given.
    """
    workers = workers or os.cpu_count() or 1
    surfaces = len(sweep.realizations) or 1
    points = len(sweep.loads) * len(sweep.velocities) * surfaces
    counts = [step_count(sweep, load) for load in sweep.loads]
    # A chain is the trunk up to the highest load, and a step off it for each lower one.
    steps = sum(counts) if sweep.independent else max(counts) + len(counts) - 1
    interval = sweep.fidelity.temperature_interval
    temperatures = len(counts) + (max(counts) // interval if interval else 0)
    moving = sum(velocity != 0 for velocity in sweep.velocities)
    ramps = len(sweep.velocities) * surfaces
    steps, temperatures = steps * ramps, temperatures * moving * surfaces
    convolutions = (
        steps * _CONVOLUTIONS_PER_CONTACT / sweep.coarsening**2
        + temperatures * _CONVOLUTIONS_PER_TEMPERATURE
    )
    if sweep.coarsening > 1:
        convolutions += points * _CONVOLUTIONS_PER_REFINEMENT
    parallel = min(workers, points if sweep.independent else ramps)
    field_bytes = 8.0 * np.prod(sweep.grid.shape)
    row_bytes = 8.0 * (_STORED_COLUMNS + len(QUANTILES)) * max(counts)
    return Estimate(
        points=points,
        steps=steps,
        temperatures=temperatures,
        workers=workers,
        seconds=convolutions * _convolution_seconds(sweep) / parallel,
        worker_bytes=_WORKER_BYTES + _FIELDS_IN_MEMORY * field_bytes,
        disk_bytes=points * (row_bytes + (3 * field_bytes if sweep.store_fields else 0.0)),
        left_out=tuple(_left_out(sweep, max(counts), surfaces)),
    )


def _left_out(sweep: Sweep, steps: int, surfaces: int) -> Iterator[str]:
    """What would be computed or stored for another scene, and why not for this one."""
    nx, ny = sweep.grid.shape
    if sweep.is_plane:
        yield (
            f"the axis y: both bodies are smooth, so {nx} × 1 elements stand for "
            f"{nx} × {sweep.rows_per_element}"
        )
    increments = sum(1 for _ in sweep.loading.stations(max(sweep.loads), sweep.fidelity.increments))
    if steps < increments:
        yield f"{increments - steps} of {increments} steps: without wear no step needs the others"
    if sweep.wear is None:
        yield "wear: the scene has none"
    if not math.isfinite(sweep.hardness):
        yield "the bound on the pressure from above: no body has a hardness"
    still = sum(velocity == 0 for velocity in sweep.velocities)
    if still:
        yield f"heat at {still * len(sweep.loads) * surfaces} points: nothing moves there"
    interval = sweep.fidelity.temperature_interval
    if not interval and steps > 1 and sweep.fidelity.heat_model != "history":
        yield f"temperatures at up to {steps - 1} steps on the way: asked for at the end only"
    if sweep.coarsening > 1:
        factor = sweep.coarsening
        yield (
            f"the fine grid until a point's last step: {nx // factor} × {ny // factor} elements "
            "know the wear"
        )
    if not sweep.store_fields:
        megabytes = 24e-6 * nx * ny * len(sweep.loads) * len(sweep.velocities) * surfaces
        yield f"fields: not asked for, which would take up to {megabytes:.0f} MB"


def _convolution_seconds(sweep: Sweep) -> float:
    """Time of one convolution on the sweep's grid, the median of a few."""
    solid = ElasticHalfSpace(sweep.grid, contact_modulus(sweep.pin.material, sweep.disk))
    pressure = np.ones(sweep.grid.shape)
    out = np.empty(sweep.grid.shape)
    times = []
    for _ in range(7):
        began = time.perf_counter()
        solid(pressure, out=out)
        times.append(time.perf_counter() - began)
    return float(np.median(times))
