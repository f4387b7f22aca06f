"""The field ln(rise/limit) of one scene over load and velocity, from which every answer follows.

The rise is that of the contact temperature which the criterion compares with the critical
temperature, per unit friction coefficient. Its limit is (critical − bulk temperature)/friction
coefficient. A field has a rise for each surface of a sweep.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.analysis.curve import Curve, filled
from pipeline.analysis.left_out import fill_left_out
from pipeline.analysis.model_error import ModelError
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import RisePlane, planes_of, rise_errors, totals
from pipeline.analysis.transition import Line, Transitions, range_of
from pipeline.quantities import UNITS
from pipeline.store.schema import PLANE
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.conditions import Conditions, known_critical_temperature, row_conditions
from pipeline.sweep.severity import rise_limit
from tribo import Criterion, InputError
from tribo.types import Array, Mask

_FAR, _PLACES = 30.0, 1024  # extrapolation with friction by velocity: ratio, velocities
_PARTS = 64  # parts of an interval of velocities, at each of which friction is evaluated
_POINTS = 2_000_000  # most points of lines in memory


Places = Array | float
"""Loads [N] or velocities [m/s] of k operating points (k,), or a single one for all of them."""


class Here(NamedTuple):
    """Contact temperatures at k pairs of load and velocity, and whether wear is severe there.

    The temperature is the one that the criterion compares with the critical temperature. Each of m
    surfaces has its own.
    """

    values: Array  # contact temperatures [K] (m, k); NaN if unknown
    is_severe: Mask  # True if wear is severe (m, k)
    critical: Array  # critical temperatures [K] (m, k)
    is_computed: Mask  # True if the pair is a computed point (k,)
    is_continued: Mask  # True if extrapolated beyond the computed points (k,)
    reasons: Sequence[str]  # why the temperature at each pair is unknown; "" if it is known

    def require_known(self) -> None:
        """Raise an `InputError` with the reason if a temperature is unknown."""
        for reason in filter(None, self.reasons):
            raise InputError(reason)


@dataclass(frozen=True, eq=False)
class PointField:
    """Temperature rise and wear at any load and velocity, interpolated between computed points.

    The points were computed for one variant of a sweep: one value of each varied entry.
    """

    planes: tuple[RisePlane, ...]  # one for each surface, without the effect of V on friction
    conditions: Conditions
    promised: float | None  # relative error of critical velocities due to the preset
    ends: Mapping[str, tuple[float, float]]  # range of loads [N] and velocities [m/s] of the sweep
    source: Results  # results that the rises are from
    from_rest: bool = False  # True if the sweep also has velocity 0

    @property
    def at_once(self) -> int:
        """Number of pairs of load and velocity to judge in one call, with some 200 MB of memory."""
        width = 2 * _PLACES if self.conditions.has_friction_curve else len(self.velocities)
        return 1 + _POINTS // (width * len(self.planes))

    @property
    def weights(self) -> Array:
        """Equal weights of the surfaces (m,), which add up to 1."""
        return np.full(len(self.planes), 1 / len(self.planes))

    @property
    def limit(self) -> float:
        """Limit of the rise per unit friction coefficient [K]; wear is severe above it."""
        return rise_limit(self.conditions)

    def judged_by(self, own: Mapping[str, float]) -> PointField:
        """Return the field with conditions of one operating point in place of the scene's.

        `own` has some of ``friction``, ``bulk_temperature`` [K] and ``critical_temperature`` [K].
        """
        return self.under(row_conditions(self.conditions, own)) if own else self

    def under(self, conditions: Conditions) -> PointField:
        """The field under other conditions, from the same simulated points."""
        if conditions.bulk_ratio == self.conditions.bulk_ratio:
            return replace(self, conditions=conditions)  # the same rises per unit friction
        return replace(self, planes=planes_of(self.source, conditions), conditions=conditions)

    def temperatures(self, loads: Places, velocities: Places) -> Here:
        """Contact temperatures [K] at k pairs of load and velocity, and whether wear is severe.

        Temperatures are interpolated between computed points, or extrapolated along velocity within
        the sweep's range. `Here.values`, the temperatures, have the shape (m, k), for each of m
        surfaces.
        """
        loads, velocities = places_of(loads, velocities)
        rises, is_within = self._rise(loads, np.where(velocities > 0, velocities, math.nan))
        is_known = np.all(np.isfinite(rises), axis=0)
        reasons = [
            self._reason(load, velocity, known)
            for load, velocity, known in zip(
                loads.tolist(), velocities.tolist(), is_known.tolist(), strict=True
            )
        ]
        rises = np.where([not reason for reason in reasons], rises, np.nan)
        return Here(
            self.conditions.contact_temperature(rises),
            rises > self.limit,
            np.full(rises.shape, known_critical_temperature(self.conditions)),
            np.all([plane.is_done(loads, velocities) for plane in self.planes], axis=0),
            ~np.all(is_within, axis=0),
            reasons,
        )

    def _reason(self, load: float, velocity: float, is_known: bool) -> str:
        """Why the verdict at a load [N] and velocity [m/s] is unknown; empty if it is known.

        `is_known` is True if the temperature rise is known.
        """
        axes = self.loads, self.velocities
        for name, x, value in zip(PLANE, axes, (load, velocity), strict=True):
            lowest, highest = min(x[0], self.ends[name][0]), max(x[-1], self.ends[name][1])
            lowest = 0.0 if self.from_rest and name == "velocity" else lowest
            if not (lowest <= value <= highest and value > 0):
                return (
                    f"{name} is {value:g} {UNITS[name]}; the sweep has {lowest:g} to {highest:g} "
                    f"{UNITS[name]}: give one within, above 0, or add points to the sweep"
                )
        if is_known:
            return ""
        return (
            f"too few points about {load:g} N and {velocity:g} m/s are done to tell; run the "
            "sweep to its end, or add points there"
        )

    def _rise(self, loads: Array, velocities: Array) -> tuple[Array, Mask]:
        """Rises [K] at k pairs of load and velocity on m surfaces, and a mask; both (m, k).

        The rises are per unit friction coefficient. The mask is True where a rise is interpolated,
        False where it is extrapolated, estimated by `filled`, or unknown.
        """
        rises, marks, _ = self._rises_and_marks(velocities)
        rise, mark = (Curve(self.loads, part)(loads[:, None])[..., 0] for part in (rises, marks))
        return rise, mark == 1

    def _rises_and_marks(self, velocities: Array) -> tuple[Array, ...]:
        """Rises [K] at k velocities and all computed loads on m surfaces, each with two marks.

        Returns three arrays (m, k, n_load):

        1. Rises per unit friction coefficient, including the effect of velocity on friction.
           Outside the velocities that were computed at a load, rises are extrapolated. At a load
           with a single computed velocity, rises at other velocities are estimated from
           neighbouring loads.
        2. Mark: 1 if the rise is interpolated between computed velocities, 2 if it is extrapolated.
        3. Mark: 1 if it is certain whether wear is mild or severe, else 2. It is certain between
           computed velocities, below them if wear is mild at the lowest, and above them if wear is
           severe at the highest.

        Marks are NaN where the rise is unknown or estimated from neighbouring loads. Callers
        interpolate marks over load: the result is 1 only between two loads with mark 1.
        """
        points, rows = self._curves
        factor = self.conditions.friction_factor(velocities)
        limit = math.nan if self.conditions.critical_temperature is None else self.limit
        ends = (points.end(end) for end in (0, -1))
        (low, first), (high, last) = ((x[..., None], y[..., None]) for x, y in ends)
        is_within = (low <= velocities) & (velocities <= high)
        is_mild = (velocities < low) & Criterion.is_mild(first * factor, limit)
        is_severe = (velocities > high) & Criterion.is_severe(last * factor, limit)
        on_row, on_points = (is_within | (one.count > 1)[..., None] for one in (rows, points))
        rises = np.where(on_row, rows(velocities, continued=True) * factor, np.nan)
        is_marked, certain = on_points & np.isfinite(rises), is_within | is_mild | is_severe
        marks = (np.where(is_marked, 2.0 - kind, np.nan) for kind in (is_within, certain))
        return tuple(part.swapaxes(-1, -2) for part in (rises, *marks))

    @property
    def loads(self) -> Array:
        """Loads of the points [N]."""
        return self.planes[0].loads

    @property
    def velocities(self) -> Array:
        """Velocities of the points [m/s]."""
        return self.planes[0].velocities

    @functools.cached_property
    def _rises(self) -> Array:
        """Rises [K] on m surfaces (m, n_load, n_velocity); NaN at points that are not done.

        They leave out the effect of velocity on friction. At loads that a search of the boundary
        has left out, they are estimated near the boundary.
        """
        rises = np.array([plane.rises for plane in self.planes])
        is_left_out = np.array([plane.is_left_out.all(axis=-1) for plane in self.planes])
        return fill_left_out(self.loads, self.velocities, rises, is_left_out)

    @functools.cached_property
    def _filled(self) -> Array:
        """Rises [K] on m surfaces (m, n_load, n_velocity), with estimates; NaN elsewhere.

        Rises at loads with a single computed point are estimated: they are interpolated between
        neighbouring loads, and scaled to pass through that point. All other rises are as computed.
        """
        return filled(self._rises, self.loads, self.velocities)

    @functools.cached_property
    def _curves(self) -> tuple[Curve, Curve]:
        """Two `Curve` objects: the rise [K] over velocity, on each surface and at each load.

        The first has only the rises of computed points. The second also has the estimated rises at
        loads with a single point.
        """
        return Curve(self.velocities, self._rises), Curve(self.velocities, self._filled)

    @functools.cached_property
    def _load_curves(self) -> tuple[Curve, ...]:
        """Three `Curve` objects over load, on each surface and at each velocity of the points.

        The first has the rise [K]. The second is 1 where this rise is interpolated over velocity,
        not extrapolated. The third is 1 where it is certain whether wear is mild or severe.
        """
        return tuple(Curve(self.loads, part) for part in self._rises_and_marks(self.velocities))

    def errors(self, loads: Places, velocities: Places) -> Array:
        """Relative numerical errors of rises at k pairs of load and velocity (3, k).

        The first axis has three causes: interpolation between computed points, the preset of
        numerical settings, and faults that the simulation warned of. The errors are those of the
        surface where their total is largest. An unknown error is NaN.
        """
        loads, velocities = places_of(loads, velocities)
        by_plane = np.array(
            [rise_errors(plane, loads, velocities, self.promised) for plane in self.planes]
        )
        worst = np.nan_to_num(totals(by_plane.swapaxes(0, 1)), nan=math.inf).argmax(axis=0)
        errors: Array = by_plane[worst, :, np.arange(len(loads))].T
        return errors

    def transitions(self, axis: str, loads: Places, velocities: Places) -> Transitions:
        """Whether and where wear turns severe along `axis`, through each of k operating points.

        `axis` is "load" or "velocity". The other one is held at its value at the point.
        """
        return self.lines(axis, *places_of(loads, velocities)).transitions

    def probability(
        self, loads: Places, velocities: Places, scatter: ModelError, shift: Array | float = 0.0
    ) -> Array:
        """Probability (k,) that wear is severe in a further laboratory run at k operating points.

        The probability is the mean over surfaces. `scatter` is the distribution of the model's own
        error. `shift` is added to ln(rise): one value, a value for each pair of load and velocity
        (k,), or n alternatives (n, k), for each of which the result (n, k) has a row.
        """
        loads, velocities = places_of(loads, velocities)
        # Places at a load of the sweep share its line.
        keys = np.stack([loads, np.where(np.isin(loads, self.loads), -1.0, velocities)])
        _, first, rows = np.unique(keys, axis=1, return_index=True, return_inverse=True)
        line = self.lines("velocity", loads[first], velocities[first])
        shape = np.broadcast_shapes(loads.shape, np.shape(shift))
        factors = np.exp(-np.broadcast_to(shift, shape))[..., None, :]
        chosen = slice(None), rows.ravel()
        shifted = replace(line, limit=self.limit * factors, rows=chosen)
        return np.asarray(np.mean(shifted.severe_chance(velocities, scatter), axis=-2))

    def lines(self, axis: str, loads: Array, velocities: Array) -> Line:
        """Curves of the rise [K] along "load" or "velocity" (`axis`), through k operating points.

        `loads` and `velocities` (k,) are those of the operating points. The returned `Line` has
        curves (m, k): one on each of m surfaces through each point.

        A curve at a load or velocity of the sweep uses only the sweep's points at that value. Any
        other curve is interpolated between the two neighbouring curves, as far as mild or severe
        wear is certain on each of the two. `Line.continued` goes further: its rises are estimated
        from neighbouring curves, or by power laws.
        """
        factor, limit = self.conditions.friction_factor, self.limit
        parts = [rises * factor(self.velocities) for rises in (self._rises, self._filled)]
        if axis == "velocity":
            x, other, place, along = self.velocities, self.loads, loads, velocities
            far, *marks = (curve(place).swapaxes(-1, -2) for curve in self._load_curves)
        else:
            x, other, place, along = self.loads, self.velocities, velocities, loads
            far, *marks = self._rises_and_marks(velocities)
            parts = [rises.swapaxes(-1, -2) for rises in parts]
        nearest = np.minimum(np.searchsorted(other, place), len(other) - 1)
        is_row = np.isin(place, other)
        points, row = (rises[:, nearest] for rises in parts)
        computed, going_on = (
            np.where(is_row[:, None], points, np.where(mark == 1, far, np.nan)) for mark in marks
        )
        has_row = is_row[:, None] & (np.isfinite(row).sum(axis=-1, keepdims=True) > 1)
        far = np.where(has_row, row, far)
        turns_back = self.conditions.has_friction_curve and axis == "velocity"
        if turns_back:  # with friction by velocity, rises beyond the points are no power law
            going_on = computed
        done = np.where(np.isfinite(computed), x, np.nan)
        rise, is_within = self._rise(loads, velocities)
        rise = np.where(is_row, np.nan, rise)
        line = _inserted(x, going_on, along, np.where(is_within, rise, np.nan))
        beyond = _inserted(x, far, along, rise)  # with the rise known at the place
        if turns_back:
            line = along_friction(*line, factor)
        continued = continued_rises(*beyond, factor) if turns_back else Curve(*beyond)
        return Line(Curve(*line), np.array(limit), self.ends[axis], done, continued, turns_back)


def places_of(loads: Places, velocities: Places) -> tuple[Array, Array]:
    """Convert loads and velocities to arrays of the same shape (k,); a single value is repeated."""
    pair = np.broadcast_arrays(*np.atleast_1d(loads, velocities))
    return np.asarray(pair[0], float), np.asarray(pair[1], float)


def _inserted(x: Array, y: Array, places: Array, values: Array) -> tuple[Array, Array]:
    """Insert a point into each curve y(x); return ascending x, and y, each (..., n + 1).

    `places` are the abscissae of the points, and `values` their ordinates. If an ordinate is NaN,
    its abscissa becomes NaN and comes last. A point replaces one of the curve at the same abscissa.
    """
    is_there = np.isfinite(values)[..., None]
    others = np.where(is_there & (x == places[:, None]), np.nan, x)
    wider = np.append(others, np.where(is_there, places[:, None], np.nan), axis=-1)
    order = np.argsort(wider, axis=-1)
    ordinates = np.append(y, values[..., None], axis=-1)
    return np.take_along_axis(wider, order, -1), np.take_along_axis(ordinates, order, -1)


def along_friction(velocities: Array, rises: Array, factor: Any) -> tuple[Array, Array]:
    """Interpolate curves of rises [K] to closely spaced velocities [m/s].

    Returns the new velocities and their rises. `factor` is a function of velocity: the ratio of
    friction to the nominal coefficient of friction. Friction is known at every velocity, so only
    rise/factor is interpolated, and then multiplied by the factor at each new velocity.
    """
    steps = np.diff(velocities)[..., None] * (np.arange(_PARTS) / _PARTS)
    places = (velocities[..., :-1, None] + steps).reshape(*velocities.shape[:-1], -1)
    places[..., ::_PARTS] = velocities[..., :-1]
    places = np.append(places, velocities[..., -1:], axis=-1)
    between = Curve(velocities, rises / factor(velocities))(places) * factor(places)
    between[..., ::_PARTS] = rises
    return places, between


def continued_rises(velocities: Array, rises: Array, factor: Any) -> Curve:
    """Extrapolate curves of rises [K] far beyond their velocities [m/s], both (..., n).

    The rise is a power law of velocity, times `factor`. `factor` is a function of velocity: the
    ratio of friction to the nominal coefficient of friction. A curve to which no power law fits is
    NaN.
    """
    heat = Curve(velocities, rises / factor(velocities))
    heat = Curve(heat.x, np.where(heat.is_log[..., None], heat.y, np.nan))
    (first, _), (last, _) = heat.end(0), heat.end(-1)
    far = np.geomspace(first / _FAR, last * _FAR, _PLACES, axis=-1)
    within = np.linspace(first, last, _PLACES, axis=-1)
    places = np.sort(np.concatenate([far, within, heat.x], axis=-1), axis=-1)
    places[..., 1:] = np.where(places[..., 1:] == places[..., :-1], np.nan, places[..., 1:])
    places = np.sort(places, axis=-1)
    return Curve(places, heat(places, continued=True) * factor(places))


def point_field(whole: Results, conditions: Conditions | None = None) -> PointField:
    """Make a `PointField` from `whole`, the results of one scene.

    Wear is judged under `conditions`; None for the conditions of `whole`. Points at velocity 0 are
    left out.
    """
    conditions, place, scene = conditions or whole.conditions, whole.place, whole.take_moving()
    ends = {
        name: (at, at) if place else range_of(scene, name)
        for name, at in zip(PLANE, place or (np.nan, np.nan), strict=True)
    }
    return PointField(
        planes=planes_of(scene, conditions),
        conditions=conditions,
        promised=velocity_error(scene.sweep),
        ends=ends,
        source=scene,
        from_rest=0.0 in whole.velocities and scene is not whole,
    )


def quantile(values: Array, weights: Array, share: float) -> Array:
    """Weighted quantile of values, over their first axis; `share` is 0.5 for the median.

    The quantile is infinite next to an infinite value, and NaN if any value is NaN.
    """
    if len(values) == 1:
        return np.asarray(values[0])
    order = np.argsort(values, axis=0)
    ranked, weight = np.take_along_axis(values, order, 0), weights[order]
    total, share = np.cumsum(weight, axis=0), share * weights.sum()
    middles, is_known = total - 0.5 * weight, np.isfinite(ranked)
    first = np.argmax(is_known, axis=0)
    last = len(values) - 1 - np.argmax(is_known[::-1], axis=0)
    low = np.clip(first + ((middles <= share) & is_known).sum(axis=0) - 1, first, last)
    high = np.minimum(low + 1, last)

    def at(part: Array, number: Any) -> Array:
        found: Array = np.take_along_axis(part, number[None], 0)[0]
        return found

    with np.errstate(invalid="ignore", divide="ignore"):
        way = (share - at(middles, low)) / (at(middles, high) - at(middles, low))
        way = np.where(high > low, np.clip(way, 0.0, 1.0), 0.0)
        found = at(ranked, low) + way * (at(ranked, high) - at(ranked, low))
    for is_before in (total.round(12) <= round(share, 12), total.round(12) < round(share, 12)):
        beside = at(ranked, np.minimum(is_before.sum(axis=0), len(values) - 1))
        found = np.where(np.isinf(beside), beside, found)
    return np.where(np.isnan(values).any(axis=0), math.nan, found)
