"""Stages of a long computation: which one begins, of how many, and the time to go."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
Tell = Callable[[str], None]
"""Takes a line on what goes on."""
Count = Callable[[int, int], None]
"""Takes how many of a task's parts are done, and how many there are."""

_YEAR = 365.25 * 24 * 3600  # [s]
_SOON = 2.0  # [s] before which no time is predicted


def staged(
    items: Iterable[T],
    tell: Tell | None,
    name: Callable[[T], str] = str,
    weight: Callable[[T], float] = lambda item: 1.0,
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[T]:
    """Go through items, and say before each which it is, of how many, and the time to go."""
    everything = list(items)
    weights = [weight(item) for item in everything]
    began = clock()
    for number, item in enumerate(everything):
        done, left = sum(weights[:number]), sum(weights[number:])
        elapsed = clock() - began
        can_tell = done > 0 and elapsed >= _SOON
        rest = f" (about {duration(elapsed * left / done)} to go)" if can_tell else ""
        count = f"{number + 1} of {len(everything)}: " if len(everything) > 1 else ""
        if tell:
            tell(f"{count}{name(item)}{rest}")
        yield item


def duration(seconds: float) -> str:
    """Write a duration in the unit that suits it."""
    if not seconds < 100 * _YEAR:
        return "more than 100 years"
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"
