"""One array, y = ln(rise/limit) over load and velocity, from which every answer is read.

The rise is that of the contact temperature which the criterion compares with the critical
temperature, per unit friction coefficient; it is the mean over the patches of a specimen. Its limit
is (critical − bulk temperature)/friction coefficient. Wear is severe where y is above 0.

Between points y is interpolated by a monotone cubic, in ln(velocity) at each load, then in
ln(load). Beyond the velocities of a load it goes on with the last slope.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pipeline.analysis.curve import Curve, filled, neighbours, slots
from pipeline.analysis.left_out import fill_left_out
from pipeline.analysis.outcomes import Turns, turns_of
from pipeline.analysis.outside import why_unknown
from pipeline.analysis.preset_error import velocity_error
from pipeline.analysis.results import Results
from pipeline.analysis.specimen import counted, specimen_at
from pipeline.analysis.warned_points import warning_flags
from pipeline.constants import FARTHEST, PARTS, PARTS_OF_CURVE
from pipeline.store.schema import PLANE
from pipeline.sweep.conditions import Conditions, rise_limit, row_conditions
from tribo import Criterion, InputError, WarningKind
from tribo.types import Array, Indices, Mask

Places = Array | float
"""Loads [N] or velocities [m/s] of k operating points (k,), or a single one for all of them."""


class Known(NamedTuple):
    """What is known of k places."""

    y: Array  # ln(rise/limit) (k,); NaN if unknown
    is_computed: Mask  # True if the place is a computed point
    is_continued: Mask  # True if extrapolated beyond the computed velocities
    reasons: tuple[str, ...]  # why y is unknown; "" if it is known

    def require(self) -> None:
        """Raise an `InputError` with the reason if a place is unknown."""
        for reason in filter(None, self.reasons):
            raise InputError(reason)


@dataclass(frozen=True, eq=False)
class Rises:
    """Rises of one case at its points, and the conditions to judge them by.

    `plane` has the rises per unit friction coefficient, without the effect of velocity on friction;
    NaN where a point is not done. `surface` bounds the relative errors of these rises due to the
    choice of patches. `flags` are sums of `WarningKind` codes, `durations` the times of loading
    [s], and `is_left_out` is True for points that a search of the boundary did not need, all
    (n_load, n_velocity).
    """

    loads: Array
    velocities: Array
    plane: Array
    surface: Array
    flags: Indices
    durations: Array
    is_left_out: Mask
    conditions: Conditions
    promised: float | None  # relative error of critical velocities due to the preset
    ends: Mapping[str, tuple[float, float]]  # range of loads [N] and velocities [m/s] of the sweep
    source: Results = field(repr=False)  # results that the rises are from
    from_rest: bool = False  # True if the sweep also has velocity 0

    @property
    def limit(self) -> float:
        """Limit of the rise per unit friction coefficient [K]; wear is severe above it."""
        return rise_limit(self.conditions)

    def judged_by(self, own: Mapping[str, float]) -> Rises:
        """The rises under conditions of one operating point in place of the scene's.

        `own` has some of ``friction``, ``bulk_temperature`` [K] and ``critical_temperature`` [K].
        """
        return self.under(row_conditions(self.conditions, own)) if own else self

    def under(self, conditions: Conditions) -> Rises:
        """The same points under other conditions."""
        alike = conditions.criterion == self.conditions.criterion
        if alike and conditions.bulk_ratio == self.conditions.bulk_ratio:
            return replace(self, conditions=conditions)  # the same rises per unit friction
        found = specimen_at(self.source, conditions)
        return replace(self, plane=found.rises, surface=found.error, conditions=conditions)

    def y(self, loads: Places, velocities: Places) -> Array:
        """ln(rise/limit) at k pairs of load and velocity; NaN outside the loads."""
        loads, velocities = places_of(loads, velocities)
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(self.rise(loads, velocities)) - np.log(self.limit))

    def known(self, loads: Places, velocities: Places) -> Known:
        """ln(rise/limit) at k pairs within the sweep's range, and how each is known."""
        loads, velocities = places_of(loads, velocities)
        y = self.y(loads, np.where(velocities > 0, velocities, math.nan))
        ranges = {
            name: (min(axis[0], self.ends[name][0]), max(axis[-1], self.ends[name][1]))
            for name, axis in zip(PLANE, (self.loads, self.velocities), strict=True)
        }
        if self.from_rest:
            ranges["velocity"] = 0.0, ranges["velocity"][1]
        places = zip(loads.tolist(), velocities.tolist(), ~np.isnan(y), strict=True)
        reasons = tuple(why_unknown(self.source, ranges, *place) for place in places)
        return Known(
            np.where([not reason for reason in reasons], y, math.nan),
            self.is_done(loads, velocities),
            self.is_continued(loads, velocities),
            reasons,
        )

    def is_continued(self, loads: Array, velocities: Array) -> Mask:
        """True for those of k places that are beyond the computed velocities (k,)."""
        each, back = np.unique(velocities, return_inverse=True)
        marks = self._marks(each, self._is_within(each))[:, back]
        return np.asarray(Curve(self.loads, marks.T)(loads[:, None])[:, 0] != 1)

    def is_done(self, loads: Array, velocities: Array) -> Mask:
        """Mask (k,) of k pairs of load and velocity: True for computed points."""
        at_load, at_velocity = loads[:, None] == self.loads, velocities[:, None] == self.velocities
        return np.asarray(((at_load @ self._is_done) & at_velocity).any(axis=1))

    def rise(self, loads: Places, velocities: Places) -> Array:
        """Rises at k pairs of load and velocity (k,) [K], with the effect of velocity on friction.

        They are per unit of the coefficient of friction.
        """
        loads, velocities = places_of(loads, velocities)
        each, back = np.unique(velocities, return_inverse=True)
        return Curve(self.loads, self._rows(each)[:, back].T)(loads[:, None])[:, 0]

    def _rows(self, velocities: Array, near: slice = slice(None)) -> Array:
        """Rises (n_load, k), with the effect of velocity on friction, also beyond velocities."""
        curve, factor = Curve(self.velocities, self._filled[near]), self.conditions.friction_factor
        rises = curve(velocities, continued=True)
        is_own = (curve.count > 1)[:, None] | (velocities == curve.end(0)[0][:, None])
        return np.where(is_own, rises * factor(velocities), math.nan)

    def _is_within(self, velocities: Array) -> Mask:
        """True where a rise is interpolated between points of its load (n_load, k)."""
        first, last = (end[:, None] for end in self._reaches)
        return np.asarray((first <= velocities) & (velocities <= last))

    def _is_certain(self, velocities: Array) -> Mask:
        """True where the side of the limit is certain at each load (n_load, k)."""
        within = self._is_within(velocities)
        if self.conditions.has_friction_curve:
            return within
        points = Curve(self.velocities, self._known)
        (low, first), (high, last) = ((x[:, None], y[:, None]) for x, y in map(points.end, (0, -1)))
        is_row = (points.count > 1)[:, None]
        is_mild = (velocities < low) & Criterion.is_mild(first, self.limit)
        is_severe = (velocities > high) & Criterion.is_severe(last, self.limit)
        return np.asarray(within | (is_row & (is_mild | is_severe)))

    @functools.cached_property
    def _reaches(self) -> tuple[Array, Array]:
        """First and last velocity with a rise at each load (n_load,); NaN without."""
        points = Curve(self.velocities, self._known)
        return points.end(0)[0], points.end(-1)[0]

    @functools.cached_property
    def _known(self) -> Array:
        """Rises [K]; at loads that a search left out they are estimated near the boundary."""
        is_left_out = np.asarray(self.is_left_out.all(axis=-1))
        return fill_left_out(self.loads, self.velocities, self.plane, is_left_out)

    @functools.cached_property
    def _filled(self) -> Array:
        """Rises [K]; at loads with a single point also those estimated from their neighbours."""
        return filled(self._known, self.loads, self.velocities)

    @functools.cached_property
    def _is_done(self) -> Mask:
        return np.isfinite(self.plane)

    @functools.cached_property
    def _is_known(self) -> Mask:
        return np.isfinite(self._known)

    def turns(self, axis: str, places: Array) -> Turns:
        """Where wear changes along `axis`, "velocity" or "load", through k places on the other.

        A line at a load or velocity of the sweep has only the points there. Any other one ends
        where the side of the limit is no longer certain at both places beside it.
        """
        return self._turns(axis, places, np.array(self.limit), self._is_certain)

    def _turns(
        self, axis: str, places: Array, limits: Array, reaches: Callable[[Array], Mask]
    ) -> Turns:
        """As `turns`, of lines that go as far as `reaches` says of each load (n_load, k)."""
        ends = self.ends[axis]
        if axis == "load":
            is_done = [part[:, None] for part in self._is_known.T]
            own = dict(zip(self.velocities.tolist(), is_done, strict=True))
            within, reached = (
                np.concatenate([own.get(x, rest[:, [k]]) for k, x in enumerate(places.tolist())], 1)
                for rest in (self._is_within(places), reaches(places))
            )
            lines = np.where(reached, self._rows(places), math.nan).T
            done = np.where(within, self.loads[:, None], math.nan).T
            return turns_of(self.loads, lines, limits, done, ends)
        nodes = self._nodes(places, 1.0)
        within, lines = self._lines(places, nodes, self._is_within(nodes), reaches(nodes))
        is_point = np.isfinite(within) & np.isin(nodes, self.velocities)
        done = np.where(is_point, nodes, math.nan)
        return turns_of(nodes, lines, limits, done, ends, self.conditions.has_friction_curve)

    def crossings(self, loads: Array, levels: Sequence[float]) -> tuple[Array, Mask, Mask]:
        """Velocities (k, m, n) at which y crosses m levels at k loads, ascending, then NaN.

        Also masks (k, m): above a level at the lowest velocity, and at the highest.
        """
        nodes = self._nodes(loads, FARTHEST)
        (lines,) = self._lines(loads, nodes, np.ones((len(self.loads), len(nodes)), bool))
        curves = [Curve(nodes, lines / math.exp(level)) for level in levels]
        rows = np.arange(len(loads))
        found = [curve.crossings(np.array(self.limit), rows) for curve in curves]
        most = max(one.shape[-1] for one in found)
        padded = [
            np.pad(one, ((0, 0), (0, most - one.shape[-1])), constant_values=math.nan)
            for one in found
        ]
        first, last = (
            np.stack([curve.end(end)[1] > self.limit for curve in curves], axis=1)
            for end in (0, -1)
        )
        return np.stack(padded, axis=1), first, last

    def _nodes(self, loads: Array, reach: float) -> Array:
        """Velocities at which lines at `loads` are made, a factor of `reach` beyond the points."""
        parts = 1 if np.isin(loads, self.loads).all() else PARTS
        parts = PARTS_OF_CURVE if self.conditions.has_friction_curve else parts
        x = self.velocities
        steps = np.diff(x)[:, None] * (np.arange(parts) / parts)
        inner = np.append((x[:-1, None] + steps).ravel(), x[-1])
        inner[::parts] = x
        if reach == 1.0:
            return inner
        beyond = np.geomspace(1.0, reach, PARTS_OF_CURVE)[1:]
        return np.concatenate([x[0] / beyond[::-1], inner, x[-1] * beyond])

    def _lines(self, loads: Array, nodes: Array, *masks: Mask) -> list[Array]:
        """Rises (k, n) [K] at `loads` and `nodes`, NaN unless a mask (n_load, n) holds around."""
        at, is_own = np.searchsorted(self.loads, loads), np.isin(loads, self.loads)
        near = slice(None)
        if self._is_done.all():  # a cubic between two loads is made of these and one on either side
            near = slice(max(int(at.min()) - 2, 0), int(at.max()) + 2)
        lines = Curve(self.loads[near], self._rows(nodes, near).T)(loads).T
        found = []
        for holds in masks:
            marks = Curve(self.loads[near], self._marks(nodes, holds)[near].T)(loads).T
            own = np.ones_like(holds) if holds.all() else self._is_within(nodes)
            own = own & (self._is_known.sum(axis=1) > 0)[:, None]
            if is_own.all() and not self.conditions.has_friction_curve:
                # Between two points there is no other node, whose value would be interpolated.
                here = np.searchsorted(nodes, self.velocities)
                own[:, here] &= self._is_known
            marks[is_own] = np.where(own[at[is_own]], 1.0, 2.0)
            found.append(np.where(marks == 1, lines, math.nan))
        return found

    def _marks(self, velocities: Array, holds: Mask) -> Array:
        """1 where `holds` (n_load, k), else 2; NaN at a load that tells nothing of others."""
        tells = (self._is_known.sum(axis=1) > 1)[:, None] | self._is_within(velocities)
        # A cubic through these marks is 1 only between two loads at which they are.
        return np.where(tells, np.where(holds, 1.0, 2.0), math.nan)

    def rests_on(self, loads: Array, velocities: Array) -> tuple[Indices, Indices]:
        """Indices of the points between which rises at k pairs of load and velocity are found.

        Returns the indices of two loads (k, 2), and of two velocities at each of these loads
        (k, 2, 2). At a computed point all indices are of this point. An index is -1 if there is no
        point.
        """
        along = slots(self.velocities, velocities)
        rows = self._loads_around[along, slots(self.loads, loads)]
        return rows, self._velocities_around[rows, along[:, None]]

    def have_warning(self, loads: Array, velocities: Array, kind: WarningKind) -> Mask:
        """True for those of k places whose rise is found between points with a warning (k,)."""
        rows, columns = self.rests_on(loads, velocities)
        found = (self.flags[rows[..., None], columns] & kind) != 0
        return np.asarray((found & (columns >= 0)).any(axis=(1, 2)))

    @functools.cached_property
    def _loads_around(self) -> Indices:
        """Indices (2 n_velocity + 1, 2 n_load + 1, 2) of the loads around `slots`, or -1."""
        goes_on = self._is_done.sum(axis=1) >= 2  # rows that can be extrapolated
        reached = np.repeat(goes_on[None], 2 * len(self.velocities) + 1, axis=0)
        reached[1::2] |= self._is_done.T
        return neighbours(reached)

    @functools.cached_property
    def _velocities_around(self) -> Indices:
        """Indices (n_load, 2 n_velocity + 1, 2) of the velocities around `slots`, or -1."""
        return neighbours(self._is_done)


def rises_of(whole: Results, conditions: Conditions | None = None) -> Rises:
    """Rises of `whole`, the results of one scene, judged under `conditions`.

    None stands for the conditions of `whole`. Points at velocity 0 are left out.
    """
    conditions, place, scene = conditions or whole.conditions, whole.place, whole.take_moving()
    scene.require("time")
    ends = {
        name: (at, at) if place else range_of(scene, name)
        for name, at in zip(PLANE, place or (math.nan, math.nan), strict=True)
    }
    shape = -1, len(scene.loads), len(scene.velocities)
    flags = warning_flags(scene).reshape(shape)
    times = np.nan_to_num(scene.columns["time"], nan=-np.inf).max(axis=-1).reshape(shape)
    left_out = (~scene.asked & ~scene.done).reshape(shape)
    counts, specimen = counted(scene), specimen_at(scene, conditions)
    return Rises(
        loads=scene.loads,
        velocities=scene.velocities,
        plane=specimen.rises,
        surface=specimen.error,
        flags=np.bitwise_or.reduce(flags[counts], axis=0),
        durations=times[counts].max(axis=0),
        is_left_out=left_out[0] | specimen.is_alone[:, None],
        conditions=conditions,
        promised=velocity_error(scene.sweep),
        ends=ends,
        source=scene,
        from_rest=0.0 in whole.velocities and scene is not whole,
    )


def range_of(data: Results, axis: str) -> tuple[float, float]:
    """Lowest and highest velocity [m/s] or load [N] (`axis`) of a scene, without 0."""
    present = (data.loads if axis == "load" else data.velocities).tolist()
    of_scene = data.sweep.loads if axis == "load" else data.sweep.velocities
    moving = [value for value in of_scene if value > 0] or present
    return float(min(moving)), float(max(moving))


def places_of(loads: Places, velocities: Places) -> tuple[Array, Array]:
    """Convert loads and velocities to arrays of the same shape (k,); a single value is repeated."""
    pair = np.broadcast_arrays(*np.atleast_1d(loads, velocities))
    return np.asarray(pair[0], float), np.asarray(pair[1], float)
