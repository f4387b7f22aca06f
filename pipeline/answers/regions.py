"""Regions of one verdict in the plane of load and velocity, for figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pipeline.answers.condition_values import QueryPoints, override_conditions
from pipeline.answers.results import cases_of
from pipeline.answers.verdict_limits import Stretches, dense_values, line_limits, stretches
from pipeline.answers.verdict_model import MILD, SEVERE, VerdictModel, verdict_model
from tribo.types import Array

_JUST_BELOW = 1 - 1e-6  # of the load of a test, from which it rules verdicts out


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
    loads = _loads(model)
    by_code = stretches(model, QueryPoints.under(model.conditions, loads, loads))
    return {code: [*_joined(loads, parts)] for code, parts in by_code.items()}


def _loads(model: VerdictModel) -> Array:
    """Loads (n,) dense enough for smooth edges, with corners at tests and at ends of the plane."""
    low, high = model.ranges["load"]
    ends = np.array(model.ranges["velocity"])
    points = QueryPoints.under(model.conditions, ends, ends)
    limits = [x.values for x in line_limits(model, "load", (MILD, SEVERE), points, None)]
    tested = [load for row in model.evidence.rows for load, _ in row.test.points]
    dense = dense_values(np.union1d(model.field.loads, (low, high)))
    loads = np.concatenate([dense, *limits, np.outer(tested, (_JUST_BELOW, 1.0)).ravel()])
    return np.unique(loads[(low <= loads) & (loads <= high)])


def _joined(loads: Array, parts: Stretches) -> Iterator[Region]:
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
