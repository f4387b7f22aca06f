"""Laws that a user brings: of the wear of the pin, and of the disk's surface.

A law is any object with these attributes. A wear that is none, or a height that is not finite,
is an `InvariantError`. A criterion of severe wear is a `tribo.Rule`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from tribo.errors import InputError, InvariantError, of_law, require_positive
from tribo.grid import Grid
from tribo.types import Array
from tribo.wear import Wear, WearPattern


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
        """Pattern of the wear, ``"local"`` or ``"swept"``; see `tribo.Wear`."""

    def over(self, begin: float, end: float) -> Wear:
        """Wear between two sliding distances [m], at the mean rate there."""


class Surface(Protocol):
    """A surface of the disk; it has to be hashable, and the same for the same hash.

    Examples
    --------
    >>> from tribo.simulation import SelfAffineRoughness
    >>> ground: Surface = SelfAffineRoughness(0.27e-6, 0.8, correlation_length=(4e-6, 4e-6))
    >>> ground.heights(Grid((8, 4), (1e-6, 1e-6))).shape
    (8, 4)
    """

    def __hash__(self) -> int:
        """Hash by which its heights are kept."""

    def heights(self, pixels: Grid) -> Array:
        """Heights, positive towards the pin [m], shape ``pixels.shape``."""


@dataclass(frozen=True, slots=True)
class RunningIn:
    """Wear whose rate falls as the surfaces run in.

    Between sliding distances the specific wear rate is k(S) = k∞ + (k₀ − k∞) exp(−S/L), so that a
    constant load F wears off

        V = F [k∞ S + (k₀ − k∞) L (1 − exp(−S/L))]

    Parameters
    ----------
    initial_rate, final_rate : float
        k₀ and k∞ [m²/N].
    distance : float
        L [m].
    pattern : {"local", "swept"}
        See `tribo.Wear`.

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
        """Wear between two sliding distances [m], at the mean rate there."""
        way = (end - begin) / self.distance
        faded = -math.exp(-begin / self.distance) * math.expm1(-way) / way
        rate = self.final_rate + (self.initial_rate - self.final_rate) * faded
        return Wear(rate, self.pattern)


def wear_over(wear: Wear | WearLaw, begin: float, end: float) -> Wear:
    """Wear between two sliding distances [m], also by a law of one's own.

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
    with of_law(f"wear law {wear!r}"):
        found: object = wear.over(begin, end)
    if not isinstance(found, Wear):
        raise InvariantError(
            f"wear law: its wear over {begin:g} to {end:g} m is {found!r}; it must be a tribo.Wear"
        )
    return found


def require_wear(wear: object) -> None:
    """Raise `InputError` for what is no wear, and no law of it."""
    if wear is None or isinstance(wear, Wear):
        return
    if lacks := ", ".join(name for name in ("pattern", "over") if not hasattr(wear, name)):
        raise InputError(f"the wear law {wear!r} has no {lacks}; see tribo.WearLaw")


def heights_of(surface: Any, pixels: Grid) -> Array:
    """Heights of a surface [m], shape ``pixels.shape``; `InvariantError` if they are not."""
    with of_law(f"surface {surface!r}"):
        heights = np.asarray(surface.heights(pixels), dtype=float)
    if heights.shape != pixels.shape:
        raise InvariantError(
            f"surface: its heights have the shape {heights.shape}, the window's pixels "
            f"{pixels.shape}; they must be the same"
        )
    bad = np.argwhere(~np.isfinite(heights))
    if bad.size:
        raise InvariantError(
            f"surface: its height is {heights[tuple(bad[0])]} at pixel {tuple(bad[0].tolist())}, "
            "counted from 0; each must be finite"
        )
    return heights
