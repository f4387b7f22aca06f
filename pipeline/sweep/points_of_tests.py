"""The sweep of the points of a scene's tests."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from pipeline.sweep.case import TEST
from pipeline.sweep.case_table import PLACE_UNITS, CaseTable, Column
from pipeline.sweep.stored_steps import StoredSteps
from pipeline.sweep.sweep import Sweep

TEST_POINT = "test_point"
"""Dimension of the points of tests."""
NO_TEST = -1
"""Number of the test of a point that only an earlier version of the scene has."""
SCENE_HASH = "scene_hash"
"""Column with the hash of the scene that each point is of."""


class PointOfTest(NamedTuple):
    """A point of a test in a store: what is simulated there, and for which test."""

    scene_hash: str
    load: float  # [N]
    velocity: float  # [m/s]
    test: int  # number of the test in the scene, from 0, or `NO_TEST`


def list_points_of_tests(sweep: Sweep) -> list[PointOfTest]:
    """The points of a scene's tests, in their order."""
    return [point for point in list_all_points_of_tests(sweep) if point.test != NO_TEST]


def list_all_points_of_tests(sweep: Sweep) -> list[PointOfTest]:
    """The points of a scene's tests, in their order, then those of its former tests."""
    numbers = [*range(len(sweep.tests)), *[NO_TEST] * len(sweep.former)]
    return [
        PointOfTest(sweep._hash_scene(test.case.scene), *point, number)
        for number, test in zip(numbers, (*sweep.tests, *sweep.former), strict=True)
        for point in test.points
    ]


def sweep_of_tests(sweep: Sweep, judges_hold: bool) -> Sweep:
    """The sweep of the points of tests, a row for each of `list_all_points_of_tests`."""
    points = list_all_points_of_tests(sweep)
    columns = (
        Column(TEST_POINT, meaning="number of the point of a test"),
        Column(TEST, "1", TEST_POINT, meaning="number of the test"),
        Column(SCENE_HASH, None, TEST_POINT, meaning="SHA-256 of the scene that is simulated"),
        *(
            Column(k, unit, TEST_POINT, meaning=f"{k} of the test")
            for k, unit in PLACE_UNITS.items()
        ),
    )
    rows = tuple({TEST_POINT: k, **point._asdict()} for k, point in enumerate(points))
    cases = (test.case for test in (*sweep.tests, *sweep.former) for _ in test.points)
    return replace(
        sweep,
        cases=tuple(replace(case, name=((TEST_POINT, k),)) for k, case in enumerate(cases)),
        case_table=CaseTable(columns, rows),
        loads=tuple(sorted({point.load for point in points})),
        velocities=tuple(sorted({point.velocity for point in points})),
        fields=False,
        tests=(),
        former=(),
        stored_steps=StoredSteps("end", judges_hold),
    )


def judges_holds(sweep: Sweep) -> bool:
    """True if the holds of tests are judged at each step, since bodies warm up in them."""
    all_corrections = (test.case.conditions.corrections for test in (*sweep.tests, *sweep.former))
    return any(corrections.keeps_heat for corrections in all_corrections if corrections)
