"""Tests of a scene as cases of their own: the scene with what each test changes."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.scene.faults import Faults, quoted
from pipeline.scene.format import EvenStages
from pipeline.scene.parts import Parts, axis_of, levels_of, stages_of
from pipeline.scene.reading import SceneReader
from pipeline.scene.units import to_si
from pipeline.sweep.conditions import with_own
from pipeline.sweep.measurement import TEST, Case, Measurement
from pipeline.sweep.tables import Entries, replace_value, replace_values
from tribo import InputError, MeasuredLoad, Ramp, Scene, Stages
from tribo.simulation import widen_window

_OWN = {
    "friction": ("friction",),
    "bulk_temperature": ("temperature.bulk",),
    "hold": ("loading.hold",),
}
"""Entries of the scene that entries of a test replace, by name of the entry of the test."""
_OF_ALL = (
    "extends", "without", "title", "caveat", "sweep", "measured", "tested", "oil", "model",
    "temperature.critical", "temperature.failing_share", "temperature.criterion",
)  # fmt: skip
"""Entries that are the same in all tests of a scene."""


def test_of(entry: Any) -> Measurement:
    """Make a test from its table in a scene, read into SI."""
    names: dict[str, Any] = {
        name: str(value)
        for name in ("number", "run")
        if (value := getattr(entry, name, None)) is not None
    }
    step, steps = getattr(entry, "step", None), dict[str, Any]()
    if step is not None:
        steps[f"{axis_of(step)}_step"] = to_si(step, like=step)
    return Measurement(
        normal_load=entry.load,
        velocity=entry.velocity,
        friction=entry.friction,
        bulk_temperature=entry.bulk_temperature,
        hold=entry.hold,
        stages=getattr(entry, "stages", None),
        outcome=getattr(entry, "outcome", None),
        changes=entry.with_ or {},
        **names,
        **steps,
    )


@dataclass(frozen=True)
class TestReader:
    """Reads the tests of a scene.

    `written` are the entries of the scene as a file has them, `entries` the complete ones, and
    `parts` what `reader` has read from them.
    """

    reader: SceneReader
    written: Entries
    entries: Entries
    parts: Parts
    known: dict[str, tuple[Parts | None, Faults]] = field(default_factory=dict)

    def tests(self, base: Case, faults: Faults) -> tuple[Measurement, ...]:
        """Tests of the scene, each with the case to simulate; faults are added to `faults`.

        `base` is the scene itself. A test without `with` or a hold of its own shares its scene.
        """
        made = list[Measurement]()
        entries = *(self.parts.declared.measured or ()), *(self.parts.declared.tested or ())
        listed = _listed(map(test_of, entries))
        for number, (key, index, test) in enumerate(listed):
            place, case, wrong = f"{key}[{index}]", base, [*_misplaced(test)]
            if test.changes and not wrong:
                parts, found = self.read_changed(test.changes)
                wrong += [f"{fault.key}: {fault.problem}" for fault in found]
                faults.notes += [note for note in found.notes if note.place in test.changes]
                if parts and parts.case.scene.unequal_bulks != base.scene.unequal_bulks:
                    problem = "this changes the unequal bulks, which must be the same in all tests"
                    wrong.append(f"{problem}; give bulk_temperature")
                elif parts:
                    case = case_of(parts, base)
                    if not self.reader.is_stored:
                        written = self._written_with(test.changes)
                        complete = self.reader.complete_changes
                        own = complete(test.changes, written, parts, self.entries, self.parts)
                        test = replace(test, changes=own)
            for problem in wrong:
                faults.refuse(f"{place}.with", problem)
            with faults.at(place):
                case = replace(case, scene=self.staged(case.scene, test))
                made.append(attach_case(test, number, case))
        return tuple(made)

    def staged(self, scene: Scene, test: Measurement) -> Scene:
        """The scene with the stages of a test; or with so many of its own that it has the test.

        Its window is wide enough for the stages.
        """
        if test.stages is not None:
            if isinstance(scene.loading, MeasuredLoad):
                problem = "stages need a rate of the load; give [loading] a rate, not a record"
                raise InputError(problem)
            name, _, _ = levels_of(test.stages, 0.0)
            end = test.normal_load if name == "load" else test.velocity
            _, levels, holds = levels_of(test.stages, end)
            loads, velocities = (levels, ()) if name == "load" else ((test.normal_load,), levels)
            own = Stages(loads, holds, scene.loading.rate, velocities)
            own.count(test.normal_load, test.velocity)  # raises if it is no stage
            return widen_window(replace(scene, loading=own), test.velocity)
        if not isinstance(scene.loading, Stages):
            return scene
        loading, stages = scene.loading, self.parts.declared.loading.stages
        if isinstance(stages, EvenStages) and test.normal_load > loading.loads[-1]:
            loading = Stages(*stages_of(stages, test.normal_load), loading.rate)
            scene = widen_window(replace(scene, loading=loading), test.velocity)
        for load, _ in test.places:
            loading.count(load)  # raises if it is no stage
        return scene

    def _written_with(self, own: Mapping[str, Any]) -> dict[str, Any]:
        """Entries of the scene with a test's own, and without tests."""
        without = {k: one for k, one in self.written.items() if k not in ("measured", "tested")}
        if "fidelity.preset" in own:  # the preset replaces all other choices
            without = replace_value(without, "fidelity", None)
        return replace_values(without, own)

    def read_changed(self, changes: Mapping[str, Any]) -> tuple[Parts | None, Faults]:
        """Read the scene with `changes` by path, once; return its parts and its faults."""
        key = json.dumps(dict(changes))
        if key not in self.known:
            faults = Faults(self.reader.is_stored, allows_store_only=True)
            self.known[key] = self.reader.read_all(self._written_with(changes), faults), faults
        return self.known[key]


def case_of(parts: Parts, base: Case) -> Case:
    """Case of changed entries, with critical temperature, criterion and `[model]` of `base`."""
    own = parts.case
    conditions = with_own(replace(base.conditions, critical_temperature=None), own.conditions)
    return replace(base, scene=own.scene, preset=own.preset, conditions=conditions)


def attach_case(test: Measurement, number: int, case: Case) -> Measurement:
    """The test with its own case: `case` with the hold, friction and bulk of the test."""
    scene = _held(case.scene, test.hold)
    own = replace(case.conditions, critical_temperature=None).under(scene.loading)
    if test.bulk_temperature is not None:
        own = replace(own, bulk_temperature=test.bulk_temperature, disk_temperature=None)
    own = own.replace_friction(test.friction)
    rises = isinstance(scene.loading, Stages) and scene.loading.velocities
    if rises and (parts := own.corrections) and (parts.keeps_heat or own.has_friction_curve):
        raise InputError(
            "stages of velocity take one friction, and no body with a track_length or a diameter; "
            "give the test its friction, and leave out the others"
        )
    if own.friction and not scene.friction_heat:
        scene = replace(scene, friction_heat=True)
    own_case = replace(
        case, name=((TEST, number),), scene=scene, conditions=own, friction_band=None
    )
    return replace(test, own=own_case)


def with_changes(entries: Entries, tests: Iterable[Measurement]) -> dict[str, Any]:
    """`entries` of a scene, with the complete changes of its tests."""
    rows = dict(entries)
    for key, index, test in _listed(tests):
        if test.changes:
            rows[key] = [*rows[key]]
            rows[key][index] = rows[key][index] | {"with": dict(test.changes)}
    return rows


def _listed(tests: Iterable[Measurement]) -> Iterator[tuple[str, int, Measurement]]:
    """Yield each test after the name of its list in the scene, and its index there."""
    counts = Counter[str]()
    for test in tests:
        key = "tested" if test.outcome else "measured"
        yield key, counts[key], test
        counts[key] += 1


def _misplaced(test: Measurement) -> Iterator[str]:
    """Faults of paths in the changes of a test that it states itself, or cannot have."""
    for path in test.changes:
        if any(is_in(path, other) for other in _OF_ALL):
            yield f"{quoted(path)} is the same in all tests of a scene; set it in the scene"
        for name, others in _OWN.items():
            if getattr(test, name) is not None and any(is_in(path, one) for one in others):
                yield f"{quoted(path)} is set by the {name} of this test; give one of them"


def is_in(path: str, other: str) -> bool:
    """True if an entry is another one, or in its table, or its table has the other one."""
    return path == other or path.startswith(f"{other}.") or other.startswith(f"{path}.")


def _held(scene: Scene, hold: float | None) -> Scene:
    """The scene with a test's own time at the full load [s]."""
    if hold is None or getattr(scene.loading, "hold", None) == hold:
        return scene
    if isinstance(scene.loading, Stages):
        raise InputError(f"hold is {hold:g} s, but each of the stages has its own; leave it out")
    if not isinstance(scene.loading, Ramp):
        raise InputError(
            f"hold is {hold:g} s, but the load follows a record, which has its own end; leave out "
            "the hold, or give a loading with rate and reference_load"
        )
    return replace(scene, loading=replace(scene.loading, hold=hold))
