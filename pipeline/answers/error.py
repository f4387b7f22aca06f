"""Numerical error of a temperature rise at any load and velocity, in independent parts.

- Interpolation: 0 at computed points. It knows only the points around a place, so points that are
  added elsewhere never change it, and points that are added beside a place make it smaller.
- The preset's numerical choices, from what it promises of critical velocities.
- Warnings of the points around.
- The surface: other realizations of it have other summits.

Each part is a bound that holds for at least 95 % of places. The parts are independent, so that
their squares add. An unknown part is NaN, and makes the total NaN. All are continuous.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pipeline.answers.field import Field
from pipeline.answers.pchip import Pchip
from pipeline.answers.specimen import Specimen
from pipeline.constants import (
    BEYOND,
    LEAST_BENT,
    OF_WARNED,
    RISE_SHARE,
    ROUGH_GAP,
    UNSEEN_BENT,
)
from tribo import WarningKind
from tribo.types import Array, Indices

PARTS = "interpolation", "discretization", "warnings", "surface"
"""Names of the parts, in their order."""
INTERPOLATION, PRESET, _, SURFACE = range(len(PARTS))
ROUGH_LOAD = 0.03
"""As `ROUGH_GAP`, between loads, of a single realization.

Leaving each load of five sweeps out, the bound held at 115 of 115 places, and 95 % of the errors
were below 0.6 of it.
"""
_SLOPE = 0.1  # error of the exponent beyond the computed velocities, as between its neighbours
_FLATTEST = 0.5  # exponent of the rise down to which a preset's promise of velocities was measured
_BESIDE = 1.01  # ratio of velocities between which an exponent is taken
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
        field.bilinear(specimen.mean.bound, loads, velocities),
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
    (low, high), way = field.bracketing_rows(loads), field.load_fraction(loads)
    first, last = field.loads[low], field.loads[high]
    has_gap = last > first
    sides = _along_rows(field, np.append(low, high), np.tile(velocities, 2)).reshape(2, -1)
    weights = np.stack([1 - way, way])
    along = np.where(weights > 0, weights * sides, 0.0)
    between = np.where(has_gap, np.nan, 0.0)
    if len(rows := field.curve_rows) > 1:
        # Each realization is rough along load in its own way.
        rough = ROUGH_LOAD / np.sqrt(np.maximum(specimen.realizations[rows], 1))
        each, back = np.unique(velocities, return_inverse=True)
        curves = Pchip(np.log(field.loads[rows]), field.rows(each)[rows])
        i = np.minimum(np.searchsorted(rows, low), len(rows) - 2)
        own = _along_rows(field, np.repeat(rows, len(each)), np.tile(each, len(rows)))
        own = own.reshape(len(rows), -1)
        bounds = _interpolation_bounds(curves, rough, np.unique(i[has_gap]), own)[i, back]
        between = np.where(has_gap, bounds * _shape(way), 0.0)
    inside = (first <= loads) & (loads <= last)
    return along, np.where(inside, between, np.nan)


def _along_rows(field: Field, rows: Indices, velocities: Array) -> Array:
    """Relative errors (k,) at velocities, of the loads numbered `rows` (k,)."""
    found = np.full(len(rows), np.nan)
    for alike, curves in field.curves:
        here = np.flatnonzero(np.isin(rows, alike))
        if here.size:
            own, at = np.searchsorted(alike, rows[here]), np.log(velocities[here])
            found[here] = _errors_of(curves, own, at)
    return found


def curve_errors(x: Array, y: Array, at: Array) -> Array:
    """Errors at k places of the cubic through n points of ln(rise) `y` at ln(velocity) `x`.

    Examples
    --------
    >>> x = np.array([0.0, 0.4, 0.8])
    >>> curve_errors(x, 0.6 * x, np.array([0.2, 0.4, 1.0])).round(4).tolist()
    [0.0038, 0.0, 0.0246]
    """
    return _errors_of(Pchip(x, y[:, None]), np.zeros(len(at), int), at)


def _errors_of(curves: Pchip, own: Indices, at: Array) -> Array:
    """Errors at k places of ln(velocity), each of the curve with its `own` number (k,)."""
    x = curves.x
    if len(x) == 1:
        return np.where(at == x[0], 0.0, np.nan)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    gap = x[i + 1] - x[i]
    bounds = _interpolation_bounds(curves, ROUGH_GAP, np.unique(i))[i, own]
    within = bounds * _shape((at - x[i]) / gap)
    beyond = np.maximum(np.maximum(x[0] - at, at - x[-1]), 0.0)
    return np.asarray(within + beyond * np.hypot(_SLOPE, BEYOND * (beyond + gap)))


def _interpolation_bounds(
    curves: Pchip, rough: Array | float, gaps: Indices, own: Array | float = 0.0
) -> Array:
    """Bounds of the error of k curves in the middle of each gap (n − 1, k), valid for `gaps`.

    A point that lies farther from the curve of the others than they bound, beside its `own` error
    and theirs (n, k), shows that they bound too little: both gaps beside it get its distance.
    """
    x, y = curves.x, curves.y
    rough, own = np.broadcast_to(rough, x.shape), np.broadcast_to(own, y.shape)
    found = _smooth_bounds(curves, rough)
    for k in {*np.append(gaps, gaps + 1).tolist()} - {0, len(x) - 1}:
        rest = np.arange(len(x)) != k
        others = Pchip(x[rest], y[rest])
        way = (x[k] - x[k - 1]) / (x[k + 1] - x[k - 1])
        stated = _smooth_bounds(others, rough[rest])[k - 1] * _shape(way)
        off = np.abs(others.grid(x[k : k + 1])[0] - y[k])
        off = off - own[k] - np.maximum(own[k - 1], own[k + 1])
        nearly = np.clip(50 * off / stated - 49, 0, 1)  # steep, but nothing jumps
        found[k - 1 : k + 1] = np.fmax(found[k - 1 : k + 1], nearly * off)
    return found


def _smooth_bounds(curves: Pchip, rough: Array) -> Array:
    """Bounds in the middle of each gap of curves on which all points lie.

    Between two points the cubic through all differs from the chord by what is known of the
    curvature. It is halved between points that have further ones on both sides.
    """
    x, y, gap = curves.x, curves.y, np.diff(curves.x)[:, None]
    if len(x) > 2:
        bow = curves.beyond((x[:-1] + x[1:]) / 2) - (y[:-1] + y[1:]) / 2
        curved = np.maximum(np.abs(bow), LEAST_BENT * gap**2 / 8)
        curved[1:-1] /= 2
    else:
        curved = np.broadcast_to(UNSEEN_BENT * gap**2 / 8, y[1:].shape)
    return np.hypot(curved, np.maximum(rough[:-1], rough[1:])[:, None] * gap)


def _shape(way: Any) -> Array:
    """Error within a gap over that in its middle: 0 at both points, and steep beside them."""
    return np.asarray(2 * np.sqrt(np.clip(way * (1 - way), 0, None)))


def warned_errors(flags: Indices, durations: Array) -> Array:
    """Relative errors of rises that the warnings of their points imply; NaN if not known."""
    is_warm = (flags & int(WarningKind.PRESENT_HEAT)) > 0
    warm = np.interp(np.log(np.where(is_warm, durations, 1.0)), np.log(_DURATIONS), _TOO_WARM)
    errors = np.where(is_warm, warm, 0.0)
    for kind in {*WarningKind} - {WarningKind.PRESENT_HEAT}:
        is_kind = (flags & int(kind)) > 0
        errors = np.where(is_kind, np.maximum(errors, OF_WARNED.get(kind, math.nan)), errors)
    return errors
