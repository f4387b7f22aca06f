"""Report of a run: how far it is, and how long it will take."""

from __future__ import annotations

import sys
import time
from collections.abc import Collection
from typing import Any

import numpy as np

from pipeline.progress import Progress, Report, silent
from pipeline.store.schema import DONE, FAILED, NOT_NEEDED, PENDING
from pipeline.store.store import Store
from pipeline.sweep.plan import PointRecord


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
        asked = np.concatenate([one.flags[one.flags != NOT_NEEDED] for one in self._groups])
        done, failed, pending = (int(np.sum(asked == flag)) for flag in (DONE, FAILED, PENDING))
        time_to_go = None
        if self.computed:
            rounds = max(pending / max(workers, 1), min(pending, 1))
            time_to_go = rounds * self._seconds / self.computed
        elapsed = time.monotonic() - self._began
        self._progress(Progress("", done, asked.size, failed, elapsed, time_to_go))


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
