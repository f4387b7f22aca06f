"""Which points of a store the boundary between mild and severe wear needs next."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pipeline.run.line_search import Line, places_along
from pipeline.run.plane_search import next_points
from pipeline.store.schema import DONE, FAILED
from pipeline.store.write import Store
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.severity import rise_limit, worst_rises
from tribo import InputError

USUAL_TOLERANCE = 0.01
"""Relative error of the boundary's velocity by points left out, if none is given."""

# In place of 0, which has no logarithm.
_COLDEST = 1e-9  # rise [K]
_LEAST_FACTOR = 1e-6  # of friction


def require_boundary(sweep: Sweep, tolerance: float) -> None:
    """Raise an `InputError` unless a sweep has a boundary that can be searched."""
    if isinstance(tolerance, bool) or not 0 < tolerance < 1:
        raise InputError(
            f"boundary_only is {tolerance!r}, the boundary's relative error by points left out; "
            "give a share between 0 and 1, such as 0.01"
        )
    if any({"load", "velocity"} & row.labels.keys() for row in sweep.rows):
        raise InputError(
            "each row of the sweep has its own load and velocity, so there is no boundary in a "
            "plane of them; run without --boundary-only"
        )
    if not any(velocity > 0 for velocity in sweep.plane.velocities):
        raise InputError(
            "sweep.velocities has none above 0, so there is no boundary; give others, or run "
            "without --boundary-only"
        )
    limits = [rise_limit(sweep.variant(name).conditions) for name in sweep.variants.names]
    if not np.isfinite(limits).all():
        raise InputError("there is no boundary without friction: set friction.coefficient")


def beside_boundary(store: Store, sweep: Sweep, tolerance: float) -> list[Point]:
    """Points to compute next for the boundary of each variant; none once it is known.

    `tolerance` is the relative error of the boundary's velocity by points left out.
    """
    rises, failed = results_of(store, sweep)
    planes = defaultdict[Any, dict[float, list[Point]]](lambda: defaultdict(list))
    for point in points(sweep):
        if point.velocity > 0 and point not in failed:
            planes[point.variant][point.load].append(point)
    wanted = list[Point]()
    for variant, plane in planes.items():
        conditions, loads = sweep.variant(variant).conditions, sorted(plane)
        rows = [sorted(plane[load]) for load in loads]
        lines = [_line(row, rises, conditions) for row in rows]
        steps = next_points(np.log(loads), lines, tolerance)
        wanted += [rows[load][velocity] for load, velocity in steps]
    return wanted


def _line(row: list[Point], rises: Mapping[Point, float], conditions: Conditions) -> Line:
    """ln(rise/limit) along a row of points at one load."""
    x = np.log([point.velocity for point in row])
    limit = max(rise_limit(conditions), _COLDEST)
    known = [max(rises[point], _COLDEST) if point in rises else np.nan for point in row]
    friction = np.maximum(conditions.friction_factor(np.exp(places_along(x))), _LEAST_FACTOR)
    return Line(x, np.log(np.array(known) / limit), np.log(friction))


def results_of(store: Store, sweep: Sweep) -> tuple[dict[Point, float], set[Point]]:
    """Rises of the done points of a store by point [K], and the set of its failed points.

    Only points at the loads and in the variants of `sweep` are returned. A rise is the temperature
    rise per unit friction coefficient that the criterion compares with its limit, at the worst step
    of the point. A done point without a rise counts as failed.
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
    without = {point for point, rise in done.items() if np.isnan(rise)}
    done = {point: rise for point, rise in done.items() if point not in without}
    return done, without | {point for point, _ in swept(FAILED)}
