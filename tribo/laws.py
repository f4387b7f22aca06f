"""Laws that a user brings: of the wear of the pin, and of the disk's surface.

A law is any object with these attributes. What it says is held against itself in every step: a
depth that is negative, a worn volume that its depths do not add up to, or a height that is not
finite is an `InvariantError`. A criterion of severe wear is a `tribo.Rule`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np

from tribo.errors import InputError, InvariantError, of_law, require_positive
from tribo.grid import Grid
from tribo.types import Array
from tribo.wear import Wear, WearPattern


class WearLaw(Protocol):
    """A law of wear in proportion to pressure, with a rate that depends on the distance slid.

    Examples
    --------
    >>> law: WearLaw = RunningIn(initial_rate=6e-15, final_rate=1e-15, distance=2.0)
    >>> bool(law.volume(750.0, 0.0, 2.0) == 750.0 * law.compliance(0.0, 2.0))
    True
    """

    @property
    def pattern(self) -> WearPattern:
        """Pattern of the wear, ``"local"`` or ``"swept"``; see `tribo.Wear`."""

    def compliance(self, begin: float, end: float) -> float:
        """Worn depth over pressure between two sliding distances [m/Pa]."""

    def depth(self, pressure: Array, begin: float, end: float) -> Array:
        """Depth that a constant pressure wears off between two sliding distances [m]."""

    def volume(self, load: float, begin: float, end: float) -> float:
        """Volume that the whole pin loses under a constant load between two distances [m³]."""


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
    >>> f"{law.volume(750.0, 0.0, 2.0):.3e} m³, at a constant rate {750.0 * 6e-15 * 2.0:.1e} m³"
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

    def compliance(self, begin: float, end: float) -> float:
        """Worn depth over pressure between two sliding distances [m/Pa]."""
        faded = math.exp(-begin / self.distance) - math.exp(-end / self.distance)
        excess = self.initial_rate - self.final_rate
        return self.final_rate * (end - begin) + excess * self.distance * faded

    def depth(self, pressure: Array, begin: float, end: float) -> Array:
        """Depth that a constant pressure wears off between two sliding distances [m]."""
        return self.compliance(begin, end) * pressure

    def volume(self, load: float, begin: float, end: float) -> float:
        """Volume lost under a constant load between two sliding distances [m³]."""
        return self.compliance(begin, end) * load


@dataclass(frozen=True, slots=True)
class OwnWear(Wear):
    """Wear by a law of one's own between two sliding distances, at its mean rate there.

    Examples
    --------
    >>> law = RunningIn(initial_rate=6e-15, final_rate=1e-15, distance=2.0)
    >>> f"{OwnWear.between(law, 0.0, 2.0).specific_wear_rate:.3e} m²/N"
    '4.161e-15 m²/N'
    """

    law: WearLaw | None = None
    begin: float = 0.0
    end: float = 1.0

    @classmethod
    def between(cls, law: WearLaw, begin: float, end: float) -> Self:
        """Wear by a law between two sliding distances [m]."""
        needed = "pattern", "compliance", "depth", "volume"
        if lacks := ", ".join(name for name in needed if not hasattr(law, name)):
            raise InputError(f"the wear law {law!r} has no {lacks}; see tribo.WearLaw")
        with of_law(f"wear law {law!r}"):
            rate = float(law.compliance(begin, end) / (end - begin)) if end > begin else 0.0
        if not 0 <= rate < math.inf:
            raise InvariantError(
                f"wear law: its compliance from {begin:g} to {end:g} m is {rate * (end - begin):g} "
                "m/Pa; it must be finite and at least 0"
            )
        return cls(rate, law.pattern, law, begin, end)

    def depth(self, pressure: Array, distance: float) -> Array:
        """Depth that the pin loses over a part of the way [m], shape of `pressure`."""
        if self.law is None or self.end == self.begin:
            return np.zeros_like(pressure)
        source = pressure.mean(axis=1, keepdims=True) if self.pattern == "swept" else pressure
        part = distance / (self.end - self.begin)
        with of_law(f"wear law {self.law!r}"):
            worn = part * np.asarray(self.law.depth(source, self.begin, self.end), dtype=float)
        if worn.shape != source.shape or not np.isfinite(worn).all():
            raise InvariantError(
                f"wear law: its depth from {self.begin:g} to {self.end:g} m has the shape "
                f"{worn.shape} for {source.shape} pressures; it must have theirs, and be finite"
            )
        return np.broadcast_to(worn, pressure.shape)

    def volume(self, load: float) -> float:
        """Volume that the law says of the whole way under a constant load [m³]."""
        if self.law is None or self.end == self.begin:
            return 0.0
        with of_law(f"wear law {self.law!r}"):
            return float(self.law.volume(load, self.begin, self.end))


def wear_of(wear: Wear | WearLaw | None) -> Wear | None:
    """Archard's wear as it is, and a law of one's own by its mean rate over the first metre."""
    if wear is None or isinstance(wear, Wear):
        return wear
    return OwnWear.between(wear, 0.0, 1.0)


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
