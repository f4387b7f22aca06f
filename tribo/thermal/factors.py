"""One-dimensional factors of a thermal kernel: E along one axis, at the nodes of a quadrature.

A factor comes from its values at the element centres or, along a periodic axis once the heat has
spread or travelled far, from its Fourier series.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from tribo.thermal.quadrature import REACH
from tribo.types import Array, Spectrum


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of the heat kernel: n elements of side `step` [m], transformed over `length` points.

    Along a periodic axis an element acts together with all its periodic images; with
    `nearest_image` only the image nearest to each point is added to the element itself.
    """

    n: int
    step: float
    length: int
    periodic: bool
    nearest_image: bool = False

    def series_start(self, drift: float) -> float:
        """Diffusion length [m] from which on the kernel is computed by its Fourier series.

        `drift` is ``|V|/(4κ)`` [1/m]. The result is infinite if the series is never used.

        At shorter lengths the kernel is sampled at the elements, since the series would have many
        modes. At greater lengths samples would cost more, for two reasons: heat has spread over the
        period, so that images of the source count, or a moving source has passed many elements. At
        rest the limit is where heat has spread over four elements: there the series has no more
        modes than the axis has elements.
        """
        if not self.periodic or self.nearest_image:
            return math.inf
        spread = self.n * self.step / 4
        if drift:
            return min(spread, math.sqrt(16 * self.step / drift))
        return min(spread, 2 * REACH / math.pi * self.step)


def factor(axis: Axis, s: Array, low: float, drift: float) -> Spectrum:
    """Fourier transform, along `axis`, of the thermal kernel's factor E, shape (nodes, modes).

    At a coordinate x, E is erf((x + a)/s − vs) − erf((x − a)/s − vs), with half the side of an
    element, a, and v = `drift` = ``|V|/(4κ)`` [1/m]. V is the body's velocity [m/s], and κ its
    thermal diffusivity [m²/s]. `s` are diffusion lengths [m], the ascending nodes of a quadrature,
    and `low` is a lower bound of them [m]. The result is real for a body at rest.
    """
    factor: Spectrum
    if low >= axis.series_start(drift):
        factor = series_terms(axis, s, wavenumbers(axis, low)).sum(axis=1)
    else:
        factor = np.fft.rfft(_sampled_factor(axis, s, drift * s**2))
    return factor if drift else factor.real


def _sampled_factor(axis: Axis, s: Array, shift: Array) -> Array:
    """erf((x + a − d)/s) − erf((x − a − d)/s) at the element centres x, (nodes, length)."""
    first = math.floor((shift[0] - REACH * s[-1]) / axis.step - 0.5)
    last = math.ceil((shift[-1] + REACH * s[-1]) / axis.step + 0.5)
    if not axis.periodic:
        first, last = max(first, 1 - axis.n), min(last, axis.n - 1)
    elif axis.nearest_image:
        first, last = max(first, -axis.n), min(last, axis.n)
    at_rest = not shift.any()
    edges = (np.arange(0 if at_rest else first, last + 2) - 0.5) * axis.step
    edge_values = scipy.special.erf((edges - shift[:, None]) / s[:, None])
    values: Array = edge_values[:, 1:] - edge_values[:, :-1]
    if at_rest:  # the same on both sides
        values = np.concatenate((values[:, :0:-1], values), axis=1)
    if axis.nearest_image:
        # The images on both sides are equally near, so that each has half the weight.
        values[:, np.abs(np.arange(first, last + 1)) == axis.n] /= 2
    offset = first % axis.length
    periods = -(-(offset + values.shape[1]) // axis.length)
    unwrapped = np.zeros((len(s), periods * axis.length))
    unwrapped[:, offset : offset + values.shape[1]] = values
    return np.asarray(unwrapped.reshape(len(s), periods, axis.length).sum(axis=1))


def wavenumbers(axis: Axis, s: float) -> Array:
    """Wavenumbers [rad/m] of modes that have not faded at the diffusion length `s` [m].

    The shape is (aliases, modes). Sampling at the n element centres folds each mode m + pn, with an
    integer p, onto the mode m as an alias.
    """
    highest = int(REACH * axis.n * axis.step / (math.pi * s))
    modes = np.arange(min(highest, axis.n // 2) + 1)
    folds = int(highest / axis.n + 0.5)
    aliases = np.arange(-folds, folds + 1)[:, None] * axis.n
    return np.asarray(2 * math.pi / (axis.n * axis.step) * (modes + aliases), dtype=np.float64)


def series_terms(axis: Axis, s: Array, k: Array) -> Array:
    """Terms of the Fourier series of a thermal kernel along one axis, for a body at rest.

    The terms are 2 sinc(ka) exp(−k²s²/4), of shape (nodes, aliases, modes). They belong to the
    function erf((x + a)/s) − erf((x − a)/s) of the coordinate x. `s` are diffusion lengths [m], one
    for each node of a quadrature, and `k` are the `wavenumbers` [rad/m], (aliases, modes).
    a = `axis.step`/2 is half the side of an element [m].
    """
    decay = np.exp(-((k * s[:, None, None] / 2) ** 2))
    return np.asarray(2 * np.sinc(k * axis.step / (2 * math.pi)) * decay)
