"""A specimen from its realizations: its rise at each point, and the error of their mean.

Each random surface of a case is a realization of one specimen. The difference between two
realizations is nearly constant along velocity. A realization that lacks a point therefore takes its
difference from the first realization at the nearest velocity of this load at which both have a
point. The mean at a load is over the realizations that have a point at this load. A load that only
the first realization has, between loads that several have, is omitted: a single realization may err
by some percent, and the specimen's rise there is interpolated from the neighbouring loads.

A load may have fewer realizations than another one. Realizations that only other loads have improve
its mean as far as rises at both loads are correlated: the means at all loads are estimated together
by generalized least squares, with the correlation that the realizations themselves show.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri, stdtrit

from pipeline.answers.case_results import CaseResults
from pipeline.answers.error import bounds_along_velocity, position_limit
from pipeline.answers.field import Field
from pipeline.constants import CORRELATION_LENGTHS
from pipeline.sweep.case import Conditions
from tribo.thermal.quantiles import GROUPS
from tribo.types import Array, Indices, Mask

_BOUND = 0.975  # quantile of Student's t whose two sides bound 95 %
_LEAST_MISFIT = 1e-9  # of equal realizations, in place of 0, in squares of the deviation
_MAX_FREEDOM = GROUPS - 1.0  # degrees of freedom of the estimate from one realization, at most


class RealizationMean(NamedTuple):
    """ln(rise) of a specimen by its realizations, at points (n_load, n_velocity)."""

    offset: Array  # ln(rise) of the specimen minus that of its first realization
    bound: Array  # 95 % bound of the error by the choice of realizations
    deviation: Array  # standard deviation of a realization
    correlation: Array  # of ln(rise) of realizations between loads (n_load, n_load)
    covariance: Array  # of the errors of `offset` between loads (n_load, n_load), over `deviation`²

    def contrast_bound(self, rows: Indices, x: Array) -> Array:
        """Bound of the error of y − chord (n,) at ln(load) `x` of `rows`, by their realizations.

        The chord is that of the two neighbouring rows; the bound is 0 at both ends.
        """
        variance = np.diag(self.covariance)[rows]
        scale = np.median(self.bound, axis=1)[rows] / np.sqrt(variance)
        contrasts = np.zeros((len(rows), len(rows)))
        for k in range(1, len(rows) - 1):
            fraction = (x[k] - x[k - 1]) / (x[k + 1] - x[k - 1])
            contrasts[k, k - 1 : k + 2] = fraction - 1, 1.0, -fraction
        contrasts *= scale
        covariance = self.covariance[np.ix_(rows, rows)]
        return np.sqrt(np.diag(contrasts @ covariance @ contrasts.T))


@dataclass(frozen=True, eq=False)
class Specimen:
    """The specimen of a case, the differences of its realizations, and warnings of its points."""

    field: Field  # ln(rise) [K]
    # ln(rise) of each realization minus that of the first one (m, n_load, n_velocity); NaN at loads
    # where the realization has no point.
    differences: Array
    mean: RealizationMean
    flags: Indices  # sums of `WarningKind` codes (n_load, n_velocity)
    durations: Array  # times of loading [s]
    is_highest: bool  # True if the highest temperature governs, that of the hottest realization
    # Degrees of freedom of the deviation that one realization states (n_load,); 0 if unknown.
    freedom: Array
    position_limit: float = 0.0  # largest error of a rise by positions of the disk

    @property
    def realizations(self) -> Indices:
        """Number of realizations with a point at each load (n_load,)."""
        return np.asarray(np.isfinite(self.differences[..., 0]).sum(axis=0))

    @functools.cached_property
    def bounds_along_velocity(self) -> list[Array]:
        """Bounds of interpolation errors between velocities, for each of the field's curves."""
        return bounds_along_velocity(self)

    def offset_at(self, load: float, velocity: float) -> float:
        """ln(rise) minus that of the first realization; beyond the points, that of the nearest."""
        field = self.field
        offsets = [np.interp(velocity, field.velocities, row) for row in self.mean.offset]
        return float(np.interp(math.log(load), np.log(field.loads), offsets))


def specimen_of(case: CaseResults, conditions: Conditions) -> Specimen:
    """The specimen of a case."""
    usable = case.usable_realizations
    y = case.log_rises(conditions)[usable]
    sampling = _rms_over_realizations(case.sampling(conditions)[usable])
    freedom = case.sampling_freedom[usable].min(axis=(0, 2), initial=_MAX_FREEDOM)
    kinds = np.bitwise_or.reduce(case.warning_flags[usable], 0)
    durations = case.durations[usable].max(axis=0)
    is_highest = conditions.critical_area_fraction == 0
    specimen = merge_realizations(
        case.loads, case.velocities, y, sampling, kinds, durations, is_highest, freedom
    )
    return replace(specimen, position_limit=position_limit(case.sweep))


def merge_realizations(
    loads: Array, velocities: Array, y: Array, sampling: Array, flags: Indices, durations: Array,
    is_highest: bool = False, freedom: Array | float = _MAX_FREEDOM,
) -> Specimen:  # fmt: skip
    """Specimen from ln(rise) `y` of realizations (m, n_load, n_velocity), NaN without a result.

    It has the highest rise if `is_highest`, otherwise the mean. `freedom` (n_load,) are the degrees
    of freedom of `sampling`.
    """
    freedom = np.broadcast_to(freedom, loads.shape)
    level, filled = y[0], [np.zeros_like(y[0])]
    for log_rises in y[1:]:
        filled.append(_fill_differences(log_rises - y[0], loads))
        level = np.where(np.isnan(level), log_rises - filled[-1], level)
    has_point = np.asarray(np.isfinite(y).any(axis=2))
    has_point[0] = has_point.any(axis=0)
    is_single = _is_single_between_several(has_point)
    is_counted = has_point & ~is_single
    differences = np.where(is_counted[..., None], np.array(filled), np.nan)
    mean = mean_of_realizations(loads, differences, sampling, freedom, is_highest)
    offset = _interpolate_loads(loads, mean.offset, np.asarray(is_counted.any(axis=0)))
    plane = np.where(is_single[:, None], np.nan, level + offset)
    field = Field(loads, velocities, plane)
    mean = mean._replace(offset=offset)
    return Specimen(field, differences, mean, flags, durations, is_highest, freedom)


def _rms_over_realizations(sampling: Array) -> Array:
    """Root mean square over realizations; where all are NaN, that of the nearest velocity."""
    is_known = np.isfinite(sampling)
    squares, count = np.square(np.where(is_known, sampling, 0.0)).sum(axis=0), is_known.sum(axis=0)
    with np.errstate(invalid="ignore"):
        return _fill_from_nearest_velocity(np.sqrt(squares / count))


def _fill_from_nearest_velocity(values: Array) -> Array:
    """Values (n_load, n_velocity); NaN is replaced by the value of the nearest velocity."""
    columns = np.arange(values.shape[1])
    is_known = np.isfinite(values)[:, None, :]
    distance = np.where(is_known, np.abs(columns[:, None] - columns), np.inf)
    return np.take_along_axis(values, distance.argmin(axis=-1), axis=1)


def _fill_differences(difference: Array, loads: Array) -> Array:
    """Differences from the first realization, filled where one of the two has no point."""
    is_known = np.isfinite(difference)
    if is_known.all():
        return difference
    has_known, nearest = np.asarray(is_known.any(axis=1)), _fill_from_nearest_velocity(difference)
    return np.where(has_known[:, None], nearest, _interpolate_loads(loads, nearest, has_known))


def _interpolate_loads(loads: Array, values: Array, is_known: Mask) -> Array:
    """Values (n_load, n_velocity), interpolated in ln(load) except at the loads `is_known`."""
    if is_known.all():
        return values
    if not is_known.any():
        return np.zeros_like(values)
    x = np.log(loads)
    return np.transpose([np.interp(x, x[is_known], column) for column in values[is_known].T])


def _is_single_between_several(has_point: Mask) -> Mask:
    """True at loads (n_load,) with one realization, between loads with several."""
    counts, rows = has_point.sum(axis=0), np.arange(has_point.shape[1])
    several = np.flatnonzero(counts > 1)
    first, last = several[[0, -1]] if several.size else (0, 0)
    return np.asarray((counts == 1) & (first < rows) & (rows < last))


def mean_of_realizations(
    loads: Array, differences: Array, sampling: Array, freedom: Array, is_highest: bool
) -> RealizationMean:
    """Mean of realizations; the highest of them if the highest temperature governs.

    Parameters
    ----------
    loads : ndarray, shape (n_load,)
        Loads [N].
    differences : ndarray, shape (m, n_load, n_velocity)
        ln(rise) of each realization minus that of the first one; NaN at loads without a point.
    sampling : ndarray, shape (n_load, n_velocity)
        Deviation of realizations that one of them states; NaN if unknown.
    freedom : ndarray, shape (n_load,)
        Degrees of freedom of this statement; 0 if the deviation is unknown.
    is_highest : bool
        True if the highest temperature governs.

    Examples
    --------
    Two of four realizations at 100 N are simulated at 200 N, too. At 100 N they are hotter than
    the mean of all four, so the specimen at 200 N is less hot than these two:

    >>> lifts = np.array([[0.0, 0.0], [0.02, 0.02], [-0.05, np.nan], [-0.07, np.nan]])[..., None]
    >>> sampling = np.full((2, 1), 0.04)
    >>> loads = np.array([100.0, 200.0])
    >>> mean = mean_of_realizations(loads, lifts, sampling, np.array([7.0, 7.0]), False)
    >>> mean.offset.ravel().round(4).tolist()
    [-0.025, -0.008]
    """
    has_point = np.isfinite(differences)
    count = has_point[..., :1].sum(axis=0)  # (n_load, 1)
    known = np.where(has_point, differences, 0.0)
    offset = known.sum(axis=0) / np.maximum(count, 1)
    squares = np.square(np.where(has_point, differences - offset, 0.0)).sum(axis=0)
    scaled_sampling = _scale_to_spread(squares, count, sampling, freedom[:, None])
    deviation, student_t = _deviation(count, squares, scaled_sampling, freedom[:, None])
    if is_highest:
        offset = np.where(has_point, differences, -np.inf).max(axis=0)
        all_ones, bound = np.ones((len(loads), len(loads))), student_t * deviation
        return RealizationMean(offset, bound, deviation, correlation=all_ones, covariance=all_ones)
    correlation, covariance = np.eye(len(loads)), np.diag(1 / np.maximum(count[:, 0], 1))
    scale = np.median(deviation, axis=1)[:, None]
    rows = np.flatnonzero((count[:, 0] > 0) & (scale[:, 0] > 0))
    if rows.size:
        scaled, among_rows = differences[:, rows] / scale[rows], np.ix_(rows, rows)
        correlation = _correlation(loads, rows, scaled)
        mean, covariance[among_rows], _ = _generalized_least_squares(
            correlation[among_rows], scaled
        )
        offset[rows] = scale[rows] * mean
    bound = student_t * deviation * np.sqrt(np.diag(covariance))[:, None]
    return RealizationMean(offset, bound, deviation, correlation, covariance)


def _correlation(loads: Array, rows: Indices, scaled: Array) -> Array:
    """Correlation of ln(rise) of realizations between loads (n_load, n_load).

    It is exp(−|ln(load ratio)|/length), averaged over `CORRELATION_LENGTHS` by the restricted
    likelihood of the realizations `scaled` (m, k, n_velocity) at the loads with indices `rows`.
    """
    distance = np.abs(np.subtract.outer(np.log(loads), np.log(loads)))
    matrices = [np.exp(-distance / length) for length in CORRELATION_LENGTHS]
    among_rows = np.ix_(rows, rows)
    log_likelihood = np.array(
        [_generalized_least_squares(matrix[among_rows], scaled)[2] for matrix in matrices]
    )
    weights = np.exp(log_likelihood - log_likelihood.max())
    return np.asarray(np.tensordot(weights / weights.sum(), matrices, 1))


def _generalized_least_squares(correlation: Array, scaled: Array) -> tuple[Array, Array, float]:
    """Mean of realizations `scaled` (m, k, n_velocity) at k loads, by their correlation (k, k).

    Returns the mean, its covariance (k, k) and the restricted ln(likelihood) of the correlation,
    whose scale is free.
    """
    known, values = np.isfinite(scaled[..., 0]), np.nan_to_num(scaled)
    patterns, inverse, counts = np.unique(known, axis=0, return_inverse=True, return_counts=True)
    precisions = np.array([precision_of(correlation, pattern) for pattern in patterns])
    weighted = precisions[inverse.ravel()] @ values
    covariance = np.linalg.inv(np.tensordot(counts, precisions, 1))
    mean = covariance @ weighted.sum(axis=0)
    freedom = int(known.sum()) - len(mean)
    squares = ((values * weighted).sum() - (mean * weighted.sum(axis=0)).sum()) / values.shape[2]
    misfit = freedom * math.log(max(squares, _LEAST_MISFIT) / freedom) if freedom else 0.0
    unknown = np.eye(len(mean)) * ~patterns[:, None]  # 1 on the diagonal leaves determinants alone
    log_determinants = counts @ np.linalg.slogdet(precisions + unknown)[1]
    log_determinants += np.linalg.slogdet(covariance)[1]
    return mean, covariance, float(log_determinants - misfit) / 2


def precision_of(correlation: Array, known: Mask) -> Array:
    """Inverse of the correlation (k, k) among `known` loads (k,); 0 at the others."""
    precision, among_known = np.zeros_like(correlation), np.ix_(known, known)
    precision[among_known] = np.linalg.inv(correlation[among_known])
    return precision


def _scale_to_spread(squares: Array, count: Indices, sampling: Array, freedom: Array) -> Array:
    """Deviation that one realization states, scaled by the ratio of the observed spread to it.

    All loads share this ratio, because their realizations are the same surfaces.
    """
    variance = np.square(sampling)
    observed = np.where(variance > 0, np.maximum(count - 1, 0), 0)
    ratio = np.divide(squares, variance, out=np.zeros_like(squares), where=variance > 0).sum(axis=0)
    ratio, max_observed = ratio / np.maximum(observed.sum(axis=0), 1), observed.max(axis=0)
    total_freedom = np.maximum(freedom + max_observed, 1)
    return np.asarray(sampling * np.sqrt((freedom + max_observed * ratio) / total_freedom))


def _deviation(count: Any, squares: Any, sampling: Any, freedom: Any) -> tuple[Array, Array]:
    """Standard deviation of a realization, and the quantile of Student's t of its bound."""
    prior_freedom = np.where(np.isnan(sampling), 0, freedom)
    total_freedom = prior_freedom + count - 1
    total_squares = prior_freedom * np.nan_to_num(sampling) ** 2 + squares
    deviation = np.sqrt(total_squares / np.where(total_freedom > 0, total_freedom, np.nan))
    return deviation, np.asarray(stdtrit(total_freedom, _BOUND))


def realizations_share(count: Any, is_highest: bool, freedom: Array) -> Array:
    """Bound of `count` realizations over the deviation of one; `freedom` is that of one alone."""
    bound = stdtrit(freedom - 1 + count, _BOUND)
    return np.asarray(bound / (1.0 if is_highest else np.sqrt(count)))


def least_variance_share(count: Any, freedom: Any) -> Array:
    """Lower 97.5 % bound of the variance of realizations over the estimate from `count` of them.

    `freedom` are the degrees of freedom of the estimate from one of them.

    Examples
    --------
    >>> least_variance_share(np.array([1, 16, 256]), 7.0).round(2).tolist()
    [0.44, 0.6, 0.85]
    """
    total_freedom = freedom + np.asarray(count) - 1
    return np.asarray(total_freedom / chdtri(total_freedom, 1 - _BOUND))
