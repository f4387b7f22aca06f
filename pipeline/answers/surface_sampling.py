"""A specimen from its realizations: its rise at each point, and how its realizations differ.

Each random surface of a case is a realization of one specimen. Realizations differ by nearly a
constant along velocity, so a realization that lacks a point counts by its difference from the first
realization at the nearest point of that load which both have. At each load those realizations count
that have a point there. Loads that the first realization has alone, between loads of several
realizations, are left out: a single realization is up to some percent off there, and the specimen's
rises follow from the loads beside.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pipeline.answers.field import TWINS, Field
from pipeline.answers.realizations import (
    SWEPT,
    JackknifeQuality,
    RealizationMean,
    mean_of_realizations,
)
from pipeline.answers.results import CaseResults
from pipeline.sweep.conditions import Conditions
from tribo.types import Array, Indices, Mask


class Specimen(NamedTuple):
    """The specimen of a case, how its realizations differ, and what else is known at its points."""

    field: Field  # ln(rise) [K]
    # ln(rise) of each realization minus that of the first one (m, n_load, n_velocity); NaN at loads
    # where the realization has no point.
    apart: Array
    mean: RealizationMean
    flags: Indices  # sums of `WarningKind` codes (n_load, n_velocity)
    durations: Array  # times of loading [s]
    is_highest: bool  # the highest temperature decides: then that of the hottest realization
    alone: JackknifeQuality

    @property
    def realizations(self) -> Indices:
        """Number of realizations with a point at each load (n_load,)."""
        return np.asarray(np.isfinite(self.apart[..., 0]).sum(axis=0))

    def offset_at(self, load: float, velocity: float) -> float:
        """ln(rise) minus that of the first realization; beyond the points that of the nearest."""
        f = self.field
        along = [np.interp(velocity, f.velocities, row) for row in self.mean.offset]
        return float(np.interp(math.log(load), np.log(f.loads), along))


def specimen_of(case: CaseResults, conditions: Conditions, flags: Indices) -> Specimen:
    """The specimen of a case; `flags` (m, n_load, n_velocity) are sums of `WarningKind` codes."""
    counts = case.usable_realizations
    y, sampling = case.log_rises(conditions)[counts], case.sampling(conditions)[counts]
    durations, kinds = case.durations[counts].max(axis=0), np.bitwise_or.reduce(flags[counts], 0)
    sampling = _stated(sampling)
    loads, velocities = case.loads, case.velocities
    for axis, x in ((0, loads), (1, velocities)):
        if (twins := np.diff(np.log(x)) < TWINS).any():
            starts = np.flatnonzero(np.append(True, ~twins))
            y, durations = _means(y, starts, axis + 1), np.maximum.reduceat(durations, starts, axis)
            kinds = np.bitwise_or.reduceat(kinds, starts, axis)
            sampling = _means(sampling, starts, axis)
            if axis == 0:
                loads = _means(loads, starts)
            else:
                velocities = _means(velocities, starts)
    factor = conditions.friction_factor if conditions.has_friction_curve else np.ones_like
    is_highest = conditions.critical_area_fraction == 0
    alone = JackknifeQuality.of(case.sweep.scene)
    return merged(loads, velocities, y, sampling, kinds, durations, factor, is_highest, alone)


def merged(
    loads: Array, velocities: Array, y: Array, sampling: Array, flags: Indices, durations: Array,
    factor: Callable[[Array], Array] = np.ones_like, is_highest: bool = False,
    alone: JackknifeQuality = SWEPT,
) -> Specimen:  # fmt: skip
    """The specimen of realizations with ln(rise) `y` (m, n_load, n_velocity), NaN without a result.

    Of realizations of the highest temperature it has the highest, of others the mean.
    """
    level, differences = y[0], [np.zeros_like(y[0])]
    for own in y[1:]:
        differences.append(_extended(own - y[0], loads))
        level = np.where(np.isnan(level), own - differences[-1], level)
    has_point = np.asarray(np.isfinite(y).any(axis=2))
    has_point[0] = has_point.any(axis=0)
    is_alone = _between_several(has_point)
    known = has_point & ~is_alone
    apart = np.where(known[..., None], np.array(differences), np.nan)
    mean = mean_of_realizations(loads, apart, sampling, alone, is_highest)
    offset = _along_load(loads, mean.offset, np.asarray(known.any(axis=0)))
    plane = np.where(is_alone[:, None], np.nan, level + offset)
    field = Field(loads, velocities, plane, factor)
    mean = mean._replace(offset=offset)
    return Specimen(field, apart, mean, flags, durations, is_highest, alone)


def _stated(sampling: Array) -> Array:
    """Root mean square over realizations at each point; where none tells, that of the nearest."""
    known = np.isfinite(sampling)
    squares, count = np.square(np.where(known, sampling, 0.0)).sum(axis=0), known.sum(axis=0)
    with np.errstate(invalid="ignore"):
        return _of_nearest(np.sqrt(squares / count))


def _of_nearest(values: Array) -> Array:
    """Values (n_load, n_velocity), where unknown those of the nearest velocity of a load."""
    number = np.arange(values.shape[1])
    known = np.isfinite(values)[:, None, :]
    away = np.where(known, np.abs(number[:, None] - number), np.inf)
    return np.take_along_axis(values, away.argmin(axis=-1), axis=1)


def _extended(difference: Array, loads: Array) -> Array:
    """Differences from the first realization at all points, from those that both have."""
    known = np.isfinite(difference)
    if known.all():
        return difference
    rows, nearest = np.asarray(known.any(axis=1)), _of_nearest(difference)
    return np.where(rows[:, None], nearest, _along_load(loads, nearest, rows))


def _along_load(loads: Array, values: Array, rows: Mask) -> Array:
    """Values (n_load, n_velocity), at loads other than `rows` interpolated in ln(load)."""
    if rows.all():
        return values
    if not rows.any():
        return np.zeros_like(values)
    x = np.log(loads)
    return np.transpose([np.interp(x, x[rows], column) for column in values[rows].T])


def _between_several(has_point: Mask) -> Mask:
    """Mask of the loads (n_load,) of one realization (m, n_load) between loads of several."""
    counts, number = has_point.sum(axis=0), np.arange(has_point.shape[1])
    several = np.flatnonzero(counts > 1)
    first, last = several[[0, -1]] if several.size else (0, 0)
    return np.asarray((counts == 1) & (first < number) & (number < last))


def _means(values: Array, starts: Indices, axis: int = 0) -> Array:
    """Means of the known values of each group along an axis."""
    known = np.isfinite(values)
    total = np.add.reduceat(np.where(known, values, 0.0), starts, axis)
    with np.errstate(invalid="ignore"):
        return np.asarray(total / np.add.reduceat(known.astype(int), starts, axis))
