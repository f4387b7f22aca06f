"""Distance of an operating point from severe wear: in temperature, in velocity and in load.

The decisive rise is interpolated along the velocity at each load, then along the load
(`pipeline.analysis.transition`). Its error has three parts (`pipeline.analysis.margin_error`):
interpolation, preset and warned points. The interpolation error is estimated by leaving out the
points next to the place, and asking how far interpolation misses them. That spans twice the
distance, so it is mostly too large: it held at 54 of 60 random places of
`workflows/first_try.toml`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.decisive import require_sound
from pipeline.analysis.margin_error import RiseError, RisePlane, rise_error
from pipeline.analysis.transition import (
    SEVERAL,
    UNITS,
    Crossing,
    along_friction,
    certain,
    interpolated,
    outcomes,
    spread,
)
from pipeline.store.schema import PLANE
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import contact_temperature, rise_limit
from tribo import Criterion, InputError
from tribo.types import Array

NOT_DECIDED = "not decided"
"""Verdict on a place whose distance from severe wear lies within the error of its temperature."""


@dataclass(frozen=True, slots=True)
class Margin:
    """The distance of an operating point from severe wear.

    Beyond the velocities computed at a load the rise is extrapolated as a power of the velocity,
    such as in a sweep of the boundary alone. The boundary is not extrapolated.
    """

    load: float  #: Normal load on the whole pin [N].
    velocity: float  #: Sliding velocity [m/s].
    realization: int | None  #: Seed of the random surface, in a sweep over several.
    decisive_temperature: float  #: Temperature of the contact that decides [K].
    is_severe: bool  #: Severe wear by that temperature as it was found, whatever its error.
    error: RiseError  #: Error of that temperature by its three parts [K].
    is_computed: bool  #: That very point is done, and the temperature not interpolated.
    is_continued: bool  #: Temperature extrapolated beyond the computed points.
    critical_temperature: float  #: Temperature above which the lubricant fails [K].
    critical_velocity: float  #: At this load [m/s]; NaN if the sweep does not reach it.
    critical_load: float  #: At this velocity [N]; NaN if the sweep does not reach it.
    velocity_outcome: str  #: One of `pipeline.analysis.transition.outcomes`.
    load_outcome: str  #: Likewise, along the load.
    velocity_range: tuple[float, float]  #: Lowest and highest velocity computed there [m/s].
    load_range: tuple[float, float]  #: Lowest and highest load computed there [N].
    velocity_bridged: int  #: Points not done that the critical velocity is interpolated across.
    load_bridged: int  #: Points not done that the critical load is interpolated across.
    #: Values of entries with several, by their paths [SI].
    entries: Mapping[str, float | str] = field(default_factory=dict)

    @property
    def distance(self) -> float:
        """Critical less deciding temperature [K]; negative where wear is severe."""
        return self.critical_temperature - self.decisive_temperature

    @property
    def temperature_error(self) -> float | None:
        """Error of the deciding temperature [K]: the sum of its parts; None if one is unknown."""
        return self.error.total

    @property
    def verdict(self) -> str:
        """``"mild"`` or ``"severe"`` beyond the error of the temperature, else not decided.

        Nor is a place between points decided where wear is severe at a lower velocity or load, and
        mild at a higher one.
        """
        named = zip(("velocity", "load"), (self.velocity_outcome, self.load_outcome), strict=True)
        if not self.is_computed and any(said == outcomes(axis)[SEVERAL] for axis, said in named):
            return NOT_DECIDED
        return verdict_on(self.is_severe, self.distance, self.temperature_error)

    @property
    def velocity_factor(self) -> float:
        """Critical velocity at this load over the velocity; NaN where it is not known."""
        return self.critical_velocity / self.velocity

    @property
    def load_factor(self) -> float:
        """Critical load at this velocity over the load; NaN where it is not known."""
        return self.critical_load / self.load

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        plain: dict[str, Any] = asdict(self)
        entries: dict[str, Any] = plain.pop("entries")
        del plain["is_severe"]
        names = "verdict", "temperature_error", "distance", "velocity_factor", "load_factor"
        return plain | entries | {name: getattr(self, name) for name in names}


def verdict_on(is_severe: bool, distance: float, error: float | None) -> str:
    """Verdict at a distance from severe wear [K] that has an error [K]."""
    if error is None or abs(distance) <= error:
        return NOT_DECIDED
    return "severe" if is_severe else "mild"


@dataclass(frozen=True, slots=True, eq=False)
class JudgedRow:
    """Decisive rises of one row of the table of variants by load and velocity, and how to judge."""

    grid: RisePlane  # at one friction, where it depends on the velocity
    conditions: Conditions
    promised: float | None  # relative error of its boundary velocities
    ends: Mapping[str, tuple[float, float]]  # of the loads [N] and velocities [m/s] asked for
    realization: int | None
    entries: Mapping[str, Any]
    shown: Mapping[str, Any]  # all labels of the row
    source: xr.Dataset  # where the rises are from
    place: tuple[float, float] | None = None  # load [N] and velocity [m/s] if it has no plane

    def here(self) -> Margin:
        """The margin at the row's own place."""
        if self.place is None:
            raise InputError(
                "no operating point is given, and the rows have none of their own; give a load and "
                "a velocity (--load and --velocity), or a table of them (--points)"
            )
        return self.at(*self.place)

    def at(self, load: float, velocity: float) -> Margin:
        """The margin at a load [N] and a velocity [m/s]; an `InputError` where it is not known."""
        grid, conditions = self.grid, self.conditions
        for name, x, value in (("load", grid.loads, load), ("velocity", grid.velocities, velocity)):
            lowest, highest = min(x[0], self.ends[name][0]), max(x[-1], self.ends[name][1])
            if not (lowest <= value <= highest and value > 0):
                raise InputError(
                    f"{name} is {value:g} {UNITS[name]}; the sweep has {lowest:g} to {highest:g} "
                    f"{UNITS[name]}: give one within, above 0, or add points to the sweep"
                )
        rise = _at(grid.loads, self.at_velocity(velocity, continued=True), load)
        if not math.isfinite(rise):
            raise InputError(
                f"too few points about {load:g} N and {velocity:g} m/s are done to tell; run the "
                "sweep to its end, or add points there"
            )
        if self.place is None:  # else all rows are checked
            require_sound(self.source, grid.beneath(load, velocity), *PLANE)
        is_within = math.isfinite(_at(grid.loads, self.at_velocity(velocity), load))
        here = grid.rises[np.ix_(grid.loads == load, grid.velocities == velocity)]
        error = rise_error(grid, load, velocity, self.promised)
        through = load, velocity, rise if is_within else math.nan
        by_velocity, by_load = (self.along(axis, *through) for axis in ("velocity", "load"))
        return Margin(
            load=load,
            velocity=velocity,
            realization=self.realization,
            decisive_temperature=contact_temperature(rise, conditions),
            is_severe=bool(Criterion.is_severe(rise, rise_limit(conditions))),
            error=error.times(conditions.rise_factor * rise),
            is_computed=bool(np.isfinite(here).any()),
            is_continued=not is_within,
            critical_temperature=conditions.known_critical_temperature(),
            critical_velocity=by_velocity.place,
            critical_load=by_load.place,
            velocity_outcome=outcomes("velocity")[by_velocity.outcome],
            load_outcome=outcomes("load")[by_load.outcome],
            velocity_range=by_velocity.computed,
            load_range=by_load.computed,
            velocity_bridged=by_velocity.bridged,
            load_bridged=by_load.bridged,
            entries=self.entries,
        )

    def at_velocity(self, velocity: float, continued: bool = False) -> Array:
        """Rise by load at one velocity [K], with the friction there."""
        x, rows = self.grid.velocities, self.grid.rises
        at_one_friction = np.array([_at(x, row, velocity, continued) for row in rows])
        return at_one_friction * self.conditions.friction_factor(np.array(velocity))

    def along(self, axis: str, load: float, velocity: float, rise: float) -> Crossing:
        """Transition along an axis through a place, and the rise there if that is finite.

        Between those of the sweep, rises go on where wear is certainly mild or severe.
        """
        x, other, place, along = self.grid.velocities, self.grid.loads, load, velocity
        limit, ends = rise_limit(self.conditions), self.ends[axis]
        rises = self.grid.rises * self.conditions.friction_factor(x)
        is_missing = self.grid.is_missing
        if axis == "load":
            x, other, place, along = other, x, velocity, load
            rises, is_missing = rises.T, is_missing.T
        above = int(np.searchsorted(other, place))
        is_between = above < len(other) and other[above] != place
        missing = np.logical_or.reduce(is_missing[above - is_between : above + 1])
        has_curve = self.conditions.has_friction_curve
        if place in other:
            computed = going_on = rises[above]
            rise = math.nan
        elif axis == "load":
            computed, here = self.at_velocity(velocity), np.array([velocity])
            factor = self.conditions.friction_factor(here)
            by_load = [certain(other, row, here, limit / factor[0]) for row in self.grid.rises]
            going_on = np.concatenate(by_load) * factor
        elif has_curve:  # how friction goes on beyond the points is no power law
            computed = going_on = np.array([_at(other, column, place) for column in rises.T])
        else:
            certainly = [certain(x, row, x, limit) for row in rises]
            rows = np.where(np.isfinite(rises), rises, certainly)
            computed, going_on = (
                np.array([_at(other, column, place) for column in lines.T])
                for lines in (rises, rows)
            )
        is_done = np.isfinite(computed)
        if math.isfinite(rise):
            number = int(np.searchsorted(x, along))
            if along not in x:
                x, going_on = np.insert(x, number, along), np.insert(going_on, number, rise)
                is_done, missing = (np.insert(mask, number, False) for mask in (is_done, missing))
            going_on[number] = rise
        if has_curve and axis == "velocity":
            x, going_on = along_friction(x, going_on, self.conditions.friction_factor)
            missing, is_done = spread(missing), spread(is_done)
        return Crossing.along(x, going_on, limit, ends, missing, is_done)


def _at(x: Array, y: Array, place: float, continued: bool = False) -> float:
    """Value at one abscissa; that of a point itself where there is one."""
    (same,) = np.nonzero((x == place) & np.isfinite(y))
    if same.size:
        return float(y[same[0]])
    return float(interpolated(x, y, np.array([place]), continued)[0])
