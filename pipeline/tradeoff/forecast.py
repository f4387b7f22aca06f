"""Foretells what a sweep will cost: time, memory and disk."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.store.schema import AT_END, is_coordinate, variables
from pipeline.sweep.left_out import left_out
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from pipeline.tradeoff.sample import sampled
from tribo import BULK_RATIOS, QUANTILES, ConductingHalfSpace, Grid, partition_heat
from tribo.thermal import DIRECT_MEMORY

_SECONDS_TO_START = 1.0  # of a cluster and its workers
_SECONDS_TO_COMMIT = 0.005  # of scheduling a point and writing it
_WORKER_BYTES = 115e6  # interpreter and libraries
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_BLOCK = 4096  # [B] that the smallest file takes on most disks
_NODES = 1280  # of the elimination that is timed
_SPAN = 0.35  # logarithm of the ratio of two velocities that enclose a boundary
_LONG = 10.0  # [s] for one temperature


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cost of a sweep.

    Attributes
    ----------
    points, steps, temperatures : int
        Points of the diagram; contacts and heat partitions to solve for them.
    workers : int
        Processes that compute.
    seconds : float
        Wall time, as long as the machine stays as busy as it is [s].
    basis : str
        Measurement from which the time is foretold.
    worker_bytes, disk_bytes : float
        Memory of each worker, and size of the store [B].
    warnings : tuple of str
        What will fail or take unreasonably long.
    left_out : tuple of str
        What the scene does not require, and why.
    """

    points: int
    steps: int
    temperatures: int
    workers: int
    seconds: float
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
        Number of processes; one for each core if not given.

    Raises
    ------
    TriboError
        If the highest load has no solution.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> cost = pipeline.estimate(scene, workers=1)
    >>> cost.points
    24
    """
    workers = workers or os.cpu_count() or 1
    variants = len(sweep.simulated)
    velocities = _searched(sweep) if sweep.samples else len(sweep.velocities)
    ramps = velocities * variants
    points = (min(2, velocities) if sweep.samples else velocities) * len(sweep.loads) * variants
    moving = sum(velocity != 0 for velocity in sweep.velocities) if sweep.friction_heat else 0
    steps = list(_steps_of_ramp(sweep))
    if sweep.samples:  # each velocity is looked at for some of the loads alone
        moving = min(moving, velocities)
        steps = [step for step in steps if step[0] <= np.median(sweep.loads)]
    heats = sum(with_heat for _, with_heat in steps)

    busy, cores = busy_cores(), os.cpu_count() or 1
    sample = sampled(sweep)
    ramp = sum(sample.end(load) if heat else sample.step(load) for load, heat in steps)
    warnings: list[str] = []
    if sweep.fidelity.partition == "direct" and moving:
        each = elimination_seconds(sweep, sample.contact_nodes)
        ramp += heats * each
        warnings += _too_many_nodes(sample.contact_nodes, each)
    parallel = min(workers, points if sweep.independent else ramps)
    turns = ramps / parallel if sweep.independent else math.ceil(ramps / parallel)
    computing = turns * (ramp + len(sweep.loads) * _SECONDS_TO_COMMIT)
    crowd = _slower_by(busy, parallel)
    return Estimate(
        points=points,
        steps=len(steps) * ramps,
        temperatures=heats * moving * variants,
        workers=workers,
        seconds=_SECONDS_TO_START + crowd * (sample.begin_seconds * variants + computing),
        basis=(
            f"from real steps at {len(sample.loads)} of {len(sweep.loads)} loads, timed just now: "
            f"{1e3 * sample.end(max(sweep.loads)):.3g} ms for one with a temperature at the "
            "highest load; mostly right within a factor of 1.5; "
            f"{min(busy, cores):.2g} of {cores} cores were busy, and are taken to stay so"
        ),
        worker_bytes=worker_bytes(sweep, sample.contact_nodes),
        disk_bytes=_disk_bytes(sweep),
        warnings=tuple(warnings),
        left_out=(*left_out(sweep), *_idle_rows(sweep, sample.contact_rows)),
    )


def worker_bytes(sweep: Sweep, contact_nodes: int = 0) -> float:
    """Memory of a worker [B], without computing anything.

    Parameters
    ----------
    sweep : Sweep
    contact_nodes : int
        Elements in contact, which count for the direct heat partition alone.
    """
    direct = sweep.fidelity.partition == "direct" and sweep.friction_heat
    matrix = 8.0 * contact_nodes**2 if direct else 0.0
    return _WORKER_BYTES + _FIELDS_IN_MEMORY * 8.0 * math.prod(sweep.grid.shape) + matrix


def machine_bytes() -> float:
    """Memory of this machine [B]; infinite where that is not known."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return math.inf


def busy_cores() -> float:
    """Number of tasks that had or wanted a core in the last minute; 0 where that is not known."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0


def elimination_seconds(sweep: Sweep, nodes: int) -> float:
    """Duration of a direct heat partition with so many nodes in contact, from a smaller one [s]."""
    grid = Grid((_NODES // 16, 16), sweep.grid.spacing, periodic=(False, False))
    body = ConductingHalfSpace(grid, sweep.disk, 0.0, 1.0)
    flux = np.ones(grid.shape)
    began = time.perf_counter()
    partition_heat(body, body, flux, flux > 0, method="direct")
    return (time.perf_counter() - began) * (nodes / _NODES) ** 3


def _searched(sweep: Sweep) -> int:
    """How many velocities the search for a boundary takes at all loads together, about."""
    moving = [velocity for velocity in sweep.velocities if velocity > 0]
    spans = math.log(moving[-1] / moving[0]) / _SPAN if moving else 0.0
    return min(2 * len(sweep.loads), math.ceil(spans) + 1)


def _slower_by(busy: float, parallel: int) -> float:
    """Factor by which workers take longer than the sample did, beside what else is running."""
    cores = os.cpu_count() or 1
    return max(1.0, (busy + parallel) / cores) / max(1.0, (busy + 1) / cores)


def _steps_of_ramp(sweep: Sweep) -> Iterator[tuple[float, bool]]:
    """Load of each step at one velocity, and whether it is given its temperature."""
    interval, shared, trunk = sweep.fidelity.temperature_interval, 0.0, 0.0
    for load in sweep.loads:
        if sweep.trunk(load) != shared:
            shared, trunk = sweep.trunk(load), 0.0
        stations = list(sweep.stations(load, after=trunk))
        for station in stations:
            reached = station.normal_load == load and not station.holding
            asked = reached or station is stations[-1]
            on_way = interval > 0 and station.index % interval == 0
            yield station.normal_load, asked or on_way or sweep.remembers_heat
            if station.on_trunk and not sweep.independent:
                trunk = station.normal_load


def _too_many_nodes(nodes: int, seconds: float) -> Iterator[str]:
    """Why a direct heat partition of so many nodes will fail or take unreasonably long, if so."""
    if (matrix := 8.0 * nodes**2) > DIRECT_MEMORY:
        yield (
            f"direct partition of {nodes} nodes takes a matrix of {matrix / 2**30:.1f} GiB, "
            f"allowed are {DIRECT_MEMORY / 2**30:.1f} GiB: points at high loads will fail; "
            "take partition = 'local'"
        )
    elif seconds > _LONG:
        yield (
            f"direct partition of {nodes} nodes takes about {seconds:.0f} s a temperature; "
            "partition = 'local' gives the same within heat_tolerance"
        )


def _disk_bytes(sweep: Sweep) -> float:
    """Size of the store, uncompressed [B]; each field of a point has a file of its own."""
    each = min(2, len(sweep.velocities)) if sweep.samples else len(sweep.velocities)
    variants, loads = len(sweep.simulated), len(sweep.loads)
    points = variants * loads * each
    nx, ny = sweep.grid.shape
    sizes = {
        "step": max(step_count(sweep, load) for load in sweep.loads),
        "quantile": len(QUANTILES),
        "bulk_ratio": len(BULK_RATIOS),
        "x": nx,
        "y": ny,
    }
    blocks = 0
    for name, kind in variables(None, sweep.store_fields, sweep.unequal_bulks, {}).items():
        if not is_coordinate(name):
            of_a_point = 8 * math.prod(sizes[dim] for dim in kind.dims[2:])
            files = points if name in AT_END else 1 + variants // 64
            blocks += files * math.ceil(points * of_a_point / files / _BLOCK)
    return float(_BLOCK * blocks)


def _idle_rows(sweep: Sweep, contact_rows: int) -> Iterator[str]:
    """Rows of elements that no transform along y is needed for."""
    nx, _ = sweep.grid.shape
    if contact_rows < nx and not sweep.is_plane:
        yield (
            f"transforms along y of {nx - contact_rows} of {nx} rows of elements, which carry "
            f"nothing even at {max(sweep.loads):g} N"
        )
