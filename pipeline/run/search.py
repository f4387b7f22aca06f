"""Which points the boundary of a scene needs next, until its total error is below a goal.

The search uses the same rises and errors as the answers do. It first finds the crossings of the
first realization along velocity, at as many loads as are needed to interpolate the others. Where
the velocities of the sweep are too far apart about a crossing, the sweep gets a further one. Then
each load gets as many further realizations as it needs, with one point each near the crossing.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pipeline.answers.error import (
    INTERPOLATION,
    PRESET,
    SURFACE,
    exponents,
    interpolation_errors,
    rise_errors,
    velocity_errors,
)
from pipeline.answers.specimen import (
    Specimen,
    least_variance_share,
    realizations_needed,
    realizations_share,
)
from pipeline.constants import GAP_SHARE, LOAD_SHARE, VELOCITY_SHARE
from pipeline.run.line_search import Line
from tribo.types import Array, Indices, Mask

MOST_REALIZATIONS = 256
_SLOPE = -0.8  # first guess of the slope of ln(critical velocity) over ln(load)
_MIN_DISTANCE = 0.005  # between a further velocity and those of the sweep, in ln(velocity)
_MAX_FAILED = 3  # failed points of a load without a done one, after which its others are omitted


class Place(NamedTuple):
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
    promised : float or None
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
    promised: float | None
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
        """Relative errors of `critical` by part (4, n_load), see `velocity_errors`."""
        parts = rise_errors(self.specimen, self.promised, self.loads, self.critical)
        return velocity_errors(self.specimen.field, parts, self.loads, self.critical)

    @property
    def _has_realization(self) -> Mask:
        """True where a realization has a point of a load that is done or failed (m, n_load)."""
        return np.asarray(self.tried.any(axis=2))

    @cached_property
    def error_budget(self) -> Array:
        """Error that the preset leaves for interpolation and surface sampling (n_load,)."""
        preset = self.errors[PRESET]
        preset = np.where(np.isnan(preset), self.promised or 0.0, preset)
        return np.sqrt(np.maximum(self.goal.accuracy**2 - preset**2, 0.0))

    @property
    def reducible(self) -> Array:
        """Part of the error that further points reduce (n_load,); NaN without a crossing."""
        parts = [INTERPOLATION, SURFACE] if self.goal.counts_surface else [INTERPOLATION]
        return np.asarray(np.sqrt(np.square(self.errors[parts]).sum(axis=0)))

    def next_places(self) -> list[Place]:
        """Points to compute next; empty if the goal is reached or cannot be reached."""
        return self._next_points[0]

    def next_velocities(self) -> list[float]:
        """Velocities [m/s] to add to the sweep; if there are any, `next_places` is empty."""
        return self._next_points[1]

    @cached_property
    def _next_points(self) -> tuple[list[Place], list[float]]:
        last = len(self.loads) - 1
        has_points, has_several = (self._has_realization.sum(axis=0) > n for n in (0, 1))
        loads: set[int] = set()
        # The other loads may be interpolated from these.
        for added in ({last}, {0, last // 2}, {last // 4, 3 * last // 4}):
            loads |= added
            if places := self._first_realization_places(loads):
                return places, []
        loads |= {*np.flatnonzero(has_several).tolist()}
        if places := self._first_realization_places({*np.flatnonzero(has_points).tolist()}):
            return places, []
        while True:
            if places := self._first_realization_places(loads):
                return places, []
            if velocities := self._missing_velocities(loads):
                return [], velocities
            if places := self._realization_places(loads) or self._improving_places(loads):
                return places, []
            if self.is_out_of_reach(loads) or not (added := self._missing_loads(loads)):
                return [], []
            loads |= added

    def _missing_velocities(self, loads: set[int]) -> list[float]:
        """Critical velocities of the loads at which the sweep's velocities are too far apart.

        There the interpolation error requires many realizations, or makes the goal unreachable.
        """
        share = GAP_SHARE if self.goal.counts_surface else 1.0
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

    def _first_realization_places(self, loads: set[int]) -> list[Place]:
        """Next point of the first realization at each load that still needs one."""
        places, tolerance = [], VELOCITY_SHARE * self.error_budget
        for load in sorted(loads):
            line, columns = self._lines[load]
            guess = 0.0 if line.known.size else self._guess_crossing(load)
            if len(columns) and (step := line.next_velocity(guess, tolerance[load])) is not None:
                places.append(Place(0, load, int(columns[step])))
        return places

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

    def _improving_places(self, loads: set[int]) -> list[Place]:
        """Points of the first realization that improve the interpolation between `loads`.

        They are at loads whose error along velocity is the largest part of that error.
        """
        places = set[Place]()
        for low, high in itertools.pairwise(sorted(loads)):
            inner = np.arange(low + 1, high)
            inner = inner[np.isfinite(self.critical[inner])]
            errors = np.fmax(self.errors[INTERPOLATION] / LOAD_SHARE, self.reducible)[inner]
            if not inner.size or (errors <= self.error_budget[inner]).all():
                continue
            load = int(inner[np.argmax(np.nan_to_num(errors, nan=np.inf))])
            point = self.loads[load : load + 1], self.critical[load : load + 1]
            along, between = interpolation_errors(self.specimen, *point)
            side = int(np.argmax(along[:, 0]))
            if along[side, 0] > between[0]:
                places |= self._nearest_place((low, high)[side], float(point[1][0]))
        return sorted(places)

    def _nearest_place(self, load: int, velocity: float) -> set[Place]:
        """Point of the first realization nearest a velocity; none if tried, or if all failed."""
        column = int(np.argmin(np.abs(np.log(self.velocities / velocity))))
        is_excluded = self.tried[0, load, column] or not self._lines[load][0].known.size
        return set() if is_excluded else {Place(0, load, column)}

    def _missing_loads(self, loads: set[int]) -> set[int]:
        """Middle load of each interval between `loads` whose interpolation error is too large."""
        missing, x = set[int](), np.log(self.loads)
        for low, high in itertools.pairwise(sorted(loads)):
            inner = np.arange(low + 1, high)
            lines = [self._lines[end][0] for end in (low, high)]
            differ = len({(line.is_severe, line.has_crossing) for line in lines}) > 1
            errors = np.fmax(self.errors[INTERPOLATION] / LOAD_SHARE, self.reducible)[inner]
            exceeds = ~(errors <= self.error_budget[inner])  # True also if unknown
            if inner.size and (differ or (lines[0].has_crossing and exceeds.any())):
                distance = np.abs(x[inner] - (x[low] + x[high]) / 2)
                missing.add(int(inner[np.argmin(distance)]))
        return missing

    def needed(self, loads: set[int]) -> Array:
        """Estimated number of realizations that `loads` with a crossing need (n_load,); else 0."""
        counts, budgets = np.zeros(len(self.critical), int), self._sampling_budget(loads)
        for load in loads:
            if not self._lines[load][0].has_crossing:
                continue
            if self.specimen.realizations[load] == 0:
                counts[load] = 2  # with one, the points of the first realization do not count
            elif not self.goal.counts_surface:
                counts[load] = self.goal.realizations
            elif budgets[load] > 0 and np.isfinite(self.errors[SURFACE, load]):
                counts[load] = self._needed_at(load, budgets)
        return counts

    def _sampling_budget(self, loads: set[int]) -> Array:
        """Error allowed for surface sampling at each of `loads` (n_load,); 0 at the others."""
        squares = np.zeros(len(self.critical))
        for load in loads:
            squares[load] = (
                self.error_budget[load] ** 2 - self._interpolation_error(loads, load) ** 2
            )
        return np.sqrt(np.maximum(squares, 0.0))

    def _needed_at(self, load: int, budgets: Array) -> int:
        """Number of realizations that a load needs, if other loads keep to their `budgets`."""
        specimen, mean = self.specimen, self.specimen.mean
        point = self.loads[load : load + 1], self.critical[load : load + 1]
        exponent = exponents(specimen.field, *point).item()
        bound, deviation, shared = (
            specimen.field.bilinear(values, *point).item() / exponent
            for values in (mean.bound, mean.deviation, mean.shared)
        )
        count, kind = int(specimen.realizations[load]), (specimen.is_highest, specimen.jackknife)

        def count_for(error: float, budget: float) -> int:
            return realizations_needed(count, error / budget, 4 * MOST_REALIZATIONS, *kind)

        unshared = count_for(deviation * float(realizations_share(count, *kind)), budgets[load])
        if (other_load := mean.shared_from[load]) < 0:
            return unshared
        reduction = float(np.fmin(1.0, budgets[other_load] / self.errors[SURFACE, other_load]))
        square = budgets[load] ** 2 - (shared * reduction) ** 2
        residual_bound = math.sqrt(bound**2 - shared**2)
        return (
            min(unshared, count_for(residual_bound, math.sqrt(square))) if square > 0 else unshared
        )

    def _interpolation_error(self, loads: set[int], load: int) -> float:
        """Interpolation error at a load, or the largest one at loads interpolated from it.

        The latter does not count if it is too large, because such a load gets its own points.
        """
        ordered, errors = sorted(loads), np.nan_to_num(self.errors[INTERPOLATION])
        position = ordered.index(load)
        low, high = ordered[max(position - 1, 0)], ordered[min(position + 1, len(ordered) - 1)]
        largest = np.append(errors[low + 1 : load], errors[load + 1 : high]).max(initial=0.0)
        is_interpolated = largest <= LOAD_SHARE * self.error_budget[load]
        return max(float(errors[load]), float(largest) if is_interpolated else 0.0)

    def is_out_of_reach(self, loads: set[int]) -> bool:
        """True if other errors, or too few realizations, exclude the goal at one of `loads`."""
        crossing = [
            load
            for load in loads
            if np.isfinite(self.critical[load]) and self.specimen.realizations[load]
        ]
        other_errors = np.sqrt(
            np.square(np.delete(self.errors[:, crossing], SURFACE, axis=0)).sum(axis=0)
        )
        counts = self._has_realization.sum(axis=0)
        is_too_many = (self.needed(loads) * self._min_share > self.goal.realizations) & (
            counts < self.goal.realizations
        )
        is_short = self.goal.counts_surface and is_too_many.any()
        return bool(is_short or not (other_errors < self.goal.accuracy).all())

    @property
    def _min_share(self) -> Array:
        """Least share of the estimated number of realizations that may suffice (n_load,)."""
        return least_variance_share(
            np.maximum(self.specimen.realizations, 1), self.specimen.jackknife
        )

    def _realization_places(self, loads: set[int]) -> list[Place]:
        """Points of further realizations near the crossings, up to the number that a load needs."""
        places = list[Place]()
        if self.is_out_of_reach(loads):
            return places
        tried = self._has_realization
        needed = np.minimum(self.needed(loads), self.goal.realizations)
        for load in np.flatnonzero(needed > tried.sum(axis=0)).tolist():
            count = int(tried[:, load].sum())
            line, columns = self._lines[load]
            distance = np.abs(line.x[line.known] - line.crossing)
            column = int(columns[line.known[np.argmin(distance)]])
            # More realizations give a better estimate of the number needed.
            added = min(needed[load], max(2 * count + 2, needed[load] // 4)) - count
            new = np.flatnonzero(~np.append(tried[:, load], np.zeros(added, bool)))[:added]
            places += [Place(realization, load, column) for realization in new.tolist()]
        return places

    def to_come(self) -> int:
        """Estimated number of points of further realizations."""
        loads = {*np.flatnonzero(self._has_realization[0]).tolist()}
        missing = self.needed(loads) - self._has_realization.sum(axis=0)
        return int(np.maximum(missing, 0).sum())
