"""The thread that commits results to the store, beside the schedule."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Iterable
from types import TracebackType

from pipeline.store.place import Bucket
from pipeline.store.write import Store
from pipeline.sweep.plan import PointRecord

_PAUSE = 1.0  # [s] between commits: as much work as a kill may cost
_PAUSE_OF_BUCKET = 10.0  # [s], since each commit to an object store is some 50 requests
_SHARE = 10.0  # durations of a commit between two, so that they take a tenth of a core at most
_LONGEST = 10.0  # [s] between commits, however slow the disk or busy the machine


class Writer:
    """Commits results about once a second, in a thread of its own.

    In the loop of the schedule a commit would keep workers waiting. An error of the thread is
    raised by the next call.

    Parameters
    ----------
    store : Store
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._pause = _PAUSE_OF_BUCKET if isinstance(store.place, Bucket) else _PAUSE
        self._arrived: list[PointRecord] = []
        self._written: list[PointRecord] = []
        self._error: Exception | None = None
        self._is_urgent = self._is_over = False
        self._changed = threading.Condition()
        self._is_idle = True
        self._thread = threading.Thread(target=self._run, name="writer", daemon=True)

    def __enter__(self) -> Writer:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._changed:
            self._is_over = self._is_urgent = True
            self._changed.notify_all()
        self._thread.join()
        if error is None:
            self._raise()

    def add(self, records: Iterable[PointRecord]) -> None:
        """Take results, to be written soon."""
        self._raise()
        with self._changed:
            self._arrived += records
            self._changed.notify_all()

    def written(self) -> list[PointRecord]:
        """Results that have been written since the last call."""
        self._raise()
        with self._changed:
            records, self._written = self._written, []
        return records

    def flush(self) -> None:
        """Wait until all results are written."""
        with self._changed:
            self._is_urgent = True
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._error or (self._is_idle and not self._arrived))
            self._is_urgent = False
        self._raise()

    def _raise(self) -> None:
        if self._error:
            raise self._error

    def _run(self) -> None:
        pause = 0.0
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._arrived or self._is_over)
                self._changed.wait_for(lambda: self._is_urgent, timeout=pause)
                records, self._arrived = self._arrived, []
                self._is_idle = False
                if not records and self._is_over:
                    return
            pause = self._commit(records)
            if self._error:
                return

    def _commit(self, records: Collection[PointRecord]) -> float:
        """Commit, and return the time until the next commit [s]."""
        began = time.monotonic()
        error: Exception | None = None
        try:
            self._store.commit(records)
        except Exception as raised:
            error = raised
        with self._changed:
            self._error = error
            self._written += () if error else records
            self._is_idle = True
            self._changed.notify_all()
        return min(max(self._pause, _SHARE * (time.monotonic() - began)), _LONGEST)
