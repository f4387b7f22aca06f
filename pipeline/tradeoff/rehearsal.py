"""A search of a boundary on its first patch, and what searches that go on from there would take."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from pipeline.analysis.rise_error import totals, velocity_errors
from pipeline.analysis.specimen import Alone, patches_share
from pipeline.progress import Report
from pipeline.run.goal_preset import simulate_search
from pipeline.run.search import Goal, Place, Search
from pipeline.sweep.sweep import Sweep
from tribo import InputError
from tribo.thermal.sampling import GROUPS
from tribo.types import Array, Indices

_NEAR = 0.03  # error of the crossings by points left out, in the search of the first patch


class Rehearsed(NamedTuple):
    """Points that a run would compute, and the errors of the boundary that it would reach."""

    shape: tuple[int, int]  # loads and velocities of the plane
    points: Array  # number at each load (n_load,)
    patches: int
    errors: Array  # relative, by cause, at the load where the whole is largest (4,)


@dataclass(frozen=True, eq=False)
class FirstPatch:
    """Rises of a scene on its first patch at all points of a sweep, most of them interpolated.

    `rises` [K] are per unit friction coefficient, without the effect of velocity on friction, and
    `sampling` the deviations of ln(rise) from patch to patch; `flags` and `durations` [s] are those
    of the nearest simulated points, all (n_load, n_velocity). `seconds` (n_load,) is the processor
    time of a point.
    """

    search: Search
    rises: Array
    sampling: Array
    flags: Indices
    durations: Array
    seconds: Array

    @classmethod
    def of(cls, sweep: Sweep, report: Report) -> Self:
        """Simulate the points that the boundary of a sweep's first scene needs on one patch."""
        loads, velocities = np.array(sweep.loads), np.array([v for v in sweep.velocities if v > 0])
        alone = Alone.of(sweep.scene)
        goal = Goal(_NEAR, 0.0, patches=1, counts_surface=False, alone=alone)
        search = Search(loads, velocities, sweep._given[0].conditions, goal)
        found = simulate_search(sweep, search, report)
        if not np.isfinite(search.critical).any():
            raise InputError(
                "wear does not turn severe among the loads and velocities of the sweep, so there "
                "is no boundary to compute; give others in [sweep]"
            )
        rises, criterion = search.rises, search.conditions.criterion
        shape, done = rises.plane.shape, np.array([place[1:] for place in found]).T
        at, on = (part.ravel() for part in np.meshgrid(loads, velocities, indexing="ij"))
        away = np.log(at[:, None] / loads[done[0]]), np.log(on[:, None] / velocities[done[1]])
        nearest = np.hypot(*away).argmin(axis=1).reshape(shape)
        times, rows = np.array([seconds for _, seconds in found.values()]), np.unique(done[0])
        return cls(
            search,
            np.exp(rises.y(at, on)).reshape(shape)
            * rises.limit
            / search.conditions.friction_factor(velocities),
            rises.surface / patches_share(1, criterion.is_highest, alone) / alone.factor,
            rises.flags[tuple(done)][nearest],
            rises.durations[tuple(done)][nearest],
            np.interp(loads, loads[rows], [np.median(times[done[0] == row]) for row in rows]),
        )

    def rehearse(self, goal: Goal) -> Rehearsed:
        """A search with a goal, on this patch and others that differ as they are likely to."""
        search = Search(self.search.loads, self.search.velocities, self.search.conditions, goal)
        while batch := search.ask():
            self._tell(search, batch, batch)
        points, patches = search.asked.sum(axis=(0, 2)), search.asked.any(axis=(1, 2)).sum()
        return Rehearsed(self.rises.shape, points, int(patches), self._errors(search))

    def plane(self, rows: Indices, columns: Indices, goal: Goal) -> Rehearsed:
        """All points of a plane of some loads and velocities, on all patches of a goal."""
        loads, velocities = self.search.loads[rows], self.search.velocities[columns]
        search = Search(loads, velocities, self.search.conditions, goal)
        axes = range(goal.patches), range(len(rows)), range(len(columns))
        places = [Place(*one) for one in itertools.product(*axes)]
        whole = [Place(one.patch, rows[one.load], columns[one.velocity]) for one in places]
        self._tell(search, places, whole)
        points = np.zeros(len(self.search.loads), int)
        points[rows] = goal.patches * len(columns)
        return Rehearsed((len(rows), len(columns)), points, goal.patches, self._errors(search))

    def _tell(self, search: Search, places: Sequence[Place], whole: Sequence[Place]) -> None:
        """Tell a search its `places`, which are `whole` by their indices on this patch."""
        patch, *at = np.array(whole).T
        where = tuple(at)
        sampling = self.sampling[where]
        # Deviations of both signs, so that their mean is 0; their size is what is to be expected
        # where the deviation is known by the jackknife alone.
        expected = search.goal.alone.factor * sampling * math.sqrt((GROUPS - 1) / (GROUPS - 3))
        apart = np.where(patch == 0, 0.0, np.where(patch % 2, expected, -expected))
        rises = self.rises[where] * np.exp(apart)
        search.tell(places, rises, sampling, self.flags[where], self.durations[where])

    def _errors(self, search: Search) -> Array:
        """Largest errors of the boundary at the loads of this patch, by cause (4,)."""
        loads = self.search.loads
        critical = search.rises.turns("velocity", loads).critical
        errors = velocity_errors(search.rises, loads, critical)[:, np.isfinite(critical)]
        whole = totals(errors)
        return errors[:, np.argmax(np.where(np.isnan(whole), np.inf, whole))]
