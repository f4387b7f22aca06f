"""Lengths over which the heights of a surface lose their correlation, in all directions."""

from __future__ import annotations

import math

import numpy as np

from tribo.errors import require_positive
from tribo.types import Array

_DIRECTIONS = 90  # directions over half a turn in which lengths are found
_FALLEN = 1 / math.e  # value of the autocorrelation at the end of a length
_MOST_LAGS = 16  # lags for each height along a side, at most, if pixels are much longer than wide
_FARTHEST = 0.5  # share of a side beyond which lags have too few pairs of heights


def autocorrelation_lengths(
    heights: Array, spacing: tuple[float, float]
) -> tuple[float, float, float]:
    """Find the shortest and the longest distance at which the autocorrelation falls to 1/e.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights above their form [m], NaN where a height is missing.
    spacing : tuple of float
        Sides of a pixel along x and y [m].

    Returns
    -------
    tuple of float
        The shortest and the longest distance [m], infinite if the autocorrelation stays above 1/e
        over half the side; and the direction of the longest distance, from x towards y, from −90 to
        90 [°].

    Raises
    ------
    InputError
        If all heights are missing, or are equal.

    Notes
    -----
    The surface need not be periodic: for each lag the mean is over the pairs of heights at this
    lag.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(400.0), np.arange(400.0), indexing="ij")
    >>> shortest, longest, _ = autocorrelation_lengths(np.cos(2 * np.pi * x / 40), (1e-6, 1e-6))
    >>> f"{1e6 * shortest:.1f} µm along x, {longest} along y"
    '7.5 µm along x, inf along y'
    """
    from scipy.ndimage import map_coordinates

    measured = np.isfinite(heights)
    require_positive(rms_height=float(heights[measured].std()) if measured.any() else 0.0)
    level = np.where(measured, heights - heights[measured].mean(), 0.0)
    correlation, origin = _autocorrelation(level, measured)
    angles = np.pi * np.arange(1 - _DIRECTIONS // 2, _DIRECTIONS // 2 + 1) / _DIRECTIONS
    steps = np.stack([np.cos(angles) / spacing[0], np.sin(angles) / spacing[1]])  # pixels a metre
    ends = (_FARTHEST * np.array(heights.shape)[:, None]) / np.maximum(np.abs(steps), 1e-30)
    lengths, most = np.full(_DIRECTIONS, np.inf), _MOST_LAGS * max(heights.shape)
    for number, (step, end) in enumerate(zip(steps.T, ends.min(axis=0), strict=True)):
        lags = np.arange(0.0, end, max(min(spacing) / 2, end / most))
        values = map_coordinates(correlation, origin[:, None] + np.outer(step, lags), order=1)
        below = np.flatnonzero(values < _FALLEN)
        if len(below):
            k = below[0]
            part = (values[k - 1] - _FALLEN) / (values[k - 1] - values[k])
            lengths[number] = lags[k - 1] + part * (lags[k] - lags[k - 1])
    # The mean direction, as an infinite length may lie along several directions.
    slowest = np.exp(2j * angles[lengths == lengths.max()]).mean()
    return float(lengths.min()), float(lengths.max()), float(np.degrees(np.angle(slowest) / 2))


def _autocorrelation(heights: Array, measured: Array) -> tuple[Array, Array]:
    """Autocorrelation, 1 at lag 0, over lags up to half a side; and the index of lag 0."""
    reach = [n // 2 + 1 for n in heights.shape]
    kept = [np.arange(-far, far + 1) for far in reach]
    pairs = np.outer(*(n - np.abs(lag) for n, lag in zip(heights.shape, kept, strict=True)))
    if not measured.all():  # heights that are missing are 0 here, and left out of the means
        pairs = _lag_sums(measured.astype(float))[np.ix_(*kept)]
    correlation: Array = _lag_sums(heights)[np.ix_(*kept)] / np.maximum(pairs, 1.0)
    origin = np.array(reach)
    return correlation / correlation[tuple(origin)], origin


def _lag_sums(values: Array) -> Array:
    """Sum over all (i, j) of values[i, j] · values[i + k, j + l] at index [k, l] of the result."""
    shape, axes = [2 * n for n in values.shape], (0, 1)  # with zeros around, as not periodic
    result: Array = np.fft.irfft2(np.abs(np.fft.rfft2(values, shape, axes)) ** 2, shape, axes)
    return result
