"""Fit a self-affine random surface to measured heights, of a map or of profiles.

The spectrum of `tribo.surface.self_affine` is fitted to the periodogram of the heights by Whittle's
likelihood: on a random surface, each mode of the periodogram is exponentially distributed about the
spectrum. A Hann window prevents leakage from the edges of a surface that is not periodic. Before
the comparison the spectrum is smoothed by that window, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from pipeline.quantities import display
from tribo.errors import InputError
from tribo.types import Array

_FEWEST = 16  # least number of heights along each side of a map
_FEWEST_OF_PROFILE = 64
_SHORTEST = 0.5  # share of the Nyquist wavenumber up to which instruments resolve the spectrum
_BANDS = 6  # bands of wavelength compared
_NEIGHBOURS = 101  # modes whose median tells the power that is usual beside a peak
_PEAK = 30.0  # power of a peak over the usual one; in random profiles it is 16 at most
_FLAT = 1e-200  # least power of neighbours over the fit's, above 0
_MODES, _MODES_OF_PROFILE = 50, 10  # least number of modes in a band


@dataclass(frozen=True, slots=True)
class SelfAffineFit:
    """Parameters of a self-affine surface fitted to heights.

    Attributes
    ----------
    hurst_exponent : float
        Hurst exponent H, from 0 to 1.
    correlation_length : tuple of float
        Correlation lengths along x and y [m].
    misfit : float
        Largest factor between the fitted spectrum and the heights' spectrum in any band of
        wavelength.

    Examples
    --------
    >>> from tribo import Grid
    >>> from tribo.surface import self_affine
    >>> heights = self_affine(Grid((128, 128), (1e-6, 1e-6)), 2e-7, 0.7, (4e-6, 4e-6), seed=1)
    >>> fit = fit_self_affine(heights, (1e-6, 1e-6))
    >>> abs(fit.hurst_exponent - 0.7) < 0.15  # single surfaces differ by 0.07
    True
    """

    hurst_exponent: float
    correlation_length: tuple[float, float]
    misfit: float


def fit_self_affine(heights: Array, spacing: tuple[float, float]) -> SelfAffineFit:
    """Find the self-affine surface whose spectrum fits the heights best.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights above their least-squares plane, without gaps [m].
    spacing : tuple of float
        Sides of a pixel along x and y [m].

    Raises
    ------
    InputError
        If there are fewer than 16 heights along x or y.

    Notes
    -----
    The fit minimises the sum of ln S + P/S over modes, with spectrum S and periodogram P
    (Whittle, *Ark. Mat.* 2, 1953).

    Examples
    --------
    >>> from tribo import Grid
    >>> from tribo.surface import self_affine
    >>> grid = Grid((192, 192), (1e-6, 1e-6))
    >>> fit = fit_self_affine(self_affine(grid, 2e-7, 0.7, (4e-6, 12e-6), seed=1), grid.spacing)
    >>> f"{fit.hurst_exponent:.2f}"
    '0.65'
    """
    if min(heights.shape) < _FEWEST:
        raise InputError(
            f"{heights.shape[0]} × {heights.shape[1]} heights are too few for a spectrum; give at "
            f"least {_FEWEST} along each side"
        )
    start = np.array([*np.log(np.multiply(5, spacing)), 0.8])
    sides = zip(spacing, heights.shape, strict=True)
    bounds = [(np.log(step / 3), np.log(step * n)) for step, n in sides]
    best, misfit = _fit(_modes_of_map(heights, spacing), [start], bounds, _MODES)
    length_x, length_y = np.exp(best[:2]).tolist()
    return SelfAffineFit(float(best[2]), (length_x, length_y), misfit)


def fit_profiles(lines: Array, step: float, cutoff: float | None) -> SelfAffineFit:
    """Find the isotropic self-affine surface whose profiles fit measured ones best.

    Parameters
    ----------
    lines : ndarray, shape (n, n_profile)
        Heights of profiles [m], above their mean lines.
    step : float
        Distance of neighbouring heights [m].
    cutoff : float or None
        Nesting index λc [m] of the Gaussian filter that took the waviness off; None without it.

    Raises
    ------
    InputError
        If a profile has fewer than 64 heights, or repeats itself as a turned one does.

    Notes
    -----
    A profile across a self-affine surface has the spectrum (1 + (q l)²)^−(1/2+H), whatever the
    correlation length along the lay. The filter leaves (1 − 2^−(λc/λ)²)² of it.

    Examples
    --------
    >>> from tribo import Grid
    >>> from tribo.surface import self_affine
    >>> heights = self_affine(Grid((4096, 64), (5e-7, 5e-7)), 2e-7, 0.7, (4e-6, 4e-6), seed=1)
    >>> fit = fit_profiles(heights[:, ::16], 5e-7, None)
    >>> abs(fit.hurst_exponent - 0.7) < 0.1, abs(fit.correlation_length[0] / 4e-6 - 1) < 0.2
    (True, True)
    """
    if len(lines) < _FEWEST_OF_PROFILE:
        raise InputError(
            f"{len(lines)} heights are too few for a spectrum; give at least {_FEWEST_OF_PROFILE}"
        )
    modes = _modes_of_profiles(lines, step, cutoff)
    starts = [np.array([np.log(count * step), 0.8]) for count in (5, 50)]
    best, misfit = _fit(modes, starts, [np.log([step / 3, step * len(lines)])], _MODES_OF_PROFILE)
    ratio = modes.power / modes.spectrum(best)
    # Of exponentially distributed power; it is 0 where most of a profile is flat.
    ratio /= np.maximum(median_filter(ratio, _NEIGHBOURS), _FLAT) / np.log(2)
    if ratio.max() > _PEAK:
        highest = np.where(ratio > _PEAK, modes.power, 0.0).argmax()
        period = 2 * np.pi / float(modes.wavenumber[highest])
        raise InputError(f"it repeats every {display(period, 'µm', 3)}, as by turning")
    length = float(np.exp(best[0]))
    return SelfAffineFit(float(best[1]), (length, length), misfit)


def profile_spectrum(q: Array, length: float, hurst: float, cutoff: float | None) -> Array:
    """Spectrum of profiles across a self-affine surface at wavenumbers [1/m], up to a factor.

    `length` is the correlation length [m], and `cutoff` that of the filter [m]; None without it.
    """
    passed = 1.0 if cutoff is None else (1 - 0.5 ** (cutoff * q / (2 * np.pi)) ** 2) ** 2
    spectrum: Array = passed * (1 + (q * length) ** 2) ** -(0.5 + hurst)
    return spectrum


class _Modes(NamedTuple):
    """Modes of measured heights that are compared with a spectrum."""

    power: Array  # (n_mode,)
    wavenumber: Array  # (n_mode,) [1/m]
    spectrum: Callable[[Array], Array]  # (n_mode,), from ln(lengths [m]) and the Hurst exponent


def _fit(
    modes: _Modes, starts: Sequence[Array], bounds: list[Any], fewest: int
) -> tuple[Array, float]:
    """Best parameters of a spectrum from any start, and its largest factor off in a band."""
    from scipy.optimize import minimize

    power, q = modes.power / modes.power.mean(), modes.wavenumber

    def misfit(parameters: Array) -> float:
        spectrum = modes.spectrum(parameters)
        return float(q.size * (np.log(np.mean(power / spectrum)) + np.mean(np.log(spectrum))))

    limits = [*bounds, (0.02, 1.0)]
    found = [minimize(misfit, start, bounds=limits, method="L-BFGS-B") for start in starts]
    best = min(found, key=lambda one: one.fun).x
    ratio = power / modes.spectrum(best)
    bands = np.digitize(q, np.geomspace(q.min(), q.max(), _BANDS + 1)[1:-1])
    counts = np.bincount(bands)
    means = np.bincount(bands, ratio)[counts >= fewest] / counts[counts >= fewest]
    return best, float(np.exp(np.abs(np.log(means / ratio.mean())).max(initial=0.0)))


def _modes_of_map(heights: Array, spacing: tuple[float, float]) -> _Modes:
    """Modes of a map in half the wavenumber plane."""
    nx, ny = heights.shape
    window = np.outer(np.hanning(nx + 1)[:-1], np.hanning(ny + 1)[:-1])
    level = heights - np.average(heights, weights=window)
    q_x = (2 * np.pi * np.fft.fftfreq(nx, spacing[0])[:, None]).astype(np.float64)
    q_y = (2 * np.pi * np.fft.rfftfreq(ny, spacing[1])).astype(np.float64)
    ends = _SHORTEST * np.pi / np.array(spacing)
    is_compared = (np.abs(q_x) <= ends[0]) & (q_y <= ends[1])
    # Leave out mean and tilt, which are form, and the duplicates of modes with q_y = 0.
    is_compared &= (np.abs(q_x) > 1.5 * q_x[1]) | (q_y > 1.5 * q_y[1])
    is_compared[nx // 2 :, 0] = False

    def spectrum(parameters: Array) -> Array:
        length_x, length_y, hurst = np.exp(parameters[0]), np.exp(parameters[1]), parameters[2]
        whole = (1 + (q_x * length_x) ** 2 + (q_y * length_y) ** 2) ** -(1 + hurst)
        whole = (4 * whole + np.roll(whole, 1, 0) + np.roll(whole, -1, 0)) / 6  # Hann's window
        before = np.roll(whole, 1, 1)
        before[:, 0] = np.roll(whole[::-1, 1], 1)  # the mode at −q, in the half plane left out
        shown: Array = ((4 * whole + before + np.roll(whole, -1, 1)) / 6)[is_compared]
        return shown

    power = np.abs(np.fft.rfft2(level * window)) ** 2
    return _Modes(power[is_compared], np.hypot(q_x, q_y)[is_compared], spectrum)


def _modes_of_profiles(lines: Array, step: float, cutoff: float | None) -> _Modes:
    """Modes of profiles, whose power is the mean over the profiles."""
    window = np.hanning(len(lines) + 1)[:-1]
    level = lines - np.average(lines, axis=0, weights=window)
    q = (2 * np.pi * np.fft.rfftfreq(len(lines), step)).astype(np.float64)
    is_compared = (q > 1.5 * q[1]) & (q <= _SHORTEST * np.pi / step)

    def spectrum(parameters: Array) -> Array:
        whole = profile_spectrum(q, np.exp(parameters[0]), parameters[1], cutoff)
        whole = (4 * whole + np.roll(whole, 1) + np.roll(whole, -1)) / 6  # Hann's window
        shown: Array = whole[is_compared]
        return shown

    power = (np.abs(np.fft.rfft(level * window[:, None], axis=0)) ** 2).mean(axis=1)
    return _Modes(power[is_compared], q[is_compared], spectrum)
