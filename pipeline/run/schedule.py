"""Computes chains of points on the threads of a cluster.

A task computes points of one chain for about a second, and the next task of the chain depends on
the trunk that it leaves. Short chains of one surface share a task. Dask decides what runs where,
and runs a task again if its trunk was lost. Records of the points go to the driver, whose writer
commits them; points whose records were lost with a worker are submitted anew.

A worker that dies takes with it whatever it was given to do, and does not say what it died of. So
the point at which each lost task was is suspected, and tried again in the end on a worker that
computes nothing else. Kills from outside hit the same point again now and then, but not time after
time: a point fails that kills even workers of its own.
"""

from __future__ import annotations

import itertools
import pickle
from bisect import bisect_left
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace

from distributed import Future
from distributed.scheduler import KilledWorker

from pipeline.run.cluster import (
    LOST,
    Connection,
    gathered,
    is_processed,
    require_same_code,
    share,
    threads_of,
    wait_for_any,
)
from pipeline.run.source import SAFE, ExecutionError
from pipeline.run.versions import other_packages, packages_of
from pipeline.run.work import compute_points, records_of
from pipeline.run.writer import Writer
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord

TRIALS = 5  # alone, that a point may be lost in before it is called failed
_STRETCH = 1.0  # [s] that a task should take, beside which 5 ms of Dask do not count
_JOINED = 48  # points of a task: such short ones as fill a stretch, and few to be sent
_POLL = 2.0  # [s] after which to look for workers that came or went
_WORD = 60.0  # [s] without a task that ends, after which the user is told; then after twice that
_END = 300.0  # [s] without a worker that computes, after which the sweep is given up
_KILLED = (
    "every worker process that computed it died, and the next one again: "
    "out of memory, or killed from outside"
)


@dataclass(frozen=True, slots=True)
class _Chain:
    """Points still to compute on one ramp, and the trunk to go on from, if there is one.

    One that was lost with a worker is wary: each task computes one point of it.
    """

    points: tuple[Point, ...]
    trunk: Future | None = None
    is_wary: bool = False


@dataclass(frozen=True, slots=True)
class _Task:
    """Points that a task computes, its result and their records; its worker if it runs alone."""

    points: tuple[Point, ...]
    stretch: Future
    records: Future
    alone_on: str | None = None
    is_wary: bool = False

    @property
    def keys(self) -> tuple[str, str]:
        """Names of both for Dask."""
        return self.stretch.key, self.records.key


def compute(
    connection: Connection,
    sweep: Sweep,
    writer: Writer,
    waiting: Iterable[tuple[Point, ...]],
    report: Callable[[list[PointRecord]], None],
) -> None:
    """Compute chains of points, until the writer has written each of them as done or failed.

    `report` is called now and then with the records that have been written since the last call.

    Raises
    ------
    StoreError
        If points cannot be written.
    ExecutionError
        If the cluster is lost, or nothing moves any more.
    """
    workers = threads_of(connection)
    run = _Run(connection, sweep, writer, map(_Chain, waiting))
    while run.waiting or run.running or run.losses:
        workers = threads_of(connection)
        run.submit(workers)
        wait_for_any([task.records for task in run.running], _POLL)
        moved = run.look(workers)
        report(writer.written())
        run.watch(moved)
    writer.flush()
    report(writer.written())


class _Run:
    """Chains that wait for a thread, tasks that run, and points that workers may die of.

    `losses` are the suspects, and how often each was lost while it was tried alone.
    """

    def __init__(
        self, connection: Connection, sweep: Sweep, writer: Writer, waiting: Iterable[_Chain]
    ) -> None:
        self._connection, self._client = connection, connection.client
        self._writer, self._sweep = writer, sweep
        with_fields = "pressure" in writer.store.arrays
        self._pickled = pickle.dumps((sweep.changed(chosen=None), with_fields))
        self._parcel = share(connection, self._pickled)
        self.waiting = deque(waiting)
        self.running: list[_Task] = []
        self.losses: dict[Point, int] = {}
        self._ended = self._computed = connection.clock()
        self._word = _WORD

    def submit(self, workers: Counter[str]) -> None:
        """Give the workers a task for each thread; in the end, give each one suspect alone.

        Dask counts the death of a worker against all tasks that it was given, so it is given no
        more than it can begin at once.
        """
        if self.waiting or any(task.alone_on is None for task in self.running):
            while self.waiting and len(self.running) < workers.total():
                self._start(self._next(workers.total()))
            return
        tried = {task.points[0] for task in self.running}
        free = set(workers) - {task.alone_on for task in self.running}
        suspects = sorted(self.losses, key=lambda point: self.losses[point])
        untried = (point for point in suspects if point not in tried)
        for worker, point in zip(free, untried, strict=False):
            self._start(_Chain((point,)), worker)

    def _next(self, threads: int) -> _Chain:
        """Take the next chain: the first, so that few trunks are kept; near the end the longest."""
        if self._are_many(threads):
            return self._joined(self.waiting.popleft(), threads)
        chain = max(self.waiting, key=lambda chain: len(chain.points))
        self.waiting.remove(chain)
        return chain

    def _are_many(self, threads: int) -> bool:
        """True if more chains wait than keep the workers busy to the end."""
        return len(self.waiting) + len(self.running) >= 2 * threads

    def _joined(self, chain: _Chain, threads: int) -> _Chain:
        """A chain with its neighbours of the same surface that wait behind it, if many do."""
        first, place, points = chain, chain.points[0].variant, list(chain.points)
        while not self._sweep.plane.independent and self._are_many(threads) and self.waiting:
            after = self.waiting[0]
            if after.trunk or after.is_wary or chain.is_wary or after.points[0].variant != place:
                break
            # Those of the coarse pass are far apart, and begin on all workers at once: joined, the
            # first picture of 10 000 points would have a few velocities of one end alone.
            if self._rank(after) != self._rank(chain) + 1:
                break
            chain = after
            if len(points) + len(after.points) > _JOINED:
                break
            points += self.waiting.popleft().points
        return replace(first, points=tuple(points))

    def _rank(self, chain: _Chain) -> int:
        """Place of a chain's velocity among those of the sweep."""
        return bisect_left(self._sweep.plane.velocities, chain.points[0].velocity)

    def _put_back(
        self, left: Iterable[Point], trunk: Future | None = None, is_wary: bool = False
    ) -> None:
        """Let points wait again, each ramp as a chain; the first one has a trunk."""
        ramps = itertools.groupby(left, key=self._sweep.contact_of)
        chains = [_Chain(tuple(points), None, is_wary) for _, points in ramps]
        if chains:
            chains[0] = replace(chains[0], trunk=trunk)
        self.waiting.extendleft(reversed(chains))

    def _start(self, chain: _Chain, worker: str | None = None) -> None:
        parcel = self._parcel
        if isinstance(parcel, Future) and parcel.status in ("error", "cancelled"):  # none has it
            self._parcel = share(self._connection, self._pickled)
        points = deque(chain.points)  # in a tuple, Dask would look for tasks point by point
        arguments = (self._parcel, points, chain.trunk, 0.0 if chain.is_wary else _STRETCH)
        stretch = self._client.submit(compute_points, *arguments, pure=False, workers=worker)
        records = self._client.submit(records_of, stretch, pure=False, workers=worker)
        self.running.append(_Task(chain.points, stretch, records, worker, chain.is_wary))

    def look(self, workers: Counter[str]) -> bool:
        """See what has become of the tasks; return whether any has ended."""
        ended = [task for task in self.running if self._has_ended(task, workers)]
        self.running = [task for task in self.running if task not in ended]
        return bool(ended)

    def _has_ended(self, task: _Task, workers: Counter[str]) -> bool:
        died = task.alone_on is not None and task.alone_on not in workers
        if not (died or task.records.done()):
            return False
        error = _error(task)
        if isinstance(error, ExecutionError):
            raise error
        if died or error:
            self._recover(task, error)
            return True
        result = gathered(task.records, self._connection.patience)
        if result is None:
            return False  # lost on the way; Dask computes it again
        theirs, content = result
        require_same_code(theirs, f"that computed {task.points[0]}")
        if other_packages(theirs):
            self._writer.store.note_worker(packages_of(theirs))
        records: tuple[PointRecord, ...] = pickle.loads(content)
        self._settle(records)
        if left := task.points[len(records) :]:
            self._put_back(left, task.stretch, task.is_wary)
        return True

    def _settle(self, records: Collection[PointRecord]) -> None:
        """Take records of points that are done or have failed."""
        self._writer.add(records)
        for record in records:
            self.losses.pop(record.point, None)

    def _recover(self, task: _Task, error: BaseException | None) -> None:
        """Go on point by point after a loss; suspect the point at which that is lost."""
        alone = task.alone_on is not None
        if isinstance(error, KilledWorker) and error.task not in task.keys:
            # What it depends on was lost too often; it goes on without.
            if not alone:
                self._put_back(task.points, None, task.is_wary)
            return
        if len(task.points) > 1 and not task.is_wary:  # it may have been at any of them
            self._put_back(task.points, None, is_wary=True)
            return
        suspect, *others = task.points
        self.losses[suspect] = self.losses.get(suspect, 0) + alone
        self._put_back(others, None, task.is_wary)
        if self.losses[suspect] >= TRIALS:
            killed = error is None or isinstance(error, KilledWorker)
            reason = _KILLED if killed else f"{type(error).__name__}: {error}"
            self._settle([PointRecord(suspect, None, reason)])

    def watch(self, moved: bool) -> None:
        """Tell the user if nothing has ended for long.

        A point may take its time: as long as a worker computes one, there is no limit. But if tasks
        wait and no worker has been given one, something is wrong.

        Raises
        ------
        ExecutionError
            If no worker computes any more.
        """
        now = self._connection.clock()
        keys = {key for task in self.running for key in task.keys}
        others = f" and {n} more" if (n := len(self.running) - 1) > 0 else ""
        if moved:
            self._ended, self._word = now, _WORD
        if moved or is_processed(self._connection, keys):
            self._computed = now
        silence = now - self._ended
        words = f"no point has been finished for {silence:.0f} s"
        if now - self._computed > _END:
            raise ExecutionError(f"{words}, and no worker computes any; {SAFE}")
        if silence >= self._word:
            self._word *= 2
            first = next((f"{task.points[0]}{others}" for task in self.running), "a worker")
            self._connection.tell(f"{words}; waiting for {first}")


def _error(task: _Task) -> BaseException | None:
    """Reason why a task did not finish, if it did not."""
    for future in (task.stretch, task.records):
        error: BaseException | None = future.exception() if future.status == "error" else None
        if future.status == "cancelled" or isinstance(error, CancelledError):
            return ExecutionError(LOST)
        if error:
            return error
    return None
