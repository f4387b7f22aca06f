"""What workers tell of the tasks of a run, beside their computations."""

from __future__ import annotations

import threading
from collections.abc import Collection, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

from pipeline.run.cluster import Connection
from pipeline.run.work import Report, report

_THREADS = 8  # requests at a time, of some milliseconds each
_ANSWER = 10.0  # [s] that a worker may take; one that is frozen must not hold up the others


class Reports:
    """Requests to workers, one at a time to each, and their answers, which are `news`."""

    def __init__(self, connection: Connection, news: threading.Event) -> None:
        self._client, self._news = connection.client, news
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
                self._asked[worker] = self._threads.submit(self._answer, worker, keys)
                self._asked[worker].add_done_callback(self.wake)

    def answers(self) -> Iterator[tuple[str, Report]]:
        """Answers that have come since the last call, by worker."""
        for worker in [worker for worker, asked in self._asked.items() if asked.done()]:
            answer = self._asked.pop(worker).result()
            self._now[worker] = answer.now if answer else None
            if answer:
                yield worker, answer

    def computes(self, workers: Collection[str]) -> bool:
        """True if one of these workers computed when it answered last."""
        return any(self._now.get(worker) for worker in workers)

    def _answer(self, worker: str, keys: list[str]) -> Report | None:
        """Answer of a worker; None if it has died, or does not answer in time."""
        with suppress(OSError, TimeoutError, ValueError):
            answers = self._client.sync(
                self._client.run,
                report,
                keys,
                workers=[worker],
                on_error="return",
                callback_timeout=_ANSWER,
            )
            if isinstance(answer := answers.get(worker), Report):
                return answer
        return None
