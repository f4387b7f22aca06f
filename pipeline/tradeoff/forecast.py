"""Rough forecast of the cost of a sweep: time, memory and disk, and what work it is spared."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import require_count
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import points as points_of
from pipeline.sweep.plan import record_at, step_count
from pipeline.sweep.station_choice import choose_stations
from tribo import State
from tribo.simulation import contacts, heat, leads_to

_SECONDS_TO_START = 1.0  # of a cluster and its workers
_SECONDS_TO_COMMIT = 0.005  # of scheduling a point and writing it
_WORKER_BYTES = 115e6  # interpreter and libraries
_PACKED = 0.35  # of a field in single precision is left by zstd: 0.355 of first_try at draft
_STORE_BYTES = 0.36e6  # of a store without points: some 30 arrays, a folder and two files each
_HALF_BLOCK = 2048  # of the disk, which the end of each file leaves empty
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_PATIENCE = 3.0  # [s] of processor time, after which no further step is timed


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cost of a sweep."""

    points: int  #: Points of the diagram.
    steps: int  #: Contacts to solve for them.
    temperatures: int  #: Heat partitions to solve for them.
    chains: int  #: Chains of points, one worker each: more workers are idle.
    workers: int  #: Processes that compute.
    seconds: float  #: Wall time on an idle machine, roughly, by steps timed here and now [s].
    worker_bytes: float  #: Memory of each worker [B].
    disk_bytes: float  #: Room that the store takes on a disk [B].

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)


def estimate(
    sweep: SceneLike,
    workers: int | None = None,
    boundary_only: bool = False,
    own_laws: bool = False,
) -> Estimate:
    """Estimate the cost of a whole sweep, from a few of its steps done here and now.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path or name.
    workers : int, optional
        Number of processes; one for each core if not given.
    boundary_only : bool
        True if velocities are chosen on the way, not computed all.
    own_laws : bool
        See `pipeline.load_scene`.

    Raises
    ------
    InputError
        If there is to be no worker.
    TriboError
        If a load has no solution.

    Examples
    --------
    >>> import pipeline
    >>> cost = pipeline.estimate("first_try", workers=1)
    >>> cost.points
    24
    """
    if workers is not None:
        require_count("workers", workers)
    sweep, cores = sweep_of(sweep, own_laws), os.cpu_count() or 1
    workers, (every, variants) = workers or cores, sweep.lines
    if boundary_only:
        sweep.require_search()
    loads, names = len(sweep.plane.loads), sweep.variants.names
    # A search takes two velocities at each load, of which neighbouring loads share one.
    velocities = min(len(every), loads + 1) if boundary_only else len(every)
    points = min(2, velocities) * loads * variants if boundary_only else len(points_of(sweep))
    given = list(sweep.variants.given)
    scene = sweep.variant(given[len(given) // 2])
    shared = len(names) / len({lead.variant for lead in sweep.leads.values()})
    moving = sum(velocity != 0 for velocity in every) * sweep.scene.friction_heat
    steps, (contact_time, heat_time, state) = list(_steps_of_ramp(scene)), _timed(scene)
    if boundary_only:  # each velocity is looked at for some of the loads alone
        moving = min(moving, velocities)
        steps = [step for step in steps if step[0] <= np.median(sweep.plane.loads)]
    heated = sum(is_heated for _, is_heated in steps)
    ramps = math.ceil(velocities * variants / shared)
    chains = math.ceil(points / shared) if sweep.plane.independent else ramps
    parallel = min(workers, chains)
    if not sweep.scene.remembers_steps:  # workers keep the contacts of the first velocity
        ramps = min(ramps, parallel * variants)
    turns = max(1.0, ramps / parallel) if sweep.plane.independent else math.ceil(ramps / parallel)
    of_heat = math.ceil(velocities * variants / parallel) * heated * heat_time
    commits = loads * velocities * variants / parallel * _SECONDS_TO_COMMIT
    alone = turns * len(steps) * contact_time + of_heat + commits
    return Estimate(
        points=points,
        steps=len(steps) * ramps,
        temperatures=heated * moving * variants,
        chains=chains,
        workers=workers,
        seconds=_SECONDS_TO_START + alone * max(1.0, parallel / cores),
        worker_bytes=max(worker_bytes(sweep.variant(name)) for name in given),
        disk_bytes=_STORE_BYTES + points * _point_bytes(scene, state),
    )


def worker_bytes(sweep: Sweep) -> float:
    """Memory of a worker [B]."""
    return _WORKER_BYTES + _FIELDS_IN_MEMORY * 8.0 * math.prod(sweep.scene.grid.shape)


def _timed(sweep: Sweep) -> tuple[float, float, State]:
    """Times of a contact and of a temperature on a ramp [s], and the state as far as it is fast."""
    moving = [velocity for velocity in sweep.plane.velocities if velocity] or [0.0]
    velocity = moving[len(moving) // 2]
    of_contacts, of_heat = list[float](), list[float]()
    for state, taken in _clocked(sweep, velocity):
        of_contacts.append(taken)
        if state.is_asked and state.heat is None:
            began = time.process_time()
            heat(sweep.scene, state, velocity)
            of_heat.append(time.process_time() - began)
        if state.is_asked and sum(of_contacts) + sum(of_heat) > _PATIENCE:
            break
    return float(np.mean(of_contacts)), float(np.mean(of_heat or 0.0)), state


def _clocked(sweep: Sweep, velocity: float) -> Iterator[tuple[State, float]]:
    """Contacts of a ramp through all loads, each with the processor time that it took [s]."""
    trunk, began = None, time.process_time()
    for load in sweep.plane.loads:
        if trunk and (sweep.plane.independent or not leads_to(sweep.scene, trunk, load)):
            trunk = None
        for state in contacts(sweep.scene, load, velocity, trunk):
            if state.pressure.any():
                yield state, time.process_time() - began
                began = time.process_time()
            if state.on_trunk:
                trunk = state.history or replace(state, heat=None)


def _steps_of_ramp(sweep: Sweep) -> Iterator[tuple[float, bool]]:
    """Load of each step at one velocity, and whether it is given its temperature."""
    stations, shared, trunk = choose_stations(sweep), 0.0, 0.0
    loads = {load for load in stations.loads if load < sweep.plane.loads[-1]}
    for load in sorted(loads.union(sweep.plane.loads)):
        if sweep.scene.trunk(load) != shared:
            shared, trunk = sweep.scene.trunk(load), 0.0
        asked = stations.asked(sweep.scene, load)
        steps = list(sweep.scene.stations(load, trunk, asked))
        for station in steps:
            reached = station.normal_load == load and not station.holding
            is_shown = reached or station is steps[-1] or station.index in asked
            yield station.normal_load, is_shown or sweep.scene.remembers_heat
            if station.on_trunk and not sweep.plane.independent:
                trunk = station.normal_load


def _point_bytes(sweep: Sweep, state: State) -> float:
    """Size of a point in the store [B]."""
    stations = choose_stations(sweep)
    numbers = sum(np.size(value) for value in record_at(sweep, state).values())
    fields = (3 + sweep.scene.unequal_bulks) * sweep.record.fields
    field = 4.0 * _PACKED * math.prod(sweep.scene.grid.shape) + _HALF_BLOCK
    stored = 8.0 * numbers * max(stations.count(sweep.scene, load) for load in sweep.plane.loads)
    return stored + fields * field


def savings(sweep: Sweep) -> Iterator[str]:
    """Lines on the work that this scene does not need, each with the reason."""
    scene, plane = sweep.scene, sweep.plane
    nx, ny = scene.grid.shape
    steps = max(step_count(scene, load) for load in plane.loads)
    if scene.is_plane:
        rows = scene.rows_per_element
        yield f"the axis y, since both bodies are smooth ({nx} × 1 elements, not {nx} × {rows})"
    increments = len([*scene.loading.stations(max(plane.loads), scene.fidelity.increments)])
    if steps < increments:
        yield f"{increments - steps} of {increments} steps, since nothing wears between them"
    if scene.wear is None:
        yield "wear, since the scene has no table [wear]"
    if not math.isfinite(scene.hardness):
        yield "the upper bound on the pressure, since no body has a hardness"
    if not scene.friction_heat:
        yield "heat, since the friction coefficient is 0"
    elif still := sum(velocity == 0 for velocity in plane.velocities):
        points = still * len(plane.loads) * len(sweep.variants.names)
        yield f"heat at {points} points, since nothing moves there"
    stations = choose_stations(sweep)
    is_end = stations.interval is None and not stations.judges_hold
    if is_end and steps > 1 and scene.friction_heat and not scene.remembers_heat:
        yield f"temperatures before the last step (up to {steps - 1} a point)"
    if scene.coarsening > 1:
        factor = scene.coarsening
        yield f"wear before the last step on a coarser grid ({nx // factor} × {ny // factor})"
    if not sweep.record.fields:
        megabytes = 24e-6 * nx * ny * len(plane.loads) * sweep.ramps
        yield f"fields, since the scene does not ask for them (up to {megabytes:.0f} MB)"
