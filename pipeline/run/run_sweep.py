"""A sweep on a Dask cluster, a task for each point."""

from __future__ import annotations

import multiprocessing
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
import xarray as xr
from dask.system import cpu_count
from distributed import Client

from pipeline.kinds import WORKERS
from pipeline.progress import Progress, Report, silent
from pipeline.run.boundary_variants import with_variants
from pipeline.run.cluster import PATIENCE, Watch, connected
from pipeline.run.drive import Tally, TaskQueue, compute, notebook_progress
from pipeline.run.goal import GoalPlan
from pipeline.scene.scene_file import sweep_of
from pipeline.scene.variants import expected_variants
from pipeline.store.create import changes_in_words, enlarged, find_sweep, versions, writing
from pipeline.store.dataset import store_dataset
from pipeline.store.location import PathLike
from pipeline.store.points import copy_points
from pipeline.store.schema import FAILED, require_free_names
from pipeline.store.status import FailedPoint, Summary, summary_of
from pipeline.store.store import Store, opened
from pipeline.sweep.plan import tasks
from pipeline.sweep.stored import require_stored_classes
from pipeline.sweep.sweep import Point, Sweep
from tribo import InputError
from tribo.errors import require_positive


@dataclass(frozen=True, slots=True)
class RunSummary:
    """Result of a run: how many points are done, which failed, and how long it took."""

    #: Number of points that the sweep or its accuracy needs, and of these that are done.
    total: int
    done: int
    computed: int  #: Number of points that this run completed.
    failed: tuple[FailedPoint, ...]  #: Points that failed, now or in an earlier run.
    wall_time: float  #: Duration of this run [s].
    cpu_time: float  #: Processor time of this process and of the workers [s].
    tests: Summary | None  #: Progress of the points of tests; None if there are none.


@np.errstate(under="ignore")
def run_sweep(
    sweep: Sweep | PathLike,
    out: PathLike,
    workers: int | None = None,
    client: Client | None = None,
    progress: Report | None = None,
    retry_failed: bool = False,
    accuracy: float | str | None = None,
    patience: float = PATIENCE,
    dashboard: bool = False,
    source: PathLike | None = None,
) -> RunSummary:
    """Compute the points of a sweep that its store does not have yet.

    In a script, call it under ``if __name__ == "__main__":``, since workers import the script.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path.
    out : str or path
        Path of the store, which is created, resumed or extended. In a folder, all done points are
        read first; damaged ones are computed again.
    workers : int, optional
        Number of processes; by default one for each core that this process may use. Never more than
        there are tasks.
    client : distributed.Client, optional
        Client of a Dask cluster to compute on instead. Its workers need this package, but no access
        to the store. A worker computes one point at a time, however many threads it has.
    progress : callable, optional
        Called with a `Progress` at the start, whenever points were written, and for messages to the
        user, such as a note on a store that is resumed. If it is not given, a notebook shows a line
        of progress.
    retry_failed : bool, optional
        True to compute points again that failed in an earlier run.
    accuracy : float or str, optional
        Largest numerical error (95 % bound) of the critical velocity at any load that has one,
        such as 0.02 or "2%": discretization, interpolation and surface sampling together. The run
        chooses the preset, and computes only the points and surface realizations that this needs.
        Surface sampling is left out of the goal for scans, smooth surfaces and listed seeds. A
        later run with a smaller accuracy continues in the store. By default all points are
        computed.
    patience : float, optional
        Time to wait for an answer of the scheduler, and for a worker if there is none [s]. Set it
        to the queueing time, such as 3600, on a batch cluster.
    dashboard : bool, optional
        True to report the link of Dask's dashboard, which everybody on this machine can read.
    source : str or path, optional
        Another store, which is only read. Its done points are copied instead of being computed, if
        this sweep needs them and they belong to the same scene.

    Raises
    ------
    InputError
        If `workers`, `client`, `patience` or `accuracy` cannot be used; with `accuracy` also if the
        sweep has no boundary, such as without friction, or no preset has the accuracy.
    StoreMismatchError
        If `out` is the store of another scene.
    StoreError
        If the store is in use or cannot be written. Finished points are safe.
    ExecutionError
        If the cluster does not start or is lost. Finished points are safe.

    Examples
    --------
    >>> import pipeline
    >>> outcome = pipeline.run_sweep("workflows/first_try.toml", "results/first_try.zarr")
    >>> outcome.total, outcome.done, outcome.computed, outcome.failed
    (24, 24, 0, ())
    """
    report = progress or silent
    if workers is not None:
        workers = WORKERS.argument("workers", workers)
    require_positive(patience=patience)
    _require_cluster(client)
    sweep = sweep_of(sweep)
    require_free_names(sweep)  # before a folder is made
    require_stored_classes(sweep)
    expected_variants(sweep)  # raises for an uncertain input that cannot be varied
    goal = None if accuracy is None else GoalPlan(sweep, find_sweep(out), accuracy, report)
    return run_planned(
        sweep, out, goal, workers, progress, client=client, patience=patience,
        dashboard=dashboard, retry_failed=retry_failed, source=source,
    )  # fmt: skip


class PointsBeside:
    """Plan of a run that simulates no point of the plane, only those of tests and variants."""

    accuracy = None

    def __init__(self, sweep: Sweep) -> None:
        self.sweep = sweep

    def ask(self, _: xr.Dataset) -> list[Point]:
        """No point."""
        return []


Plan = GoalPlan | PointsBeside
"""What chooses the points of a run."""


def run_planned(
    sweep: Sweep, out: PathLike, plan: Plan | None, workers: int | None, progress: Report | None,
    client: Client | None = None, patience: float = PATIENCE, dashboard: bool = False,
    retry_failed: bool = False, source: PathLike | None = None,
) -> RunSummary:  # fmt: skip
    """Compute the points that a plan chooses, by default all, and those of tests and variants."""
    report, began, began_cpu_time = progress or silent, time.monotonic(), time.process_time()
    old_sweep, source_store = find_sweep(out), None if source is None else opened(source)
    sweep = plan.sweep if plan else sweep
    with writing(out, sweep, report, plan.accuracy if plan else None) as store:
        for note in _notes_on_resuming(store, old_sweep) if old_sweep else ():
            report(Progress(note))
        for group in store.groups if retry_failed else ():
            group.forget(group.points_where(group.flags == FAILED))
        if source_store:
            copied_count = copy_points(store, source_store)
            report(Progress(f"{copied_count} points are copied from {source}"))
        count = min(workers or cpu_count(), _task_count(store, plan))
        if plan:
            store.leave_out_pending()
        tally = Tally(store, notebook_progress(progress))
        with _Workers(client, count, patience, dashboard, report) as cluster:
            for tests in store.groups[1:]:  # first, as the critical temperature may follow
                cluster.compute(tests, tally)
            computed_tests = tally.computed
            store = _with_next_points(store, plan, tally) if plan else store
            while store.pending():
                cluster.compute(store, tally)
                store = _with_next_points(store, plan, tally) if plan else store
            computed = tally.computed - computed_tests
            if larger := with_variants(store):
                store = enlarged(store, larger)
                store.leave_out_pending()
                if source_store:
                    copy_points(store, source_store)
                tally.follow(store)
                for tests in store.groups[1:]:
                    cluster.compute(tests, tally)
            cpu_time = cluster.cpu_time()
        summary = summary_of(store)
    return RunSummary(
        summary.total,
        summary.done,
        computed=computed,
        failed=summary.failed,
        wall_time=time.monotonic() - began,
        cpu_time=time.process_time() - began_cpu_time + cpu_time,
        tests=summary.tests,
    )


def _task_count(store: Store, plan: Plan | None) -> int:
    """Number of tasks that can run at a time; a plan and uncertainties add some later."""
    has_more = plan or store.sweep.base.uncertainty
    return cpu_count() if has_more else sum(len(group.pending()) for group in store.groups)


class _Workers(ExitStack):
    """The workers of a run: those of a client, or processes that the first point starts here.

    `count` is the number of processes. The context ends them.
    """

    def __init__(
        self, client: Client | None, count: int, patience: float, dashboard: bool, report: Report
    ) -> None:
        super().__init__()
        self._client, self._count, self._patience = client, count, patience
        self._dashboard, self._report = dashboard, report
        self._watch: Watch | None = None
        self._initial_cpu_time = 0.0

    def compute(self, store: Store, tally: Tally) -> None:
        """Compute the pending points of a store."""
        if not (queue := TaskQueue(tasks(store.pending(), store.sweep))):
            return
        if self._watch is None:
            client = self.enter_context(
                connected(self._client, self._count, self._report, self._dashboard)
            )
            is_own, self._client = self._client is None, client
            self._watch = Watch(client, self._patience, self._report, is_own)
            self._initial_cpu_time = 0.0 if is_own else self._watch.cpu_time()
        compute(self._client, self._watch, store, queue, tally)

    def cpu_time(self) -> float:
        """Processor time that workers have spent on this run [s]."""
        return self._watch.cpu_time() - self._initial_cpu_time if self._watch else 0.0


def _with_next_points(store: Store, plan: Plan, tally: Tally) -> Store:
    """The store with the next points of a plan as pending, enlarged for further realizations."""
    while True:
        sweep = plan.sweep
        points = plan.ask(store_dataset(store))
        if is_larger := plan.sweep is not sweep:
            store = enlarged(store, plan.sweep)
            store.leave_out_pending()
        if points or not is_larger:
            store.need(points)
            tally.follow(store)
            return store


def _require_cluster(client: Client | None) -> None:
    """Raise an `InputError` unless the client is None, or connected and not asynchronous."""
    script = sys.modules.get("__mp_main__")  # by which a worker imports the driver's script
    if script and script.__name__ == "__mp_main__" and not multiprocessing.parent_process():
        raise SystemExit(1)  # of a worker, which imports a script that calls this unguarded
    is_usable = isinstance(client, Client) and client.scheduler and not client.asynchronous
    if client is not None and not is_usable:
        raise InputError(
            f"client is {client!r}; pass a connected, synchronous distributed.Client, such as "
            "Client(cluster)"
        )


def _notes_on_resuming(store: Store, old_sweep: Sweep) -> Iterator[str]:
    """Notes for the user if the conditions or program versions of `old_sweep` are different."""
    if changed := [*changes_in_words(old_sweep.conditions, store.sweep.conditions)]:
        yield (
            f"the conditions in {store.location} are replaced by those of the scene: "
            f"{'; '.join(changed)}"
        )
    current = versions()
    if not (began := store.root.history[0]).endswith(current):
        yield (
            f"{store.location} was {began}; points computed from now on by {current} may differ in "
            "the last digits"
        )
