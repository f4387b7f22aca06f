"""The load as a function of time, cut into steps.

One ramp serves many loads: its trunk advances by a fixed increment, whatever loads are asked
for, and each load branches off the last station of the trunk below it with one shorter step. A
load far below the reference load would then take few steps, and so has a trunk of smaller
increments: halved until the load takes a quarter of the steps that the reference load takes. Which
trunk leads to a load depends on nothing else, so no point depends on which other loads there are.
A hold at constant load belongs to its point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from tribo.errors import InputError, require_integer, require_positive

MOST_STEPS = 100_000
"""Steps that a load or a hold may take; more are an oversight."""


_CURES = {
    "hold": ("s", "Give a shorter hold, or hold_steps"),
    "load": ("N", "Choose fewer increments or a higher reference_load"),
}
_FEWEST_SHARE = 0.25  # of the increments up to the reference load, that a load takes at least


@dataclass(frozen=True, slots=True)
class Station:
    """A moment at which the contact is solved.

    Attributes
    ----------
    normal_load : float
        Load on the whole pin [N].
    time : float
        Time since the load began to grow [s].
    on_trunk : bool
        True if higher loads pass through this station too.
    index : int
        Number of steps from the unloaded state to here.
    impulse : float
        Integral of the load over the time since then, ∫F dt [N s].
    holding : bool
        True if the load has been the same since the station before.

    Examples
    --------
    >>> import tribo
    >>> ramp = tribo.Ramp(rate=150.0, reference_load=750.0)
    >>> *_, last = ramp.stations(100.0, increments=10)
    >>> last.normal_load, last.on_trunk
    (100.0, False)
    """

    normal_load: float
    time: float
    on_trunk: bool
    index: int
    impulse: float
    holding: bool = False


@dataclass(frozen=True, slots=True)
class Ramp:
    """A load that grows at a constant rate and may then be held.

    Parameters
    ----------
    rate : float
        Growth of the load on the whole pin [N/s].
    reference_load : float
        Load that the trunk reaches in the scene's number of increments [N].
    hold : float, optional
        Duration for which each point's load goes on once it is reached [s].
    hold_steps : int, optional
        Steps of the hold; if not given, as few as are no longer than those of the trunk.

    Examples
    --------
    >>> ramp = Ramp(rate=150.0, reference_load=750.0, hold=4.0, hold_steps=2)
    >>> for station in ramp.stations(200.0, increments=10):
    ...     print(f"{station.normal_load:g} N at {station.time:.4f} s")
    75 N at 0.5000 s
    150 N at 1.0000 s
    200 N at 1.3333 s
    200 N at 3.3333 s
    200 N at 5.3333 s
    """

    rate: float
    reference_load: float
    hold: float = 0.0
    hold_steps: int | None = None

    def __post_init__(self) -> None:
        require_positive(rate=self.rate, reference_load=self.reference_load)
        if not 0 <= self.hold < math.inf:
            raise InputError(f"hold is {self.hold!r} s; it must be finite and at least 0")
        if self.hold_steps is not None:
            require_integer(1, hold_steps=self.hold_steps)
            if self.hold_steps > MOST_STEPS:
                raise InputError(
                    f"hold_steps is {self.hold_steps}; it must be at most {MOST_STEPS}"
                )

    def increment(self, normal_load: float, increments: int) -> float:
        """Load by which each step of the trunk that leads to a load is higher [N].

        Loads of one increment share their trunk.

        Examples
        --------
        >>> ramp = Ramp(rate=150.0, reference_load=800.0)
        >>> [ramp.increment(load, increments=100) for load in (800.0, 200.0, 199.0, 10.0)]
        [8.0, 8.0, 4.0, 0.25]
        """
        share = normal_load / self.reference_load * (1 + 1e-12)
        halvings = 0
        if 0 < share < _FEWEST_SHARE:
            halvings = math.ceil(math.log2(_FEWEST_SHARE) - math.log2(share))
        return math.ldexp(self.reference_load / increments, -halvings)

    def stations(self, normal_load: float, increments: int) -> Iterator[Station]:
        """Stations up to `normal_load` [N] and through its hold.

        The increments are the steps of the trunk up to the reference load.
        """
        require_positive(normal_load=normal_load)
        require_integer(1, increments=increments)
        for station in self._rise(normal_load, increments):
            yield station  # `yield from` would not keep the last one
        if self.hold:
            step = self.increment(normal_load, increments) / self.rate
            steps = self.hold_steps or _whole(math.ceil, "hold", self.hold, step)
            for number in range(1, steps + 1):
                yield Station(
                    normal_load,
                    station.time + self.hold * number / steps,
                    on_trunk=False,
                    index=station.index + number,
                    impulse=station.impulse + normal_load * self.hold * number / steps,
                    holding=True,
                )

    def _rise(self, normal_load: float, increments: int) -> Iterator[Station]:
        """Stations of the trunk, and the one at `normal_load`."""
        increment = self.increment(normal_load, increments)
        last = _whole(math.floor, "load", normal_load, increment)
        for index in range(1, last + 1):
            load = index * increment
            if math.isclose(load, normal_load, rel_tol=1e-12):
                yield self._reached(normal_load, load == normal_load, index)
                return
            yield self._reached(load, True, index)
        yield self._reached(normal_load, False, last + 1)

    def _reached(self, normal_load: float, on_trunk: bool, index: int) -> Station:
        """Station at which the growing load has reached `normal_load`."""
        time = normal_load / self.rate
        return Station(normal_load, time, on_trunk, index, impulse=normal_load * time / 2)


def _whole(rounded: Callable[[float], int], name: str, whole: float, step: float) -> int:
    """Number of steps that make up the whole; a whole number where it is one but for rounding."""
    steps = whole / step if step > 0 else math.inf
    if not steps <= MOST_STEPS:
        unit, cure = _CURES[name]
        raise InputError(
            f"{name} is {whole:g} {unit}, which takes {steps:.3g} steps of {step:.3g} {unit}; at "
            f"most {MOST_STEPS} are allowed. {cure}"
        )
    return rounded(steps * (1 - 1e-12 if rounded is math.ceil else 1 + 1e-12))
