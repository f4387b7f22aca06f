"""Which points of a plane the boundary needs: at each load, those beside it along velocity."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.store.schema import DONE, FAILED
from pipeline.store.write import Store
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from pipeline.sweep.severity import rise_limit, worst_rises
from tribo import InputError

_BESIDE = 1  # further points on each side of the boundary, for a smooth interpolation


def beside_boundary(store: Store, sweep: Sweep) -> list[Point]:
    """Pending points to compute next for the boundary of each variant; none once it is known.

    At each load the velocities are bisected until neighbours are mild and severe. The first ones
    tried are those beside the boundary of the nearest load that is known.
    """
    lines: dict[tuple[object, float], list[Point]] = {}
    for point in points(sweep):
        if point.velocity > 0:
            lines.setdefault((point.variant, point.load), []).append(point)
    severe = _outcomes(store, sweep)
    ends = {key: _ends(line, severe) for key, line in lines.items()}
    found = {key: high for key, (low, high) in ends.items() if high - low == 1}
    wanted = list[Point]()
    for (variant, load), line in lines.items():
        low, high = ends[variant, load]
        hint = None
        if found and not any(point in severe for point in line):
            nearest = min(found, key=lambda key: (key[0] != variant, abs(np.log(key[1] / load))))
            hint = found[nearest]
        wanted += [line[place] for place in _next(low, high, len(line), hint)]
    return [point for point in wanted if point not in severe]


def _next(low: int, high: int, count: int, hint: int | None) -> Iterator[int]:
    """Places to try, given the highest mild place, the lowest severe one, and a first guess."""
    if high - low == 1:
        yield from range(max(0, low - _BESIDE), min(count, high + _BESIDE + 1))
    elif hint is None:
        yield (low + high) // 2
    else:
        yield from {min(max(place, 0), count - 1) for place in (hint - 1, hint)}


def _ends(line: Sequence[Point], severe: Mapping[Point, bool | None]) -> tuple[int, int]:
    """Highest place known to be mild below the lowest one known to be severe; −1 or n without."""
    states = [severe.get(point) for point in line]
    high = states.index(True) if True in states else len(line)
    mild = [place for place in range(high) if states[place] is False]
    low = mild[-1] if mild else -1
    while low + 1 < high and severe.get(line[low + 1], False) is None:  # failed: as if mild
        low += 1
    return low, high


def _outcomes(store: Store, sweep: Sweep) -> dict[Point, bool | None]:
    """Whether wear is severe at each computed point of a store; None where it failed."""
    conditions = {name: sweep.variant(name).conditions for name in sweep.variants.names}
    limits = {name: rise_limit(one) for name, one in conditions.items()}
    if not all(map(np.isfinite, limits.values())):
        raise InputError("there is no boundary without friction: set friction.coefficient")
    rises, failed = results_of(store, sweep)
    severe = {point: rise > limits[point.variant] for point, rise in rises.items()}
    return severe | dict.fromkeys(failed)


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
