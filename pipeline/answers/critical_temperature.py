"""Critical temperature Tc of the lubricant, inferred from tests.

The prior of ln(Tc − bulk temperature) is Student's t with 4 degrees of freedom and a scale of 1,
centred on ln(120 K). At each Tc the y of every test is computed at the bulk temperature of this
test, so the result does not depend on an initial guess. On the same rig Tc contains the model's
bias; on another rig the bias is added.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.answers.case_results import CaseResults
from pipeline.answers.evidence import Evidence, evidence_of
from pipeline.answers.posterior import Outcome, Posterior, Prior, change_at, density, update
from pipeline.answers.specimen import Specimen
from pipeline.sweep.case import Conditions
from tribo import InputError

_PRIOR_MEDIAN = 120.0  # of Tc − bulk temperature [K]
_LOGS = np.linspace(-4, 4, 101)  # ln((Tc − bulk)/120 K), at which bounds are sought
_DEVIATIONS = np.linspace(-8, 8, 801)  # from the mean, over the standard deviation
_BOUND = 0.05  # likelihood over its maximum, at the bound by tests of a single outcome


@dataclass(frozen=True, eq=False)
class CriticalTemperature:
    """Critical temperature inferred from tests; `temperature` is its median on this rig [K]."""

    temperature: float
    spread: float  # standard deviation on this rig [K]
    at_least: float  # bounds by tests of a single outcome [K]; NaN if there are both outcomes
    at_most: float
    bulk: float  # bulk temperature of the scene [K]
    outcomes: tuple[Outcome, ...]  # with y at `temperature`
    prior: Prior
    _at_bulk: dict[float, Posterior] = field(default_factory=dict, repr=False)

    @functools.cached_property
    def posterior(self) -> Posterior:
        """Bias, critical temperature and scatter after the tests."""
        return update(self.outcomes, self.prior)

    def at_bulk(self, bulk: float) -> Posterior:
        """Posterior of points at a bulk temperature [K], with y at `temperature`."""
        if bulk not in self._at_bulk:
            self._at_bulk[bulk] = self.posterior.at(_warmth(bulk, self.bulk, self.temperature))
        return self._at_bulk[bulk]

    @functools.cached_property
    def spread_with_bias(self) -> float:
        """Standard deviation of the critical temperature on another rig [K]."""
        return (self.temperature - self.bulk) * _deviation(self.posterior)


def evidence_with_critical_temperature(
    case: CaseResults, specimen: Specimen, oil: Conditions
) -> Evidence:
    """Infer Tc from the tests of a case; return them with this Tc, and with their y at it.

    `oil` has all conditions but the critical temperature.
    """
    bulk = case.sweep.conditions.bulk_temperature
    bulks = [bulk, *(test.case.conditions.bulk_temperature for test in case.sweep.tests)]
    temperature = max([oil.bulk_temperature, *bulks]) + _PRIOR_MEDIAN
    evidence = evidence_of(case, specimen, replace(oil, critical_temperature=temperature))
    if not evidence.specimens:
        reason = "; ".join(row.reason for row in evidence.without_result[:1]) or "it has none"
        raise InputError(
            f"scene {case.sweep.name}: the critical temperature is from tests, and no test has a "
            f"result ({reason})"
        )
    outcomes, prior = _outcomes_and_prior(evidence, bulk, temperature)
    prior = replace(prior, bias=0.0)
    without_bias = update(outcomes, prior)
    excess = (temperature - bulk) * math.exp(-_median_change(without_bias, outcomes, prior))
    at_least, at_most = _bounds(evidence, outcomes, bulk, temperature)
    if bulk + excess > max(bulks):
        temperature = bulk + excess
        evidence = evidence_of(case, specimen, replace(oil, critical_temperature=temperature))
    outcomes, prior = _outcomes_and_prior(evidence, bulk, temperature)
    spread = excess * _deviation(without_bias)
    critical = CriticalTemperature(temperature, spread, at_least, at_most, bulk, outcomes, prior)
    return replace(evidence, critical=critical)


def _outcomes_and_prior(
    evidence: Evidence, bulk: float, temperature: float
) -> tuple[tuple[Outcome, ...], Prior]:
    """Outcomes with the warmth of each specimen, and the prior with that of Tc."""
    bulks = (rows[0].test.case.conditions.bulk_temperature for rows in evidence.specimens)
    outcomes = tuple(
        replace(outcome, warmth=_warmth(test_bulk, bulk, temperature))
        for outcome, test_bulk in zip(evidence.outcomes, bulks, strict=True)
    )
    change = math.log((temperature - bulk) / _PRIOR_MEDIAN)
    return outcomes, replace(evidence.prior, critical_change=change)


def _warmth(bulk: float, scene_bulk: float, temperature: float) -> float:
    """Warmth of an `Outcome` at a bulk temperature [K], if y is computed at Tc = `temperature`."""
    return (bulk - scene_bulk) / (temperature - scene_bulk)


def _median_change(posterior: Posterior, outcomes: tuple[Outcome, ...], prior: Prior) -> float:
    """Median of the change of y by Tc in the `posterior` of a prior without a bias."""
    changes = posterior.weights @ posterior.change + _deviation(posterior) * _DEVIATIONS
    weights = density(changes, outcomes, prior)
    cumulative = np.cumsum(weights) - weights / 2
    return float(np.interp(0.5, cumulative / weights.sum(), changes))


def _deviation(posterior: Posterior) -> float:
    """Standard deviation of ln(Tc − bulk)."""
    mean = posterior.weights @ posterior.change
    return math.sqrt(posterior.weights @ np.square(posterior.change - mean))


def _bounds(
    evidence: Evidence, outcomes: tuple[Outcome, ...], bulk: float, temperature: float
) -> tuple[float, float]:
    """Bounds [K] by tests of a single outcome, on any rig; NaN for no bound."""
    has_mild = evidence.has_outcome("mild")
    if has_mild == evidence.has_outcome("severe"):
        return math.nan, math.nan
    model = update((), evidence.prior)
    change = math.log((temperature - bulk) / _PRIOR_MEDIAN) - _LOGS[:, None] + model.bias
    logs = np.zeros(change.shape)
    for outcome in outcomes:
        test_change = change_at(outcome.warmth, change, model.bias)
        logs += outcome.log_likelihood(test_change, model.scatter)
    log_likelihoods = np.log(np.maximum(np.exp(logs) @ model.weights, 1e-300))
    order = 1 if has_mild else -1  # in which the likelihood increases
    log = np.interp(
        log_likelihoods.max() + math.log(_BOUND), log_likelihoods[::order], _LOGS[::order]
    )
    bound = bulk + _PRIOR_MEDIAN * math.exp(log)
    return (bound, math.nan) if has_mild else (math.nan, bound)
