"""Normal displacement of an elastic half-space under uniform pressure on rectangular elements.

The influence of one element at offset (x, y) is Love's integral of 1/(πE*r) over the element
(Love 1929; Johnson, *Contact Mechanics*, Eq. 3.25). A periodic axis sums that of all images, or,
as Bosman & de Rooij do, of the nearest one alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, get_args

import numpy as np
import scipy

from tribo.convolution import Convolution, padded_shape, wrapped_offsets
from tribo.errors import InputError, require_positive
from tribo.grid import Grid
from tribo.types import Array

__all__ = ["ElasticHalfSpace", "ElasticKernel", "elastic_influence"]

ElasticKernel = Literal["periodic", "nearest-image"]

_IMAGES = 6  # explicit ones on each side; with the tail below, 1e-13 of the self term
_FADED = 7.0  # periods from a row of images at which it is a line load, to exp(−14π) = 1e-19
_EULER_MACLAURIN = (1 / 12, -1 / 120, 1 / 252, -1 / 240, 1 / 132)  # Bernoulli numbers B₂ⱼ/(2j)
_NEAR = 20.0  # element sides beyond which Gauss quadrature is more exact than Love's formula
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


class ElasticHalfSpace(Convolution):
    """The map from pressure [Pa] to normal displacement [m] on `grid`.

    Parameters
    ----------
    grid : Grid
        Axes may be free or periodic in any mix. With a periodic axis the displacement is known
        up to a constant, which in a contact only shifts the approach.
    contact_modulus : float
        E* [Pa].
    kernel : {"periodic", "nearest-image"}, optional
        Whether a periodic axis sums all images or one; see `elastic_influence`.

    Attributes
    ----------
    self_influence : float
        Displacement of an element under unit pressure on itself alone, all images left out
        [m/Pa]. The unit in which the contact solver judges a gap.

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
        influence = elastic_influence(grid, contact_modulus, kernel)
        super().__init__(grid, np.fft.rfft2(influence).real)
        if all(grid.periodic):
            self.spectrum[0, 0] = 0.0
        half_sides = grid.spacing[0] / 2, grid.spacing[1] / 2
        self.self_influence = float(
            _love(np.zeros(1), np.zeros(1), *half_sides)[0] / (np.pi * contact_modulus)
        )


def elastic_influence(
    grid: Grid, contact_modulus: float, kernel: ElasticKernel = "periodic"
) -> Array:
    """Displacement at each offset under unit pressure on one element [m/Pa].

    Parameters
    ----------
    grid : Grid
    contact_modulus : float
        E* [Pa].
    kernel : {"periodic", "nearest-image"}, optional
        ``"periodic"`` sums all images along the periodic axes. ``"nearest-image"`` is for one
        periodic axis, say y of length L, and takes D(x, |y|) + D(x, L − |y|): the DC-FFT with
        its leakage added (Bosman & de Rooij, Fig. 3). Each point then feels a line contact of
        length 2L instead of an endless one, which is too stiff: the cylinder of their Fig. 4 has
        a peak pressure that is 1.1 % too high at L = 456 µm.

    Returns
    -------
    ndarray, shape ``padded_shape(grid)``
        In the order of `wrapped_offsets`; even in both offsets. Along periodic axes the sum over
        all images, up to a constant.

    Raises
    ------
    InputError
        If the kernel is unknown, or takes one image and not just one axis is periodic.

    Examples
    --------
    Halfway along the period both images are equally near:

    >>> line, free = (Grid((1, 9), (1e-6, 1e-6), periodic=(False, y)) for y in (True, False))
    >>> near = elastic_influence(line, 115.385e9, "nearest-image")
    >>> alone = elastic_influence(free, 115.385e9)
    >>> f"{near[0, 4] / (alone[0, 4] + alone[0, 5]):.12f}"
    '1.000000000000'
    """
    if kernel not in get_args(ElasticKernel):
        raise InputError(f"kernel is {kernel!r}; allowed are {', '.join(get_args(ElasticKernel))}")
    if kernel == "nearest-image" and sum(grid.periodic) != 1:
        raise InputError(
            f"kernel 'nearest-image' is for a patch that is periodic along one axis, not "
            f"{grid.periodic}; use 'periodic'"
        )
    mx, my = padded_shape(grid)
    quadrant_x = np.abs(wrapped_offsets(grid, 0)[: mx // 2 + 1])
    quadrant_y = np.abs(wrapped_offsets(grid, 1)[: my // 2 + 1])
    a, b = grid.spacing[0] / 2, grid.spacing[1] / 2
    period_x, period_y = grid.size
    match grid.periodic:
        case (False, True) if kernel == "nearest-image":
            quadrant = _nearest_images(quadrant_x, quadrant_y, a, b, period_y)
        case (True, False) if kernel == "nearest-image":
            quadrant = _nearest_images(quadrant_y, quadrant_x, b, a, period_x).T
        case (False, False):
            quadrant = _element(quadrant_x[:, None], quadrant_y[None, :], a, b)
        case (False, True):
            quadrant = _line_periodic(quadrant_x, quadrant_y, a, b, period_y)
        case (True, False):
            quadrant = _line_periodic(quadrant_y, quadrant_x, b, a, period_x).T
        case _ if period_x >= period_y:
            quadrant = _doubly_periodic(quadrant_x, quadrant_y, a, b, period_x, period_y)
        case _:
            quadrant = _doubly_periodic(quadrant_y, quadrant_x, b, a, period_y, period_x).T
    index_x, index_y = np.arange(mx), np.arange(my)
    mirrored = np.ix_(np.minimum(index_x, mx - index_x), np.minimum(index_y, my - index_y))
    influence: Array = quadrant[mirrored] / (np.pi * contact_modulus)
    return influence


def _love(x: Array, y: Array, a: float, b: float) -> Array:
    """∫∫ 1/r over the element with half sides a, b, seen from (x, y), in closed form."""
    left, right, low, high = x - a, x + a, y - b, y + b
    return (
        _love_term(right, high)
        - _love_term(left, high)
        - _love_term(right, low)
        + _love_term(left, low)
    )


def _love_term(x: Array, y: Array) -> Array:
    """F(x, y) = x asinh(y/|x|) + y asinh(x/|y|), 0 on the axes."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        first = np.where(x == 0, 0.0, x * np.arcsinh(y / np.abs(x)))
        second = np.where(y == 0, 0.0, y * np.arcsinh(x / np.abs(y)))
    total: Array = first + second
    return total


def _element(x: Array, y: Array, a: float, b: float) -> Array:
    """∫∫ 1/r over one element: Love's form near it, Gauss quadrature far from it.

    The four terms of Love's form cancel like r², which leaves too few digits far away.
    """
    x, y = np.broadcast_arrays(x, y)
    near = np.hypot(x, y) < 2 * _NEAR * max(a, b)
    result = np.empty(x.shape)
    result[near] = _love(x[near], y[near], a, b)
    result[~near] = _gauss(lambda s, t: 1 / np.hypot(s, t), x[~near], y[~near], a, b)
    return result


def _gauss(
    function: Callable[[Array, Array], Array], x: Array, y: Array, a: float, b: float
) -> Array:
    """∫∫ function(x + s, y + t) over |s| < a, |t| < b, by 4 × 4 Gauss points."""
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    for s, weight_s in zip(_NODES, _WEIGHTS, strict=True):
        for t, weight_t in zip(_NODES, _WEIGHTS, strict=True):
            total += weight_s * weight_t * function(x + a * s, y + b * t)
    return a * b * total


def _nearest_images(x: Array, y: Array, a: float, b: float, period: float) -> Array:
    """∫∫ 1/r over an element and the nearer of its images along y."""
    x, y = x[:, None], y[None, :]
    return _element(x, y, a, b) + _element(x, period - y, a, b)


def _line_periodic(x: Array, y: Array, a: float, b: float, period: float) -> Array:
    """∫∫ 1/r over an element and all its images along y, less a constant; all values positive."""
    element = _images_summed if 2 * a <= period else _long_element
    total = element(x, y, a, b, period)
    return total + max(0.0, -2.0 * float(total.min()))


def _long_element(x: Array, y: Array, a: float, b: float, period: float) -> Array:
    """The sum of `_images_summed` for an element that is longer than the period.

    It is that of line loads −(2/L) ln(|x|/L), plus what varies along y, which decays like
    exp(−2π|x|/L) and so is taken from parts of the element that are close and short enough.
    """
    total = np.repeat(_line_load(x, a, b, period)[:, None], y.size, axis=1)
    for index in np.flatnonzero(x - a < _FADED * period):
        left, right = max(x[index] - a, -_FADED * period), min(x[index] + a, _FADED * period)
        parts = math.ceil((right - left) / period)
        half = (right - left) / (2 * parts)
        centres = np.abs(left + half * (2 * np.arange(parts) + 1))
        varying = _images_summed(centres, y, half, b, period)
        varying -= _line_load(centres, half, b, period)[:, None]
        total[index] += varying.sum(axis=0)
    return total


def _line_load(x: Array, a: float, b: float, period: float) -> Array:
    """∫∫ −(2/L) ln(|x|/L) over an element, shape of x."""
    load: Array = -4 * b * _log_integral(x / period, a / period)
    return load


def _images_summed(x: Array, y: Array, a: float, b: float, period: float) -> Array:
    """∫∫ 1/r over an element and all its images along y, less a constant.

    Images to ±`_IMAGES` are summed; the rest is the Euler–Maclaurin sum of 1/r, whose integral
    −ln(s + r)/L is taken from a datum that makes it finite.
    """
    x, y = x[:, None], y[None, :]
    total = np.zeros((x.shape[0], y.shape[1]))
    for image in range(-_IMAGES, _IMAGES + 1):
        total += _element(x, y + image * period, a, b)

    def tail(distance_x: Array, offset_y: Array) -> Array:
        start = (_IMAGES + 1) * period
        return _tail(distance_x, start + offset_y, period) + _tail(
            distance_x, start - offset_y, period
        )

    return total + _gauss(tail, x, y, a, b)


def _tail(x: Array, s: Array, period: float) -> Array:
    """Σ 1/r over the images at s, s + L, s + 2L, … less a constant.

    Euler–Maclaurin, with the derivatives dⁿ(1/r)/dsⁿ = (−1)ⁿ n! Pₙ(s/r)/rⁿ⁺¹.
    """
    r = np.hypot(x, s)
    series = np.full(r.shape, 0.5)
    for order, coefficient in zip((1, 3, 5, 7, 9), _EULER_MACLAURIN, strict=True):
        series += coefficient * (period / r) ** order * scipy.special.eval_legendre(order, s / r)
    tail: Array = series / r - np.log((s + r) / period) / period
    return tail


def _doubly_periodic(
    x: Array, y: Array, a: float, b: float, period_x: float, period_y: float
) -> Array:
    """∫∫ 1/r over an element and all its images along both axes, less a constant.

    The part of `_line_periodic` that varies along y decays like exp(−2π|x|/L_y), so that few
    images along x do, L_x being the longer period. The part that is uniform along y is a row of
    line loads −(2/L_y) ln|x|, whose sum over all images is −(2/L_y) ln|2 sin(πx/L_x)|.
    """
    total = np.zeros((x.size, y.size))
    for image in range(-_IMAGES, _IMAGES + 1):
        distance = np.abs(x + image * period_x)
        total += _line_periodic(distance, y, a, b, period_y)
        total -= -4 * b / period_y * _log_integral(distance, a)[:, None]
    angle = 2 * np.pi / period_x
    uniform = period_x / (2 * np.pi) * (_clausen(angle * (x + a)) - _clausen(angle * (x - a)))
    return total + 4 * b / period_y * uniform[:, None]


def _log_integral(x: Array, a: float) -> Array:
    """∫ ln|x + s| ds over |s| < a, shape of x."""
    integral: Array = (
        scipy.special.xlogy(x + a, np.abs(x + a))
        - scipy.special.xlogy(x - a, np.abs(x - a))
        - 2 * a
    )
    return integral


def _clausen(angle: Array) -> Array:
    """Clausen's integral −∫₀^θ ln|2 sin(t/2)| dt."""
    integral: Array = scipy.special.spence(1 - np.exp(1j * angle)).imag
    return integral
