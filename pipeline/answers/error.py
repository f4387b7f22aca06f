"""Numerical error of a temperature rise at any load and velocity, in independent parts.

- Interpolation: 0 at simulated points. It depends only on neighbouring points: further points make
  it smaller nearby, and do not change it elsewhere.
- Discretization: the error that the preset promises for critical velocities where the rise grows as
  velocity to the power of `RISE_EXPONENT`. Where it grows more slowly, the same error of the rise
  is a larger one of the velocity.
- Warnings of neighbouring points.
- Positions: a pin at rest under a line contact wears by the disk, or strips of it, at some
  positions, and others would give another rise. The error falls with the number of realizations. It
  is no property of the surface, and counts also for a scan, whose surface is fixed.
- Surface: other realizations of it have other summits.

Each part is a bound that holds at 95 % or more of all loads and velocities. The parts are
independent, so their squares add. An unknown part is NaN, and so is then the total. All are
continuous.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.answers.pchip import Pchip
from pipeline.constants import (
    EXPONENT_ERROR,
    FREE_ENDS_POSITION_LIMIT,
    HIGHEST_TEMPERATURE_BOUNDS,
    HIGHEST_TEMPERATURE_FRACTION,
    LARGE_AREA_FRACTION,
    LARGE_FRACTION_BOUNDS,
    MIN_CURVATURE,
    POSITION_LIMIT,
    POSITION_SHARE,
    PRESET_BOUNDS,
    RISE_EXPONENT,
    ROUGHNESS_DEVIATION,
    ROUGHNESS_ERROR,
    UNSEEN_CURVATURE,
    WARNING_ERRORS,
)
from pipeline.sweep.sweep import Sweep
from tribo import PRESETS, Fidelity, Scene, WarningKind
from tribo.simulation.pin_ends import has_free_ends
from tribo.types import Array, Indices

if TYPE_CHECKING:  # so that irg check does not import xarray
    from pipeline.answers.field import Field
    from pipeline.answers.field_points import FieldPoints
    from pipeline.answers.specimen import Specimen

PARTS = {
    "interpolation": "interpolation between points",
    "discretization": "discretization (preset)",
    "warnings": "allowance for warnings",
    "positions": "positions of the moving disk",
    "surface": "surface sampling",
}
"""Meaning of each part, by its name, in their order."""
INTERPOLATION, PRESET, WARNINGS, POSITIONS, SURFACE = range(len(PARTS))
ROUGH_LOAD = 0.03
"""Like `ROUGHNESS_ERROR`, but between loads, for a single realization.

With each load of five sweeps left out in turn, the bound held at 115 of 115 points, and 95 % of the
errors were below 0.6 of it.
"""
_SLOPE = 0.1  # error of the exponent just beyond the simulated velocities
_EXPONENT_RATIO = 1.01  # to both sides of a velocity, for the exponent by differences
_DURATIONS, _WARM_ERRORS = (1e-3, 1e-2, 0.1), (0.25, 0.11, 0.05)
"""Durations of ramps [s], and the largest relative error of the heat model "elapsed" at these."""


def rise_errors(specimen: Specimen, preset_error: float | None, points: FieldPoints) -> Array:
    """Relative errors of the rise at k points by part (5, k).

    `preset_error` is the relative error of critical velocities due to the preset; None if unknown.
    """
    along, between = interpolation_errors(specimen, points)
    surface = surface_sampling_errors(specimen, points)
    return np.stack(np.broadcast_arrays(
        np.hypot(along.sum(axis=0), between),
        np.nan if preset_error is None else RISE_EXPONENT * preset_error,
        points.bilinear(warned_errors(specimen.flags, specimen.durations)),
        position_errors(specimen, surface, points),
        surface,
    ))  # fmt: skip


def surface_sampling_errors(specimen: Specimen, points: FieldPoints) -> Array:
    """Relative errors of the rise by surface sampling at k points.

    Between two loads their errors add by the correlation that the realizations give them.
    """
    covariance, (low, high) = specimen.mean.covariance, points.rows
    correlation = covariance[low, high] / np.sqrt(covariance[low, low] * covariance[high, high])
    sides = points.weighted_sides(specimen.mean.bound)
    return np.asarray(np.sqrt(np.square(sides).sum(axis=0) + 2 * correlation * sides.prod(axis=0)))


def position_errors(specimen: Specimen, surface: Array, points: FieldPoints) -> Array:
    """Relative errors of the rise by positions of the disk at k points.

    They are a share of the errors by `surface` sampling (k,), or the largest error if that is less
    or surface sampling is unknown. The mean of n realizations errs by 1/√n of the largest error.
    The difference between realizations contains the error, so that surface sampling counts it by
    n − 1 degrees of freedom; only the jackknife's degrees are left here.
    """
    count = np.maximum(specimen.realizations, 1)
    further = count - 1.0
    weights = np.where(further > 0, specimen.freedom / np.maximum(specimen.freedom + further, 1), 1)
    row = np.ones(len(specimen.field.velocities))
    limit, weight = (
        points.bilinear(values[:, None] * row)
        for values in (specimen.position_limit / np.sqrt(count), np.sqrt(weights))
    )
    return np.asarray(weight * np.fmin(POSITION_SHARE * surface, limit))


def velocity_errors(field: Field, parts: Array, loads: Array, velocities: Array) -> Array:
    """Relative errors of critical velocities by part (5, k), from the `parts` of the rise.

    The error of a velocity is that of the rise over the exponent d ln(rise)/d ln(velocity). By the
    preset it is at least the error that the preset promises for velocities.
    """
    exponent = exponents(field, loads, velocities)
    errors = parts / exponent
    errors[PRESET] = parts[PRESET] / np.minimum(exponent, RISE_EXPONENT)
    return errors


def exponents(field: Field, loads: Array, velocities: Array) -> Array:
    """Absolute values of d ln(rise)/d ln(velocity) at k points; NaN where they are 0."""
    upper, lower = (field(loads, velocities * _EXPONENT_RATIO**sign) for sign in (1, -1))
    exponent = np.abs(upper - lower) / (2 * math.log(_EXPONENT_RATIO))
    return np.where(exponent > 0, exponent, np.nan)


def total(parts: Array) -> Array:
    """Total error: root of the sum of squares of the parts, the first axis."""
    return np.asarray(np.sqrt(np.square(parts).sum(axis=0)))


def interpolation_errors(specimen: Specimen, points: FieldPoints) -> tuple[Array, Array]:
    """Relative errors of rises between simulated points, or beyond the velocities, at k points.

    Returns the errors along velocity of the two bracketing loads, times their weights (2, k), and
    the error between these loads (k,).
    """
    field, pairs = specimen.field, np.arange(len(points.loads))
    low, weights, at_rows = points.rows[0], points.weights, points.row_velocities
    low_load, high_load = field.loads[points.rows]
    has_gap = high_load > low_load
    row_errors = _row_errors(specimen, points.rows.ravel(), at_rows[points.rows, pairs].ravel())
    along = np.where(weights > 0, weights * row_errors.reshape(2, -1), 0.0)
    between = np.where(has_gap, np.nan, 0.0)
    if len(rows := field.interpolated_rows) > 1:
        # Roughness of a single realization; the surface-sampling error of several includes theirs.
        roughness = np.where(specimen.realizations[rows] > 1, 0.0, ROUGH_LOAD)
        curves = Pchip(np.log(field.loads[rows]), points.row_values[rows])
        errors = _row_errors(specimen, np.repeat(rows, len(pairs)), at_rows[rows].ravel())
        errors = errors.reshape(len(rows), -1)
        noise = np.where(roughness > 0, 0.0, specimen.mean.contrast_bound(rows, curves.x))
        gap = np.minimum(np.searchsorted(rows, low), len(rows) - 2)
        bounds = _interpolation_bounds(
            curves, roughness, np.unique(gap[has_gap]), errors, noise[:, None]
        )
        between = np.where(has_gap, bounds[gap, pairs] * _gap_shape(weights[1]), 0.0)
    is_within = (low_load <= points.loads) & (points.loads <= high_load)
    return along, np.where(is_within, between, np.nan)


def _row_errors(specimen: Specimen, rows: Indices, velocities: Array) -> Array:
    """Relative errors (k,) along velocity at the loads with indices `rows` (k,)."""
    errors = np.full(len(rows), np.nan)
    for (curve_rows, curves), bounds in zip(
        specimen.field.curves, specimen.bounds_along_velocity, strict=True
    ):
        indices = np.flatnonzero(np.isin(rows, curve_rows))
        if indices.size:
            columns, at = np.searchsorted(curve_rows, rows[indices]), np.log(velocities[indices])
            errors[indices] = _curve_errors(curves.x, bounds, columns, at)
    return errors


def bounds_along_velocity(specimen: Specimen) -> list[Array]:
    """Bounds of the error in the middle of each gap between velocities, for each of the curves."""
    # The mean of several realizations is smooth; the curve of the first one is not.
    noise = np.where(specimen.realizations > 1, ROUGHNESS_DEVIATION, 0.0)
    return [_curve_bounds(curves, noise[rows]) for rows, curves in specimen.field.curves]


def curve_errors(x: Array, y: Array, at: Array) -> Array:
    """Errors at k values `at` of ln(velocity) of the cubic through n points (`x`, ln(rise) `y`).

    Examples
    --------
    >>> x = np.array([0.0, 0.4, 0.8])
    >>> curve_errors(x, 0.6 * x, np.array([0.2, 0.4, 1.0])).round(4).tolist()
    [0.0038, 0.0, 0.0246]
    """
    bounds = _curve_bounds(Pchip(x, y[:, None]), 0.0)
    return _curve_errors(x, bounds, np.zeros(len(at), int), at)


def _curve_bounds(curves: Pchip, noise: Array | float) -> Array:
    """Bounds of the error of k curves in the middle of each gap between velocities (n − 1, k)."""
    gaps = np.arange(len(curves.x) - 1)
    return _interpolation_bounds(curves, ROUGHNESS_ERROR, gaps, noise=noise)


def _curve_errors(x: Array, bounds: Array, columns: Indices, at: Array) -> Array:
    """Errors at k values `at` of ln(velocity), each of the curve in column `columns` (k,)."""
    if len(x) == 1:
        return np.where(at == x[0], 0.0, np.nan)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    gap = x[i + 1] - x[i]
    interpolated = bounds[i, columns] * _gap_shape((at - x[i]) / gap)
    beyond = np.maximum(np.maximum(x[0] - at, at - x[-1]), 0.0)
    return np.asarray(interpolated + beyond * np.hypot(_SLOPE, EXPONENT_ERROR * (beyond + gap)))


def _interpolation_bounds(
    curves: Pchip, roughness: Array | float, gaps: Indices, errors: Array | float = 0.0,
    noise: Array | float = 0.0,
) -> Array:  # fmt: skip
    """Bounds of the error of k curves in the middle of each gap (n − 1, k), valid for `gaps`.

    The curve without a point has a bound there, too. If the distance of the point from this curve,
    less the `errors` of the points themselves (n, k) and the `noise` of such a distance,
    exceeds that bound, both gaps next to the point get this distance as their bound.
    """
    x, y = curves.x, curves.y
    roughness = np.broadcast_to(roughness, x.shape)
    errors, noise = np.broadcast_to(errors, y.shape), np.broadcast_to(noise, y.shape)
    bounds = _smooth_bounds(curves, roughness)
    for k in {*np.append(gaps, gaps + 1).tolist()} - {0, len(x) - 1}:
        is_other = np.arange(len(x)) != k
        curves_without = Pchip(x[is_other], y[is_other])
        fraction = (x[k] - x[k - 1]) / (x[k + 1] - x[k - 1])
        bound = _smooth_bounds(curves_without, roughness[is_other])[k - 1] * _gap_shape(fraction)
        excess = np.abs(curves_without.grid(x[k : k + 1])[0] - y[k])
        excess = excess - noise[k] - errors[k] - np.maximum(errors[k - 1], errors[k + 1])
        weight = np.clip(50 * excess / bound - 49, 0, 1)  # steep, but continuous
        bounds[k - 1 : k + 1] = np.fmax(bounds[k - 1 : k + 1], weight * excess)
    return bounds


def _smooth_bounds(curves: Pchip, roughness: Array) -> Array:
    """Bounds in the middle of each gap, if the points deviate from the curves by `roughness` only.

    The distance of the cubic from the chord is the estimate of the curvature. Half of it is the
    bound in gaps that have further points on both sides.
    """
    x, y, gap = curves.x, curves.y, np.diff(curves.x)[:, None]
    if len(x) > 2:
        sagitta = curves.beyond((x[:-1] + x[1:])[:, None] / 2) - (y[:-1] + y[1:]) / 2
        curved = np.maximum(np.abs(sagitta), MIN_CURVATURE * gap**2 / 8)
        curved[1:-1] /= 2
    else:
        curved = np.broadcast_to(UNSEEN_CURVATURE * gap**2 / 8, y[1:].shape)
    return np.hypot(curved, np.maximum(roughness[:-1], roughness[1:])[:, None] * gap)


def _gap_shape(fraction: Any) -> Array:
    """Error within a gap over that in its middle: 0 at both ends, where it is steep."""
    return np.asarray(2 * np.sqrt(np.clip(fraction * (1 - fraction), 0, None)))


def warned_errors(flags: Indices, durations: Array) -> Array:
    """Relative errors of rises due to the warnings of their points; NaN if unknown."""
    is_warm = (flags & int(WarningKind.PRESENT_HEAT)) > 0
    warm = np.interp(np.log(np.where(is_warm, durations, 1.0)), np.log(_DURATIONS), _WARM_ERRORS)
    errors = np.where(is_warm, warm, 0.0)
    for kind in {*WarningKind} - {WarningKind.PRESENT_HEAT}:
        is_kind = (flags & int(kind)) > 0
        errors = np.where(is_kind, np.maximum(errors, WARNING_ERRORS.get(kind, math.nan)), errors)
    return errors


def presets_for(scene: Scene, names: Iterable[str]) -> dict[str, Fidelity]:
    """Presets by name; their elements are small enough to tile the scene's grid of pixels."""
    return {name: with_dividing_elements(scene, PRESETS[name]) for name in names}


def with_dividing_elements(scene: Scene, fidelity: Fidelity) -> Fidelity:
    """Return `fidelity` with elements small enough to tile the scene's grid of pixels.

    An element is a block of n × n pixels. Its n is lowered until n divides the numbers of pixels
    along x and along y.
    """
    nx, ny = scene.pixels.shape
    divisors = (n for n in range(fidelity.pixels_per_element, 0, -1) if nx % n == ny % n == 0)
    return replace(fidelity, pixels_per_element=next(divisors))


def preset_of(scene: Scene) -> str | None:
    """Name of the preset that a scene has, adapted to it; None for custom settings."""
    adapted = presets_for(scene, PRESET_BOUNDS).items()
    return next((name for name, fidelity in adapted if fidelity == scene.fidelity), None)


def preset_error_of(sweep: Sweep) -> float | None:
    """Bound of the relative error of a sweep's critical velocity; None if unknown.

    It is known only for presets, adapted to the scene.
    """
    return preset_bound(str(_preset(sweep)), sweep.conditions.critical_area_fraction)


def preset_bound(preset: str, share: float) -> float | None:
    """Bound of the relative error of critical velocities with a preset; None without a preset.

    `share` is the critical area fraction.
    """
    bounds = dict[str, float]()
    if share < HIGHEST_TEMPERATURE_FRACTION:
        bounds = HIGHEST_TEMPERATURE_BOUNDS
    elif share >= LARGE_AREA_FRACTION:
        bounds = LARGE_FRACTION_BOUNDS
    return bounds.get(preset, PRESET_BOUNDS.get(preset))


def finer_preset_error(sweep: Sweep) -> float:
    """Bound of the relative error of a sweep's critical velocity with the next finer preset.

    It is that of the coarsest preset for custom settings, and of the finest for the finest.
    """
    presets, preset = [*PRESET_BOUNDS], _preset(sweep)
    finer = presets.index(preset) + 1 if preset in presets else 0
    name = presets[min(finer, len(presets) - 1)]
    return float(preset_bound(name, sweep.conditions.critical_area_fraction) or math.nan)


def position_limit(sweep: Sweep) -> float:
    """Largest relative error of a rise by positions of the disk.

    It is 0 unless a pin wears by strips of the disk, or is computed with its ends and wears by the
    disk at many positions.
    """
    if sweep.scene.sweeps_over and has_free_ends(sweep.scene):
        return FREE_ENDS_POSITION_LIMIT
    return POSITION_LIMIT if sweep.scene.wears_by_strips else 0.0


def has_boundary(sweep: Sweep) -> bool:
    """True if a sweep has a boundary of severe wear, whose error is of interest."""
    is_judged = sweep.conditions.friction > 0 and sweep.base.is_judged
    return is_judged and any(sweep.velocities)


def has_unknown_preset_error(sweep: Sweep) -> bool:
    """True if a sweep has a boundary of severe wear, but no preset whose error is known."""
    return has_boundary(sweep) and preset_error_of(sweep) is None


def preset_error_text(sweep: Sweep) -> str:
    """Describe the discretization error of a sweep."""
    error = preset_error_of(sweep)
    if error is None:
        return "custom numerical settings: the error of critical velocities is unknown"
    text = (
        f"preset {_preset(sweep)}: discretization error at most {100 * error:g} % of critical "
        "velocities, more where the rise hardly grows with velocity (irg help choosing)"
    )
    if limit := position_limit(sweep):
        text += (
            f"; random error by positions of the disk at most {100 * limit:g} % of the rise of one "
            "realization"
        )
    return text


def _preset(sweep: Sweep) -> str | None:
    """Name of the preset of a sweep; None for custom numerical settings."""
    return sweep.preset or preset_of(sweep.scene)
