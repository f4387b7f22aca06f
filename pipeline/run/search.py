"""Which points the boundary of a specimen needs next, until its whole error is below a goal.

The first patch is searched along velocity, at as many loads as it takes to interpolate the others.
Then further patches follow, one point each beside the crossing, as many as each load needs. The
search knows only what it was told, which is what it asked for: after a run was killed it asks for
the same points again.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pipeline.analysis.rise_error import INTERPOLATION, SURFACE, velocity_errors
from pipeline.analysis.rises import Rises
from pipeline.analysis.specimen import SWEPT, Alone, Specimen, patches_needed, patches_share
from pipeline.constants import OF_LOADS, OF_POINTS
from pipeline.run.line_search import Line, places_along
from pipeline.sweep.conditions import rise_limit
from tribo import Conditions
from tribo.types import Array, Indices

MOST_PATCHES = 256
_NO_STORE: Any = None  # rises and their errors need none
_UNSURE = 1.3  # by which the surface's part may be smaller than few patches tell
_SLOPE = -0.8  # of ln(critical velocity) over ln(load), for a first guess
_GIVEN_UP = 3  # failed points of a load, if none is done: then its others are not tried
_COLDEST = 1e-9  # rise [K], in place of 0, which has no logarithm
_LEAST_FACTOR = 1e-6  # of friction, in place of 0


class Place(NamedTuple):
    """A point of the search by its indices."""

    patch: int
    load: int
    velocity: int


class Goal(NamedTuple):
    """Error of the critical velocity that is asked for, and what a search can do about it."""

    accuracy: float  # relative, a bound at 95 %
    promised: float  # part of it due to the preset
    patches: int = MOST_PATCHES  # that there are
    counts_surface: bool = True  # False if the choice of patches is left out of the goal
    alone: Alone = SWEPT  # what a patch alone tells of others

    @property
    def left(self) -> float:
        """Error that the preset leaves to patches and to points left out."""
        return math.sqrt(max(self.accuracy**2 - self.promised**2, 0.0))


class Search:
    """Search of the boundary of one specimen: `ask` for points, and `tell` what they gave.

    Parameters
    ----------
    loads, velocities : ndarray
        Loads [N] and velocities above 0 [m/s] that can be computed, ascending.
    conditions : Conditions
        Conditions to judge by.
    goal : Goal
        When to end.

    Examples
    --------
    >>> from pipeline.run.search import Goal, Search
    >>> oil = Conditions(0.1, 298.15, 418.15)
    >>> search = Search(np.array([100.0, 200.0]), np.geomspace(0.5, 4, 10), oil, Goal(0.05, 0.0))
    >>> while batch := search.ask():
    ...     _, load, velocity = np.array(batch).T
    ...     F, V = search.loads[load], search.velocities[velocity]
    ...     rises = 1200 * (F / 150) ** 0.5 * V**0.6
    ...     search.tell(batch, rises, np.full(len(batch), 0.01))
    >>> search.critical.round(2).tolist(), int(search.asked.sum())
    ([1.4, 0.79], 5)
    """

    def __init__(self, loads: Array, velocities: Array, conditions: Conditions, goal: Goal) -> None:
        self.loads, self.velocities = loads, velocities
        self.conditions, self.goal = conditions, goal
        shape = goal.patches, len(loads), len(velocities)
        self.asked = np.zeros(shape, bool)
        self._rises, self._sampling = np.full(shape, math.nan), np.full(shape, math.nan)
        self._flags, self._durations = np.zeros(shape[1:], np.int64), np.zeros(shape[1:])
        self._searched = [len(loads) - 1]  # from the highest load down
        self.patches = 1  # that the load which needs most is thought to need

    def tell(
        self,
        places: Sequence[Place],
        rises: Array,
        sampling: Array,
        flags: Array | int = 0,
        durations: Array | float = 0.0,
    ) -> None:
        """Record points that were asked for, in their order.

        `rises` [K] are per unit friction coefficient, without the effect of velocity on friction,
        NaN where a point failed. `sampling` has the deviations of ln(rise) that points state,
        `flags` their warnings, and `durations` the times of loading [s].
        """
        where = tuple(np.array(places).T)
        self.asked[where] = True
        self._rises[where], self._sampling[where] = np.fmax(rises, _COLDEST), sampling
        self._rises[where] = np.where(np.isnan(rises), math.nan, self._rises[where])
        np.bitwise_or.at(self._flags, where[1:], flags)
        np.maximum.at(self._durations, where[1:], durations)
        for name in ("_specimen", "_lines", "rises", "critical", "errors"):
            self.__dict__.pop(name, None)

    # What is known

    @functools.cached_property
    def _specimen(self) -> Specimen:
        count = max(int(self.asked.any(axis=(1, 2)).sum()), 1)
        y = np.log(self._rises[:count])
        is_highest = self.conditions.criterion.is_highest
        sampling, alone = self._sampling[:count], self.goal.alone
        return Specimen.of(self.loads, self.velocities, y, sampling, is_highest, alone)

    @functools.cached_property
    def rises(self) -> Rises:
        """Rises of the specimen as answers see them once the search has ended."""
        ends = {"load": self.loads, "velocity": self.velocities}
        return Rises(
            loads=self.loads,
            velocities=self.velocities,
            plane=self._specimen.rises,
            surface=self._specimen.error,
            flags=self._flags,
            durations=self._durations,
            is_left_out=~self.asked[0] | self._specimen.is_alone[:, None],
            conditions=self.conditions,
            promised=self.goal.promised,
            ends={name: (float(x[0]), float(x[-1])) for name, x in ends.items()},
            source=_NO_STORE,
        )

    @functools.cached_property
    def critical(self) -> Array:
        """Critical velocities [m/s] (n_load,); NaN at a load without a crossing."""
        return self.rises.turns("velocity", self.loads).critical

    @functools.cached_property
    def errors(self) -> Array:
        """Relative errors of `critical` by cause (4, n_load), see `velocity_errors`."""
        return velocity_errors(self.rises, self.loads, self.critical)

    def reducible(self) -> Array:
        """Part of the error that further points reduce (n_load,); NaN without a crossing."""
        parts = self.errors[
            [INTERPOLATION, SURFACE] if self.goal.counts_surface else [INTERPOLATION]
        ]
        return np.asarray(np.sqrt(np.square(parts).sum(axis=0)))

    def needed(self) -> Array:
        """Patches that each searched load with a crossing needs (n_load,), by what is known.

        It is the number that there are where they do not suffice, and 0 at other loads.
        """
        found = np.zeros(len(self.loads), int)
        for load in self._searched:
            if not np.isfinite(self.critical[load]):
                continue
            if self._specimen.is_alone[load]:
                found[load] = 2  # or its own points do not count
                continue
            count = int(np.isfinite(self._rises[:, load]).any(axis=1).sum())
            surface, between = self.errors[SURFACE, load], self._between(load)
            bound = math.sqrt(max(self.goal.left**2 - between**2, 0.0))
            found[load] = self.goal.patches
            if self.goal.counts_surface and surface > 0:
                found[load] = patches_needed(
                    count,
                    surface / bound if bound else math.inf,
                    self.goal.patches,
                    self._specimen.is_highest,
                    self.goal.alone,
                )
        return found

    def to_come(self) -> int:
        """About how many points further patches take, by what is known."""
        needed, tried = self.needed(), self.asked.any(axis=2).sum(axis=0)
        lacking = np.maximum(needed - tried, 0)[needed > 0]
        more = len(self._loads_between()) if lacking.size else 0
        return int(lacking.sum() + more * (3 + lacking.mean())) if lacking.size else 0

    def best(self) -> tuple[float, int]:
        """Least error that can be reached, and the load where it is largest; NaN if not known."""
        parts = self.errors[:, self._searched].copy()
        counts = np.isfinite(self._rises[:, self._searched]).any(axis=2).sum(axis=0)
        kind = self._specimen.is_highest, self.goal.alone
        shares = [patches_share(n, *kind) for n in (self.goal.patches, counts)]
        sure = np.where(counts < self.goal.patches, _UNSURE, 1.0)
        parts[SURFACE] *= shares[0] / shares[1] / sure if self.goal.counts_surface else 0.0
        counts_own = np.isfinite(self.critical) & ~self._specimen.is_alone
        (known,) = np.nonzero(counts_own[self._searched])
        if not known.size:
            return 0.0, 0
        whole = np.sqrt(np.square(parts[:, known]).sum(axis=0))
        worst = int(np.argmax(whole))
        return float(whole[worst]), self._searched[int(known[worst])]

    def _between(self, load: int) -> float:
        """Error by points left out at a load, and at those beside that are interpolated from it."""
        done = sorted(self._searched)
        place, errors = done.index(load), self.errors[INTERPOLATION]
        low, high = done[max(place - 1, 0)], done[min(place + 1, len(done) - 1)]
        beside = np.nan_to_num(np.append(errors[low + 1 : load], errors[load + 1 : high]))
        widest = float(beside.max(initial=0.0))
        return max(float(errors[load]), min(widest, OF_LOADS * self.goal.left))

    # What is needed next

    def ask(self) -> list[Place]:
        """Points to compute next; empty once the goal is reached, or as near as it can be."""
        steps = self._along_velocity, self._first_loads, self._along_velocity, self._further_patches
        while True:
            for step in steps:
                if batch := step():
                    return batch
            if not (more := self._loads_between()):
                return []
            self._searched += more

    def _first_loads(self) -> list[Place]:
        """Begin with loads from which the others may be interpolated: ends, middle and quarters."""
        last = len(self.loads) - 1
        wanted = {0, last // 2, last} if len(self._searched) == 1 else {last // 4, 3 * last // 4}
        if len(self._searched) < 5:
            self._searched += sorted(wanted - {*self._searched})
        return self._along_velocity()

    @property
    def is_first_patch_done(self) -> bool:
        """True once further patches are to come, and points that these make necessary."""
        return len(self._searched) >= min(5, len(self.loads)) and not self._along_velocity()

    @functools.cached_property
    def _lines(self) -> dict[int, tuple[Line, Indices]]:
        return {}

    def _line(self, load: int) -> tuple[Line, Indices]:
        """ln(rise/limit) of the specimen along a load, and indices of its velocities."""
        if load not in self._lines:
            failed = self.asked[0, load] & np.isnan(rises := self._rises[0, load])
            is_given_up = failed.sum() >= _GIVEN_UP and not np.isfinite(rises).any()
            columns = np.flatnonzero(~failed & (not is_given_up))
            x = np.log(self.velocities[columns])
            at = np.exp(places_along(x)) if len(x) else np.ones(1)
            factor = self.conditions.friction_factor(at)
            friction = np.log(np.maximum(factor, _LEAST_FACTOR))
            heat = (np.log(rises) + self._specimen.apart[load])[columns]
            heat -= math.log(rise_limit(self.conditions))
            self._lines[load] = Line.of_heat(x, heat, friction), columns
        return self._lines[load]

    def _along_velocity(self) -> list[Place]:
        """Points of the first patch, one at each load that still needs some."""
        found, tolerance = [], OF_POINTS * self.goal.left
        for load in self._searched:
            line, columns = self._line(load)
            guess = 0.0 if line.known.size else self._guess(load)
            if len(columns) and (step := line.wanted(guess, tolerance)) is not None:
                found.append(Place(0, load, int(columns[step])))
        return found

    def _guess(self, load: int) -> float:
        """ln(velocity) at which to begin at a load: near the crossings of the loads beside."""
        lines = {one: self._line(one)[0].crossings() for one in self._searched if one != load}
        known = [one for one, crossings in lines.items() if crossings.size]
        if not known:
            return float(np.log(self.velocities).mean())
        x = np.log(self.loads)
        nearest = sorted(sorted(known, key=lambda one: abs(x[one] - x[load]))[:2])
        first = [float(lines[one][0]) for one in nearest]
        slope = (
            (first[-1] - first[0]) / (x[nearest[-1]] - x[nearest[0]])
            if len(nearest) > 1
            else _SLOPE
        )
        return float(first[0] + slope * (x[load] - x[nearest[0]]))

    def _loads_between(self) -> list[int]:
        """Loads to search, too: of each span the load that cannot be interpolated well enough."""
        done, x, found = sorted(self._searched), np.log(self.loads), []
        lines = {one: self._line(one)[0] for one in done}
        for low, high in itertools.pairwise(done):
            if high - low < 2:
                continue
            ends = {(lines[one].is_severe, len(lines[one].crossings())) for one in (low, high)}
            alone = self.errors[INTERPOLATION, low + 1 : high] / OF_LOADS
            errors = np.fmax(alone, self.reducible()[low + 1 : high])
            if len(ends) > 1 or np.isnan(errors).any():
                errors = -np.abs(x[low + 1 : high] - (x[low] + x[high]) / 2)
            elif errors.max() <= self.goal.left:
                continue
            if len(ends) > 1 or lines[low].crossings().size:
                found.append(low + 1 + int(np.argmax(errors)))
        return found

    def _further_patches(self) -> list[Place]:
        """Points of further patches beside the crossings, about as many as each load needs."""
        found, needed = [], self.needed()
        self.patches = int(needed.max(initial=1))
        for load in np.flatnonzero(needed).tolist():
            has = np.isfinite(self._rises[:, load]).any(axis=1)
            known = np.isfinite(self._rises[0, load])
            away = np.abs(self.velocities - self.critical[load])
            column = int(np.argmin(np.where(known, away, math.inf)))
            tried = self.asked[:, load].any(axis=1)
            # The number that is needed is known the better, the more there are.
            wanted = min(needed[load], max(2 * has.sum() + 2, needed[load] // 4)) - has.sum()
            patches = np.flatnonzero(~tried)[:wanted]
            found += [Place(patch, load, column) for patch in patches.tolist()]
        return found
