"""The tests of a scene at their own conditions: their y, and what they say of other places."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pipeline.analysis.dataset import Layout
from pipeline.analysis.film import OUTSIDE_WORDS, is_test_outside
from pipeline.analysis.likelihood import Belief, SpecimenResult, condition
from pipeline.analysis.results import Results
from pipeline.analysis.results_of_tests import ABSENT, TestResults
from pipeline.analysis.specimen import specimen_at
from pipeline.analysis.tables import frame_of, short
from pipeline.constants import UNLIKELY
from pipeline.quantities import display
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.case import Test
from pipeline.sweep.conditions import Conditions, rise_limit, with_own
from tribo import InputError
from tribo.types import Array, Mask

APART = 0.05
"""Relative distance of the two critical velocities from which a line names it."""
_FARTHEST = 20.0  # |y| of a test, so that a rise of 0 or a limit of 0 has one
_BESIDE = 0.1  # relative distance in load and velocity within which a test is near
_SAME = 1e-9  # relative rounding difference of equal conditions
_HEADS = (
    "test", "outcome", "load [N]", "velocity [m/s]", "friction", "bulk temperature [°C]",
    "deciding temperature [°C]", "ln(rise/limit)", "by the others", "notes",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ComparedTest:
    """A test at its own conditions: y where it was severe, and where it was mild.

    A measured transition has both: with a step at its two ends, without one the same twice. NaN
    where the test says nothing, or has no result.
    """

    test: Test
    conditions: Conditions | None
    severe: float = math.nan
    mild: float = math.nan
    temperature: float = math.nan  # that the criterion compares, at the test's place [K]
    is_outside: bool = False  #: True if a film carries too much, so that the test does not count.
    reason: str = ""  #: Why the test has no y; empty if it has one.
    place: int = 0  #: Number of the test in the scene, from 0.

    @property
    def name(self) -> str:
        """The test in words, such as "test 3 (severe, 400 N, 2.25 m/s)"."""
        test = self.test
        place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
        return f"test {test.number} ({test.outcome or 'transition'}, {place})"

    @property
    def specimen(self) -> str:
        """Name of the specimen: that of the run, or the test's own."""
        return f"run {self.test.run}" if self.test.run else f"test {self.test.number}"


@dataclass(frozen=True, eq=False)
class Evidence:
    """All tests of a scene, under one oil's conditions, and what they make of the prior."""

    rows: tuple[ComparedTest, ...]
    results: tuple[SpecimenResult, ...]  # one for each specimen that has a y
    members: tuple[tuple[ComparedTest, ...], ...]  # rows of each result
    belief: Belief

    @property
    def waiting(self) -> tuple[ComparedTest, ...]:
        """Tests without a y: they wait, have failed, or cannot be compared."""
        return tuple(row for row in self.rows if row.reason)

    @property
    def misfits(self) -> Iterator[str]:
        """Yield a line for each test outside the model, and each that the others find unlikely."""
        for row in self.rows:
            if row.is_outside:
                yield f"{row.name} does not count: it is {OUTSIDE_WORDS}"
        for rows, share in zip(self.members, self.belief.expected, strict=True):
            if share < UNLIKELY:
                names = " and ".join(row.name for row in rows)
                yield f"{names}: the other tests give it less than 1 %; is it a slip?"

    @functools.cached_property  # asked for at each operating point
    def text(self) -> str:
        """How far the model may be off, as a part of the rise, and by how many tests."""
        low, high = (math.expm1(-self.belief.level(p)) for p in (0.95, 0.05))
        size = f"{_signed(100 * low)} to {_signed(100 * high)} %".replace("-", "−")
        count = len(self.results)
        tests = "no test" if not count else f"{count} test{'s' * (count > 1)}"
        return f"{size} of the rise (90 %), by {tests} and the prior"

    @property
    def open_sides(self) -> tuple[bool, bool]:
        """Whether no place is mild, and none is severe, as a test without a y might forbid it."""
        outcomes = {row.test.outcome for row in self.waiting}
        return bool(outcomes & {"severe", None}), bool(outcomes & {"mild", None})


def _signed(percent: float) -> str:
    """A percentage with its sign and two digits, or all of its own if it has more."""
    return f"{percent:+.0f}" if abs(percent) >= 10 else f"{percent:+.2g}"


def evidence_of(data: Results, oil: Conditions) -> Evidence:
    """Compare the tests of a scene with the model, under one oil's conditions."""
    rows = tuple(_rows(data, oil)) if data.takes_tests else ()
    grouped = dict[str, list[ComparedTest]]()
    for row in rows:
        if not (row.reason or row.is_outside):
            grouped.setdefault(row.specimen, []).append(row)
    members = tuple(map(tuple, grouped.values()))
    results = tuple(map(_result, members))
    return Evidence(rows, results, members, condition(results, data.prior))


def _result(rows: Sequence[ComparedTest]) -> SpecimenResult:
    """What one specimen says."""
    severe = min((row.severe for row in rows if not math.isnan(row.severe)), default=math.nan)
    mild = max((row.mild for row in rows if not math.isnan(row.mild)), default=math.nan)
    if math.isnan(mild):
        return SpecimenResult(severe)
    if math.isnan(severe):
        return SpecimenResult(mild, sign=-1)
    if severe >= mild:
        return SpecimenResult(severe, width=severe - mild)
    # The specimen contradicts itself, which counts as a transition.
    return SpecimenResult((severe + mild) / 2, width=0.0, own=(mild - severe) / 2 / math.sqrt(3))


def _rows(data: Results, oil: Conditions) -> Iterator[ComparedTest]:
    """Yield the tests of a scene with their y, on the specimen of all patches."""
    held, specimen = data.tests, None
    if data.patches > 1 and data.kind is Layout.PLANE:
        specimen = specimen_at(data.take_moving(), oil)
    for number, test in enumerate(data.stored.tests):
        try:
            own = with_own(oil, test.case.conditions)
            limit = rise_limit(own)
        except InputError as error:
            yield ComparedTest(test, None, reason=f"cannot be compared: {error}")
            continue
        points = np.flatnonzero(held.numbers == number).tolist()
        if reason := next(filter(None, (_why_missing(held, place) for place in points)), ""):
            yield ComparedTest(test, own, reason=reason)
            continue
        try:
            rises = [held.rise(place, own) for place in points]
            # They were computed on the first patch alone.
            if specimen:
                aparts = itertools.starmap(specimen.apart_at, test.places)
                rises = [x * math.exp(apart) for x, apart in zip(rises, aparts, strict=True)]
        except InputError as error:
            yield ComparedTest(test, own, reason=f"cannot be compared: {error}")
            continue
        with np.errstate(divide="ignore"):
            y = np.clip(np.log(np.array(rises) / limit), -_FARTHEST, _FARTHEST).tolist()
        temperature = float(own.contact_temperature(rises[-1]))
        severe = y[-1] if test.outcome != "mild" else math.nan
        mild = y[0] if test.outcome != "severe" else math.nan
        beyond = any(is_test_outside(data, place, own) for place in points)
        yield ComparedTest(test, own, severe, mild, temperature, place=number, is_outside=beyond)


def _why_missing(held: TestResults, place: int) -> str:
    """Why a point of a test has no result, after its name; empty if it has one."""
    match held.status[place]:
        case code if code == DONE:
            return ""
        case code if code == FAILED:
            return f"has failed ({held.messages[place]}): irg run SCENE --retry-failed"
        case code if code == ABSENT:
            return "is not in this dataset: irg run SCENE, or leave tests out (--without-tests)"
    return "waits for its point: irg run SCENE"


def forbidden(
    evidence: Evidence, data: Results, conditions: Conditions, loads: Array, velocities: Array
) -> tuple[Mask, Mask, list[str]]:
    """Places where a test that dominates them forbids mild wear, and severe wear (k,).

    A severe test dominates a place that is no easier: load, velocity, friction and bulk temperature
    are no lower, all else equal. A mild test is the mirror of it. A transition without a step does
    both, where something differs. The third result has the names of these tests for each place.
    """
    no_mild, no_severe = (np.zeros(len(loads), bool) for _ in range(2))
    names = [list[str]() for _ in loads]
    friction = conditions.friction * conditions.friction_factor(velocities)
    for row in evidence.rows:
        own, test = row.conditions, row.test
        if own is None or row.is_outside or not is_alike(data, conditions, row):
            continue
        places = test.places
        pairs = {"severe": places[-1], "mild": places[0]}
        for outcome, (load, velocity) in pairs.items():
            if test.outcome not in (outcome, None):
                continue
            at_test = [load, velocity, own.friction_at(velocity), *_bulks(own)]
            here = [loads, velocities, friction, *_bulks(conditions)]
            pairs_apart = itertools.starmap(_apart, zip(here, at_test, strict=True))
            ways = np.array([np.broadcast_to(one, loads.shape) for one in pairs_apart])
            ways = ways if outcome == "severe" else -ways
            holds = (ways >= 0).all(axis=0)
            if test.outcome is None and len(places) == 1:
                holds &= (ways > 0).any(axis=0)
            mask = no_mild if outcome == "severe" else no_severe
            mask |= holds
            for place in np.flatnonzero(holds):
                names[place].append(row.name)
    return no_mild, no_severe, [", ".join(dict.fromkeys(one)) for one in names]


def is_alike(data: Results, conditions: Conditions, row: ComparedTest) -> bool:
    """True if a place and a test differ in nothing but what may be compared."""
    if row.conditions is None:
        return False
    scene, alike = row.test.case.scene, with_own(row.conditions, conditions) == conditions
    return alike and (scene is data.sweep.scene or scene == data.sweep.scene)


def _bulks(conditions: Conditions) -> tuple[float, float]:
    disk = conditions.disk_temperature
    return conditions.bulk_temperature, conditions.bulk_temperature if disk is None else disk


def _apart(a: Array | float, b: float) -> Array:
    """Sign of a − b; 0 if they differ by rounding only."""
    difference = np.asarray(a, float) - b
    return np.where(np.abs(difference) <= _SAME * abs(b), 0.0, np.sign(difference))


def tests_beside(evidence: Evidence, load: float, velocity: float) -> Iterator[str]:
    """Yield each test within 10 % of a load [N] and of a velocity [m/s], with its conditions."""
    for row in evidence.rows:
        test, own = row.test, row.conditions
        pairs = (test.normal_load, load), (test.velocity, velocity)
        if own is None or any(abs(there - here) > _BESIDE * here for there, here in pairs):
            continue
        at = f"friction {own.friction_at(test.velocity):.3g}"
        bulk = display(own.bulk_temperature, "°C", 3)
        place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
        yield f"{test.outcome or 'transition'}, {place} at {at} and bulk {bulk}"


def waiting_words(evidence: Evidence) -> str:
    """Which tests have no result yet, and why; empty if all have one."""
    rows = evidence.waiting
    if not rows:
        return ""
    others = f" and {len(rows) - 1} more" * (len(rows) > 1)
    return f"{rows[0].name}{others} {rows[0].reason}"


def tests_frame(evidence: Evidence) -> pd.DataFrame:
    """Data frame of the tests of a scene, with a row for each."""
    expected = {
        id(row): share
        for rows, share in zip(evidence.members, evidence.belief.expected, strict=True)
        for row in rows
    }
    rows = []
    for row in evidence.rows:
        test, own = row.test, row.conditions
        y = row.mild if math.isnan(row.severe) else row.severe
        at = (own.friction_at(test.velocity), own.bulk_temperature) if own else (None, None)
        rows.append((
            test.number, test.outcome or "transition", test.normal_load, test.velocity, *at,
            row.temperature, y, expected.get(id(row)), row.reason or None,
        ))  # fmt: skip
    return frame_of(_HEADS, rows)


def test_parts(evidence: Evidence) -> Iterator[str | pd.DataFrame]:
    """Yield parts of a report on tests: a table, tests without a result, and misfits."""
    frame = tests_frame(evidence)
    yield f"{len(evidence.rows)} tests, each at its own friction and bulk temperature"
    yield short(frame, ["notes"])
    for row in evidence.waiting:
        yield f"{row.name} {row.reason}"
    yield from evidence.misfits
    yield f"the model's own error: {evidence.text}"
