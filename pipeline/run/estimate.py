"""Rough cost of a sweep before it runs: time, memory and disk, from a few timed steps."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pipeline.machine import cores
from pipeline.scene.read import SceneLike, sweep_of
from pipeline.sweep.plan import Task, choose_stored_steps, record_at, tasks
from pipeline.sweep.plan import points as points_of
from pipeline.sweep.points_of_tests import list_points_of_tests, sweep_of_tests
from pipeline.sweep.stored_steps import StoredSteps
from pipeline.sweep.sweep import Sweep
from pipeline.units import require_count
from tribo import Scene, Stages, State
from tribo.simulation import RampCache, contacts, fit_elements, heat
from tribo.simulation.ramp_cache import MOST_BYTES

_SECONDS_TO_START = 1.0  # to start a cluster and its workers
_SECONDS_TO_COMMIT = 0.005  # to schedule and write a point
_WORKER_BYTES = 115e6  # interpreter and libraries
_PACKED = 0.35  # compressed size of a field over its size, by zstd: 0.355 in first_try
_STORE_BYTES = 0.36e6  # an empty store: some 30 arrays, each with a folder and two files
_HALF_BLOCK = 2048  # bytes wasted in the last disk block of a file, on average
_FIELDS_IN_MEMORY = 60  # arrays of the grid's size that a worker holds at a time
_FIELDS_OF_STATE = 3  # arrays kept for each increment of a ramp
_MOST_PIXELS = 2e7  # largest surface that is generated here
_PATIENCE = 1.0  # [s] of processor time after which no further step is timed


@dataclass(frozen=True, slots=True)
class Estimate:
    """Expected cost of a sweep: numbers of points, steps and tasks, time [s], disk space [B]."""

    points: int  #: Points of the diagram.
    tests: int  #: Points of the scene's tests, which are computed first.
    steps: int  #: Contacts to solve for these points.
    temperatures: int  #: Heat partitions to solve for these points.
    tasks: int  #: Parallel tasks; points that share a contact are one. More workers would be idle.
    workers: int  #: Processes that compute.
    seconds: float  #: Rough wall time on an idle machine, from steps timed on this machine [s].
    disk_bytes: float  #: Size of the store on disk [B].


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
    if workers is not None:
        require_count("workers", workers)
    sweep, available = sweep_of(sweep), cores()
    workers = workers or available
    every = [*tasks(points_of(sweep), sweep)]
    given = sweep.case_table.without_surfaces.names
    scene = sweep._select_case(given[len(given) // 2])
    contact_time, heat_time, state = time_steps(scene)
    is_course = choose_stored_steps(scene).steps == "course"
    work = _TaskTimes(scene, contact_time, heat_time, is_course)
    parallel = min(workers, len(every))
    wall = work.total(every) / parallel
    slots, points = list_points_of_tests(sweep), len(every)
    of_tests = sweep_of_tests(sweep, False) if slots else None
    own = [*tasks(points_of(of_tests), of_tests)] if of_tests else []
    if of_tests:  # each step takes as long as in the scene
        of_own = _TaskTimes(of_tests, contact_time, heat_time, is_course=False, is_of_tests=True)
        wall += of_own.total(own) / min(workers, len(own))
    return Estimate(
        points=points,
        tests=len(slots),
        steps=work.contacts,
        temperatures=work.temperatures,
        tasks=len(every),
        workers=workers,
        seconds=_SECONDS_TO_START + wall * max(1.0, parallel / available),
        disk_bytes=_STORE_BYTES + (points + len(own)) * _point_bytes(scene, state),
    )


@dataclass(slots=True)
class _TaskTimes:
    """Counts the contacts and heat partitions of tasks, and estimates the time that they take."""

    sweep: Sweep
    contact_time: float  # [s]
    heat_time: float  # [s]
    is_course: bool  # True if temperatures are also computed during the run
    is_of_tests: bool = False  # True if each task has a scene of its own
    contacts: int = 0
    temperatures: int = 0
    _steps: dict[Any, tuple[int, int, int]] = field(default_factory=dict)

    def total(self, every: Iterable[Task]) -> float:
        """Time of tasks [s], one after another, which share their ramps and contacts."""
        has = dict[Any, Any]()
        return sum(self._seconds(task, has) for task in every)

    def _seconds(self, task: Task, has: dict[Any, Any]) -> float:
        """Time of a task [s]; `has` keeps ramps and contacts of those before, and gets its own."""
        load, velocity, case = task.point
        scene = self.sweep.case(case).scene if self.is_of_tests else self.sweep.scene
        if (key := (scene, load, velocity)) not in self._steps:
            stored_steps = choose_stored_steps(self.sweep)
            self._steps[key] = _count_steps(scene, stored_steps, load, velocity)
        increments, own, shown = self._steps[key]
        new = max(0, increments - has.get(task.ramp, 0))
        has[task.ramp] = max(increments, has.get(task.ramp, 0))
        if isinstance(scene.loading, Stages):
            shown = round(shown * new / increments)  # the new ones
        warms = bool(scene.friction_heat and velocity)
        steps = new + own
        heats_on_way = new * warms * (scene.remembers_heat or self.is_course)
        heats = (own if scene.remembers_heat else shown) * warms
        # A worker reuses the contact of its last point; without wear, of its first velocity.
        contact = (task.ramp if scene.remembers_steps else task.ramp[0]), load
        steps = new if contact in has else steps
        has[contact] = True
        self.contacts += steps
        self.temperatures += heats_on_way + heats
        of_heat = (heats_on_way + heats) * self.heat_time
        solved = steps + new * self.is_course  # on the grid of the history, and on the point's own
        return float(solved * self.contact_time + of_heat + _SECONDS_TO_COMMIT)


def worker_bytes(sweep: Sweep) -> float:
    """Memory that a worker needs [B], including the results of steps kept for reuse."""
    scene = as_computed(sweep)
    coarse, *finer = scene.levels()
    kept_on = [coarse, *finer[-1:]] if choose_stored_steps(sweep).steps == "course" else [coarse]
    elements = sum(math.prod(one.grid.shape) for one in kept_on)
    of_ramp = scene.fidelity.increments * _FIELDS_OF_STATE * 8.0 * elements
    kept = min(MOST_BYTES, of_ramp) if scene.remembers_steps else 0.0
    return _WORKER_BYTES + _FIELDS_IN_MEMORY * 8.0 * math.prod(scene.grid.shape) + kept


def as_computed(sweep: Sweep) -> Scene:
    """Scene with the elements that a simulation would choose at the sweep's lowest load.

    If there are very many pixels, elements are single pixels instead.
    """
    scene = sweep.scene
    if math.prod(scene.pixels.shape) <= _MOST_PIXELS:
        return fit_elements(scene, min(sweep.loads))
    finest = replace(scene.fidelity, pixels_per_element=1, fewest_elements=0)
    return replace(scene, fidelity=finest)


def time_steps(sweep: Sweep) -> tuple[float, float, State]:
    """Measure the CPU time of some steps of a sweep's simulations.

    Returns the mean time of a contact solution [s], that of a heat solution [s], and the last state
    that was computed.
    """
    moving = [velocity for velocity in sweep.velocities if velocity] or [0.0]
    velocity = moving[len(moving) // 2]
    of_contacts, of_heat, ramp_cache = list[float](), list[float](), RampCache()
    ramps = (contacts(sweep.scene, load, velocity, ramp_cache) for load in sweep.loads)
    began = time.process_time()
    for state in itertools.chain.from_iterable(ramps):
        if not state.pressure.any():
            continue
        of_contacts.append(time.process_time() - began)
        began = time.process_time()
        if state.is_requested and state.heat is None:
            heat(sweep.scene, state, velocity)
            of_heat.append(time.process_time() - began)
        if state.is_requested and sum(of_contacts) + sum(of_heat) > _PATIENCE:
            break
        began = time.process_time()
    return float(np.mean(of_contacts)), float(np.mean(of_heat or 0.0)), state


def _count_steps(
    scene: Scene, stored_steps: StoredSteps, load: float, velocity: float
) -> tuple[int, int, int]:
    """Numbers of steps that higher loads share, of all others, and of those with a temperature."""
    requested = stored_steps.heat_steps(scene, load)
    steps = list(scene.load_steps(load, requested, velocity))
    if isinstance(scene.loading, Stages):
        return len(steps), 0, sum(step.is_shown for step in steps)
    shared = sum(
        step.on_trunk and step.normal_load < load and step.index not in requested for step in steps
    )
    shown = sum(
        step is steps[-1]
        or step.index in requested
        or (step.normal_load == load and not step.holding)
        for step in steps
    )
    if stored_steps.steps == "course" and steps[-1].on_trunk:
        return len(steps), 0, 1  # the end is the last step that others share
    return shared, len(steps) - shared, shown


def _point_bytes(sweep: Sweep, state: State) -> float:
    """Compressed size of a point in the store [B]."""
    stored_steps = choose_stored_steps(sweep)
    numbers = sum(np.size(value) for value in record_at(sweep.scene, state).values())
    field = 4.0 * _PACKED * math.prod(sweep.scene.grid.shape) + _HALF_BLOCK
    steps = max(len(stored_steps.kept(sweep.scene, n)) for n in sweep.loads)
    fields = {False: 0, True: 3, "steps": 3 * steps}[sweep.fields]
    return 8.0 * numbers * steps + fields * field
