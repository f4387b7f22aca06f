"""Compute the points of a sweep as independent tasks of Dask.

Two policies decide: `TaskQueue` which task is next, `Losses` what to do about one that was lost. A
worker has one task that it computes and one that waits; of tasks of milliseconds it has a group.
"""

from __future__ import annotations

import pickle
from collections import Counter, defaultdict, deque
from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from statistics import fmean

from pipeline.run.cluster import Connection
from pipeline.run.jobs import ANYWHERE, Job, Jobs, Loss
from pipeline.run.tally import Tally
from pipeline.run.task_queue import TaskQueue
from pipeline.run.work import VERSIONS
from pipeline.store.store import Writer
from pipeline.sweep.plan import PointRecord, Task
from pipeline.sweep.sweep import Point, Sweep

TRIALS = 5
"""Times that a point may be lost until it counts as failed; after two it is tried alone."""

_TO_COME = 16  # tasks handed out for workers that are still to come
_OTHERS = "a Dask worker computes by"
_AHEAD = 2  # tasks for each worker: one that it computes, and one that waits
_GROUP = 8  # tasks that are given to Dask together where points are short, so that two groups wait
_SHORT = 0.02  # mean time of short points [s]: to lose a group of them with a worker costs little
_RECENT = 50  # points for the mean


def compute(
    link: Connection,
    sweep: Sweep,
    writer: Writer,
    queue: TaskQueue,
    tally: Tally,
    with_fields: bool = True,
) -> None:
    """Compute all tasks of a queue, and write their points to the store as done or failed.

    `link` is the connection to the workers, `writer` writes to the store, and `tally` reports
    progress. Without `with_fields` the fields of the store are NaN. Raises a `StoreError` if
    points cannot be written, an `ExecutionError` if the scheduler is lost or no worker can compute.
    """
    losses, recent = Losses(), deque[float](maxlen=_RECENT)  # `recent`: durations of points [s]
    wanted = replace(sweep, stations=writer.store.sweep.stations)
    has_fields = "pressure" in writer.store.arrays
    blank = {} if with_fields or not has_fields else writer.store.blank_fields()
    with Jobs(link, wanted, has_fields and not blank) as jobs:
        while queue or losses or jobs:
            has_looked = link.update()
            busy = Counter(job.worker for job in jobs.running.values())
            is_short = bool(recent) and fmean(recent) < _SHORT
            ahead = 2 * _GROUP if is_short else _AHEAD
            able = [one for one in link.workers if busy[one] <= ahead // 2]
            free = [one for count in range(ahead) for one in able if busy[one] <= count]
            # A cluster that adapts starts as many workers as its tasks need.
            if getattr(link.client.cluster, "_adaptive", None) or not link.workers:
                free += [ANYWHERE] * (_TO_COME - busy[ANYWHERE])
            groups = defaultdict[str, list[Job]](list)
            for worker in free:
                if queue:
                    groups[worker].append(Job(queue.take(worker or object()), worker))
            for group in groups.values():
                jobs.submit(group)
            on_workers = [*jobs.running.values(), *jobs.computed.values()]  # results die with them
            for job in losses.trials(on_workers, link.workers):
                jobs.submit([job])
            jobs.wait()
            for job, loss in jobs.lost(has_looked):
                link.workers.pop(job.worker, None)  # gets no task until it is listed again
                if losses.record(job, loss):
                    queue.put_back(job.task)
                elif cause := link.memory_cause([job.worker]):
                    link.report(f"a worker has died: {cause}", again=link.patience)
            for point, workers in losses.failed():
                cause = link.memory_cause(workers) or "out of memory, or killed from outside"
                why = f"{len(workers)} workers died, the last computing only this point: {cause}"
                writer.add([PointRecord(point, None, why)])
            for result in jobs.results():
                record, versions = pickle.loads(result)
                if blank and record.data is not None:
                    record = replace(record, data={**record.data, **blank})
                writer.add([record])
                recent += [record.wall_time] * (record.data is not None)
                if versions != VERSIONS:
                    link.report(f"{_OTHERS} {versions}, and not {VERSIONS}; last digits may differ")
            if written := writer.written():
                tally.count(written, len(link.workers))
    tally.count(writer.flush(), len(link.workers))


class Losses:
    """Policy for lost tasks: queue them again, or try each of their points alone at the end.

    If a worker dies, all of its tasks are lost, and any point of these tasks may have killed it.
    """

    def __init__(self) -> None:
        # Addresses of the workers that were lost while they had a point, by point.
        self._workers: defaultdict[Point, list[str]] = defaultdict(list)
        self._suspects: dict[Point, None] = {}

    def __bool__(self) -> bool:
        return bool(self._suspects)

    def record(self, job: Job, loss: Loss) -> bool:
        """Record a lost task; return True if it is to be queued again unchanged."""
        point = job.task.point
        if loss is not Loss.FORGOTTEN:
            self._workers[point].append(job.worker)
        # The task may have killed a worker that leaves. When a second worker leaves, its point is
        # suspected.
        times = len(self._workers[point])
        if not job.is_alone and (loss is Loss.FORGOTTEN or (loss is Loss.LEFT and times == 1)):
            return True
        self._suspects[point] = None
        return False

    def failed(self) -> list[tuple[Point, list[str]]]:
        """Remove and return the points that were lost `TRIALS` times or more often.

        Each comes with the addresses of the workers that were lost while they had the point.
        """
        failed = [point for point in self._suspects if len(self._workers[point]) >= TRIALS]
        for point in failed:
            del self._suspects[point]
        return [(point, self._workers[point]) for point in failed]

    def trials(self, present: Collection[Job], workers: Iterable[str]) -> Iterator[Job]:
        """Yield jobs that try one point alone, for points that may have killed their worker.

        Each worker without a job gets one such point; points lost least often come first. `workers`
        are the addresses of all workers. `present` are the jobs on workers now; while one of them
        is an ordinary job, nothing is yielded.
        """
        if not all(job.is_alone for job in present):
            return
        free = {*workers} - {job.worker for job in present}
        suspects = sorted(self._suspects, key=lambda point: len(self._workers[point]))
        for worker, point in zip(free, suspects, strict=False):
            del self._suspects[point]
            yield Job(Task(point, ()), worker, is_alone=True)
