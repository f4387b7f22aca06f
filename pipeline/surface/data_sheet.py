"""A random surface with the Ra and RSm of a data sheet, or of an instrument for profiles."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from pipeline.quantities import display
from pipeline.surface.statistics import roughness_toml
from tribo import Grid, InputError
from tribo.surface import self_affine
from tribo.types import Array

_HURST = 0.8  # Hurst exponent of the random surfaces
_SURFACES = 4  # number of random surfaces
_PIXELS = 512  # along a side of these surfaces
_SECTIONS = 5  # sections of a profile, for Rz
_MIN_HEIGHT_RATIO = 0.1  # least height of profile elements, over Rz


def data_sheet_toml(ra: float, rsm: float, pixel: float) -> tuple[str, list[str]]:
    """Roughness of a scene's disk, for random surfaces with Ra and RSm [m], and the assumptions.

    RSm is that of profiles of random surfaces in pixels [m].
    """
    length = correlation_length(ra, rsm, pixel)
    return roughness_toml(ra, _HURST, (length, length)), [
        f"assumed: Hurst exponent {_HURST}",
        "assumed: isotropic, without a lay",
        f"assumed: RSm is that of profiles of random surfaces in pixels of "
        f"{display(pixel, 'µm', 3)}",
    ]


def correlation_length(ra: float, rsm: float, pixel: float) -> float:
    """Correlation length [m] of random surfaces with Ra and RSm [m], in pixels [m].

    Raises an `InputError` if profiles in such pixels cannot have this RSm.
    """
    grid = Grid((_PIXELS, _PIXELS), (pixel, pixel))

    def excess(length: float) -> float:
        spacings = list[float]()
        for seed in range(_SURFACES):
            heights = self_affine(grid, ra, _HURST, (length, length), seed=seed)
            for line in heights.T[::16]:
                rz = float(
                    np.mean([np.ptp(section) for section in np.array_split(line, _SECTIONS)])
                )
                spacings.append(
                    mean_spacing(line, pixel, _MIN_HEIGHT_RATIO * rz) or _PIXELS * pixel
                )
        return math.log(float(np.mean(spacings)) / rsm)

    limits = 0.3 * pixel, _PIXELS * pixel / 12
    shortest, longest = (rsm * math.exp(excess(length)) for length in limits)
    if not shortest < rsm < longest:
        raise InputError(
            f"RSm is {display(rsm, 'µm', 3)}; with pixels of {display(pixel, 'µm', 3)} profiles of "
            f"random surfaces have {display(shortest, 'µm', 3)} to {display(longest, 'µm', 3)}; "
            f"give {'smaller' if rsm < shortest else 'larger'} pixels, --pixel-size"
        )
    return math.exp(float(brentq(lambda x: excess(math.exp(x)), *map(math.log, limits), xtol=0.01)))


def mean_spacing(line: Array, step: float, min_height: float) -> float | None:
    """RSm [m]: mean spacing of profile elements with a peak and a valley of at least `min_height`.

    None for fewer than two elements.

    Examples
    --------
    >>> x = np.arange(4000) * 0.5e-6
    >>> f"{1e6 * mean_spacing(np.sin(2 * np.pi * x / 60e-6), 0.5e-6, 0.2):.2f} µm"
    '60.00 µm'
    """
    side = np.where(line > min_height, 1, np.where(line < -min_height, -1, 0))
    rows = np.flatnonzero(side)
    if rows.size < 2:
        return None
    crossings: list[list[float]] = [[], []]
    for k in np.flatnonzero(np.diff(side[rows])):
        low, high = rows[k], rows[k + 1]
        signs = np.flatnonzero(np.diff(np.signbit(line[low : high + 1])))
        row = low + int(signs[-1])
        position = row + line[row] / (line[row] - line[row + 1])
        crossings[int(side[high] > 0)].append(float(position))
    spans = [
        ((positions[-1] - positions[0]), len(positions) - 1)
        for positions in crossings
        if len(positions) > 1
    ]
    if not spans:
        return None
    return step * sum(span for span, _ in spans) / sum(count for _, count in spans)
