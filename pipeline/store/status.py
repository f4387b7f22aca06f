"""Progress and verification of a store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.progress import Report, silent
from pipeline.store.location import PathLike, io_errors, location_of
from pipeline.store.lock import holder_of
from pipeline.store.points import find_damage
from pipeline.store.root import damaged_documents, read_root
from pipeline.store.schema import DONE, FAILED, NOT_NEEDED, PENDING
from pipeline.store.store import Index, Store, opened
from pipeline.sweep.case_table import CaseName
from pipeline.sweep.sweep import Point, Sweep


@dataclass(frozen=True, slots=True)
class FailedPoint:
    """A point that failed or is damaged: load [N], velocity [m/s], reason and case.

    `location` describes the point in words, with entries in the user's units.
    """

    load: float
    velocity: float
    message: str
    case: CaseName = ()
    location: str = field(default="", compare=False)

    def __str__(self) -> str:
        return f"{self.location or Point(self.load, self.velocity, self.case)}: {self.message}"


@dataclass(frozen=True, slots=True)
class Summary:
    """Progress of a sweep: number of points by state, failed points, and the writing process."""

    #: Name and title of the scene.
    name: str
    title: str
    #: Number of points that were asked for; of these that are done and to do.
    total: int
    done: int
    pending: int
    failed: tuple[FailedPoint, ...]  #: Points that could not be computed.
    warned: int  #: Number of done points with a warning.
    running: str | None  #: Process that computes points now; None if there is none.
    tests: Summary | None  #: Progress of the points of tests; None if there are none.


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of checking a whole store: the number of intact points, and what is damaged."""

    done: int  #: Points that are done and intact.
    damaged: tuple[FailedPoint, ...]  #: Points that are damaged.
    shared: tuple[str, ...]  #: Damaged coordinates and files, which several points share.
    tests: Verification | None  #: Result for the points of tests, if there are any.

    @property
    def is_clean(self) -> bool:
        """True if nothing was damaged."""
        return not (self.damaged or self.shared) and (self.tests is None or self.tests.is_clean)


def summary(path: PathLike) -> Summary:
    """Count the points of a store by state, and those with warnings, without reading results.

    Parameters
    ----------
    path : str or path
        Path of the store.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> summary = pipeline.summary("results/first_try.zarr")
    >>> summary.done, summary.pending, summary.failed
    (24, 0, ())
    """
    return summary_and_sweep(path)[0]


def summary_and_sweep(path: PathLike) -> tuple[Summary, Sweep]:
    """Progress of a store, and its sweep."""
    store = opened(path)
    return summary_of(store), store.sweep


def summary_of(store: Store) -> Summary:
    """Count the points of an open store by state, and the points with a warning."""
    flags = store.flags
    failed = [*zip(*np.nonzero(flags == FAILED), strict=True)]
    messages = store.read("message", ...) if failed else {}
    return Summary(
        name=store.sweep.name,
        title=store.sweep.title,
        total=int(np.count_nonzero(flags != NOT_NEEDED)),
        done=int(np.count_nonzero(flags == DONE)),
        pending=int(np.count_nonzero(flags == PENDING)),
        failed=_failed_points(store, {index: str(messages[index]) for index in failed}),
        warned=int(np.count_nonzero((flags == DONE) & (store.read("warning_flags", ...) != 0))),
        running=holder_of(store.location),
        tests=next(map(summary_of, store.groups[1:]), None),
    )


def _failed_points(store: Store, faults: Mapping[Index, str]) -> tuple[FailedPoint, ...]:
    """Points by index, each with its fault."""
    points = store.group.points_at([*np.array([*faults], int).reshape(-1, len(store.dims)).T])
    return tuple(
        FailedPoint(*point[:2], fault, point.case, store.group.to_text(point))
        for point, fault in zip(points, faults.values(), strict=True)
    )


def verify_store(path: PathLike, progress: Report | None = None) -> Verification:
    """Check a whole store for damage; nothing is written.

    Parameters
    ----------
    path : str or path
        Path of the store, which may be in use.
    progress : callable, optional
        Called now and then with a `Progress` that counts chunks of points.

    Raises
    ------
    StoreError
        If there is no readable store, or one of its files cannot be read now.

    Examples
    --------
    >>> import pipeline
    >>> verification = pipeline.verify_store("results/first_try.zarr")
    >>> verification.done, verification.damaged, verification.is_clean
    (24, (), True)
    """
    location = location_of(path)
    store = Store(location, read_root(location), may_be_damaged=True)
    verification = _verified(store, progress or silent)
    with io_errors(location):
        documents = damaged_documents(location, store.root)
    return replace(verification, shared=(*verification.shared, *documents))


def _verified(store: Store, progress: Report = silent) -> Verification:
    damage = find_damage(store, progress)
    damaged_count = sum(bool(store.flags[index] == DONE) for index in damage.points)
    return Verification(
        done=int(np.count_nonzero(store.flags == DONE)) - damaged_count,
        damaged=_failed_points(store, damage.points),
        shared=tuple(damage.files),
        tests=next(map(_verified, store.groups[1:]), None),
    )
