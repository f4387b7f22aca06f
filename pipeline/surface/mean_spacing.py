"""Correlation lengths of random surfaces by the mean spacing RSm of their profiles.

RSm is counted as in ISO 4287, on profiles that are sampled in the pixels of the window, without a
filter for waviness: an element has a peak and a valley of at least 10 % of Rz.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from pipeline.quantities import display, in_unit
from tribo import Grid, InputError
from tribo.surface import self_affine
from tribo.types import Array

_PIXELS = 512  # along a side of the surfaces whose profiles have the RSm
_SURFACES = 4
_PROFILE_DISTANCE, _DISTANCE_ON_LAY = 16, 4  # pixels from one profile to the next
_TOLERANCE = 0.01  # of a length; the mean RSm of these profiles scatters by as much
_LENGTHS = 0.3, _PIXELS / 12  # shortest and longest correlation length in pixels
Pair = tuple[float, float]
"""Values along x and y."""


@functools.cache
def correlation_lengths(rsm: float | Pair, hurst_exponent: float, pixel_size: Pair) -> Pair:
    """Correlation lengths [m] along x and y of random surfaces whose profiles have an RSm [m].

    A single RSm is that of a surface without a lay, in square pixels of the longer side. With two,
    along x and y, profiles along an axis depend on both lengths, since a surface varies less along
    its grooves. Lengths are rounded to four digits.

    Raises
    ------
    InputError
        If profiles in pixels of these sides [m] cannot have the RSm.

    Examples
    --------
    >>> x, y = correlation_lengths(30e-6, 0.8, (0.8e-6, 0.95e-6))
    >>> f"{1e6 * x:.1f} µm", x == y
    ('4.2 µm', True)
    """
    if not isinstance(rsm, tuple):
        pixel = max(pixel_size)
        length = _fitted_length(rsm, 0, None, hurst_exponent, (pixel, pixel))
        return length, length
    x = rsm[0] / 7  # near enough to begin with
    for _ in range(2):
        y = _fitted_length(rsm[1], 1, x, hurst_exponent, pixel_size)
        x = _fitted_length(rsm[0], 0, y, hurst_exponent, pixel_size)
    return x, y


def _fitted_length(
    rsm: float, axis: int, other_length: float | None, hurst_exponent: float, pixel_size: Pair
) -> float:
    """Correlation length [m] along an axis whose profiles have an RSm [m].

    `other_length` [m] is that along the other axis; None if both are equal.
    """
    from scipy.optimize import brentq  # which a scene without RSm does without

    def log_ratio(log_length: float) -> float:
        length = math.exp(log_length)
        other = other_length or length
        distance = _DISTANCE_ON_LAY if other_length else _PROFILE_DISTANCE
        lengths = (length, other) if axis == 0 else (other, length)
        mean_rsm = _mean_rsm(lengths, axis, hurst_exponent, pixel_size, distance)
        return math.log(mean_rsm / rsm)

    pixel = pixel_size[axis]
    ends = [math.log(factor * pixel) for factor in _LENGTHS]
    at_ends = [log_ratio(end) for end in ends]
    if not at_ends[0] <= 0 <= at_ends[1]:
        low, high = (in_unit(rsm * math.exp(ratio), "µm") for ratio in at_ends)
        raise InputError(
            f"rsm is {display(rsm, 'µm', 4)}, but random surfaces in pixels of "
            f"{display(pixel, 'µm', 4)} have {low:.3g} to {high:.3g} µm; change "
            "window.pixel_size, or give correlation_length instead"
        )
    return float(f"{math.exp(brentq(log_ratio, *ends, xtol=_TOLERANCE)):.4g}")


def _mean_rsm(
    lengths: Pair, axis: int, hurst_exponent: float, pixel_size: Pair, profile_distance: int
) -> float:
    """Mean RSm [m] along an axis of random surfaces with correlation lengths along x and y [m]."""
    grid, pixel = Grid((_PIXELS, _PIXELS), pixel_size), pixel_size[axis]
    spacings = list[float]()
    for seed in range(_SURFACES):
        heights = self_affine(grid, pixel, hurst_exponent, lengths, seed)
        profiles = (heights.T if axis == 0 else heights)[::profile_distance]
        sections = np.array_split(profiles, 5, axis=1)
        rz = np.mean([np.ptp(section, axis=1) for section in sections], axis=0)
        # Without two elements, the spacing is at least the length of the profile.
        spacings += [
            mean_spacing(profile, pixel, min_height) or _PIXELS * pixel
            for profile, min_height in zip(profiles, 0.1 * rz, strict=True)
        ]
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
    after = high_or_low[1:][np.diff(side[high_or_low]) != 0]
    # The last change of sign before each point from which on the profile is on the other side.
    sign_changes = np.flatnonzero(np.diff(np.signbit(profile)))
    last = sign_changes[np.searchsorted(sign_changes, after) - 1]
    positions = last + profile[last] / (profile[last] - profile[last + 1])
    falls, rises = positions[side[after] < 0], positions[side[after] > 0]
    crossings = [ends for ends in (falls, rises) if ends.size > 1]
    if not crossings:
        return None
    total_length = sum(float(ends[-1] - ends[0]) for ends in crossings)
    return float(step * total_length / sum(ends.size - 1 for ends in crossings))
