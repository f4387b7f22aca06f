"""Progress of a sweep, counted in its store."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pipeline.store.lock import holder_of
from pipeline.store.schema import ASKED, DONE, FAILED, LEFT_OUT, PENDING
from pipeline.store.write import Store
from pipeline.sweep.model import Point
from pipeline.sweep.variants import Variant


@dataclass(frozen=True, slots=True)
class FailedPoint:
    """A point that failed or is damaged: load [N], velocity [m/s], reason and variant.

    `place` describes the point in words, with entries in the user's units.
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
    """Progress of a sweep: number of points by state, failed points, and the writing process."""

    #: Name and title of the scene.
    name: str
    title: str
    #: Number of points that the scene, or the search for an accuracy, asks for; of these that are
    #: done and to do.
    total: int
    done: int
    pending: int
    failed: tuple[FailedPoint, ...]  #: Points that could not be computed.
    earlier: int = 0  #: Number of further done points, for which only an earlier run asked.
    #: Number of done points with a warning, also those for which only an earlier run asked.
    warned: int = 0
    running: str | None = None  #: Process that computes points now; None if there is none.
    tests: Summary | None = None  #: Progress of the points of tests; None if there are none.


def is_wanted(asked: Any, status: Any) -> Any:
    """Mask of the points that are asked for; a search has left out others, unless they are done."""
    return (asked == ASKED) | ((asked == LEFT_OUT) & (status != PENDING))


def summary_of(store: Store) -> Summary:
    """Count the points of an open store by state, and the points with a warning."""
    flags = store.flags
    asked = is_wanted(store.asked, flags)
    failed = np.nonzero(asked & (flags == FAILED))
    messages = store.read("message", ...)[failed] if failed[0].size else ()
    return Summary(
        name=store.sweep.name,
        title=store.sweep.title,
        total=int(np.count_nonzero(asked)),
        done=int(np.count_nonzero(asked & (flags == DONE))),
        pending=int(np.count_nonzero(asked & (flags == PENDING))),
        failed=tuple(
            FailedPoint(*point[:2], str(message), point.variant, store.in_words(point))
            for point, message in zip(store.points_at(failed), messages, strict=True)
        ),
        earlier=int(np.count_nonzero(flags[~asked] == DONE)),
        warned=int(np.count_nonzero((flags == DONE) & (store.read("warning_flags", ...) != 0))),
        running=holder_of(store.place),
        tests=summary_of(store.tests) if store.tests and store.tests.root.points else None,
    )
