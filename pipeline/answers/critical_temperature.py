"""Critical temperature Tc of the lubricant, inferred from tests.

The prior of ln(Tc − bulk temperature) is Student's t with 4 degrees of freedom and a scale of 1,
centred on ln(120 K). At each Tc the y of every test is computed at the bulk
temperature of this test, so the result does not depend on an initial guess. On the same rig Tc
contains the model's bias; on another rig the bias is added.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import logsumexp

from pipeline.answers.case_results import CaseResults
from pipeline.answers.evidence import Evidence, evidence_of
from pipeline.answers.posterior import (
    LEAST_BIAS,
    Outcome,
    Posterior,
    Prior,
    log_prior_scatter,
    update,
)
from pipeline.answers.specimen import Specimen
from pipeline.constants import PRIOR_WEIGHT
from pipeline.sweep.case import Conditions
from tribo import InputError
from tribo.types import Array

_PRIOR_MEDIAN = 120.0  # of Tc − bulk temperature [K]
_NODES = np.linspace(-4, 4, 801)  # of ln((Tc − bulk)/120 K)
_SCATTERS, _BIASES, _FARTHEST = 100, 101, 7.0  # nodes; sinh(7) scales of the bias are 550
_BOUND = 0.05  # likelihood over its maximum, at the bound by tests of a single outcome
_GRID_BIASES, _GRID_SCATTERS = 241, 50  # nodes
_GRID_SCALE = 6.0  # scale of the biases over a width; they are 0.3 widths apart in the middle
_MIN_WIDTH = 0.01  # smallest width of these nodes
_MAX_CHANGE = 40.0  # of y by the critical temperature, also if it is not above a bulk temperature
_BIN_WIDTH = 0.25  # difference of biases over the scatter, within which they are merged
_NEGLIGIBLE_PAIR = 1e-11  # largest weight of an omitted pair of node and bias


@dataclass(frozen=True, eq=False)
class CriticalTemperature:
    """Critical temperature inferred from tests; `temperature` is its median on this rig [K]."""

    temperature: float
    spread: float  # standard deviation on this rig [K]
    at_least: float  # bounds by tests of a single outcome [K]; NaN if there are both outcomes
    at_most: float
    bulk: float  # bulk temperature of the scene [K]
    nodes: Posterior  # of bias − ln((Tc − bulk)/(temperature − bulk)) and scatter
    logs: Array  # ln((Tc − bulk)/(temperature − bulk)) by node and bias
    weights: Array  # of each node and bias; their sum is 1
    _at_bulk: dict[float, Posterior] = field(default_factory=dict, repr=False)

    def at_bulk(self, bulk: float) -> Posterior:
        """Bias and scatter of points at a bulk temperature [K], with y at `temperature`.

        A change of Tc changes y by another amount than at the scene's bulk temperature. Biases
        that differ by less than `_BIN_WIDTH` scatters are merged, and their variance is added to
        that of the scatter.
        """
        if bulk == self.bulk:
            return self.nodes
        if bulk not in self._at_bulk:
            self._at_bulk[bulk] = self._posterior_at(bulk)
        return self._at_bulk[bulk]

    def _posterior_at(self, bulk: float) -> Posterior:
        biases = _change_of_y(self.temperature, self._temperatures, bulk) + self._biases
        is_significant = self.weights > _NEGLIGIBLE_PAIR
        biases = np.clip(biases[is_significant], -_MAX_CHANGE, _MAX_CHANGE)
        weights = self.weights[is_significant]
        scatter, inverse = np.unique(self.nodes.scatter, return_inverse=True)
        scatter_index = np.broadcast_to(inverse[:, None], is_significant.shape)[is_significant]
        bins = np.floor(biases / (_BIN_WIDTH * scatter[scatter_index])).astype(int)
        first_bin, bin_count = bins.min(), np.ptp(bins) + 1
        keys = scatter_index * bin_count + bins - first_bin
        groups, inverse = np.unique(keys, return_inverse=True)
        weights, first_moments, second_moments = (
            np.bincount(inverse, weights * biases**power).astype(float) for power in range(3)
        )
        is_kept = weights > _NEGLIGIBLE_PAIR
        weights, means = weights[is_kept], first_moments[is_kept] / weights[is_kept]
        variances = np.maximum(second_moments[is_kept] / weights - means**2, 0.0)
        group_scatter = scatter[groups[is_kept] // bin_count]
        return replace(
            self.nodes, bias=means, scatter=np.hypot(group_scatter, np.sqrt(variances)),
            weights=weights / weights.sum(),
        )  # fmt: skip

    @functools.cached_property
    def spread_with_bias(self) -> float:
        """Standard deviation of the critical temperature on another rig [K]."""
        mean = (self.weights * self.logs).sum()
        variance = (self.weights * np.square(self.logs - mean)).sum()
        return float((self.temperature - self.bulk) * math.sqrt(variance))

    @property
    def _biases(self) -> Array:
        """Bias of each node and bias."""
        return self.nodes.bias[:, None] + self.logs

    @property
    def _temperatures(self) -> Array:
        return self.bulk + (self.temperature - self.bulk) * np.exp(self.logs)


def _change_of_y(start: float, temperatures: Array, bulk: float) -> Array:
    """Change of y at a bulk temperature for critical temperatures other than `start` [K]."""
    above = np.maximum(temperatures - bulk, 1e-300)
    return np.asarray(np.minimum(math.log(start - bulk) - np.log(above), _MAX_CHANGE))


def evidence_with_critical_temperature(
    case: CaseResults, specimen: Specimen, oil: Conditions
) -> Evidence:
    """Infer Tc from the tests of a case; return them with this Tc, and with their y at it.

    `oil` has all conditions but the critical temperature.
    """
    bulk = case.sweep.conditions.bulk_temperature
    bulks = [bulk, *(test.case.conditions.bulk_temperature for test in case.sweep.tests)]
    start = max([oil.bulk_temperature, *bulks]) + _PRIOR_MEDIAN
    evidence = evidence_of(case, specimen, replace(oil, critical_temperature=start))
    if not evidence.specimens:
        reason = "; ".join(row.reason for row in evidence.without_result[:1]) or "it has none"
        raise InputError(
            f"scene {case.sweep.name}: the critical temperature is from tests, and no test has a "
            f"result ({reason})"
        )
    at_least, at_most = _bounds(evidence, start, bulk)
    median_excess, log_spread = _median_excess(evidence, start, bulk)
    temperature = start
    if bulk + median_excess > max(bulks):
        temperature = bulk + median_excess
        evidence = evidence_of(case, specimen, replace(oil, critical_temperature=temperature))
    nodes = update(evidence.outcomes, Prior(1.0, evidence.prior.scatter))
    if any(test_bulk != bulk for _, test_bulk in _outcomes_and_bulks(evidence)):
        nodes = _reweighted_nodes(nodes, evidence, bulk, max(log_spread, _MIN_WIDTH))
    logs, joint_weights = _joint(nodes, evidence, bulk, temperature)
    nodes = replace(nodes, weights=joint_weights.sum(axis=1))
    spread = median_excess * log_spread
    critical = CriticalTemperature(
        temperature, spread, at_least, at_most, bulk, nodes, logs, joint_weights
    )
    return replace(evidence, critical=critical)


def _outcomes_and_bulks(evidence: Evidence) -> list[tuple[Outcome, float]]:
    """Outcome of each specimen, and its bulk temperature [K]."""
    bulks = (rows[0].test.case.conditions.bulk_temperature for rows in evidence.specimens)
    return [*zip(evidence.outcomes, bulks, strict=True)]


def _log_likelihood(evidence: Evidence, start: float, temperatures: Array, biases: Array) -> Array:
    """ln(likelihood) at each critical temperature and bias, integrated over the scatter.

    The tests of `evidence` have their y at the critical temperature `start`.
    """
    v = np.linspace(math.log(0.05 * evidence.prior.scatter), math.log(50), _SCATTERS)
    weights = log_prior_scatter(v, evidence.prior)
    logs = np.zeros((len(temperatures), len(biases), len(v)))
    for outcome, bulk in _outcomes_and_bulks(evidence):
        change = _change_of_y(start, temperatures, bulk)
        logs += outcome.log_likelihood((change[:, None] + biases)[..., None], np.exp(v))
    return np.asarray(logsumexp(logs + weights - logsumexp(weights), axis=2))


def _median_excess(evidence: Evidence, start: float, bulk: float) -> tuple[float, float]:
    """Median of Tc − bulk temperature [K] without a bias, and standard deviation of its ln."""
    temperatures = bulk + _PRIOR_MEDIAN * np.exp(_NODES)
    logs = _log_likelihood(evidence, start, temperatures, np.zeros(1))[:, 0]
    weights = np.exp(
        logs - (PRIOR_WEIGHT + 1) / 2 * np.log1p(_NODES**2 / PRIOR_WEIGHT) - logs.max()
    )
    weights /= weights.sum()
    median = float(np.interp(0.5, np.cumsum(weights) - weights / 2, _NODES))
    variance = float(weights @ (_NODES - weights @ _NODES) ** 2)
    return _PRIOR_MEDIAN * math.exp(median), math.sqrt(variance)


def _bounds(evidence: Evidence, start: float, bulk: float) -> tuple[float, float]:
    """Bounds [K] by tests of a single outcome, on any rig; NaN for no bound."""
    has_mild = evidence.has_outcome("mild")
    if has_mild == evidence.has_outcome("severe"):
        return math.nan, math.nan
    excesses = _PRIOR_MEDIAN * np.exp(nodes := _NODES[::8])
    biases, log_prior = _biases(evidence.prior)
    logs = _log_likelihood(evidence, start, bulk + excesses, biases)
    likelihood = np.exp(logs + log_prior).sum(axis=1)
    ratio = likelihood / likelihood.max()
    if has_mild:  # the likelihood increases with Tc
        return bulk + _PRIOR_MEDIAN * math.exp(np.interp(_BOUND, ratio, nodes)), math.nan
    return math.nan, bulk + _PRIOR_MEDIAN * math.exp(np.interp(_BOUND, ratio[::-1], nodes[::-1]))


def _biases(prior: Prior) -> tuple[Array, Array]:
    """Nodes of the bias, and ln(weights)."""
    u = np.linspace(-_FARTHEST, _FARTHEST, _BIASES)
    bias = max(prior.bias, LEAST_BIAS) * np.sinh(u)
    return bias, np.log(np.cosh(u)) - (PRIOR_WEIGHT + 1) / 2 * np.log1p(
        np.sinh(u) ** 2 / PRIOR_WEIGHT
    )


def _reweighted_nodes(nodes: Posterior, evidence: Evidence, bulk: float, width: float) -> Posterior:
    """Nodes weighted by tests at the scene's bulk temperature, dense within a `width`."""
    prior = evidence.prior
    v = np.linspace(math.log(0.1 * prior.scatter), math.log(_MAX_CHANGE), _GRID_SCATTERS)
    reach = math.asinh(_MAX_CHANGE / (_GRID_SCALE * width))
    u = np.linspace(-reach, reach, _GRID_BIASES)[:, None]
    bias, scatter = _GRID_SCALE * width * np.sinh(u), np.exp(v)
    logs = np.log(np.cosh(u)) - (PRIOR_WEIGHT + 1) / 2 * np.log1p(bias**2 / PRIOR_WEIGHT)
    logs = logs + log_prior_scatter(v, prior)
    for outcome, test_bulk in _outcomes_and_bulks(evidence):
        if test_bulk == bulk:
            logs += outcome.log_likelihood(bias, scatter)
    weights = np.exp(logs - logs.max())
    is_kept = weights > _NEGLIGIBLE_PAIR * weights.sum()
    bias, scatter = (np.broadcast_to(array, is_kept.shape)[is_kept] for array in (bias, scatter))
    return replace(nodes, bias=bias, scatter=scatter, weights=weights[is_kept])


def _joint(
    nodes: Posterior, evidence: Evidence, bulk: float, temperature: float
) -> tuple[Array, Array]:
    """ln((Tc − bulk)/(temperature − bulk)) by node and bias, and the weights of both.

    The change of y at a node is the sum of the bias and of the change by the critical temperature.
    The prior of the sum, with which `nodes` were computed, is replaced by the priors of both. If
    tests have other bulk temperatures, `nodes` contain only the tests at that of the scene.
    """
    biases, log_prior = _biases(evidence.prior)
    logs = biases - nodes.bias[:, None]
    log_prior_sum = -(PRIOR_WEIGHT + 1) / 2 * np.log1p(nodes.bias**2 / PRIOR_WEIGHT)
    u = logs + math.log((temperature - bulk) / _PRIOR_MEDIAN)
    joint = (
        log_prior - (PRIOR_WEIGHT + 1) / 2 * np.log1p(u**2 / PRIOR_WEIGHT) - log_prior_sum[:, None]
    )
    temperatures = bulk + (temperature - bulk) * np.exp(logs)
    for outcome, test_bulk in _outcomes_and_bulks(evidence):
        if test_bulk != bulk:
            total_bias = _change_of_y(temperature, temperatures, test_bulk) + biases
            joint += outcome.log_likelihood(total_bias, nodes.scatter[:, None])
    joint += np.log(nodes.weights)[:, None]
    weights = np.exp(joint - joint.max())
    return logs, weights / weights.sum()
