"""Which points the boundary of a scene needs next, until its total error is below a goal.

The search uses the same rises and errors as the answers do. It first finds the crossings of the
first realization along velocity, at as many loads as are needed to interpolate the others. Where
the velocities of the sweep are too far apart about a crossing, the sweep gets a further one. Then
further realizations follow, with one point each near the crossing. They are planned for all loads
together, because a realization at one load improves the means at the others.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pipeline.answers.error import (
    INTERPOLATION,
    POSITIONS,
    PRESET,
    SURFACE,
    exponents,
    rise_errors,
    velocity_errors,
)
from pipeline.answers.specimen import (
    Specimen,
    least_variance_share,
    precision_of,
    realizations_share,
)
from pipeline.constants import CROSSING_BUDGET, LOAD_BUDGET, POSITION_SHARE, VELOCITY_BUDGET
from pipeline.run.line_search import Line
from tribo.types import Array, Indices, Mask

MOST_REALIZATIONS = 256
_SLOPE = -0.8  # first guess of the slope of ln(critical velocity) over ln(load)
_MIN_DISTANCE = 0.02  # between a further velocity and those of the sweep, in ln(velocity)
_GOLDEN = (5**0.5 - 1) / 2  # whose multiples, modulo 1, are evenly distributed
_TIME_EXPONENT = 0.5  # of the time of a point over its load
_MAX_FAILED = 3  # failed points of a load without a done one, after which its others are omitted


class PointIndex(NamedTuple):
    """A point of a scene by its indices."""

    realization: int
    load: int
    velocity: int


class Goal(NamedTuple):
    """Error of the critical velocity to reach, and the realizations that may be simulated."""

    accuracy: float  # relative, a bound at 95 %
    realizations: int = MOST_REALIZATIONS  # available
    counts_surface: bool = True  # False if the goal excludes the error by surface sampling


@dataclass(frozen=True, eq=False)
class Search:
    """Search of the points that a goal still needs in one scene.

    Attributes
    ----------
    specimen : Specimen
        The scene's specimen, as in answers.
    limit : float
        ln(allowable rise), above which wear is severe.
    preset_error : float or None
        Relative error of critical velocities due to the preset.
    first : ndarray, shape (n_load, n_velocity)
        ln(rise/limit) of the first realization, plus the offset of the specimen from it; NaN where
        it is unknown.
    tried : ndarray of bool, shape (realizations, n_load, n_velocity)
        Points that are done or failed.
    goal : Goal
        Error to reach.
    """

    specimen: Specimen
    limit: float
    preset_error: float | None
    first: Array
    tried: Mask
    goal: Goal

    @property
    def loads(self) -> Array:
        """Loads of the sweep [N]."""
        return self.specimen.field.loads

    @property
    def velocities(self) -> Array:
        """Velocities of the sweep above 0 [m/s]."""
        return self.specimen.field.velocities

    @cached_property
    def critical(self) -> Array:
        """Critical velocities [m/s] (n_load,); NaN at a load without a crossing."""
        levels = np.full(len(self.loads), self.limit)
        return self.specimen.field.along_velocity(self.loads, levels).critical

    @cached_property
    def errors(self) -> Array:
        """Relative errors of `critical` by part (5, n_load), see `velocity_errors`."""
        field = self.specimen.field
        crossings = field.at(self.loads, self.critical)
        parts = rise_errors(self.specimen, self.preset_error, crossings)
        return velocity_errors(field, parts, self.loads, self.critical)

    @cached_property
    def _has_realization(self) -> Mask:
        """True where an available realization has a point that is done or failed (m, n_load)."""
        further = max(self.goal.realizations - len(self.tried), 0)
        return np.pad(self.tried.any(axis=2), ((0, further), (0, 0)))

    @cached_property
    def error_budget(self) -> Array:
        """Error that the preset leaves for interpolation and realizations (n_load,)."""
        preset = self.errors[PRESET]
        preset = np.where(np.isnan(preset), self.preset_error or 0.0, preset)
        fixed = 0.0 if self.goal.counts_surface else np.nan_to_num(self.errors[POSITIONS])
        return np.sqrt(np.maximum(self.goal.accuracy**2 - preset**2 - fixed**2, 0.0))

    @property
    def reducible(self) -> Array:
        """Part of the error that further points reduce (n_load,); NaN without a crossing."""
        by_realizations = [POSITIONS, SURFACE] if self.goal.counts_surface else []
        parts = [INTERPOLATION, *by_realizations]
        return np.asarray(np.sqrt(np.square(self.errors[parts]).sum(axis=0)))

    def ask(self) -> tuple[list[PointIndex], list[float]]:
        """Points to compute next, or velocities [m/s] that the sweep needs before any.

        Both are empty if the goal is reached or cannot be reached.
        """
        last = len(self.loads) - 1
        has_points, has_several = (self._has_realization.sum(axis=0) > n for n in (0, 1))
        loads: set[int] = set()
        # The other loads may be interpolated from these.
        for added in ({last}, {0, last // 2}, {last // 4, 3 * last // 4}):
            loads |= added
            if points := self._first_realization_points(loads):
                return points, []
        loads |= {*np.flatnonzero(has_several).tolist()}
        if points := self._first_realization_points({*np.flatnonzero(has_points).tolist()}):
            return points, []
        while True:
            if points := self._first_realization_points(loads):
                return points, []
            if velocities := self._missing_velocities(loads):
                return [], velocities
            if points := self._further_realization_points(loads):
                return points, []
            if self.is_out_of_reach(loads) or not (added := self._missing_loads(loads)):
                return [], []
            loads |= added

    def _missing_velocities(self, loads: set[int]) -> list[float]:
        """Critical velocities of the loads at which the sweep's velocities are too far apart.

        There the interpolation error requires many realizations, or makes the goal unreachable.
        """
        share = CROSSING_BUDGET if self.goal.counts_surface else 1.0
        velocities = set[float]()
        for load in loads:
            critical, error = self.critical[load], self.errors[INTERPOLATION, load]
            is_far = (
                self._lines[load][0].has_crossing and not error <= share * self.error_budget[load]
            )
            if is_far and np.isfinite(critical):
                rounded = float(f"{critical:.3g}")
                if np.abs(np.log(self.velocities / rounded)).min() > _MIN_DISTANCE:
                    velocities.add(rounded)
        return sorted(velocities)

    @cached_property
    def _lines(self) -> list[tuple[Line, Indices]]:
        """ln(rise/limit) of the specimen along each load, and the indices of its velocities."""
        lines, tried = [], self.tried[0]
        for log_ratios, failed in zip(self.first, tried & np.isnan(self.first), strict=True):
            is_given_up = failed.sum() >= _MAX_FAILED and not np.isfinite(log_ratios).any()
            columns = np.flatnonzero(~failed & (not is_given_up))
            lines.append((Line(np.log(self.velocities[columns]), log_ratios[columns]), columns))
        return lines

    def _first_realization_points(self, loads: set[int]) -> list[PointIndex]:
        """Next point of the first realization at each load that still needs one."""
        points, tolerance = [], VELOCITY_BUDGET * self.error_budget
        for load in sorted(loads):
            line, columns = self._lines[load]
            guess = 0.0 if line.known.size else self._guess_crossing(load)
            if len(columns) and (step := line.next_velocity(guess, tolerance[load])) is not None:
                points.append(PointIndex(0, load, int(columns[step])))
        return points

    def _guess_crossing(self, load: int) -> float:
        """ln(velocity) at which to begin at a load, from the crossings at the nearest two loads."""
        x = np.log(self.loads)
        crossings = {
            k: line.crossing for k, (line, _) in enumerate(self._lines) if line.has_crossing
        }
        if not crossings:
            return float(np.log(self.velocities).mean())
        nearest = sorted(crossings, key=lambda index: abs(x[index] - x[load]))[:2]
        distance = x[nearest[-1]] - x[nearest[0]]
        slope = (crossings[nearest[-1]] - crossings[nearest[0]]) / distance if distance else _SLOPE
        return float(crossings[nearest[0]] + slope * (x[load] - x[nearest[0]]))

    def _missing_loads(self, loads: set[int]) -> set[int]:
        """Middle load of each interval between `loads` whose interpolation error is too large."""
        missing, x = set[int](), np.log(self.loads)
        for low, high in itertools.pairwise(sorted(loads)):
            inner = np.arange(low + 1, high)
            lines = [self._lines[end][0] for end in (low, high)]
            differ = len({(line.is_severe, line.has_crossing) for line in lines}) > 1
            errors = np.fmax(self.errors[INTERPOLATION] / LOAD_BUDGET, self.reducible)[inner]
            exceeds = ~(errors <= self.error_budget[inner])  # True also if unknown
            if inner.size and (differ or (lines[0].has_crossing and exceeds.any())):
                distance = np.abs(x[inner] - (x[low] + x[high]) / 2)
                missing.add(int(inner[np.argmin(distance)]))
        return missing

    def is_out_of_reach(self, loads: set[int]) -> bool:
        """True if other errors, or too few realizations, exclude the goal at one of `loads`."""
        crossing = [
            load
            for load in loads
            if np.isfinite(self.critical[load]) and self.specimen.realizations[load] > 1
        ]
        removed = [POSITIONS, SURFACE] if self.goal.counts_surface else [SURFACE]
        other_errors = np.sqrt(
            np.square(np.delete(self.errors[:, crossing], removed, axis=0)).sum(axis=0)
        )
        if not (other_errors < self.goal.accuracy).all():
            return True
        specimen, available = self.specimen, self.goal.realizations
        freedom = specimen.freedom[crossing]
        least_bounds = (
            realizations_share(available, specimen.is_highest, freedom)
            * np.sqrt(least_variance_share(specimen.realizations[crossing], freedom))
            * np.diag(self._deviations)[crossing]
        )
        is_short = least_bounds > np.sqrt(self.goal.accuracy**2 - other_errors**2)
        has_more = self._has_realization[:, crossing].sum(axis=0) < available
        return self.goal.counts_surface and bool((is_short & has_more).any())

    @cached_property
    def _deviations(self) -> Array:
        """Error of each critical velocity by that of each load (n_load, n_load), per its bound.

        The bound at a load is in units of the deviation of a realization, and includes the error by
        positions of the disk. An unknown deviation counts as 0, so that it leaves the errors of
        other loads known.
        """
        field, point = self.specimen.field, (self.loads, self.critical)
        deviation = self.specimen.mean.deviation
        if self.specimen.position_limit:
            deviation = math.hypot(1, POSITION_SHARE) * deviation
        only = np.eye(len(self.loads))[..., None] * np.nan_to_num(deviation)
        crossings = field.at(*point)
        errors = [crossings.bilinear(deviation) for deviation in only]
        return np.asarray(np.transpose(errors) / exponents(field, *point)[:, None])

    def _further_realization_points(self, loads: set[int]) -> list[PointIndex]:
        """Points of further realizations near the crossings, a part of those planned."""
        if self.is_out_of_reach(loads):
            return []
        planned, counts = self._plan(loads), self._has_realization.sum(axis=0)
        needed = counts + np.bincount([point.load for point in planned], minlength=len(counts))
        # More realizations give a better plan.
        limit, points = np.maximum(2 * counts + 2, needed // 4), list[PointIndex]()
        for point in planned:
            counts[point.load] += 1
            if counts[point.load] <= limit[point.load]:
                points.append(point)
        return sorted(points)

    @cached_property
    def _squared_budgets(self) -> Array:
        """Squares of the errors that surface sampling may have at each load (n_load,)."""
        return np.asarray(np.square(self.error_budget) - np.square(self.errors[INTERPOLATION]))

    def _plan(self, loads: Iterable[int]) -> list[PointIndex]:
        """Points of further realizations at `loads`, until all errors are below the goal."""
        crossing = np.array([k for k in sorted(loads) if self._lines[k][0].has_crossing], int)
        counts, tried = self.specimen.realizations[crossing], self._has_realization
        if not self.goal.counts_surface:
            min_count, incomplete_rows = self.goal.realizations, crossing
        else:
            # The points of the first realization between loads of several count with a second one.
            # A second one shows how much of the interpolation error is its roughness, and how
            # realizations differ if one does not.
            is_known = self.specimen.freedom[crossing] > 0
            is_enough = is_known & (self._squared_budgets[crossing] > 0)
            is_few = (counts == 0) | ((counts == 1) & ~is_enough)
            min_count, incomplete_rows = min(2, self.goal.realizations), crossing[is_few]
        points = [
            self._point_near_crossing(realization, load)
            for load in incomplete_rows.tolist()
            for realization in np.flatnonzero(~tried[:min_count, load]).tolist()
        ]
        has_deviation = (counts > 0) & (counts + self.specimen.freedom[crossing] > 1)
        if self.goal.counts_surface and has_deviation.any() and not self.specimen.is_highest:
            points += self._useful_points(crossing[has_deviation])
        return points

    def _point_near_crossing(self, realization: int, load: int) -> PointIndex:
        """Point of a further realization at one of the two velocities around the crossing.

        Both are used in proportion to their nearness to the crossing. So the deviations of the
        first realization from a smooth curve at these two velocities cancel in the mean.
        """
        line, columns = self._lines[load]
        position = np.interp(line.crossing, line.x[line.known], np.arange(line.known.size))
        index = int(position + realization * _GOLDEN % 1)
        return PointIndex(realization, load, int(columns[line.known[index]]))

    def _useful_points(self, rows: Indices) -> Iterator[PointIndex]:
        """Points of further realizations at the loads with indices `rows` (k,), until all suffice.

        Each point is the one that lowers the excess of errors over their budgets most per time. Its
        realization is a new one, or has points at other loads.
        """
        mean, known = self.specimen.mean, self._has_realization[:, rows].copy()
        counts, squared_budgets = self.specimen.realizations[rows], self._squared_budgets
        correlation, covariance = (
            mean.correlation[np.ix_(rows, rows)],
            mean.covariance[np.ix_(rows, rows)],
        )
        precisions = np.array([precision_of(correlation, pattern) for pattern in known])
        # Loads that cannot be interpolated well enough get points of their own.
        is_open = squared_budgets > (1 - LOAD_BUDGET**2) * np.square(self.error_budget)
        is_open[rows] = squared_budgets[rows] > 0
        weights = self._deviations[np.ix_(is_open, rows)]
        weights /= np.sqrt(squared_budgets[is_open])[:, None]
        while True:
            share = realizations_share(counts, True, self.specimen.freedom[rows])
            bounds = share * weights
            squares = np.einsum("qi,ij,qj->q", bounds, covariance, bounds)  # 1 at the budget
            # A further load j of a realization adds u uᵀ/s to the precision of the means.
            patterns, first = np.unique(known, axis=0, return_index=True)
            u = np.eye(len(rows)) - precisions[first] @ correlation  # a column for each j
            s = np.diagonal(correlation @ u, axis1=1, axis2=2)
            change = covariance @ u
            scale = np.where(patterns, np.inf, s + (u * change).sum(axis=1))
            later = squares[:, None] - np.square(bounds @ change) / scale[:, None]
            excess = np.maximum(squares - 1, 0.0).sum()
            rates = excess - np.maximum(later - 1, 0.0).sum(axis=1)
            rates /= self.loads[rows] ** _TIME_EXPONENT
            i, j = np.unravel_index(int(rates.argmax()), rates.shape)
            if rates[i, j] <= 0:
                return
            covariance = covariance - np.outer(change[i, :, j], change[i, :, j]) / scale[i, j]
            precisions[first[i]] += np.outer(u[i, :, j], u[i, :, j]) / s[i, j]
            known[first[i], j] = True
            counts[j] += 1
            yield self._point_near_crossing(int(first[i]), int(rows[j]))
