"""Critical temperature Tc of the lubricant, inferred from tests.

The prior of ln(Tc − bulk temperature) is Student's t with 4 degrees of freedom and a scale of 1,
about 120 K above the bulk temperature. At each Tc the y of every test is computed at the bulk
temperature of this test, so the result does not depend on an initial guess. On the same rig Tc
contains the model's bias; on another rig the bias is added.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Unpack

import numpy as np
import xarray as xr
from scipy.special import logsumexp

from pipeline.answers.condition_values import ConditionValues, override_conditions
from pipeline.answers.evidence import Evidence, evidence_of, outcome_of
from pipeline.answers.posterior import (
    LEAST_BIAS,
    MAX_CHANGE,
    NEGLIGIBLE_PAIR,
    CriticalTemperature,
    Outcome,
    Posterior,
    Prior,
    change_of_y,
    log_prior_scatter,
    update,
)
from pipeline.answers.results import CaseResults, cases_of
from pipeline.answers.scene_wording import model_words
from pipeline.answers.specimen import Specimen, specimen_of
from pipeline.constants import WORTH
from pipeline.store.place import PathLike
from pipeline.sweep.condition_entries import Conditions
from tribo import InputError
from tribo.types import Array

_PRIOR_MEDIAN = 120.0  # of Tc − bulk temperature [K]
_NODES = np.linspace(-4, 4, 801)  # of ln((Tc − bulk)/120 K)
_SCATTERS, _BIASES, _FARTHEST = 100, 101, 7.0  # nodes; sinh(7) scales of the bias are 550
_BOUND = 0.05  # likelihood over its maximum, at the bound by tests of a single outcome
_GRID_BIASES, _GRID_SCATTERS = 241, 50  # nodes
_GRID_SCALE = 6.0  # scale of the biases over a width; they are 0.3 widths apart in the middle
_MIN_WIDTH = 0.01  # smallest width of these nodes


def critical_temperature_of(
    case: CaseResults, specimen: Specimen, oil: Conditions
) -> tuple[CriticalTemperature, Evidence]:
    """Infer Tc from the tests of a case; also return the tests with their y at this Tc.

    `oil` has all conditions but the critical temperature.
    """
    bulk = case.sweep.conditions.bulk_temperature
    bulks = [test.case.conditions.bulk_temperature for test in case.sweep.tests]
    start = max([bulk, oil.bulk_temperature, *bulks]) + _PRIOR_MEDIAN
    evidence = evidence_of(case, specimen, replace(oil, critical_temperature=start))
    if not evidence.specimens:
        reason = "; ".join(row.reason for row in evidence.without_result[:1]) or "it has none"
        raise InputError(
            f"scene {case.sweep.name}: no test has a result, and the critical temperature is to be "
            f"found from tests ({reason})"
        )
    prior, outcomes = evidence.prior, _TestOutcomes(evidence, start)
    temperatures = bulk + _PRIOR_MEDIAN * np.exp(_NODES)
    logs = outcomes.log_likelihood(temperatures, np.zeros(1), prior)[:, 0]
    weights = np.exp(logs - (WORTH + 1) / 2 * np.log1p(_NODES**2 / WORTH) - logs.max())
    weights /= weights.sum()
    median = float(np.interp(0.5, np.cumsum(weights) - weights / 2, _NODES))
    spread = math.sqrt(float(weights @ (_NODES - weights @ _NODES) ** 2))
    median_excess = _PRIOR_MEDIAN * math.exp(median)
    final_evidence = (
        evidence_of(case, specimen, replace(oil, critical_temperature=bulk + median_excess))
        if bulk + median_excess > max([bulk, *bulks])
        else evidence
    )
    temperature = bulk + median_excess if final_evidence is not evidence else start
    at_least, at_most = _bounds(outcomes, bulk, prior)
    outcomes = _TestOutcomes(final_evidence, temperature)
    nodes = update(tuple(outcome for outcome, _ in outcomes.pairs), Prior(1.0, prior.scatter))
    if any(test_bulk != bulk for _, test_bulk in outcomes.pairs):
        nodes = _reweighted_nodes(nodes, outcomes, bulk, max(spread, _MIN_WIDTH), prior)
    logs, joint_weights = _joint(nodes, outcomes, bulk, temperature, prior)
    critical = CriticalTemperature(
        temperature, median_excess * spread, at_least, at_most, bulk,
        replace(nodes, weights=joint_weights.sum(axis=1)), logs, joint_weights,
    )  # fmt: skip
    return critical, replace(final_evidence, critical=critical)


class _TestOutcomes:
    """Outcomes of specimens with y at a critical temperature `start`, and bulk temperatures."""

    def __init__(self, evidence: Evidence, start: float) -> None:
        self.start = start
        self.pairs: list[tuple[Outcome, float]] = [
            (outcome_of(rows), rows[0].test.case.conditions.bulk_temperature)
            for rows in evidence.specimens
        ]

    def has_outcome(self, name: str) -> bool:
        """True if a specimen was mild, or severe, by `name`."""
        return any(math.isfinite(getattr(outcome, name)) for outcome, _ in self.pairs)

    def log_likelihood(self, temperatures: Array, biases: Array, prior: Prior) -> Array:
        """ln(likelihood) at each critical temperature and bias, integrated over the scatter."""
        v = np.linspace(math.log(0.05 * prior.scatter), math.log(50), _SCATTERS)
        weights = log_prior_scatter(v, prior)
        logs = np.zeros((len(temperatures), len(biases), len(v)))
        for outcome, bulk in self.pairs:
            change = change_of_y(self.start, temperatures, bulk)
            logs += outcome.log_likelihood((change[:, None] + biases)[..., None], np.exp(v))
        return np.asarray(logsumexp(logs + weights - logsumexp(weights), axis=2))


def _bounds(outcomes: _TestOutcomes, bulk: float, prior: Prior) -> tuple[float, float]:
    """Bounds [K] by tests of a single outcome, on any rig; NaN for no bound."""
    nodes = _NODES[::8]
    biases, log_prior = _biases(prior)
    logs = outcomes.log_likelihood(bulk + _PRIOR_MEDIAN * np.exp(nodes), biases, prior)
    likelihood = np.exp(logs + log_prior).sum(axis=1)
    ratio = likelihood / likelihood.max()
    has_mild, has_severe = outcomes.has_outcome("mild"), outcomes.has_outcome("severe")
    if has_mild == has_severe:
        return math.nan, math.nan
    if has_mild:  # the likelihood increases with Tc
        return bulk + _PRIOR_MEDIAN * math.exp(np.interp(_BOUND, ratio, nodes)), math.nan
    return math.nan, bulk + _PRIOR_MEDIAN * math.exp(np.interp(_BOUND, ratio[::-1], nodes[::-1]))


def _biases(prior: Prior) -> tuple[Array, Array]:
    """Nodes of the bias, and ln(weights)."""
    u = np.linspace(-_FARTHEST, _FARTHEST, _BIASES)
    bias = max(prior.bias, LEAST_BIAS) * np.sinh(u)
    return bias, np.log(np.cosh(u)) - (WORTH + 1) / 2 * np.log1p(np.sinh(u) ** 2 / WORTH)


def _reweighted_nodes(
    nodes: Posterior, outcomes: _TestOutcomes, bulk: float, width: float, prior: Prior
) -> Posterior:
    """Nodes weighted by tests at the scene's bulk temperature, dense within a `width`."""
    v = np.linspace(math.log(0.1 * prior.scatter), math.log(MAX_CHANGE), _GRID_SCATTERS)
    reach = math.asinh(MAX_CHANGE / (_GRID_SCALE * width))
    u = np.linspace(-reach, reach, _GRID_BIASES)[:, None]
    bias, scatter = _GRID_SCALE * width * np.sinh(u), np.exp(v)
    logs = np.log(np.cosh(u)) - (WORTH + 1) / 2 * np.log1p(bias**2 / WORTH)
    logs = logs + log_prior_scatter(v, prior)
    for outcome, test_bulk in outcomes.pairs:
        if test_bulk == bulk:
            logs += outcome.log_likelihood(bias, scatter)
    weights = np.exp(logs - logs.max())
    is_kept = weights > NEGLIGIBLE_PAIR * weights.sum()
    bias, scatter = (np.broadcast_to(array, is_kept.shape)[is_kept] for array in (bias, scatter))
    return replace(nodes, bias=bias, scatter=scatter, weights=weights[is_kept])


def _joint(
    nodes: Posterior, outcomes: _TestOutcomes, bulk: float, temperature: float, prior: Prior
) -> tuple[Array, Array]:
    """ln((Tc − bulk)/(temperature − bulk)) by node and bias, and the weights of both.

    The change of y at a node is the sum of the bias and of the change by the critical temperature.
    The prior of the sum, with which `nodes` were computed, is replaced by the priors of both. If
    tests have other bulk temperatures, `nodes` contain only the tests at that of the scene.
    """
    biases, log_prior = _biases(prior)
    logs = biases - nodes.bias[:, None]
    log_prior_sum = -(WORTH + 1) / 2 * np.log1p(nodes.bias**2 / WORTH)
    u = logs + math.log((temperature - bulk) / _PRIOR_MEDIAN)
    joint = log_prior - (WORTH + 1) / 2 * np.log1p(u**2 / WORTH) - log_prior_sum[:, None]
    temperatures = bulk + (temperature - bulk) * np.exp(logs)
    for outcome, test_bulk in outcomes.pairs:
        if test_bulk != bulk:
            total_bias = change_of_y(temperature, temperatures, test_bulk) + biases
            joint += outcome.log_likelihood(total_bias, nodes.scatter[:, None])
    joint += np.log(nodes.weights)[:, None]
    weights = np.exp(joint - joint.max())
    return logs, weights / weights.sum()


@np.errstate(under="ignore")
def infer(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Find the critical temperature of the lubricant from the tests of a scene.

    The prior of ln(critical − bulk temperature) is Student's t with 4 degrees of freedom and a
    scale of 1, about 120 K above the bulk temperature. A critical temperature in the scene is
    ignored.

    Returns
    -------
    Dataset
        ``critical_temperature``, the median; ``spread_another_rig``, its standard deviation on
        another rig, with the model's bias in it, and ``spread_this_rig`` on this one; ``at_least``
        and ``at_most``, its bounds by only mild or only severe tests, at which the likelihood is 5
        % of its maximum. The attribute ``model`` names the surface, wear pattern and preset to
        which it belongs.

    Examples
    --------
    >>> import pipeline
    >>> oil = pipeline.infer("results/first_try.zarr")
    >>> (oil["critical_temperature"] - 273.15).round(1).item()
    141.2
    """
    case = cases_of(ds)[0]
    conditions_of_case = override_conditions(
        replace(case.sweep.conditions, critical_temperature=None), conditions
    )
    critical, _ = critical_temperature_of(
        case, specimen_of(case, conditions_of_case), conditions_of_case
    )
    values = {
        "critical_temperature": (critical.temperature, "critical temperature by the tests, median"),
        "spread_another_rig": (
            critical.spread_with_bias,
            "standard deviation on another rig (model bias included)",
        ),
        "spread_this_rig": (
            critical.spread,
            "standard deviation on this rig (model bias excluded)",
        ),
        "at_least": (critical.at_least, "lower bound, by tests that were only mild"),
        "at_most": (critical.at_most, "upper bound, by tests that were only severe"),
    }
    return xr.Dataset(
        {k: ((), value, {"units": "K", "long_name": name}) for k, (value, name) in values.items()},
        attrs={"model": model_words(case.sweep)},
    )
