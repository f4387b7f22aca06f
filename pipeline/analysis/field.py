"""The field ln(rise/limit) of one scene over load and velocity, from which every answer follows.

The rise is that which decides, at friction 1; its limit is (critical − bulk)/friction. A field has
members, each with a weight: the surfaces of a sweep, one row of its table, or draws of what is not
known exactly. This is the field of points that were computed; `pipeline.uncertain` has that of
samples.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
import xarray as xr

from pipeline import extras
from pipeline.analysis.curve import Curve, certain
from pipeline.analysis.dataset import (
    Kind,
    dataset_of,
    moving_points,
    read_conditions,
    stored_sweep,
    sweep_kind,
    taken_entries,
)
from pipeline.analysis.decisive import (
    decisive_rise,
    strip_friction,
)
from pipeline.analysis.model_error import Scatter, severe_share
from pipeline.analysis.rise_error import RiseError, RisePlane, add_counted, grids_of, rise_error
from pipeline.analysis.scenes import scenes
from pipeline.analysis.transition import LEAST_SLOPE, Line, Transitions, range_of
from pipeline.quantities import UNITS
from pipeline.store.place import PathLike
from pipeline.store.schema import COORDINATES, PLANE
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import rise_limit, rise_limits
from pipeline.sweep.variants import VARIANT
from tribo import InputError
from tribo.types import Array, Mask

_USUAL = COORDINATES.keys() - {VARIANT, "realization"}
_FAR, _PLACES = 30.0, 1024  # ratio to which a line goes on with its friction, and places of it
_PARTS = 64  # parts of an interval of velocities, in each of which friction is taken as it is there


class Field(Protocol):
    """What every answer asks of a scene; arrays have a value of each member, shape (m,)."""

    @property
    def weights(self) -> Array:
        """Weights of the members, whose sum is 1."""

    @property
    def conditions(self) -> Conditions:
        """Conditions that the field is judged by."""

    @property
    def source(self) -> xr.Dataset:
        """Dataset of the scene or the row."""

    @property
    def entries(self) -> Mapping[str, Any]:
        """Values of the entries that have several, by their paths."""

    @property
    def shown(self) -> Mapping[str, Any]:
        """All labels of the row."""

    @property
    def ends(self) -> Mapping[str, tuple[float, float]]:
        """Ends of the loads [N] and velocities [m/s] asked for."""

    @property
    def place(self) -> tuple[float, float] | None:
        """Load [N] and velocity [m/s] of a row that has no plane."""

    @property
    def counts_inputs(self) -> bool:
        """True if the members are draws of unknown inputs; surfaces tell nothing of these."""

    @property
    def misfit(self) -> str:
        """Why the tests contradict the model; empty if they do not."""

    @property
    def basis(self) -> tuple[Mapping[str, Any], Sequence[str]]:
        """What answers rest on beside computed points: as plain data, and in lines."""

    def judged_by(self, own: Mapping[str, float]) -> Field:
        """The field under the conditions of a row of a table; see `Conditions.row_conditions`."""

    def temperatures(self, load: float, velocity: float) -> Here:
        """Deciding temperatures at a place, and where they are from."""

    def error(self, load: float, velocity: float) -> RiseError:
        """Numerical error there, relative to the rise: that of the member that errs most."""

    def transitions(self, axis: str, load: float, velocity: float) -> Transitions:
        """Where wear first turns severe along an axis through a place."""

    def probability(
        self, load: float, velocities: Array, scatter: Scatter, shift: float = 0.0
    ) -> Array:
        """Probability that the next run is severe, by velocity (k,).

        The shift of ln(rise) makes all rises larger.
        """

    def plane(self, loads: Sequence[float], velocities: Array, scatter: Scatter) -> Array:
        """The same by load and velocity."""


class Here(NamedTuple):
    """Deciding temperatures of the members of a field at a place."""

    values: Array  # [K]
    is_severe: Mask
    critical: Array  # [K]
    is_computed: bool  # the very point is done
    is_continued: bool  # beyond the points that are done


@dataclass(frozen=True, eq=False)
class PointField:
    """The field of computed points, of the surfaces of a scene or of one row of its table."""

    planes: tuple[RisePlane, ...]  # at one friction, where it depends on the velocity
    conditions: Conditions
    promised: float | None  # relative error of boundary velocities
    ends: Mapping[str, tuple[float, float]]  # ends of the loads [N] and velocities [m/s] asked for
    source: xr.Dataset  # where the rises are from
    entries: Mapping[str, Any] = field(default_factory=dict)
    shown: Mapping[str, Any] = field(default_factory=dict)
    place: tuple[float, float] | None = None
    from_rest: bool = False  # the sweep has points at rest, below its lowest velocity
    misfit: str = ""
    basis: tuple[Mapping[str, Any], Sequence[str]] = ({}, ())
    counts_inputs = False

    @property
    def weights(self) -> Array:
        """See `Field`."""
        return np.full(len(self.planes), 1 / len(self.planes))

    @property
    def limit(self) -> float:
        """Rise above which wear is severe [K]."""
        return rise_limit(self.conditions)

    def judged_by(self, own: Mapping[str, float]) -> PointField:
        """See `Field`."""
        return self.under(self.conditions.row_conditions(own)) if own else self

    def under(self, conditions: Conditions) -> PointField:
        """The field under other conditions."""
        names = "bulk_ratio", "solved_friction"
        if all(getattr(conditions, name) == getattr(self.conditions, name) for name in names):
            return replace(self, conditions=conditions)  # rises at friction 1 are the same
        rise = decisive_rise(self.source, conditions)
        planes = tuple(grids_of(self.source, strip_friction(rise, conditions), conditions))
        return replace(self, planes=planes, conditions=conditions)

    @functools.cached_property
    def _curves(self) -> list[list[Curve]]:
        """Curve over velocities of each load, by plane."""
        return [[Curve(plane.velocities, row) for row in plane.rises] for plane in self.planes]

    def temperatures(self, load: float, velocity: float) -> Here:
        """See `Field`; an `InputError` where too little is done to tell."""
        self._require_within(load, velocity)
        found = [self._rise(number, load, velocity) for number in range(len(self.planes))]
        if not all(math.isfinite(rise) for rise, _ in found):
            raise InputError(
                f"too few points about {load:g} N and {velocity:g} m/s are done to tell; run the "
                "sweep to its end, or add points there"
            )
        rises = np.array([rise for rise, _ in found])
        return Here(
            self.conditions.contact_temperature(rises),
            rises > self.limit,
            np.full(len(rises), self.conditions.known_critical_temperature()),
            all(plane.is_done(load, velocity) for plane in self.planes),
            not all(is_within for _, is_within in found),
        )

    def _require_within(self, load: float, velocity: float) -> None:
        axes = self.planes[0].loads, self.planes[0].velocities
        for name, x, value in zip(PLANE, axes, (load, velocity), strict=True):
            lowest, highest = min(x[0], self.ends[name][0]), max(x[-1], self.ends[name][1])
            lowest = 0.0 if self.from_rest and name == "velocity" else lowest
            if not (lowest <= value <= highest and value > 0):
                raise InputError(
                    f"{name} is {value:g} {UNITS[name]}; the sweep has {lowest:g} to {highest:g} "
                    f"{UNITS[name]}: give one within, above 0, or add points to the sweep"
                )

    def _rise(self, number: int, load: float, velocity: float) -> tuple[float, bool]:
        """Rise of a member at a place [K], and whether it lies between computed points."""
        for continued in (False, True):
            by_load = self._load_rises(number, velocity, continued)
            rise = Curve(self.planes[number].loads, by_load).at(load)
            if math.isfinite(rise):
                break
        return rise, not continued

    def _load_rises(self, number: int, velocity: float, continued: bool = False) -> Array:
        """Rises of a member by load at one velocity [K], with the friction there."""
        rises = np.array([curve.at(velocity, continued) for curve in self._curves[number]])
        return rises * self.conditions.friction_factor(np.array(velocity))

    def error(self, load: float, velocity: float) -> RiseError:
        """See `Field`."""
        errors = [rise_error(plane, load, velocity, self.promised) for plane in self.planes]
        worst = max(errors, key=lambda one: math.inf if one.total is None else one.total)
        is_solved = all(plane.rests_on_solved(load, velocity) for plane in self.planes)
        rises = [self._rise(number, load, velocity)[0] for number in range(len(self.planes))]
        return add_counted(worst, self.conditions, max(rises), is_solved)

    def transitions(self, axis: str, load: float, velocity: float) -> Transitions:
        """See `Field`."""
        return Transitions.of(self.lines(axis, load, velocity))

    def probability(
        self, load: float, velocities: Array, scatter: Scatter, shift: float = 0.0
    ) -> Array:
        """See `Field`."""
        limits, here = rise_limits(self.conditions) * math.exp(-shift), float(velocities[0])
        lines = self.lines("velocity", load, here, self._is_untold(load, velocities))
        shares = np.array([
            [severe_share(replace(line, limit=limit).severe(), velocities, scatter)
             for limit in limits.tolist()]
            for line in lines
        ])  # fmt: skip
        return np.asarray(self.weights @ shares.mean(axis=1))

    def _is_untold(self, load: float, velocities: Array) -> bool:
        """A row of the sweep has too few points to go on to velocities, on any surface."""
        rows = np.flatnonzero(self.planes[0].loads == load).tolist()
        own = [curves[row] for curves in self._curves for row in rows]
        return any(len(curve.x) < 2 and not np.isin(velocities, curve.x).all() for curve in own)

    def plane(self, loads: Sequence[float], velocities: Array, scatter: Scatter) -> Array:
        """See `Field`."""
        return np.array([self.probability(load, velocities, scatter) for load in loads])

    @functools.cached_property
    def lines(self) -> Callable[..., list[Line]]:
        """Line of each member along an axis, through the rise at a load and a velocity.

        Between loads or velocities of the sweep, rises go on where wear is certainly mild or
        severe. A row of the sweep has its own points alone, unless those of other rows are asked to
        stand in for points that it lacks.
        """
        kept = functools.lru_cache(maxsize=2)  # those of one place are asked for several times
        return kept(lambda *place: [self._line(k, *place) for k in range(len(self.planes))])

    def _line(
        self, number: int, axis: str, load: float, velocity: float, is_filled: bool = False
    ) -> Line:
        plane, factor, limit = self.planes[number], self.conditions.friction_factor, self.limit
        x, other, place, along = plane.velocities, plane.loads, load, velocity
        rises = plane.rises * factor(x)
        if axis == "load":
            x, other, place, along, rises = other, x, velocity, load, rises.T
        has_curve = self.conditions.has_friction_curve
        is_row = place in other and not is_filled
        if is_row:
            computed = going_on = rises[int(np.searchsorted(other, place))]
        elif axis == "load":
            computed, here = self._load_rises(number, velocity), np.array([velocity])
            going_on = np.array(
                [certain(other, row, here, limit / factor(here)[0])[0] for row in plane.rises]
            ) * factor(here)
        elif has_curve:  # how friction goes on beyond the points is no power law
            computed = going_on = np.array([Curve(other, column).at(place) for column in rises.T])
        else:
            certainly = np.array([certain(x, row, x, limit) for row in rises])
            rows = np.where(np.isfinite(rises), rises, certainly)
            computed, going_on = (
                np.array([Curve(other, column).at(place) for column in lines.T])
                for lines in (rises, rows)
            )
        done = x[np.isfinite(computed)]
        rise, is_within = (math.nan, False) if is_row else self._rise(number, load, velocity)
        known: tuple[Array, Array] = x, going_on
        through_place = _inserted(*known, along, rise) if math.isfinite(rise) else known
        line = through_place if is_within else known
        if not (has_curve and axis == "velocity"):
            return Line(Curve(*line), limit, self.ends[axis], done)
        continued = continued_friction(*through_place, factor)
        return Line(Curve(*along_friction(*line, factor)), limit, self.ends[axis], done, continued)


def _inserted(x: Array, y: Array, place: float, value: float) -> tuple[Array, Array]:
    """Ascending abscissae and their ordinates, with a value at a place."""
    others, number = x != place, int(np.searchsorted(x, place))
    return np.insert(x[others], number, place), np.insert(y[others], number, value)


def along_friction(velocities: Array, rises: Array, factor: Any) -> tuple[Array, Array]:
    """Velocities [m/s] close together, and rises [K] there with friction by velocity.

    Between two velocities the friction is known, and only the heat is interpolated: rises are
    divided by the factor of their friction, and multiplied by that of each place.
    """
    steps = np.arange((len(velocities) - 1) * _PARTS + 1) / _PARTS
    places = np.interp(steps, np.arange(len(velocities)), velocities)
    between = Curve(velocities, rises / factor(velocities))(places) * factor(places)
    between[::_PARTS] = rises
    return places, between


def continued_friction(velocities: Array, rises: Array, factor: Any) -> Curve | None:
    """Rises [K] far beyond the velocities [m/s] that are known: only the heat is a power there."""
    heat = Curve(velocities, rises / factor(velocities))
    if not (heat.x.size and (heat.y > 0).all()):
        return None
    if len(heat.x) == 1:  # as the velocity, at most
        heat = Curve(np.append(heat.x, 2 * heat.x), np.append(heat.y, 2 * heat.y))
    far = np.geomspace(heat.x[0] / _FAR, heat.x[-1] * _FAR, _PLACES)
    places = np.union1d(np.append(far, np.linspace(heat.x[0], heat.x[-1], _PLACES)), heat.x)
    return Curve(places, heat(places, continued=True, least_slope=LEAST_SLOPE) * factor(places))


def fields(ds: xr.Dataset | PathLike) -> list[Field]:
    """The field of each scene of a sweep, or of each row with its own place."""
    ds = dataset_of(ds)
    kind = sweep_kind(ds)
    if kind is Kind.SAMPLES:
        made: list[Field] = extras.module("uncertain", "fields").fields(ds)
        return made
    if kind is Kind.PLACES:  # at once, for a read of each row by itself takes ten times as long
        ds = ds.drop_dims(["x", "y"], errors="ignore").compute()
    return [point_field(scene) for scene in scenes(ds)]


def point_field(scene: xr.Dataset, conditions: Conditions | None = None) -> PointField:
    """The field of one scene, under given conditions or its own."""
    conditions = conditions or read_conditions(scene)
    placed = [name for name in PLANE if name not in scene.dims]
    place = tuple(scene[name].item() for name in PLANE) if len(placed) == len(PLANE) else None
    coords = {str(name): label for name, label in scene.coords.items() if name not in _USUAL}
    shown = {name: label.item() for name, label in coords.items() if not label.ndim}
    entries = {path: scene[path].item() for path in taken_entries(scene)}
    whole, sweep = scene.expand_dims(placed if place else []), stored_sweep(scene)
    scene = moving_points(whole)
    rise = decisive_rise(scene, conditions)
    ends = {
        name: (at, at) if place else range_of(scene, name)
        for name, at in zip(PLANE, place or (np.nan, np.nan), strict=True)
    }
    return PointField(
        planes=tuple(grids_of(scene, strip_friction(rise, conditions), conditions)),
        conditions=conditions,
        promised=velocity_error(sweep),
        ends=ends,
        source=scene,
        entries=entries,
        shown=shown,
        place=place,
        from_rest=0.0 in whole["velocity"].values and scene.sizes != whole.sizes,
    )


def quantile(values: Array, weights: Array, share: float) -> float:
    """Value that a share of weight stays below: infinite beside an infinite one, NaN if any is."""
    if np.isnan(values).any():
        return math.nan
    order = np.argsort(values)
    values, weights = values[order], weights[order]
    total, share = np.cumsum(weights), share * weights.sum()
    sides = [np.searchsorted(total.round(12), round(share, 12), side) for side in ("left", "right")]
    for value in values[np.minimum(sides, len(values) - 1)].tolist():
        if math.isinf(value):
            return float(value)
    known = np.isfinite(values)
    return float(np.interp(share, (total - 0.5 * weights)[known], values[known]))
