"""Which points the boundary of a scene needs next, until its whole error is below a goal.

The search sees what answers see: the rises of all points that a store has, and the same errors. The
first realization is searched along velocity, at as many loads as it takes to interpolate the
others; the sweep gets a velocity at a crossing where its own are too far apart. Then further
realizations follow, one point each beside the crossing, as many as each load needs.
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
from pipeline.constants import OF_GAP, OF_LOADS, OF_POINTS
from pipeline.run.line_search import Line, places_along
from tribo.types import Array, Indices, Mask

MOST_REALIZATIONS = 256
_SLOPE = -0.8  # of ln(critical velocity) over ln(load), for a first guess
_NEAR = 0.005  # least distance of a further velocity from another one, in ln(velocity)
_GIVEN_UP = 3  # failed points of a load, if none is done: then its others are not tried
_LEAST_FACTOR = 1e-6  # of friction, in place of 0


class Place(NamedTuple):
    """A point of a scene by its indices."""

    realization: int
    load: int
    velocity: int


class Goal(NamedTuple):
    """Error of the critical velocity to reach, and what may be computed for it."""

    accuracy: float  # relative, a bound at 95 %
    realizations: int = MOST_REALIZATIONS  # that there are
    counts_surface: bool = True  # False if the choice of realizations is left out of the goal


@dataclass(frozen=True, eq=False)
class Search:
    """Points of one scene that a goal still needs, by all that is known of it.

    Attributes
    ----------
    specimen : Specimen
        What the scene's specimen is known to be, as answers take it.
    limit : float
        ln(limit of the rise), above which wear is severe.
    promised : float or None
        Relative error of critical velocities due to the preset.
    first : ndarray, shape (n_load, n_velocity)
        ln(rise/limit) at friction 1 of the first realization, on the level of the specimen; NaN
        where it is not known.
    tried : ndarray of bool, shape (realizations, n_load, n_velocity)
        Points that are done or failed.
    goal : Goal
        What to reach.
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
        """Relative errors of `critical` by cause (4, n_load), see `velocity_errors`."""
        parts = rise_errors(self.specimen, self.promised, self.loads, self.critical)
        place = self.loads, self.critical
        return velocity_errors(self.specimen.field, parts, self.promised, *place)

    @property
    def _has_realization(self) -> Mask:
        """True where a realization has a point of a load that is done or failed (m, n_load)."""
        return np.asarray(self.tried.any(axis=2))

    @cached_property
    def left(self) -> Array:
        """Error that the preset leaves to realizations and to points left out (n_load,)."""
        preset = self.errors[PRESET]
        preset = np.where(np.isnan(preset), self.promised or 0.0, preset)
        return np.sqrt(np.maximum(self.goal.accuracy**2 - preset**2, 0.0))

    @property
    def reducible(self) -> Array:
        """Part of the error that further points reduce (n_load,); NaN without a crossing."""
        parts = [INTERPOLATION, SURFACE] if self.goal.counts_surface else [INTERPOLATION]
        return np.asarray(np.sqrt(np.square(self.errors[parts]).sum(axis=0)))

    def next_places(self) -> list[Place]:
        """Points to compute next; empty once the goal is reached, or cannot be."""
        return self._next[0]

    def next_velocities(self) -> list[float]:
        """Velocities [m/s] that the sweep needs between its own; then there are no next points."""
        return self._next[1]

    @cached_property
    def _next(self) -> tuple[list[Place], list[float]]:
        last = len(self.loads) - 1
        has_points, has_several = (self._has_realization.sum(axis=0) > n for n in (0, 1))
        loads: set[int] = set()
        # From these the others may be interpolated.
        for more in ({last}, {0, last // 2}, {last // 4, 3 * last // 4}):
            loads |= more
            if found := self._along_velocity(loads):
                return found, []
        loads |= {*np.flatnonzero(has_several).tolist()}
        if found := self._along_velocity({*np.flatnonzero(has_points).tolist()}):
            return found, []
        while True:
            if found := self._along_velocity(loads):
                return found, []
            if more_velocities := self._velocities_between(loads):
                return [], more_velocities
            if found := self._further_realizations(loads) or self._toward_others(loads):
                return found, []
            if self.is_out_of_reach(loads) or not (more := self._loads_between(loads)):
                return [], []
            loads |= more

    def _velocities_between(self, loads: set[int]) -> list[float]:
        """The critical velocities of loads where no velocity of the sweep is near enough.

        There the points around leave an error that makes realizations dear, or the goal
        unreachable.
        """
        share = OF_GAP if self.goal.counts_surface else 1.0
        found = set[float]()
        for load in loads:
            critical, error = self.critical[load], self.errors[INTERPOLATION, load]
            is_far = self._lines[load][0].turns and not error <= share * self.left[load]
            if is_far and np.isfinite(critical):
                rounded = float(f"{critical:.3g}")
                if np.abs(np.log(self.velocities / rounded)).min() > _NEAR:
                    found.add(rounded)
        return sorted(found)

    @cached_property
    def _lines(self) -> list[tuple[Line, Indices]]:
        """ln(rise/limit) of the specimen along each load, and indices of its velocities."""
        found, tried = [], self.tried[0]
        for known, failed in zip(self.first, tried & np.isnan(self.first), strict=True):
            is_given_up = failed.sum() >= _GIVEN_UP and not np.isfinite(known).any()
            columns = np.flatnonzero(~failed & (not is_given_up))
            x = np.log(self.velocities[columns])
            at = np.exp(places_along(x)) if len(x) else np.ones(1)
            factor = self.specimen.field.factor(at)
            friction = np.log(np.maximum(factor, _LEAST_FACTOR))
            found.append((Line.of_heat(x, known[columns], friction), columns))
        return found

    def _along_velocity(self, loads: set[int]) -> list[Place]:
        """Points of the first realization, one at each load that still needs some."""
        found, tolerance = [], OF_POINTS * self.left
        for load in sorted(loads):
            line, columns = self._lines[load]
            guess = 0.0 if line.known.size else self._guess(load)
            if len(columns) and (step := line.wanted(guess, tolerance[load])) is not None:
                found.append(Place(0, load, int(columns[step])))
        return found

    def _guess(self, load: int) -> float:
        """ln(velocity) at which to begin at a load: near the crossings of the loads beside."""
        x = np.log(self.loads)
        known = {k: line.crossings()[0] for k, (line, _) in enumerate(self._lines) if line.turns}
        if not known:
            return float(np.log(self.velocities).mean())
        near = sorted(known, key=lambda one: abs(x[one] - x[load]))[:2]
        run = x[near[-1]] - x[near[0]]
        slope = (known[near[-1]] - known[near[0]]) / run if run else _SLOPE
        return float(known[near[0]] + slope * (x[load] - x[near[0]]))

    def _toward_others(self, loads: set[int]) -> list[Place]:
        """Points of the first realization by which a load between `loads` is interpolated better.

        There the error along the velocities of a load beside is the largest part.
        """
        found = set[Place]()
        for low, high in itertools.pairwise(sorted(loads)):
            inner = np.arange(low + 1, high)
            inner = inner[np.isfinite(self.critical[inner])]
            errors = np.fmax(self.errors[INTERPOLATION] / OF_LOADS, self.reducible)[inner]
            if not inner.size or (errors <= self.left[inner]).all():
                continue
            load = int(inner[np.argmax(np.nan_to_num(errors, nan=np.inf))])
            place = self.loads[load : load + 1], self.critical[load : load + 1]
            along, between = interpolation_errors(self.specimen, *place)
            side = int(np.argmax(along[:, 0]))
            if along[side, 0] > between[0]:
                found |= self._beside((low, high)[side], float(place[1][0]))
        return sorted(found)

    def _beside(self, load: int, velocity: float) -> set[Place]:
        """The first realization's point nearest a velocity, unless it was tried or all failed."""
        column = int(np.argmin(np.abs(np.log(self.velocities / velocity))))
        is_done = self.tried[0, load, column] or not self._lines[load][0].known.size
        return set() if is_done else {Place(0, load, column)}

    def _loads_between(self, loads: set[int]) -> set[int]:
        """Of each span between `loads` the load that cannot be interpolated well enough."""
        found, x = set[int](), np.log(self.loads)
        for low, high in itertools.pairwise(sorted(loads)):
            inner = np.arange(low + 1, high)
            ends = [self._lines[one][0] for one in (low, high)]
            differ = len({(one.is_severe, len(one.crossings())) for one in ends}) > 1
            errors = np.fmax(self.errors[INTERPOLATION] / OF_LOADS, self.reducible)[inner]
            is_far = ~(errors <= self.left[inner])  # or unknown
            if inner.size and (differ or (ends[0].turns and is_far.any())):
                away = np.abs(x[inner] - (x[low] + x[high]) / 2)
                found.add(int(inner[np.argmin(away)]))
        return found

    def needed(self, loads: set[int]) -> Array:
        """Realizations that each of `loads` with a crossing needs (n_load,), by what is known."""
        found, allowed = np.zeros(len(self.critical), int), self._allowed(loads)
        for load in loads:
            if not self._lines[load][0].turns:
                continue
            if self.specimen.realizations[load] == 0:
                found[load] = 2  # or the first realization's own points do not count
            elif not self.goal.counts_surface:
                found[load] = self.goal.realizations
            elif allowed[load] > 0 and np.isfinite(self.errors[SURFACE, load]):
                found[load] = self._needed(load, allowed)
        return found

    def _allowed(self, loads: set[int]) -> Array:
        """Error that is left to the choice of realizations at each of `loads` (n_load,), else 0."""
        found = np.zeros(len(self.critical))
        for load in loads:
            found[load] = self.left[load] ** 2 - self._between(loads, load) ** 2
        return np.sqrt(np.maximum(found, 0.0))

    def _needed(self, load: int, allowed: Array) -> int:
        """Realizations that a load needs, beside those that others are allowed to need."""
        specimen, mean = self.specimen, self.specimen.mean
        place = self.loads[load : load + 1], self.critical[load : load + 1]
        exponent = exponents(specimen.field, *place).item()
        bound, deviation, shared = (
            specimen.field.bilinear(one, *place).item() / exponent
            for one in (mean.bound, mean.deviation, mean.shared)
        )
        count, kind = int(specimen.realizations[load]), (specimen.is_highest, specimen.jackknife)

        def number(error: float, room: float) -> int:
            return realizations_needed(count, error / room, 4 * MOST_REALIZATIONS, *kind)

        alone = number(deviation * float(realizations_share(count, *kind)), allowed[load])
        if (other := mean.shared_from[load]) < 0:
            return alone
        to_come = float(np.fmin(1.0, allowed[other] / self.errors[SURFACE, other]))
        room = allowed[load] ** 2 - (shared * to_come) ** 2
        own = math.sqrt(bound**2 - shared**2)
        return min(alone, number(own, math.sqrt(room))) if room > 0 else alone

    def _between(self, loads: set[int], load: int) -> float:
        """Error by points left out at a load, and at those beside that are interpolated from it.

        Those that cannot be interpolated well enough get points of their own.
        """
        done, errors = sorted(loads), np.nan_to_num(self.errors[INTERPOLATION])
        place = done.index(load)
        low, high = done[max(place - 1, 0)], done[min(place + 1, len(done) - 1)]
        beside = np.append(errors[low + 1 : load], errors[load + 1 : high]).max(initial=0.0)
        is_near = beside <= OF_LOADS * self.left[load]
        return max(float(errors[load]), float(beside) if is_near else 0.0)

    def is_out_of_reach(self, loads: set[int]) -> bool:
        """True if realizations cannot reach the goal at one of `loads`, as far as is known."""
        own = [
            one
            for one in loads
            if np.isfinite(self.critical[one]) and self.specimen.realizations[one]
        ]
        without = np.sqrt(np.square(np.delete(self.errors[:, own], SURFACE, axis=0)).sum(axis=0))
        tried = self._has_realization.sum(axis=0)
        few = (self.needed(loads) * self._least_share > self.goal.realizations) & (
            tried < self.goal.realizations
        )
        is_short = self.goal.counts_surface and few.any()
        return bool(is_short or not (without < self.goal.accuracy).all())

    @property
    def _least_share(self) -> Array:
        """Share of the realizations needed that may suffice, as few tell badly (n_load,)."""
        return least_variance_share(
            np.maximum(self.specimen.realizations, 1), self.specimen.jackknife
        )

    def _further_realizations(self, loads: set[int]) -> list[Place]:
        """Points of further realizations beside the crossings, about as many as each load needs."""
        found = list[Place]()
        if self.is_out_of_reach(loads):
            return found
        tried = self._has_realization
        needed = np.minimum(self.needed(loads), self.goal.realizations)
        for load in np.flatnonzero(needed > tried.sum(axis=0)).tolist():
            has = int(tried[:, load].sum())
            line, columns = self._lines[load]
            away = np.abs(line.x[line.known] - line.crossings()[0])
            column = int(columns[line.known[np.argmin(away)]])
            # The number that is needed is known the better, the more there are.
            wanted = min(needed[load], max(2 * has + 2, needed[load] // 4)) - has
            fresh = np.flatnonzero(~np.append(tried[:, load], np.zeros(wanted, bool)))[:wanted]
            found += [Place(realization, load, column) for realization in fresh.tolist()]
        return found

    def to_come(self) -> int:
        """About how many points further realizations take, by what is known."""
        loads = {*np.flatnonzero(self._has_realization[0]).tolist()}
        lacking = self.needed(loads) - self._has_realization.sum(axis=0)
        return int(np.maximum(lacking, 0).sum())
