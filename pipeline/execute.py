"""A sweep on a Dask cluster: each point is one task, and continues the ramp of the one below it.

The trunk of a chain stays on the worker that computed it, as the result of a task. Should that
worker die, Dask runs the task again; its point is done by then, so that only the trunk is
computed. No result depends on any of this.

::

    TriboError
    ├── ExecutionError     the cluster does not start, or is lost (pipeline.cluster)
    └── PointFailedError   on its way from a worker: why a point failed, as the store has it
"""

from __future__ import annotations

import functools
import multiprocessing
import pickle
import queue
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from dataclasses import dataclass

from dask.system import CPU_COUNT
from distributed import Client, Future
from distributed.scheduler import KilledWorker

from pipeline.cluster import (
    LOST,
    PATIENCE,
    ExecutionError,
    connected,
    dashboard_of,
    share,
    threads_of,
)
from pipeline.compact import lay_out
from pipeline.folder import PathLike
from pipeline.layout import BY_POINT, COMPACT, versions
from pipeline.plan import Point, Trunk, advance_trunk, chains, points, run_point
from pipeline.store import (
    DONE,
    FAILED,
    PENDING,
    FailedPoint,
    Store,
    StoreError,
    Summary,
    locked,
    prepare,
)
from pipeline.sweep import Sweep
from tribo import InputError, TriboError

__all__ = ["ExecutionError", "Outcome", "PointFailedError", "Progress", "run_sweep"]

_MANY = 2000  # points, from which compacting is worth a word
_POLL = 2.0  # [s] after which to look for workers that came or went

# Buffers of the transforms are shared within a process, whatever threads a given cluster has.
_one_at_a_time = threading.Lock()


class PointFailedError(TriboError):
    """A point that could not be computed; the store knows."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run has come.

    Attributes
    ----------
    done, failed, total : int
        Points of the sweep, those of earlier runs included.
    elapsed : float
        Since this run began [s].
    time_to_go : float or None
        Estimated [s]; None until the first point is done.
    """

    done: int
    failed: int
    total: int
    elapsed: float
    time_to_go: float | None


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a run leaves.

    Attributes
    ----------
    total, done : int
        Points of the sweep, and those of them that are done.
    computed : int
        Points that this run completed.
    failed : tuple of FailedPoint
        Points that failed, now or in an earlier run.
    wall_time : float
        Of this run [s].
    """

    total: int
    done: int
    computed: int
    failed: tuple[FailedPoint, ...]
    wall_time: float


def run_sweep(
    sweep: Sweep,
    out: PathLike,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[Progress], None] | None = None,
    retry_failed: bool = False,
    further: Callable[[], Sweep | None] | None = None,
    tell: Callable[[str], None] | None = None,
    patience: float = PATIENCE,
    fill_fields: bool = False,
) -> Outcome:
    """Compute every point of a sweep that its store does not have yet.

    In a script, call it under ``if __name__ == "__main__":``, since workers import the script.

    Parameters
    ----------
    sweep : Sweep
    out : str or path
        Of the store; it is created, resumed or extended.
    workers : int, optional
        Number of processes; one for each core that this process may use if not given.
    scheduler : str, optional
        Address of a Dask scheduler to use instead. Its workers need this package and see the
        store under the same path.
    progress : callable, optional
        Called with a `Progress` at the start and after each point.
    retry_failed : bool, optional
        Whether to try points again that failed in an earlier run.
    further : callable, optional
        Called when every point is done or has failed: gives the same sweep with more points, to
        go on with, or None.
    tell : callable, optional
        Called with a line for the user, such as where the cluster's dashboard is.
    patience : float, optional
        How long to wait for a scheduler to answer, and for workers if there are none [s].
    fill_fields : bool, optional
        Whether to compute points again that were finished before the scene asked for fields.

    Raises
    ------
    StoreMismatchError
        If `out` is the store of another scene.
    StoreError
        If the store is in use or cannot be written. Finished points are safe.
    ExecutionError
        If the cluster does not start or is lost. Finished points are safe.
    """
    if workers is not None and workers < 1:
        raise InputError(f"workers is {workers}; it must be at least 1")
    if multiprocessing.parent_process() is not None and scheduler is None:
        raise ExecutionError(
            "a worker process cannot run a sweep; in a script, call run_sweep under "
            'if __name__ == "__main__":'
        )
    began = time.monotonic()
    checked: set[Point] = set()
    with locked(out):
        store = prepare(out, sweep)
        if fill_fields:
            for point in _without_fields(store, sweep):
                store.forget(point)
        if tell:
            for note in _notes(store, sweep):
                tell(note)
        waiting = chains(_todo(store, sweep, retry_failed, checked), sweep.independent)
        tally = _Tally(store.summary(), began, progress)
        more = None if waiting or further is None else further()
        was_compact = store.is_compact
        if waiting or more:
            if was_compact:
                lay_out(store.path, BY_POINT)
                store = Store(store.path)
            # Points that come later may have more chains than those that wait now.
            least = len(waiting) if further is None else CPU_COUNT
            with connected(min(workers or CPU_COUNT, least), scheduler, patience) as client:
                if tell and (dashboard := dashboard_of(client)):
                    tell(f"the cluster's dashboard is at {dashboard}")
                while True:
                    if waiting:
                        _run(client, sweep, store, waiting, tally, patience)
                    more = more or (further() if further else None)
                    if more is None:
                        break
                    sweep, more = more, None
                    store = prepare(out, sweep)
                    waiting = chains(_todo(store, sweep, False, checked), sweep.independent)
                    tally.widen(store.summary())
            if was_compact:
                lay_out(store.path, COMPACT)
                store = Store(store.path)
        found = store.summary()
    if tell and found.total >= _MANY and not was_compact:
        tell(f"{out} opens faster after: irg compact {out}")
    return Outcome(
        total=found.total,
        done=found.done,
        computed=tally.computed,
        failed=found.failed,
        wall_time=time.monotonic() - began,
    )


def _without_fields(store: Store, sweep: Sweep) -> list[Point]:
    """Points that were finished before the scene asked for fields."""
    if not sweep.store_fields:
        return []
    status = store.status()
    done = (point for point in points(sweep) if status[point] == DONE)
    return [point for point in done if store.lacks_fields(point)]


def _notes(store: Store, sweep: Sweep) -> Iterable[str]:
    """What to know before going on with a store."""
    for name, present in versions().items():
        if (before := store.attributes["versions"][name]) != present:
            yield (
                f"{store.path} was begun with {name} {before}, and goes on with {present}: "
                "new points may differ from the others in the last digits"
            )
    if lacking := len(_without_fields(store, sweep)):
        yield (
            f"{lacking} points were finished before the scene asked for fields, and have none; "
            "--fill-fields computes them again"
        )


def _todo(store: Store, sweep: Sweep, retry_failed: bool, checked: set[Point]) -> list[Point]:
    """Points to compute: those pending, those damaged, and those that failed if asked for.

    What is done is read once in a run to see whether it is intact; those points are `checked`.
    """
    status, asked = store.status(), set(points(sweep))
    for point in (place for place in store.places() if place in asked):  # chunk after chunk
        done = status[point] == DONE and point not in checked
        damaged = done and not store.is_intact(point)
        if damaged or (retry_failed and status[point] == FAILED):
            store.forget(point)
            status[point] = PENDING
    checked.update(asked)
    return [point for point in points(sweep) if status[point] == PENDING]


class _Tally:
    """Counts the points and tells the caller."""

    def __init__(
        self, found: Summary, began: float, progress: Callable[[Progress], None] | None
    ) -> None:
        self.computed = 0
        self._total, self._done, self._failed = found.total, found.done, len(found.failed)
        self._began, self._progress = began, progress
        self.report()

    def widen(self, found: Summary) -> None:
        """Take note of points that were added."""
        self._total, self._done, self._failed = found.total, found.done, len(found.failed)
        self.report()

    def report(self, done: int = 0, failed: int = 0) -> None:
        self.computed += done
        self._done += done
        self._failed += failed
        if self._progress is None:
            return
        elapsed = time.monotonic() - self._began
        pending = self._total - self._done - self._failed
        time_to_go = elapsed / self.computed * pending if self.computed else None
        self._progress(Progress(self._done, self._failed, self._total, elapsed, time_to_go))


@dataclass(eq=False)
class _Chain:
    """Points still to compute on one ramp, the trunk to go on from, and the worker with it.

    A suspect is a point that workers have died of before.
    """

    points: deque[Point]
    trunk: Future | None = None
    worker: str = ""
    suspect: bool = False


def _run(
    client: Client,
    sweep: Sweep,
    store: Store,
    waiting: Iterable[tuple[Point, ...]],
    tally: _Tally,
    patience: float,
) -> None:
    """Compute all points, as many at a time as there are threads."""
    parcel = share(client, pickle.dumps(sweep), patience)
    fresh = deque(_Chain(deque(chain)) for chain in waiting)
    ready: list[_Chain] = []  # and begun, so that there are never many
    suspects: list[_Chain] = []
    running: dict[str, tuple[_Chain, Future]] = {}
    ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
    while fresh or ready or running or suspects:
        if not (fresh or ready or running):
            ready, suspects = suspects, []
        threads = threads_of(client, patience)
        spare = threads - Counter(chain.worker for chain, _ in running.values())
        while (fresh or ready) and spare and len(running) < threads.total():
            ((worker, _),) = spare.most_common(1)
            chain = _next(fresh, ready, worker, len(running), threads.total())
            task = client.submit(
                _compute,
                parcel,
                store,
                *chain.points[0],
                chain.trunk,
                pure=False,
                # Where a thread is to spare, and not where the parcel happens to be; or on any
                # other worker if that one dies.
                workers=worker,
                allow_other_workers=True,
            )
            task.add_done_callback(ended.put)
            chain.worker, running[task.key] = worker, (chain, task)
            spare -= Counter([worker])
        try:
            key = ended.get(timeout=_POLL).key
        except queue.Empty:
            continue
        chain, task = running.pop(key)
        suspects += _conclude(chain, task, store, tally)
        if chain.points:
            ready.append(chain)


def _next(
    fresh: deque[_Chain], ready: list[_Chain], worker: str, running: int, threads: int
) -> _Chain:
    """Finish chains one by one, so that few trunks are kept; but let the last ones end together."""
    if len(fresh) + len(ready) + running < 2 * threads:
        ready += fresh
        fresh.clear()
        chosen = max(ready, key=lambda chain: (len(chain.points), chain.worker == worker))
    else:
        if fresh:
            ready.append(fresh.popleft())
        chosen = max(ready, key=lambda chain: (chain.worker == worker, chain.trunk is not None))
        if ready[-1] is not chosen and not ready[-1].worker:
            fresh.appendleft(ready.pop())
    ready.remove(chosen)
    return chosen


def _conclude(chain: _Chain, task: Future, store: Store, tally: _Tally) -> list[_Chain]:
    """Take note of how a task ended, and of what its chain goes on from; give new suspects."""
    point = chain.points[0]
    if task.status == "finished":
        chain.trunk = task
        chain.points.popleft()
        tally.report(done=1)
        return []
    error = _error(task)
    if isinstance(error, StoreError | ExecutionError):
        raise error
    if isinstance(error, KilledWorker):
        trunk, chain.trunk = chain.trunk, None
        if error.task != task.key and trunk is not None:
            return []  # the trunk's fault; without it, the same point begins at the start
        if not chain.suspect:
            # Whoever kills workers at random hits the same point twice before long, so it is
            # tried once more, when nothing else is left that could suffer from it.
            chain.points.popleft()
            return [_Chain(deque([point]), suspect=True)]
        error = PointFailedError(
            "every worker process that computed it died, and the next one again: "
            "out of memory, or killed from outside"
        )
        store.fail(point, str(error))
    elif not isinstance(error, PointFailedError):
        store.fail(point, _text(error))
    chain.points.popleft()
    tally.report(failed=1)
    return []


def _error(task: Future) -> BaseException:
    """Why a task did not finish."""
    if task.status != "error":
        return ExecutionError(LOST)
    error: BaseException = task.exception()
    return ExecutionError(LOST) if isinstance(error, CancelledError) else error


# On the workers. Arrays travel inside bytes: those that Dask rebuilds from its own messages may
# lie at odd addresses, and NumPy sums such arrays in another order.


@functools.lru_cache(maxsize=1)
def _unpacked(parcel: bytes) -> Sweep:
    sweep: Sweep = pickle.loads(parcel)
    return sweep


def _compute(
    parcel: bytes,
    store: Store,
    load: float,
    velocity: float,
    realization: int | None,
    trunk: bytes | None,
) -> bytes:
    """Compute and commit a point; return the trunk."""
    with _one_at_a_time:
        sweep = _unpacked(parcel)
        before: Trunk | None = pickle.loads(trunk) if trunk else None
        point = Point(load, velocity, realization)
        if store.is_done(point):  # Dask asks again, since the trunk was lost with a worker
            return pickle.dumps(advance_trunk(sweep, *point, before))
        try:
            result = run_point(sweep, *point, before)
        except Exception as error:
            store.fail(point, _text(error))
            raise PointFailedError(_text(error)) from None
        store.commit(result)
        return pickle.dumps(result.trunk)


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
