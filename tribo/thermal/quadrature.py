"""Quadrature over the distance that heat has diffused, s = 2√(κτ): panels, and Filon's rule.

Gauss' rule resolves each panel, unless the integrand oscillates along it: there `filon_weights`
take the oscillation into the weights.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import scipy
from numpy.typing import NDArray

from tribo.types import Array

# erfc(6) = 2e-17 and exp(-6²) = 2e-16: heat has no effect beyond this many diffusion lengths.
REACH = 6.0
_MIN_PANEL_RATIO = 1e-12  # smallest panel over its diffusion length


def diffusion_length(reach: float, drift: float, distance: float) -> float:
    """Return the diffusion length s > 0 [m] at which drift·s² + reach·s = `distance` [m].

    While heat diffuses by s, its source moves by drift·s², with the `drift` ``|V|/(4κ)`` [1/m]. The
    heat extends to `reach` times s ahead of the source, or behind it if `reach` is negative. At the
    returned s this front or rear of the heat is at `distance` from where the source started. The
    result is infinite if there is no such s.
    """
    root = math.sqrt(reach**2 + 4 * drift * distance)
    if reach > 0:
        return 2 * distance / (reach + root)
    return (root - reach) / (2 * drift) if drift else math.inf


def panels(
    drift: float, start: float, end: float, filon_start: float, side: float
) -> Iterator[tuple[float, float]]:
    """Split the range of diffusion lengths from `start` to `end` [m] into panels of quadrature.

    Yields the ends of each panel [m]. Below `filon_start` panels are for Gauss' rule: the diffusion
    length at most doubles within a panel, and where an edge of the moving source is near an
    element's centre, the source moves by at most `REACH` diffusion lengths. From `filon_start` on
    panels are for Filon's rule, and the diffusion length grows by half within each. `drift` is
    ``|V|/(4κ)`` [1/m], and `side` is the side of an element [m].
    """
    low = start
    while low < end:
        if low >= filon_start:
            step = low / 2
        else:
            step = max(REACH / (REACH / low + 2 * drift), _MIN_PANEL_RATIO * low)
            if drift:
                # A fast source is either over the centre of an element or not, except while one of
                # its edges is near a centre.
                step = max(step, min(low, _growth_until_edge(drift, low, side)))
        high = min(low + step, end)
        yield low, high
        low = high


def _growth_until_edge(drift: float, low: float, side: float) -> float:
    """Growth of the diffusion length from `low` until the source's edge is near a centre [m]."""
    # An edge passes a centre where drift·s² is an odd multiple of half a side, and acts within
    # REACH/(2 drift) of this s.
    centre_count = math.floor(drift * low**2 / side + 0.5)
    reach = REACH / (2 * drift)
    if centre_count and low < math.sqrt((centre_count - 0.5) * side / drift) + reach:
        return 0.0
    return math.sqrt((centre_count + 0.5) * side / drift) - reach - low


def filon_weights(
    omega: Array,
    low: float,
    high: float,
    nodes: Array,
    weights: Array,
) -> NDArray[np.complex128]:
    """Weights of the Gauss nodes for ∫ g(z) exp(−iωz) dz from low to high, any ω.

    g is expanded in Legendre polynomials. The integral of the l-th one against exp(−iθξ) over −1 ≤
    ξ ≤ 1 is 2(−i)^l j_l(θ), here with θ = ω(high − low)/2 (Bakhvalov & Vasil'eva, USSR Comput.
    Math. 8, 1968). `omega` is ω; `nodes` and `weights` are from Gauss' rule on [−1, 1]. The shape
    of the result is (nodes, *ω.shape).
    """
    degrees = np.arange(len(nodes))
    projection = np.polynomial.legendre.legvander(nodes, len(nodes) - 1) * weights[:, None]
    projection = projection * (2 * degrees + 1) * (-1j) ** degrees
    moments = scipy.special.spherical_jn(degrees[:, None, None], omega * (high - low) / 2)
    carrier = (high - low) / 2 * np.exp(-1j * omega * (high + low) / 2)
    return np.asarray(np.einsum("sl,lpm->spm", projection, moments) * carrier)
