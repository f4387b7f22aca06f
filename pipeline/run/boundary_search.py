"""A sweep that chooses its own velocities, to find the boundary with few points.

Between a mild and a severe velocity a straight line in logarithms finds the crossing to κh²/8; h is
the logarithm of their ratio, κ = |d²ln r/d(ln V)²|/(d ln r/d ln V). All loads share an axis of
velocities, which is halved where need be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

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
_LEAST_CURVATURE = 0.2  # known from a few points, it may be less by chance
_WIDEST = 0.35  # largest h
_NEAR = 0.1  # share of h: how near to a node a crossing must be expected to ask beyond it
_FINEST = 12  # halvings of the axis
_ROUNDING = 1e-5  # relative, of a velocity in round figures, and more
_CLOSER = 10.0  # divides the tolerance where friction by velocity may nearly balance the heat
_EXPECTED = 512  # velocities among which turns are expected

Row = list[tuple[float, float]]
"""Velocities and rises at a load."""
Rows = Mapping[float, Row]


@dataclass(frozen=True, slots=True)
class BoundarySearch:
    """A search for the velocity, divided by `scale`, of a rise [K] at each of several loads."""

    loads: Sequence[float]
    lowest: float
    highest: float
    limit: float
    tolerance: float
    scale: float = 1.0
    #: Factor of the friction by velocity, with which wear may turn several times.
    factor: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        if not 0 < self.tolerance < 1:
            raise InputError(f"the tolerance is {self.tolerance!r}; it must be between 0 and 1")

    @classmethod
    def of(cls, sweep: Sweep, tolerance: float, scale: float = 1.0) -> BoundarySearch:
        """A search between a sweep's lowest and highest velocity; `InputError` if there is none."""
        limit = rise_limit(sweep.conditions)
        if not math.isfinite(limit):
            raise InputError(
                "there is no boundary to look for without friction; give friction.coefficient a "
                "number above 0"
            )
        moving = [velocity for velocity in sweep.plane.velocities if velocity > 0]
        if len(moving) < 2:
            listed = ", ".join(f"{velocity:g}" for velocity in sweep.plane.velocities)
            raise InputError(
                f"there is no boundary to look for where sweep.velocities are {listed} m/s; give "
                "two or more above 0"
            )
        factor = sweep.conditions.friction_factor if sweep.conditions.has_friction_curve else None
        tolerance /= _CLOSER if factor else 1.0
        return cls(sweep.plane.loads, moving[0], moving[-1], limit, tolerance, scale, factor)

    def wanted(
        self, rises: Mapping[Point, float], hopeless: Iterable[Point] = ()
    ) -> tuple[Point, ...]:
        """Points to compute next by known rises [K], but failed ones; none once all is known."""
        rows = {load: self._row(rises, load) for load in self.loads}
        past = set(rises) | set(hopeless)
        asked = self._asked_turns(rows, past) if self.factor else self._asked(rows)
        fresh = asked - past
        return tuple(sorted(fresh, key=lambda point: (point.velocity, point.load)))

    def _asked(self, rows: Rows) -> set[Point]:
        """Points about the one transition of each load."""
        guesses = self._guesses(rows)
        if not guesses:
            ends = (self.loads[0], self.loads[len(self.loads) // 2], self.loads[-1])
            return {Point(load, self._first_node(load)) for load in ends}
        curvature, asked = self._curvature(rows), set()
        for load, guess in guesses.items():
            asked |= {Point(load, v) for v in self._next(rows[load], guess, curvature)}
        return asked

    def _asked_turns(self, rows: Rows, past: Set[Point]) -> set[Point]:
        """Points about all turns of each load, or at its ends.

        The heat, which is all that points tell, passes at each the one value that turns wear there.
        """
        asked = set()
        for load, row in rows.items():
            first = Point(load, self._first_node(load))
            if not row and first not in past:
                asked.add(first)
                continue
            turns = self._turns(row) if row else {}
            for turn, heat in turns.items():
                search = replace(self, limit=heat, factor=None)
                nodes = search._next(row, turn, search._curvature(rows))
                asked |= {Point(load, velocity) for velocity in nodes}
            if not turns:
                asked |= {Point(load, self.lowest), Point(load, self.highest)}
        return asked

    def _turns(self, row: Row) -> dict[float, float]:
        """Logarithms of the velocities at which wear is expected to turn, with the heat there."""
        assert self.factor  # for the type checker
        x, y = np.log(np.array(row)).T
        fine = np.linspace(math.log(self.lowest), math.log(self.highest), _EXPECTED)
        limits = self.limit / self.factor(np.exp(fine))
        is_severe = _line(x, y, _EXPONENT)(fine) > np.log(limits)
        before = np.flatnonzero(is_severe[1:] != is_severe[:-1])
        return dict(zip(fine[before].tolist(), limits[before].tolist(), strict=True))

    def _first_node(self, load: float) -> float:
        """The velocity of the axis to begin with: in its middle at the middle load."""
        above = _TREND * math.log(load / self.loads[len(self.loads) // 2])
        number = round(self._intervals() / 2 + (above + math.log(self.scale)) / self._span())
        return self._node(number, 0)

    def _row(self, rises: Mapping[Point, float], load: float) -> Row:
        """Velocities and rises that are known at a load, in the range, without their friction."""
        return sorted(
            (
                point.velocity,
                rise / (float(self.factor(np.array(point.velocity))) if self.factor else 1.0),
            )
            for point, rise in rises.items()
            if point.load == load and self.lowest <= point.velocity <= self.highest and rise > 0
        )

    def _bracket(self, row: Row) -> tuple[float | None, float | None]:
        """Velocities next to the first crossing: mild and severe, None where there is none."""
        high = next((velocity for velocity, rise in row if rise >= self.limit), None)
        mild = [velocity for velocity, _ in row if high is None or velocity < high]
        return (mild[-1] if mild else None), high

    def _curvature(self, rows: Rows) -> float:
        """The greatest κ by three velocities about a crossing, with a margin."""
        curvatures = []
        for row in rows.values():
            low, high = self._bracket(row)
            if low is None or high is None or len(row) < 3:
                continue
            x, y = np.log(np.array(row)).T
            first = [velocity for velocity, _ in row].index(low)
            for k in (first - 1, first):
                if 0 <= k < len(row) - 2 and x[k + 2] - x[k] < 3 * _WIDEST:
                    slopes = np.diff(y[k : k + 3]) / np.diff(x[k : k + 3])
                    slope = (y[k + 2] - y[k]) / (x[k + 2] - x[k])
                    bend = 2 * (slopes[1] - slopes[0]) / (x[k + 2] - x[k])
                    curvatures.append(abs(bend / slope) if slope > 0 else math.inf)
        if not curvatures:
            return _CURVATURE
        return min(max(_LEAST_CURVATURE, 1.5 * max(curvatures)), 100.0)

    def _guesses(self, rows: Rows) -> dict[float, float]:
        """Logarithm of the critical velocity at each load, as far as can be told."""
        by_load = {load: self._guess(row) for load, row in rows.items() if row}
        if not by_load:
            return {}
        line = _line(np.log(list(by_load)), np.array(list(by_load.values())), _TREND)
        return {load: by_load.get(load, float(line(math.log(load)))) for load in self.loads}

    def _guess(self, row: Row) -> float:
        """Logarithm of the critical velocity, by the straight line through the nearest two."""
        x, y = np.log(np.array(row)).T
        y = y - math.log(self.limit)
        if len(row) == 1:
            return float(x[0] - y[0] / _EXPONENT)
        k = int(np.clip(np.searchsorted(y >= 0, True), 1, len(row) - 1))
        slope = (y[k] - y[k - 1]) / (x[k] - x[k - 1])
        return float(x[k] - y[k] / min(max(slope, 0.2), 3.0))

    def _next(self, row: Row, guess: float, curvature: float) -> Iterable[float]:
        """Velocities to look at next at one load."""
        low, high = self._bracket(row)
        log_ends = math.log(low or self.lowest), math.log(high or self.highest)
        if low is not None and high is not None:
            span = log_ends[1] - log_ends[0]
            if curvature * span**2 / 8 <= self.tolerance:
                return []
        elif (low == self.highest) or (high == self.lowest):
            return []
        # Nodes about the guess, on the coarsest axis that has one in between.
        guess = min(max(guess, log_ends[0]), log_ends[1])
        for level in range(_FINEST):
            span = self._span() / 2**level
            if level and curvature * (2 * span) ** 2 / 8 <= self.tolerance:
                return []
            k = (guess + math.log(self.scale / self.lowest)) / span
            below, above = math.floor(k), math.ceil(k)
            nodes = {below, above} | ({below + 1} if below == above else set())
            if not (low and high):
                nodes |= {below - 1} if k - below < _NEAR else set()
                nodes |= {above + 1} if above - k < _NEAR else set()
            asked = {self._node(node, level) for node in nodes}
            inside = {v for v in asked if (low is None or v > low) and (high is None or v < high)}
            if inside:
                return inside
        return []

    def _intervals(self) -> int:
        widest = min(_WIDEST, math.sqrt(8 * self.tolerance / _CURVATURE))
        return max(2, math.ceil(math.log(self.highest / self.lowest) / widest))

    def _span(self) -> float:
        return math.log(self.highest / self.lowest) / self._intervals()

    def _node(self, number: int, level: int) -> float:
        """A velocity of the axis, in round figures but for the scale; the nearer end beyond it."""
        along = self.lowest * math.exp(number * self._span() / 2**level)
        velocity = float(f"{along:.6g}") / self.scale
        if velocity <= self.lowest * (1 + _ROUNDING):
            return self.lowest
        return self.highest if velocity >= self.highest * (1 - _ROUNDING) else velocity


def _line(x: Array, y: Array, slope: float) -> BSpline:
    """Straight lines through points, also beyond their ends; of this slope through a single one."""
    if len(x) == 1:
        x, y = np.append(x, x + 1.0), np.append(y, y + slope)
    return make_interp_spline(x, y, k=1)


def boundary_search(sweep: Sweep, tolerance: float) -> Callable[..., Sweep]:
    """What gives the sweep of a store's points and of those to compute next, if there are any.

    The tolerance is the relative error of the critical velocity that the search adds.
    """
    sweep.require_search()
    searches = {
        variant: BoundarySearch.of(sweep.variant(variant), tolerance, sweep.leads[variant].ratio)
        for variant in sweep.variants.names
    }
    alike: dict[Scene, list[Variant]] = {}  # whose points have the same numbers
    for variant in searches:
        alike.setdefault(sweep.variant(variant).scene, []).append(variant)

    def further(store: Store | None, retry_failed: bool = False) -> Sweep:
        rises, failed = results_of(store, sweep) if store else ({}, set())
        chosen = {*rises, *failed}
        for variant, search in searches.items():
            rises_here = {
                Point(*point[:2]): rise for point, rise in rises.items() if point.variant == variant
            }
            hopeless = {Point(*point[:2]) for point in failed if point.variant == variant}
            asked = search.wanted(rises_here, () if retry_failed else hopeless)
            same = alike[sweep.variant(variant).scene]
            chosen |= {Point(*point[:2], other) for point in asked for other in same}
        return replace(sweep, chosen=frozenset(chosen))

    return further


def results_of(store: Store, sweep: Sweep) -> tuple[dict[Point, float], set[Point]]:
    """Decisive rise of each point of a store that is done [K], and points that failed."""
    columns = store.read_steps()
    inner = len(store.dims) - store.dims.index(store.along("load"))  # dimensions, with the step
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
