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

_HURST, _SURFACES = 0.8, 4  # of random surfaces
_WINDOW = 512  # pixels of a side of these surfaces
_SECTIONS, _HEIGHT = 5, 0.1  # sections of a profile; least height of its elements, over Rz


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
    grid = Grid((_WINDOW, _WINDOW), (pixel, pixel))

    def excess(length: float) -> float:
        spacings = list[float]()
        for seed in range(_SURFACES):
            heights = self_affine(grid, ra, _HURST, (length, length), seed=seed)
            for line in heights.T[::16]:
                rz = float(
                    np.mean([np.ptp(section) for section in np.array_split(line, _SECTIONS)])
                )
                spacings.append(mean_spacing(line, pixel, _HEIGHT * rz) or _WINDOW * pixel)
        return math.log(float(np.mean(spacings)) / rsm)

    ends = 0.3 * pixel, _WINDOW * pixel / 12
    below, above = (rsm * math.exp(excess(length)) for length in ends)
    if not below < rsm < above:
        raise InputError(
            f"RSm is {display(rsm, 'µm', 3)}; with pixels of {display(pixel, 'µm', 3)} profiles of "
            f"random surfaces have {display(below, 'µm', 3)} to {display(above, 'µm', 3)}; give "
            f"{'smaller' if rsm < below else 'larger'} pixels, --pixel-size"
        )
    return math.exp(float(brentq(lambda x: excess(math.exp(x)), *map(math.log, ends), xtol=0.01)))


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
