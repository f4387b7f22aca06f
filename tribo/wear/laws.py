"""Wear laws of a user, whose rate may depend on distance, pressure and velocity: their protocol.

A law is any object with the attributes of `WearLaw`. If its method `over` returns anything but a
`tribo.Wear`, `wear_over` raises an `InvariantError`.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tribo.errors import InputError, InvariantError, law_errors
from tribo.types import Array
from tribo.wear.archard import Wear, WearPattern


class WearLaw(Protocol):
    """A law of wear in proportion to pressure, at a rate that may change from step to step.

    The rate of a step may depend on the distance slid, on the mean pressure of the contact and on
    the sliding velocity.

    Examples
    --------
    A rate that has fallen to a half after 2 m:

    >>> import math
    >>> from dataclasses import dataclass
    >>> import tribo
    >>> @dataclass(frozen=True)
    ... class Fading:
    ...     rate: float
    ...     distance: float
    ...     pattern: str = "swept"
    ...
    ...     def over(self, begin, end, pressure, velocity):
    ...         mean = math.log((self.distance + end) / (self.distance + begin)) / (end - begin)
    ...         return tribo.Wear(self.rate * self.distance * mean, self.pattern)
    >>> law: tribo.WearLaw = Fading(6e-15, 2.0)
    >>> f"{law.over(2.0, 2.001, 1e9, 1.5).specific_wear_rate:.1e} m²/N"
    '3.0e-15 m²/N'
    """

    @property
    def pattern(self) -> WearPattern:
        """Pattern of the wear, see `tribo.Wear`.

        ``"local"``: each point of the pin wears by the pressure on it. ``"swept"``: by a mean
        pressure, as the disk's roughness moves past the pin.
        """

    def over(self, begin: float, end: float, pressure: float, velocity: float) -> Wear:
        """A `Wear` whose rate is the law's mean from sliding distance `begin` to `end` [m].

        `pressure` is the mean pressure of the contact where the step begins [Pa], 0 before the
        first contact, and `velocity` the sliding velocity [m/s].
        """


def wear_over(
    wear: Wear | WearLaw, begin: float, end: float, pressure: Array | float, velocity: float
) -> Wear:
    """A `Wear` with a constant rate: the mean from sliding distance `begin` to `end` [m].

    `wear` is a law, or a `Wear`, which has a constant rate and is returned unchanged. `pressure` is
    that of the contact where the step begins [Pa], 0 outside the contact, and `velocity` the
    sliding velocity [m/s]. If `end` does not exceed `begin`, a law gives a `Wear` with the rate 0.

    Raises
    ------
    InputError, InvariantError
        If the law fails, or if it returns no `Wear`.
    """
    if isinstance(wear, Wear):
        return wear
    if not end > begin:
        return Wear(0.0, wear.pattern)
    with law_errors(f"wear law {wear!r}"):
        touching = np.compress(np.ravel(pressure) > 0, np.ravel(pressure))
        mean = float(touching.mean()) if touching.size else 0.0
        found: object = wear.over(begin, end, mean, velocity)
    if not isinstance(found, Wear):
        raise InvariantError(
            f"wear law: its wear over {begin:g} to {end:g} m is {found!r}; it must be a tribo.Wear"
        )
    return found


def require_wear(wear: object) -> None:
    """Raise `InputError` unless `wear` is None, a `Wear` or has the attributes of a `WearLaw`."""
    if wear is None or isinstance(wear, Wear):
        return
    if lacks := ", ".join(name for name in ("pattern", "over") if not hasattr(wear, name)):
        raise InputError(f"the wear law {wear!r} has no {lacks}; see tribo.WearLaw")
