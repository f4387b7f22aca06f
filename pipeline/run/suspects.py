"""Points that workers may die of."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from pipeline.sweep.model import Point

TRIALS = 5
"""Times that a point may be lost alone before it is called failed."""
STARTS = 3
"""Workers that may leave in the midst of a point before it is called failed."""


class Suspects:
    """Points that were on a worker as it died, and how often each was lost while tried alone.

    Examples
    --------
    >>> suspects, point = Suspects(), Point(600.0, 1.5)
    >>> suspects.accuse(point, alone=False), [*suspects.besides(())]
    (False, [Point(load=600.0, velocity=1.5, variant=())])
    >>> [suspects.accuse(point, alone=True) for _ in range(TRIALS)]
    [False, False, False, False, True]
    """

    def __init__(self) -> None:
        self._losses: dict[Point, int] = {}

    def __bool__(self) -> bool:
        return bool(self._losses)

    def besides(self, tried: Collection[Point]) -> Iterator[Point]:
        """Suspects that are not being tried, those first that were lost least often."""
        in_order = sorted(self._losses, key=lambda point: self._losses[point])
        return (point for point in in_order if point not in tried)

    def accuse(self, point: Point, alone: bool) -> bool:
        """Count a loss if the point was alone; return whether it has been lost often enough."""
        self._losses[point] = self._losses.get(point, 0) + alone
        return self._losses[point] >= TRIALS

    def acquit(self, point: Point) -> None:
        """Forget a point that is done, or has failed for good."""
        self._losses.pop(point, None)
