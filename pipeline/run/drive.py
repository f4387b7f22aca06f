"""The points of a sweep as independent tasks of Dask.

Dask orders them, and computes a task again whose result is lost. The driver keeps two or more tasks
for each worker: one is computed, the others wait. If possible, the next task continues a loading
ramp that this worker has cached.
"""

from __future__ import annotations

import itertools
import sys
import time
import uuid
from collections import Counter, defaultdict, deque
from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import numpy as np
from distributed import Client, Future, as_completed
from distributed.scheduler import KilledWorker

from pipeline.progress import Progress, Report, silent
from pipeline.run.watch import CANNOT, POLL, Watch
from pipeline.run.work import Case, ExecutionError, loaded, simulate_point
from pipeline.store.schema import DONE, FAILED, NOT_NEEDED, PENDING
from pipeline.store.store import Store, Writer
from pipeline.sweep.case_table import CaseName
from pipeline.sweep.plan import PointRecord, Task, choose_stored_steps
from pipeline.sweep.stored_steps import Fields
from pipeline.sweep.sweep import Point

ANYWHERE = ""
"""Address of the worker for a task that any worker may take."""

_TIME_AHEAD = 0.4  # computing time of the tasks submitted to a worker [s]
_MIN_AHEAD, _MAX_AHEAD = 2, 16
_SPARE_TASKS = 16  # tasks without a worker, for which an adaptive cluster starts workers
_MAX_DEATHS = 3  # deaths of its workers after which a point has failed
_MAX_SHARED_DEATHS = 2  # deaths of its workers after which a point is computed without other tasks
_KILLED_MESSAGE = (
    "{} workers died; the last one was computing only this point: {}; use fewer workers, or reduce "
    "window.pixels"
)


@dataclass(slots=True, eq=False)
class _Job:
    task: Task
    worker: str
    process: str | None  # of the worker
    is_movable: bool = True  # False if Dask must not give it to another worker
    is_alone: bool = False
    deaths: int = 0  # of its workers, by this or another task; `worker` is the last one


class TaskQueue:
    """Waiting tasks by loading ramp, and the last ramp of each worker.

    A worker gets the next load of its last ramp; if there is none, the lowest load of a new ramp;
    if all ramps have begun, the next load of the ramp with most waiting tasks.
    """

    def __init__(self, tasks: Iterable[Task]) -> None:
        self._tasks_by_ramp: dict[tuple[Any, ...], deque[Task]] = {}
        for task in tasks:
            self._tasks_by_ramp.setdefault(task.ramp, deque()).append(task)
        self._new_ramps = dict.fromkeys(self._tasks_by_ramp)
        self._last_ramps: dict[Hashable, tuple[Any, ...]] = {}

    def __len__(self) -> int:
        return sum(map(len, self._tasks_by_ramp.values()))

    def __bool__(self) -> bool:
        return bool(self._tasks_by_ramp)

    def take(self, worker: Hashable) -> Task:
        """Remove and return the next task for a worker; the queue must not be empty."""
        ramp = self._last_ramps.get(worker)
        if ramp is None or ramp not in self._tasks_by_ramp:
            ramp = next(iter(self._new_ramps), None)
            ramp = ramp or max(self._tasks_by_ramp, key=lambda key: len(self._tasks_by_ramp[key]))
        self._new_ramps.pop(ramp, None)
        self._last_ramps[worker] = ramp
        task = self._tasks_by_ramp[ramp].popleft()
        if not self._tasks_by_ramp[ramp]:
            del self._tasks_by_ramp[ramp]
        return task

    def put_back(self, task: Task) -> None:
        """Put a task that was not computed back into the queue, as the next task of its ramp."""
        self._tasks_by_ramp.setdefault(task.ramp, deque()).appendleft(task)


def compute(client: Client, watch: Watch, store: Store, queue: TaskQueue, tally: Tally) -> None:
    """Compute all tasks of a queue, and write their points to the store as done or failed.

    `watch` looks after the workers, and `tally` reports progress. Raises a `StoreError` if points
    cannot be written, an `ExecutionError` if the scheduler is lost or no worker can compute.
    """
    with Writer(store) as writer:
        _compute(client, watch, writer, queue, tally)


def _compute(client: Client, watch: Watch, writer: Writer, queue: TaskQueue, tally: Tally) -> None:
    tasks = _Tasks(client, writer.store)
    suspect_tasks = deque[Task]()  # tasks of workers that died, of which one may be the cause
    deaths = Counter[Point]()  # deaths of workers, by the point that they had
    recent_times = deque([1.0], maxlen=50)  # times of points [s]
    try:
        while queue or suspect_tasks or tasks:
            workers = watch()
            max_ahead = max(
                int(_TIME_AHEAD / max(fmean(recent_times), _TIME_AHEAD / _MAX_AHEAD)), _MIN_AHEAD
            )
            busy = Counter(job.worker for job in tasks.running.values())
            available = [worker for worker in workers if busy[worker] <= max_ahead // 2]
            slots = [
                worker
                for count in range(max_ahead)
                for worker in available
                if busy[worker] <= count
            ]
            adaptive = getattr(client.cluster, "_adaptive", None)
            if not workers or (adaptive and adaptive.minimum < adaptive.maximum):
                slots += [ANYWHERE] * (_SPARE_TASKS - busy[ANYWHERE])
            processes = watch.processes
            jobs = [
                _Job(task, worker, processes.get(worker), is_movable=task.point not in deaths)
                for worker in slots
                if queue and (task := queue.take(worker or object()))
            ]
            if suspect_tasks and not (jobs or tasks):
                worker = workers[0] if workers else ANYWHERE
                task = suspect_tasks.popleft()
                jobs = [_Job(task, worker, processes.get(worker), is_movable=False, is_alone=True)]
            with watch.reached():
                tasks.submit(jobs)
                for job, result in tasks.ended(processes):
                    point = job.task.point
                    if result is not None:
                        record, program = loaded(result)
                        watch.require_program(program)
                        writer.add([record])
                        recent_times.append(record.wall_time if record.data else recent_times[-1])
                        continue
                    if job.deaths:
                        deaths[point] += job.deaths
                        watch.look_again()  # or the dead worker would get the next task
                    if job.is_alone and deaths[point] >= _MAX_DEATHS:
                        cause = watch.cause_of_death(job.worker)
                        message = _KILLED_MESSAGE.format(deaths[point], cause)
                        writer.add([PointRecord(point, None, message)])
                    elif deaths[point] >= _MAX_SHARED_DEATHS:
                        suspect_tasks.append(job.task)
                    else:
                        queue.put_back(job.task)
            if written := writer.written():
                tally.count(written, len(workers))
    finally:
        tasks.release()
    tally.count(writer.flush(), len(workers))


class _Tasks:
    """Tasks at Dask whose results have not arrived, by their futures."""

    def __init__(self, client: Client, store: Store) -> None:
        self._client, self._store = client, store
        self._stored_steps = choose_stored_steps(store.sweep)
        self._cases: dict[tuple[str, Fields], bytes] = {}
        # Keys with a random name, as a scheduler may have tasks of other runs.
        self._name, self._numbers = uuid.uuid4().hex[:8], itertools.count()
        self._ended = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self.running: dict[Future, _Job] = {}

    def __bool__(self) -> bool:
        return bool(self.running)

    def submit(self, jobs: list[_Job]) -> None:
        """Submit tasks to Dask, grouped by worker, which takes half the time."""
        groups = defaultdict[tuple[str, bool], list[_Job]](list)
        for job in jobs:
            groups[job.worker, job.is_movable].append(job)
        for (worker, is_movable), group in groups.items():
            points = [job.task.point for job in group]
            futures = self._client.map(
                simulate_point,
                [self._case(point.case) for point in points],
                points,
                key=[
                    f"point-{point.load:g}N-{point.velocity:g}ms-{self._name}-{next(self._numbers)}"
                    for point in points
                ],
                pure=False,
                workers=worker or None,
                allow_other_workers=bool(worker) and is_movable,
            )
            self.running.update(zip(futures, group, strict=True))
            self._ended.update(futures)

    def _case(self, name: CaseName) -> bytes:
        sweep, fields = self._store.sweep, self._store.fields_of(name)
        case = sweep.case(name)
        key = sweep._hash_scene(case.scene), fields
        if key not in self._cases:
            new_case = Case(case.scene, self._stored_steps, fields, case.has_film)
            self._cases[key] = new_case.pickled()
        return self._cases[key]

    def ended(self, processes: Mapping[str, str]) -> Iterator[tuple[_Job, bytes | None]]:
        """Wait until a task ends, at most a second; yield the jobs that have ended, with results.

        The result is None if the task is lost. `processes` has the connected workers. A job
        whose worker is lost or was restarted is taken back: without another worker Dask would never
        run it, and one that kills its workers would be run four times.
        """
        with self._ended.thread_condition:
            self._ended.thread_condition.wait_for(self._ended.has_ready, timeout=POLL)
        for future, result in self._ended.next_batch(block=False):
            if (job := self.running.pop(future, None)) is None:
                continue  # taken back
            if future.status == "error":
                if not isinstance(error := result[1], KilledWorker):
                    raise ExecutionError(f"{CANNOT}: {error}")
                job.deaths, job.worker = error.allowed_failures + 1, error.last_worker.address
            future.release()
            yield job, result if isinstance(result, bytes) else None
        for future, job in [*self.running.items()]:
            if job.worker and processes.get(job.worker) != job.process:
                del self.running[future]
                future.release()
                job.deaths = 1
                yield job, None

    def release(self) -> None:
        """Release all futures, so that a shared scheduler keeps none; do not wait for answers."""
        for future in self.running:
            future.release()


class Tally:
    """Counts points as they are written; estimates the time left from the mean time of a point.

    Points of tests count as those of the plane do.
    """

    def __init__(self, store: Store, progress: Report) -> None:
        self._progress, self._began = progress, time.monotonic()
        self._seconds = 0.0
        self.computed = 0
        self.follow(store)
        self.count((), 1)

    def follow(self, store: Store) -> None:
        """Count the points of a store that has grown."""
        self._groups = [group for group in (store, store.tests) if group]

    def count(self, records: Collection[PointRecord], workers: int) -> None:
        """Count written points, and report progress; `workers` is the number of workers."""
        computed = [record.wall_time for record in records if record.data is not None]
        self.computed += len(computed)
        self._seconds += sum(computed)
        flags = np.concatenate([group.flags[group.flags != NOT_NEEDED] for group in self._groups])
        done, failed, pending = (int(np.sum(flags == flag)) for flag in (DONE, FAILED, PENDING))
        time_to_go = None
        if self.computed:
            rounds = max(pending / max(workers, 1), min(pending, 1))
            time_to_go = rounds * self._seconds / self.computed
        elapsed = time.monotonic() - self._began
        self._progress(Progress("", done, flags.size, failed, elapsed, time_to_go))


def shown_progress(progress: Report | None) -> Report:
    """Return `progress`, or if it is None a function that shows progress in a notebook.

    Outside a notebook this function shows nothing.
    """
    ipython: Any = sys.modules.get("IPython")
    if progress is not None or not hasattr(ipython and ipython.get_ipython(), "kernel"):
        return progress or silent
    from IPython.display import display

    line = display(  # type: ignore[no-untyped-call]
        {"text/plain": "starting workers"}, raw=True, display_id=True
    )
    return lambda progress: line.update({"text/plain": str(progress)}, raw=True)
