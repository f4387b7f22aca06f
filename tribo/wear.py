"""Archard's wear of the pin, dh = k p dS, in steps of the sliding distance.

The pressure p follows at once from the worn depth h and the load, and wear relaxes it: a wave of
h that the half-space flattens with the compliance λ, an eigenvalue of the elastic map D, decays
as exp(−kS/λ). So the shortest waves make the equation stiff. A scheme that takes the pressure at
the end of a step solves the contact with D + k·dS in place of D, which costs nothing, since it
only adds a constant to some entries of the spectrum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from tribo.contact.elasticity import ElasticHalfSpace
from tribo.errors import InputError
from tribo.types import Array

__all__ = [
    "EXPLICIT_LIMIT",
    "WEAR_PATTERNS",
    "WEAR_SCHEMES",
    "RungeKutta",
    "Wear",
    "WearPattern",
    "WearScheme",
]

WearPattern = Literal["local", "swept"]
WEAR_PATTERNS: tuple[WearPattern, ...] = get_args(WearPattern)
WearScheme = Literal["implicit", "explicit", "sdirk2"]

EXPLICIT_LIMIT = 2.0
"""Value of `Wear.stiffness` from which on the explicit scheme is unstable."""


@dataclass(frozen=True, slots=True)
class RungeKutta:
    """A scheme for dh/dS = k p(h, F), of one or more stages.

    Stage i takes the load at the fraction cᵢ of the step, and there the pressure pᵢ of the shape
    worn by h + k dS (b₁p₁ + … + bᵢ₋₁pᵢ₋₁ + γpᵢ). The step ends at h + k dS Σ bᵢpᵢ.

    Attributes
    ----------
    fractions, weights : tuple of float
        c and b.
    implicitness : float
        γ; 0 for a scheme that takes the pressure before the wear that it causes.
    """

    fractions: tuple[float, ...]
    weights: tuple[float, ...]
    implicitness: float


_GAMMA = 1 - 1 / math.sqrt(2)

WEAR_SCHEMES: dict[WearScheme, RungeKutta] = {
    "implicit": RungeKutta((1.0,), (1.0,), implicitness=1.0),
    "explicit": RungeKutta((1.0,), (1.0,), implicitness=0.0),
    "sdirk2": RungeKutta((_GAMMA, 1.0), (1 - _GAMMA, _GAMMA), implicitness=_GAMMA),
}
"""Schemes by name.

``"implicit"``, backward Euler: of first order, stable for any step. ``"explicit"``, the loop of
Bosman & de Rooij (Fig. 2): of first order, stable while k·dS is below `EXPLICIT_LIMIT` times the
smallest compliance. ``"sdirk2"`` (Alexander, SIAM J. Numer. Anal. 14, 1977): of second order,
stable for any step, at twice the cost.
"""


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
        source = pressure.mean(axis=1, keepdims=True) if self.pattern == "swept" else pressure
        return np.broadcast_to(self.specific_wear_rate * distance * source, pressure.shape)

    def yielding(self, solid: ElasticHalfSpace, distance: float) -> ElasticHalfSpace:
        """`solid` with the wear over a sliding distance added to its displacement.

        Raises
        ------
        InputError
            If the pattern is swept and the patch not periodic along y.
        """
        compliance = self.specific_wear_rate * distance
        if self.pattern == "swept" and not solid.grid.periodic[1]:
            raise InputError(
                "swept wear averages along y, which needs a patch that is periodic along y; "
                "use the pattern 'local'"
            )
        if self.pattern == "local" or solid.grid.shape[1] == 1:
            worn = solid.with_spectrum(solid.spectrum + compliance)
            worn.self_influence += compliance
            return worn
        spectrum = solid.spectrum.copy()
        spectrum[:, 0] += compliance
        return solid.with_spectrum(spectrum)

    def stiffness(self, solid: ElasticHalfSpace, distance: float) -> float:
        """k·dS/λ_min, the decay of the shortest wave over a sliding distance.

        λ_min is the smallest eigenvalue of the elastic map among the shapes that wear: all of
        them, or for swept wear those that are uniform along y.

        Examples
        --------
        The paper's grid at 1.25 m/s and 0.05 s an increment, far beyond `EXPLICIT_LIMIT`:

        >>> from tribo.grid import Grid
        >>> solid = ElasticHalfSpace(Grid((240, 240), (1.632e-6, 1.9e-6)), 115.385e9)
        >>> f"{Wear(1.2e-15, 'local').stiffness(solid, 1.25 * 0.05):.2f}"
        '8.52'
        """
        compliances = solid.spectrum[:, 0] if self.pattern == "swept" else solid.spectrum
        return self.specific_wear_rate * distance / float(compliances[compliances > 0].min())
