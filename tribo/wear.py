"""Archard's wear of the pin, dh = k p dS, by the implicit (backward Euler) scheme.

The pressure at the end of an increment is the one that the worn shape itself gives. So the
contact is solved with D + k·dS in place of D, and h grows by k·dS·p: at no cost, since that only
adds a constant to some entries of the spectrum, and stable for any k·dS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tribo.elasticity import ElasticHalfSpace
from tribo.errors import InputError

__all__ = ["WEAR_PATTERNS", "Wear", "WearPattern"]

Array = NDArray[np.float64]
WearPattern = Literal["local", "swept"]
WEAR_PATTERNS: tuple[WearPattern, ...] = ("local", "swept")


@dataclass(frozen=True, slots=True)
class Wear:
    """How the pin wears.

    Parameters
    ----------
    specific_wear_rate : float
        Worn volume per load and sliding distance, k [m²/N].
    pattern : {"local", "swept"}
        ``"local"``: each point of the pin wears by the pressure on it, as if it always faced the
        same patch of the disk (Bosman & de Rooij, Eq. 26). ``"swept"``: the roughness moves past
        the pin, which at x loses the mean along y, dh(x) = k dS ⟨p(x, ·)⟩_y. It needs a patch
        that is periodic along y.

    Raises
    ------
    InputError
        If the rate is negative or the pattern unknown.

    Examples
    --------
    >>> steel = Wear(specific_wear_rate=1.2e-15, pattern="swept")
    >>> steel.depth(np.array([[1e9, 3e9]]), distance=0.0625)
    array([[1.5e-07, 1.5e-07]])
    """

    specific_wear_rate: float
    pattern: WearPattern = "swept"

    def __post_init__(self) -> None:
        if not 0 <= self.specific_wear_rate < np.inf:
            raise InputError(
                f"specific_wear_rate is {self.specific_wear_rate!r}; it must be finite and ≥ 0"
            )
        if self.pattern not in WEAR_PATTERNS:
            raise InputError(
                f"wear pattern is {self.pattern!r}; allowed are {', '.join(WEAR_PATTERNS)}"
            )

    def depth(self, pressure: Array, distance: float) -> Array:
        """Depth that the pin loses over a sliding distance [m], shape of `pressure`."""
        if self.pattern == "swept":
            pressure = np.broadcast_to(pressure.mean(axis=1, keepdims=True), pressure.shape)
        worn: Array = self.specific_wear_rate * distance * pressure
        return worn

    def yielding(self, solid: ElasticHalfSpace, distance: float) -> ElasticHalfSpace:
        """`solid` with the wear over a sliding distance added to its displacement.

        Raises
        ------
        InputError
            If the pattern is swept and the patch not periodic along y.
        """
        compliance = self.specific_wear_rate * distance
        if self.pattern == "local":
            return solid.with_spectrum(solid.spectrum + compliance)
        if not solid.grid.periodic[1]:
            raise InputError(
                "swept wear averages along y, which needs a patch that is periodic along y; "
                "use the pattern 'local'"
            )
        spectrum = solid.spectrum.copy()
        spectrum[:, 0] += compliance
        return solid.with_spectrum(spectrum)
