"""Blame for the death of workers: points fail that kill even a worker of their own.

A worker that dies takes with it whatever it was given to do, and does not say what it died of. So
the point at which each lost task was is suspected, and tried again later on a worker that computes
nothing else. Kills from outside hit the same point again now and then, but not time after time.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from pipeline.sweep.model import Point

TRIALS = 5  # alone, that a point may be lost in before it is called failed


@dataclass(frozen=True, slots=True)
class Suspects:
    """Points that were lost with a worker, and how often each was lost alone.

    Attributes
    ----------
    losses : mapping of Point to int
        Number of times that each suspect was lost while it was tried alone.

    Examples
    --------
    >>> deadly, bystander = Point(600.0, 1.5), Point(600.0, 2.0)
    >>> suspects = Suspects().after_loss(deadly, alone=False).after_loss(bystander, alone=False)
    >>> suspects = suspects.without([bystander])
    >>> for _ in range(TRIALS):
    ...     suspects = suspects.after_loss(deadly, alone=True)
    >>> [str(point) for point in suspects.failed]
    ['600 N, 1.5 m/s']
    """

    losses: Mapping[Point, int] = field(default_factory=dict)

    def after_loss(self, point: Point, alone: bool) -> Suspects:
        """Take note that a task was lost at a point, which may have been tried alone."""
        return Suspects({**self.losses, point: self.losses.get(point, 0) + alone})

    def without(self, points: Collection[Point]) -> Suspects:
        """Take points off the list: cleared of suspicion, or called failed."""
        return Suspects({point: n for point, n in self.losses.items() if point not in points})

    @property
    def to_try(self) -> list[Point]:
        """Points to try alone, those lost least often first."""
        return sorted(self.losses, key=lambda point: self.losses[point])

    @property
    def failed(self) -> list[Point]:
        """Points that are to be called failed."""
        return [point for point, number in self.losses.items() if number >= TRIALS]
