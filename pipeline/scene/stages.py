"""Stages of a specimen, levels of load or velocity with their holds; and tests by stages."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from pipeline.quantities import UNITS, display
from pipeline.scene.faults import Faults
from pipeline.scene.format import EvenLevels, EvenStages, Test
from pipeline.scene.kinds import LOAD, VELOCITY, Level
from pipeline.scene.tables import table_of
from tribo import InputError
from tribo.loading.ramp import MOST_STEPS

_ROUNDING = 1e-9
_STAGES = ("mild", "mild_up_to"), ("severe", "severe_at")
_KINDS = {"load": LOAD, "velocity": VELOCITY}
Levels = tuple[tuple[float, ...], tuple[float, ...]]
"""Levels in SI, and their holds [s]."""


def stages_of(stages: Any, highest: float) -> Levels:
    """Levels and holds of the stages in an entry; even stages end at the `highest` level."""
    if isinstance(stages, EvenStages):
        return _even(stages.first, stages.step, stages.hold, highest)
    return tuple(level for level, _ in stages), tuple(hold for _, hold in stages)


def levels_of(stages: Any, end: float) -> tuple[str, tuple[float, ...], tuple[float, ...]]:
    """Stages of a test: "load" or "velocity", levels in SI and holds; even ones up to `end`."""
    is_even = isinstance(stages, EvenLevels)
    levels = [stages.first, stages.step] if is_even else [level for level, _ in stages]
    axis, *other_axes = dict.fromkeys(level.axis for level in levels)
    if other_axes:
        raise InputError("the stages are of load and of velocity; give one of them")
    if is_even:
        return axis, *_even(levels[0].value, levels[1].value, stages.hold, end)
    return axis, tuple(level.value for level in levels), tuple(hold for _, hold in stages)


def _even(first: float, step: float, hold: float, highest: float) -> Levels:
    steps = max(0.0, (highest - first) / step)
    if steps > MOST_STEPS:
        raise InputError(f"{steps:.3g} load stages exceed the limit of {MOST_STEPS}")
    count = 1 + math.floor(steps * (1 + _ROUNDING))
    return tuple(first + k * step for k in range(count)), (hold,) * count


def expand_tests(scene: Any, faults: Faults) -> Any:
    """Copy of `scene`, a `SceneFile`, with numbered tests and without runs by stages.

    In a run by stages the load or the velocity of one specimen rises stage by stage. It is replaced
    by a test at its last mild stage and a test at its first severe stage, if the run states these
    stages. Faulty tests are added to `faults`, and left out.
    """
    numbers = {str(test.number) for test in scene.tests or ()}
    free = (number for number in itertools.count(1) if str(number) not in numbers)
    used_names, tests = set[str](), list[Test]()
    for index, entry in enumerate(scene.tests or ()):
        path = f"tests[{index}]"
        numbered = replace(entry, number=next(free)) if entry.number is None else entry
        if (name := str(numbered.number)) in used_names:
            problem = f"{name} is the number of two tests; give each its own, or leave it out"
            faults.refuse(f"{path}.number", problem)
        used_names.add(name)
        if faults.touches(path):
            continue
        if problems := [*test_faults(numbered)]:
            for key, problem in problems:
                faults.refuse(f"{path}.{key}", problem)
        elif ends := _ends_of(numbered):
            tests += _read_stages(numbered, ends, path, faults)
        else:
            tests.append(numbered)
    return replace(scene, tests=scene.tests and tuple(tests))


def test_faults(test: Test) -> Iterator[tuple[str, str]]:
    """Yield the entries of a test that are missing or do not fit others, and why."""
    if ends := _ends_of(test):
        axes = [name for name in _KINDS if getattr(test, name) is not None]
        if len(axes) != 1:
            problem = "both load and velocity are" if axes else "neither load nor velocity is"
            yield "load", f"{problem} given together with stages; give the one that is constant"
        for key in ("outcome", "step"):
            if getattr(test, key) is not None:
                yield key, f"does not fit {', '.join(ends.values())}; leave it out"
        return
    for key in ("load", "velocity", "outcome"):
        if getattr(test, key) is None:
            yield key, f"missing; required: {table_of(Test).keys[key].kind}"
    if test.outcome == "transition" and test.stages is not None:
        words = "do not fit a transition; give mild_up_to and severe_at instead of the outcome"
        yield "stages", words
    if test.step is None:
        return
    if test.outcome != "transition":
        words = 'it belongs to a transition; leave it out, or give outcome = "transition"'
        yield "step", words
        return
    axis, step = test.step
    if (value := getattr(test, axis)) is not None and step >= value:
        step, value = (display(level, UNITS[axis]) for level in (step, value))
        yield "step", f"{step} must be less than the {axis} ({value})"


def _ends_of(test: Test) -> dict[str, str]:
    """Entries that state the ends of a run by stages, by the outcome there; else empty."""
    return {outcome: key for outcome, key in _STAGES if getattr(test, key) is not None}


def _read_stages(entry: Test, keys: dict[str, str], path: str, faults: Faults) -> Iterator[Test]:
    """Tests at the last mild and the first severe stage of a run, which `entry` states."""
    (name,) = (name for name in _KINDS if getattr(entry, name) is None)
    read = _KINDS[name].read
    ends = {o: read(getattr(entry, key), f"{path}.{key}", faults) for o, key in keys.items()}
    if None in ends.values():
        return
    if len(ends) > 1 and not ends["mild"] < ends["severe"]:
        low, high = (display(ends[outcome], UNITS[name]) for outcome in ("severe", "mild"))
        faults.refuse(f"{path}.severe_at", f"{low} is not above mild_up_to, {high}; exchange them")
        return
    common = {key: value for key, value in vars(entry).items() if key not in keys.values()}
    if entry.stages is not None:
        last = max(ends.values())  # the specimen ends at the last stage that the entry states
        with faults.at(f"{path}.stages"):
            axis, levels, holds = levels_of(entry.stages, last)
            if axis != name:
                problem = f"these are stages of {axis}, which the test gives, too; leave out one"
                raise InputError(problem)
            common["stages"] = tuple(
                (Level(name, level), hold)
                for level, hold in zip(levels, holds, strict=True)
                if level <= last * (1 + 1e-9)
            )
    for outcome, value in ends.items():
        yield Test(**common | {name: value, "outcome": outcome})
