"""Measurements to make next, and programmes of tests, for ``irg infer --next``."""

from __future__ import annotations

import argparse
from argparse import ArgumentTypeError as Refused
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.cli.output import counted
from pipeline.cli.values import share
from pipeline.uncertain.programme import MOST, programme
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.sweep.unknown import Unknown
    from pipeline.uncertain.next_tests import Candidate
    from pipeline.uncertain.posterior import Posterior
    from pipeline.uncertain.programme import Programme

_SHOWN = 12  # candidates


def measurements_to_make(
    options: argparse.Namespace, weighed: Posterior
) -> tuple[dict[str, Any], list[str]]:
    """Measurements ranked for a target, or a batch of tests, as plain data and as text."""
    about = {"target": options.target, "bulk_temperatures": options.bulk_temperature or ()}
    unknown = {one.path: one for one in weighed.unknown}.get(options.target or "")
    if options.until is not None:
        most = options.next if options.next > 1 else MOST
        planned = programme(weighed, _goal(options.until, unknown), most=most, **about)
        document = {**_plan(options, planned.tests, planned.tests), **_reached(planned)}
        return document, list(_on_programme(options, planned, unknown))
    if options.next > 1:
        ranked = tests = pipeline.plan_tests(weighed, options.next, **about)
        head = f"{options.next} tests to make next, each beside those before it"
    else:
        ranked = pipeline.candidates(weighed, **about)
        tests = tuple(one for one in ranked if one.test)[:1]
        ranked = ranked[:_SHOWN]
        head = "measurements to make next, the best first"
    before = _spread(ranked[0].before, unknown)
    lines = [f"{head}; {_target(options)} is known to {before} today"]
    return _plan(options, ranked, tests), lines + [_in_a_line(one, unknown) for one in ranked]


def _target(options: argparse.Namespace) -> str:
    return options.target or "the boundary, in velocity"


def _spread(spread: float, unknown: Unknown | None) -> str:
    """Spread of a target, in words: of a velocity a share, of an input in its unit."""
    if unknown is None or unknown.is_relative:
        return f"± {100 * spread:.2g} %"
    return f"± {unknown.spread.of(spread):.2g}{unknown.spread.suffix}"


def _in_a_line(test: Candidate, unknown: Unknown | None) -> str:
    left = _spread(test.spread, unknown)
    return f"  to {left:10} (by {100 * test.narrows:.0f} %)  {test.what}"


def _plan(
    options: argparse.Namespace, ranked: Sequence[Candidate], tests: Sequence[Candidate]
) -> dict[str, Any]:
    """Measurements and planned tests, as plain data."""
    names = ("what", "test", "spread", "narrows")
    return {
        "target": options.target,
        "next": [{name: getattr(test, name) for name in names} for test in ranked],
        "planned": [
            {"tests": number, "what": test.what, "test": test.test, "sd": test.spread}
            for number, test in enumerate(tests, 1)
        ],
    }


def _goal(text: str, unknown: Unknown | None) -> float:
    """Spread of a target until which to test, in SI or as a share."""
    try:
        if unknown is None or unknown.is_relative:
            return share(text)
        if unknown.unit == "1":
            return float(text)
        return pipeline.to_si(text, f"1 {unknown.spread.name}")
    except (ValueError, Refused) as error:
        like = "5 %" if unknown is None or unknown.is_relative else f"1{unknown.spread.suffix}"
        raise InputError(
            f'--until is "{text}"; give the spread of the target, like "{like}"'
        ) from error


def _reached(planned: Programme) -> dict[str, Any]:
    """Goal of a programme, and what helps where its tests do not reach it, as plain data."""
    return {
        "until": planned.until,
        "reached": planned.is_reached,
        "stuck": planned.is_stuck,
        "others": [{"what": one.what, "sd": one.spread} for one in planned.others],
    }


def _on_programme(
    options: argparse.Namespace, planned: Programme, unknown: Unknown | None
) -> Iterator[str]:
    """Lines on a programme: its tests, and whether they reach the goal."""
    goal, before = (_spread(value, unknown) for value in (planned.until, planned.before))
    yield f"tests until {_target(options)} is known to {goal}; today it is to {before}"
    for number, test in enumerate(planned.tests, 1):
        yield f"{number:4}{_in_a_line(test, unknown)}"
    count = counted(len(planned.tests), "test", "tests")
    if planned.is_reached:
        yield f"reached by {count}" if planned.tests else "reached already"
        return
    reason = "more of the same help little" if planned.is_stuck else "as many as were allowed"
    yield f"not reached by {count}: {reason}"
    if not planned.others:
        yield "no other measurement alone takes away a tenth of what is left"
    for one in planned.others:
        yield f"  what does: to {_spread(one.spread, unknown):10}  {one.what}"
