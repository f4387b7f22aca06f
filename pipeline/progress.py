"""Progress of a long computation: the stage that begins, how much is done, and the time to go."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")

_YEAR = 365.25 * 24 * 3600  # [s]
_SOON = 2.0  # [s] before which no time is predicted


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

    def __str__(self) -> str:
        if self.words:
            return self.words
        parts = [f"{self.done} of {self.total} done"]
        if self.failed is not None:
            parts = [f"{self.done} of {self.total} points done", f"{self.failed} failed"]
        if self.elapsed is not None:
            parts.append(f"{duration(self.elapsed)} so far")
        if self.time_to_go:
            parts.append(f"{duration(self.time_to_go)} to go")
        return ", ".join(parts)


Report = Callable[[Progress], None]
"""Function that a long computation calls with its progress."""


def silent(progress: Progress) -> None:
    """Ignore a report of progress."""


def with_progress(
    items: Iterable[T],
    progress: Report,
    name: Callable[[T], str] = str,
    weight: Callable[[T], float] = lambda item: 1.0,
) -> Iterator[T]:
    """Yield items; before each, report its name, its number and the estimated time left.

    `name` returns the name of an item, and `weight` its relative duration.
    """
    everything = list(items)
    weights = [weight(item) for item in everything]
    began, total = time.monotonic(), len(everything)
    for number, item in enumerate(everything):
        done, left = sum(weights[:number]), sum(weights[number:])
        elapsed = time.monotonic() - began
        to_go = elapsed * left / done if done > 0 and elapsed >= _SOON else None
        rest = "" if to_go is None else f" (about {duration(to_go)} left)"
        count = f"{number + 1} of {total}: " if total > 1 else ""
        words = f"{count}{name(item)}{rest}"
        progress(Progress(words, number, total, elapsed=elapsed, time_to_go=to_go))
        yield item


def duration(seconds: float) -> str:
    """Write a duration [s] as text in a suitable unit, such as "5 min"."""
    if not seconds < 100 * _YEAR:
        return "more than 100 years"
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"
