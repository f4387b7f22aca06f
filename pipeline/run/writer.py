"""Writer that commits results to the store in a thread of its own, beside the schedule."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Collection
from concurrent.futures import Future, ThreadPoolExecutor, wait

from pipeline.store.place import Bucket
from pipeline.store.write import Store
from pipeline.sweep.plan import PointRecord

_PAUSE = 1.0  # [s] between commits: as much work as a kill may cost
_PAUSE_OF_BUCKET = 10.0  # [s], since each commit to an object store is some 50 requests
_SHARE = 10.0  # durations of a commit between two, so that they take a tenth of a core at most
_LONGEST = 10.0  # [s] between commits, however slow the disk or busy the machine


class Writer:
    """Commits records about once a second; in the loop of the schedule, workers would wait for it.

    An error of a commit is raised by the next call of `written`.
    """

    def __init__(self, store: Store) -> None:
        self.store = store
        self._least = _PAUSE_OF_BUCKET if isinstance(store.place, Bucket) else _PAUSE
        self._pause = 0.0
        self._arrived: deque[Collection[PointRecord]] = deque()
        self._commits: deque[Future[list[PointRecord]]] = deque()
        self._is_urgent = threading.Event()
        self._thread = ThreadPoolExecutor(1, "writer")

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *_: object) -> None:
        self._is_urgent.set()
        self._thread.shutdown()  # when all that has arrived is written

    def add(self, records: Collection[PointRecord]) -> None:
        """Take records, to be written soon."""
        self._arrived.append(records)
        self._commits.append(self._thread.submit(self._commit))

    def written(self) -> list[PointRecord]:
        """Records that have been written since the last call."""
        records: list[PointRecord] = []
        while self._commits and self._commits[0].done():
            records += self._commits.popleft().result()
        return records

    def flush(self) -> None:
        """Wait until all records are written."""
        self._is_urgent.set()
        wait(self._commits)
        self._is_urgent.clear()

    def _commit(self) -> list[PointRecord]:
        """Commit what has arrived until the pause after the last commit is over."""
        if not self._arrived:  # an earlier commit took it along
            return []
        self._is_urgent.wait(self._pause)
        records: list[PointRecord] = []
        while self._arrived:
            records += self._arrived.popleft()
        began = time.monotonic()
        self.store.commit(records)
        self._pause = min(max(self._least, _SHARE * (time.monotonic() - began)), _LONGEST)
        return records
