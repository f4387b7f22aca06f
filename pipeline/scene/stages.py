"""Stages of a specimen: levels of load or velocity, each held; and runs by stages as tests."""

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
"""Levels in SI, and the times for which they are held [s]."""


def stages_of(stages: Any, highest: float) -> Levels:
    """Levels and holds of the stages in an entry; even stages end at the `highest` level."""
    if isinstance(stages, EvenStages):
        return _even(stages.first, stages.step, stages.hold, highest)
    return tuple(level for level, _ in stages), tuple(hold for _, hold in stages)


def levels_of(stages: Any, end: float) -> tuple[str, tuple[float, ...], tuple[float, ...]]:
    """Stages of a test: "load" or "velocity", levels in SI and holds; even ones up to `end`."""
    is_even = isinstance(stages, EvenLevels)
    found = [stages.first, stages.step] if is_even else [level for level, _ in stages]
    axis, *others = dict.fromkeys(level.axis for level in found)
    if others:
        raise InputError("the stages are of load and of velocity; give one of them")
    if is_even:
        return axis, *_even(found[0].value, found[1].value, stages.hold, end)
    return axis, tuple(level.value for level in found), tuple(hold for _, hold in stages)


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
    given = {str(one.number) for one in scene.tests or ()}
    free = (number for number in itertools.count(1) if str(number) not in given)
    named_before, tests = set[str](), list[Test]()
    for index, entry in enumerate(scene.tests or ()):
        place = f"tests[{index}]"
        named = replace(entry, number=next(free)) if entry.number is None else entry
        if (name := str(named.number)) in named_before:
            problem = f"{name} is the number of two tests; give each its own, or leave it out"
            faults.refuse(f"{place}.number", problem)
        named_before.add(name)
        if faults.touches(place):
            continue
        if problems := [*test_faults(named)]:
            for key, problem in problems:
                faults.refuse(f"{place}.{key}", problem)
        elif ends := _ends_of(named):
            tests += _read_stages(named, ends, place, faults)
        else:
            tests.append(named)
    return replace(scene, tests=scene.tests and tuple(tests))


def test_faults(test: Test) -> Iterator[tuple[str, str]]:
    """Yield the entries of a test that are missing or do not fit others, and why."""
    if ends := _ends_of(test):
        given = [name for name in _KINDS if getattr(test, name) is not None]
        if len(given) != 1:
            problem = "both load and velocity are" if given else "neither load nor velocity is"
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
        step, value = (display(one, UNITS[axis]) for one in (step, value))
        yield "step", f"{step} must be less than the {axis} ({value})"


def _ends_of(test: Test) -> dict[str, str]:
    """Entries that state the ends of a run by stages, by the outcome there; else empty."""
    return {outcome: key for outcome, key in _STAGES if getattr(test, key) is not None}


def _read_stages(entry: Test, given: dict[str, str], place: str, faults: Faults) -> Iterator[Test]:
    """Tests at the last mild and the first severe stage of a run, which `entry` states."""
    (name,) = (name for name in _KINDS if getattr(entry, name) is None)
    read = _KINDS[name].read
    ends = {o: read(getattr(entry, key), f"{place}.{key}", faults) for o, key in given.items()}
    if None in ends.values():
        return
    if len(ends) > 1 and not ends["mild"] < ends["severe"]:
        low, high = (display(ends[outcome], UNITS[name]) for outcome in ("severe", "mild"))
        faults.refuse(f"{place}.severe_at", f"{low} is not above mild_up_to, {high}; exchange them")
        return
    common = {key: one for key, one in vars(entry).items() if key not in given.values()}
    if entry.stages is not None:
        last = max(ends.values())  # the last stage that is named ends the specimen
        with faults.at(f"{place}.stages"):
            found, levels, holds = levels_of(entry.stages, last)
            if found != name:
                problem = f"these are stages of {found}, which the test gives, too; leave out one"
                raise InputError(problem)
            common["stages"] = tuple(
                (Level(name, level), hold)
                for level, hold in zip(levels, holds, strict=True)
                if level <= last * (1 + 1e-9)
            )
    for outcome, value in ends.items():
        yield Test(**common | {name: value, "outcome": outcome})
