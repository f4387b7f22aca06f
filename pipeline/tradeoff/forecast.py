"""What a sweep will cost, before it runs."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from pipeline.tradeoff.sample import busy_cores, elimination_seconds, sampled
from tribo import QUANTILES
from tribo.thermal.partition import DIRECT_MEMORY

__all__ = ["Estimate", "estimate"]

_CONVOLUTIONS_PER_REFINEMENT = 15.0  # of a point's last step, from the grid of the history
_SECONDS_TO_START = 1.0  # a cluster
_SECONDS_TO_COMMIT = 0.005  # a point, and to schedule it
_WORKER_BYTES = 115e6  # interpreter and libraries
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_STORED_COLUMNS = 15
_LONG = 10.0  # s for one temperature


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cost of a sweep.

    Attributes
    ----------
    points, steps, temperatures : int
        Points of the diagram; contacts and heat partitions to solve for them.
    workers : int
    seconds : float
        Wall time, as long as the machine stays as busy as it is.
    convolutions : float
        To solve contacts and heat partitions, on all grids.
    basis : str
        What the time rests on.
    worker_bytes, disk_bytes : float
        Memory of each worker, and size of the store.
    warnings : tuple of str
        What of it will fail, or is beyond reason.
    left_out : tuple of str
        What the scene does not require, and why.
    """

    points: int
    steps: int
    temperatures: int
    workers: int
    seconds: float
    convolutions: float
    basis: str
    worker_bytes: float
    disk_bytes: float
    warnings: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)


def estimate(sweep: Sweep, workers: int | None = None) -> Estimate:
    """Estimate the cost of a whole sweep, from a few of its steps done here and now.

    Parameters
    ----------
    sweep : Sweep
    workers : int, optional
        One for each core if not given.

    Raises
    ------
    TriboError
        If the first step of the scene has no solution.
    """
    cores = os.cpu_count() or 1
    workers = workers or cores
    surfaces = len(sweep.realizations) or 1
    points = len(sweep.loads) * len(sweep.velocities) * surfaces
    counts = [step_count(sweep, load) for load in sweep.loads]
    steps = sum(counts) if sweep.independent else _steps_of_chain(sweep)
    fidelity = sweep.fidelity
    interval = fidelity.temperature_interval
    temperatures = len(counts) + (max(counts) // interval if interval else 0)
    if sweep.remembers_heat:
        temperatures = steps
    moving = sum(velocity != 0 for velocity in sweep.velocities) if sweep.friction_heat else 0
    ramps = len(sweep.velocities) * surfaces
    steps, temperatures = steps * ramps, temperatures * moving * surfaces
    parallel = min(workers, points if sweep.independent else ramps)

    busy = busy_cores()
    sample = sampled(sweep)
    on_history, on_own = sample.seconds_per_convolution
    contacts = steps * sample.convolutions_per_contact
    refinements = points * _CONVOLUTIONS_PER_REFINEMENT if sweep.coarsening > 1 else 0.0
    heats = temperatures * sample.convolutions_per_temperature
    pin_kernel, disk_kernel = sample.kernel_seconds
    pin_kernels = temperatures / max(moving * surfaces, 1) * parallel
    seconds = (
        contacts * on_history
        + (refinements + heats) * on_own
        + pin_kernels * pin_kernel
        + moving * disk_kernel
    )
    nodes = sample.contact_fraction * np.prod(sweep.grid.shape)
    matrix_bytes, warnings = 0.0, []
    if fidelity.partition == "direct" and moving:
        matrix_bytes = 8.0 * nodes**2
        each = elimination_seconds(sweep, nodes)
        seconds += temperatures * each
        heats = 0.0
        if matrix_bytes > DIRECT_MEMORY:
            warnings.append(
                f"direct partition of {nodes:.0f} nodes takes a matrix of "
                f"{matrix_bytes / 2**30:.1f} GiB, allowed are {DIRECT_MEMORY / 2**30:.1f} GiB: "
                "points at high loads will fail; take partition = 'local'"
            )
        elif each > _LONG:
            warnings.append(
                f"direct partition of {nodes:.0f} nodes takes about {each:.0f} s a temperature; "
                "partition = 'local' gives the same within heat_tolerance"
            )
    # The sample has had one core among those that are busy; workers will share them.
    crowd = max(1.0, (busy + parallel) / cores)
    seconds *= crowd / max(1.0, (busy + 1) / cores)
    seconds += points * _SECONDS_TO_COMMIT * crowd
    field_bytes = 8.0 * np.prod(sweep.grid.shape)
    row_bytes = 8.0 * (_STORED_COLUMNS + len(QUANTILES)) * max(counts)
    return Estimate(
        points=points,
        steps=steps,
        temperatures=temperatures,
        workers=workers,
        seconds=_SECONDS_TO_START * crowd + sample.surface_seconds * surfaces + seconds / parallel,
        convolutions=contacts + refinements + heats,
        basis=(
            f"measured just now: {1e3 * on_own:.3g} ms a convolution, "
            f"{sample.convolutions_per_contact:.0f} a contact and "
            f"{sample.convolutions_per_temperature:.0f} a temperature{sample.where}; "
            f"{busy:.1f} of {cores} cores were busy, and are taken to stay so"
        ),
        worker_bytes=_WORKER_BYTES + _FIELDS_IN_MEMORY * field_bytes + matrix_bytes,
        disk_bytes=points * (row_bytes + (3 * field_bytes if sweep.store_fields else 0.0)),
        warnings=tuple(warnings),
        left_out=tuple(_left_out(sweep, max(counts), surfaces, sample.contact_rows)),
    )


def _steps_of_chain(sweep: Sweep) -> int:
    """Steps of the trunk up to the highest load, and of the points that lie off it."""
    trunk = sum(station.on_trunk for station in sweep.stations(max(sweep.loads)))
    off = (not station.on_trunk for load in sweep.loads for station in sweep.stations(load))
    return trunk + sum(off)


def _left_out(sweep: Sweep, steps: int, surfaces: int, contact_rows: float) -> Iterator[str]:
    """What would be computed or stored for another scene, and why not for this one."""
    nx, ny = sweep.grid.shape
    if sweep.is_plane:
        yield (
            f"the axis y: both bodies are smooth, so {nx} × 1 elements stand for "
            f"{nx} × {sweep.rows_per_element}"
        )
    elif (apart := nx - math.ceil(contact_rows * nx)) > 0:
        yield (
            f"transforms along y of {apart} of {nx} rows of elements, which carry nothing even at "
            f"{max(sweep.loads):g} N"
        )
    increments = sum(1 for _ in sweep.loading.stations(max(sweep.loads), sweep.fidelity.increments))
    if steps < increments:
        yield f"{increments - steps} of {increments} steps: without wear no step needs the others"
    if sweep.wear is None:
        yield "wear: the scene has none"
    if not math.isfinite(sweep.hardness):
        yield "the bound on the pressure from above: no body has a hardness"
    still = sum(velocity == 0 for velocity in sweep.velocities)
    if not sweep.friction_heat:
        yield "heat: the friction coefficient is 0, so nothing gets warmer"
    elif still:
        yield f"heat at {still * len(sweep.loads) * surfaces} points: nothing moves there"
    interval = sweep.fidelity.temperature_interval
    if not interval and steps > 1 and sweep.friction_heat and not sweep.remembers_heat:
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
