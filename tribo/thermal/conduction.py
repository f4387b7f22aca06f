"""Surface temperature of a half-space heated over rectangular elements, at rest or moving.

A unit heat flux on the element ``2a × 2b`` centred at 0, from time 0 on, raises the temperature
of the insulated surface of a half-space that moves at V along x by::

    T(x, y, t) = 1/(4√π K) ∫₀^{2√(κt)} E_x E_y ds                                        (1)
    E_x = erf((x + a)/s − vs) − erf((x − a)/s − vs),   v = V/(4κ)

and E_y likewise with b and at rest (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed.,
§10.7). It is the instantaneous source integrated over its age τ, with s = 2√(κτ) the distance
that heat diffuses and vs² = Vτ the distance that the surface travels in the meantime. At each
node s of a quadrature the integrand is an outer product f(x) g(y), and so is its transform: the
spectrum of the whole kernel is a sum of outer products of one-dimensional transforms.

On each panel of the quadrature a factor comes from its values at the element centres
(`_sampled_factor`) or, along a periodic axis once the heat has spread or travelled far, from its
Fourier series (`_series_terms`).

**Length of the pin.** Along a periodic y the patch repeats as far as the pin reaches, which may be
much less than heat spreads. Of a flux, what varies along y has then long evened out: the ends are
felt by its mean along y alone. In the middle of a length ℓ heated evenly the factor E_y of that
mean is erf(ℓ/(2s)) of what it is without ends (in the middle of b = ℓ/2, E_y = 2 erf(ℓ/(2s))). So
it is here at each node of the quadrature, for the mode k_y = 0.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from tribo.convolution import Convolution, padded_shape
from tribo.errors import InputError
from tribo.grid import Grid
from tribo.material import Material
from tribo.types import Array, Spectrum

__all__ = [
    "ConductingHalfSpace",
    "HeatedLength",
    "flux_history_spectrum",
    "settling_time",
    "thermal_influence",
]

# erfc(6) = 2e-17 and exp(-6²) = 2e-16: what lies this many diffusion lengths off is nothing.
_REACH = 6.0
_NOTHING = 1e-12  # of a length, below which no part of the integral is worth a panel


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
        Gauss nodes on each panel of the integral (1); 10 give 7e-7 of the kernel's self term,
        16 give 6e-12.
    length : float or "nearest-image", optional
        Length along a periodic y that is heated [m], the patch in its middle; at least that of the
        patch is taken. Endless if not given. ``"nearest-image"``: the patch and, of its images,
        the nearer one of each element, as the leakage of Bosman & de Rooij adds it.

    Raises
    ------
    InputError
        If `velocity` is not finite, `time` is negative or not finite, there is no node, or
        `length` is not positive.

    Examples
    --------
    A square at rest in its steady state is 4a ln(1 + √2)/(πK) warm at its centre, a being half
    a side.

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
        constant = (0.0, time), (1.0, 1.0)
        spectrum = _spectrum(grid, material, velocity, *constant, quadrature_nodes, length)
        super().__init__(grid, spectrum)


def thermal_influence(
    grid: Grid,
    material: Material,
    velocity: float,
    time: float,
    quadrature_nodes: int = 10,
    length: HeatedLength = math.inf,
) -> Array:
    """Temperature rise per unit heat flux on one element, T(x, y, t) of Eq. (1) [K m²/W].

    Parameters are those of `ConductingHalfSpace`.

    Returns
    -------
    ndarray, shape `padded_shape(grid)`
        The kernel in the order of `wrapped_offsets`, images along periodic axes included.

    Examples
    --------
    Early, heat has left the element downwards only: T = 2√t/√(πKρc).

    >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> kernel = thermal_influence(Grid((3, 4), (1e-6, 1e-6)), steel, velocity=0.0, time=1e-12)
    >>> kernel.shape, f"{kernel[0, 0] * math.sqrt(math.pi) * steel.thermal_effusivity:.4e}"
    ((5, 4), '2.0000e-06')
    """
    constant = (0.0, time), (1.0, 1.0)
    spectrum = _spectrum(grid, material, velocity, *constant, quadrature_nodes, length)
    return np.fft.irfft2(spectrum, s=padded_shape(grid))


def settling_time(grid: Grid, material: Material, velocity: float) -> float:
    """Time after which the kernel of a `ConductingHalfSpace` no longer changes [s].

    By then what was heated has left the patch, and its heat does not come back against the
    motion. Infinite at rest, and where the patch repeats along x.

    Examples
    --------
    >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> patch = Grid((240, 240), (1.632e-6, 1.9e-6))
    >>> f"{settling_time(patch, steel, velocity=1.25) * 1e3:.2f} ms"
    '1.70 ms'
    """
    if grid.periodic[0]:
        return math.inf
    kappa = material.thermal_diffusivity
    width = (grid.shape[0] - 0.5) * grid.spacing[0]
    # The rest is for rounding.
    return _diffusion_length(-_REACH, abs(velocity) / (4 * kappa), width) ** 2 / (4 * kappa) * 1.001


def flux_history_spectrum(
    grid: Grid,
    material: Material,
    velocity: float,
    ages: Sequence[float],
    strengths: Sequence[float],
    quadrature_nodes: int = 10,
    length: HeatedLength = math.inf,
) -> Spectrum:
    """Spectrum of the present rise due to a flux of unit shape whose strength varied with time.

    By Duhamel's principle Eq. (1) with the strength of the flux at the age τ = s²/(4κ) under the
    integral.

    Parameters
    ----------
    grid, material, velocity, quadrature_nodes, length
        Those of `ConductingHalfSpace`.
    ages : sequence of float
        Times before now [s], at least 0 and not decreasing.
    strengths : sequence of float
        Strengths of the flux at these ages, linear in between; 0 before the first and after the
        last.

    Returns
    -------
    ndarray, shape (mx, c)
        The first c columns of a spectrum for `Convolution`; the others are 0, since what varies
        quickly along a periodic y has faded since the first age. [K m²/W]

    Raises
    ------
    InputError
        If an age is negative, not finite or below the one before, besides those of
        `ConductingHalfSpace`.

    Examples
    --------
    A flux that has grown in proportion to time gives two thirds of the rise of its final value:

    >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> plane = Grid((4, 3), (1e-6, 1e-6), periodic=(True, True))
    >>> ramp = flux_history_spectrum(plane, steel, 1.0, ages=(0.0, 5.0), strengths=(1.0, 0.0))
    >>> constant = ConductingHalfSpace(plane, steel, velocity=1.0, time=5.0)
    >>> print(f"{(ramp[0, 0] / constant.spectrum[0, 0]).real:.12f}")
    0.666666666667
    """
    return _spectrum(grid, material, velocity, ages, strengths, quadrature_nodes, length)


@dataclass(frozen=True, slots=True)
class _Axis:
    """One axis of the kernel: n elements of side `step`, transformed over `length` points.

    With `nearest_image` the elements of other periods act up to the distance of one period.
    """

    n: int
    step: float
    length: int
    periodic: bool
    nearest_image: bool = False

    def series_start(self, drift: float) -> float:
        """Diffusion length from which the Fourier series is cheaper than samples [m].

        Samples need images of the source once heat has spread over the period, and many nodes
        once a source has passed many elements; the series needs many modes before.
        """
        if not self.periodic or self.nearest_image:
            return math.inf
        spread = self.n * self.step / 4
        return min(spread, math.sqrt(16 * self.step / drift)) if drift else spread


def _spectrum(
    grid: Grid,
    material: Material,
    velocity: float,
    ages: Sequence[float],
    strengths: Sequence[float],
    quadrature_nodes: int,
    length: HeatedLength,
) -> Spectrum:
    """Transform of the kernel [K m²/W], without the last columns if 0; real if nothing moves."""
    if not math.isfinite(velocity):
        raise InputError(f"velocity is {velocity!r}; it must be finite")
    for earlier, time in itertools.pairwise((0.0, *ages)):
        if not (math.isfinite(time) and time >= earlier):
            raise InputError(f"time is {time!r}; it must be finite and at least {earlier:g}")
    if quadrature_nodes < 1:
        raise InputError(f"quadrature_nodes is {quadrature_nodes!r}; it must be at least 1")
    (mx, my), (dx, dy) = padded_shape(grid), grid.spacing
    x = _Axis(grid.shape[0], dx, mx, grid.periodic[0])
    y = _Axis(grid.shape[1], dy, my, grid.periodic[1], length == "nearest-image")
    heated = _heated_length(grid, length)
    K, kappa = material.thermal_conductivity, material.thermal_diffusivity
    v = abs(velocity) / (4 * kappa)
    # Earlier no heat has crossed half an element: both factors are 2 on the element, 0 off it.
    confined = _diffusion_length(_REACH, v, min(dx, dy) / 2)
    # Later the source has left the patch, and its heat does not come back against the motion.
    gone = math.inf if x.periodic else _diffusion_length(-_REACH, v, (x.n - 0.5) * dx)

    nodes, weights = np.polynomial.legendre.leggauss(quadrature_nodes)
    half = np.zeros((mx // 2 + 1, my // 2 + 1), dtype=complex if v else float)
    columns = 0 if ages[0] > 0 else my // 2 + 1
    filon_start = x.series_start(v) if v else math.inf
    lengths = [2 * math.sqrt(kappa * age) for age in ages]
    for (begin, end), (first, last) in zip(
        itertools.pairwise(lengths), itertools.pairwise(strengths), strict=True
    ):
        # The strength is first + slope·(s² − begin²), linear in the age.
        slope = (last - first) / (end**2 - begin**2) if end > begin else 0.0
        end = min(end, gone)
        middle = max(begin, min(confined, end))
        if middle > begin:
            half += 4 * (
                (first - slope * begin**2) * (middle - begin) + slope * (middle**3 - begin**3) / 3
            )
            columns = my // 2 + 1
        for low, high in _panels(v, middle, end, filon_start, dx):
            if low >= filon_start:
                square = (high**2 + low**2) / 2 + (high**2 - low**2) / 2 * nodes
                s = np.sqrt(square)
                k = _wavenumbers(x, low)
                terms = _filon_weights(k * v, low**2, high**2, nodes, weights)
                terms = terms / (2 * s)[:, None, None]
                f = (terms * _series_terms(x, s, k)).sum(axis=1)
            else:
                s = (high + low) / 2 + (high - low) / 2 * nodes
                f = _factor(x, s, low, v) * ((high - low) / 2 * weights)[:, None]
            f *= (first + slope * (s**2 - begin**2))[:, None]
            g = _factor(y, s, low, 0.0)
            g[:, 0] *= scipy.special.erf(heated / (2 * s))
            # Not a matrix product: the bits of one by BLAS depend on the number of its threads.
            block = half[: f.shape[1], : g.shape[1]]
            block.real += np.einsum("sm,sn->mn", f.real, g)
            if v:
                block.imag += np.einsum("sm,sn->mn", f.imag, g)
            columns = max(columns, g.shape[1])
    half = half[:, :columns]
    if velocity < 0:
        half = half.conj()
    mirrored = half[1 : (mx + 1) // 2][::-1].conj()
    return np.concatenate((half, mirrored)) / (4 * math.sqrt(math.pi) * K)


def _heated_length(grid: Grid, length: HeatedLength) -> float:
    """Length along y whose ends the mean along y feels [m]; infinite where it feels none."""
    if length == "nearest-image":
        if not grid.periodic[1]:
            raise InputError("length 'nearest-image' is for a patch that is periodic along y")
        return math.inf
    if not (isinstance(length, (int, float)) and length > 0):
        raise InputError(f"length is {length!r}; it must be positive, or 'nearest-image'")
    return max(float(length), grid.size[1]) if grid.periodic[1] else math.inf


def _diffusion_length(reach: float, drift: float, distance: float) -> float:
    """Return the s > 0 at which drift·s² + reach·s = distance; infinite if there is none.

    At that age the heat of a moving source (reach > 0: its front, reach < 0: its rear) gets past
    `distance`.
    """
    root = math.sqrt(reach**2 + 4 * drift * distance)
    if reach > 0:
        return 2 * distance / (reach + root)
    return (root - reach) / (2 * drift) if drift else math.inf


def _panels(
    drift: float, start: float, end: float, filon_start: float, side: float
) -> Iterator[tuple[float, float]]:
    """Split the diffusion lengths from `start` to `end` so that Gauss' rule resolves each part.

    Heat spreads in proportion to s, hence panels that double; and within one panel the source
    moves by at most half of `_REACH` diffusion lengths, unless Filon's rule takes care of that, or
    its edges stay away from the centres of all elements, of length `side`: seen from there, a
    source that passes quickly is either over an element or not.
    """
    low = start
    while low < end:
        if low >= filon_start:
            step = low / 2
        else:
            step = max(_REACH / (_REACH / low + 2 * drift), _NOTHING * low)
            if drift:
                step = max(step, min(low, _undisturbed(drift, low, side)))
        high = min(low + step, end)
        yield low, high
        low = high


def _undisturbed(drift: float, low: float, side: float) -> float:
    """How far s can grow until an edge of the source comes within reach of an element's centre.

    0 or less if one is within reach already. The edges pass centres when drift·s² is an odd
    multiple of half the side, and reach this far for a change of s by `_REACH`/(2 drift).
    """
    passed = math.floor(drift * low**2 / side + 0.5)
    reach = _REACH / (2 * drift)
    if passed and low < math.sqrt((passed - 0.5) * side / drift) + reach:
        return 0.0
    return math.sqrt((passed + 0.5) * side / drift) - reach - low


def _factor(axis: _Axis, s: Array, low: float, drift: float) -> Spectrum:
    """Transform of E over `axis` at the nodes s of a panel, shape (nodes, modes); real at rest."""
    factor: Spectrum
    if low >= axis.series_start(drift):
        factor = _series_terms(axis, s, _wavenumbers(axis, low)).sum(axis=1)
    else:
        factor = np.fft.rfft(_sampled_factor(axis, s, drift * s**2))
    return factor if drift else factor.real


def _sampled_factor(axis: _Axis, s: Array, shift: Array) -> Array:
    """Values of E at the element centres in wrapped order, shape (nodes, length).

    Only the elements within reach of the source are evaluated; those of all periods fall on the
    same `length` places and add up.
    """
    first = math.floor((shift[0] - _REACH * s[-1]) / axis.step - 0.5)
    last = math.ceil((shift[-1] + _REACH * s[-1]) / axis.step + 0.5)
    if not axis.periodic:
        first, last = max(first, 1 - axis.n), min(last, axis.n - 1)
    elif axis.nearest_image:
        first, last = max(first, -axis.n), min(last, axis.n)
    edges = (np.arange(first, last + 2) - 0.5) * axis.step
    u = (edges - shift[:, None]) / s[:, None]
    # erf(u) is a step from -1 to 1 and a tail. The tails are small where they nearly cancel.
    tail = scipy.special.erfc(np.abs(u))
    values = np.diff(np.where(u < 0, tail, -tail)) + 2 * np.diff((u >= 0).astype(float))
    if axis.nearest_image:
        values[:, np.abs(np.arange(first, last + 1)) == axis.n] /= 2  # both are as near
    offset = first % axis.length
    periods = -(-(offset + values.shape[1]) // axis.length)
    unwrapped = np.zeros((len(s), periods * axis.length))
    unwrapped[:, offset : offset + values.shape[1]] = values
    return np.asarray(unwrapped.reshape(len(s), periods, axis.length).sum(axis=1))


def _wavenumbers(axis: _Axis, s: float) -> Array:
    """Wavenumbers of the modes that live at diffusion length s, shape (aliases, modes) [rad/m].

    Sampling at the element centres folds the modes m + pn onto the mode m.
    """
    highest = int(_REACH * axis.n * axis.step / (math.pi * s))
    modes = np.arange(min(highest, axis.n // 2) + 1)
    folds = int(highest / axis.n + 0.5)
    aliases = np.arange(-folds, folds + 1)[:, None] * axis.n
    return np.asarray(2 * math.pi / (axis.n * axis.step) * (modes + aliases), dtype=np.float64)


def _series_terms(axis: _Axis, s: Array, k: Array) -> Array:
    """Transform of E at rest, 2 sinc(ka) exp(−k²s²/4), for each node, alias and mode."""
    decay = np.exp(-((k * s[:, None, None] / 2) ** 2))
    return np.asarray(2 * np.sinc(k * axis.step / (2 * math.pi)) * decay)


def _filon_weights(
    omega: Array,
    low: float,
    high: float,
    nodes: Array,
    weights: Array,
) -> NDArray[np.complex128]:
    """Weights of the Gauss nodes for ∫ g(z) exp(−iωz) dz from low to high, any ω.

    g is expanded in Legendre polynomials, whose integrals against exp(−iθξ) over [−1, 1] are
    2(−i)^l j_l(θ) (Bakhvalov & Vasil'eva, USSR Comput. Math. 8, 1968). Shape (nodes, *ω.shape).
    """
    degrees = np.arange(len(nodes))
    projection = np.polynomial.legendre.legvander(nodes, len(nodes) - 1) * weights[:, None]
    projection = projection * (2 * degrees + 1) * (-1j) ** degrees
    moments = scipy.special.spherical_jn(degrees[:, None, None], omega * (high - low) / 2)
    carrier = (high - low) / 2 * np.exp(-1j * omega * (high + low) / 2)
    return np.asarray(np.einsum("sl,lpm->spm", projection, moments) * carrier)
