"""Protocol of user-defined wear laws, whose rate depends on distance, pressure and velocity.

A law is any object with the attributes of `WearLaw`. If its method `mean_wear` returns anything but
a `tribo.Wear`, `evaluate_wear` raises an `InvariantError`.
"""

from __future__ import annotations

from typing import Protocol

from tribo.errors import InputError, InvariantError, law_errors
from tribo.wear.archard import Wear, WearPattern


class WearLaw(Protocol):
    """A law of wear in proportion to pressure, with one specific wear rate in each step.

    The rate may depend on the distance slid, on the pressure in the contact and on the sliding
    velocity.

    Examples
    --------
    A rate that falls as the pin slides, to a half after 2 m, and grows with the velocity:

    >>> import math
    >>> from dataclasses import dataclass
    >>> import tribo
    >>> @dataclass(frozen=True)
    ... class Fading:
    ...     rate: float  # at 1 m/s
    ...     distance: float
    ...     pattern: str = "swept"
    ...
    ...     def mean_wear(self, begin, end, pressure, velocity):
    ...         mean = math.log((self.distance + end) / (self.distance + begin)) / (end - begin)
    ...         return tribo.Wear(self.rate * velocity * self.distance * mean, self.pattern)
    >>> law: tribo.WearLaw = Fading(6e-15, 2.0)
    >>> f"{law.mean_wear(2.0, 2.001, pressure=5e8, velocity=1.5).specific_wear_rate:.1e} m²/N"
    '4.5e-15 m²/N'
    """

    @property
    def pattern(self) -> WearPattern:
        """Pattern of the wear, see `tribo.Wear`.

        ``"local"``: each point of the pin wears by the pressure on it. ``"swept"``: by a mean
        pressure, as the disk's roughness moves past the pin.
        """

    def mean_wear(self, begin: float, end: float, pressure: float, velocity: float) -> Wear:
        """A `Wear` with the law's mean rate in a step, from sliding distance `begin` to `end` [m].

        `pressure` is the nominal pressure at the step's begin [Pa]: the load over the area that
        the contact spans, width × length under a line contact, else the ellipse of its two widths.
        It is 0 before the first contact. A rate that depends on it is of first order in the steps.
        `velocity` is the sliding velocity, not negative [m/s].
        """


def evaluate_wear(
    wear: Wear | WearLaw, begin: float, end: float, pressure: float, velocity: float
) -> Wear:
    """A `Wear` with a constant rate: the mean from sliding distance `begin` to `end` [m].

    `wear` is a law, called with the arguments of `WearLaw.mean_wear`, or a `Wear`, which is
    returned unchanged. If `end` does not exceed `begin`, a law gives a `Wear` with the rate 0.

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
        step_wear: object = wear.mean_wear(begin, end, pressure, velocity)
    if not isinstance(step_wear, Wear):
        raise InvariantError(
            f"wear law: its wear over {begin:g} to {end:g} m is {step_wear!r}; it must be a "
            "tribo.Wear"
        )
    return step_wear


def require_wear(wear: object) -> None:
    """Raise `InputError` unless `wear` is None, a `Wear` or has the attributes of a `WearLaw`."""
    if wear is None or isinstance(wear, Wear):
        return
    if missing := ", ".join(name for name in ("pattern", "mean_wear") if not hasattr(wear, name)):
        raise InputError(f"the wear law {wear!r} has no {missing}; see tribo.WearLaw")
