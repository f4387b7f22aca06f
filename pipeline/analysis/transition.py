"""The transition to severe wear along a line of points, and as much of it as was computed.

Wear is mild (or severe) throughout only if the outermost points of the sweep's own range are. If
these are not done, or were never asked for, the transition lies beyond what was computed.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.interpolation import crossing
from tribo import Criterion
from tribo.types import Array, Mask

CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW = range(6)
"""Values of the variables ``outcome_at_load`` and ``outcome_at_velocity``."""

BEYOND = (ABOVE, BELOW)
"""Outcomes that more points would tell."""


@functools.cache
def outcomes(axis: str) -> Mapping[int, str]:
    """Meanings of the outcomes along ``"velocity"`` or ``"load"``, in the words used everywhere.

    Examples
    --------
    >>> outcomes("velocity")[MILD], outcomes("load")[ABOVE]
    ('mild throughout', 'mild at every load computed')
    """
    words = {
        CROSSES: "crosses",
        MILD: "mild throughout",
        SEVERE: "severe throughout",
        UNKNOWN: "not known yet",
        ABOVE: f"mild at every {axis} computed",
        BELOW: f"severe at every {axis} computed",
    }
    return MappingProxyType(words)


UNITS = {"velocity": "m/s", "load": "N"}


@dataclass(frozen=True, slots=True)
class Crossing:
    """The first crossing from mild to severe wear along a line of points.

    Attributes
    ----------
    place : float
        Velocity [m/s] or load [N] of the crossing; NaN where there is none.
    outcome : int
        Key of `outcomes`.
    computed : tuple of float
        Lowest and highest velocity [m/s] or load [N] computed; NaN where no point is done.
    bridged : int
        Points that were asked for and are not done, between the two next to the crossing that are.

    Examples
    --------
    >>> velocity, rise = np.array([1.2, 2.2]), np.array([700.0, 900.0])
    >>> Crossing.along(velocity, rise, 1200.0, (1.0, 4.0)).worded("velocity")
    'mild at every velocity computed (to 2.2 m/s)'
    >>> Crossing.along(velocity, rise, 1200.0, (1.2, 2.2)).worded("velocity")
    'mild throughout'
    >>> Crossing.along(velocity, rise, 600.0, (1.0, 4.0)).worded("velocity")
    'severe at every velocity computed (from 1.2 m/s)'
    """

    place: float
    outcome: int
    computed: tuple[float, float]
    bridged: int = 0

    @classmethod
    def along(
        cls,
        x: Array,
        rise: Array,
        limit: float,
        ends: tuple[float, float],
        is_missing: Mask | None = None,
        is_done: Mask | None = None,
    ) -> Crossing:
        """Find the transition along velocities [m/s] or loads [N], which ascend.

        Rises [K] are NaN where they are not known; they are done there, or go on where that leaves
        wear as it is. Points that are missing were asked for, and are not done. Wear is severe
        above the limit [K]. The ends are those of the sweep's own range.
        """
        is_done = np.isfinite(rise) if is_done is None else is_done
        done = x[is_done]
        computed = (float(done[0]), float(done[-1])) if done.size else (math.nan, math.nan)
        place = crossing(x, rise, limit)
        if math.isfinite(place):
            is_missing = np.zeros_like(is_done) if is_missing is None else is_missing
            across = _bridged(x[is_done & ~is_missing], x[is_missing], place)
            return cls(place, CROSSES, computed, across)
        if not done.size:
            outcome = UNKNOWN
        elif Criterion.is_severe(rise[is_done][0], limit):
            outcome = SEVERE if computed[0] <= ends[0] else BELOW
        else:
            outcome = MILD if computed[1] >= ends[1] else ABOVE
        return cls(place, outcome, computed)

    def worded(self, along: str) -> str:
        """The outcome along ``"velocity"`` or ``"load"`` in words."""
        return in_words(outcomes(along)[self.outcome], self.computed, along)


def _bridged(done: Array, missing: Array, place: float) -> int:
    """Number of missing points between the two done ones next to a place.

    Examples
    --------
    >>> _bridged(np.array([1.0, 2.0, 4.0]), np.array([1.5, 2.5, 3.0]), 3.7)
    2
    """
    below, above = done[done <= place], done[done >= place]
    if not (below.size and above.size):
        return 0
    return int(np.sum((missing > below[-1]) & (missing < above[0])))


def in_words(outcome: str, computed: tuple[float, float], along: str) -> str:
    """One of `outcomes` along ``"velocity"`` or ``"load"``, with how far was computed.

    Examples
    --------
    >>> in_words("severe throughout", (1.6, 4.0), "velocity")
    'severe throughout'
    >>> in_words("severe at every load computed", (600.0, 750.0), "load")
    'severe at every load computed (from 600 N)'
    """
    low, high = (f"{end:.4g} {UNITS[along]}" for end in computed)
    words = outcomes(along)
    ends = {words[ABOVE]: f" (to {high})", words[BELOW]: f" (from {low})"}
    return outcome + ends.get(outcome, "")


def range_of(ds: xr.Dataset, axis: str) -> tuple[float, float]:
    """Lowest and highest velocity [m/s] or load [N] of the scene that a sweep is of.

    Rest is left out where the sweep has no point at it, as one that searches the boundary alone.

    Examples
    --------
    >>> ds = xr.Dataset(coords={"velocity": [1.2, 2.2]}, attrs={"velocities": [0.0, 1.0, 4.0]})
    >>> range_of(ds, "velocity")
    (1.0, 4.0)
    """
    names = {"load": "loads", "velocity": "velocities"}
    present = ds[axis].values.tolist()
    asked = [
        value for value in attributes_of(ds).get(names[axis]) or present if value or 0.0 in present
    ]
    return float(min(asked or present)), float(max(asked or present))


ENTRIES = {
    "friction": "friction.coefficient",
    "bulk_temperature": "temperature.bulk",
    "critical_temperature": "temperature.critical",
    "failing_share": "temperature.failing_share",
    "criterion": "temperature.criterion",
}
"""Entries of the scene format that give the conditions."""
