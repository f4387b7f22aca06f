"""Normal displacement of an elastic half-space under uniform pressure on rectangular elements.

Unit pressure on the element |x| < a, |y| < b displaces the surface by Love's integral of 1/(πE*r)
over the element (Love 1929; Johnson, *Contact Mechanics*, Eq. 3.25). With 1/r written as a sum of
Gaussians of all widths s, 1/r = 2/√π ∫₀^∞ exp(−r²/s²) ds/s², the integral separates into functions
of x and of y::

    ∫∫ 1/r = √π/2 ∫₀^∞ E_a(x) E_b(y) ds,   E_a(x) = erf((x + a)/s) − erf((x − a)/s)       (1)

Its discrete transform, the spectrum that a convolution needs, separates as well: it is a sum over
s of products of one-dimensional transforms, without the cancellation of the closed form. Along a
free axis these are transforms of the values of E at the elements. Along a periodic axis, where the
n elements of the period repeat, Poisson's formula gives the transform of all images at μ = m/n::

    Σ_j E_a(2aj) cos(2πjμ) = 2 Σ_p sinc(μ + p) exp(−(π(μ + p)s/2a)²)                      (2)

with sinc(u) = sin(πu)/(πu); few terms matter on the left where s is short, on the right where
it is long. Together, (1) and (2) are the aliased sum of the spectrum 2/(E*|q|) of the half-space
times that of the element.

The integral is the trapezoidal sum in ln s, which converges exponentially: with a step h, the
relative error of 1/r is at most 2√2 exp(−π²/2h) (Beylkin & Monzón, Appl. Comput. Harmon. Anal.
28, 2010, Sec. 2).
"""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
import scipy

from tribo.errors import InputError, require_positive
from tribo.numerics import Convolution, Grid, padded_shape
from tribo.types import Array

ElasticKernel = Literal["periodic", "nearest-image"]

_STEP = 1 / 7  # in ln s, for a relative error of 3e-15
_REACH = 6.0  # widths at which a Gaussian has faded: erfc(6) = 2e-17, exp(−6²) = 2e-16
_FAR = 1e4  # window sizes; from this width s on, E_a E_b is constant over the window, to 1e-14
_WIDE = 4 / 3  # elements; from this width s on, three terms are enough on the right of Eq. (2)
_OFFSETS = 9  # offsets j that are enough on the left of Eq. (2) below that width


class ElasticHalfSpace(Convolution):
    """The map from pressure [Pa] to normal displacement [m] on `grid`.

    Parameters
    ----------
    grid : Grid
        Axes may be free or periodic in any mix. With a periodic axis the displacement is known
        up to a constant, which in a contact only shifts the approach.
    contact_modulus : float
        Contact modulus E* [Pa].
    kernel : {"periodic", "nearest-image"}, optional
        ``"periodic"`` sums all images along the periodic axes. ``"nearest-image"`` is for one
        periodic axis, say y of length L. It adds only the nearest image to the influence D of an
        element, ``D(x, |y|) + D(x, L − |y|)``, as Bosman & de Rooij do (Fig. 3). The line contact
        then has the length 2L instead of being endless, which is too stiff: the peak pressure of
        the cylinder in their Fig. 4 is 1.1 % above Hertz's at L = 456 µm.

    Attributes
    ----------
    self_influence : float
        Displacement of an element due to unit pressure on this element, without images [m/Pa]. The
        contact solver measures gaps in this unit.

    Examples
    --------
    Under uniform pressure, the centre of a square of side 2a sinks by 8a·asinh(1)/(πE*):

    >>> solid = ElasticHalfSpace(Grid((1, 1), (2e-6, 2e-6), periodic=(False, False)), 115.385e9)
    >>> f"{solid(np.array([[1e9]])).item():.4e} m, {8e-6 * np.arcsinh(1) / np.pi / 115.385:.4e} m"
    '1.9451e-08 m, 1.9451e-08 m'
    """

    def __init__(
        self, grid: Grid, contact_modulus: float, kernel: ElasticKernel = "periodic"
    ) -> None:
        require_positive(contact_modulus=contact_modulus)
        spectrum = _spectrum(grid, kernel)
        spectrum /= np.pi * contact_modulus
        super().__init__(grid, spectrum)
        dx, dy = grid.spacing
        closed_form = 2 * (dx * math.asinh(dy / dx) + dy * math.asinh(dx / dy))
        self.self_influence = closed_form / (np.pi * contact_modulus)


def _spectrum(grid: Grid, kernel: ElasticKernel) -> Array:
    """Transform of ∫∫ 1/r over one element and its images [m], over the `padded_shape`."""
    if kernel not in get_args(ElasticKernel):
        raise InputError(f"kernel is {kernel!r}; allowed are {', '.join(get_args(ElasticKernel))}")
    if kernel == "nearest-image" and sum(grid.periodic) != 1:
        raise InputError(
            f"kernel 'nearest-image' is for a window that is periodic along one axis, not "
            f"{grid.periodic}; use 'periodic'"
        )
    s, weights = _widths(grid, kernel)
    along_x, along_y = (_factor_transform(grid, axis, kernel, s) for axis in (0, 1))
    quarter = (along_x * weights[:, None]).T @ along_y
    if kernel == "periodic":
        # The mean along a periodic axis has an infinite constant, which is omitted.
        match grid.periodic:
            case (True, True):
                quarter[0, 0] = 0.0
            case (False, True):
                quarter[:, 0] = _line_load(grid, axis=0)
            case (True, False):
                quarter[0, :] = _line_load(grid, axis=1)
    mirrored = quarter[1 : (padded_shape(grid)[0] + 1) // 2][::-1]
    return np.concatenate((quarter, mirrored))


def _widths(grid: Grid, kernel: ElasticKernel) -> tuple[Array, Array]:
    """Widths s of Gaussians [m], and weights [m] of the sum for the integral of Eq. (1)."""
    shortest = min(grid.spacing) / (2 * _REACH)
    endless = any(grid.periodic) and kernel == "periodic"
    longest = max(grid.size) * (_REACH / math.pi if endless else _FAR)
    s = shortest * np.exp(np.arange(0.0, math.log(longest / shortest) + _STEP, _STEP))
    weights = math.sqrt(math.pi) / 2 * _STEP * s
    # The omitted terms at either end form a geometric series. At shorter s, E_a E_b is 4 on the
    # element and 0 off it; at longer s it falls like 1/s², or all waves have faded.
    weights[0] /= -math.expm1(-_STEP)
    if not endless:
        weights[-1] /= -math.expm1(-_STEP)
    return s, weights


def _factor_transform(grid: Grid, axis: int, kernel: ElasticKernel, s: Array) -> Array:
    """Transform (widths, modes) of E of Eq. (1) along one axis, with images if it is periodic."""
    n, step, length = grid.shape[axis], grid.spacing[axis], padded_shape(grid)[axis]
    if not grid.periodic[axis]:
        return _even_transform(_factor_values(length // 2 + 1, step, s), length)
    if kernel == "nearest-image":
        values = _factor_values(n + 1, step, s)
        return _even_transform(values + values[:, ::-1], n)
    return _all_images(n, s / step)


def _factor_values(n: int, step: float, s: Array) -> Array:
    """E of Eq. (1) at the offsets 0 to n − 1 times `step`, (widths, n)."""
    edges = (np.arange(n + 1) - 0.5) * step
    values: Array = np.diff(scipy.special.erf(edges / s[:, None]))
    return values


def _all_images(n: int, s: Array) -> Array:
    """Transform (2) of E with all images, periods of n elements, (widths, n // 2 + 1)."""
    # Below the shortest node s, E is 2 on the element and 0 off it.
    s = np.maximum(s, 1 / (2 * _REACH))
    narrow, wide = s[s < _WIDE], s[s >= _WIDE, None, None]
    mu = np.arange(n // 2 + 1) / n
    offsets = np.arange(_OFFSETS)
    both_sides = np.where(offsets > 0, 2, 1) * _factor_values(_OFFSETS, 1.0, narrow)
    left = both_sides @ np.cos(2 * np.pi * offsets[:, None] * mu)
    waves = mu + np.array([[-1], [0], [1]])
    right = 2 * np.einsum("pm,spm->sm", np.sinc(waves), np.exp(-((np.pi * waves * wide) ** 2)))
    return np.concatenate((left, right))


def _line_load(grid: Grid, axis: int) -> Array:
    """Transform of −2 ∫ ln(|x|/c) dx over an endless strip across `axis`, an element wide [m]."""
    step, length = grid.spacing[axis], padded_shape(grid)[axis]
    c = length * step + grid.size[1 - axis]
    x, a = np.arange(length // 2 + 1) * step, step / 2
    # ½ ln|(x + a)/(x − a)|, in a form that does not cancel far away.
    log_ratio = np.arctanh(np.minimum(x / a, a / np.maximum(x, a)))
    integral = a * np.log(np.abs(x - a) / c * (x + a) / c) + 2 * x * log_ratio - 2 * a
    return _even_transform(-2 * integral, length)


def _even_transform(values: Array, length: int) -> Array:
    """Real transform of an even kernel of period `length`, at offsets 0 to length // 2."""
    index = np.arange(length)
    transform: Array = np.fft.rfft(values[..., np.minimum(index, length - index)]).real
    return transform
