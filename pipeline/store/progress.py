"""How far a sweep has come, by its store."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeline.store.folder import PathLike, user
from pipeline.store.pace import pace
from pipeline.store.snapshot import Snapshot
from pipeline.store.variables import DONE, FAILED, PENDING
from pipeline.store.whole import read_whole
from pipeline.sweep.model import Point


@dataclass(frozen=True, slots=True)
class FailedPoint:
    """A point that could not be computed: load [N], velocity [m/s], why, and which variant."""

    load: float
    velocity: float
    message: str
    realization: int | None = None
    sample: int | None = None

    def __str__(self) -> str:
        return f"{Point(self.load, self.velocity, self.realization, self.sample)}: {self.message}"


@dataclass(frozen=True, slots=True)
class Summary:
    """How far a sweep has come.

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


def summarized(store: Snapshot) -> Summary:
    """Count the points of an open store, without reading their data."""
    flags, _ = store.flags()
    asked = store.asked_places()
    counts = {flag: int(np.count_nonzero(flags[asked] == flag)) for flag in (PENDING, DONE)}
    failed = set(store.points_at(np.nonzero(asked & (flags == FAILED))))
    return Summary(
        name=store.attributes["name"],
        title=store.attributes["title"],
        total=int(np.count_nonzero(asked)),
        done=counts[DONE],
        pending=counts[PENDING],
        failed=tuple(
            FailedPoint(at.load, at.velocity, store.message(at), *at[2:])
            for at in (store.asked() if failed else ())
            if at in failed
        ),
        earlier=int(np.count_nonzero(flags[~asked] == DONE)),
    )


def summary(path: PathLike) -> Summary:
    """Count the points of a store and their warnings, and tell their rate, without their data.

    Raises
    ------
    StoreError
        If there is no readable store.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.summary("results/first_try.zarr")
    >>> found.done, found.pending, found.failed
    (24, 0, ())
    """
    _, found = read_whole(path, _with_rate_and_warnings, Snapshot)
    return replace(found, running=user(path))


def _with_rate_and_warnings(store: Snapshot) -> Summary:
    name = "warning_flags" if "warning_flags" in store.names else "message"
    flags, _ = store.flags()
    # Both are empty, 0 or no text, where there is nothing to warn of.
    warned = (flags == DONE) & store.values(name).astype(bool)
    return replace(summarized(store), rate=pace(store.finished_at()), warned=int(warned.sum()))
