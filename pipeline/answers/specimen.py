"""A specimen from its realizations: its rise at each point, and how far its mean may be off.

Each random surface of a case is a realization of one specimen. Realizations differ by nearly a
constant along velocity, so a realization that lacks a point counts by its difference from the first
realization at the nearest point of that load which both have. At each load those realizations count
that have a point there. Loads that the first realization has alone, between loads of several
realizations, are left out: a single realization is up to some percent off there, and the specimen's
rises follow from the loads beside.

At a load fewer realizations may be simulated than at another. Realizations differ alike at loads
beside each other, so those that are simulated at the other load alone count, too: as much as the
differences at both loads are correlated (a control variate with a slope that is fixed before).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri, stdtrit

from pipeline.answers.field import TWINS, Field
from pipeline.answers.results import CaseResults
from pipeline.constants import ALONE_IN_LOCAL_WEAR, CORRELATION
from pipeline.sweep.conditions import Conditions
from tribo import Scene
from tribo.thermal.sampling import GROUPS
from tribo.types import Array, Indices, Mask

_BOUND = 0.975  # quantile of Student's t whose two sides bound 95 %


class JackknifeQuality(NamedTuple):
    """What a realization alone tells of how realizations differ, by its jackknife."""

    degrees: int = GROUPS - 1  # of freedom
    factor: float = 1.0  # of the deviation of realizations over that which one states

    @classmethod
    def of(cls, scene: Scene) -> JackknifeQuality:
        """What a realization of a scene tells."""
        is_local = scene.wear is not None and scene.wear.pattern == "local"
        return JackknifeQuality(*ALONE_IN_LOCAL_WEAR) if is_local else SWEPT


SWEPT = JackknifeQuality()
"""What a realization alone tells unless wear is local."""


class RealizationMean(NamedTuple):
    """ln(rise) of a specimen by its realizations, at points (n_load, n_velocity)."""

    offset: Array  # ln(rise) of the specimen minus that of its first realization
    bound: Array  # of the error at 95 % due to the choice of realizations
    deviation: Array  # of one realization
    shared: Array  # part of `bound` that rests on realizations at the load `shared_from`
    shared_from: Indices  # (n_load,); −1 at loads whose own realizations decide


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


def specimen_of(case: CaseResults, conditions: Conditions) -> Specimen:
    """The specimen of a case."""
    counts = case.usable_realizations
    y = case.log_rises(conditions)[counts]
    sampling = _mean_stated(case.sampling(conditions)[counts])
    kinds = np.bitwise_or.reduce(case.warning_flags[counts], 0)
    durations = case.durations[counts].max(axis=0)
    axes = [case.loads, case.velocities]
    for axis, x in enumerate(axes):
        starts = np.flatnonzero(np.append(True, np.diff(np.log(x)) >= TWINS))
        if len(starts) < len(x):
            axes[axis] = _means(x, starts)
            y, sampling = _means(y, starts, axis + 1), _means(sampling, starts, axis)
            kinds = np.bitwise_or.reduceat(kinds, starts, axis)
            durations = np.maximum.reduceat(durations, starts, axis)
    loads, velocities = axes
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


def _mean_stated(sampling: Array) -> Array:
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


def mean_of_realizations(
    loads: Array, apart: Array, sampling: Array, alone: JackknifeQuality, is_highest: bool
) -> RealizationMean:
    """Mean of realizations; the highest of them if the highest temperature decides.

    Parameters
    ----------
    loads : ndarray, shape (n_load,)
        Loads [N].
    apart : ndarray, shape (m, n_load, n_velocity)
        ln(rise) of each realization minus that of the first one; NaN at loads where it has none.
    sampling : ndarray, shape (n_load, n_velocity)
        Deviation of realizations that they state themselves, by their jackknife; NaN if unknown.
    alone : JackknifeQuality
        What a realization alone tells.
    is_highest : bool
        True if the highest temperature decides.

    Examples
    --------
    Of four realizations at 100 N two are simulated at 200 N, too. They are hotter than the mean
    at 100 N, so the specimen is less hot at 200 N than they are:

    >>> apart = np.array([[0.0, 0.0], [0.02, 0.02], [-0.05, np.nan], [-0.07, np.nan]])[..., None]
    >>> stated = np.full((2, 1), 0.04)
    >>> loads = np.array([100.0, 200.0])
    >>> mean_of_realizations(loads, apart, stated, SWEPT, False).offset.ravel().round(4).tolist()
    [-0.025, -0.0145]
    """
    known = np.isfinite(apart)
    count = known[..., :1].sum(axis=0)  # (n_load, 1)
    zeroed = np.where(known, apart, 0.0)
    offset = zeroed.sum(axis=0) / np.maximum(count, 1)
    squares = np.square(np.where(known, apart - offset, 0.0)).sum(axis=0)
    if is_highest:
        offset = np.where(known, apart, -np.inf).max(axis=0)
    stated = _stated(squares, count, sampling, alone)
    found = RealizationMean(
        offset,
        bound=surface_sampling_bound(count, squares, stated, is_highest, alone),
        deviation=_deviation(count, squares, stated, alone)[0],
        shared=np.zeros_like(squares),
        shared_from=np.full(len(loads), -1),
    )
    if is_highest:
        return found
    for load in np.argsort(-count[:, 0], kind="stable").tolist():
        more = np.flatnonzero(count[:, 0] > count[load, 0])
        if count[load, 0] > 1 and more.size:
            nearest = int(more[np.argmin(np.abs(np.log(loads[more] / loads[load])))])
            _share(found, load, nearest, apart, stated, alone)
    return found


def _share(
    found: RealizationMean, load: int, other: int, apart: Array, stated: Array,
    alone: JackknifeQuality,
) -> None:  # fmt: skip
    """Let realizations of another load count at a load, if its error gets smaller."""
    both = np.isfinite(apart[:, [load, other], 0]).all(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = CORRELATION * float(np.median(stated[load] / stated[other]))
    if both.sum() < 2 or not 0 < slope < np.inf:
        return
    rest = apart[both, load] - slope * apart[both, other]
    squares = np.square(rest - rest.mean(axis=0)).sum(axis=0)
    prior = np.sqrt(1 - CORRELATION**2) * stated[load]
    own = surface_sampling_bound(int(both.sum()), squares, prior, alone=alone)
    shared = slope * found.bound[other]
    bound = np.hypot(own, shared)
    if np.median(bound) < np.median(found.bound[load]):
        found.offset[load] = rest.mean(axis=0) + slope * found.offset[other]
        found.bound[load], found.shared[load], found.shared_from[load] = bound, shared, other


def _stated(squares: Array, count: Indices, sampling: Array, alone: JackknifeQuality) -> Array:
    """What realizations state of their deviation, scaled by what their spread tells of it.

    Loads share this ratio: their realizations are the same surfaces.
    """
    own = np.square(alone.factor * sampling)
    freedom = np.where(own > 0, np.maximum(count - 1, 0), 0)
    ratio = np.divide(squares, own, out=np.zeros_like(squares), where=own > 0).sum(axis=0)
    ratio, most = ratio / np.maximum(freedom.sum(axis=0), 1), freedom.max(axis=0)
    return np.asarray(sampling * np.sqrt((alone.degrees + most * ratio) / (alone.degrees + most)))


def _deviation(
    count: Any, squares: Any, sampling: Any, alone: JackknifeQuality
) -> tuple[Array, Array]:
    """Deviation of a realization, and Student's t that bounds it."""
    own = np.where(np.isnan(sampling), 0, alone.degrees)
    freedom = own + count - 1
    known = own * (alone.factor * np.nan_to_num(sampling)) ** 2 + squares
    deviation = np.sqrt(known / np.where(freedom > 0, freedom, np.nan))
    return deviation, np.asarray(stdtrit(freedom, _BOUND))


def surface_sampling_bound(
    count: Indices | int, squares: Array | float, sampling: Array | float,
    is_highest: bool = False, alone: JackknifeQuality = SWEPT,
) -> Array:  # fmt: skip
    """Bound of ln(rise) at 95 % due to the choice of `count` realizations.

    The deviation s of a realization has the realizations' own estimates J (`sampling`) and their
    spread, the sum of `squares` of the differences from their mean: s² = (7 J² + squares)/(6 + P).
    The bound of the mean of P realizations is t s/√P, with Student's t of 6 + P degrees; the
    highest of them is as uncertain as one. It is NaN for a single realization that states nothing.

    Examples
    --------
    >>> float(surface_sampling_bound(1, 0.0, 0.02).round(4))
    0.0473
    >>> float(surface_sampling_bound(16, 0.006, 0.02).round(4))
    0.0104
    """
    deviation, reduced = _deviation(count, squares, sampling, alone)
    return np.asarray(deviation * reduced / (1.0 if is_highest else np.sqrt(np.maximum(count, 1))))


def realizations_needed(
    count: int, ratio: float, most: int, is_highest: bool = False, alone: JackknifeQuality = SWEPT
) -> int:
    """Number of realizations, `most` at most, whose bound is that of `count` of them over `ratio`.

    It is taken that further realizations differ as those that there are. The highest of them is as
    uncertain as one, so that no number suffices.

    Examples
    --------
    >>> [realizations_needed(1, ratio, 256) for ratio in (0.9, 4.0)]
    [1, 13]
    >>> realizations_needed(8, 2.0, 20)
    20
    """
    if ratio <= 1:
        return count
    numbers = np.arange(1, most + 1)
    shares = realizations_share(numbers, is_highest, alone)
    enough = numbers[shares <= shares[count - 1] / ratio]
    return int(enough[0]) if enough.size else most


def realizations_share(
    count: Any, is_highest: bool = False, alone: JackknifeQuality = SWEPT
) -> Array:
    """Bound by `count` realizations over the deviation of one; all state their own deviation."""
    bound = stdtrit(alone.degrees - 1 + count, _BOUND)
    return np.asarray(bound / (1.0 if is_highest else np.sqrt(count)))


def least_variance_share(count: Any, alone: JackknifeQuality = SWEPT) -> Array:
    """Least variance of realizations at 97.5 % over that which `count` of them tell.

    Examples
    --------
    >>> least_variance_share(np.array([1, 16, 256])).round(2).tolist()
    [0.44, 0.6, 0.85]
    """
    freedom = alone.degrees + np.asarray(count) - 1
    return np.asarray(freedom / chdtri(freedom, 1 - _BOUND))
