"""Forecast of the cost of a sweep: time, memory and disk, and what work it is spared."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from pipeline.scene.quantities import require_count
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import points as points_of
from pipeline.sweep.plan import stacked_columns, step_count
from pipeline.sweep.stations import Stations
from tribo import State
from tribo.simulation import contacts, forget_contacts, heat, leads_to

_HERE = 4  # workers a core; more of them are taken to be on other machines
_SECONDS_TO_START = 1.0  # of a cluster and its workers
_SECONDS_TO_COMMIT = 0.005  # of scheduling a point and writing it
_WORKER_BYTES = 115e6  # interpreter and libraries
_PACKED = 0.35  # of a field in single precision is left by zstd: 0.355 of first_try at draft
_STORE_BYTES = 0.36e6  # of a store without points: some 30 arrays, a folder and two files each
_HALF_BLOCK = 2048  # of the disk, which the end of each file leaves empty
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_PATIENCE = 3.0  # [s] of processor time, after which no further point is timed
_SPAN = 0.35  # logarithm of the ratio of two velocities that enclose a boundary


@dataclass(frozen=True, slots=True)
class Estimate:
    """Cost of a sweep.

    Attributes
    ----------
    points, steps, temperatures : int
        Points of the diagram; contacts and heat partitions to solve for them. Without wear each
        worker solves the contact at a load once for all velocities.
    chains : int
        Chains of points, each of which one worker computes at a time: more workers are idle.
    workers : int
        Processes that compute.
    seconds : float
        Wall time on an idle machine [s]; with many more workers than it has cores, that of workers
        elsewhere which have a core each.
    basis : str
        Measurement from which the time is predicted.
    worker_bytes, disk_bytes : float
        Memory of each worker; room that the store takes on a disk [B].

    Examples
    --------
    >>> import pipeline
    >>> cost = pipeline.estimate("first_try", workers=1)
    >>> cost.chains, cost.steps, cost.disk_bytes < 10e6
    (6, 42, True)
    """

    points: int
    steps: int
    temperatures: int
    chains: int
    workers: int
    seconds: float
    basis: str
    worker_bytes: float
    disk_bytes: float

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
    if searched := boundary_only:
        sweep.require_search()
    velocities = _searched(sweep) if searched else len(every)
    ramps = velocities * variants
    loads = len(sweep.plane.loads)
    points = min(2, velocities) * loads * variants if searched else len(points_of(sweep))
    moving = sum(velocity != 0 for velocity in every) * sweep.scene.friction_heat
    names, given = sweep.variants.names, list(sweep.variants.given)
    scene = sweep.variant(given[len(given) // 2])
    # Rows that share a contact; of these, those with one velocity and scene share its heat, too.
    shared = Fraction(len(names), len({lead.variant for lead in sweep.leads.values()}))
    alike = len({sweep.variant(name).scene for name in names}) / len(names) if variants > 1 else 1.0
    timed, steps = _timed(scene), list(_steps_of_ramp(scene))
    if searched:  # each velocity is looked at for some of the loads alone
        moving = min(moving, velocities)
        steps = [step for step in steps if step[0] <= np.median(sweep.plane.loads)]
    heated = sum(is_heated for _, is_heated in steps)
    chains = math.ceil((points if sweep.plane.independent else ramps) / shared)
    parallel, of_contacts = min(workers, chains), math.ceil(ramps / shared)
    turns = of_contacts / parallel if sweep.plane.independent else math.ceil(of_contacts / parallel)
    alone = (
        turns
        * float(shared)
        * (alike * heated * timed.heat + len(sweep.plane.loads) * _SECONDS_TO_COMMIT)
    )
    if not sweep.scene.remembers_steps:  # workers keep those of the first velocity
        of_contacts = min(of_contacts, parallel * variants)
        turns = min(turns, variants)
    alone += timed.begin * variants + turns * len(steps) * timed.contact
    basis = "mostly right within a factor of 1.5 on an idle machine, from steps timed just now"
    seconds = _SECONDS_TO_START + alone * max(1.0, parallel / cores)
    if workers > _HERE * cores:
        seconds = _SECONDS_TO_START + alone
        basis += "; for workers that have a core each, as fast as those here"
    return Estimate(
        points=points,
        steps=len(steps) * of_contacts,
        temperatures=round(alike * heated * moving * variants),
        chains=chains,
        workers=workers,
        seconds=seconds,
        basis=basis,
        worker_bytes=max(worker_bytes(sweep.variant(name)) for name in given),
        disk_bytes=_STORE_BYTES + points * _point_bytes(scene, timed.state),
    )


def worker_bytes(sweep: Sweep) -> float:
    """Memory of a worker [B]."""
    return _WORKER_BYTES + _FIELDS_IN_MEMORY * 8.0 * math.prod(sweep.scene.grid.shape)


def machine_bytes() -> float:
    """Memory of this machine [B]; infinite where that is not known."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return math.inf


class _Timed(NamedTuple):
    """Processor times [s], and a state as high as they lead to."""

    begin: float  # of a worker's first step, beyond that of later ones
    contact: float  # of a step
    heat: float  # of the temperature of a contact
    state: State


def _timed(sweep: Sweep) -> _Timed:
    """Compute a ramp here and now: its first point, and more if it is fast."""
    moving = [velocity for velocity in sweep.plane.velocities if velocity] or [0.0]
    velocity, firsts = moving[len(moving) // 2], []
    for _ in ("cold", "warm"):
        state, taken = next(_clocked(sweep, velocity * 1.01))
        firsts.append(taken + _heat_seconds(sweep, state, velocity * 1.01))
        forget_contacts()
    of_contacts, of_heat = list[float](), list[float]()
    for state, taken in _clocked(sweep, velocity):
        of_contacts.append(taken)
        if state.is_asked and state.heat is None:
            of_heat.append(_heat_seconds(sweep, state, velocity))
        if state.is_asked and sum(of_contacts) + sum(of_heat) > _PATIENCE:
            break
    begin, contact = max(0.0, firsts[0] - firsts[1]), float(np.mean(of_contacts))
    return _Timed(begin, contact, float(np.mean(of_heat or 0.0)), state)


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


def _heat_seconds(sweep: Sweep, state: State, velocity: float) -> float:
    """Processor time of the temperature of a contact [s]."""
    began = time.process_time()
    heat(sweep.scene, state, velocity)
    return time.process_time() - began


def _searched(sweep: Sweep) -> int:
    """Number of velocities that the search for a boundary takes at all loads together, about."""
    moving = [velocity for velocity in sweep.plane.velocities if velocity > 0]
    spans = math.log(moving[-1] / moving[0]) / _SPAN if moving else 0.0
    return min(2 * len(sweep.plane.loads), math.ceil(spans) + 1)


def _steps_of_ramp(sweep: Sweep) -> Iterator[tuple[float, bool]]:
    """Load of each step at one velocity, and whether it is given its temperature."""
    stations, shared, trunk = Stations.of(sweep), 0.0, 0.0
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
    stations = Stations.of(sweep)
    numbers: int = sum(column[0].size for column in stacked_columns(sweep, [state]).values())
    fields = (3 + sweep.scene.unequal_bulks) * sweep.record.fields
    field = 4.0 * _PACKED * math.prod(sweep.scene.grid.shape) + _HALF_BLOCK
    stored = 8.0 * numbers * max(stations.count(sweep.scene, load) for load in sweep.plane.loads)
    return stored + fields * field


def savings(sweep: Sweep) -> Iterator[str]:
    """Say in a line each which work is saved that another scene would need, and why."""
    nx, ny = sweep.scene.grid.shape
    steps = max(step_count(sweep.scene, load) for load in sweep.plane.loads)
    if sweep.scene.is_plane:
        rows = sweep.scene.rows_per_element
        yield f"the axis y, since both bodies are smooth ({nx} × 1 elements, not {nx} × {rows})"
    increments = sum(
        1
        for _ in sweep.scene.loading.stations(
            max(sweep.plane.loads), sweep.scene.fidelity.increments
        )
    )
    if steps < increments:
        yield f"{increments - steps} of {increments} steps, since nothing wears between them"
    if sweep.scene.wear is None:
        yield "wear, since the scene has no table [wear]"
    if not math.isfinite(sweep.scene.hardness):
        yield "the upper bound on the pressure, since no body has a hardness"
    still = sum(velocity == 0 for velocity in sweep.plane.velocities)
    if not sweep.scene.friction_heat:
        yield "heat, since the friction coefficient is 0"
    elif still:
        points = still * len(sweep.plane.loads) * len(sweep.variants.names)
        yield f"heat at {points} points, since nothing moves there"
    is_end = Stations.of(sweep).interval is None
    if is_end and steps > 1 and sweep.scene.friction_heat and not sweep.scene.remembers_heat:
        yield f"temperatures before the last step (up to {steps - 1} a point)"
    if sweep.scene.coarsening > 1:
        factor = sweep.scene.coarsening
        yield f"wear before the last step on a coarser grid ({nx // factor} × {ny // factor})"
    if not sweep.record.fields:
        megabytes = 24e-6 * nx * ny * len(sweep.plane.loads) * sweep.ramps
        yield f"fields, since the scene does not ask for them (up to {megabytes:.0f} MB)"
