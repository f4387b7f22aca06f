"""Roughness and lay of a map of heights above its form: a plane or a curved surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tribo.errors import InputError, require_positive
from tribo.types import Array

_LAY_ASPECT = 0.5  # Str, below which a surface has a lay
_MAX_SIDE = 1500  # side of the central part used for the autocorrelation, in heights
_ROUNDING = 1e-9  # smaller deviations from the plane, relative to the heights, are rounding
_DIRECTIONS = 90  # number of directions over half a turn
_DECAY_LEVEL = 0.2  # value of the autocorrelation at the end of a length, as in ISO 25178-3
_MAX_LAGS_PER_HEIGHT = 16  # lags per height along a side, for pixels much longer than wide
_MAX_LAG_SHARE = 0.5  # longest lag over the side; longer lags have too few pairs of heights


@dataclass(frozen=True, slots=True)
class ArealRoughness:
    """Roughness of an area, measured from its form.

    Attributes
    ----------
    sa, sq : float
        Average and root mean square distance from the form [m], Sa and Sq of ISO 25178-2.
    aspect : float
        Str, the shortest distance over which the autocorrelation falls to 0.2 divided by the
        longest; 0 if the longest is beyond half the side, NaN if the shortest is.
    lay : float or None
        Direction of the lay, from x towards y, from −90 to 90 [°]; None without a lay.
    mean : float
        Mean height [m].
    slopes : tuple of float
        Slopes of the form along x and y in the middle.
    radii : tuple of float
        Radii of curvature along x and y [m], positive for a hill; infinite where the curvature is
        small compared with the roughness.
    """

    sa: float
    sq: float
    aspect: float
    lay: float | None
    mean: float
    slopes: tuple[float, float]
    radii: tuple[float, float]


def areal_roughness(
    heights: Array, spacing: tuple[float, float], with_lay: bool = True
) -> ArealRoughness:
    """Compute the roughness and the lay of a map of heights.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights [m], NaN where a height is missing.
    spacing : tuple of float
        Sides of a pixel along x and y [m].
    with_lay : bool, optional
        False to leave out Str and the lay, which take most of the time; they are NaN and None.

    Raises
    ------
    InputError
        If all heights are missing, or there is no roughness in addition to the form.

    Examples
    --------
    >>> from tribo import Grid
    >>> from tribo.surface import self_affine
    >>> grid = Grid((192, 192), (1e-6, 1e-6))
    >>> heights = self_affine(grid, 2e-7, 0.8, (3e-6, 12e-6), seed=1)
    >>> areal = areal_roughness(heights, grid.spacing)
    >>> f"Sa {1e6 * areal.sa:.3f} µm, Str {areal.aspect:.2f}, lay at {areal.lay:.0f}°"
    'Sa 0.199 µm, Str 0.22, lay at 90°'
    """
    level, slopes, radii = remove_form(heights, spacing)
    values = level[np.isfinite(level)]
    values = values - values.mean()
    aspect = direction = math.nan
    if with_lay:
        starts = [max(0, (n - _MAX_SIDE) // 2) for n in level.shape]
        centre = level[tuple(slice(start, start + _MAX_SIDE) for start in starts)]
        shortest, longest, direction = autocorrelation_lengths(centre, spacing)
        aspect = shortest / longest if math.isfinite(shortest) else math.nan
    return ArealRoughness(
        sa=float(np.abs(values).mean()),
        sq=float(np.sqrt(np.mean(values**2))),
        aspect=aspect,
        lay=direction if aspect < _LAY_ASPECT else None,
        mean=float(np.nanmean(heights)),
        slopes=slopes,
        radii=radii,
    )


def remove_form(
    heights: Array, spacing: tuple[float, float]
) -> tuple[Array, tuple[float, float], tuple[float, float]]:
    """Remove the mean plane of a surface, and its curvature if this is significant.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights [m], NaN where a height is missing.
    spacing : tuple of float
        Sides of a pixel along x and y [m].

    Returns
    -------
    ndarray, shape (nx, ny)
        Heights above the fitted plane or curved surface; NaN stays NaN.
    tuple of float
        Slopes of the form along x and y in the middle.
    tuple of float
        Radii of curvature along x and y [m], positive for a hill; infinite along an axis if the
        curvature there is not significant.

    Notes
    -----
    The form is z = z₀ + a x + b y − x²/(2 Rx) + c xy − y²/(2 Ry), with constants z₀, a, b, c and
    radii Rx, Ry fitted to the heights. The curvature along an axis is significant if it raises or
    lowers the form by more than the roughness Sq from the middle to an edge. If neither axis has a
    significant curvature, only the plane z₀ + a x + b y is removed. A curvature along one axis that
    is left raises Sq by at most 4 %.

    Examples
    --------
    >>> x = np.linspace(-1e-3, 1e-3, 101)[:, None] * np.ones(50)
    >>> rough = 1e-7 * np.random.default_rng(1).standard_normal(x.shape)
    >>> _, _, radii = remove_form(rough - x**2 / (2 * 0.06), (2e-5, 2e-5))
    >>> f"{1e3 * radii[0]:.1f} mm along x, {radii[1]} along y"
    '59.9 mm along x, inf along y'
    """
    measured = np.isfinite(heights)
    if not measured.any():
        raise InputError("all heights are missing")
    halves = [max((n - 1) / 2, 0.5) * step for n, step in zip(heights.shape, spacing, strict=True)]
    x, y = (np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1) for n in heights.shape)
    u, v = np.broadcast_arrays(x[:, None], y[None, :])
    terms = np.stack([np.ones(u.shape), u, v, u * u, u * v, v * v], axis=-1)

    def subtract_fit(count: int) -> tuple[Array, Array]:
        factors, *_ = np.linalg.lstsq(terms[..., :count][measured], heights[measured], rcond=None)
        return heights - terms[..., :count] @ factors, factors

    level, plane = subtract_fit(3)
    radii = [math.inf, math.inf]
    curved, factors = subtract_fit(6)
    sq = float(np.nanstd(curved))
    if max(abs(factors[3]), abs(factors[5])) > sq > 0:
        level, plane = curved, factors
        radii = [
            -(half**2) / (2 * sag) if abs(sag) > sq else math.inf
            for half, sag in zip(halves, factors[[3, 5]].tolist(), strict=True)
        ]
    if float(np.nanstd(level)) <= _ROUNDING * float(np.nanmax(np.abs(heights))):
        raise InputError("the heights form a plane without roughness; use another file")
    slope_x, slope_y = (plane[k] / half for k, half in zip((1, 2), halves, strict=True))
    return level, (float(slope_x), float(slope_y)), (radii[0], radii[1])


def autocorrelation_lengths(
    heights: Array, spacing: tuple[float, float]
) -> tuple[float, float, float]:
    """Shortest and longest distance at which the autocorrelation falls to 0.2.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights above their form [m], NaN where a height is missing.
    spacing : tuple of float
        Sides of a pixel along x and y [m].

    Returns
    -------
    tuple of float
        The shortest and the longest distance [m], infinite if the autocorrelation stays above 0.2
        over half the side; and the direction of the longest distance, from x towards y, from −90 to
        90 [°].

    Notes
    -----
    The surface need not be periodic: for each lag the mean is over the pairs of heights at this
    lag.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(400.0), np.arange(400.0), indexing="ij")
    >>> shortest, longest, _ = autocorrelation_lengths(np.cos(2 * np.pi * x / 40), (1e-6, 1e-6))
    >>> f"{1e6 * shortest:.1f} µm along x, {longest} along y"
    '8.6 µm along x, inf along y'
    """
    from scipy.ndimage import map_coordinates

    measured = np.isfinite(heights)
    require_positive(rms_height=float(heights[measured].std()) if measured.any() else 0.0)
    level = np.where(measured, heights - heights[measured].mean(), 0.0)
    correlation, origin = _autocorrelation(level, measured)
    angles = np.pi * np.arange(1 - _DIRECTIONS // 2, _DIRECTIONS // 2 + 1) / _DIRECTIONS
    directions = np.stack([np.cos(angles) / spacing[0], np.sin(angles) / spacing[1]])  # [pixels/m]
    limits = (_MAX_LAG_SHARE * np.array(heights.shape)[:, None]) / np.maximum(
        np.abs(directions), 1e-30
    )
    lengths, max_count = np.full(_DIRECTIONS, np.inf), _MAX_LAGS_PER_HEIGHT * max(heights.shape)
    for index, (direction, limit) in enumerate(zip(directions.T, limits.min(axis=0), strict=True)):
        lags = np.arange(0.0, limit, max(min(spacing) / 2, limit / max_count))
        values = map_coordinates(correlation, origin[:, None] + np.outer(direction, lags), order=1)
        below = np.flatnonzero(values < _DECAY_LEVEL)
        if len(below):
            k = below[0]
            fraction = (values[k - 1] - _DECAY_LEVEL) / (values[k - 1] - values[k])
            lengths[index] = lags[k - 1] + fraction * (lags[k] - lags[k - 1])
    # The mean direction, since several directions may have an infinite length.
    mean_phasor = np.exp(2j * angles[lengths == lengths.max()]).mean()
    return float(lengths.min()), float(lengths.max()), float(np.degrees(np.angle(mean_phasor) / 2))


def _autocorrelation(heights: Array, measured: Array) -> tuple[Array, Array]:
    """Autocorrelation, 1 at lag 0, over lags up to half a side; and the index of lag 0."""
    max_lags = [n // 2 + 1 for n in heights.shape]
    lags = [np.arange(-max_lag, max_lag + 1) for max_lag in max_lags]
    pairs = np.outer(*(n - np.abs(lag) for n, lag in zip(heights.shape, lags, strict=True)))
    if not measured.all():  # missing heights are 0 here, and excluded from the means
        pairs = _lag_sums(measured.astype(float))[np.ix_(*lags)]
    correlation: Array = _lag_sums(heights)[np.ix_(*lags)] / np.maximum(pairs, 1.0)
    origin = np.array(max_lags)
    return correlation / correlation[tuple(origin)], origin


def _lag_sums(values: Array) -> Array:
    """Sum over all (i, j) of values[i, j] · values[i + k, j + l] at index [k, l] of the result."""
    # Zero-padded, since the surface is not periodic.
    shape, axes = [2 * n for n in values.shape], (0, 1)
    result: Array = np.fft.irfft2(np.abs(np.fft.rfft2(values, shape, axes)) ** 2, shape, axes)
    return result
