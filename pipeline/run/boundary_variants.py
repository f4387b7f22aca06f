"""Variants that a run simulates for the uncertainties of a scene, once its plane is done."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from pipeline.answers.case_results import CaseResults
from pipeline.answers.results import ascending, cases_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.scene.variants import variants_of
from pipeline.store.dataset import store_dataset
from pipeline.store.store import Store
from pipeline.sweep.case import CLOSED_FORM
from pipeline.sweep.case_table import CaseName
from pipeline.sweep.sweep import Point, Sweep
from tribo.types import Array


def uncertain_inputs(sweep: Sweep) -> set[str]:
    """Paths of the uncertain inputs of a scene that act by simulations."""
    return {path for each in sweep.base.uncertainty for path in each.entries} - {*CLOSED_FORM}


def expected_variants(sweep: Sweep) -> int:
    """Number of points that a run of a sweep simulates for its uncertain inputs."""
    if not (paths := uncertain_inputs(sweep)) or not sweep.base.is_judged:
        return 0
    names, loads = sweep.case_table.without_surfaces.names, _spread(np.array(sweep.loads))
    if sweep.case_table.column("load") is not None:
        names, loads = names[:1], loads[:1]
    points = (Point(load, sweep.velocities[-1], name) for name in names for load in loads.tolist())
    return len(variants_of(sweep, points, paths))


def with_variants(store: Store) -> Sweep | None:
    """The sweep of a store with the variants that its uncertainties need; None if it has them.

    In a plane they are at the lowest, middle and highest load of each case, in a sweep of rows at
    the row that governs.
    """
    sweep = store.sweep
    paths = uncertain_inputs(sweep)
    if not (paths and sweep.base.is_judged and sweep.conditions.friction):
        return None
    stored_points, stored_paths = defaultdict[CaseName, dict[Point, None]](dict), set[str]()
    for variant in sweep.variants:
        point = Point(variant.load, variant.velocity, variant.of_case)
        stored_points[variant.of_case][point] = None
        stored_paths.add(variant.entry)
    cases = cases_of(ascending(store_dataset(store)))
    if cases[0].is_row:
        points = [[*stored] for stored in stored_points.values()] or [[governing_row(cases)]]
    else:
        points = [
            [*stored_points.get(case.name, {})] or [*_boundary_points(case)] for case in cases
        ]
    if paths <= stored_paths and len(stored_points) >= len(points):
        return None
    flat_points = (point for case_points in points for point in case_points)
    return replace(sweep, variants=variants_of(sweep, flat_points, paths | stored_paths))


def governing_row(cases: list[CaseResults]) -> Point:
    """The row of a sweep whose rise is highest compared with its allowable rise."""
    ratios, points = list[float](), list[Point]()
    for case in cases:
        model = verdict_model(case, case.conditions)
        load, velocity = case.loads[:1], case.velocities[:1]
        ratios.append(float(model.field(load, velocity)[0] - model.limit))
        points.append(Point(float(load[0]), float(velocity[0]), case.name))
    return points[int(np.argmax(np.nan_to_num(ratios, nan=-np.inf)))]


def _boundary_points(case: CaseResults) -> Iterator[Point]:
    """Yield the lowest, middle and highest load of a case, each at its critical velocity.

    Without one, the velocity is the end of the sweep that is nearest to it.
    """
    model = verdict_model(case, case.conditions)
    loads = _spread(model.field.loads)
    lines = model.field.along_velocity(loads, np.full(loads.shape, model.limit))
    ends = np.where(lines.is_severe, case.velocities[0], case.velocities[-1])
    velocities = np.where(np.isfinite(lines.critical), lines.critical, ends)
    for load, velocity in zip(loads.tolist(), velocities.tolist(), strict=True):
        yield Point(load, velocity, case.name)


def _spread(values: Array) -> Array:
    """The first, middle and last of ascending values, each once."""
    return np.unique(values[[0, len(values) // 2, -1]])
