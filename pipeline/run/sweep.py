"""A sweep on a Dask cluster, a task for each point."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from distributed import Client

from pipeline.machine import cores
from pipeline.run.boundary_search import (
    beside_boundary,
    on_first_patch,
    on_further_patches,
    require_boundary,
    require_tolerance,
)
from pipeline.run.cluster import PATIENCE, connected
from pipeline.run.forkserver import end_if_imported
from pipeline.run.schedule import compute
from pipeline.run.tally import Tally, shown_progress
from pipeline.scene.resume import effective_changes
from pipeline.scene.scenefile import sweep_of
from pipeline.scene.units import require_count
from pipeline.store.create import writing
from pipeline.store.place import PathLike
from pipeline.store.progress import FailedPoint, Summary, summary_of
from pipeline.store.root_file import find_sweep
from pipeline.store.schema import ASKED, FAILED, require_free_names
from pipeline.store.take import take_points
from pipeline.store.verify import mend_store
from pipeline.store.versions import in_words, package_versions
from pipeline.store.write import Store, Writer, opened
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import Task, tasks
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, Report, silent
from pipeline.sweep.task_queue import TaskQueue
from tribo import InputError
from tribo.errors import require_positive


@shown
@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a run: how many points are done, which failed, and how long it took."""

    #: Number of points of the sweep, and of its points that are done.
    total: int
    done: int
    computed: int  #: Number of points that this run completed.
    failed: tuple[FailedPoint, ...]  #: Points that failed, now or in an earlier run.
    wall_time: float  #: Duration of this run [s].
    tests: Summary | None = None  #: Progress of the points of tests; None if there are none.


@np.errstate(under="ignore")
def run_sweep(
    sweep: Sweep | PathLike,
    out: PathLike,
    workers: int | None = None,
    client: Client | None = None,
    progress: Report | None = None,
    retry_failed: bool = False,
    boundary_only: float | None = None,
    further_patches: bool = False,
    patience: float = PATIENCE,
    dashboard: bool = False,
    source: PathLike | None = None,
) -> Outcome:
    """Compute the points of a sweep that its store does not have yet.

    In a script, call it under ``if __name__ == "__main__":``, since workers import the script.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path.
    out : str or path
        Path of the store, which is created, resumed or extended. If it is a folder, all done points
        are first compared with their checksums, and computed again if they differ.
    workers : int, optional
        Number of processes; by default one for each core that this process may use. There are no
        more than tasks.
    client : distributed.Client, optional
        Client of a Dask cluster to compute on instead. Its workers need this package, but no access
        to the store. A worker computes one point at a time, however many threads it has.
    progress : callable, optional
        Called with a `Progress` at the start, whenever points were written, and for messages to the
        user, such as a note on a store that is resumed. If it is not given, a notebook shows a line
        of progress.
    retry_failed : bool, optional
        True to compute points again that failed in an earlier run.
    boundary_only : float, optional
        Compute only the points that the boundary needs, so that the points left out move its
        velocity by about this share at most, such as 0.01. The rest stays pending, which answers
        do not report as missing; a later run without this argument computes it. By default all
        points are computed.
    further_patches : bool, optional
        True to compute only the first patch of the surface (``sweep.realizations``) at all points.
        Of each other one a point at each load follows, beside the boundary: patches differ by
        nearly a constant along velocity.
    patience : float, optional
        Time to wait for an answer of the scheduler, and for a worker if there is none [s]. Choose
        it long if workers wait in a queue.
    dashboard : bool, optional
        True to report the link of Dask's dashboard, which everybody on this machine can read.
    source : str or path, optional
        Another store, which is only read. Its done points are taken over instead of being computed,
        if this sweep needs them and they belong to the same scene.

    Raises
    ------
    InputError
        If `workers`, `client`, `patience` or `boundary_only` cannot be used; with
        `boundary_only` also if the sweep has no boundary, such as without friction.
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
    if workers is not None:
        require_count("workers", workers)
    require_positive(patience=patience)
    _require_cluster(client)
    sweep = sweep_of(sweep)
    require_free_names(sweep)  # before a folder is made
    if boundary_only is not None:
        require_tolerance(boundary_only)
    is_chosen = further_patches or boundary_only is not None
    if is_chosen:
        require_boundary(sweep, "--patches" if further_patches else "--boundary-only")
    began = time.monotonic()
    report = progress or silent
    if damaged := mend_store(out, sweep):
        report(Progress(f"{out} had {damaged} damaged points or files, which are made anew"))
    before, other = find_sweep(out), None if source is None else opened(source)
    with writing(out, sweep, report) as store:
        for note in _notes_on_resuming(store, before) if before else ():
            report(Progress(note))
        for group in filter(None, (store, store.tests) if retry_failed else ()):
            failed = (group.asked == ASKED) & (group.flags == FAILED)
            group.forget(group.points_at(np.nonzero(failed)))
        if other:
            taken = take_points(store, other)
            report(Progress(f"{taken} points are taken from {source}"))
        if is_chosen:
            store.leave_out_pending()

        def waiting() -> TaskQueue:
            if boundary_only is not None:
                store.ask_for(beside_boundary(store, sweep, boundary_only, further_patches))
            elif further_patches:
                store.ask_for(on_first_patch(sweep))
            if further_patches and not store.pending():
                store.ask_for(on_further_patches(store, sweep))
            return TaskQueue(tasks(store.pending(), sweep))

        of_tests = TaskQueue(_tasks_of_tests(store))
        queue, tally, at_tests = waiting(), Tally(store, shown_progress(progress)), 0
        if queue or of_tests:
            most = cores() if is_chosen else len(queue) + len(of_tests)
            with connected(
                client, min(workers or cores(), most), patience, report, dashboard
            ) as link:
                if store.tests and of_tests:
                    with Writer(store.tests) as writer:
                        compute(link, store.tests.sweep, writer, of_tests, tally)
                    at_tests = tally.computed
                while queue:
                    with Writer(store) as writer:
                        compute(link, sweep, writer, queue, tally)
                    queue = waiting()  # the next points of a search; none without one
        summary = summary_of(store)
    counts = summary.total, summary.done, tally.computed - at_tests
    return Outcome(
        *counts,
        failed=summary.failed,
        wall_time=time.monotonic() - began,
        tests=summary.tests,
    )


def _tasks_of_tests(store: Store) -> Iterable[Task]:
    return tasks(store.tests.pending(), store.tests.sweep) if store.tests else ()


def _require_cluster(client: Client | None) -> None:
    """Raise an `InputError` unless the client is None, or connected and not asynchronous."""
    end_if_imported()  # a worker, which imports and so runs the driver's script, exits here
    is_usable = isinstance(client, Client) and client.scheduler and not client.asynchronous
    if client is not None and not is_usable:
        raise InputError(
            f"client is {client!r}; give a distributed.Client that is connected and not "
            "asynchronous, such as Client(cluster)"
        )


def _notes_on_resuming(store: Store, before: Sweep) -> Iterator[str]:
    """Notes for the user if conditions or program versions are not those of the sweep `before`."""
    if changed := [*effective_changes(before, store.sweep, lambda one: one.conditions)]:
        yield (
            f"the conditions of {store.place} are now those of the scene, and every command judges "
            f"by them: {'; '.join(changed)}"
        )
    now = in_words(package_versions())
    if not (began := store.root.history[0]).endswith(now):
        yield f"{store.place} was {began}: new points by {now} may differ in the last digits"
