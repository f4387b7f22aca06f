"""Which points of a store the boundary between mild and severe wear needs next."""

from __future__ import annotations

import bisect
import itertools
import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipeline.run.line_search import Line, places_along
from pipeline.run.plane_search import next_points
from pipeline.store.schema import DONE, FAILED
from pipeline.store.write import Store
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.severity import rise_limit, worst_rises
from pipeline.sweep.stations import load_that_counts
from pipeline.sweep.variants import Variant
from tribo import InputError
from tribo.types import Array, Mask

# In place of 0, which has no logarithm.
_COLDEST = 1e-9  # rise [K]
_LEAST_FACTOR = 1e-6  # of friction
_GIVEN_UP = 3  # failed points of a load, if none is done: then its others are not tried


def require_tolerance(tolerance: float) -> None:
    """Raise an `InputError` unless `tolerance` is a share of a velocity."""
    if isinstance(tolerance, bool) or not 0 < tolerance < 1:
        raise InputError(
            f"boundary_only is {tolerance!r}, the boundary's relative error by points left out; "
            "give a share between 0 and 1, such as 0.01"
        )


def require_boundary(sweep: Sweep, option: str) -> None:
    """Raise an `InputError` unless a sweep has a boundary, which an `option` needs."""
    if any({"load", "velocity"} & row.labels.keys() for row in sweep.rows):
        raise InputError(
            "each row of the sweep has its own load and velocity, so there is no boundary in a "
            f"plane of them; run without {option}"
        )
    if not any(velocity > 0 for velocity in sweep.velocities):
        raise InputError(
            "sweep.velocities has none above 0, so there is no boundary; give others, or run "
            f"without {option}"
        )
    limits = [rise_limit(case.conditions) for case in sweep.cases]
    if not np.isfinite(limits).all():
        raise InputError("there is no boundary without friction: set friction.coefficient")


def beside_boundary(
    store: Store, sweep: Sweep, tolerance: float, only_first: bool = False
) -> list[Point]:
    """Points to compute next for the boundary of each variant; none once it is known.

    `tolerance` is the relative error of the boundary's velocity by points left out. Once the
    boundary is known, the points follow that the scene's tests need for their comparison with it.
    With `only_first` they are on the first of several patches alone.
    """
    reader = RiseReader(store)
    wanted = dict[Point, None]()
    for variant, rows in _planes(sweep, reader).items():
        conditions = sweep.case(variant).conditions
        if not rows or (only_first and not _is_first(variant, sweep)):
            continue
        lines = [_line(row, reader, conditions) for row in rows]
        steps = next_points(np.log([row[0].load for row in rows]), lines, tolerance)
        found = [rows[load][velocity] for load, velocity in steps]
        wanted |= dict.fromkeys(
            found or _beside_tests(sweep.tests, conditions, rows, reader, tolerance)
        )
    return [*wanted]


def on_first_patch(sweep: Sweep) -> list[Point]:
    """Points of a sweep on the first of its patches."""
    return [point for point in points(sweep) if _is_first(point.variant, sweep)]


def on_further_patches(store: Store, sweep: Sweep) -> list[Point]:
    """Points of all patches but the first: at each load the one that is nearest to the boundary.

    It is nearest on the first patch. One point tells enough, since patches differ by nearly a
    constant along velocity.
    """
    reader, nearest = RiseReader(store), dict[tuple[Variant, float], float]()
    for variant, rows in _planes(sweep, reader).items():
        if not _is_first(variant, sweep):
            continue
        for row in rows:
            y = np.abs(_line(row, reader, sweep.case(variant).conditions).y)
            if np.isfinite(y).any():
                nearest[_scene_of(variant), row[0].load] = row[int(np.nanargmin(y))].velocity
    return [
        point
        for point in points(sweep)
        if nearest.get((_scene_of(point.variant), point.load)) == point.velocity
    ]


def _is_first(variant: Variant, sweep: Sweep) -> bool:
    """True on the first of several patches, and on the only one."""
    first = dict(sweep.cases[0].name)
    return dict(variant).get("realization") == first.get("realization")


def _scene_of(variant: Variant) -> Variant:
    """Name of a variant without its patch."""
    return tuple(pair for pair in variant if pair[0] != "realization")


def _planes(sweep: Sweep, reader: RiseReader) -> dict[Variant, list[list[Point]]]:
    """Computable points above velocity 0 by variant, for each load, all ascending."""
    planes = defaultdict[Variant, dict[float, list[Point]]](lambda: defaultdict(list))
    for point in points(sweep):
        if point.velocity > 0:
            planes[point.variant][point.load].append(point)
    return {
        variant: [row for load in sorted(plane) if (row := reader.computable(sorted(plane[load])))]
        for variant, plane in planes.items()
    }


def _beside_tests(
    tests: Sequence[Measurement],
    scene: Conditions,
    rows: Sequence[list[Point]],
    reader: RiseReader,
    tolerance: float,
) -> Iterator[Point]:
    """Points at the loads about each test that show where wear turns severe in the test."""
    loads = [row[0].load for row in rows]
    for test in tests:
        conditions = _conditions_of(test, scene)
        if conditions is None or not loads[0] <= test.normal_load <= loads[-1]:
            continue
        above = bisect.bisect_left(loads, test.normal_load)
        for row in rows[above - (loads[above] != test.normal_load) : above + 1]:
            line = _line(row, reader, conditions)
            step = line.wanted(math.log(test.velocity), tolerance)
            if step is not None:
                yield row[step]


def _conditions_of(test: Measurement, scene: Conditions) -> Conditions | None:
    """Conditions of a test; None if its bulk is above the critical temperature or friction 0."""
    own = scene.replace_friction(test.friction)
    if test.bulk_temperature is not None:
        try:
            own = replace(own, bulk_temperature=test.bulk_temperature, disk_temperature=None)
        except InputError:
            return None
    return own if math.isfinite(rise_limit(own)) else None


def _line(row: Sequence[Point], reader: RiseReader, conditions: Conditions) -> Line:
    """ln(rise/limit) along a row of points at one load."""
    x = np.log([point.velocity for point in row])
    rises = np.fmax(reader.rises(row, conditions), _COLDEST)
    is_known = reader.is_done(row)
    limit = max(rise_limit(conditions), _COLDEST)
    friction = np.maximum(conditions.friction_factor(np.exp(places_along(x))), _LEAST_FACTOR)
    return Line(x, np.where(is_known, np.log(rises / limit), np.nan), np.log(friction))


class RiseReader:
    """Rises at the worst step of the points of a store, under any conditions."""

    def __init__(self, store: Store) -> None:
        self._store, self._columns = store, store.read_steps()
        (along,) = store.root.variables["load"].dims
        inner = len(store.dims) - store.dims.index(along)  # dimensions after loads, and steps
        loads = [load_that_counts(store.sweep.scene, load) for load in store.axes["load"]]
        self._loads = np.array(loads).reshape(-1, *[1] * inner)
        self._rises = dict[Conditions, Array]()

    def is_done(self, row: Sequence[Point]) -> Mask:
        """Mask of the points that are done."""
        return self._has(row, DONE)

    def failed(self, row: Sequence[Point]) -> list[Point]:
        """Those of some points that failed."""
        return [*itertools.compress(row, self._has(row, FAILED))]

    def computable(self, row: Sequence[Point]) -> list[Point]:
        """Those of the points of one load that did not fail; none if this load is given up."""
        failed = self.failed(row)
        is_given_up = len(failed) >= _GIVEN_UP and not self.is_done(row).any()
        return [] if is_given_up else [point for point in row if point not in failed]

    def _has(self, row: Sequence[Point], flag: int) -> Mask:
        return np.array([self._store.flags[self._store.index(point)] == flag for point in row])

    def rises(self, row: Sequence[Point], conditions: Conditions) -> Array:
        """Rise per unit friction coefficient that the criterion compares with its limit [K].

        It is NaN at points that are not done, and at points without a contact.
        """
        if conditions not in self._rises:
            self._rises[conditions] = worst_rises(self._columns, self._loads, conditions)
        found = self._rises[conditions]
        return np.array([found[self._store.index(point)] for point in row])
