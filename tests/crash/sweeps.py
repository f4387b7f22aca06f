"""Sweeps of milliseconds a point that grow from stage to stage, and what is computed of them."""

import numpy as np

from pipeline.sweep.plan import PointRecord, points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.points import run_point

_FIRST = tiny.full(
    loading=tiny.SlowRamp(150.0, 750.0),
    loads=(150.0, 600.0),
    velocities=tuple(np.linspace(0.5, 1.5, 6).tolist()),
)
_LONGER = changed(_FIRST, loads=(150.0, 600.0, 900.0))  # has some more load steps
_WIDER = changed(_LONGER, velocities=(*_FIRST.velocities, 1.7, 1.9, 2.1, 2.3, 2.5))
STAGES = (_FIRST, _LONGER, _WIDER)
"""The same sweep, with more and more points."""
FAILING = Point(600.0, 1.5)
"""A point that fails as long as nothing but the first stage is asked for, if it has a record."""
REASON = "ConvergenceError: the contact did not converge"


class Expected:
    """Function from a point to its result, computed alone and once.

    Parameters
    ----------
    sweep : Sweep
    """

    def __init__(self, sweep):
        self._sweep = sweep
        self._results = {}

    def __call__(self, point):
        if point not in self._results:
            with np.errstate(all="raise", under="ignore"):
                self._results[point] = run_point(self._sweep, point)
        return self._results[point]

    def records(self, sweep):
        """Records of all points of a sweep, as its workers return them, by point."""
        return {point: self(point).record(sweep.fields) for point in points(sweep)}


EXPECTED = Expected(STAGES[-1])
"""Results of the points of all stages."""


def record_of(records, sweep, point):
    """Record of a point; a failure if it is `FAILING` in the first stage."""
    if point == FAILING and sweep.loads == STAGES[0].loads:
        return PointRecord(point, None, REASON)
    return records[point]
