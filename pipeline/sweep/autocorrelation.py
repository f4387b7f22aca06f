"""Lengths over which the heights of a surface lose their correlation, in all directions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.sweep.shown import shown
from tribo.errors import require_positive
from tribo.types import Array

_DIRECTIONS = 90  # over half a turn, in which the autocorrelation falls
_FARTHEST = 0.5  # share of a side beyond which lags have too few pairs of heights


@shown
@dataclass(frozen=True, slots=True)
class AutocorrelationLengths:
    """Distances at which the autocorrelation of heights falls to a threshold.

    Each is infinite where the autocorrelation stays above it over half the side of the surface.

    Attributes
    ----------
    along_x, along_y : float
        Distances along x and along y [m].
    shortest, longest : float
        In the directions of fastest and of slowest fall [m]; the shortest is Sal of ISO 25178-2.
    direction : float
        Direction of slowest fall, from x towards y, from −90 to 90 [°].
    """

    along_x: float
    along_y: float
    shortest: float
    longest: float
    direction: float

    @property
    def texture_aspect(self) -> float:
        """Str of ISO 25178-2, the shortest over the longest; 0 if that is infinite, NaN of both."""
        return self.shortest / self.longest if math.isfinite(self.shortest) else math.nan


def autocorrelation_lengths(
    heights: Array, spacing: tuple[float, float], threshold: float = 1 / math.e
) -> AutocorrelationLengths:
    """Find the distances at which the autocorrelation of heights falls to a threshold.

    Parameters
    ----------
    heights : ndarray, shape (nx, ny)
        Heights above their form, NaN where there is none [m].
    spacing : tuple of float
        Sides of a pixel along x and y [m].
    threshold : float
        Part of its value without a lag, above 0 and below 1. ISO 25178-3 has 0.2 as default.

    Notes
    -----
    The surface is not taken to repeat itself: each lag has the mean over its own pairs of heights.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(400.0), np.arange(400.0), indexing="ij")
    >>> waves = autocorrelation_lengths(np.cos(2 * np.pi * x / 40), (1e-6, 1e-6))
    >>> f"{1e6 * waves.along_x:.1f} µm along x, {waves.along_y} along y"
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
    lengths = np.full(_DIRECTIONS, np.inf)
    for number, (step, end) in enumerate(zip(steps.T, ends.min(axis=0), strict=True)):
        lags = np.arange(0.0, end, min(spacing) / 2)
        values = map_coordinates(correlation, origin[:, None] + np.outer(step, lags), order=1)
        below = np.flatnonzero(values < threshold)
        if len(below):
            k = below[0]
            part = (values[k - 1] - threshold) / (values[k - 1] - values[k])
            lengths[number] = lags[k - 1] + part * (lags[k] - lags[k - 1])
    slowest = np.exp(2j * angles[lengths == lengths.max()]).mean()  # several if it is infinite
    return AutocorrelationLengths(
        along_x=float(lengths[_DIRECTIONS // 2 - 1]),
        along_y=float(lengths[-1]),
        shortest=float(lengths.min()),
        longest=float(lengths.max()),
        direction=float(np.degrees(np.angle(slowest) / 2)),
    )


def _autocorrelation(heights: Array, measured: Array) -> tuple[Array, Array]:
    """Autocorrelation up to half a side, 1 without a lag; and the index of that.

    Heights that are not measured are 0, and make no pair.
    """
    reach = [n // 2 + 1 for n in heights.shape]
    kept = [np.arange(-far, far + 1) for far in reach]
    pairs = np.outer(*(n - np.abs(lag) for n, lag in zip(heights.shape, kept, strict=True)))
    if not measured.all():
        pairs = _lagged(measured.astype(float))[np.ix_(*kept)]
    correlation: Array = _lagged(heights)[np.ix_(*kept)] / np.maximum(pairs, 1.0)
    origin = np.array(reach)
    return correlation / correlation[tuple(origin)], origin


def _lagged(values: Array) -> Array:
    """Sum over an area of the products of values at each lag."""
    shape, axes = [2 * n for n in values.shape], (0, 1)
    result: Array = np.fft.irfft2(np.abs(np.fft.rfft2(values, shape, axes)) ** 2, shape, axes)
    return result
