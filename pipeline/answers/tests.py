"""The tests of a scene at their own conditions, and what they rule out by dominance."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pipeline.answers.conditions import Operation, by_bulk
from pipeline.answers.posterior import Outcome, Posterior, Prior, update
from pipeline.answers.results import CaseResults, TestPoint
from pipeline.answers.specimen import Specimen
from pipeline.constants import UNLIKELY
from pipeline.quantities import display
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.conditions import Conditions, allowable_rise, with_own
from tribo import InputError
from tribo.simulation.film import film_excess
from tribo.types import Array, Mask

if TYPE_CHECKING:
    from pipeline.answers.critical_temperature import CriticalTemperature

_FARTHEST = 20.0  # |y| of a test, so that a rise of 0 or a limit of 0 has one
_BESIDE = 0.1  # relative distance in load and velocity within which a test is near
_SAME = 1e-9  # relative rounding difference of equal conditions


@dataclass(frozen=True, slots=True)
class EvaluatedTest:
    """A test at its own conditions: y where it was severe, and where it was mild.

    A measured transition has both: with a step at its two ends, without one the same twice. NaN
    where the test says nothing, or has no result.
    """

    test: SpecimenTest
    conditions: Conditions | None
    severe: float = math.nan
    mild: float = math.nan
    temperature: float = math.nan  # compared with the critical one, at the test's place [K]
    is_outside: bool = False  #: True if an oil film carries too much, so that y does not count.
    reason: str = ""  #: Why the test has no y; empty if it has one.

    def __str__(self) -> str:
        test = self.test
        place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
        return f"test {test.number} ({test.outcome}, {place})"


@dataclass(frozen=True, eq=False)
class Evidence:
    """All tests of a case, under one oil's conditions, and what they make of the prior."""

    rows: tuple[EvaluatedTest, ...]
    prior: Prior
    critical: CriticalTemperature | None = None  #: Where it is integrated over.

    @functools.cached_property
    def specimens(self) -> list[list[EvaluatedTest]]:
        """Tests with a result within the model; both ends of a run by stages are one specimen."""
        grouped = dict[str, list[EvaluatedTest]]()
        for row in self.rows:
            if not (row.reason or row.is_outside):
                grouped.setdefault(str(row.test.number), []).append(row)
        return [*grouped.values()]

    @functools.cached_property
    def posterior(self) -> Posterior:
        """Bias and scatter of the model, after the tests, at the scene's bulk temperature."""
        if self.critical is not None:
            return self.critical.nodes
        return update(tuple(map(outcome_of, self.specimens)), self.prior)

    def probabilities(self, ys: Iterable[Array], bulks: Array) -> list[Array]:
        """Probabilities of severe wear (k,) at each of `ys` (k,), at bulk temperatures [K]."""

        def probability(y: Array) -> Array:
            return self._by_bulk(bulks, lambda one, here: one.probability(y[here]))

        return [*map(probability, ys)]

    def log_rise_ratio_quantiles(self, probability: float, bulks: Array) -> Array:
        """Y (k,) at which severe wear has a probability, at bulk temperatures [K]."""
        return self._by_bulk(bulks, lambda one, here: np.full(here.sum(), one.level(probability)))

    def _by_bulk(self, bulks: Array, value: Callable[[Posterior, Mask], Array]) -> Array:
        """Values of points by the posterior at the bulk temperature of each."""
        if self.critical is None:
            return value(self.posterior, np.ones(bulks.shape, bool))
        at_bulk = self.critical.at_bulk
        return by_bulk(bulks, lambda bulk, here: value(at_bulk(bulk), here))

    @property
    def without_result(self) -> list[EvaluatedTest]:
        """Tests without a y: they wait, have failed, or cannot be compared."""
        return [row for row in self.rows if row.reason]

    @property
    def withheld(self) -> tuple[str, str]:
        """Why no point is mild, and why none is severe; empty if verdicts are given.

        A test without a y might rule them out.
        """
        kinds, why = {row.test.outcome for row in self.without_result}, waiting_text(self)
        no_mild = why * bool(kinds & {"severe", "transition"})
        no_severe = why * bool(kinds & {"mild", "transition"})
        if self.critical is not None:
            one_sided = "the critical temperature is found by tests, of which none was "
            results = [*map(outcome_of, self.specimens)]
            has_severe, has_mild = (
                any(math.isfinite(getattr(one, side)) for one in results)
                for side in ("severe", "mild")
            )
            no_mild = no_mild or f"{one_sided}severe" * (not has_severe)
            no_severe = no_severe or f"{one_sided}mild" * (not has_mild)
        return no_mild, no_severe

    @property
    def outliers(self) -> Iterator[str]:
        """Yield a line for each test outside the model, and each that the others find unlikely."""
        for row in self.rows:
            if row.is_outside:
                yield f"{row} is not used: an oil film carried more than 20 % of the load"
        for rows, share in zip(self.specimens, self.posterior.expected, strict=True):
            if share < UNLIKELY:
                names = " and ".join(map(str, rows))
                yield f"outlier: {names} has a probability of less than 1 % by the other tests"

    def nearby(self, load: float, velocity: float) -> Iterator[str]:
        """Yield each test within 10 % of a load [N] and a velocity [m/s], with its conditions."""
        for row in self.rows:
            test, own = row.test, row.conditions
            pairs = (test.normal_load, load), (test.velocity, velocity)
            if own is None or any(abs(there - here) > _BESIDE * here for there, here in pairs):
                continue
            place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
            at = f"friction {own.friction_at(test.velocity):.3g}"
            bulk = display(own.bulk_temperature, "°C", 3)
            yield f"{test.outcome} at {place}, {at}, bulk temperature {bulk}"


def waiting_text(evidence: Evidence) -> str:
    """Which tests have no result yet, and why; empty if all have one."""
    rows = evidence.without_result
    others = f"; {len(rows) - 1} more without a result" * (len(rows) > 1)
    return f"{rows[0]} {rows[0].reason}{others}" if rows else ""


def outcome_of(rows: list[EvaluatedTest]) -> Outcome:
    """One specimen as an interval of y: from its hardest mild point to its easiest severe one."""
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
    case: CaseResults, specimen: Specimen, oil: Conditions, test: SpecimenTest,
    points: tuple[TestPoint, ...],
) -> EvaluatedTest:  # fmt: skip
    try:
        own = with_own(oil, test.case.conditions)
        if reason := next((one.why_missing for one in points if one.why_missing), ""):
            return EvaluatedTest(test, own, reason=reason)
        rises = np.array([one.rise(own) for one in points])
    except InputError as error:
        return EvaluatedTest(test, None, reason=f"cannot be compared with the model: {error}")
    if len(specimen.apart) > 1:  # they were computed on the first realization alone
        rises = rises * np.exp([specimen.offset_at(*place) for place in test.places])
    with np.errstate(divide="ignore"):
        y = np.clip(np.log(rises / allowable_rise(own)), -_FARTHEST, _FARTHEST).tolist()
    return EvaluatedTest(
        test, own,
        severe=y[-1] if test.outcome != "mild" else math.nan,
        mild=y[0] if test.outcome != "severe" else math.nan,
        temperature=float(own.contact_temperature(rises[-1])),
        is_outside=any(_is_outside(case, test, point, own) for point in points),
    )  # fmt: skip


def _is_outside(case: CaseResults, test: SpecimenTest, point: TestPoint, own: Conditions) -> bool:
    """True if a film carries too much at a point of a test."""
    oil, held = case.sweep.lubricant, point.columns
    if oil is None or not case.sweep.base.has_film or "film_inlet" not in held:
        return False
    inlet, pressure = float(held["film_inlet"]), float(held["film_pressure"])
    if not (inlet > 0 and pressure > 0):  # the film is not known
        return False
    place, bulk = (point.load, point.velocity), own.bulk_temperature
    return film_excess(test.case.scene, oil, *place, bulk, inlet, pressure) > 0


class RuledOut(NamedTuple):
    """Points at which tests rule out mild wear, and severe wear (k,), and the tests' names."""

    mild: Mask
    severe: Mask
    names: list[str]


def ruled_out(
    case: CaseResults, evidence: Evidence, conditions: Conditions, at: Operation
) -> RuledOut:
    """What tests rule out at points by dominance.

    A severe test rules out mild wear where load, velocity, friction and bulk temperature are no
    lower, with the same oil and all else equal, a film or none. A mild test rules out severe wear
    where they are no higher, unless a film carried too much of its load. A transition without a
    step does both, where something differs.
    """
    masks = {kind: np.zeros(len(at.load), bool) for kind in ("severe", "mild")}
    names = [list[str]() for _ in at.load]
    here = [
        at.load, at.velocity, at.friction * conditions.friction_factor(at.velocity),
        at.bulk_temperature,
    ]  # fmt: skip
    for row in evidence.rows:
        own, test = row.conditions, row.test
        if own is None or test.case.scene != case.sweep.scene:
            continue
        for kind, place in (("severe", test.places[-1]), ("mild", test.places[0])):
            if test.outcome not in (kind, "transition") or (kind == "mild" and row.is_outside):
                continue
            there = [*place, own.friction_at(place[1]), own.bulk_temperature]
            ways = np.array([_apart(a, b) for a, b in zip(here, there, strict=True)])
            ways = ways if kind == "severe" else -ways
            holds = (ways >= 0).all(axis=0)
            if test.outcome == "transition" and len(test.places) == 1:
                holds &= (ways > 0).any(axis=0)
            masks[kind] |= holds
            for k in np.flatnonzero(holds).tolist():
                names[k].append(str(row))
    return RuledOut(masks["severe"], masks["mild"], [", ".join(dict.fromkeys(n)) for n in names])


def _apart(a: Array, b: float) -> Array:
    """Sign of a − b; 0 if they differ by rounding only."""
    return np.where(np.abs(a - b) <= _SAME * abs(b), 0.0, np.sign(a - b))
