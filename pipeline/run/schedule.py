"""Computes the points of a sweep as independent tasks of Dask.

A worker with a free place gets a task, so that each has one waiting: the graph depends on no time.
About once a second each worker is asked for the records that lie there; the writer commits them,
and only then are they told as done.

Points that were on a worker as it died are suspected, and tried again in the end, each alone on a
worker; those fail that kill even that, time after time.
"""

from __future__ import annotations

import itertools
import pickle
import threading
import uuid
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, field, replace

from distributed import Future
from distributed.scheduler import KilledWorker

from pipeline.run.cluster import LOST, Connection, present_threads, threads_of
from pipeline.run.tally import Reports, Tally
from pipeline.run.work import (
    SAFE,
    ExecutionError,
    UnsentError,
    WorkerReport,
    compute_points,
    other_packages,
    packages_of,
    parcel_of,
    require_same_code,
)
from pipeline.store.write import Writer
from pipeline.sweep.hand_out import HandOut
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, Task
from pipeline.sweep.stages import duration

TRIALS = 5
"""Times that a point may be lost alone before it is called failed."""
STARTS = 3
"""Workers that may leave in the midst of a point before it is called failed."""

ANYWHERE = ""
"""Worker of a task that any one may take."""

_TO_COME = 16  # tasks that wait for workers to come
_AHEAD = 2  # tasks for each worker: one that it computes, and one that waits
_POLL = 1.0  # [s] between looks at the workers, and at what lies there
_SOONER = 0.1  # share of the time since the beginning that is between them, until that is more
_WORD = 60.0  # [s] without a task that ends, after which the user is told; then after twice that
_END = 300.0  # [s] without a worker that computes, after which the sweep is given up
_KILLED = (
    "each worker process that computed it died, also when it was tried alone: "
    "out of memory, or killed from outside"
)
_TOO_LONG = (
    "begun on {} workers, and each left before it was done, after {}: let workers live longer, "
    "or take a coarser fidelity"
)


@dataclass(slots=True, eq=False)
class _Running:
    """A task on the worker that it was given to, perhaps alone.

    `begun` are the workers that were seen computing it, and when first and last [s].
    """

    task: Task
    future: Future
    worker: str
    is_alone: bool
    begun: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def points(self) -> tuple[Point, ...]:
        """Points of the task."""
        return self.task.points


def compute(
    connection: Connection, sweep: Sweep, writer: Writer, waiting: Iterable[Task], tally: Tally
) -> None:
    """Compute tasks, until the writer has written each of their points as done or failed.

    The tally learns from records as they come from a worker, except its first, and notes those
    written. `StoreError` if points cannot be written, `ExecutionError` if nothing moves.
    """
    news, label = threading.Event(), uuid.uuid4().hex[:8]  # a scheduler may know other runs
    asked = replace(sweep, chosen=None, stations=writer.store.sweep.stations)
    parcel = parcel_of(asked, "pressure" in writer.store.arrays)
    with Reports(connection, news, label, parcel) as reports:
        run = _Run(connection, label, writer, reports, tally, waiting)
        silence = _Silence(connection)
        if connection.adapts or not present_threads(connection):
            run.submit_for_later()
        while run.is_under_way():
            moved = run.look()
            run.submit()
            if connection.adapts:
                run.submit_for_later()
            tally.count(writer.written())
            silence.watch(moved, run.computes, run.running)
            news.wait(_POLL)
            news.clear()
    writer.flush()
    tally.count(writer.written())


class _Run:
    """Tasks that wait, and those that are `running`, or `computed`, with records on a worker.

    `computes` is true if a worker said so when it was asked last.
    """

    def __init__(
        self,
        connection: Connection,
        label: str,
        writer: Writer,
        reports: Reports,
        tally: Tally,
        waiting: Iterable[Task],
    ) -> None:
        self._connection, self._writer, self._reports = connection, writer, reports
        self._label, self._tally, self._waiting = label, tally, HandOut(waiting)
        self._numbers = itertools.count()
        self._losses: dict[Point, int] = {}  # losses of each suspect while it was tried alone
        self._workers: Counter[str] = Counter()
        self._began = connection.clock()
        self._looked = -_POLL
        self._warm: set[str] = set()  # workers that have told of a point
        self._noted: set[str] = set()  # versions that the user was told of
        self._is_idle_told = False
        self._begun: dict[tuple[Point, ...], dict[str, tuple[float, float]]] = {}
        self._moved: Counter[tuple[Point, ...]] = Counter()  # tasks whose worker was gone
        self.running: list[_Running] = []
        self.computed: dict[str, _Running] = {}
        self.computes = True

    def is_under_way(self) -> bool:
        """True as long as a point is not known as done or failed."""
        return bool(self._waiting or self.running or self.computed or self._losses)

    # Tasks begin

    def submit(self) -> None:
        """Fill the workers' places, as a death counts against all there; last suspects alone."""
        busy = Counter(one.worker for one in self.running)
        for places in range(1, _AHEAD + 1):  # first those where nothing runs
            # One that has not answered yet may run other code, and has no scene.
            for worker in filter(self._reports.knows, self._workers):
                while self._waiting and busy[worker] < places:
                    self._start(self._waiting.take(worker), worker)
                    busy[worker] += 1
        if self._waiting or not self._losses or any(not one.is_alone for one in self.running):
            return
        self._workers = threads_of(self._connection)  # one that is gone would count as a loss
        tried = {one.points[0] for one in (*self.running, *self.computed.values())}
        free = {*filter(self._reports.knows, self._workers)} - {one.worker for one in self.running}
        suspects = sorted(self._losses, key=self._losses.__getitem__)
        untried = (point for point in suspects if point not in tried)
        for worker, point in zip(free, untried, strict=False):
            self._start(Task((point,), ()), worker, is_alone=True)

    def submit_for_later(self) -> None:
        """Begin ramps for workers that are to come: adaptive clusters start them for tasks."""
        missing = _TO_COME - len(self.running)
        for number in range(missing):
            if self._waiting:
                self._start(self._waiting.take((ANYWHERE, number)), ANYWHERE)

    def _start(self, task: Task, worker: str, is_alone: bool = False) -> None:
        number = next(self._numbers)
        name = f"point-{_short_name(task.points)}-{self._label}-{number}"
        # Without a priority Dask orders tasks of one moment by chance.
        future = self._connection.client.submit(
            compute_points, name, self._label, task.points,
            key=name, workers=worker or None, allow_other_workers=bool(worker and not is_alone),
            priority=-number,
        )  # fmt: skip
        future.add_done_callback(self._reports.wake)
        begun = self._begun.setdefault(task.points, {})
        self.running.append(_Running(task, future, worker, is_alone, begun))

    # Tasks end

    def look(self) -> bool:
        """See what has become of the tasks; return whether any has ended."""
        ended = [task for task in self.running if task.future.done()]
        self.running = [task for task in self.running if task not in ended]
        self.computed |= {task.future.key: task for task in ended}
        for key, task in [*self.computed.items()]:
            if task.future.status in ("error", "cancelled"):  # or lost, and once more when repeated
                del self.computed[key]
                self._recover(task)
            elif self._is_gone(task.worker) and task.future.status != "finished":
                del self.computed[key]  # if it was alone, it is still suspected
                self._hand_out_again(task)
        self._look_at_workers()
        return bool(ended)

    def _look_at_workers(self) -> None:
        """Now and then, ask them for records; take what they have answered meanwhile."""
        now, is_last = self._connection.clock(), not (self._waiting or self.running)
        are_there = any(task.future.status == "finished" for task in self.computed.values())
        pause = min(_POLL, _SOONER * (now - self._began))
        if now - self._looked >= pause or (is_last and are_there):
            self._looked = now
            self._workers = threads_of(self._connection)
            self._tell_idle()
            self._reports.ask(self._workers, list(self.computed))
        for worker, answer in self._reports.answers():
            self._take(worker, answer, now)
        self.computes = self._reports.computes(self._workers)
        self.running = [task for task in self.running if not self._is_given_up(task)]
        for task in [task for task in self.running if self._is_gone(task.worker)]:
            if not task.future.done():
                self.running.remove(task)
                self._hand_out_again(task)

    def _is_gone(self, worker: str) -> bool:
        return worker != ANYWHERE and worker not in self._workers

    def _hand_out_again(self, task: _Running) -> None:
        """Give a task to another worker after its own has gone: Dask may leave it waiting."""
        if task.is_alone:
            return
        self._connection.client.cancel([task.future])
        self._moved[task.points] += 1
        if self._moved[task.points] < TRIALS:
            self._waiting.put_back(task.task)
        else:  # a worker may die of it before it tells that it has begun
            self._accuse(task, _KILLED)

    def _tell_idle(self) -> None:
        """Tell, once, of threads that have nothing to do."""
        idle = self._workers.total() - len(self._workers)
        if idle and not self._is_idle_told:
            self._is_idle_told = True
            self._connection.tell(
                f"{idle} of {self._workers.total()} threads of the Dask workers stand idle, since "
                "each process computes one point at a time; start workers of one thread, as "
                "Client(threads_per_worker=1) and dask worker --nthreads 1 do"
            )

    def _take(self, worker: str, answer: WorkerReport, now: float) -> None:
        """Take the records that a worker has, and note what it computes."""
        require_same_code(answer.versions, worker)
        if difference := other_packages(answer.versions):
            if difference not in self._noted:
                words = f"has {difference}: last digits may differ there"
                self._connection.tell(f"the Dask worker {worker} {words}")
                self._noted.add(difference)
            if answer.records:
                self._writer.store.note_worker(packages_of(answer.versions))
        for key, content in answer.records.items():
            if self.computed.pop(key, None):  # not if another worker has a copy
                records = pickle.loads(content)
                self._settle(records)
                if worker in self._warm:
                    self._tally.learn(records)
                self._warm.add(worker)
        for task in self.running:
            if task.future.key == answer.now:
                task.begun[worker] = task.begun.get(worker, (now, now))[0], now

    def _settle(self, records: Iterable[PointRecord]) -> None:
        """Take records of points that are done or have failed."""
        records = tuple(records)
        self._writer.add(records)
        for record in records:
            self._losses.pop(record.point, None)

    def _recover(self, task: _Running) -> None:
        """Go on after a loss; suspect the points of the task if it was lost itself."""
        error = task.future.exception() if task.future.status == "error" else None
        if error is None or isinstance(error, CancelledError):
            if self._connection.client.status != "running":
                raise ExecutionError(LOST)
            self._reports.send_again()  # a scheduler that was restarted has forgotten its tasks
            self._hand_out_again(task)
            return
        if isinstance(error, UnsentError):  # a worker that has come, or come back, meanwhile
            self._reports.send_again()
            self._waiting.put_back(task.task)
            return
        if isinstance(error, ExecutionError):  # from a worker that cannot run this program
            raise error
        killed = isinstance(error, KilledWorker)
        self._accuse(task, _KILLED if killed else f"{type(error).__name__}: {error}")

    def _accuse(self, task: _Running, reason: str) -> None:
        """Suspect the points of a task; those fail that were lost alone too often."""
        for point in task.points:
            self._losses[point] = self._losses.get(point, 0) + task.is_alone
        guilty = [point for point in task.points if self._losses[point] >= TRIALS]
        self._settle(PointRecord(point, None, reason) for point in guilty)

    def _is_given_up(self, task: _Running) -> bool:
        """True if a task should be given up: its worker is gone, or worker after worker left it."""
        if task.is_alone and task.worker not in self._workers:
            self._accuse(task, _KILLED)
            return True
        left = [times for worker, times in task.begun.items() if worker not in self._workers]
        if len(left) < STARTS:
            return False
        self._connection.client.cancel([task.future])
        spans = ", ".join(duration(last - first) for first, last in left)
        reason = _TOO_LONG.format(len(left), spans)
        self._settle(PointRecord(point, None, reason) for point in task.points)
        return True


def _short_name(points: tuple[Point, ...]) -> str:
    """Place of a task for the dashboard, such as ``600N-1.5ms``, and how many share its contact."""
    first, others = points[0], len(points) - 1
    return f"{first.load:g}N-{first.velocity:g}ms" + f"-and-{others}-more" * bool(others)


class _Silence:
    """Time in which no task has ended; it may last as long as any worker computes [s]."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._ended = self._computed = connection.clock()
        self._word = _WORD

    def watch(self, moved: bool, computes: bool, running: Sequence[_Running]) -> None:
        """Tell the user if nothing has ended for long; raise if no worker computes any more."""
        now = self._connection.clock()
        if moved:
            self._ended, self._word = now, _WORD
        if moved or computes:
            self._computed = now
        silence = now - self._ended
        words = f"no point has been finished for {silence:.0f} s"
        if now - self._computed > _END:
            raise ExecutionError(f"{words}, and no worker computes any; {SAFE}")
        if silence >= self._word:
            self._word *= 2
            others = f" and {n} more" if (n := len(running) - 1) > 0 else ""
            first = next((f"{task.points[0]}{others}" for task in running), "a worker")
            self._connection.tell(f"{words}; waiting for {first}")
