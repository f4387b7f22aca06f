"""Fit a self-affine random surface to a map of heights.

The spectrum of `tribo.surface.self_affine` is fitted to the periodogram of the heights by Whittle's
likelihood: on a random surface, each mode of the periodogram is exponentially distributed about the
spectrum. A Hann window prevents leakage from the edges of a surface that is not periodic. Before
the comparison the spectrum is smoothed by that window, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tribo.errors import InputError
from tribo.types import Array

_MIN_SIDE = 16  # least number of heights along each side
_RESOLVED_SHARE = (
    0.5  # share of the Nyquist wavenumber up to which instruments resolve the spectrum
)
_BANDS, _MIN_MODES = 6, 20  # bands of wavelength compared, and the least number of modes in one


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
        Largest factor between the fitted spectrum and the heights' in any band of wavelength; NaN
        if there are too few heights to compare bands.
    """

    hurst_exponent: float
    correlation_length: tuple[float, float]
    misfit: float


def fit_self_affine(heights: Array, spacing: tuple[float, float]) -> SelfAffineFit:
    """Find the self-affine surface whose spectrum fits the heights best.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights above their form, without gaps [m].
    spacing : tuple of float
        Sides of a pixel along x and y [m].

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
    from scipy.optimize import minimize

    if min(heights.shape) < _MIN_SIDE:
        raise InputError(
            f"{heights.shape[0]} × {heights.shape[1]} heights are too few for a spectrum; give at "
            f"least {_MIN_SIDE} along each side"
        )
    power, q_x, q_y, is_compared = _periodogram(heights, spacing)
    power = power[is_compared] / power[is_compared].mean()
    q = np.hypot(q_x, q_y)[is_compared]

    def spectrum(parameters: Array) -> Array:
        length_x, length_y, hurst = np.exp(parameters[0]), np.exp(parameters[1]), parameters[2]
        density = (1 + (q_x * length_x) ** 2 + (q_y * length_y) ** 2) ** -(1 + hurst)
        density = (
            4 * density + np.roll(density, 1, 0) + np.roll(density, -1, 0)
        ) / 6  # Hann's window
        lower_mode = np.roll(density, 1, 1)
        lower_mode[:, 0] = np.roll(
            density[::-1, 1], 1
        )  # the mode at −q, in the half plane left out
        density = (4 * density + lower_mode + np.roll(density, -1, 1)) / 6
        compared_density: Array = density[is_compared]
        return compared_density

    def misfit(parameters: Array) -> float:
        model = spectrum(parameters)
        return float(q.size * (np.log(np.mean(power / model)) + np.mean(np.log(model))))

    sides = zip(spacing, heights.shape, strict=True)
    bounds = [*((np.log(step / 3), np.log(step * n)) for step, n in sides), (0.02, 1.0)]
    start = np.array([*np.log(np.multiply(5, spacing)), 0.8])
    best = minimize(misfit, start, bounds=bounds, method="L-BFGS-B").x
    ratio = power / spectrum(best)
    bands = np.digitize(q, np.geomspace(q.min(), q.max(), _BANDS + 1)[1:-1])
    counts = np.bincount(bands)
    means = np.bincount(bands, ratio)[counts >= _MIN_MODES] / counts[counts >= _MIN_MODES]
    factor = float(np.exp(np.abs(np.log(means / ratio.mean())).max(initial=0.0)))
    factor = factor if means.size > 1 else np.nan
    length_x, length_y = np.exp(best[:2]).tolist()
    return SelfAffineFit(float(best[2]), (length_x, length_y), factor)


def _periodogram(heights: Array, spacing: tuple[float, float]) -> tuple[Array, ...]:
    """Power in half the plane of wavenumbers, the wavenumbers, and which modes are compared."""
    nx, ny = heights.shape
    window = np.outer(np.hanning(nx + 1)[:-1], np.hanning(ny + 1)[:-1])
    level = heights - np.average(heights, weights=window)
    q_x = (2 * np.pi * np.fft.fftfreq(nx, spacing[0])[:, None]).astype(np.float64)
    q_y = (2 * np.pi * np.fft.rfftfreq(ny, spacing[1])).astype(np.float64)
    limits = _RESOLVED_SHARE * np.pi / np.array(spacing)
    is_compared = (np.abs(q_x) <= limits[0]) & (q_y <= limits[1])
    # Leave out mean and tilt, which are form, and the duplicates of modes with q_y = 0.
    is_compared &= (np.abs(q_x) > 1.5 * q_x[1]) | (q_y > 1.5 * q_y[1])
    is_compared[nx // 2 :, 0] = False
    return np.abs(np.fft.rfft2(level * window)) ** 2, q_x, q_y, is_compared
