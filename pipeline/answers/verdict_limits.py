"""Mild and severe limits: where the verdict changes along a line of load, velocity or friction.

The mild limit is the largest value up to which the verdict is mild, the severe limit the smallest
from which it is severe. Both are found by bisection of the verdict itself, so they contain all that
it contains: errors, tests, films, and places without an answer. The verdict at a limit is the one
that the limit is named after.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pipeline.answers.condition_values import QueryPoints, override_conditions
from pipeline.answers.results import cases_of
from pipeline.answers.verdict_model import (
    MILD,
    OUTSIDE,
    SEVERE,
    UNDECIDED,
    VerdictModel,
    verdict_model,
)
from tribo.types import Array, Indices, Mask

Side = IntEnum("Side", "INSIDE ABOVE BELOW OUTSIDE_MODEL UNKNOWN", start=0)
"""Codes of where a limit lies: inside the sweep, above or below it, or nowhere.

A mild limit is nowhere on a line whose lowest place is outside the model, or unknown, and which is
not mild from the first place with a verdict; likewise a severe limit from the highest place. On a
line of a single simulated value it is unknown.
"""
_NOWHERE = Side.OUTSIDE_MODEL, Side.UNKNOWN
_PARTS_OF_GAP = 12  # between two simulated values
_BISECTIONS = 24  # of the ratio of neighbouring nodes, to 1e-8 of a limit
_MOST_AT_ONCE = 4  # bisections; all numbers up to it divide `_BISECTIONS`
_SMALL_BATCH = 1000  # values, which take four times as long to judge as one
_LOG_FRICTIONS = 25.0  # largest |ln(limit over computed critical friction)|
_BATCH_SIZE = 4000
_JUST_BELOW = 1 - 1e-6  # of the load of a test, from which it rules verdicts out
_DIGITS = 6  # of a limit, which is rounded to its own side


class Limits(NamedTuple):
    """Limits on k lines, NaN outside the sweep, with codes of `Side`."""

    values: Array
    sides: Indices


def line_limits(
    model: VerdictModel,
    axis: str,
    kinds: Sequence[int],
    points: QueryPoints,
    verdicts: Indices | None,
) -> list[Limits]:
    """Limits of each kind, `MILD` or `SEVERE`, along `axis`, load or velocity, through k points.

    A line begins at its lowest place with a verdict for mild wear, at its highest for severe wear.
    With the `verdicts` at the points, a point inside a separate stretch of the kind has the limit
    of this stretch, so that a limit never contradicts the verdict at its point.
    """
    positions = getattr(points, axis)
    if verdicts is None:
        positions, verdicts = np.full(positions.shape, np.nan), np.full(positions.shape, -1)
    simulated = model.field.loads if axis == "load" else model.field.velocities
    nodes = dense_values(np.union1d(simulated, model.ranges[axis]))
    if len(nodes) < 2 or not positions.size:
        shape = positions.shape
        return [Limits(np.full(shape, np.nan), np.full(shape, Side.UNKNOWN, np.int8))] * len(kinds)
    across = points.load if axis == "velocity" else points.velocity
    line_keys = np.stack([across, points.friction, points.bulk_temperature])
    _, first, line = np.unique(line_keys, axis=1, return_index=True, return_inverse=True)
    lines, line = points.take(first), line.ravel()
    codes, brackets = _codes(model, axis, lines, nodes)[line], []
    for kind in kinds:
        order = -1 if kind == SEVERE else 1  # from the highest value downwards for severe wear
        brackets.append(_brackets(nodes[::order], codes[:, ::order], positions, verdicts, kind))
    lower, upper, sides = (np.concatenate(arrays) for arrays in zip(*brackets, strict=True))
    values, is_inside = np.full(lower.shape, np.nan), sides == Side.INSIDE
    if is_inside.any():
        rows = np.repeat(kinds, len(line)), np.tile(line, len(kinds)), lower, upper
        keys, inverse = np.unique(np.stack(rows)[:, is_inside], axis=1, return_inverse=True)
        kind_of_key, line_of_key, inside, beyond = keys
        key_lines = lines.take(line_of_key.astype(int))
        limits = _bisect(model, axis, kind_of_key, key_lines, inside, beyond)
        values[is_inside] = _rounded(limits, inside, kind_of_key)[inverse.ravel()]
    return [
        Limits(limits, _sides(kind, sides_of_kind))
        for kind, limits, sides_of_kind in zip(
            kinds, np.split(values, len(kinds)), np.split(sides, len(kinds)), strict=True
        )
    ]


def _sides(kind: int, sides: Indices) -> Indices:
    """Sides as seen towards higher values, from those as seen along the line of a `kind`."""
    if kind == SEVERE:
        sides = np.choose(sides, [Side.INSIDE, Side.BELOW, Side.ABOVE, *_NOWHERE])
    return sides.astype(np.int8)


def dense_values(simulated: Array) -> Array:
    """Ascending values on a line: the simulated ones, and others between, dense next to these.

    The interpolation error is 0 at simulated values, and steep next to them.
    """
    u = np.arange(_PARTS_OF_GAP) / _PARTS_OF_GAP
    fractions = u**3 * (10 - 15 * u + 6 * u**2)
    inner = simulated[:-1, None] + np.diff(simulated)[:, None] * fractions
    return np.append(inner.ravel(), simulated[-1:])


def _codes(model: VerdictModel, axis: str, lines: QueryPoints, nodes: Array) -> Indices:
    """Verdicts (k, m) at m nodes on each of k lines."""
    count = len(lines.load)
    indices, at = np.repeat(np.arange(count), len(nodes)), np.tile(nodes, count)
    codes = np.empty(len(at), int)
    for batch in np.array_split(np.arange(len(at)), -(-len(at) // _BATCH_SIZE)):
        codes[batch] = model.verdicts(lines.take(indices[batch])._replace(**{axis: at[batch]}))
    return codes.reshape(count, -1)


def _brackets(
    nodes: Array, codes: Indices, positions: Array, verdicts: Indices, verdict: int
) -> tuple[Array, Array, Indices]:
    """Neighbours (k,) of each limit: the last value with `verdict`, and the first without it.

    The third array has sides as seen along `nodes`: ABOVE if the line ends with `verdict`.
    `positions` and `verdicts` are those of points on the lines.
    """
    index, sign = np.arange(len(nodes)), np.sign(nodes[-1] - nodes[0])
    has_verdict = codes <= SEVERE
    start = np.where(has_verdict.any(axis=1), has_verdict.argmax(axis=1), len(nodes))
    is_point_in = verdicts == verdict
    with np.errstate(invalid="ignore"):
        next_node = (sign * nodes <= sign * positions[:, None]).sum(axis=1)
        is_past_start = sign * positions > sign * nodes[np.minimum(start, len(nodes) - 1)]
    start = np.where(is_point_in, next_node, start)
    is_stop = (codes != verdict) & (index >= start[:, None])
    stop = np.where(is_stop.any(axis=1), is_stop.argmax(axis=1), len(nodes))
    edge = np.append(nodes, sign * np.inf)[stop]
    # A point without the verdict may lie between two nodes with it.
    is_blocking = ~is_point_in & (verdicts >= 0) & is_past_start
    edge = np.where(is_blocking & (sign * positions < sign * edge), positions, edge)
    before = np.maximum((sign * nodes < sign * edge[:, None]).sum(axis=1) - 1, 0)
    last = nodes[before]
    last = np.where(is_point_in & (sign * positions > sign * last), positions, last)
    sides = np.full(len(stop), Side.INSIDE)
    sides[~np.isfinite(edge)] = Side.ABOVE
    sides[(stop == start) & ~is_point_in] = Side.BELOW
    is_nowhere = (start > 0) & (stop == start) & ~is_point_in
    sides[is_nowhere] = np.where(codes[:, 0] == OUTSIDE, Side.OUTSIDE_MODEL, Side.UNKNOWN)[
        is_nowhere
    ]
    return last, edge, sides


class Stretches(NamedTuple):
    """Stretches (n,) of lines on which all values have one verdict, from `start` to `end`."""

    line: Indices
    start: Array
    end: Array


def stretches(model: VerdictModel, points: QueryPoints) -> dict[int, Stretches]:
    """Stretches of each verdict on the lines of velocity through k points, by its code.

    An edge of mild wear at its upper end, or of severe wear at its lower one, is a limit. Undecided
    stretches, which fill what the others leave, end at nodes.
    """
    nodes = dense_values(np.union1d(model.field.velocities, model.ranges["velocity"]))
    codes, by_code = _codes(model, "velocity", points, nodes), dict[int, Stretches]()
    for code in np.unique(codes).tolist():
        is_change = np.diff(np.pad(codes == code, ((0, 0), (1, 1))).astype(int), axis=1)
        (line, first), (_, after) = np.nonzero(is_change == 1), np.nonzero(is_change == -1)
        start, end = nodes[first], nodes[after - 1]
        by_code[code] = Stretches(line, start, end)
        if code == UNDECIDED:
            continue
        for edge, limit_code, is_inner, beyond in (
            (start, SEVERE, first > 0, first - 1),
            (end, MILD, after < len(nodes), after),
        ):
            inside, lines = edge[is_inner], points.take(line[is_inner])
            last = _bisect(model, "velocity", code, lines, inside, nodes[beyond[is_inner]])
            edge[is_inner] = _rounded(last, inside, code) if code == limit_code else last
    return by_code


def friction_limits(model: VerdictModel, points: QueryPoints, critical: Array) -> Limits:
    """Mild limits of friction at k points, whose computed `critical` frictions are known."""
    rises, all_points = model.rises(points), np.arange(len(critical))

    def is_mild(friction: Array, point: Indices) -> Mask:
        at = points.take(point)._replace(friction=friction)
        return np.asarray(model.judge(at, rises.take(point)).verdict == MILD)

    lower, upper = (critical * np.exp(sign * _LOG_FRICTIONS) for sign in (-1, 1))
    is_below, is_above = ~is_mild(lower, all_points), is_mild(upper, all_points)
    at_point = is_mild(points.friction, all_points)
    lower = np.where(at_point, np.maximum(lower, points.friction), lower)
    upper = np.where(at_point, upper, np.minimum(upper, points.friction))
    limits = _rounded(_last_in(is_mild, lower, upper, 2 * _BISECTIONS), lower, MILD)
    codes = (*map(int, _NOWHERE), int(Side.BELOW), int(Side.ABOVE))
    is_nowhere = rises.is_outside, np.isnan(critical)
    sides = np.select((*is_nowhere, is_below, is_above), codes, int(Side.INSIDE))
    return Limits(np.where(sides == Side.INSIDE, limits, np.nan), sides.astype(np.int8))


def _bisect(
    model: VerdictModel,
    axis: str,
    verdict: int | Array,
    lines: QueryPoints,
    last: Array,
    edge: Array,
) -> Array:
    """Last values (k,) with `verdict` on lines, between those with it and those without it."""

    def is_in(values: Array, line: Indices) -> Mask:
        codes = model.verdicts(lines.take(line)._replace(**{axis: values}))
        return np.asarray(codes == np.broadcast_to(verdict, last.shape)[line])

    return _last_in(is_in, last, edge, _BISECTIONS)


def _last_in(
    is_in: Callable[[Array, Indices], Mask], last: Array, edge: Array, bisections: int
) -> Array:
    """Last values (k,) that are in, each between `last`, which is in, and `edge`, which is not.

    `is_in` takes values and the line of each. Where lines are few, it takes several values of each
    at once, since a hundred values cost little more than one.
    """
    lines = np.arange(len(last))
    at_once = int(np.clip(np.log2(_SMALL_BATCH / max(len(last), 1)), 1, _MOST_AT_ONCE))
    fractions = np.arange(1, 2**at_once) / 2**at_once
    for _ in range(bisections // at_once):
        inner = last[:, None] * (edge / last)[:, None] ** fractions
        is_inner_in = is_in(inner.ravel(), np.repeat(lines, len(fractions))).reshape(inner.shape)
        first_out = np.where(is_inner_in.all(axis=1), len(fractions), is_inner_in.argmin(axis=1))
        values = np.column_stack([last, inner, edge])
        last, edge = values[lines, first_out], values[lines, first_out + 1]
    return last


def _rounded(limits: Array, inside: Array, verdict: int | Array) -> Array:
    """Limits (k,) rounded to `_DIGITS` towards values `inside` of them, but no farther."""
    lowered = np.maximum(round_to(np.floor, limits), inside)
    raised = np.minimum(round_to(np.ceil, limits), inside)
    return np.where(np.equal(verdict, MILD), lowered, raised)


def round_to(side: Callable[[Array], Array], limits: Array) -> Array:
    """Limits rounded to `_DIGITS` to a `side`, by `numpy.floor` or `numpy.ceil`."""
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = 10.0 ** (np.floor(np.log10(limits)) - _DIGITS + 1)
    return np.asarray(side(limits / unit) * unit)


# Regions of one verdict in the plane of load and velocity, for figures


class Region(NamedTuple):
    """Part of the plane with one verdict: at each of its loads (n,), from `start` to `end`."""

    loads: Array  # ascending [N]
    start: Array  # [m/s]
    end: Array


def regions(ds: xr.Dataset, conditions: Mapping[str, Any]) -> dict[int, list[Region]]:
    """Regions of each verdict of the first case of a sweep, by the verdict's code.

    Edges of mild and severe wear are the limits.
    """
    case = cases_of(ds)[0]
    model = verdict_model(case, override_conditions(case.conditions, conditions))
    loads = _dense_loads(model)
    by_code = stretches(model, QueryPoints.under(model.conditions, loads, loads))
    return {code: [*_joined_stretches(loads, parts)] for code, parts in by_code.items()}


def _dense_loads(model: VerdictModel) -> Array:
    """Loads (n,) dense enough for smooth edges, with corners at tests and at ends of the plane."""
    low, high = model.ranges["load"]
    ends = np.array(model.ranges["velocity"])
    points = QueryPoints.under(model.conditions, ends, ends)
    limits = [x.values for x in line_limits(model, "load", (MILD, SEVERE), points, None)]
    tested = [load for row in model.evidence.rows for load, _ in row.test.points]
    dense = dense_values(np.union1d(model.field.loads, (low, high)))
    loads = np.concatenate([dense, *limits, np.outer(tested, (_JUST_BELOW, 1.0)).ravel()])
    return np.unique(loads[(low <= loads) & (loads <= high)])


def _joined_stretches(loads: Array, parts: Stretches) -> Iterator[Region]:
    """Yield regions of stretches that overlap from one load to the next."""
    open_chains = list[list[tuple[int, float, float]]]()
    for line in range(len(loads)):
        is_line, chains = parts.line == line, list[list[tuple[int, float, float]]]()
        for start, end in zip(parts.start[is_line], parts.end[is_line], strict=True):
            overlapping = (
                chain for chain in open_chains if chain[-1][1] <= end and start <= chain[-1][2]
            )
            chain = next(overlapping, [])
            open_chains = [other for other in open_chains if other is not chain]
            chains.append([*chain, (line, float(start), float(end))])
        yield from (_region(loads, chain) for chain in open_chains)
        open_chains = chains
    yield from (_region(loads, chain) for chain in open_chains)


def _region(loads: Array, chain: list[tuple[int, float, float]]) -> Region:
    lines, starts, ends = (np.array(column) for column in zip(*chain, strict=True))
    return Region(loads[lines], starts, ends)
