"""Rough cost of a sweep before it runs: time, from a few timed steps, and memory."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import psutil

from pipeline.kinds import WORKERS
from pipeline.scene.scene_file import SceneLike, sweep_of
from pipeline.scene.variants import expected_variants
from pipeline.sweep.plan import Task, choose_stored_steps, tasks, with_sweep_of_tests
from pipeline.sweep.plan import points as points_of
from pipeline.sweep.sweep import Sweep
from tribo import Scene
from tribo.simulation import RampCache, contacts, fit_elements, heat
from tribo.simulation.ramp_cache import MOST_BYTES

_SECONDS_TO_START = 1.0  # to start a cluster and its workers
_SECONDS_TO_COMMIT = 0.005  # to schedule and write a point
_WORKER_BYTES = 115e6  # interpreter and libraries
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_FIELDS_OF_STATE = 3  # arrays cached for each increment of a ramp
_MAX_PIXELS = 2e7  # largest surface that is generated for an estimate
_TIMING_LIMIT = 1.0  # [s] of processor time after which no further step is timed


@dataclass(frozen=True, slots=True)
class Estimate:
    """Expected cost of a sweep: numbers of points and tasks, and time."""

    points: int  #: Points of the diagram.
    tests: int  #: Points of the scene's tests, which are computed first.
    uncertain: int  #: Points for uncertain inputs, which are computed last.
    tasks: int  #: Parallel tasks, also the largest useful number of workers.
    workers: int  #: Processes that compute.
    seconds: float  #: Rough wall time on an idle machine, from steps timed on this machine [s].


@np.errstate(under="ignore")
def estimate(sweep: SceneLike, workers: int | None = None) -> Estimate:
    """Estimate the cost of a whole sweep, by timing a few of its steps on this machine.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path or name.
    workers : int, optional
        Number of processes; one for each core if not given.

    Raises
    ------
    InputError
        If `workers` is below 1.
    TriboError
        If a load has no solution.

    Examples
    --------
    >>> import pipeline
    >>> cost = pipeline.estimate("first_try", workers=1)
    >>> cost.points
    24
    """
    from dask.system import cpu_count  # takes 0.14 s

    if workers is not None:
        workers = WORKERS.argument("workers", workers)
    sweep, available = sweep_of(sweep), cpu_count()
    workers = workers or available
    cases = sweep.case_table.without_surfaces.names
    scene = sweep.select_case(cases[len(cases) // 2])
    times = _time_steps(scene)
    seconds = _SECONDS_TO_START
    counts = list[int]()
    variants = expected_variants(sweep)
    for part in with_sweep_of_tests(replace(sweep, variants=variants)):
        part_tasks = [*tasks(points_of(part), part)]
        counts.append(len(part_tasks))
        parallel = min(workers, counts[-1])
        busy = max(1.0, parallel / available)
        seconds += busy * _task_seconds(part, part_tasks, *times) / parallel
    return Estimate(
        points=counts[0],
        tests=sum(counts[1:]) - len(variants),
        uncertain=len(variants),
        tasks=counts[0],
        workers=workers,
        seconds=seconds,
    )


def _task_seconds(
    sweep: Sweep, sweep_tasks: Iterable[Task], contact_time: float, heat_time: float
) -> float:
    """Time of tasks in sequence [s]; tasks of one ramp share its steps."""
    stored, seconds = choose_stored_steps(sweep), 0.0
    for _, ramp_tasks in itertools.groupby(sweep_tasks, key=lambda task: task.ramp):
        points = [task.point for task in ramp_tasks]  # their loads ascend
        load, velocity, case = points[-1]
        scene = sweep.case(case).scene
        steps = len([*scene.load_steps(load, stored.heat_steps(scene, load))])
        stored_counts = [len(stored.select(scene, point.load)) for point in points]
        if stored.steps == "course":  # on the grid of the history, and on that of the point
            solved, heated = 2 * steps + len(points), stored_counts[-1] + len(points)
        else:
            solved, heated = steps + len(points), sum(stored_counts)
        heated *= bool(scene.friction_heat and velocity)
        seconds += solved * contact_time + heated * heat_time + len(points) * _SECONDS_TO_COMMIT
    return seconds


def machine_memory() -> int:
    """Memory that this process may use, by a container's limit, too [B]."""
    limits = [int(psutil.virtual_memory().total)]
    with suppress(OSError, ValueError):  # "max" is no limit
        limits.append(int(Path("/sys/fs/cgroup/memory.max").read_text()))
    return min(limits)


def worker_bytes(sweep: Sweep) -> float:
    """Memory that a worker needs [B], including the results of steps kept for reuse."""
    scene = _fitted_scene(sweep)
    coarse, *finer = scene.levels()
    cached_levels = (
        [coarse, *finer[-1:]] if choose_stored_steps(sweep).steps == "course" else [coarse]
    )
    elements = sum(math.prod(level.grid.shape) for level in cached_levels)
    ramp_bytes = scene.fidelity.increments * _FIELDS_OF_STATE * 8.0 * elements
    cache_bytes = min(MOST_BYTES, ramp_bytes) if scene.wears else 0.0
    return _WORKER_BYTES + _FIELDS_IN_MEMORY * 8.0 * math.prod(scene.grid.shape) + cache_bytes


def _fitted_scene(sweep: Sweep) -> Scene:
    """Scene with the elements that a simulation would choose at the sweep's lowest load.

    If there are very many pixels, elements are single pixels instead.
    """
    scene = sweep.scene
    if math.prod(scene.pixels.shape) <= _MAX_PIXELS:
        return fit_elements(scene, min(sweep.loads))
    finest = replace(scene.fidelity, pixels_per_element=1, fewest_elements=0)
    return replace(scene, fidelity=finest)


def _time_steps(sweep: Sweep) -> tuple[float, float]:
    """Mean CPU times [s] of a contact and of a heat solution, from some steps of a sweep."""
    moving = [velocity for velocity in sweep.velocities if velocity] or [0.0]
    velocity = moving[len(moving) // 2]
    contact_times, heat_times, ramp_cache = list[float](), list[float](), RampCache()
    ramps = (contacts(sweep.scene, load, velocity, ramp_cache) for load in sweep.loads)
    began = time.process_time()
    for state in itertools.chain.from_iterable(ramps):
        if not state.pressure.any():
            continue
        contact_times.append(time.process_time() - began)
        began = time.process_time()
        if state.is_requested and state.heat is None:
            heat(sweep.scene, state, velocity)
            heat_times.append(time.process_time() - began)
        if state.is_requested and sum(contact_times) + sum(heat_times) > _TIMING_LIMIT:
            break
        began = time.process_time()
    return float(np.mean(contact_times)), float(np.mean(heat_times or 0.0))
