"""A search of a boundary with its results in memory."""

import functools

import numpy as np

from pipeline.answers.specimen import merge_realizations
from pipeline.run.search import Search
from pipeline.sweep.case import allowable_rise


class Told:
    """A search of one scene, which receives the results of the points that it asks for.

    `conditions` judge rises per unit friction coefficient, `promised` is the error of the preset,
    and `freedom` are the degrees of freedom of the deviation that one realization states.
    """

    def __init__(self, loads, velocities, conditions, promised, goal, freedom=7.0):
        self.loads, self.velocities = loads, velocities
        self.conditions, self.promised, self.goal = conditions, promised, goal
        self._freedom = freedom
        shape = goal.realizations, len(loads), len(velocities)
        self.asked = np.zeros(shape, bool)
        self._rises, self._sampling = np.full(shape, np.nan), np.full(shape, np.nan)
        self._flags, self._durations = np.zeros(shape[1:], int), np.zeros(shape[1:])

    def tell(self, points, rises, sampling, flags=0, durations=0.0):
        """Record points that were asked for; rises are NaN where they failed."""
        index = tuple(np.array(points).T)
        self.asked[index], self._rises[index], self._sampling[index] = True, rises, sampling
        np.bitwise_or.at(self._flags, index[1:], flags)
        np.maximum.at(self._durations, index[1:], durations)
        self.__dict__.pop("now", None)

    @functools.cached_property
    def now(self):
        """The search in its present state."""
        count = int(np.flatnonzero(self.asked.any(axis=(1, 2))).max(initial=0)) + 1
        y, is_highest = np.log(self._rises[:count]), self.conditions.critical_area_fraction == 0
        specimen = merge_realizations(
            self.loads,
            self.velocities,
            y,
            _mean_square(self._sampling[:count]),
            self._flags,
            self._durations,
            is_highest,
            self._freedom,
        )
        limit = np.log(allowable_rise(self.conditions))
        first = y[0] + specimen.mean.offset - limit
        return Search(specimen, limit, self.promised, first, self.asked, self.goal)

    def ask(self):
        """Points to compute next; empty at the end."""
        points, velocities = self.now.ask()
        while velocities:
            self._grow(velocities)
            points, velocities = self.now.ask()
        return points

    def _grow(self, more):
        """Insert velocities without results."""
        at = np.searchsorted(self.velocities, more)
        self.velocities = np.insert(self.velocities, at, more)
        for name in "asked", "_rises", "_sampling", "_flags", "_durations":
            values = getattr(self, name)
            empty = np.nan if name in ("_rises", "_sampling") else 0
            setattr(self, name, np.insert(values, at, empty, axis=-1))
        self.__dict__.pop("now", None)

    def __getattr__(self, name):
        return getattr(self.now, name)


def _mean_square(sampling):
    """Root mean square of the deviations stated at each load, repeated for each velocity."""
    known = np.isfinite(sampling)
    squares, count = np.square(np.where(known, sampling, 0.0)).sum(axis=(0, 2)), known.sum((0, 2))
    rows = np.sqrt(np.where(count > 0, squares / np.maximum(count, 1), np.nan))
    return np.repeat(rows[:, None], sampling.shape[2], axis=1)
