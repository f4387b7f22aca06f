"""The load as a function of time, cut into steps.

One ramp serves every load: its trunk advances by a fixed increment, whatever loads are asked
for, and each load branches off the last station of the trunk below it with one shorter step. So
no point depends on which other loads there are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from tribo.errors import require_positive

__all__ = ["Ramp", "Station"]


@dataclass(frozen=True, slots=True)
class Station:
    """A moment at which the contact is solved.

    Attributes
    ----------
    normal_load : float
        Load on the whole pin [N].
    time : float
        Since the load began to grow [s].
    on_trunk : bool
        Whether higher loads pass through this station too.
    """

    normal_load: float
    time: float
    on_trunk: bool


@dataclass(frozen=True, slots=True)
class Ramp:
    """A load that grows at a constant rate.

    Parameters
    ----------
    rate : float
        [N/s].
    reference_load : float
        The load [N] that the trunk reaches in the scene's number of increments.

    Examples
    --------
    >>> ramp = Ramp(rate=150.0, reference_load=750.0)
    >>> [station.normal_load for station in ramp.stations(200.0, increments=10)]
    [75.0, 150.0, 200.0]
    """

    rate: float
    reference_load: float

    def __post_init__(self) -> None:
        require_positive(rate=self.rate, reference_load=self.reference_load)

    def stations(
        self, normal_load: float, increments: int, after: float = 0.0
    ) -> Iterator[Station]:
        """Stations beyond the load `after` up to `normal_load`, the last one included.

        Raises
        ------
        InputError
            If the load is not positive.
        """
        require_positive(normal_load=normal_load)
        increment = self.reference_load / increments
        first = round(after / increment) + 1
        # A load within rounding of a station is that station, not a step of no length beyond it.
        last = math.floor(normal_load / increment * (1 + 1e-12))
        for index in range(first, last + 1):
            load = index * increment
            if math.isclose(load, normal_load, rel_tol=1e-12):
                yield Station(normal_load, normal_load / self.rate, on_trunk=load == normal_load)
                return
            yield Station(load, load / self.rate, on_trunk=True)
        yield Station(normal_load, normal_load / self.rate, on_trunk=False)
