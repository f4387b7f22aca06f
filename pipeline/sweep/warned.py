"""Points of a sweep that carry a warning, as every command counts them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

MELTS = 1700.0  # K, where a carbon steel of 1 % begins to

MOLTEN = (
    f"the deciding temperature is above {MELTS - 273.15:.0f} °C, where steel melts: the model's "
    "bodies stay solid and keep their properties, so that it says no more than that wear is "
    "severe; check the load, the velocity and the units if this is where tests were"
)


@dataclass(frozen=True, slots=True)
class Warned:
    """Points of a sweep that carry a warning, by kind.

    Attributes
    ----------
    points : int
        Number of points with at least one warning.
    kinds : dict of int
        Number of points with a warning of each kind that occurs.
    at_boundary : int or None
        Number of these beside the boundary: a neighbour in load or in velocity has the other kind
        of wear.
        None where there is no boundary, for want of a critical temperature.
    example : str
        One of the points beside the boundary, or else any of them, with its warning.

    Examples
    --------
    >>> warned = Warned(2, {"contact at edge": 2}, 1, "400 N, 2.2 m/s: contact at edge")
    >>> first, second = warned.lines()
    >>> print(second)
    warning: at 400 N, 2.2 m/s: contact at edge
    """

    points: int
    kinds: dict[str, int]
    at_boundary: int | None
    example: str = ""

    def __add__(self, other: Warned) -> Warned:
        """Points of two sweeps."""
        beside = (self.at_boundary, other.at_boundary)
        return Warned(
            self.points + other.points,
            dict(Counter(self.kinds) + Counter(other.kinds)),
            None if None in beside else sum(filter(None, beside)),
            self.example or other.example,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name."""
        return asdict(self)

    def lines(self) -> Iterator[str]:
        """Lines for the user; none where no point carries a warning."""
        if not self.points:
            return
        kinds = ", ".join(f"{kind} at {count}" for kind, count in self.kinds.items())
        if self.at_boundary is None:
            lies = "and it is not known which of them lie beside the boundary"
        elif self.at_boundary:
            lies = f"{self.at_boundary} beside the boundary, which may be wrong there"
        else:
            lies = "none beside the boundary"
        carry = "1 point carries" if self.points == 1 else f"{self.points} points carry"
        yield f"warning: {carry} a warning ({kinds}), {lies}"
        yield f"warning: at {self.example}"


NO_WARNING = Warned(0, {}, 0)
"""Of a sweep in which no point carries one."""
