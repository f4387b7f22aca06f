"""Tests of a scene, each at its own conditions: the model error after them, what they rule out.

A severe test rules out mild wear at points whose load, velocity, friction and bulk temperature are
no lower, if the scene is the same, with a film or without. A mild test rules out severe wear where
they are no higher, unless a film carried too much of its load. A transition without a step does
both, at points that differ from it. A test without a result may rule a verdict out, so this verdict
is withheld at all points.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.answers.case_results import CaseResults, TestPoint
from pipeline.answers.condition_values import QueryPoints
from pipeline.answers.input_errors import InputErrors, input_errors
from pipeline.answers.posterior import Outcome, Posterior, Prior, leave_one_out, update
from pipeline.answers.specimen import Specimen
from pipeline.answers.value_text import join_texts
from pipeline.constants import OUTLIER_PROBABILITY
from pipeline.sweep.case import (
    Case,
    Conditions,
    OperatingPoint,
    SpecimenTest,
    allowable_rise,
    with_test_conditions,
)
from tribo import InputError
from tribo.simulation.film import film_excess
from tribo.types import Array, Mask

if TYPE_CHECKING:
    from pipeline.answers.critical_temperature import CriticalTemperature

_EQUAL_WITHIN = 1e-9  # relative rounding difference of equal conditions
_ROUNDING_OF_LIMITS = 2e-5  # relative, within which a limit is that of a test
_MAX_Y = 20.0  # largest |y| of a test, also for a rise or a limit of 0


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
    is_same_scene: bool = True  #: False if the test changes what the sweep simulates.
    reason: str = ""  #: Reason for a missing y; else empty.

    def __str__(self) -> str:
        test = self.test
        point = f"{test.normal_load:g} N, {test.velocity:g} m/s"
        return f"test {test.number} ({test.outcome}, {point})"

    def end_for(self, verdict: str) -> OperatingPoint:
        """Point of the test that rules a `verdict` out at others."""
        return self.test.points[-1 if verdict == "mild" else 0]

    def rules_out(self, verdict: str, points: QueryPoints) -> Mask:
        """True at points (k,) at which the test rules out a `verdict`, "mild" or "severe"."""
        conditions = self.conditions
        if (
            conditions is None
            or not self.is_same_scene
            or self.test.outcome == verdict
            or (verdict == "severe" and self.is_outside)
        ):
            return np.zeros(points.load.shape, bool)
        own = *self.end_for(verdict), conditions.friction, conditions.bulk_temperature
        signs = np.array([_sign(a, b) for a, b in zip(points, own, strict=True)])
        if verdict == "severe":
            signs = -signs
        # A transition without a step allows both verdicts at its own point.
        is_strict = self.test.outcome == "transition" and len(self.test.points) == 1
        return np.asarray((signs >= 0).all(axis=0) & ((signs > 0).any(axis=0) | (not is_strict)))


@dataclass(frozen=True, eq=False)
class Evidence:
    """All tests of a case, under the conditions of one oil, and the posterior."""

    rows: tuple[EvaluatedTest, ...]
    prior: Prior
    inputs: InputErrors | None  #: Errors by uncertain inputs, a part of the prior's bias.
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
    def outcomes(self) -> tuple[Outcome, ...]:
        """Result of each specimen."""
        deviation = self.inputs.deviation if self.inputs else 0.0
        return tuple(
            outcome_of(rows, deviation * rows[0].test.has_own_inputs) for rows in self.specimens
        )

    def has_outcome(self, name: str) -> bool:
        """True if a specimen was "mild", or "severe", by `name`."""
        return any(math.isfinite(getattr(outcome, name)) for outcome in self.outcomes)

    @functools.cached_property
    def posterior(self) -> Posterior:
        """Bias and scatter of the model, after the tests, at the scene's bulk temperature."""
        if self.critical is None:
            return update(self.outcomes, self.prior)
        return self.critical.at_bulk(self.critical.bulk)

    @functools.cached_property
    def loo_probabilities(self) -> tuple[float, ...]:
        """Leave-one-out probability of each specimen; on this rig, Tc from tests has no bias."""
        if self.critical is None:
            return leave_one_out(self.outcomes, self.prior)
        return leave_one_out(self.critical.outcomes, replace(self.critical.prior, bias=0.0))

    def probability(self, y: Array, bulks: Array) -> Array:
        """Probability of severe wear (k,) at `y` (k,), at bulk temperatures [K]."""
        probability = np.full(y.shape, np.nan)
        for posterior, is_member in self._posteriors(bulks):
            probability[is_member] = posterior.probability(y[is_member])
        return probability

    def log_rise_ratio_quantiles(self, probability: float, bulks: Array) -> Array:
        """Y (k,) at which severe wear has a probability, at bulk temperatures [K]."""
        quantiles = np.full(bulks.shape, np.nan)
        for posterior, is_member in self._posteriors(bulks):
            quantiles[is_member] = posterior.level(probability)
        return quantiles

    def _posteriors(self, bulks: Array) -> Iterator[tuple[Posterior, Mask]]:
        """Yield the posterior at each bulk temperature [K] among `bulks`, and its points."""
        if self.critical is None:
            yield self.posterior, np.ones(bulks.shape, bool)
            return
        for bulk in np.unique(bulks).tolist():
            yield self.critical.at_bulk(bulk), bulks == bulk

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
        for rows, share in zip(self.specimens, self.loo_probabilities, strict=True):
            if share < OUTLIER_PROBABILITY:
                names = " and ".join(map(str, rows))
                yield f"outlier: {names}, predicted from the other tests with less than 1 %"

    @property
    def waiting_text(self) -> str:
        """First test without a result, with the reason, and the number of others; else empty."""
        rows = self.without_result
        if len(rows) > 1:
            return f"{rows[0]} {rows[0].reason}; {len(rows) - 1} more without a result"
        return f"{rows[0]} {rows[0].reason}" if rows else ""

    @functools.cached_property
    def withheld(self) -> dict[str, str]:
        """Reason to withhold a verdict at all points, by verdict; empty if there is none."""
        reasons = dict[str, str]()
        for verdict, opposite in (("mild", "severe"), ("severe", "mild")):
            is_open = any(row.test.outcome != verdict for row in self.without_result)
            reasons[verdict] = self.waiting_text if is_open else ""
            if self.critical and not (reasons[verdict] or self.has_outcome(opposite)):
                reasons[verdict] = (
                    f"the critical temperature is from tests, and none of them was {opposite}"
                )
        return reasons

    def rules_out(self, verdict: str, points: QueryPoints) -> Mask:
        """True at points (k,) that cannot be `verdict`, "mild" or "severe"."""
        masks = (row.rules_out(verdict, points) for row in self.rows)
        withheld = np.full(points.load.shape, bool(self.withheld[verdict]))
        return functools.reduce(np.logical_or, masks, withheld)

    def objections(self, verdict: str, points: QueryPoints) -> list[str]:
        """Reason why each point (k,) cannot be `verdict`, "mild" or "severe"; empty if it can."""
        if self.withheld[verdict]:
            return [self.withheld[verdict]] * len(points.load)
        names = (dict.fromkeys(map(str, rows)) for rows in self._ruling(verdict, points))
        return [f"{', '.join(n)} rules it out" if n else "" for n in names]

    def texts_on_limits(self, points: QueryPoints, mild: Array, severe: Array) -> Any:
        """Tests that decide the `mild` or `severe` limits of velocity (k,) at the loads of points.

        The texts are empty without such a test.
        """
        texts = np.full(points.load.shape, "", object)
        for verdict, beyond, words in (
            ("mild", mild * (1 + _ROUNDING_OF_LIMITS), "mild wear from"),
            ("severe", severe * (1 - _ROUNDING_OF_LIMITS), "severe wear up to"),
        ):
            for k, rows in enumerate(self._ruling(verdict, points._replace(velocity=beyond))):
                if rows:
                    text = f"{rows[0]} rules out {words} {rows[0].end_for(verdict)[1]:g} m/s"
                    texts[k] = join_texts((texts[k], text))
        return texts

    def _ruling(self, verdict: str, points: QueryPoints) -> list[list[EvaluatedTest]]:
        """Tests that rule out `verdict` at each point (k,)."""
        masks = [row.rules_out(verdict, points) for row in self.rows]
        return [
            [row for row, mask in zip(self.rows, masks, strict=True) if mask[k]]
            for k in range(len(points.load))
        ]


def outcome_of(rows: list[EvaluatedTest], added_scatter: float = 0.0) -> Outcome:
    """Result of one specimen as an interval, from its highest mild y to its lowest severe y."""
    severe = min((row.severe for row in rows if not math.isnan(row.severe)), default=math.inf)
    mild = max((row.mild for row in rows if not math.isnan(row.mild)), default=-math.inf)
    return Outcome(severe, mild, added_scatter)


def evidence_of(case: CaseResults, specimen: Specimen, oil: Conditions) -> Evidence:
    """Compare the tests of a case with the model, under one oil's conditions."""
    rows = tuple(
        _evaluate(case, specimen, oil, test, points)
        for test, points in zip(case.sweep.tests, case.tests, strict=True)
    )
    inputs = input_errors(case, oil)
    return Evidence(rows, prior_of(case.sweep.base, inputs), inputs)


def prior_of(base: Case, inputs: InputErrors | None) -> Prior:
    """The model error of a case before tests, with its uncertain inputs."""
    bias = base.model_bias
    if inputs:
        bias = max(bias, math.hypot(base.bias_without_inputs, inputs.deviation))
    return Prior(bias, base.model_scatter)


def _evaluate(
    case: CaseResults, specimen: Specimen, oil: Conditions, test: SpecimenTest,
    points: tuple[TestPoint, ...],
) -> EvaluatedTest:  # fmt: skip
    is_same_scene = test.case.scene == case.sweep.scene
    try:
        conditions = with_test_conditions(oil, test.case.conditions)
        if reason := next((point.missing_reason for point in points if point.missing_reason), ""):
            return EvaluatedTest(test, conditions, is_same_scene=is_same_scene, reason=reason)
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
        is_same_scene=is_same_scene,
    )  # fmt: skip


def _is_outside(
    case: CaseResults, test: SpecimenTest, point: TestPoint, conditions: Conditions
) -> bool:
    """True if a film carries too much load at a point of a test."""
    oil, columns = case.sweep.lubricant, point.columns
    if oil is None or not case.sweep.base.has_film or "film_inlet" not in columns:
        return False
    inlet, pressure = float(columns["film_inlet"]), float(columns["film_pressure"])
    operating_point, bulk = (point.load, point.velocity), conditions.bulk_temperature
    return film_excess(test.case.scene, oil, *operating_point, bulk, inlet, pressure) > 0


def _sign(a: Array, b: float) -> Array:
    """Sign of a − b; 0 if they differ only by rounding."""
    return np.where(np.abs(a - b) <= _EQUAL_WITHIN * abs(b), 0.0, np.sign(a - b))
