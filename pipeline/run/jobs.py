"""Tasks that were given to Dask, and what has become of them."""

from __future__ import annotations

import asyncio
import itertools
import threading
import time
import uuid
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from concurrent.futures import Future as Answer
from contextlib import suppress
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from distributed import Future
from distributed.scheduler import KilledWorker

from pipeline.run.cluster import LOST, POLL, WORD, Connection
from pipeline.run.work import CODE, FOLDER, INSTALL, TASK, ExecutionError, Work
from pipeline.sweep.plan import Task, choose_stations
from pipeline.sweep.sweep import Sweep
from pipeline.sweep.variants import Variant

ANYWHERE = ""
"""Address of the worker for a task that any worker may take."""

_CANNOT = "a Dask worker cannot run this program"


@dataclass(slots=True, eq=False)
class Job:
    """A task given to Dask: its point, and the address of its worker.

    `is_alone` is True if the worker has no other task.
    """

    task: Task
    worker: str = ANYWHERE
    is_alone: bool = False
    future: Future = field(init=False, repr=False)


class Loss(Enum):
    """Reason why a task has no result."""

    KILLED = "its worker died"
    LEFT = "its worker left"
    FORGOTTEN = "its result was lost with a worker, or the scheduler was restarted"


class Jobs:
    """Tasks given to Dask: `running` ones, and `computed` ones whose result is on a worker."""

    def __init__(self, link: Connection, sweep: Sweep, with_fields: bool) -> None:
        self._link, self._client = link, link.client
        self._name = uuid.uuid4().hex[:8]  # a scheduler may know other runs
        self._sweep, self._stations = sweep, choose_stations(sweep)
        self._with_fields, self._works = with_fields, dict[str, bytes]()
        self._numbers, self._calls = itertools.count(), 0
        self._ended, self._news = deque[str](), threading.Event()
        # Pending requests for results, each with the futures that it asks for, by key.
        self._gathering: dict[Answer[dict[str, Any]], dict[str, Future]] = {}
        self._next = 0.0  # time of the next gathering
        self._last = time.monotonic()  # time of the last news
        self._without_result: list[tuple[Job, Loss]] = []
        self.running: dict[str, Job] = {}
        self.computed: dict[str, Job] = {}

    def __enter__(self) -> Jobs:
        return self

    def __exit__(self, *_: object) -> None:
        for gathering in self._gathering:
            gathering.cancel()
        for job in (*self.running.values(), *self.computed.values()):
            job.future.release()  # nothing stays on a scheduler of others; no answer is waited for

    def __bool__(self) -> bool:
        return bool(self.running or self.computed or self._without_result)

    def _work(self, variant: Variant) -> bytes:
        """What a task carries of its case, pickled once for each scene."""
        case = self._sweep.case(variant)
        scene = case.scene
        scene_hash = self._sweep._hash_scene(scene)
        if scene_hash not in self._works:
            work = Work(scene, self._stations, self._with_fields, case.has_film)
            self._works[scene_hash] = work.pickled()
        return self._works[scene_hash]

    def submit(self, jobs: Sequence[Job]) -> None:
        """Give tasks for one worker to Dask, in their order."""
        first, places = jobs[0], [job.task.point for job in jobs]
        keys = [
            f"point-{point.load:g}N-{point.velocity:g}ms-{self._name}-{next(self._numbers)}"
            for point in places
        ]
        given = [
            {"given": (CODE, FOLDER, self._work(point.variant), tuple(point))} for point in places
        ]
        options: dict[str, Any] = {
            # Without a priority Dask orders tasks of one moment by chance.
            "priority": -self._calls,
            "workers": first.worker or None,
            "allow_other_workers": bool(first.worker) and not first.is_alone,
        }
        self._calls += 1
        with self._link.reached():
            # A task takes client and scheduler 0.8 ms in a group of eight, 1.9 ms by `submit`, and
            # 2.3 ms by `map` alone.
            if len(jobs) == 1:
                futures = [self._client.submit(eval, TASK, given[0], key=keys[0], **options)]
            else:
                futures = self._client.map(eval, [TASK] * len(jobs), given, key=keys, **options)
        for key, job, future in zip(keys, jobs, futures, strict=True):
            job.future = future
            self.running[key] = job
            future.add_done_callback(self._note)

    def _note(self, future: Future) -> None:
        self._ended.append(future.key)
        self._news.set()

    def wait(self) -> None:
        """Wait until a task ends or results arrive, at most a second."""
        self._news.wait(POLL)
        self._news.clear()

    def lost(self, has_looked: bool) -> list[tuple[Job, Loss]]:
        """Return tasks that were lost since the last call, as pairs of job and reason.

        Tasks that have ended with a result move from `running` to `computed`. Such a task is lost,
        too, if its worker is gone before the result was fetched. Gone workers are looked for only
        if the list of workers was just updated (`has_looked`).
        """
        lost, self._without_result = self._without_result, []
        if self._ended or not self._link.workers:
            self._last = time.monotonic()
        elif has_looked and time.monotonic() - self._last > WORD:
            self._link.report_wait(self.running.keys())
        while self._ended:
            key = self._ended.popleft()
            if not (job := self.running.pop(key, None)):  # it was given up before
                continue
            if job.future.status == "finished":
                self.computed[key] = job
            else:
                lost.append((job, self._loss(job)))
        if has_looked:
            # Dask may never end a task whose worker is gone.
            for jobs, loss in ((self.running, Loss.LEFT), (self.computed, Loss.FORGOTTEN)):
                for key, job in [*jobs.items()]:
                    is_gone = job.worker and not self._link.has(job.worker)
                    if is_gone and not job.future.done():
                        del jobs[key]
                        job.future.release()
                        lost.append((job, loss))
        return lost

    def _loss(self, job: Job) -> Loss:
        """Find the reason why a task was lost; `ExecutionError` if the run cannot go on."""
        error = job.future.exception() if job.future.status == "error" else None
        if isinstance(error, KilledWorker):
            job.worker = error.last_worker.address  # it may have taken the task from another worker
            return Loss.KILLED
        if error is None or isinstance(error, CancelledError):
            with self._link.reached():
                if self._client.status != "running":
                    raise ExecutionError(LOST)
            return Loss.FORGOTTEN
        if isinstance(error, ExecutionError):
            raise error
        where = f" ({job.worker})" if job.worker else ""
        raise ExecutionError(f"{_CANNOT}: {error}{where}; {INSTALL}")

    def results(self) -> Iterator[bytes]:
        """Yield pickled results that have arrived, and request further results.

        While tasks are running, results are requested at most once a second. A worker that hangs
        delays only the results that are requested together with its own.
        """
        for answer in [one for one in self._gathering if one.done()]:
            del self._gathering[answer]
            gathered: dict[str, Any] = {}
            # This fails if the scheduler was restarted; the next update notices it.
            with self._link.reached(), suppress(CancelledError, OSError):
                gathered = answer.result()
            for key, result in gathered.items():
                job = self.computed.pop(key, None)  # None if it was given up meanwhile
                if job and result:
                    yield result
                elif job:
                    self._without_result.append((job, Loss.FORGOTTEN))
        if self.running and time.monotonic() < self._next:
            return
        self._next = time.monotonic() + POLL
        requested = set().union(*self._gathering.values())
        if new := {key: job.future for key, job in self.computed.items() if key not in requested}:
            with self._link.reached():
                request = self._client.gather(new, errors="skip", asynchronous=True)
                answer = asyncio.run_coroutine_threadsafe(request, self._client.loop.asyncio_loop)
            self._gathering[answer] = new
            answer.add_done_callback(lambda _: self._news.set())
