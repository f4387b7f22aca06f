"""Progress of a sweep, by its store."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.store.lock import holder_of
from pipeline.store.place import PathLike, place_of
from pipeline.store.root import read_root
from pipeline.store.schema import DONE, FAILED, PENDING
from pipeline.store.write import Store
from pipeline.sweep.model import Point
from pipeline.sweep.variants import Variant
from tribo.types import Array

_RECENT = 200  # points, of which the rate is taken
_BREAK = 20.0  # times the usual time between points, after which a run was interrupted


@dataclass(frozen=True, slots=True)
class FailedPoint:
    """A point that could not be computed: load [N], velocity [m/s], reason, and variant.

    The place is the point in words, where the scene writes values of the variant in units.

    Examples
    --------
    >>> print(FailedPoint(400.0, 2.2, "the contact leaves the window"))
    400 N, 2.2 m/s: the contact leaves the window
    """

    load: float
    velocity: float
    message: str
    variant: Variant = ()
    place: str = field(default="", compare=False)

    def __str__(self) -> str:
        return f"{self.place or Point(self.load, self.velocity, self.variant)}: {self.message}"


@dataclass(frozen=True, slots=True)
class Summary:
    """Progress of a sweep.

    Attributes
    ----------
    name, title : str
        Name and title of the scene.
    total, done, pending : int
        Points that the scene asks for, those of them that are done and those still to do.
    failed : tuple of FailedPoint
        Points that could not be computed.
    earlier : int
        Points besides these that are done, since an earlier run asked for them.
    warned : int
        Points that are done and carry a warning, also those that only an earlier run asked for.
    rate : float or None
        Rate at which points were finished most recently [1/s]; None if that is not known.
    running : str or None
        Process that computes points now; None if there is none.

    Examples
    --------
    >>> half_done = Summary("a_scene", "A scene", 24, 12, 12, failed=(), rate=4.0)
    >>> half_done.time_to_go
    3.0
    """

    name: str
    title: str
    total: int
    done: int
    pending: int
    failed: tuple[FailedPoint, ...]
    earlier: int = 0
    warned: int = 0
    rate: float | None = None
    running: str | None = None

    @property
    def time_to_go(self) -> float | None:
        """Time that the pending points take at that rate [s]."""
        return self.pending / self.rate if self.rate else None


def summarized(store: Store) -> Summary:
    """Count the points of an open store."""
    asked, flags = store.asked == 1, store.flags
    counts = {flag: int(np.count_nonzero(flags[asked] == flag)) for flag in (PENDING, DONE)}
    failed = np.nonzero(asked & (flags == FAILED))
    messages = store.read("message", ...)[failed] if failed[0].size else ()
    return Summary(
        name=store.attributes["name"],
        title=store.attributes["title"],
        total=int(np.count_nonzero(asked)),
        done=counts[DONE],
        pending=counts[PENDING],
        failed=tuple(
            FailedPoint(*point[:2], str(message), point.variant, store.in_words(point))
            for point, message in zip(store.points_at(failed), messages, strict=True)
        ),
        earlier=int(np.count_nonzero(flags[~asked] == DONE)),
    )


def summary(path: PathLike) -> Summary:
    """Number of points of a store by state, with warnings and rate, read without their data.

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
    place = place_of(path)
    store = Store(place, read_root(place))
    finished = store.read("finished_at", ...)[store.flags == DONE]
    warned = (store.flags == DONE) & (store.read("warning_flags", ...) != 0)
    return replace(
        summarized(store),
        rate=pace(finished[np.isfinite(finished)]),
        warned=int(np.count_nonzero(warned)),
        running=holder_of(place),
    )


def pace(finished: Array) -> float | None:
    """Points per second, of the most recent ones and since the last interruption.

    By the times at which points were finished [s], in any order; None if fewer than three tell.

    Examples
    --------
    >>> pace(np.array([1000.0, 1002.0, 1004.0, 9000.0, 9000.5, 9001.0, 9001.5]))
    2.0
    """
    times = np.sort(finished)[-_RECENT:]
    gaps = np.diff(times)
    if gaps.size:
        (breaks,) = np.nonzero(gaps > _BREAK * max(np.median(gaps), np.finfo(float).tiny))
        times = times[breaks[-1] + 1 :] if breaks.size else times
    if times.size < 3 or times[-1] == times[0]:
        return None
    return float((times.size - 1) / (times[-1] - times[0]))
