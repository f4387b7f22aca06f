"""What becomes of the points of a run: what workers tell, deadly points, and the progress."""

from __future__ import annotations

import re
import sys
import threading
import time
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np

from pipeline.run.cluster import Connection
from pipeline.run.work import INSTALL, ExecutionError, WorkerReport, records_here
from pipeline.store.schema import DONE, FAILED, PENDING
from pipeline.store.write import Store
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.stages import Progress, Report, silent

_SEVERAL = 4  # points on each worker that tell the pace
_ALIKE = 20  # points that fail alike before any is done, after which a run stops
_NUMBER = re.compile(r"\d[\d.e+-]*")


class Tally:
    """Counts written points, and estimates the remaining time from the work done [s]."""

    def __init__(self, store: Store, progress: Report, began: float) -> None:
        self._progress, self._began = progress, began
        self._connection: Connection | None = None
        self._ended = 0  # points since the first ones
        # Time of all workers since then, and what they have worked in it [s].
        self._offered = self._worked = 0.0
        self._looked: float | None = None
        self._failures: Counter[str] = Counter()
        self.computed = 0
        self._take(store)
        self._report()

    def begin(self, store: Store, connection: Connection) -> None:
        """Take note that points begin to be computed into a store."""
        self._take(store)
        self._connection = connection

    def learn(self, records: Iterable[PointRecord]) -> None:
        """Record the duration of points, except a worker's first, which includes its start."""
        for record in records:
            if record.data is not None:
                self._ended += self._looked is not None
                self._worked += record.wall_time * (self._looked is not None)
                self._durations[self._store.index(record.point)] = record.wall_time
        if self._connection:
            now = self._connection.clock()
            self._offered += self._connection.workers * (now - (self._looked or now))
            self._looked = now
        self._report()

    def count(self, records: Collection[PointRecord]) -> None:
        """Count written points; `ExecutionError` if the first many have failed alike."""
        for record in records:
            if record.data is not None:
                self.computed += 1
                continue
            way = _NUMBER.sub("", record.message)
            self._failures[way] += 1
            if not self.computed and self._failures[way] >= _ALIKE:
                raise ExecutionError(
                    f"the first {_ALIKE} points failed alike, and none is done: {record.message}; "
                    "put that right, and run the sweep again with --retry-failed"
                )
        if records:
            self._report()

    def _take(self, store: Store) -> None:
        self._store = store
        times = store.read("wall_time", ...)
        self._durations = np.where(store.flags == DONE, times, np.nan)

    def _report(self) -> None:
        asked, flags, now = self._store.asked == 1, self._store.flags, time.monotonic()
        done, failed = (int(np.count_nonzero(flags[asked] == flag)) for flag in (DONE, FAILED))
        pending = asked & (flags == PENDING) & np.isnan(self._durations)
        time_to_go = None
        if self._connection and np.isfinite(self._durations).any():
            points = int(np.count_nonzero(pending))
            rounds = max(points / self._connection.workers, min(points, 1))
            slowness = 1.0  # time of a worker for a second of estimated work [s]
            if self._ended >= _SEVERAL * self._connection.workers:
                slowness = max(1.0, self._offered / self._worked)
            time_to_go = slowness * float(rounds * np.nanmean(self._durations))
        total, elapsed = int(np.count_nonzero(asked)), now - self._began
        self._progress(Progress("", done, total, failed, elapsed, time_to_go))


def shown_progress(progress: Report | None) -> Report:
    """What shows progress: the callable that was given, or in a notebook a line below the cell."""
    if progress is not None:
        return progress
    ipython = sys.modules.get("IPython")
    if ipython is None or not hasattr(ipython.get_ipython(), "kernel"):
        return silent
    from IPython.display import display

    line = display(  # type: ignore[no-untyped-call]
        {"text/plain": "starting workers"}, raw=True, display_id=True
    )
    return lambda progress: line.update({"text/plain": str(progress)}, raw=True)


_THREADS = 8  # requests at a time, of some milliseconds each
_ANSWER = 10.0  # [s] that a worker may take; one that is frozen must not hold up the others


class Reports:
    """Requests to workers, one at a time each; their answers are `news`."""

    def __init__(
        self, connection: Connection, news: threading.Event, run: str, parcel: bytes
    ) -> None:
        self._client, self._news, self._run, self._parcel = connection.client, news, run, parcel
        self._threads = ThreadPoolExecutor(_THREADS, "reports")
        self._asked: dict[str, Future[Any]] = {}
        self._now: dict[str, str | None] = {}

    def __enter__(self) -> Reports:
        return self

    def __exit__(self, *_: object) -> None:
        self._threads.shutdown(wait=False, cancel_futures=True)

    def wake(self, _: object) -> None:
        """Tell the driver that there is something to look at."""
        self._news.set()

    def ask(self, workers: Collection[str], keys: list[str]) -> None:
        """Ask workers that have answered before for the records of these tasks."""
        for worker in workers:
            if worker not in self._asked:
                parcel = None if self.knows(worker) else self._parcel
                self._asked[worker] = self._threads.submit(self._answer, worker, keys, parcel)
                self._asked[worker].add_done_callback(self.wake)

    def answers(self) -> Iterator[tuple[str, WorkerReport]]:
        """Answers that have come since the last call, by worker."""
        for worker in [worker for worker, asked in self._asked.items() if asked.done()]:
            if answer := self._asked.pop(worker).result():
                self._now[worker] = answer.now
                yield worker, answer
            elif self.knows(worker):
                self._now[worker] = None

    def knows(self, worker: str) -> bool:
        """True if a worker has answered, and has what is to be computed."""
        return worker in self._now

    def send_again(self) -> None:
        """Send all workers what is to be computed once more."""
        self._now.clear()

    def computes(self, workers: Collection[str]) -> bool:
        """True if one of these workers computed when it answered last."""
        return any(self._now.get(worker) for worker in workers)

    def _answer(self, worker: str, keys: list[str], parcel: bytes | None) -> WorkerReport | None:
        """Answer of a worker, None if it is late; `ExecutionError` if it lacks this program."""
        with suppress(OSError, TimeoutError, ValueError):
            answers = self._client.sync(
                self._client.run,
                records_here,
                keys,
                self._run,
                parcel,
                workers=[worker],
                on_error="return",
                callback_timeout=_ANSWER,
            )
            answer = answers.get(worker)
            if isinstance(answer, Exception) and not isinstance(answer, OSError):
                raise ExecutionError(
                    f"the Dask worker {worker} cannot run this program: {answer}; {INSTALL}"
                )
            return answer if isinstance(answer, WorkerReport) else None
        return None
