"""Chains of points on the threads of a cluster: what is computed where, and what a failure means.

A point is a task of its own, but short ones share a task with the next of their chain. The trunk
of a chain stays on the worker that computed it, as the result of a task. Should that worker die,
Dask runs the task again; its points are done by then, so that only the trunk is computed. No
result depends on any of this.
"""

from __future__ import annotations

import functools
import itertools
import math
import pickle
import queue
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from distributed import Client, Future
from distributed.scheduler import KilledWorker

from pipeline.run.cluster import LOST, ExecutionError, share, threads_of
from pipeline.store.points import Store, StoreError
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import Point, Trunk, advance_trunk, run_point
from tribo import TriboError

__all__ = ["PointFailedError", "compute"]

_POLL = 2.0  # [s] after which to look for workers that came or went
_STRETCH = 1.0  # [s] that a task should take, beside which Dask's 5 to 10 ms do not count

# Buffers of the transforms are shared within a process, whatever threads a given cluster has.
_one_at_a_time = threading.Lock()


class PointFailedError(TriboError):
    """A point that could not be computed; the store knows."""


class _Task(NamedTuple):
    """Points that follow each other, and the trunk after the last of them."""

    points: tuple[Point, ...]
    trunk: Future


@dataclass(eq=False)
class _Chain:
    """Points still to compute on one ramp, the trunk to go on from, and the worker with it.

    The tasks have the points before these, and each goes on from the one before. A suspect is a
    point that workers have died of before.
    """

    points: deque[Point]
    trunk: Future | None = None
    tasks: deque[_Task] = field(default_factory=deque)
    worker: str = ""
    since: float = 0.0  # when the first of the tasks could begin
    suspect: bool = False


def compute(
    client: Client,
    sweep: Sweep,
    store: Store,
    waiting: Iterable[tuple[Point, ...]],
    patience: float,
    report: Callable[..., None],
) -> None:
    """Compute chains of points, as many at a time as there are threads.

    Dask blames a dead worker on whatever it has been given to do, so that a thread is given one
    task at a time. What it needs the result of that for cannot be to blame, and so waits there
    already, unless so few chains are left that they should end together.

    Parameters
    ----------
    client : Client
    sweep : Sweep
    store : Store
    waiting : iterable of tuple of Point
    patience : float
        Time to wait for a worker, if there is none [s].
    report : callable
        Called with ``done=1`` or ``failed=1`` for each point that ends.
    """
    parcel = share(client, pickle.dumps(sweep), patience)
    fresh = deque(_Chain(deque(chain)) for chain in waiting)
    ready: list[_Chain] = []  # and begun, so that there are never many
    running: list[_Chain] = []
    suspects: list[_Chain] = []
    chain_of: dict[str, _Chain] = {}  # by the key of a task
    ended: queue.SimpleQueue[Future] = queue.SimpleQueue()

    def submit(chain: _Chain, length: int) -> None:
        points = tuple(chain.points.popleft() for _ in range(min(length, len(chain.points))))
        trunk = client.submit(
            _compute,
            parcel,
            store,
            points,
            chain.tasks[-1].trunk if chain.tasks else chain.trunk,
            pure=False,
            # Where a thread is to spare, and not where the parcel happens to be; or on any other
            # worker if that one dies.
            workers=chain.worker,
            allow_other_workers=True,
        )
        chain.tasks.append(_Task(points, trunk))
        chain_of[trunk.key] = chain
        trunk.add_done_callback(ended.put)

    length = 1  # of a stretch, until it is known how long points take
    threads, known_at = threads_of(client, patience), time.monotonic()
    while fresh or ready or running or suspects:
        if not (fresh or ready or running):
            ready, suspects = suspects, []
        if time.monotonic() - known_at > _POLL:
            threads, known_at = threads_of(client, patience), time.monotonic()
        last_ones = len(fresh) + len(ready) + len(running) < 2 * threads.total()
        if last_ones:
            left = sum(len(chain.points) for chain in (*fresh, *ready, *running))
            length = min(length, max(1, left // (2 * threads.total())))
        spare = _room(threads, (*ready, *running)) - Counter(chain.worker for chain in running)
        while (fresh or ready) and spare and len(running) < threads.total():
            ((worker, _),) = spare.most_common(1)
            chain = _next(fresh, ready, worker, last_ones)
            chain.worker, chain.since = worker, time.monotonic()
            submit(chain, length)
            running.append(chain)
            spare -= Counter([worker])
        for chain in running:
            if chain.points and len(chain.tasks) == 1 and not last_ones:
                submit(chain, length)
        try:
            key = ended.get(timeout=_POLL).key
        except queue.Empty:
            continue
        chain = chain_of.pop(key)
        if chain not in running:
            continue  # a task that failed along with the one before
        while chain.tasks and chain.tasks[0].trunk.done():
            task = chain.tasks.popleft()
            if task.trunk.status == "finished":
                chain.trunk, since, chain.since = task.trunk, chain.since, time.monotonic()
                length = math.ceil(len(task.points) * _STRETCH / (chain.since - since))
                for _ in task.points:
                    report(done=1)
            else:
                suspects += _recover(chain, task, store, report)
        if not chain.tasks:
            running.remove(chain)
            if chain.points:
                ready.append(chain)


def _room(threads: Counter[str], chains: Iterable[_Chain]) -> Counter[str]:
    """How many points each worker may be given: a single one if it is a suspect."""
    if any(chain.suspect for chain in chains):
        return Counter(dict.fromkeys(threads, 1))
    return threads


def _next(fresh: deque[_Chain], ready: list[_Chain], worker: str, last_ones: bool) -> _Chain:
    """Finish chains one by one, so that few trunks are kept; but let the last ones end together."""
    if last_ones:
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


def _recover(chain: _Chain, task: _Task, store: Store, report: Callable[..., None]) -> list[_Chain]:
    """Take note of why a task failed, and of what its chain goes on with.

    Returns new suspects.
    """
    failed_along = [point for later in chain.tasks for point in later.points]
    chain.tasks.clear()
    chain.points.extendleft(reversed((*task.points, *failed_along)))
    error = _error(task.trunk)
    if isinstance(error, StoreError | ExecutionError):
        raise error
    left = list(itertools.dropwhile(store.is_done, task.points))
    for _ in range(len(task.points) - len(left)):
        chain.points.popleft()
        report(done=1)
    if isinstance(error, KilledWorker):
        trunk, chain.trunk = chain.trunk, None
        if error.task != task.trunk.key and trunk is not None:
            return []  # the trunk's fault; without it, the same point begins at the start
    if not left:
        return []
    point = chain.points.popleft()
    if isinstance(error, KilledWorker):
        if not chain.suspect:
            # Whoever kills workers at random hits the same point twice before long, so it is
            # tried once more, when nothing else is left that could suffer from it.
            return [_Chain(deque([point]), suspect=True)]
        error = PointFailedError(
            "every worker process that computed it died, and the next one again: "
            "out of memory, or killed from outside"
        )
        store.fail(point, str(error))
    elif not isinstance(error, PointFailedError):
        store.fail(point, _text(error))
    report(failed=1)
    return []


def _error(task: Future) -> BaseException:
    """Why a task did not finish."""
    if task.status != "error":
        return ExecutionError(LOST)
    error: BaseException = task.exception()
    return ExecutionError(LOST) if isinstance(error, CancelledError) else error


# On the workers.


@dataclass(frozen=True, eq=False)
class _Kept:
    """A trunk, which stays as it is for the next point on the same worker.

    On its way to another it is bytes: arrays that Dask rebuilds from its own messages may lie at
    odd addresses, and NumPy sums such arrays in another order.
    """

    trunk: Trunk | None

    def __reduce__(self) -> tuple[Any, ...]:
        return _kept, (pickle.dumps(self.trunk),)


def _kept(trunk: bytes) -> _Kept:
    return _Kept(pickle.loads(trunk))


@functools.lru_cache(maxsize=1)
def _unpacked(parcel: bytes) -> Sweep:
    sweep: Sweep = pickle.loads(parcel)
    return sweep


def _compute(parcel: bytes, store: Store, points: tuple[Point, ...], kept: _Kept | None) -> _Kept:
    """Compute and commit points, one after the other; return the trunk."""
    sweep, trunk = _unpacked(parcel), kept.trunk if kept else None
    for point in points:
        with _one_at_a_time:
            if store.is_done(point):  # Dask asks again, since the trunk was lost with a worker
                trunk = advance_trunk(sweep, *point, trunk)
                continue
            try:
                result = run_point(sweep, *point, trunk)
            except Exception as error:
                store.fail(point, _text(error))
                raise PointFailedError(_text(error)) from None
        store.commit(result)
        trunk = result.trunk
    return _Kept(trunk)


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
