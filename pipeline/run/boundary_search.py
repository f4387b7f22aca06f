"""A sweep that chooses its own velocities, to find the boundary with few points.

Between a mild and a severe velocity a straight line in logarithms finds the critical velocity with
a relative error of κh²/8. Here h is the logarithm of the ratio of the two velocities, and
κ = |d²ln r/d(ln V)²|/(d ln r/d ln V) with the rise r and the velocity V. All loads share a grid of
velocities, whose steps are halved where need be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.store.schema import DONE, FAILED
from pipeline.store.write import Store
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.severity import rise_limit, worst_rises
from pipeline.sweep.variants import Variant
from tribo import InputError, Scene
from tribo.types import Array

_EXPONENT = 0.6  # exponent of the rise over velocity, until it is known
_TREND = -0.8  # exponent of the boundary's velocity over load, until it is known
_CURVATURE = 0.5  # κ until it is known
_LEAST_CURVATURE = 0.2  # least κ, since it may be less by chance when known from few points
_WIDEST = 0.35  # largest h
_STEEPER = 5.0  # largest factor between an extrapolated exponent and _EXPONENT or _TREND
_FINEST = 12  # halvings of the axis
_ROUNDING = 1e-5  # more than the relative change of a velocity when it is rounded to 6 digits
_CLOSER = 10.0  # divides the tolerance where friction by velocity may nearly balance the heat
_EXPECTED = 512  # velocities on which crossings of the limit are sought


class _Root(NamedTuple):
    """Velocity at which the rise is expected to cross the limit; velocities are logarithms.

    `place` is that velocity. `low` and `high` are the nearest velocities below and above it whose
    rise is known.
    """

    place: float
    low: float = -math.inf  # nearest velocities whose rise is known, as logarithms; else infinite
    high: float = math.inf
    bends: Sequence[float] = ()  # values of κ from three velocities about the crossing


@dataclass(frozen=True, slots=True)
class BoundarySearch:
    """Search, at each of several loads, for the velocities at which the rise crosses its limit [K].

    The rise is the temperature rise per unit friction coefficient that the criterion compares with
    `limit`. `lowest` and `highest` [m/s] are the ends of the search, and `tolerance` is the
    relative error that it may leave in velocity.

    The contact solutions at a velocity v may be those of another variant of the scene at velocity
    `scale` × v. Without such reuse `scale` is 1. The search chooses v so that `scale` × v has six
    digits.
    """

    loads: Sequence[float]
    lowest: float
    highest: float
    limit: float
    tolerance: float
    scale: float = 1.0
    #: Factor by which velocity changes friction; the rise may then cross the limit several times.
    factor: Callable[[Array], Array] = np.ones_like

    @classmethod
    def of(cls, sweep: Sweep, tolerance: float, scale: float = 1.0) -> BoundarySearch:
        """Set up the search between a sweep's lowest velocity above 0 and its highest velocity.

        `tolerance` is the relative error that the search may leave in velocity. If friction depends
        on velocity, a tenth of the tolerance is used. `scale` is 1 unless the sweep reuses contact
        solutions of another variant. Then `scale` is the velocity at which the other variant has
        the same contacts, divided by the sweep's velocity.

        Raises an `InputError` if the tolerance is not between 0 and 1, the critical temperature is
        not known, the friction is 0, or fewer than two velocities are above 0.
        """
        if not 0 < tolerance < 1:
            raise InputError(f"the tolerance is {tolerance!r}; it must be between 0 and 1")
        limit = rise_limit(sweep.conditions)
        if not math.isfinite(limit):
            raise InputError("there is no boundary without friction: set friction.coefficient")
        moving = [velocity for velocity in sweep.plane.velocities if velocity > 0]
        if len(moving) < 2:
            raise InputError(f"sweep.velocities above 0: {len(moving)}; give two or more")
        tolerance /= _CLOSER if sweep.conditions.has_friction_curve else 1.0
        ends, factor = (moving[0], moving[-1]), sweep.conditions.friction_factor
        return cls(sweep.plane.loads, *ends, limit, tolerance, scale, factor)

    def wanted(
        self, rises: Mapping[Point, float], failures: Iterable[Point] = ()
    ) -> tuple[Point, ...]:
        """Points to compute next, given the known rises [K] and `failures`, points that failed.

        There are none once the search is done.
        """
        past, chosen = {*rises, *failures}, set[Point]()
        roots = {load: self._roots(*xy) for load in self.loads if (xy := self._points(rises, load))}
        bends = [bend for found in roots.values() for root in found for bend in root.bends]
        curvature = min(max(_LEAST_CURVATURE, 1.5 * max(bends)), 100.0) if bends else _CURVATURE
        for load, expected in (roots | self._first_roots(roots)).items():
            here = {Point(load, v) for root in expected for v in self._refine(root, curvature)}
            if load not in roots and here <= past:
                here = {Point(load, self.lowest), Point(load, self.highest)}
            chosen |= here
        return tuple(sorted(chosen - past, key=lambda point: (point.velocity, point.load)))

    def _points(self, rises: Mapping[Point, float], load: float) -> tuple[Array, ...]:
        """ln(velocity) and ln(rise/factor) at the points of a load whose rise is known.

        The factor is the one by which velocity changes friction. The result is an empty tuple if no
        rise is known.
        """
        known = sorted(
            (point.velocity, rise)
            for point, rise in rises.items()
            if point.load == load and self.lowest <= point.velocity <= self.highest and rise > 0
        )
        if not known:
            return ()
        velocities, values = np.array(known).T
        return np.log(velocities), np.log(values / self.factor(velocities))

    def _roots(self, x: Array, y: Array) -> list[_Root]:
        """Velocities at which the rise is expected to cross its limit, at one load.

        `x` is ln(velocity) of the points whose rise is known, and `y` is ln(rise/factor) there,
        where the factor is the one by which velocity changes friction. Between the points y is
        linear in x, and the factor at each velocity then gives the rise. Without a crossing, the
        result is the highest velocity of the search if the lowest is mild, else the lowest.
        """
        fine = np.linspace(math.log(self.lowest), math.log(self.highest), _EXPECTED)
        fine = np.union1d(fine, x)
        excess = _line(x, y, _EXPONENT, fine) + np.log(self.factor(np.exp(fine)) / self.limit)
        before = np.flatnonzero((excess[1:] >= 0) != (excess[:-1] >= 0))
        if not before.size:
            is_mild = excess[0] < 0
            return [_Root(fine[-1], low=x[-1]) if is_mild else _Root(fine[0], high=x[0])]
        shares = excess[before] / (excess[before] - excess[before + 1])
        places = fine[before] + shares * (fine[before + 1] - fine[before])
        known = np.concatenate([[-math.inf], x, [math.inf]])
        return [
            _Root(place, known[number], known[number + 1], [*_curvatures(x, y, number)])
            for place, number in zip(places, np.searchsorted(x, fine[before], "right"), strict=True)
        ]

    def _first_roots(self, roots: Mapping[float, Sequence[_Root]]) -> dict[float, list[_Root]]:
        """Estimate the velocity at which the rise crosses its limit, at loads without known rises.

        Returns a list with one `_Root` for each such load. `roots` are the crossings expected at
        the other loads; the lowest of each load are interpolated or extrapolated over ln(load). If
        `roots` is empty, only the lowest, the middle and the highest load get an estimate: the
        middle load about the middle of the velocities, the others by a usual power law from there.
        """
        middle = self.loads[len(self.loads) // 2]
        loads = self.loads if roots else (self.loads[0], middle, self.loads[-1])
        known = {math.log(load): found[0].place for load, found in roots.items() if found}
        first = {}
        for load in {*loads} - roots.keys():
            if known:
                x, y = np.array([*known.items()]).T
                place = _line(x, y, _TREND, math.log(load))
            else:  # a node of the axis
                above = _TREND * math.log(load / middle) + math.log(self.scale)
                number = round(self._intervals / 2 + above / self._span)
                place = math.log(self.lowest / self.scale) + number * self._span
            first[load] = [_Root(float(place))]
        return first

    def _refine(self, root: _Root, curvature: float) -> set[float]:
        """Velocities [m/s] to compute next beside a crossing; none if it is known within tolerance.

        They are nodes of a grid of equal steps of ln(velocity). The steps are halved until a node
        lies between the known points beside the crossing. `curvature` is the curvature divided by
        the slope of ln(rise) over ln(velocity), from which the error follows.
        """
        if curvature * (root.high - root.low) ** 2 / 8 <= self.tolerance:
            return set()
        for level in range(_FINEST):
            span = self._span / 2**level
            if level and curvature * (2 * span) ** 2 / 8 <= self.tolerance:
                break
            number = round((root.place + math.log(self.scale / self.lowest)) / span, 9)
            nodes = {self._node_velocity(whole(number), level) for whole in (math.floor, math.ceil)}
            low, high = root.low + _ROUNDING, root.high - _ROUNDING
            if inside := {velocity for velocity in nodes if low < math.log(velocity) < high}:
                return inside
        return set()

    @property
    def _intervals(self) -> int:
        widest = min(_WIDEST, math.sqrt(8 * self.tolerance / _CURVATURE))
        return max(2, math.ceil(math.log(self.highest / self.lowest) / widest))

    @property
    def _span(self) -> float:
        return math.log(self.highest / self.lowest) / self._intervals

    def _node_velocity(self, number: int, level: int) -> float:
        """Velocity [m/s] at node `number` of the search's grid, limited to the sweep's range.

        The grid has equal steps of ln(velocity), which were halved `level` times.
        """
        along = self.lowest * math.exp(number * self._span / 2**level)
        velocity = float(f"{along:.6g}") / self.scale
        if velocity <= self.lowest * (1 + _ROUNDING):
            return self.lowest
        return self.highest if velocity >= self.highest * (1 - _ROUNDING) else velocity


def _line(x: Array, y: Array, slope: float, at: Any) -> Any:
    """Interpolate y(x) linearly at `at`; extrapolate with the slope of the outermost interval.

    Beyond the points the slope stays within a fixed factor of `slope`. If there is only one point,
    the line has the slope `slope`.
    """
    if len(x) == 1:
        return y[0] + slope * (at - x[0])
    slopes = np.diff(y)[[0, -1]] / np.diff(x)[[0, -1]]
    least, most = sorted((slope / _STEEPER, slope * _STEEPER))
    low, high = np.clip(slopes, least, most)
    beyond = low * np.minimum(at - x[0], 0.0) + high * np.maximum(at - x[-1], 0.0)
    return np.interp(at, x, y) + beyond


def _curvatures(x: Array, y: Array, number: int) -> Iterator[float]:
    """Yield κ = |curvature/slope| of the curve y(x) near a crossing, each from three points.

    The crossing is just before the point at index `number`. There are up to two values, and none if
    points are missing or far apart.
    """
    for k in (number - 2, number - 1) if 0 < number < len(x) else ():
        if 0 <= k < len(x) - 2 and x[k + 2] - x[k] < 3 * _WIDEST:
            slopes = np.diff(y[k : k + 3]) / np.diff(x[k : k + 3])
            slope = (y[k + 2] - y[k]) / (x[k + 2] - x[k])
            bend = 2 * (slopes[1] - slopes[0]) / (x[k + 2] - x[k])
            yield abs(bend / slope) if slope > 0 else math.inf


def boundary_search(sweep: Sweep, tolerance: float) -> Callable[..., Sweep]:
    """Return a function that chooses the next points, given the store of a sweep.

    The function returns the sweep whose points are those in the store and those to compute next.
    `tolerance` is the relative error that the search adds to the critical velocity.
    """
    sweep.require_search()
    searches = {
        variant: BoundarySearch.of(sweep.variant(variant), tolerance)
        for variant in sweep.variants.names
    }
    alike: dict[Scene, list[Variant]] = {}  # variants with the same numbers
    for variant in searches:
        alike.setdefault(sweep.variant(variant).scene, []).append(variant)

    def choose_next(store: Store | None, retry_failed: bool = False) -> Sweep:
        rises, failed = results_of(store, sweep) if store else ({}, set())
        chosen = {*rises, *failed}
        for variant, search in searches.items():
            rises_here = {
                Point(*point[:2]): rise for point, rise in rises.items() if point.variant == variant
            }
            failures = {Point(*point[:2]) for point in failed if point.variant == variant}
            added = search.wanted(rises_here, () if retry_failed else failures)
            same = alike[sweep.variant(variant).scene]
            chosen |= {Point(*point[:2], other) for point in added for other in same}
        return replace(sweep, chosen=frozenset(chosen))

    return choose_next


def results_of(store: Store, sweep: Sweep) -> tuple[dict[Point, float], set[Point]]:
    """Rises of the done points of a store by point [K], and the set of its failed points.

    Only points at the loads and in the variants of `sweep` are returned. A rise is the temperature
    rise per unit friction coefficient that the criterion compares with its limit, at the worst step
    of the point.
    """
    columns = store.read_steps()
    (along,) = store.root.variables["load"].dims
    inner = len(store.dims) - store.dims.index(along)  # dimensions after that of loads, and steps
    loads = np.array(store.axes["load"]).reshape(-1, *[1] * inner)
    variants = {variant: sweep.variant(variant).conditions for variant in sweep.variants.names}
    rises = {
        conditions: worst_rises(columns, loads, conditions) for conditions in set(variants.values())
    }

    def swept(flag: int) -> Iterator[tuple[Point, tuple[Any, ...]]]:
        for point in store.points_at(np.nonzero(store.flags == flag)):
            if point.load in sweep.plane.loads and point.variant in variants:
                yield point, store.index(point)

    done = {point: float(rises[variants[point.variant]][index]) for point, index in swept(DONE)}
    return done, {point for point, _ in swept(FAILED)}
