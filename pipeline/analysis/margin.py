"""Distance of an operating point from severe wear: in temperature, in velocity and in load.

The decisive rise is interpolated along the velocity at each load, then along the load
(`pipeline.analysis.interpolation`). Its error has three parts (`pipeline.analysis.margin_error`):
interpolation, preset and warned points. The interpolation error is estimated by leaving out the
points next to the place, and asking how far interpolation misses them. That spans twice the
distance, so it is mostly too large: it held at 54 of 60 random places of
`workflows/first_try.toml`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.conditions import Bulk, conditions_of
from pipeline.analysis.dataset import asked, plane_of
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.interpolation import certain, interpolated
from pipeline.analysis.margin_error import RiseError, RisePlane, grids_of, rise_error
from pipeline.analysis.scenes import scenes
from pipeline.analysis.transition import UNITS, Crossing, outcomes, range_of
from pipeline.scene.quantities import in_si
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import contact_temperature, rise_limit
from pipeline.sweep.selection import velocity_error
from tribo import Criterion, InputError
from tribo.types import Array, Mask

NOT_DECIDED = "not decided"
"""Verdict on a place whose distance from severe wear lies within the error of its temperature."""


@dataclass(frozen=True, slots=True)
class Margin:
    """The distance of an operating point from severe wear.

    Beyond the velocities computed at a load the rise is extrapolated as a power of the velocity,
    such as in a sweep of the boundary alone. The boundary is not extrapolated.

    Attributes
    ----------
    load : float
        Normal load on the whole pin [N].
    velocity : float
        Sliding velocity [m/s].
    realization : int or None
        Seed of the random surface, in a sweep over several.
    entries : mapping
        Values of entries with several, by their paths [SI].
    decisive_temperature : float
        Temperature of the contact that decides [K].
    is_severe : bool
        Severe wear by the deciding temperature as it was found, whatever its error.
    error : RiseError
        Error of the deciding temperature by its three parts [K].
    is_computed : bool
        That very point is done, and the temperature not interpolated.
    is_continued : bool
        Continuation of the temperature beyond the computed points.
    critical_temperature : float
        Temperature above which the lubricant fails [K].
    critical_velocity, critical_load : float
        Velocity [m/s] at this load, and load [N] at this velocity, at which wear turns severe; NaN
        where the sweep does not reach the transition.
    velocity_outcome, load_outcome : str
        One of `pipeline.analysis.transition.outcomes`, along the velocity and along the load.
    velocity_range, load_range : tuple of float
        Lowest and highest velocity [m/s] and load [N] computed there.
    velocity_bridged, load_bridged : int
        Pending or failed points that the critical velocity and load are interpolated across.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> (margin,) = pipeline.margins(ds, "500 N", "1.6 m/s")
    >>> f"{margin.distance:.0f} K, severe from {margin.velocity_factor:.2f} times the velocity on"
    '9 K, severe from 1.16 times the velocity on'
    >>> margin.verdict, f"{margin.temperature_error:.0f} K"
    ('mild', '6 K')
    """

    load: float
    velocity: float
    realization: int | None
    decisive_temperature: float
    is_severe: bool
    error: RiseError
    is_computed: bool
    is_continued: bool
    critical_temperature: float
    critical_velocity: float
    critical_load: float
    velocity_outcome: str
    load_outcome: str
    velocity_range: tuple[float, float]
    load_range: tuple[float, float]
    velocity_bridged: int
    load_bridged: int
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
        """``"mild"`` or ``"severe"`` beyond the error of the temperature, else not decided."""
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
    """Verdict on a place at a distance from severe wear [K], beyond the error of that [K].

    Examples
    --------
    >>> verdict_on(True, -3.0, 2.0), verdict_on(True, -3.0, 4.0), verdict_on(False, 3.0, None)
    ('severe', 'not decided', 'not decided')
    """
    if error is None or abs(distance) <= error:
        return NOT_DECIDED
    return "severe" if is_severe else "mild"


def margins(
    ds: xr.Dataset | PathLike,
    load: float | str,
    velocity: float | str,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    own_laws: bool = False,
) -> tuple[Margin, ...]:
    """Distance of an operating point from severe wear, without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store. Points that are pending or failed
        are skipped.
    load : float or str
        Normal load on the whole pin [N], or text such as ``"500 N"``, within those of the sweep.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit, above 0 and within those of the sweep.
    friction, bulk_temperature, critical_temperature, share, criterion, own_laws
        See `pipeline.boundary`.

    Returns
    -------
    tuple of Margin
        One for each random surface of the sweep, and each value of entries with several.

    Raises
    ------
    InputError
        If the operating point lies outside the sweep, too little of the sweep is done, or a
        condition lies outside its range.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> (margin,) = pipeline.margins(ds, "500 N", "1.6 m/s", friction=0.12)
    >>> margin.verdict, f"{margin.distance:.0f} K"
    ('severe', '-13 K')
    """
    place = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
    others = friction, bulk_temperature, critical_temperature, share, criterion, own_laws
    judges = (judge_of(plane_of(scene), *others) for scene in scenes(ds))
    return tuple(margin for judge in judges for margin in judge(*place))


def margins_at(
    ds: xr.Dataset, places: Iterable[tuple[float, float]], **conditions: Any
) -> Iterator[Margin]:
    """Margins at loads [N] and velocities [m/s]; none where the sweep does not tell."""
    places = list(places)
    for scene in scenes(ds):
        judge = judge_of(plane_of(scene), **conditions)
        for place in places:
            with suppress(InputError):
                yield from judge(*place)


def judge_of(
    ds: xr.Dataset, *others: Any, **conditions_given: Any
) -> Callable[[float, float], tuple[Margin, ...]]:
    """Function that gives `margins` at a load [N] and a velocity [m/s] under some conditions."""
    conditions = conditions_of(ds, *others, **conditions_given)
    limit, rise = rise_limit(conditions), decisive_rise(ds, conditions)
    entries = {path: ds[path].item() for path in attributes_of(ds).get("entries", {})}
    ends = {name: range_of(ds, name) for name in ("load", "velocity")}
    axes = {name: rise[name].values for name in ends}
    seeds = rise["realization"].values.tolist() if "realization" in rise.dims else [None]
    is_missing = (rise.isnull() & asked(ds)).values.reshape(len(seeds), *rise.shape[-2:])
    planes = [
        _Plane(grid, missing, limit, ends)
        for grid, missing in zip(grids_of(ds, rise), is_missing, strict=True)
    ]
    promised = velocity_error(attributes_of(ds))

    def judge(load: float, velocity: float) -> tuple[Margin, ...]:
        for name, value in (("load", load), ("velocity", velocity)):
            lowest, highest = min(axes[name][0], ends[name][0]), max(axes[name][-1], ends[name][1])
            if not (lowest <= value <= highest and value > 0):
                raise InputError(
                    f"{name} is {value:g} {UNITS[name]}; the sweep has {lowest:g} to {highest:g} "
                    f"{UNITS[name]}: give one within, above 0, or add points to the sweep"
                )
        return tuple(
            _margin(plane, load, velocity, conditions, promised, seed, entries)
            for plane, seed in zip(planes, seeds, strict=True)
        )

    return judge


@dataclass(frozen=True, slots=True, eq=False)
class _Plane:
    """Decisive rises by load and velocity on one surface, and the limit of mild wear [K]."""

    grid: RisePlane
    is_missing: Mask
    limit: float
    ends: Mapping[str, tuple[float, float]]

    def at_velocity(self, velocity: float, continued: bool = False) -> Array:
        """Rise by load at one velocity [K]."""
        x, rows = self.grid.velocities, self.grid.rises
        return np.array([_at(x, row, velocity, continued) for row in rows])

    def along(self, axis: str, load: float, velocity: float, rise: float) -> Crossing:
        """Transition along an axis through a place, and through the rise there if that is finite.

        At a load or velocity of the sweep it is that of `boundary`. Between them rises go on
        beyond those computed where wear is certainly mild or severe.
        """
        x, other, place, along = self.grid.velocities, self.grid.loads, load, velocity
        rises, limit, ends = self.grid.rises, self.limit, self.ends[axis]
        is_missing = self.is_missing
        if axis == "load":
            x, other, place, along = other, x, velocity, load
            rises, is_missing = rises.T, is_missing.T
        missing = np.logical_or.reduce(is_missing[_beside(other, place)])
        if place in other:
            return Crossing.along(x, rises[other == place][0], limit, ends, missing)
        if axis == "load":
            computed, here = self.at_velocity(velocity), np.array([velocity])
            going_on = np.array([certain(other, row, here, limit)[0] for row in self.grid.rises])
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
        return Crossing.along(x, going_on, limit, ends, missing, is_done)


def _margin(
    plane: _Plane,
    load: float,
    velocity: float,
    conditions: Conditions,
    promised: float | None,
    seed: int | None,
    entries: Mapping[str, float | str],
) -> Margin:
    """The margin on one surface."""
    grid = plane.grid
    rise = _at(grid.loads, plane.at_velocity(velocity, continued=True), load)
    if not math.isfinite(rise):
        raise InputError(
            f"too few points about {load:g} N and {velocity:g} m/s are done to tell; run the sweep "
            "to its end, or add points there"
        )
    is_within = math.isfinite(_at(grid.loads, plane.at_velocity(velocity), load))
    here = grid.rises[np.ix_(grid.loads == load, grid.velocities == velocity)]
    error = rise_error(grid, load, velocity, promised)
    through = load, velocity, rise if is_within else math.nan
    along_velocity, along_load = (plane.along(axis, *through) for axis in ("velocity", "load"))
    return Margin(
        load=load,
        velocity=velocity,
        realization=seed,
        decisive_temperature=contact_temperature(rise, conditions),
        is_severe=bool(Criterion.is_severe(rise, plane.limit)),
        error=error.times(conditions.rise_factor * rise),
        is_computed=bool(np.isfinite(here).any()),
        is_continued=not is_within,
        critical_temperature=conditions.known_critical_temperature(),
        critical_velocity=along_velocity.place,
        critical_load=along_load.place,
        velocity_outcome=outcomes("velocity")[along_velocity.outcome],
        load_outcome=outcomes("load")[along_load.outcome],
        velocity_range=along_velocity.computed,
        load_range=along_load.computed,
        velocity_bridged=along_velocity.bridged,
        load_bridged=along_load.bridged,
        entries=entries,
    )


def _at(x: Array, y: Array, place: float, continued: bool = False) -> float:
    """Value at one abscissa; that of a point itself where there is one."""
    (same,) = np.nonzero((x == place) & np.isfinite(y))
    if same.size:
        return float(y[same[0]])
    return float(interpolated(x, y, np.array([place]), continued)[0])


def _beside(x: Array, place: float) -> slice:
    """The abscissa of a place, or the two that it lies between."""
    above = int(np.searchsorted(x, place))
    return slice(above - (above < len(x) and x[above] != place), above + 1)
