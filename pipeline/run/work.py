"""What a worker does: compute points of a chain, one after the other, and commit them together.

To commit several points that share chunks costs hardly more than one of them, some milliseconds. So
what takes no longer than about a second to compute is kept until then.

The trunk that it ends with is the result of the task, which stays on the worker for the next task
of the chain. Should that worker die, Dask runs the task again; as far as its points are done by
then, only the trunk is computed. No result depends on any of this.
"""

from __future__ import annotations

import functools
import pickle
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pipeline.store import Store
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointResult, Trunk, advance_trunk, run_point

_KEPT = 1.0  # [s] of work, after which it is committed: as much as a kill may cost

# Buffers of the transforms are shared within a process, whatever threads a given cluster has.
_one_at_a_time = threading.Lock()


def same(content: bytes) -> bytes:
    """What it is given, as the result of a task."""
    return content


@dataclass(frozen=True, eq=False)
class Kept:
    """A trunk and its ramp, kept as they are for the next point on the same worker.

    On its way to another it is bytes: arrays that Dask rebuilds from its own messages may lie at
    odd addresses, and NumPy sums such arrays in another order.
    """

    trunk: Trunk | None
    ramp: tuple[Any, ...] | None

    def __reduce__(self) -> tuple[Any, ...]:
        return _kept, (pickle.dumps((self.trunk, self.ramp)),)


def _kept(parts: bytes) -> Kept:
    return Kept(*pickle.loads(parts))


def compute_points(
    parcel: bytes, points: Iterable[Point], kept: Kept | None, seconds: float
) -> Kept:
    """Compute points of one or more chains, at least one, until the time is up.

    A point that fails is recorded, and the next one goes on from the same trunk. What is done
    already is passed by: then Dask runs the task again for the sake of its trunk, and no more is
    computed than that.

    Parameters
    ----------
    parcel : bytes
        The pickled sweep and its store, which a scheduler elsewhere may not see.
    points : iterable of Point
        Points, those of a chain in the order of their loads.
    kept : Kept or None
        The trunk to go on from.
    seconds : float
        Time after which no further point is begun [s].

    Returns
    -------
    Kept
        The trunk to go on from.

    Raises
    ------
    StoreError
        If a point cannot be recorded, or the store is not seen here as it is by the driver.
    """
    sweep, store = _unpacked(parcel)
    trunk, ramp = (kept.trunk, kept.ramp) if kept else (None, None)
    end = time.monotonic() + seconds
    restoring = False
    finished = _Finished(store)
    try:
        for point in points:
            if point[1:] != ramp:
                trunk, ramp = None, point[1:]
            with _one_at_a_time:
                if store.is_done(point):
                    trunk, restoring = advance_trunk(sweep, *point, trunk=trunk), True
                    continue
                if restoring:
                    break
                try:
                    result = run_point(sweep, *point, trunk=trunk)
                except Exception as error:
                    store.fail(point, f"{type(error).__name__}: {error}")
                    continue
            finished.add(result)
            trunk = result.trunk
            if time.monotonic() > end:
                break
    finally:
        finished.commit()
    return Kept(trunk, ramp)


class _Finished:
    """Results that wait to be committed together, however long the next point takes."""

    def __init__(self, store: Store) -> None:
        self._store, self._results = store, list[PointResult]()
        self._error: Exception | None = None
        self._committing = threading.Lock()
        self._last = time.monotonic()
        self._timer: threading.Timer | None = None

    def add(self, result: PointResult) -> None:
        """Take a result; commit all of them if that is due, or saves nothing."""
        with self._committing:
            self._results.append(result)
            is_due = time.monotonic() - self._last > _KEPT or not self._store.is_shared
            if not (is_due or self._timer):
                self._timer = threading.Timer(_KEPT, self._commit_late)
                self._timer.daemon = True
                self._timer.start()
        if is_due:
            self.commit()

    def commit(self) -> None:
        """Put them on the disk; raise as `Store.commit` does, also what it raised meanwhile."""
        with self._committing:
            if self._timer:
                self._timer.cancel()
                self._timer = None
            if self._error:
                raise self._error
            results, self._results = self._results, []
            self._store.commit(*results)
            self._last = time.monotonic()

    def _commit_late(self) -> None:
        try:
            self.commit()
        except Exception as error:
            self._error = error


@functools.lru_cache(maxsize=1)
def _unpacked(parcel: bytes) -> tuple[Sweep, Store]:
    found: tuple[Sweep, Store] = pickle.loads(parcel)
    return found
