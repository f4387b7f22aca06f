"""A sweep on a Dask cluster: each point continues the ramp of the one below it.

::

    TriboError
    └── ExecutionError   the cluster does not start, or is lost (pipeline.run.cluster)
"""

from __future__ import annotations

import itertools
import math
import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from dask.system import CPU_COUNT

from pipeline.run.cluster import PATIENCE, ExecutionError, connected, dashboard_of
from pipeline.run.forkserver import UNGUARDED, end_if_imported
from pipeline.run.notebook import reported
from pipeline.run.schedule import compute
from pipeline.store import (
    BY_POINT,
    COMPACT,
    DONE,
    FAILED,
    PENDING,
    FailedPoint,
    PathLike,
    Store,
    StoreError,
    Summary,
    folder_of,
    has_parts,
    lay_out,
    locked,
    prepare,
    remove_partial,
    sound,
    summarized,
    versions,
)
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import chains
from tribo import InputError
from tribo.types import Mask

_MANY = 20_000  # files, which take half a second to read: compacting is worth a word


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run has come.

    Attributes
    ----------
    done, failed, total : int
        Points that are done, that have failed, and all of the sweep, earlier runs included.
    elapsed : float
        Time since this run began [s].
    time_to_go : float or None
        Estimated time until the end [s]; None until the first point is done.
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
        Duration of this run [s].
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
        Path of the store, which is created, resumed or extended.
    workers : int, optional
        Number of processes; one for each core that this process may use if not given.
    scheduler : str, optional
        Address of a Dask scheduler to use instead. Its workers need this package and see the
        store under the same path.
    progress : callable, optional
        Called with a `Progress` at the start and after each point; in a notebook a bar shows it
        if not given.
    retry_failed : bool, optional
        Whether to try again the points that failed in an earlier run.
    further : callable, optional
        Called when every point is done or has failed; returns the same sweep with more points to go
        on with, or None.
    tell : callable, optional
        Called with a line for the user, such as where the cluster's dashboard is.
    patience : float, optional
        Time to wait for a scheduler to answer, and for workers if there are none [s].
    fill_fields : bool, optional
        Whether to compute again the points that were finished before the scene asked for fields.

    Raises
    ------
    StoreMismatchError
        If `out` is the store of another scene.
    StoreError
        If the store is in use or cannot be written. Finished points are safe.
    ExecutionError
        If the cluster does not start or is lost. Finished points are safe.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> outcome = pipeline.run_sweep(scene, "results/first_try.zarr")  # goes on where it stopped
    >>> outcome.done, outcome.failed
    (24, ())
    """
    if workers is not None and workers < 1:
        raise InputError(f"workers is {workers}; it must be at least 1")
    _refuse_in_a_worker(scheduler)
    began = time.monotonic()
    if scheduler is not None and not folder_of(out).exists():
        with connected(1, scheduler, patience):
            pass  # an address where nobody answers makes no store
    with locked(out), reported(progress) as report:
        shares = scheduler is None  # machines that share files need not see each other's locks
        store = prepare(out, sweep, shares)
        if isinstance(store.path, Path):
            remove_partial(store.path)
        if fill_fields:
            store.forget(*_without_fields(store, sweep))
        if tell:
            for note in _notes(store, sweep):
                tell(note)
        tally = _Tally(summarized(store), began, report)
        rounds = _rounds(store, sweep, retry_failed, further)
        with _kept_compact(store, tell):
            if first := next(rounds, None):
                _make_writable(store, shares)
                # Points that come later may have more chains than those that wait now.
                most = len(first.waiting) if further is None else CPU_COUNT
                with connected(min(workers or CPU_COUNT, most), scheduler, patience) as client:
                    if tell and (dashboard := dashboard_of(client, patience)):
                        tell(f"the cluster's dashboard is at {dashboard}")
                    for each in itertools.chain([first], rounds):
                        store = Store(out)
                        if each is not first:
                            tally.widen(summarized(store))
                        compute(
                            client, each.sweep, store, each.waiting, patience, tally.report, tell
                        )
        store = Store(out)
        found = summarized(store)
    files = found.total * len(store.names) / math.prod(store.array("status").chunks)
    if tell and files >= _MANY and not store.is_compact:
        tell(f"{out} opens faster after: irg compact {out}")
    return Outcome(
        total=found.total,
        done=found.done,
        computed=tally.computed,
        failed=found.failed,
        wall_time=time.monotonic() - began,
    )


def _refuse_in_a_worker(scheduler: str | None) -> None:
    end_if_imported()
    if multiprocessing.parent_process() is not None and scheduler is None:
        raise ExecutionError(f"a worker process cannot run a sweep; {UNGUARDED}")


class _Round(NamedTuple):
    """A sweep, and the points of it that wait, in chains."""

    sweep: Sweep
    waiting: tuple[tuple[Point, ...], ...]


def _rounds(
    store: Store, sweep: Sweep, retry_failed: bool, further: Callable[[], Sweep | None] | None
) -> Iterator[_Round]:
    """What there is to compute: for the sweep, then for each that comes after it."""
    checked = np.zeros(store.array("status").shape, bool)
    asked: Sweep | None = sweep
    while asked is not None:
        todo, checked = _todo(store, retry_failed, checked)
        if waiting := chains(todo, asked.independent):
            yield _Round(asked, waiting)
        retry_failed = False
        asked = further() if further else None
        if asked is not None:
            store = prepare(store.path, asked)


def _make_writable(store: Store, shares: bool) -> None:
    """Give a store such chunks as can be written where it is, by those who are to write."""
    if store.is_shared and not (shares and has_parts(store.path)):
        lay_out(store.path, COMPACT)
    if Store(store.path).is_compact:
        lay_out(store.path, BY_POINT, shares)


@contextmanager
def _kept_compact(store: Store, tell: Callable[[str], None] | None) -> Iterator[None]:
    """Make a store compact again that was so once, whether the run ends, fails or is broken off."""
    try:
        yield
    finally:
        if store.is_kept_compact:
            try:
                lay_out(store.path, COMPACT)
            except StoreError as error:  # so it stays as it is, and whole
                if tell:
                    tell(f"{store.path} is not made compact again this time: {error}")


def _without_fields(store: Store, sweep: Sweep) -> list[Point]:
    """Points that were finished before the scene asked for fields."""
    if not sweep.store_fields:
        return []
    done = store.asked_places() & (store.flags()[0] == DONE)
    return [point for point in store.points_at(np.nonzero(done)) if store.lacks_fields(point)]


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


def _todo(store: Store, retry_failed: bool, checked: Mask) -> tuple[list[Point], Mask]:
    """Points to compute: those pending, those damaged, and those that failed if asked for.

    What is done is read once in a run to see whether it is intact; those places are `checked`.
    """
    flags, _ = store.flags()
    asked = store.asked_places()
    known = np.zeros_like(asked)
    known[tuple(map(slice, checked.shape))] = checked  # the store may have grown
    fresh = asked & (flags == DONE) & ~known
    again = asked & (flags == FAILED) if retry_failed else np.zeros_like(asked)
    for point in store.points_at(np.nonzero(fresh & ~sound(store, flags, fresh))):
        again[store.index(point)] = not store.is_intact(point)
    if again.any():
        store.forget(*store.points_at(np.nonzero(again)))
        flags, _ = store.flags()
    return store.points_at(np.nonzero(asked & (flags == PENDING))), known | asked


class _Tally:
    """Counts the points and tells the caller."""

    def __init__(
        self, found: Summary, began: float, progress: Callable[[Progress], None] | None
    ) -> None:
        self.computed = 0
        self._began, self._progress = began, progress
        self.widen(found)

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
