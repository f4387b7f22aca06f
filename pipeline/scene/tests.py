"""Tests of a scene as cases of their own: the scene with what each test changes."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from pipeline.limits import MOST_ROWS
from pipeline.scene.build import Built, Files, build
from pipeline.scene.entries import Entries, replace_values
from pipeline.scene.faults import Faults
from pipeline.scene.format import EvenStages, TableFile
from pipeline.scene.format import Test as TestEntry
from pipeline.scene.stages import levels_of, stages_of, test_faults
from pipeline.scene.tables import table_of
from pipeline.sweep.case import TEST, Case, SpecimenTest
from pipeline.sweep.conditions import with_own
from pipeline.table import read_table, rows_of
from pipeline.words import quoted
from tribo import InputError, MeasuredLoad, Scene, Stages
from tribo.simulation import widen_window

_OWN = {"friction": "friction", "bulk_temperature": "temperature.bulk"}
"""Entry of the scene that an entry of a test replaces, by the name of the latter."""
_OF_ALL = (
    "extends", "without", "title", "note", "sweep", "tests", "oil", "model",
    "temperature.critical", "temperature.critical_area_fraction",
)  # fmt: skip
"""Entries that are the same in all tests of a scene."""


def with_listed_tests(entries: Entries, files: Files, faults: Faults) -> Entries:
    """Entries in which tests that name a file are replaced by its rows, each of them a test."""
    listed, rows = entries.get("tests"), list[Any]()
    if not isinstance(listed, list):
        return entries
    for number, entry in enumerate(listed):
        if not (isinstance(entry, dict) and "file" in entry):
            rows.append(entry)
            continue
        before, place = len(faults), f"tests[{number}]"
        own = table_of(TableFile).read(entry, place, faults)
        if len(faults) > before:
            continue
        with faults.at(f"{place}.file"):
            sheet = read_table(files.path("tests", own.file), MOST_ROWS, own.decimal, own.ignore)
            is_staged = {"mild_up_to", "severe_at"} & {one.name for one in sheet.columns}
            needed = () if is_staged else ("load", "velocity", "outcome")
            rows += rows_of(sheet, table_of(TestEntry).keys, _faults_in, needed)
    others = {key: one for key, one in entries.items() if key != "tests"}
    return others | ({"tests": rows} if rows else {})


def _faults_in(row: Entries) -> Iterator[tuple[str, str]]:
    made = table_of(TestEntry).read(row, "", found := Faults())
    yield from ((fault.key, fault.problem) for fault in found)
    if not found:
        yield from test_faults(made)


def read_tests(
    entries: Entries, files: Files, scene: Built, faults: Faults
) -> tuple[SpecimenTest, ...]:
    """Tests of a scene, each with the case to simulate; faults are added to `faults`.

    A test without `with` or a hold of its own shares its scene.
    """
    bare = {key: one for key, one in entries.items() if key != "tests"}
    known, made, base = dict[str, tuple[Built | None, Faults]](), list[SpecimenTest](), scene.case
    for number, entry in enumerate(scene.tables.tests or ()):
        place, changes, built = f"tests[{number}]", entry.with_ or {}, scene
        wrong = [*_misplaced(entry, changes)]
        if changes and not wrong:
            if (key := json.dumps(changes)) not in known:
                found = Faults()
                known[key] = build(replace_values(bare, changes), files, found), found
            other, found = known[key]
            wrong = [f"{fault.key}: {fault.problem}" for fault in found]
            faults.notes += [one for one in found.notes if one.place in changes]
            faults.warnings += [one for one in found.warnings if one.place in changes]
            built = other or scene
        for problem in wrong:
            faults.refuse(f"{place}.with", problem)
        with faults.at(place):
            case = _case_of(built, base)
            case = replace(case, scene=_staged(case.scene, entry, scene.tables))
            made.append(_test_of(entry, test_case(case, number, entry)))
    return tuple(made)


def _case_of(built: Built, base: Case) -> Case:
    """Case of changed entries; critical temperature, area fraction and `[model]` are of `base`."""
    own = built.case
    if own is base:
        return base
    conditions = with_own(replace(base.conditions, critical_temperature=None), own.conditions)
    return replace(base, scene=own.scene, preset=own.preset, conditions=conditions)


def test_case(case: Case, number: int, own: Any) -> Case:
    """The case of a test: `case` with the friction and bulk of the test itself (`own`)."""
    made = replace(case.conditions, critical_temperature=None).under(case.scene.loading)
    if own.bulk_temperature is not None:
        made = replace(made, bulk_temperature=own.bulk_temperature)
    made = made.replace_friction(own.friction)
    loading, parts = case.scene.loading, made.corrections
    rises = isinstance(loading, Stages) and loading.velocities
    if rises and parts and (parts.keeps_heat or made.has_friction_curve):
        raise InputError(
            "stages of velocity take one friction, and no body with a track_length or a diameter; "
            "give the test its friction, and leave out the others"
        )
    scene = case.scene
    if made.friction and not scene.friction_heat:
        scene = replace(scene, friction_heat=True)
    return replace(case, name=((TEST, number),), scene=scene, conditions=made, friction_band=None)


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


def _staged(scene: Scene, entry: Any, tables: Any) -> Scene:
    """The scene with the stages of a test; or with so many of its own that it has the test.

    Its window is wide enough for the stages.
    """
    if (stages := entry.stages) is not None:
        if isinstance(scene.loading, MeasuredLoad):
            problem = "stages need a rate of the load; give [loading] a rate, not a record"
            raise InputError(problem)
        name, _, _ = levels_of(stages, 0.0)
        _, levels, holds = levels_of(stages, entry.load if name == "load" else entry.velocity)
        loads, velocities = (levels, ()) if name == "load" else ((entry.load,), levels)
        own = Stages(loads, holds, scene.loading.rate, velocities)
        own.count(entry.load, entry.velocity)  # raises if it is no stage
        return widen_window(replace(scene, loading=own), entry.velocity)
    if not isinstance(scene.loading, Stages):
        return scene
    loading, stages = scene.loading, tables.loading.stages
    if isinstance(stages, EvenStages) and entry.load > loading.loads[-1]:
        loading = Stages(*stages_of(stages, entry.load), loading.rate)
        scene = widen_window(replace(scene, loading=loading), entry.velocity)
    step = entry.step
    before = step.value if step and step.axis == "load" else 0.0
    for load in dict.fromkeys((entry.load - before, entry.load)):
        loading.count(load)  # raises if it is no stage
    return scene


def _misplaced(entry: Any, changes: Mapping[str, Any]) -> Iterator[str]:
    """Faults of paths in the changes of a test that it states itself, or cannot have."""
    for path in changes:
        if any(_is_in(path, other) for other in _OF_ALL):
            yield f"{quoted(path)} is the same in all tests of a scene; set it in the scene"
        for name, other in _OWN.items():
            if getattr(entry, name) is not None and _is_in(path, other):
                yield f"{quoted(path)} is set by the {name} of this test; give one of them"


def _is_in(path: str, other: str) -> bool:
    """True if an entry is another one, or in its table, or its table has the other one."""
    return path == other or path.startswith(f"{other}.") or other.startswith(f"{path}.")
