"""Load stages of a specimen with their holds, and tests by stages."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from pipeline.quantities import UNITS, display
from pipeline.scene.declared_tables import table_of
from pipeline.scene.faults import Faults
from pipeline.scene.format import EvenStages, Test
from tribo import InputError
from tribo.loading.ramp import MOST_STEPS

_ROUNDING = 1e-9  # relative error of loads in floating point
_OUTCOME_ENTRIES = ("mild", "mild_up_to"), ("severe", "severe_at")
Levels = tuple[tuple[float, ...], tuple[float, ...]]
"""Loads of stages [N], and their holds [s]."""


def stages_of(stages: Any, highest: float) -> Levels:
    """Loads and holds of the stages in an entry; even stages end at the `highest` load [N]."""
    if not isinstance(stages, EvenStages):
        return tuple(load for load, _ in stages), tuple(hold for _, hold in stages)
    first, step = stages.first, stages.step
    step_count = max(0.0, (highest - first) / step)
    if step_count > MOST_STEPS:
        raise InputError(f"{step_count:.3g} load stages exceed the limit of {MOST_STEPS}")
    count = 1 + math.floor(step_count * (1 + _ROUNDING))
    return tuple(first + k * step for k in range(count)), (stages.hold,) * count


def expand_tests(scene: Any, faults: Faults) -> Any:
    """Copy of `scene`, a `SceneFile`, with numbered tests and without runs by stages.

    In a run by stages the load of one specimen rises stage by stage. It is replaced by a test at
    its last mild stage and a test at its first severe stage, if the run states these stages. Faulty
    tests are added to `faults`, and left out.
    """
    entered_numbers = {str(test.number) for test in scene.tests or ()}
    free_numbers = (n for n in itertools.count(1) if str(n) not in entered_numbers)
    numbers, tests = set[str](), list[Test]()
    for index, entry in enumerate(scene.tests or ()):
        path = f"tests[{index}]"
        test = replace(entry, number=next(free_numbers)) if entry.number is None else entry
        number = str(test.number)
        if number in numbers:
            problem = f"{number} is the number of two tests; give each its own, or leave it out"
            faults.refuse(f"{path}.number", problem)
        numbers.add(number)
        if faults.touches(path):
            continue
        if problems := [*test_faults(test)]:
            for key, problem in problems:
                faults.refuse(f"{path}.{key}", problem)
        elif ends := _ends_of(test):
            tests += _tests_of_run(test, ends, path, faults)
        else:
            tests.append(test)
    return replace(scene, tests=scene.tests and tuple(tests))


def test_faults(test: Test) -> Iterator[tuple[str, str]]:
    """Yield the entries of a test that are missing or do not fit others, and why."""
    if ends := _ends_of(test):
        keys = ", ".join(key for outcome, key in _OUTCOME_ENTRIES if outcome in ends)
        for key in ("load", "outcome", "step"):
            if getattr(test, key) is not None:
                yield key, f"does not fit {keys}; leave it out"
        if len(ends) > 1 and not ends["mild"] < ends["severe"]:
            severe, mild = display(ends["severe"], "N"), display(ends["mild"], "N")
            problem = f"{severe} is not above mild_up_to ({mild}); give the load of a later stage"
            yield "severe_at", problem
        return
    for key in ("load", "outcome"):
        if getattr(test, key) is None:
            yield key, f"missing; required: {table_of(Test).keys[key].kind}"
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


def _ends_of(test: Test) -> dict[str, float]:
    """Loads at the ends of a run by stages [N], by the outcome there; else empty."""
    ends = {outcome: getattr(test, key) for outcome, key in _OUTCOME_ENTRIES}
    return {outcome: load for outcome, load in ends.items() if load is not None}


def _tests_of_run(run: Test, ends: dict[str, float], path: str, faults: Faults) -> Iterator[Test]:
    """Tests at the last mild and the first severe stage of a run, whose loads are its `ends`."""
    stages, last = run.stages, max(ends.values())
    if stages is not None:
        with faults.at(f"{path}.stages"):
            stages = tuple(
                (load, hold)
                for load, hold in zip(*stages_of(stages, last), strict=True)
                if load <= last * (1 + _ROUNDING)
            )
    for outcome, load in ends.items():
        yield replace(
            run, load=load, outcome=outcome, stages=stages, mild_up_to=None, severe_at=None
        )
