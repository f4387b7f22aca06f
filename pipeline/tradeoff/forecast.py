"""Foretells what a sweep will cost: time, memory and disk."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.scene.quantities import require_count
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.stages import duration
from tribo import (
    BULK_RATIOS,
    QUANTILES,
    State,
    advance,
    heat,
    measures,
    simulate,
    start,
)
from tribo.simulation import forget_contacts
from tribo.thermal import DIRECT_MEMORY

_HERE = 4  # workers a core; more of them are taken to be on other machines
_SECONDS_TO_START = 1.0  # of a cluster and its workers
_SECONDS_TO_COMMIT = 0.005  # of scheduling a point and writing it
_WORKER_BYTES = 115e6  # interpreter and libraries
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_EARLY = 0.25  # of the lowest load, up to which heated steps are timed from the start on
_PATIENCE = 3.0  # [s] of CPU time that this may take
_STEPS = 5  # timed below a load; the first two are not yet extrapolated from earlier ones
_NODES = 1280  # of the elimination that is timed
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
        Wall time, as long as the machine stays as busy as it is [s]; with many more workers than
        it has cores, that of workers elsewhere which have a core each.
    basis : str
        Measurement from which the time is foretold.
    worker_bytes, disk_bytes : float
        Memory of each worker; size of the store, uncompressed [B].
    warnings : tuple of str
        Points that will fail.

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
    warnings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)


def estimate(sweep: SceneLike, workers: int | None = None, boundary_only: bool = False) -> Estimate:
    """Estimate the cost of a whole sweep, from a few of its steps done here and now.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path or name.
    workers : int, optional
        Number of processes; one for each core if not given.
    boundary_only : bool
        True if velocities are chosen on the way, not computed all.

    Raises
    ------
    InputError
        If there is to be no worker.
    TriboError
        If the highest load has no solution.

    Examples
    --------
    >>> import pipeline
    >>> cost = pipeline.estimate("first_try", workers=1)
    >>> cost.points
    24
    """
    if workers is not None:
        require_count("workers", workers)
    sweep, cores = sweep_of(sweep), os.cpu_count() or 1
    if sweep.over:
        return _of_scenes(sweep, workers, boundary_only)
    workers, variants = workers or cores, 1 if sweep.samples else len(sweep.variants)
    searched = boundary_only and not sweep.samples
    velocities = _searched(sweep) if searched else sweep.ramps // variants
    ramps = velocities * variants
    points = (min(2, velocities) if searched else velocities) * len(sweep.loads) * variants
    moving = sum(velocity != 0 for velocity in sweep.velocities) if sweep.friction_heat else 0
    shared, surfaces = 1, variants  # samples that share a contact
    if sweep.samples:
        moving, shared, surfaces = ramps, sweep.samples.design.per_contact, 1
        variants = math.ceil(ramps / shared)
    steps = list(_steps_of_ramp(sweep))
    if searched:  # each velocity is looked at for some of the loads alone
        moving = min(moving, velocities)
        steps = [step for step in steps if step[0] <= np.median(sweep.loads)]
    timed, begin = _timed_loads(sweep)
    heated = [load for load, is_heated in steps if is_heated]
    unheated = [load for load, is_heated in steps if not is_heated]
    at_rates = [load for load in heated if load in sweep.loads] * len(sweep.rates)
    contacts_and_heat = _seconds(timed, "step", unheated) + _seconds(timed, "end", heated)
    heat_alone = _seconds(timed, "heat", heated)
    ramp = heat_alone + (contacts_and_heat - heat_alone) / shared
    ramp += _seconds(timed, "heat", at_rates)
    chains = points if sweep.independent else ramps
    parallel = min(workers, chains)
    ramps_of_contacts = math.ceil(ramps / shared)
    # Workers keep the contacts of the first velocity.
    if not sweep.remembers_steps and not sweep.samples:
        ramps_of_contacts = min(ramps, parallel * variants)
        begin += _seconds(timed, "contact", [load for load, _ in steps])
    turns = ramps / parallel if sweep.independent else math.ceil(ramps / parallel)
    alone = begin * variants + turns * (ramp + len(sweep.loads) * _SECONDS_TO_COMMIT)
    busy = min(os.getloadavg()[0], cores) if hasattr(os, "getloadavg") else 0.0
    elsewhere = workers > _HERE * cores
    seconds, idle = (
        _SECONDS_TO_START + alone * (1.0 if elsewhere else max(1.0, (others + parallel) / cores))
        for others in (busy, 0.0)
    )
    highest = timed[max(timed)].state
    nodes = int(np.count_nonzero(highest.pressure))
    basis = f"mostly right within a factor of 1.5, from steps at {len(timed)} loads timed just now"
    if elsewhere:
        basis += "; for workers that have a core each, as fast as those here"
    if seconds > 1.1 * idle:
        basis += f"; other programs use {busy:.2g} of {cores} cores, without them {duration(idle)}"
    return Estimate(
        points=points,
        steps=len(steps) * ramps_of_contacts,
        temperatures=(len(heated) + len(at_rates)) * moving * surfaces,
        chains=chains,
        workers=workers,
        seconds=seconds,
        basis=basis,
        worker_bytes=worker_bytes(sweep, nodes),
        disk_bytes=points * _point_bytes(sweep, highest),
        warnings=tuple(_too_many_nodes(sweep, nodes)) if moving else (),
    )


def _of_scenes(sweep: Sweep, workers: int | None, boundary_only: bool) -> Estimate:
    """Cost of a sweep over entries, from that of some of its scenes."""
    count, ramps = len(sweep.entries), len(set(sweep.over.leads.values())) if sweep.over else 1
    tried = dict.fromkeys((0, count // 2, count - 1))
    costs = [
        estimate(sweep.variant(sweep.entries[number]), workers, boundary_only) for number in tried
    ]

    def total(name: str, scenes: int) -> float:
        return float(scenes * np.mean([getattr(cost, name) for cost in costs]))

    started = total("seconds", ramps) - (ramps - 1) * _SECONDS_TO_START
    return replace(
        costs[0],
        points=round(total("points", count)),
        steps=round(total("steps", ramps)),
        temperatures=round(total("temperatures", count)),
        chains=round(total("chains", ramps)),
        seconds=max(started, costs[0].seconds),
        worker_bytes=max(cost.worker_bytes for cost in costs),
        disk_bytes=total("disk_bytes", count),
        warnings=tuple(dict.fromkeys(line for cost in costs for line in cost.warnings)),
    )


def worker_bytes(sweep: Sweep, contact_nodes: int = 0) -> float:
    """Memory of a worker [B]; elements in contact count for the direct heat partition alone."""
    direct = sweep.fidelity.partition == "direct" and sweep.friction_heat
    matrix = 8.0 * contact_nodes**2 if direct else 0.0
    return _WORKER_BYTES + _FIELDS_IN_MEMORY * 8.0 * math.prod(sweep.grid.shape) + matrix


def machine_bytes() -> float:
    """Memory of this machine [B]; infinite where that is not known."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return math.inf


class _Timed(NamedTuple):
    """CPU time of a step without a temperature and with one [s], and the last state.

    Where the scene remembers no step, both are without the contact, which takes its own time once.
    Heat on a contact that is there takes its own time, for samples and other wear rates.
    """

    step: float
    end: float
    state: State
    contact: float = 0.0
    heat: float = 0.0


def _timed_loads(sweep: Sweep) -> tuple[dict[float, _Timed], float]:
    """Steps at the highest, lowest and middle load, and what a worker does once [s]."""
    direct = sweep.fidelity.partition == "direct"
    if direct:  # which is timed on a smaller matrix
        sweep = replace(sweep, fidelity=replace(sweep.fidelity, partition="local"))
    moving = sorted((velocity for velocity in sweep.velocities if velocity), key=abs)
    velocity = math.sqrt(abs(moving[0] * moving[-1])) if moving else 0.0
    top, began = sweep.loads[-1], time.process_time()
    _timed(sweep, top, velocity)
    cold, began = time.process_time() - began, time.process_time()
    forget_contacts()
    timed = {top: _timed(sweep, top, velocity)}
    begin = max(0.0, cold - (time.process_time() - began))
    for load in (sweep.loads[0], sweep.loads[len(sweep.loads) // 2]):
        if load not in timed:
            timed[load] = _timed(sweep, load, velocity)
    timed |= _timed_early(sweep, velocity)
    if direct:
        began = time.process_time()
        np.linalg.solve(np.eye(_NODES) + 0.5, np.ones(_NODES))
        taken = time.process_time() - began
        for load, cost in timed.items():
            share = np.count_nonzero(cost.state.pressure) / _NODES
            timed[load] = cost._replace(end=float(cost.step + taken * share**3))
    return timed, begin


def _seconds(timed: Mapping[float, _Timed], name: str, loads: Sequence[float]) -> float:
    """Time of steps at some loads [s], by one of the times of those that were timed."""
    places, costs = zip(*sorted(timed.items()), strict=True)
    return float(np.interp(loads, places, [getattr(cost, name) for cost in costs]).sum())


def _timed(sweep: Sweep, load: float, velocity: float) -> _Timed:
    """Time the last steps up to a load, from a state a few steps below that one step leads to."""
    trunk = [station for station in sweep.stations(load) if station.on_trunk]
    before = None
    if len(trunk) > _STEPS:
        scene = next(sweep.levels())
        if scene.fidelity.wear_scheme == "explicit":  # unstable in so long a step
            scene = replace(scene, fidelity=replace(scene.fidelity, wear_scheme="implicit"))
        before = advance(scene, start(scene), trunk[-_STEPS], velocity)
    first = _timed_from(sweep, load, velocity, before)
    if sweep.remembers_steps:
        return first
    again = _timed_from(sweep, load, velocity, before)
    return again._replace(contact=max(0.0, first.end - again.end))


def _clocked(states: Iterable[State]) -> Iterator[tuple[State, float]]:
    """States of a simulation, each with the CPU time that it took [s]."""
    began = time.process_time()
    for state in states:
        now = time.process_time()
        yield state, now - began
        began = now


def _timed_from(sweep: Sweep, load: float, velocity: float, before: State | None) -> _Timed:
    """Time each step from a state up to a load."""
    states = list(_clocked(simulate(sweep, load, velocity, before)))
    end = float(np.median([taken for state, taken in states if state.heat]))
    steps = [taken for state, taken in states[2:] if not state.heat]
    state, began, again = states[-1][0], time.process_time(), 0.0
    if sweep.rates or sweep.samples:
        heat(sweep, state, velocity * 1.1)
        again = time.process_time() - began
    return _Timed(float(np.median(steps)) if steps else end, end, state, heat=again)


def _timed_early(sweep: Sweep, velocity: float) -> dict[float, _Timed]:
    """The first steps of the ramp on average, and the last of them, where they are heated.

    While few elements touch, a step is computed once more on smaller ones.
    """
    early = _EARLY * sweep.loads[0]
    if not any(is_heated and load < early for load, is_heated in _steps_of_ramp(sweep)):
        return {}
    steps, ends = [0.0], [0.0]
    for state, taken in _clocked(simulate(sweep, sweep.loads[0], velocity)):
        (ends if state.heat else steps).append(taken)
        if state.normal_load > early or sum(steps + ends) > _PATIENCE:
            break
    count, heated = max(1, len(steps) - 1), max(1, len(ends) - 1)
    mean = _Timed(sum(steps) / count, sum(ends) / heated, state)
    return {
        state.normal_load: mean,
        state.normal_load * (1 + 1e-9): mean._replace(step=steps[-1], end=ends[-1]),
    }


def _searched(sweep: Sweep) -> int:
    """Number of velocities that the search for a boundary takes at all loads together, about."""
    moving = [velocity for velocity in sweep.velocities if velocity > 0]
    spans = math.log(moving[-1] / moving[0]) / _SPAN if moving else 0.0
    return min(2 * len(sweep.loads), math.ceil(spans) + 1)


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


def _point_bytes(sweep: Sweep, state: State) -> float:
    """Size of a point in the store [B]."""
    numbers = len(measures(sweep, state)) + len(QUANTILES)
    numbers += len(sweep.rates) * (len(QUANTILES) + 2)
    if sweep.unequal_bulks:
        numbers += len(BULK_RATIOS) * len(QUANTILES)
    fields = (3 + sweep.unequal_bulks) * math.prod(sweep.grid.shape) * sweep.store_fields
    return 8.0 * (numbers * max(step_count(sweep, load) for load in sweep.loads) + fields)


def _too_many_nodes(sweep: Sweep, nodes: int) -> Iterator[str]:
    """Warn of a direct heat partition whose matrix is refused."""
    if sweep.fidelity.partition == "direct" and (matrix := 8.0 * nodes**2) > DIRECT_MEMORY:
        yield (
            f"direct partition of {nodes} nodes takes a matrix of {matrix / 2**30:.1f} GiB, "
            f"allowed are {DIRECT_MEMORY / 2**30:.1f} GiB: points at high loads will fail; "
            "take partition = 'local'"
        )
