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
from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import numpy as np
from distributed import Client, Future, KilledWorker, as_completed

from pipeline.answers.scene_wording import test_group_words
from pipeline.progress import Progress, Report, silent
from pipeline.run.cluster import CANNOT, POLL, Watch
from pipeline.run.work import ExecutionError, pickled, simulate_point, unpack_result
from pipeline.store.schema import DONE, FAILED, NOT_NEEDED, PENDING
from pipeline.store.store import Store, Writer
from pipeline.sweep.case_table import CaseName
from pipeline.sweep.plan import CaseInputs, PointRecord, Task
from pipeline.sweep.stored_steps import Fields
from pipeline.sweep.sweep import Point

ANYWHERE = ""
"""Address of the worker for a task that any worker may take."""

_TIME_AHEAD = 0.4  # computing time of the tasks submitted to a worker [s]
_MIN_AHEAD, _MAX_AHEAD = 2, 16
_SPARE_TASKS = 16  # tasks while there is no worker, for which a cluster may start some
_PAUSE = 0.01  # between two looks at the tasks that have ended [s]
_MAX_LOSSES = 3  # a point has failed once it was lost so often with its worker
_LOST_MESSAGE = (
    f"{_MAX_LOSSES} workers died with this point, the last one with no other; if the memory of a "
    "worker was too small, use fewer workers, or reduce window.pixels"
)


@dataclass(slots=True, eq=False)
class _Job:
    """A task at Dask, with the worker that it was submitted to."""

    task: Task
    worker: str
    process: str | None  # of the worker
    is_lost: bool = False  # with its worker


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
    losses = Counter[Point]()  # how often a point was lost with its worker
    suspect_tasks = deque[Task]()  # lost so often that each is computed without other tasks
    recent_times = deque([1.0], maxlen=50)  # times of points [s]
    with Writer(store) as writer, closing(_SubmittedTasks(client, store)) as submitted:
        while queue or suspect_tasks or submitted:
            workers, processes = watch(), watch.processes
            assigned = [
                (worker, queue.take(worker or object()))
                for worker in _workers_with_room(workers, submitted.count_by_worker(), recent_times)
                if queue
            ]
            if suspect_tasks and not (assigned or submitted):
                assigned = [(workers[0] if workers else ANYWHERE, suspect_tasks.popleft())]
            with watch.reached():
                submitted.add(
                    [_Job(task, worker, processes.get(worker)) for worker, task in assigned]
                )
                for job, result in submitted.ended(processes):
                    point = job.task.point
                    if result is not None:
                        record, program = unpack_result(result)
                        watch.require_program(program)
                        writer.add([record])
                        recent_times.append(record.wall_time if record.data else recent_times[-1])
                        continue
                    if job.is_lost:
                        losses[point] += 1
                        watch.look_again()  # or the dead worker would get the next task
                    if losses[point] < _MAX_LOSSES - 1:
                        queue.put_back(job.task)
                    elif losses[point] < _MAX_LOSSES:
                        suspect_tasks.append(job.task)
                    else:
                        writer.add([PointRecord(point, None, _LOST_MESSAGE)])
            if written := writer.flush_if_due():
                tally.count(written, len(workers))
        tally.count(writer.flush(), len(workers))


def _workers_with_room(
    workers: Sequence[str], busy: Counter[str], recent_times: Collection[float]
) -> Iterator[str]:
    """Yield the worker of each further task, in turns, until all have enough to do.

    `busy` has the number of tasks of each worker.
    """
    max_ahead = max(
        int(_TIME_AHEAD / max(fmean(recent_times), _TIME_AHEAD / _MAX_AHEAD)), _MIN_AHEAD
    )
    available = [worker for worker in workers if busy[worker] <= max_ahead // 2]
    for count in range(max_ahead):
        yield from (worker for worker in available if busy[worker] <= count)
    if not workers:
        yield from [ANYWHERE] * (_SPARE_TASKS - busy[ANYWHERE])


class _SubmittedTasks:
    """Tasks at Dask whose results have not arrived."""

    def __init__(self, client: Client, store: Store) -> None:
        self._client, self._store = client, store
        self._cases: dict[tuple[str, Fields], bytes] = {}
        # Keys with a random name, as a scheduler may have tasks of other runs.
        self._name, self._numbers = uuid.uuid4().hex[:8], itertools.count()
        self._ended = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self._jobs: dict[Future, _Job] = {}

    def __bool__(self) -> bool:
        return bool(self._jobs)

    def count_by_worker(self) -> Counter[str]:
        """Number of tasks of each worker."""
        return Counter(job.worker for job in self._jobs.values())

    def add(self, jobs: Iterable[_Job]) -> None:
        """Submit tasks to Dask, grouped by worker, which takes half the time."""
        jobs_by_worker = defaultdict[str, list[_Job]](list)
        for job in jobs:
            jobs_by_worker[job.worker].append(job)
        for worker, group in jobs_by_worker.items():
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
                allow_other_workers=bool(worker),
            )
            self._jobs.update(zip(futures, group, strict=True))
            self._ended.update(futures)

    def _case(self, name: CaseName) -> bytes:
        sweep = self._store.sweep
        key = sweep.scene_hashes[name], sweep.fields_of(name)
        if key not in self._cases:
            self._cases[key] = pickled(CaseInputs.from_sweep(sweep, name))
        return self._cases[key]

    def ended(self, processes: Mapping[str, str]) -> Iterator[tuple[_Job, bytes | None]]:
        """Wait until a task ends, at most a second; yield the jobs that have ended, with results.

        The result is None if the task has to be computed again. `processes` has the connected
        workers. A job whose worker is lost or was restarted is taken back, because Dask never runs
        a task again whose worker is lost while there is no other one.
        """
        limit = time.monotonic() + POLL
        while not self._ended.has_ready() and time.monotonic() < limit:
            time.sleep(_PAUSE)
        for future, result in self._ended.next_batch(block=False):
            if future.status != "error" and (job := self._jobs.pop(future, None)):
                future.release()
                yield job, result if isinstance(result, bytes) else None
        for future, job in [*self._jobs.items()]:
            # `as_completed` omits an error of a task that was done before and lost its result.
            if future.status == "error":
                if not isinstance(error := future.exception(), KilledWorker):
                    raise ExecutionError(f"{CANNOT}: {error}")
                job.worker = error.last_worker.address
            elif not job.worker or processes.get(job.worker) == job.process:
                continue
            del self._jobs[future]
            future.release()
            job.is_lost = True
            yield job, None

    def close(self) -> None:
        """Release all futures, so that a shared scheduler keeps none; do not wait for answers."""
        for future in self._jobs:
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
        self._groups = store.groups

    def count(self, records: Collection[PointRecord], workers: int) -> None:
        """Count written points, and report progress; `workers` is the number of workers."""
        computed = [record.wall_time for record in records if record.data is not None]
        self.computed += len(computed)
        self._seconds += sum(computed)
        by_group = [group.flags[group.flags != NOT_NEEDED] for group in self._groups]
        flags, plane = np.concatenate(by_group), by_group[0].size
        done, failed, pending = (int(np.sum(flags == flag)) for flag in (DONE, FAILED, PENDING))
        time_to_go = None
        if self.computed:
            rounds = max(pending / max(workers, 1), min(pending, 1))
            time_to_go = rounds * self._seconds / self.computed
        elapsed = time.monotonic() - self._began
        parts = ""
        if beside_plane := flags.size - plane:
            words = test_group_words(self._groups[0].sweep)
            parts = f"{plane} of the plane, {beside_plane} for {words}"
        self._progress(Progress("", done, flags.size, failed, elapsed, time_to_go, parts))


def notebook_progress(progress: Report | None) -> Report:
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
