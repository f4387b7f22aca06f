"""Wear laws whose rate depends on the distance slid: their protocol, and the law that ships.

A law is any object with the attributes of `WearLaw`. If its method `over` returns anything but a
`tribo.Wear`, `wear_over` raises an `InvariantError`. The laws of this package are frozen
dataclasses in this module, named in `LAWS`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from tribo.errors import InputError, InvariantError, law_errors, require_positive
from tribo.wear.archard import Wear, WearPattern


class WearLaw(Protocol):
    """A law of wear in proportion to pressure, at a rate that depends on the distance slid.

    Examples
    --------
    >>> law: WearLaw = RunningIn(initial_rate=6e-15, final_rate=1e-15, distance=2.0)
    >>> law.over(0.0, 1.0).specific_wear_rate > law.over(1.0, 2.0).specific_wear_rate
    True
    """

    @property
    def pattern(self) -> WearPattern:
        """Pattern of the wear, see `tribo.Wear`.

        ``"local"``: each point of the pin wears by the pressure on it. ``"swept"``: by a mean
        pressure, as the disk's roughness moves past the pin.
        """

    def over(self, begin: float, end: float) -> Wear:
        """A `Wear` whose rate is the law's mean from sliding distance `begin` to `end` [m]."""


@dataclass(frozen=True, slots=True)
class RunningIn:
    """Wear whose rate falls as the surfaces run in.

    After a sliding distance S the specific wear rate is k(S) = k∞ + (k₀ − k∞) exp(−S/L). So up to
    this distance a constant load F wears off the volume

        V = F [k∞ S + (k₀ − k∞) L (1 − exp(−S/L))]

    Parameters
    ----------
    initial_rate : float
        Specific wear rate k₀ before running in [m²/N].
    final_rate : float
        Specific wear rate k∞ after running in [m²/N].
    distance : float
        Sliding distance L over which the excess of the rate, k − k∞, falls by a factor of e [m].
    pattern : {"local", "swept"}
        Whether each point of the pin wears by the pressure on it, or by a mean pressure; see
        `tribo.Wear`.

    Examples
    --------
    >>> law = RunningIn(initial_rate=6e-15, final_rate=1e-15, distance=2.0)
    >>> volume = 750.0 * 2.0 * law.over(0.0, 2.0).specific_wear_rate
    >>> f"{volume:.3e} m³, at a constant rate {750.0 * 6e-15 * 2.0:.1e} m³"
    '6.241e-12 m³, at a constant rate 9.0e-12 m³'
    """

    initial_rate: float
    final_rate: float
    distance: float
    pattern: WearPattern = "swept"

    def __post_init__(self) -> None:
        require_positive(distance=self.distance)
        for name in ("initial_rate", "final_rate"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} is {getattr(self, name)!r}; it must be finite and ≥ 0")

    def over(self, begin: float, end: float) -> Wear:
        """A `Wear` whose rate is the law's mean from sliding distance `begin` to `end` [m]."""
        way = (end - begin) / self.distance
        faded = -math.exp(-begin / self.distance) * math.expm1(-way) / way
        rate = self.final_rate + (self.initial_rate - self.final_rate) * faded
        return Wear(rate, self.pattern)


LAWS: dict[str, type[WearLaw]] = {"running-in": RunningIn}
"""Laws whose rate depends on the distance slid, by name."""


def wear_over(wear: Wear | WearLaw, begin: float, end: float) -> Wear:
    """A `Wear` with a constant rate: the mean from sliding distance `begin` to `end` [m].

    `wear` is a law over the sliding distance, or a `Wear`, which has a constant rate and is
    returned unchanged. If `end` does not exceed `begin`, a law gives a `Wear` with the rate 0.

    Raises
    ------
    InputError, InvariantError
        If the law fails, or if it returns no `Wear`.

    Examples
    --------
    >>> law = RunningIn(initial_rate=6e-15, final_rate=1e-15, distance=2.0)
    >>> f"{wear_over(law, 0.0, 2.0).specific_wear_rate:.3e} m²/N"
    '4.161e-15 m²/N'
    """
    if isinstance(wear, Wear):
        return wear
    if not end > begin:
        return Wear(0.0, wear.pattern)
    with law_errors(f"wear law {wear!r}"):
        found: object = wear.over(begin, end)
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
