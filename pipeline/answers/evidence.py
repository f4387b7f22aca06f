"""Tests of a scene, each at its own conditions, and the model error after them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.answers.condition_values import evaluate_by_bulk
from pipeline.answers.posterior import CriticalTemperature, Outcome, Posterior, Prior, update
from pipeline.answers.results import CaseResults, TestPoint
from pipeline.answers.specimen import Specimen
from pipeline.constants import UNLIKELY
from pipeline.quantities import display
from pipeline.sweep.case import SpecimenTest
from pipeline.sweep.condition_entries import Conditions, allowable_rise, with_test_conditions
from tribo import InputError
from tribo.simulation.film import film_excess
from tribo.types import Array, Mask

_MAX_Y = 20.0  # largest |y| of a test, also for a rise or a limit of 0
_MAX_DISTANCE = 0.1  # relative distance in load and velocity of a nearby test


@dataclass(frozen=True, slots=True)
class EvaluatedTest:
    """A test at its own conditions: y at which it was severe, and y at which it was mild.

    A measured transition has both: with a step they are those of its two ends, else equal. They
    are NaN if the test has no such outcome, or no result.
    """

    test: SpecimenTest
    conditions: Conditions | None
    severe: float = math.nan
    mild: float = math.nan
    temperature: float = math.nan  # governing temperature at the test's point [K]
    is_outside: bool = False  #: True if an oil film carries too much load: y is not used.
    reason: str = ""  #: Reason for a missing y; else empty.

    def __str__(self) -> str:
        test = self.test
        point = f"{test.normal_load:g} N, {test.velocity:g} m/s"
        return f"test {test.number} ({test.outcome}, {point})"


@dataclass(frozen=True, eq=False)
class Evidence:
    """All tests of a case, under the conditions of one oil, and the posterior."""

    rows: tuple[EvaluatedTest, ...]
    prior: Prior
    critical: CriticalTemperature | None = None  #: If it is inferred from tests.

    @functools.cached_property
    def specimens(self) -> list[list[EvaluatedTest]]:
        """Tests with a result within the model, grouped by specimen.

        Both ends of a run by stages belong to one specimen.
        """
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
            return self._evaluate_by_bulk(
                bulks, lambda posterior, is_member: posterior.probability(y[is_member])
            )

        return [*map(probability, ys)]

    def log_rise_ratio_quantiles(self, probability: float, bulks: Array) -> Array:
        """Y (k,) at which severe wear has a probability, at bulk temperatures [K]."""
        return self._evaluate_by_bulk(
            bulks,
            lambda posterior, is_member: np.full(is_member.sum(), posterior.level(probability)),
        )

    def _evaluate_by_bulk(self, bulks: Array, value: Callable[[Posterior, Mask], Array]) -> Array:
        """Values of points by the posterior at the bulk temperature of each."""
        if self.critical is None:
            return value(self.posterior, np.ones(bulks.shape, bool))
        at_bulk = self.critical.at_bulk
        return evaluate_by_bulk(bulks, lambda bulk, is_member: value(at_bulk(bulk), is_member))

    @property
    def without_result(self) -> list[EvaluatedTest]:
        """Tests without a y: they are pending, have failed, or cannot be compared."""
        return [row for row in self.rows if row.reason]

    @property
    def outliers(self) -> Iterator[str]:
        """Yield a line for each test outside the model, and for each outlier."""
        for row in self.rows:
            if row.is_outside:
                yield f"{row} gives no probability: an oil film carried more than 20 % of the load"
        for rows, share in zip(self.specimens, self.posterior.loo_probabilities, strict=True):
            if share < UNLIKELY:
                names = " and ".join(map(str, rows))
                yield f"outlier: {names} has a probability of less than 1 % by the other tests"

    def nearby(self, load: float, velocity: float) -> Iterator[str]:
        """Yield each test within 10 % of a load [N] and a velocity [m/s], with its conditions."""
        for row in self.rows:
            test, conditions = row.test, row.conditions
            pairs = (test.normal_load, load), (test.velocity, velocity)
            if conditions is None or any(
                abs(test_value - value) > _MAX_DISTANCE * value for test_value, value in pairs
            ):
                continue
            point = f"{test.normal_load:g} N, {test.velocity:g} m/s"
            friction = f"friction {conditions.friction:.3g}"
            bulk = display(conditions.bulk_temperature, "°C", 3)
            yield f"{test.outcome} at {point}, {friction}, bulk temperature {bulk}"


def waiting_text(evidence: Evidence) -> str:
    """First test without a result, with the reason, and the number of others; else empty."""
    rows = evidence.without_result
    if len(rows) > 1:
        return f"{rows[0]} {rows[0].reason}; {len(rows) - 1} more without a result"
    return f"{rows[0]} {rows[0].reason}" if rows else ""


def outcome_of(rows: list[EvaluatedTest]) -> Outcome:
    """Result of one specimen as an interval, from its highest mild y to its lowest severe y."""
    severe = min((row.severe for row in rows if not math.isnan(row.severe)), default=math.inf)
    mild = max((row.mild for row in rows if not math.isnan(row.mild)), default=-math.inf)
    return Outcome(severe, mild)


def evidence_of(case: CaseResults, specimen: Specimen, oil: Conditions) -> Evidence:
    """Compare the tests of a case with the model, under one oil's conditions."""
    rows = tuple(
        _evaluate(case, specimen, oil, test, points)
        for test, points in zip(case.sweep.tests, case.tests, strict=True)
    )
    base = case.sweep.base
    return Evidence(rows, Prior(base.model_bias, base.model_scatter))


def _evaluate(
    case: CaseResults, specimen: Specimen, oil: Conditions, test: SpecimenTest,
    points: tuple[TestPoint, ...],
) -> EvaluatedTest:  # fmt: skip
    try:
        conditions = with_test_conditions(oil, test.case.conditions)
        if reason := next((point.missing_reason for point in points if point.missing_reason), ""):
            return EvaluatedTest(test, conditions, reason=reason)
        rises = np.array([point.rise(conditions) for point in points])
    except InputError as error:
        return EvaluatedTest(test, None, reason=f"cannot be compared with the model: {error}")
    if len(specimen.differences) > 1:  # tests are simulated only on the first realization
        rises = rises * np.exp([specimen.offset_at(*pair) for pair in test.points])
    with np.errstate(divide="ignore"):
        y = np.clip(np.log(rises / allowable_rise(conditions)), -_MAX_Y, _MAX_Y).tolist()
    return EvaluatedTest(
        test, conditions,
        severe=y[-1] if test.outcome != "mild" else math.nan,
        mild=y[0] if test.outcome != "severe" else math.nan,
        temperature=float(conditions.contact_temperature(rises[-1])),
        is_outside=any(_is_outside(case, test, point, conditions) for point in points),
    )  # fmt: skip


def _is_outside(
    case: CaseResults, test: SpecimenTest, point: TestPoint, conditions: Conditions
) -> bool:
    """True if a film carries too much load at a point of a test."""
    oil, columns = case.sweep.lubricant, point.columns
    if oil is None or not case.sweep.base.has_film or "film_inlet" not in columns:
        return False
    inlet, pressure = float(columns["film_inlet"]), float(columns["film_pressure"])
    if not (inlet > 0 and pressure > 0):  # the film is not known
        return False
    operating_point, bulk = (point.load, point.velocity), conditions.bulk_temperature
    return film_excess(test.case.scene, oil, *operating_point, bulk, inlet, pressure) > 0
