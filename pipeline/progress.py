"""Progress of a long computation: the stage that begins, how much is done, and the time to go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

_YEAR = 365.25 * 24 * 3600  # [s]


@dataclass(frozen=True, slots=True)
class Progress:
    """Report on a long computation: a message in `words`, or counts of parts and times [s]."""

    words: str = ""  #: The stage that begins, or a note.
    #: Number of parts done, and of all parts; of a sweep its points, earlier runs included.
    done: int = 0
    total: int = 0
    failed: int | None = None  #: Points of a sweep that have failed.
    elapsed: float | None = None  #: Time since it began [s].
    #: Estimated time until the end [s]; None until enough is done.
    time_to_go: float | None = None
    parts: str = ""  #: What the total consists of, such as "24 of the plane, 4 for tests".

    def __str__(self) -> str:
        if self.words:
            return self.words
        parts = [f"{self.done} of {self.total} done"]
        if self.failed is not None:
            total = f"{self.total} points" + (f" ({self.parts})" if self.parts else "")
            parts = [f"{self.done} of {total} done", f"{self.failed} failed"]
        if self.elapsed is not None:
            parts.append(f"{duration(self.elapsed)} so far")
        if self.time_to_go:
            parts.append(f"{duration(self.time_to_go)} to go")
        return ", ".join(parts)


Report = Callable[[Progress], None]
"""Function that a long computation calls with its progress."""


def silent(progress: Progress) -> None:
    """Ignore a report of progress."""


def duration(seconds: float) -> str:
    """Write a duration [s] as text in a suitable unit, such as "5 min"."""
    if not seconds < 100 * _YEAR:
        return "more than 100 years"
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"
