"""Variants that a run simulates for the uncertainties of a scene, once its plane is done."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from pipeline.answers.case_results import CaseResults
from pipeline.answers.results import ascending, cases_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.scene.variants import expected_variants, spread, uncertain_inputs, variants_of
from pipeline.store.create import find_sweep, mismatches
from pipeline.store.dataset import store_dataset
from pipeline.store.location import PathLike
from pipeline.store.store import Store, opened
from pipeline.sweep.case import VELOCITY_INPUT
from pipeline.sweep.case_table import CaseName
from pipeline.sweep.sweep import Point, Sweep


def missing_variants(sweep: Sweep, path: PathLike) -> int:
    """Number of points that a run into the store at a path adds for uncertain inputs."""
    expected, stored = expected_variants(sweep), find_sweep(path)
    if stored is None or [*mismatches(stored, sweep)]:
        return len(expected)
    paths = {VELOCITY_INPUT, *uncertain_inputs(sweep)}
    done = {
        (variant.entry, variant.factor, variant.load, variant.of_case)
        for case in cases_of(ascending(store_dataset(opened(path))))
        for variant, point in case.variants
        if variant.entry in paths and not point.missing_reason
    }
    return max(len(expected) - len(done), 0)


def with_variants(store: Store) -> Sweep | None:
    """The sweep of a store with the variants that its uncertainties need; None if it has them.

    In a plane they are at the lowest, middle and highest load of each case, in a sweep of rows at
    the row that governs.
    """
    sweep = store.sweep
    if not (paths := uncertain_inputs(sweep)):
        return None
    stored_points, stored_paths = defaultdict[CaseName, dict[Point, None]](dict), set[str]()
    for variant in sweep.variants:
        point = Point(variant.load, variant.velocity, variant.of_case)
        stored_points[variant.of_case][point] = None
        stored_paths.add(variant.entry)
    cases = cases_of(ascending(store_dataset(store)))
    if cases[0].is_row:
        points = [] if stored_points else [governing_row(cases)]
    else:
        points = [
            point for case in cases for point in _missing_points(case, stored_points[case.name])
        ]
    if paths <= stored_paths and not points:
        return None
    stored = (point for case_points in stored_points.values() for point in case_points)
    return replace(sweep, variants=variants_of(sweep, [*stored, *points], paths | stored_paths))


def _missing_points(case: CaseResults, stored_points: Iterable[Point]) -> Iterator[Point]:
    """Yield the points of a case at its lowest, middle and highest load that are not stored.

    A store that has got further loads keeps its points at the old ones.
    """
    stored_loads = {point.load for point in stored_points}
    if {*spread(np.array(case.loads)).tolist()} - stored_loads:
        yield from (point for point in _boundary_points(case) if point.load not in stored_loads)


def governing_row(cases: list[CaseResults]) -> Point:
    """The row of a sweep whose rise is highest compared with its allowable rise."""
    ratios, points = list[float](), list[Point]()
    for case in cases:
        model = verdict_model(case, case.conditions)
        load, velocity = np.array([case.own_load or case.loads[0]]), case.velocities[:1]
        ratios.append(float(model.field(load, velocity)[0] - model.limit))
        points.append(Point(float(load[0]), float(velocity[0]), case.name))
    return points[int(np.argmax(np.nan_to_num(ratios, nan=-np.inf)))]


def _boundary_points(case: CaseResults) -> Iterator[Point]:
    """Yield the lowest, middle and highest load of a case, each at its critical velocity.

    Without one, the velocity is the end of the sweep that is nearest to it.
    """
    model = verdict_model(case, case.conditions)
    loads = spread(model.field.loads)
    lines = model.field.along_velocity(loads, np.full(loads.shape, model.limit))
    ends = np.where(lines.is_severe, case.velocities[0], case.velocities[-1])
    velocities = np.where(np.isfinite(lines.critical), lines.critical, ends)
    for load, velocity in zip(loads.tolist(), velocities.tolist(), strict=True):
        yield Point(load, velocity, case.name)
