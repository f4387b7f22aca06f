"""Tests of a scene, each a case: the scene with the changes of the test."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from pipeline.limits import MAX_CASES
from pipeline.messages import quoted
from pipeline.scene.build import BuiltScene, Files, build_case
from pipeline.scene.declared_tables import table_of
from pipeline.scene.entries import Entries, are_nested
from pipeline.scene.faults import Faults
from pipeline.scene.format import EvenStages, TableFile
from pipeline.scene.format import Test as TestEntry
from pipeline.scene.load_stages import stages_of, test_faults
from pipeline.sweep.case import TEST, Case, SpecimenTest, with_test_conditions
from pipeline.table import SCENE, rows_of
from pipeline.table_reader import read_table
from tribo import InputError, MeasuredLoad, Scene, Stages
from tribo.simulation import widen_window

_REPLACED_ENTRIES = {"friction": "friction", "bulk_temperature": "temperature.bulk"}
"""Entry of the scene that an entry of a test replaces, by the name of the latter."""
_SHARED_ENTRIES = (
    "extends", "without", "title", "note", "sweep", "tests", "oil", "model",
    "temperature.critical", "temperature.critical_area_fraction",
)  # fmt: skip
"""Entries that are the same in all tests of a scene."""
_OMISSIBLE = "load", "outcome", "step", "mild_up_to", "severe_at"
"""Columns of a file of tests in which a dash leaves out the entry of its row."""


def with_listed_tests(entries: Entries, files: Files, faults: Faults) -> Entries:
    """Entries in which tests that name a file are replaced by its rows, each of them a test."""
    entered, tests = entries.get("tests"), list[Any]()
    if not isinstance(entered, list):
        return entries
    for index, entry in enumerate(entered):
        if not (isinstance(entry, dict) and "file" in entry):
            tests.append(entry)
            continue
        fault_count, path = len(faults), f"tests[{index}]"
        table_file = table_of(TableFile).read(entry, path, faults)
        if len(faults) > fault_count:
            continue
        with faults.at(f"{path}.file"):
            file = files.path("tests", table_file.file)
            sheet = read_table(file, MAX_CASES, table_file.decimal, table_file.ignore, SCENE)
            is_staged = {"mild_up_to", "severe_at"} & {column.name for column in sheet.columns}
            needed = ("velocity",) if is_staged else ("load", "velocity", "outcome")
            tests += rows_of(sheet, table_of(TestEntry).keys, _faults_in, needed, _OMISSIBLE)
    without_tests = {key: value for key, value in entries.items() if key != "tests"}
    return without_tests | {"tests": tests} if tests else without_tests


def _faults_in(row: Entries) -> Iterator[tuple[str, str]]:
    """Yield the entries of a test in a row of a file that are faulty, and why."""
    test = table_of(TestEntry).read(row, "", faults := Faults())
    yield from ((fault.key, fault.problem) for fault in faults)
    if not faults:
        yield from test_faults(test)


def read_tests(
    entries: Entries, files: Files, scene: BuiltScene, faults: Faults
) -> tuple[SpecimenTest, ...]:
    """Tests of a scene, each with the case to simulate; faults are added to `faults`.

    The scene is built once for each different `with`.
    """
    changed_scenes, tests = dict[str, tuple[BuiltScene | None, Faults]](), list[SpecimenTest]()
    for number, entry in enumerate(scene.tables.tests or ()):
        path, changes, scene_of_test = f"tests[{number}]", entry.with_ or {}, scene
        problems = [*_path_faults(entry, changes)]
        if changes and not problems:
            if (key := json.dumps(changes)) not in changed_scenes:
                case_faults = Faults()
                changed_scene = build_case(scene, entries, changes, files, case_faults)
                changed_scenes[key] = changed_scene, case_faults
            changed_scene, case_faults = changed_scenes[key]
            scene_of_test = changed_scene or scene
            problems = [f"{fault.key}: {fault.problem}" for fault in case_faults]
            faults.notes += [note for note in case_faults.notes if note.path in changes]
            faults.warnings += [
                warning for warning in case_faults.warnings if warning.path in changes
            ]
        for problem in problems:
            faults.refuse(f"{path}.with", problem)
        with faults.at(path):
            case = _changed_case(scene_of_test.case, scene.case)
            case = replace(case, scene=_with_stages(case.scene, entry, scene.tables))
            tests.append(_test_of(entry, test_case(case, number, entry)))
    return tuple(tests)


def _changed_case(changed: Case, base: Case) -> Case:
    """Case of changed entries; critical temperature, area fraction and `[model]` are of `base`."""
    if changed is base:
        return base
    conditions = with_test_conditions(
        replace(base.conditions, critical_temperature=None), changed.conditions
    )
    return replace(base, scene=changed.scene, preset=changed.preset, conditions=conditions)


def test_case(case: Case, number: int, entry: Any) -> Case:
    """The case of a test: `case` with the friction and bulk temperature of its `entry`."""
    conditions = replace(case.conditions, critical_temperature=None).with_loading(
        case.scene.loading
    )
    if entry.bulk_temperature is not None:
        conditions = replace(conditions, bulk_temperature=entry.bulk_temperature)
    if entry.friction is not None:
        conditions = replace(conditions, friction=entry.friction)
    scene = case.scene
    if conditions.friction and not scene.friction_heat:
        scene = replace(scene, friction_heat=True)
    return replace(
        case, name=((TEST, number),), scene=scene, conditions=conditions, friction_band=None
    )


def _test_of(entry: Any, case: Case) -> SpecimenTest:
    """The test of an entry."""
    step = entry.step
    return SpecimenTest(
        normal_load=entry.load,
        velocity=entry.velocity,
        case=case,
        friction=entry.friction,
        bulk_temperature=entry.bulk_temperature,
        outcome=entry.outcome,
        number=None if entry.number is None else str(entry.number),
        **{} if step is None else {f"{step.axis}_step": step.value},
    )


def _with_stages(scene: Scene, entry: Any, tables: Any) -> Scene:
    """The scene with the stages of a test, or with its own continued to the load of the test.

    The window is widened for the stages.
    """
    if (stages := entry.stages) is not None:
        if isinstance(scene.loading, MeasuredLoad):
            problem = "stages need a rate of the load; give [loading] a rate, not a record"
            raise InputError(problem)
        specimen_loading = Stages(*stages_of(stages, entry.load), scene.loading.rate)
        specimen_loading.count(entry.load)  # raises an error if it is no stage
        return widen_window(replace(scene, loading=specimen_loading), entry.velocity)
    if not isinstance(scene.loading, Stages):
        return scene
    loading, stages = scene.loading, tables.loading.stages
    if isinstance(stages, EvenStages) and entry.load > loading.loads[-1]:
        loading = Stages(*stages_of(stages, entry.load), loading.rate)
        scene = widen_window(replace(scene, loading=loading), entry.velocity)
    step = entry.step
    load_step = step.value if step and step.axis == "load" else 0.0
    for load in dict.fromkeys((entry.load - load_step, entry.load)):
        loading.count(load)  # raises an error if it is no stage
    return scene


def _path_faults(entry: Any, changes: Mapping[str, Any]) -> Iterator[str]:
    """Faults of changed paths that other entries of the test set, or that no test may set."""
    for path in changes:
        if any(are_nested(path, shared_path) for shared_path in _SHARED_ENTRIES):
            yield f"{quoted(path)} is the same in all tests of a scene; set it in the scene"
        for name, replaced_path in _REPLACED_ENTRIES.items():
            if getattr(entry, name) is not None and are_nested(path, replaced_path):
                yield f"{quoted(path)} is set by the {name} of this test; give one of them"
