"""The random surface that fits a map of heights, or the Ra and RSm of a data sheet.

The spectrum of `tribo.surface.self_affine` is fitted to the periodogram of the heights by Whittle's
likelihood: on a random surface, each mode of the periodogram is exponentially distributed about the
spectrum. A Hann window prevents leakage from the edges of a surface that is not periodic. Before
the comparison the spectrum is smoothed by that window, too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize

from pipeline.quantities import display
from tribo import Grid, InputError
from tribo.surface import self_affine
from tribo.types import Array

_DATA_SHEET_HURST = 0.8  # Hurst exponent, which no data sheet has
_DATA_SHEET_PIXELS = 512  # along a side of the surfaces whose profiles have the RSm


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
    min_side = 16
    if min(heights.shape) < min_side:
        raise InputError(
            f"{heights.shape[0]} × {heights.shape[1]} heights are too few for a spectrum; give at "
            f"least {min_side} along each side"
        )
    power, q_x, q_y, is_compared = _periodogram(heights, spacing)
    power = power[is_compared] / power[is_compared].mean()
    modes = q_x, q_y, is_compared
    sides = zip(spacing, heights.shape, strict=True)
    bounds = [*((np.log(step / 3), np.log(step * count)) for step, count in sides), (0.02, 1.0)]
    start = np.array([*np.log(np.multiply(5, spacing)), 0.8])
    fit = minimize(_deviance, start, (power, *modes), bounds=bounds, method="L-BFGS-B")
    length_x, length_y = np.exp(fit.x[:2]).tolist()
    misfit = _band_misfit(power / _spectrum(fit.x, *modes), np.hypot(q_x, q_y)[is_compared])
    return SelfAffineFit(float(fit.x[2]), (length_x, length_y), misfit)


def _periodogram(heights: Array, spacing: tuple[float, float]) -> tuple[Array, Array, Array, Array]:
    """Power in half the plane of wavenumbers, the wavenumbers, and which modes are compared."""
    nx, ny = heights.shape
    window = np.outer(np.hanning(nx + 1)[:-1], np.hanning(ny + 1)[:-1])
    level = heights - np.average(heights, weights=window)
    q_x = (2 * np.pi * np.fft.fftfreq(nx, spacing[0])[:, None]).astype(np.float64)
    q_y = (2 * np.pi * np.fft.rfftfreq(ny, spacing[1])).astype(np.float64)
    # Instruments resolve the spectrum up to about half the Nyquist wavenumber.
    max_q_x, max_q_y = 0.5 * np.pi / np.array(spacing)
    is_compared = (np.abs(q_x) <= max_q_x) & (q_y <= max_q_y)
    # Leave out mean and tilt, which are form, and the duplicates of modes with q_y = 0.
    is_compared &= (np.abs(q_x) > 1.5 * q_x[1]) | (q_y > 1.5 * q_y[1])
    is_compared[nx // 2 :, 0] = False
    return np.abs(np.fft.rfft2(level * window)) ** 2, q_x, q_y, is_compared


def _deviance(parameters: Array, power: Array, q_x: Array, q_y: Array, is_compared: Array) -> float:
    """Sum of ln S + P/S over the compared modes, at the best amplitude of the spectrum S."""
    spectrum = _spectrum(parameters, q_x, q_y, is_compared)
    return float(power.size * (np.log(np.mean(power / spectrum)) + np.mean(np.log(spectrum))))


def _spectrum(parameters: Array, q_x: Array, q_y: Array, is_compared: Array) -> Array:
    """Spectrum of the compared modes, smoothed by Hann's window, in any unit.

    `parameters` are ln of the correlation lengths along x and y [m], and the Hurst exponent.
    """
    length_x, length_y, hurst = np.exp(parameters[0]), np.exp(parameters[1]), parameters[2]
    density = (1 + (q_x * length_x) ** 2 + (q_y * length_y) ** 2) ** -(1 + hurst)
    density = (4 * density + np.roll(density, 1, 0) + np.roll(density, -1, 0)) / 6
    lower_mode = np.roll(density, 1, 1)
    lower_mode[:, 0] = np.roll(density[::-1, 1], 1)  # the mode at −q, in the other half plane
    density = (4 * density + lower_mode + np.roll(density, -1, 1)) / 6
    compared_density: Array = density[is_compared]
    return compared_density


def _band_misfit(ratio: Array, wavenumber: Array) -> float:
    """Largest factor between the mean of `ratio` and that in any of six bands of wavenumbers."""
    limits = np.geomspace(wavenumber.min(), wavenumber.max(), 7)[1:-1]
    bands = np.digitize(wavenumber, limits)
    counts = np.bincount(bands)
    has_enough = counts >= 20
    band_means = np.bincount(bands, ratio)[has_enough] / counts[has_enough]
    if band_means.size < 2:
        return math.nan
    return float(np.exp(np.abs(np.log(band_means / ratio.mean())).max()))


def data_sheet_toml(ra: float, rsm: float, pixel: float) -> tuple[str, list[str]]:
    """Roughness of a scene's disk, for random surfaces with Ra and RSm [m], and the assumptions.

    RSm is that of profiles of random surfaces in pixels [m].
    """
    length = correlation_length(ra, rsm, pixel)
    return roughness_toml(ra, _DATA_SHEET_HURST, (length, length)), [
        f"assumed: Hurst exponent {_DATA_SHEET_HURST}",
        "assumed: isotropic, without a lay",
        f"assumed: RSm is that of profiles of random surfaces in pixels of "
        f"{display(pixel, 'µm', 3)}",
    ]


def correlation_length(ra: float, rsm: float, pixel: float) -> float:
    """Correlation length [m] of random surfaces with Ra and RSm [m], in pixels [m].

    Raises an `InputError` if profiles in such pixels cannot have this RSm.
    """
    min_length, max_length = 0.3 * pixel, _DATA_SHEET_PIXELS * pixel / 12
    min_rsm, max_rsm = (_mean_rsm(length, ra, pixel) for length in (min_length, max_length))
    if not min_rsm < rsm < max_rsm:
        raise InputError(
            f"RSm is {display(rsm, 'µm', 3)}; with pixels of {display(pixel, 'µm', 3)} profiles of "
            f"random surfaces have {display(min_rsm, 'µm', 3)} to {display(max_rsm, 'µm', 3)}; "
            f"give {'smaller' if rsm < min_rsm else 'larger'} pixels, --pixel-size"
        )
    log_length = brentq(
        lambda log_length: math.log(_mean_rsm(math.exp(log_length), ra, pixel) / rsm),
        math.log(min_length),
        math.log(max_length),
        xtol=0.01,
    )
    return math.exp(float(log_length))


def _mean_rsm(length: float, ra: float, pixel: float) -> float:
    """Mean RSm [m] of profiles of four random surfaces with a correlation length [m]."""
    grid = Grid((_DATA_SHEET_PIXELS, _DATA_SHEET_PIXELS), (pixel, pixel))
    spacings = list[float]()
    for seed in range(4):
        heights = self_affine(grid, ra, _DATA_SHEET_HURST, (length, length), seed=seed)
        for profile in heights.T[::16]:
            rz = float(np.mean([np.ptp(section) for section in np.array_split(profile, 5)]))
            # Without two elements, the spacing is at least the length of the profile.
            spacings.append(mean_spacing(profile, pixel, 0.1 * rz) or _DATA_SHEET_PIXELS * pixel)
    return float(np.mean(spacings))


def mean_spacing(profile: Array, step: float, min_height: float) -> float | None:
    """RSm [m]: mean spacing of profile elements with a peak and a valley of at least `min_height`.

    None for fewer than two elements.

    Examples
    --------
    >>> x = np.arange(4000) * 0.5e-6
    >>> f"{1e6 * mean_spacing(np.sin(2 * np.pi * x / 60e-6), 0.5e-6, 0.2):.2f} µm"
    '60.00 µm'
    """
    side = np.where(profile > min_height, 1, np.where(profile < -min_height, -1, 0))
    high_or_low = np.flatnonzero(side)
    if high_or_low.size < 2:
        return None
    rises, falls = list[float](), list[float]()
    for k in np.flatnonzero(np.diff(side[high_or_low])):
        before, after = high_or_low[k], high_or_low[k + 1]
        sign_changes = np.flatnonzero(np.diff(np.signbit(profile[before : after + 1])))
        last = before + int(sign_changes[-1])
        crossing = float(last + profile[last] / (profile[last] - profile[last + 1]))
        (rises if side[after] > 0 else falls).append(crossing)
    crossings = [positions for positions in (falls, rises) if len(positions) > 1]
    if not crossings:
        return None
    total_length = sum(positions[-1] - positions[0] for positions in crossings)
    return step * total_length / sum(len(positions) - 1 for positions in crossings)


def roughness_toml(ra: float, hurst_exponent: float, lengths: tuple[float, float]) -> str:
    """Roughness of a scene's disk for random surfaces, as in new scenes; `ra`, `lengths` in m.

    Nearly equal correlation lengths along x and y become their geometric mean.
    """
    x, y = (f'"{display(length, "um", 3)}"' for length in average_if_close(lengths))
    length = x if x == y else f"[{x}, {y}]"
    return (
        f'disk = {{ roughness = {{ ra = "{display(ra, "um", 4)}", '
        f"hurst_exponent = {hurst_exponent:.3g}, correlation_length = {length} }} }}\n"
    )


def average_if_close(lengths: tuple[float, float]) -> tuple[float, float]:
    """Lengths along x and y; both their geometric mean if they differ by less than 15 %."""
    x, y = lengths
    mean = math.sqrt(x * y)
    return (x, y) if abs(x - y) > 0.15 * mean else (mean, mean)
