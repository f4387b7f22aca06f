"""Tests of a scene, each a case: the scene with the changes of the test."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from pipeline.faults import Faults
from pipeline.limits import MAX_CASES
from pipeline.messages import quoted
from pipeline.quantities import UNITS, display
from pipeline.scene.build import BuiltScene, Files, build_case
from pipeline.scene.entries import Entries, are_nested
from pipeline.scene.format import EvenStages, TableFile, stages_of
from pipeline.scene.format import Test as TestEntry
from pipeline.scene.table_kinds import TableKind
from pipeline.sweep.case import TEST, Case, SpecimenTest, with_test_conditions
from pipeline.table import read_table
from tribo import InputError, MeasuredLoad, Scene, Stages
from tribo.simulation import widen_window

_SHARED_ENTRIES = (
    "extends", "without", "title", "note", "sweep", "tests", "oil", "model",
    "temperature.critical", "temperature.critical_area_fraction",
)  # fmt: skip
"""Entries that are the same in all tests of a scene."""
_REPLACED_ENTRIES = {"friction": "friction", "bulk_temperature": "temperature.bulk"}
"""Entry of the scene that an entry of a test replaces, by the name of the latter."""
_ROUNDING = 1e-9  # relative error of loads in floating point
_OMISSIBLE = "load", "outcome", "step", "mild_up_to", "severe_at", "inputs"
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
        with faults.at(f"tests[{index}].file"):
            declared = TableKind(TableFile).read(entry, f"tests[{index}]", file_faults := Faults())
            faults += file_faults
            if file_faults:
                continue
            file = files.path("tests", declared.file)
            table = read_table(file, MAX_CASES, declared.decimal, declared.ignore)
            is_staged = {"mild_up_to", "severe_at"} & {column.name for column in table.columns}
            needed = ("velocity",) if is_staged else ("load", "velocity", "outcome")
            tests += table.rows(TableKind(TestEntry).keys, _faults_in, needed, _OMISSIBLE)
    without_tests = {key: value for key, value in entries.items() if key != "tests"}
    return without_tests | {"tests": tests} if tests else without_tests


def _faults_in(row: Entries) -> Iterator[tuple[str, str]]:
    """Yield the entries of a test in a row of a file that are faulty, and why."""
    test = TableKind(TestEntry).read(row, "", faults := Faults())
    yield from faults or _test_faults(test)


def read_tests(
    entries: Entries, files: Files, scene: BuiltScene, faults: Faults
) -> tuple[SpecimenTest, ...]:
    """Tests of a scene, each with the case to simulate; faults are added to `faults`.

    The scene is built once for each different `with`.
    """
    changed_scenes, tests = dict[str, tuple[BuiltScene | None, Faults]](), list[SpecimenTest]()
    for number, entry in enumerate(_numbered(scene.tables.tests, faults)):
        path, changes, scene_of_test = f"tests[{number}]", entry.with_ or {}, scene
        problems = [*_path_faults(entry)]
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
            case = test_case(case, number, entry.friction, entry.bulk_temperature)
            tests.append(_test_of(entry, case))
    return tuple(tests)


def _numbered(entered: Sequence[TestEntry], faults: Faults) -> list[TestEntry]:
    """Tests with numbers, in which no test is a run by stages.

    In a run by stages the load of one specimen rises stage by stage. It is replaced by a test at
    its last mild stage and a test at its first severe stage, if the run states these stages. Faulty
    tests are added to `faults`, and left out.
    """
    numbers = {str(test.number) for test in entered if test.number is not None}
    free_numbers = (n for n in itertools.count(1) if str(n) not in numbers)
    if len(numbers) < sum(test.number is not None for test in entered):
        faults.refuse("tests", "two tests have one number; give each its own, or leave it out")
    tests = list[TestEntry]()
    for index, entry in enumerate(entered):
        test = replace(entry, number=next(free_numbers)) if entry.number is None else entry
        if problems := [*_test_faults(test)]:
            for key, problem in problems:
                faults.refuse(f"tests[{index}].{key}", problem)
        elif ends := _ends_of(test):
            with faults.at(f"tests[{index}].stages"):
                tests += _tests_of_run(test, ends)
        else:
            tests.append(test)
    return tests


def _test_faults(test: TestEntry) -> Iterator[tuple[str, str]]:
    """Yield the entries of a test that are missing or do not fit others, and why."""
    if ends := _ends_of(test):
        for key in ("load", "outcome", "step"):
            if getattr(test, key) is not None:
                yield key, "does not fit mild_up_to or severe_at; leave it out"
        if len(ends) > 1 and not ends["mild"] < ends["severe"]:
            severe, mild = display(ends["severe"], "N"), display(ends["mild"], "N")
            problem = f"{severe} is not above mild_up_to ({mild}); give the load of a later stage"
            yield "severe_at", problem
        return
    for key in ("load", "outcome"):
        if getattr(test, key) is None:
            yield key, f"missing; required: {TableKind(TestEntry).keys[key].kind}"
    if test.outcome == "transition" and test.stages is not None:
        problem = "do not fit a transition; give mild_up_to and severe_at instead of the outcome"
        yield "stages", problem
    if test.step is None:
        return
    if test.outcome != "transition":
        yield "step", 'it belongs to a transition; leave it out, or give outcome = "transition"'
        return
    axis, step = test.step
    load_or_velocity = getattr(test, axis)
    if load_or_velocity is not None and step >= load_or_velocity:
        limit = display(load_or_velocity, UNITS[axis])
        yield "step", f"{display(step, UNITS[axis])} must be less than the {axis} ({limit})"


def _ends_of(test: TestEntry) -> dict[str, float]:
    """Loads at the ends of a run by stages [N], by the outcome there; else empty."""
    ends = {"mild": test.mild_up_to, "severe": test.severe_at}
    return {outcome: load for outcome, load in ends.items() if load is not None}


def _tests_of_run(run: TestEntry, ends: dict[str, float]) -> Iterator[TestEntry]:
    """Tests at the last mild and the first severe stage of a run, whose loads are its `ends`."""
    stages, last = run.stages, max(ends.values())
    if stages is not None:
        levels = zip(*stages_of(stages, last), strict=True)
        stages = tuple((load, hold) for load, hold in levels if load <= last * (1 + _ROUNDING))
    for outcome, load in ends.items():
        yield replace(
            run, load=load, outcome=outcome, stages=stages, mild_up_to=None, severe_at=None
        )


def _changed_case(changed: Case, base: Case) -> Case:
    """Case of changed entries; critical temperature, area fraction and `[model]` are of `base`."""
    if changed is base:
        return base
    conditions = with_test_conditions(
        replace(base.conditions, critical_temperature=None), changed.conditions
    )
    return replace(base, scene=changed.scene, preset=changed.preset, conditions=conditions)


def test_case(
    case: Case, number: int, friction: float | None, bulk_temperature: float | None
) -> Case:
    """The case of a test: `case` with the friction and the bulk temperature [K] of the test."""
    conditions = replace(case.conditions, critical_temperature=None).with_loading(
        case.scene.loading
    )
    if bulk_temperature is not None:
        conditions = replace(conditions, bulk_temperature=bulk_temperature)
    if friction is not None:
        conditions = replace(conditions, friction=friction)
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
        outcome=entry.outcome,
        number=None if entry.number is None else str(entry.number),
        has_own_inputs=entry.inputs == "own",
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


def _path_faults(entry: Any) -> Iterator[str]:
    """Faults of changed paths that other entries of the test set, or that no test may set."""
    values = vars(entry)
    replaced = [path for name, path in _REPLACED_ENTRIES.items() if values[name] is not None]
    for path in entry.with_ or ():
        if any(are_nested(path, shared_path) for shared_path in _SHARED_ENTRIES):
            yield f"{quoted(path)} is the same in all tests of a scene; set it in the scene"
        if any(are_nested(path, replaced_path) for replaced_path in replaced):
            yield f"{quoted(path)} is set by another entry of this test; give one of them"
