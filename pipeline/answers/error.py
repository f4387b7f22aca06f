"""Numerical error of a temperature rise at any load and velocity, in independent parts.

- Interpolation: 0 at computed points. It knows only the points around a place, so points that are
  added elsewhere never change it, and points that are added beside a place make it smaller.
- The preset's numerical choices, from what it promises of critical velocities.
- Warnings of the points around.
- The surface: other patches of it have other summits.

Each part is a bound that holds for at least 95 % of places. The parts are independent, so that
their squares add. An unknown part is NaN, and makes the total NaN. All are continuous.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.special import stdtrit

from pipeline.answers.field import Field
from pipeline.answers.pchip import Pchip
from pipeline.answers.specimen import SWEPT, Alone, Specimen
from pipeline.constants import (
    BEYOND,
    LEAST_BENT,
    OF_WARNED,
    RISE_SHARE,
    ROUGH_GAP,
    UNSEEN_BENT,
)
from tribo import WarningKind
from tribo.types import Array, Indices, Mask

PARTS = "interpolation", "discretization", "warnings", "surface"
"""Names of the parts, in their order."""
INTERPOLATION, PRESET, _, SURFACE = range(len(PARTS))
ROUGH_LOAD = 0.03
"""As `ROUGH_GAP`, between loads, of a single patch.

Leaving each load of five sweeps out, the bound held at 115 of 115 places, and 95 % of the errors
were below 0.6 of it.
"""
_SLOPE = 0.1  # error of the exponent beyond the computed velocities, as between its neighbours
_FLATTEST = 0.5  # exponent of the rise down to which a preset's promise of velocities was measured
_BESIDE = 1.01  # ratio of velocities between which an exponent is taken
_BOUND = 0.975  # quantile of Student's t whose two sides bound 95 %
_DURATIONS, _TOO_WARM = (1e-3, 1e-2, 0.1), (0.25, 0.11, 0.05)
"""Durations of ramps [s], and the largest relative error of rises with the heat model "elapsed"."""


def rise_errors(
    specimen: Specimen, promised: float | None, loads: Array, velocities: Array
) -> Array:
    """Relative errors of the rise at k places by part (4, k).

    `promised` is the relative error of critical velocities due to the preset; None if unknown.
    """
    field, points = specimen.field, warned_errors(specimen.flags, specimen.durations)
    along, between = interpolation_errors(specimen, loads, velocities)
    return np.stack(np.broadcast_arrays(
        np.hypot(along.sum(axis=0), between),
        np.nan if promised is None else RISE_SHARE * promised,
        field.bilinear(points, loads, velocities),
        field.bilinear(surface_errors(specimen), loads, velocities),
    ))  # fmt: skip


def velocity_errors(
    field: Field, parts: Array, promised: float | None, loads: Array, velocities: Array
) -> Array:
    """Relative errors of critical velocities by part (4, k), from the `parts` of the rise there.

    An error of the rise moves them by this error over the exponent d ln(rise)/d ln(velocity). What
    a preset promises is an error of the velocity.
    """
    exponent = exponents(field, loads, velocities)
    found = parts / exponent
    if promised is not None:
        found[PRESET] = promised * np.maximum(1.0, _FLATTEST / exponent)
    return found


def exponents(field: Field, loads: Array, velocities: Array) -> Array:
    """Size of d ln(rise)/d ln(velocity) at k places (k,); NaN where it is 0."""
    ahead, behind = (field(loads, velocities * _BESIDE**way) for way in (1, -1))
    found = np.abs(ahead - behind) / (2 * math.log(_BESIDE))
    return np.where(found > 0, found, np.nan)


def total(parts: Array) -> Array:
    """Total error: root of the sum of squares of the parts, the first axis."""
    return np.asarray(np.sqrt(np.square(parts).sum(axis=0)))


def interpolation_errors(
    specimen: Specimen, loads: Array, velocities: Array
) -> tuple[Array, Array]:
    """Relative errors of rises between computed points, or beyond the velocities, at k places.

    Returns the errors along the velocities of the two loads beside, weighed (2, k), and that
    between these loads (k,).
    """
    field = specimen.field
    low, high = field.beside(loads)
    first, last = field.loads[low], field.loads[high]
    gap = np.log(last / first)
    with np.errstate(invalid="ignore", divide="ignore"):
        way = np.where(gap > 0, np.log(loads / first) / gap, 0.0)
    along = np.zeros((2, len(loads)))
    for side, (rows, weight) in enumerate(((low, 1 - way), (high, way))):
        along[side] = np.where(weight > 0, weight * _along_rows(field, rows, velocities), 0.0)
    middle = field(np.sqrt(first * last), velocities)
    bow = middle - (field(first, velocities) + field(last, velocities)) / 2
    rows = field.tells if field.tells.size else np.array([0])
    inner = (low > rows[0]) & (high < rows[-1])
    # Each patch is rough along load in its own way.
    rough = ROUGH_LOAD / np.sqrt(np.maximum(np.minimum(*specimen.patches[[low, high]]), 1))
    between = _gap_bound(gap, bow, inner, len(rows) > 2, rough) * _shape(way)
    inside = (first <= loads) & (loads <= last)
    return along, np.where(inside, np.where(gap > 0, between, 0.0), np.nan)


def _along_rows(field: Field, rows: Indices, velocities: Array) -> Array:
    """Relative errors (k,) at velocities, of the loads numbered `rows` (k,)."""
    found = np.full(len(rows), np.nan)
    for row in np.unique(rows):
        here, known = np.flatnonzero(rows == row), np.flatnonzero(field.is_known[row])
        if known.size:
            x, y = np.log(field.velocities[known]), field.plane[row, known]
            found[here] = curve_errors(x, y, np.log(velocities[here]))
    return found


def curve_errors(x: Array, y: Array, at: Array) -> Array:
    """Errors at k places of the cubic through n points of ln(rise) `y` at ln(velocity) `x`.

    Examples
    --------
    >>> x = np.array([0.0, 0.4, 0.8])
    >>> curve_errors(x, 0.6 * x, np.array([0.2, 0.4, 1.0])).round(4).tolist()
    [0.0038, 0.0, 0.0246]
    """
    if len(x) == 1:
        return np.where(at == x[0], 0.0, np.nan)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    gap, middle = x[i + 1] - x[i], x[:-1] + np.diff(x) / 2
    bow = (Pchip(x, y[:, None]).beyond(middle)[:, 0] - (y[:-1] + y[1:]) / 2)[i]
    inner = (i > 0) & (i < len(x) - 2)
    way = np.clip((at - x[i]) / gap, 0, 1)
    within = _gap_bound(gap, bow, inner, len(x) > 2, ROUGH_GAP) * _shape(way)
    beyond = np.maximum(np.maximum(x[0] - at, at - x[-1]), 0.0)
    return np.asarray(within + beyond * np.hypot(_SLOPE, BEYOND * (beyond + gap)))


def _gap_bound(gap: Array, bow: Array, inner: Mask, is_seen: bool, rough: Array | float) -> Array:
    """Bound of the error in the middle of a gap between two points.

    Between them the cubic through all points differs from the chord by what is known of the
    curvature. It is halved between points that have further ones on both sides.
    """
    curved = np.maximum(np.abs(bow), LEAST_BENT * gap**2 / 8)
    curved = curved if is_seen else UNSEEN_BENT * gap**2 / 8
    return np.hypot(np.where(inner, curved / 2, curved), rough * gap)


def _shape(way: Array) -> Array:
    """Error within a gap over that in its middle: 0 at both points, and steep beside them."""
    return 2 * np.sqrt(np.clip(way * (1 - way), 0, None))


def surface_errors(specimen: Specimen) -> Array:
    """Bound of ln(rise) at 95 % due to the choice of patches, at points (n_load, n_velocity)."""
    count, known = specimen.patches[:, None], np.isfinite(specimen.apart)
    mean = np.where(known, specimen.apart, 0.0).sum(axis=0) / np.maximum(count, 1)
    squares = np.square(np.where(known, specimen.apart - mean, 0.0)).sum(axis=0)
    sampling = specimen.sampling[:, None]
    bound = patches_bound(count, squares, sampling, specimen.is_highest, specimen.alone)
    return np.broadcast_to(bound, mean.shape)


def patches_bound(
    count: Indices | int, squares: Array | float, sampling: Array | float,
    is_highest: bool = False, alone: Alone = SWEPT,
) -> Array:  # fmt: skip
    """Bound of ln(rise) at 95 % due to the choice of `count` patches.

    The deviation s of a patch has the patches' own estimates J (`sampling`) and their spread, the
    sum of `squares` of the differences from their mean: s² = (7 J² + squares)/(6 + P). The bound of
    the mean of P patches is t s/√P, with Student's t of 6 + P degrees; the highest of them is as
    uncertain as one. It is NaN for a single patch that states nothing.

    Examples
    --------
    >>> float(patches_bound(1, 0.0, 0.02).round(4)), float(patches_bound(16, 0.006, 0.02).round(4))
    (0.0473, 0.0104)
    """
    own = np.where(np.isnan(sampling), 0, alone.degrees)
    freedom = own + count - 1
    known = own * (alone.factor * np.nan_to_num(sampling)) ** 2 + squares
    deviation = np.sqrt(known / np.where(freedom > 0, freedom, np.nan))
    reduced = 1.0 if is_highest else np.sqrt(np.maximum(count, 1))
    return np.asarray(stdtrit(freedom, _BOUND) * deviation / reduced)


def patches_needed(
    count: int, ratio: float, most: int, is_highest: bool = False, alone: Alone = SWEPT
) -> int:
    """Number of patches, `most` at most, whose bound is that of `count` patches over `ratio`.

    It is taken that further patches differ as those that there are. The highest of them is as
    uncertain as one, so that no number suffices.

    Examples
    --------
    >>> patches_needed(1, 0.9, 256), patches_needed(1, 4.0, 256), patches_needed(8, 2.0, 20)
    (1, 13, 20)
    """
    if ratio <= 1:
        return count
    numbers = np.arange(1, most + 1)
    shares = patches_share(numbers, is_highest, alone)
    enough = numbers[shares <= shares[count - 1] / ratio]
    return int(enough[0]) if enough.size else most


def patches_share(count: Any, is_highest: bool = False, alone: Alone = SWEPT) -> Array:
    """Bound by `count` patches over the deviation of one; all state their own deviation."""
    bound = stdtrit(alone.degrees - 1 + count, _BOUND)
    return np.asarray(bound / (1.0 if is_highest else np.sqrt(count)))


def warned_errors(flags: Indices, durations: Array) -> Array:
    """Relative errors of rises that the warnings of their points imply; NaN if not known."""
    is_warm = (flags & int(WarningKind.PRESENT_HEAT)) > 0
    warm = np.interp(np.log(np.where(is_warm, durations, 1.0)), np.log(_DURATIONS), _TOO_WARM)
    errors = np.where(is_warm, warm, 0.0)
    for kind in {*WarningKind} - {WarningKind.PRESENT_HEAT}:
        is_kind = (flags & int(kind)) > 0
        errors = np.where(is_kind, np.maximum(errors, OF_WARNED.get(kind, math.nan)), errors)
    return errors
