"""Surface temperature of a half-space heated over rectangular elements, at rest or moving.

A unit heat flux on the element ``2a × 2b`` centred at 0, from time 0 on, raises the temperature
of the insulated surface of a half-space that moves at V along x by::

    T(x, y, t) = 1/(4√π K) ∫₀^{2√(κt)} E_x E_y ds                                        (1)
    E_x = erf((x + a)/s − vs) − erf((x − a)/s − vs),   v = V/(4κ)

and E_y likewise with b and at rest, with the conductivity K and the diffusivity κ (Carslaw &
Jaeger, *Conduction of Heat in Solids*, 2nd ed., §10.7). It is the instantaneous source integrated
over its age τ, with s = 2√(κτ) the distance that heat diffuses and vs² = Vτ the distance that the
surface travels in the meantime. At each node s of a quadrature the integrand is an outer product
f(x) g(y), and so is its transform: the spectrum of the whole kernel is a sum of outer products of
one-dimensional transforms.

The panels of the quadrature are in `quadrature`, and the factors f and g in `factors`.

**Length of the pin.** Along a periodic y the window repeats as far as the pin reaches, which may be
much less than heat spreads. Variations of the flux along y have then long evened out, and only its
mean along y is affected by the ends. In the middle of an evenly heated length ℓ the factor E_y of
that mean is erf(ℓ/(2s)) times its value without ends (in the middle of b = ℓ/2, E_y = 2
erf(ℓ/(2s))). So the mode k_y = 0 has this factor at each node of the quadrature.
"""

from __future__ import annotations

import functools
import math
from typing import Literal

import numpy as np
import scipy

from tribo.errors import InputError
from tribo.material import Material
from tribo.numerics import Convolution, Grid, padded_shape
from tribo.thermal.factors import Axis, factor, series_terms, wavenumbers
from tribo.thermal.quadrature import REACH, diffusion_length, filon_weights, panels
from tribo.types import Array, Spectrum

HeatedLength = float | Literal["nearest-image"]


class ConductingHalfSpace(Convolution):
    """Surface temperature rise of an insulated half-space under a heat flux.

    Maps a heat flux [W/m²], shape ``grid.shape``, that has acted unchanged since time 0 to the
    rise of the surface temperature [K] at `time`.

    Parameters
    ----------
    grid : Grid
        Grid of both fields, at rest relative to the heat sources.
    material : Material
        The half-space.
    velocity : float
        Velocity of the half-space along x, of either sign, V [m/s].
    time : float
        Duration of heating, t [s], at least 0.
    quadrature_nodes : int, optional
        Gauss nodes on each panel of the integral over the distance that heat diffuses. The error,
        as a share of the kernel's self term, is 7e-7 with 10 nodes and 6e-12 with 16.
    length : float or "nearest-image", optional
        Heated length along a periodic y [m], with the window in its middle, and at least as long as
        the window. Infinite if not given. With ``"nearest-image"``, the window and the nearer
        periodic image of each element are heated, as Bosman & de Rooij assume.

    Examples
    --------
    The steady rise per flux at the centre of a square at rest is 4a ln(1 + √2)/(πK), with half a
    side a.

    >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> square = Grid((1, 1), (2e-6, 2e-6), periodic=(False, False))
    >>> body = ConductingHalfSpace(square, steel, velocity=0.0, time=1e6)
    >>> exact = 4e-6 * math.log(1 + math.sqrt(2)) / (math.pi * 45.0)
    >>> print(f"{body(np.full((1, 1), 1e9))[0, 0]:.4f} K, exactly {1e9 * exact:.4f} K")
    24.9378 K, exactly 24.9378 K
    """

    def __init__(
        self,
        grid: Grid,
        material: Material,
        velocity: float,
        time: float,
        quadrature_nodes: int = 10,
        length: HeatedLength = math.inf,
    ) -> None:
        spectrum = _spectrum(grid, material, velocity, time, quadrature_nodes, length)
        super().__init__(grid, spectrum)


def settling_time(grid: Grid, material: Material, velocity: float) -> float:
    """Time after which the kernel of a `ConductingHalfSpace` no longer changes [s].

    By then the surface that was heated first has left the window, and heat no longer diffuses back.
    Infinite at rest, and if the window repeats along x.
    """
    kappa = material.thermal_diffusivity
    # The last factor is a margin for rounding.
    return _leaving_length(grid, abs(velocity) / (4 * kappa)) ** 2 / (4 * kappa) * 1.001


def _spectrum(
    grid: Grid,
    material: Material,
    velocity: float,
    time: float,
    quadrature_nodes: int,
    length: HeatedLength,
) -> Spectrum:
    """Spectrum of the map from heat flux to rise [K m²/W], by Eq. (1); real if the body is at rest.

    The parameters are those of `ConductingHalfSpace`.
    """
    _check_arguments(velocity, time, quadrature_nodes)
    (mx, my), (dx, dy) = padded_shape(grid), grid.spacing
    x = Axis(grid.shape[0], dx, mx, grid.periodic[0])
    y = Axis(grid.shape[1], dy, my, grid.periodic[1], length == "nearest-image")
    heated = _heated_length(grid, length)
    K, kappa = material.thermal_conductivity, material.thermal_diffusivity
    v = abs(velocity) / (4 * kappa)
    end = min(2 * math.sqrt(kappa * time), _leaving_length(grid, v))
    # Up to this diffusion length heat has crossed less than half an element: the kernel's factors
    # along x and y are 2 on the element, and 0 off it.
    confined_length = min(diffusion_length(REACH, v, min(dx, dy) / 2), end)

    rule = _gauss(quadrature_nodes)
    # Modes along y are on the first axis, so that the products below run along long rows.
    half_spectrum = np.zeros((my // 2 + 1, mx // 2 + 1), dtype=complex if v else float)
    half_spectrum += 4 * confined_length
    filon_start = x.series_start(v) if v else math.inf
    for panel in panels(v, confined_length, end, filon_start, dx):
        s, f = _weighted_factor(x, v, panel, rule, panel[0] >= filon_start)
        g = factor(y, s, panel[0], 0.0)
        g[:, 0] *= scipy.special.erf(heated / (2 * s))
        _add_products(half_spectrum, f, g)
    half_spectrum /= 4 * math.sqrt(math.pi) * K
    if velocity < 0:
        np.conj(half_spectrum, out=half_spectrum)
    spectrum = np.empty((mx, my // 2 + 1), half_spectrum.dtype)
    spectrum[: mx // 2 + 1] = half_spectrum.T
    np.conj(spectrum[1 : (mx + 1) // 2][::-1], out=spectrum[mx // 2 + 1 :])
    return spectrum


def _check_arguments(velocity: float, time: float, quadrature_nodes: int) -> None:
    """Raise `InputError` for an argument from which no kernel can be computed."""
    if not math.isfinite(velocity):
        raise InputError(f"velocity is {velocity!r}; it must be finite")
    if not 0 <= time < math.inf:
        raise InputError(f"time is {time!r}; it must be finite and at least 0")
    if quadrature_nodes < 1:
        raise InputError(f"quadrature_nodes is {quadrature_nodes!r}; it must be at least 1")


def _leaving_length(grid: Grid, drift: float) -> float:
    """Diffusion length [m] at which a source has left the window, and heat no longer returns."""
    if grid.periodic[0]:
        return math.inf
    # From the edge of the first element to the centre of the last.
    return diffusion_length(-REACH, drift, (grid.shape[0] - 0.5) * grid.spacing[0])


_gauss = functools.cache(np.polynomial.legendre.leggauss)


def _weighted_factor(
    axis: Axis, drift: float, panel: tuple[float, float], rule: tuple[Array, Array], filon: bool
) -> tuple[Array, Spectrum]:
    """Nodes s [m] on a panel of the integral, and the factor along x times their weights."""
    (low, high), (nodes, weights) = panel, rule
    if not filon:
        s = (high + low) / 2 + (high - low) / 2 * nodes
        return s, factor(axis, s, low, drift) * ((high - low) / 2 * weights)[:, None]
    s = np.sqrt((high**2 + low**2) / 2 + (high**2 - low**2) / 2 * nodes)
    k = wavenumbers(axis, low)
    terms = filon_weights(k * drift, low**2, high**2, nodes, weights) / (2 * s)[:, None, None]
    return s, np.asarray((terms * series_terms(axis, s, k)).sum(axis=1))


def _add_products(half_spectrum: Spectrum, f: Spectrum, g: Spectrum) -> None:
    """Add a panel, the sum over nodes of factors along x and y, to `half_spectrum`."""
    block = half_spectrum[: g.shape[1], : f.shape[1]].view(float)
    block += g.T @ f.view(float)


def _heated_length(grid: Grid, length: HeatedLength) -> float:
    """Length along y that is heated [m], at least the window's; infinite without ends."""
    if length == "nearest-image":
        if not grid.periodic[1]:
            raise InputError("length 'nearest-image' is for a window that is periodic along y")
        return math.inf
    if not (isinstance(length, (int, float)) and length > 0):
        raise InputError(f"length is {length!r}; it must be positive, or 'nearest-image'")
    return max(float(length), grid.size[1]) if grid.periodic[1] else math.inf
