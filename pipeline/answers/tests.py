"""The tests of a scene at their own conditions, and what they forbid by dominance."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.answers.likelihood import Outcome, Posterior, Prior, update
from pipeline.answers.results import CaseResults, TestPoint
from pipeline.answers.specimen import Specimen
from pipeline.constants import UNLIKELY
from pipeline.quantities import display
from pipeline.sweep.case import Test
from pipeline.sweep.conditions import Conditions, rise_limit, with_own
from tribo import InputError
from tribo.simulation.film import film_excess
from tribo.types import Array, Mask

_FARTHEST = 20.0  # |y| of a test, so that a rise of 0 or a limit of 0 has one
_BESIDE = 0.1  # relative distance in load and velocity within which a test is near
_SAME = 1e-9  # relative rounding difference of equal conditions


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
    temperature: float = math.nan  # compared with the critical one, at the test's place [K]
    is_outside: bool = False  #: True if an oil film carries too much, so that y does not count.
    reason: str = ""  #: Why the test has no y; empty if it has one.

    def __str__(self) -> str:
        test = self.test
        place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
        return f"test {test.number} ({test.outcome or 'transition'}, {place})"


@dataclass(frozen=True, eq=False)
class Evidence:
    """All tests of a case, under one oil's conditions, and what they make of the prior."""

    rows: tuple[ComparedTest, ...]
    prior: Prior

    @functools.cached_property
    def specimens(self) -> list[list[ComparedTest]]:
        """Tests that count, those of one specimen together."""
        grouped = dict[str, list[ComparedTest]]()
        for row in self.rows:
            if not (row.reason or row.is_outside):
                grouped.setdefault(str(row.test.number), []).append(row)
        return [*grouped.values()]

    @functools.cached_property
    def posterior(self) -> Posterior:
        """Bias and scatter of the model, after the tests."""
        return update(tuple(map(outcome_of, self.specimens)), self.prior)

    @property
    def waiting(self) -> list[ComparedTest]:
        """Tests without a y: they wait, have failed, or cannot be compared."""
        return [row for row in self.rows if row.reason]

    @property
    def open_sides(self) -> tuple[bool, bool]:
        """Whether no place is mild, and none is severe, as a test without a y might forbid it."""
        kinds = {row.test.outcome for row in self.waiting}
        return bool(kinds & {"severe", None}), bool(kinds & {"mild", None})

    @property
    def misfits(self) -> Iterator[str]:
        """Yield a line for each test outside the model, and each that the others find unlikely."""
        for row in self.rows:
            if row.is_outside:
                yield f"{row} says nothing of the model: an oil film carried too much of the load"
        for rows, share in zip(self.specimens, self.posterior.expected, strict=True):
            if share < UNLIKELY:
                names = " and ".join(map(str, rows))
                yield f"{names}: the other tests give it less than 1 %; is it a slip?"

    def beside(self, load: float, velocity: float) -> Iterator[str]:
        """Yield each test within 10 % of a load [N] and a velocity [m/s], with its conditions."""
        for row in self.rows:
            test, own = row.test, row.conditions
            pairs = (test.normal_load, load), (test.velocity, velocity)
            if own is None or any(abs(there - here) > _BESIDE * here for there, here in pairs):
                continue
            place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
            at = f"friction {own.friction_at(test.velocity):.3g}"
            bulk = display(own.bulk_temperature, "°C", 3)
            yield f"{test.outcome or 'transition'}, {place} at {at} and bulk {bulk}"


def outcome_of(rows: list[ComparedTest], shift: float | Array = 0.0) -> Outcome:
    """What one specimen says: the easiest place where it was severe, the hardest mild one."""
    severe = min((row.severe for row in rows if not math.isnan(row.severe)), default=math.inf)
    mild = max((row.mild for row in rows if not math.isnan(row.mild)), default=-math.inf)
    return Outcome(severe, mild)


def evidence_of(case: CaseResults, specimen: Specimen, oil: Conditions) -> Evidence:
    """Compare the tests of a case with the model, under one oil's conditions."""
    rows = tuple(
        _compared(case, specimen, oil, test, points)
        for test, points in zip(case.sweep.tests, case.tests, strict=True)
    )
    base = case.sweep.base
    return Evidence(rows, Prior(base.model_bias, base.model_scatter))


def _compared(
    case: CaseResults, specimen: Specimen, oil: Conditions, test: Test,
    points: tuple[TestPoint, ...],
) -> ComparedTest:  # fmt: skip
    try:
        own = with_own(oil, test.case.conditions)
        if reason := next((one.why_missing for one in points if one.why_missing), ""):
            return ComparedTest(test, own, reason=reason)
        rises = np.array([one.rise(own) for one in points])
    except InputError as error:
        return ComparedTest(test, None, reason=f"cannot be compared: {error}")
    if len(specimen.apart) > 1:  # they were computed on the first patch alone
        rises = rises * np.exp([specimen.offset_at(*place) for place in test.places])
    with np.errstate(divide="ignore"):
        y = np.clip(np.log(rises / rise_limit(own)), -_FARTHEST, _FARTHEST).tolist()
    return ComparedTest(
        test, own,
        severe=y[-1] if test.outcome != "mild" else math.nan,
        mild=y[0] if test.outcome != "severe" else math.nan,
        temperature=float(own.contact_temperature(rises[-1])),
        is_outside=any(_is_outside(case, test, point, own) for point in points),
    )  # fmt: skip


def _is_outside(case: CaseResults, test: Test, point: TestPoint, own: Conditions) -> bool:
    """True if a film carries too much at a point of a test."""
    oil, held = case.sweep.lubricant, point.columns
    if oil is None or not case.sweep.base.has_film or "film_inlet" not in held:
        return False
    inlet, pressure = float(held["film_inlet"]), float(held["film_pressure"])
    if not (inlet > 0 and pressure > 0):  # the film is not known
        return False
    place, bulk = (point.load, point.velocity), own.bulk_temperature
    return film_excess(test.case.scene, oil, *place, bulk, inlet, pressure) > 0


class Forbidden(NamedTuple):
    """Places at which tests forbid mild wear, and severe wear (k,), and the names of the tests."""

    mild: Mask
    severe: Mask
    names: list[str]


def forbidden(
    case: CaseResults, evidence: Evidence, conditions: Conditions, loads: Array, velocities: Array
) -> Forbidden:
    """Places that a test dominates.

    A severe test dominates a place that is no easier: load, velocity, friction and bulk temperature
    are no lower, all else equal. It does so even if a film carried much of its load: wear was
    severe in spite of it. A mild test is the mirror of it, unless a film carried too much. A
    transition without a step does both, where something differs.
    """
    masks = {kind: np.zeros(len(loads), bool) for kind in ("severe", "mild")}
    names = [list[str]() for _ in loads]
    here = [loads, velocities, conditions.friction * conditions.friction_factor(velocities)]
    here.append(np.full(len(loads), conditions.bulk_temperature))
    for row in evidence.rows:
        own, test = row.conditions, row.test
        if own is None or with_own(own, conditions) != conditions:
            continue
        if test.case.scene != case.sweep.scene:
            continue
        for kind, place in (("severe", test.places[-1]), ("mild", test.places[0])):
            if test.outcome not in (kind, None) or (kind == "mild" and row.is_outside):
                continue
            there = [*place, own.friction_at(place[1]), own.bulk_temperature]
            ways = np.array([_apart(a, b) for a, b in zip(here, there, strict=True)])
            ways = ways if kind == "severe" else -ways
            holds = (ways >= 0).all(axis=0)
            if test.outcome is None and len(test.places) == 1:
                holds &= (ways > 0).any(axis=0)
            masks[kind] |= holds
            for k in np.flatnonzero(holds).tolist():
                names[k].append(str(row))
    return Forbidden(masks["severe"], masks["mild"], [", ".join(dict.fromkeys(n)) for n in names])


def _apart(a: Array, b: float) -> Array:
    """Sign of a − b; 0 if they differ by rounding only."""
    return np.where(np.abs(a - b) <= _SAME * abs(b), 0.0, np.sign(a - b))
