"""The critical temperature of the lubricant from tests: what they say of it, and integrated over.

ln(Tc − bulk temperature) is unknown: Student's t with 4 degrees and a scale of 1 about 120 K above
the bulk. At each Tc the y of every test is taken anew with its own bulk temperature, so nothing
depends on where a search begins. On the same rig Tc contains the model's bias; on another rig the
bias is added.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np
import xarray as xr
from scipy.special import logsumexp

from pipeline.answers.conditions import ConditionValues, judged
from pipeline.answers.posterior import (
    LEAST_BIAS,
    Outcome,
    Posterior,
    Prior,
    log_prior_scatter,
    update,
)
from pipeline.answers.results import CaseResults, cases_of
from pipeline.answers.specimen import Specimen, specimen_of
from pipeline.answers.tests import Evidence, evidence_of, outcome_of
from pipeline.constants import WORTH
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import Conditions
from tribo import InputError
from tribo.types import Array

_USUAL = 120.0  # K above the bulk temperature, about which Tc is assumed
_NODES = np.linspace(-4, 4, 801)  # of ln((Tc − bulk)/120 K)
_SCATTERS, _BIASES, _FARTHEST = 100, 101, 7.0  # nodes; sinh(7) scales of the bias are 550
_SEVERE = 40.0  # change of y in place of infinity, where Tc is not above a bulk temperature
_BOUND = 0.05  # likelihood, over the largest, at the end of a range that tests of one outcome leave
_EVEN_BIASES, _EVEN_SCATTERS, _EVEN = 241, 50, 6.0  # nodes, 0.3 widths apart in the middle
_NARROWEST = 0.01  # width of these nodes
_MERGED = 0.25  # difference of biases, over the scatter, within which they are merged
_NEGLIGIBLE = 1e-11  # weight of a node and bias that is left out


@dataclass(frozen=True, eq=False)
class CriticalTemperature:
    """What tests say of the critical temperature; `temperature` is its median on this rig [K]."""

    temperature: float
    spread: float  # standard deviation on this rig [K]
    at_least: float  # bounds by tests of one outcome [K]; NaN if there are both outcomes
    at_most: float
    evidence: Evidence  # y of the tests at `temperature`
    bulk: float  # of the scene, above which Tc is assumed [K]
    nodes: Posterior  # of bias − ln((Tc − bulk)/(temperature − bulk)) and scatter
    logs: Array  # ln((Tc − bulk)/(temperature − bulk)) by node and bias
    weights: Array  # of each node and bias, which add up to 1
    _at_bulk: dict[float, Posterior] = field(default_factory=dict, repr=False)

    def at_bulk(self, bulk: float) -> Posterior:
        """Bias and scatter of points at a bulk temperature [K], whose y are at `temperature`.

        Tc moves y by another amount than at the scene's bulk temperature. Values nearer to each
        other than a part of the scatter are merged, and their variance is added to it.
        """
        if bulk == self.bulk:
            return self.nodes
        if bulk not in self._at_bulk:
            self._at_bulk[bulk] = self._moved_to(bulk)
        return self._at_bulk[bulk]

    def _moved_to(self, bulk: float) -> Posterior:
        moved = _change(self.temperature, self._temperatures, bulk) + self._biases
        counts = self.weights > _NEGLIGIBLE
        moved, weights = np.clip(moved[counts], -_SEVERE, _SEVERE), self.weights[counts]
        scatter, kind = np.unique(self.nodes.scatter, return_inverse=True)
        kind = np.broadcast_to(kind[:, None], counts.shape)[counts]
        places = np.floor(moved / (_MERGED * scatter[kind])).astype(int)
        first, count = places.min(), np.ptp(places) + 1
        which, back = np.unique(kind * count + places - first, return_inverse=True)
        weights, first_moments, second_moments = (
            np.bincount(back, weights * moved**power).astype(float) for power in range(3)
        )
        kept = weights > _NEGLIGIBLE
        weights, means = weights[kept], first_moments[kept] / weights[kept]
        variances = np.maximum(second_moments[kept] / weights - means**2, 0.0)
        own = scatter[which[kept] // count]
        return replace(
            self.nodes, bias=means, scatter=np.hypot(own, np.sqrt(variances)),
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


def _change(start: float, temperatures: Array, bulk: float) -> Array:
    """Change of y at a bulk temperature, if the critical temperature changes from `start` [K]."""
    above = np.maximum(temperatures - bulk, 1e-300)
    return np.asarray(np.minimum(math.log(start - bulk) - np.log(above), _SEVERE))


def critical_temperature_of(
    case: CaseResults, specimen: Specimen, oil: Conditions
) -> CriticalTemperature:
    """What the tests of a case say; `oil` has all conditions but the critical temperature."""
    bulk = case.sweep.conditions.bulk_temperature
    bulks = [test.case.conditions.bulk_temperature for test in case.sweep.tests]
    start = max([bulk, oil.bulk_temperature, *bulks]) + _USUAL
    evidence = evidence_of(case, specimen, replace(oil, critical_temperature=start))
    if not evidence.specimens:
        why = "; ".join(row.reason for row in evidence.without_result[:1]) or "it has none"
        raise InputError(
            f"scene {case.sweep.name}: no test has a result, and the critical temperature is to be "
            f"found from tests ({why})"
        )
    prior, own = evidence.prior, _OwnBulks(evidence, start)
    temperatures = bulk + _USUAL * np.exp(_NODES)
    logs = own.log_likelihood(temperatures, np.zeros(1), prior)[:, 0]
    share = np.exp(logs - (WORTH + 1) / 2 * np.log1p(_NODES**2 / WORTH) - logs.max())
    share /= share.sum()
    middle = float(np.interp(0.5, np.cumsum(share) - share / 2, _NODES))
    spread = math.sqrt(float(share @ (_NODES - share @ _NODES) ** 2))
    above = _USUAL * math.exp(middle)
    found = evidence_of(case, specimen, replace(oil, critical_temperature=bulk + above)) if (
        bulk + above > max([bulk, *bulks])
    ) else evidence  # fmt: skip
    temperature = bulk + above if found is not evidence else start
    at_least, at_most = _bounds(own, bulk, prior)
    own = _OwnBulks(found, temperature)
    nodes = update(tuple(one for one, _ in own.results), Prior(1.0, prior.scatter))
    if any(at != bulk for _, at in own.results):
        nodes = _even(nodes, own, bulk, max(spread, _NARROWEST), prior)
    logs, weights = _joint(nodes, own, bulk, temperature, prior)
    return CriticalTemperature(
        temperature, above * spread, at_least, at_most, found, bulk,
        replace(nodes, weights=weights.sum(axis=1)), logs, weights,
    )  # fmt: skip


class _OwnBulks:
    """Results of tests at a critical temperature `start`, each with its own bulk temperature."""

    def __init__(self, evidence: Evidence, start: float) -> None:
        self.start = start
        self.results: list[tuple[Outcome, float]] = [
            (outcome_of(rows), rows[0].test.case.conditions.bulk_temperature)
            for rows in evidence.specimens
        ]

    def has(self, side: str) -> bool:
        """True if a test has a finite end on this side."""
        return any(math.isfinite(getattr(one, side)) for one, _ in self.results)

    def log_likelihood(self, temperatures: Array, biases: Array, prior: Prior) -> Array:
        """ln(likelihood) at each critical temperature and bias, over all scatters."""
        v = np.linspace(math.log(0.05 * prior.scatter), math.log(50), _SCATTERS)
        weights = log_prior_scatter(v, prior)
        logs = np.zeros((len(temperatures), len(biases), len(v)))
        for one, bulk in self.results:
            moved = _change(self.start, temperatures, bulk)
            logs += one.log_likelihood((moved[:, None] + biases)[..., None], np.exp(v))
        return np.asarray(logsumexp(logs + weights - logsumexp(weights), axis=2))


def _bounds(own: _OwnBulks, bulk: float, prior: Prior) -> tuple[float, float]:
    """Bounds [K] that tests of one outcome leave, on any rig; NaN where there is none."""
    nodes = _NODES[::8]
    biases, log_prior = _biases(prior)
    logs = own.log_likelihood(bulk + _USUAL * np.exp(nodes), biases, prior)
    whole = np.exp(logs + log_prior).sum(axis=1)
    ratio = whole / whole.max()
    mild, severe = own.has("mild"), own.has("severe")
    if mild == severe:
        return math.nan, math.nan
    if mild:  # the likelihood rises with Tc
        return bulk + _USUAL * math.exp(np.interp(_BOUND, ratio, nodes)), math.nan
    return math.nan, bulk + _USUAL * math.exp(np.interp(_BOUND, ratio[::-1], nodes[::-1]))


def _biases(prior: Prior) -> tuple[Array, Array]:
    """Nodes of the bias, and ln(weights)."""
    u = np.linspace(-_FARTHEST, _FARTHEST, _BIASES)
    bias = max(prior.bias, LEAST_BIAS) * np.sinh(u)
    return bias, np.log(np.cosh(u)) - (WORTH + 1) / 2 * np.log1p(np.sinh(u) ** 2 / WORTH)


def _even(nodes: Posterior, own: _OwnBulks, bulk: float, width: float, prior: Prior) -> Posterior:
    """Nodes with the weights by tests at the scene's bulk temperature, dense within a `width`."""
    v = np.linspace(math.log(0.1 * prior.scatter), math.log(_SEVERE), _EVEN_SCATTERS)
    reach = math.asinh(_SEVERE / (_EVEN * width))
    u = np.linspace(-reach, reach, _EVEN_BIASES)[:, None]
    bias, scatter = _EVEN * width * np.sinh(u), np.exp(v)
    logs = np.log(np.cosh(u)) - (WORTH + 1) / 2 * np.log1p(bias**2 / WORTH)
    logs = logs + log_prior_scatter(v, prior)
    for one, at in own.results:
        if at == bulk:
            logs += one.log_likelihood(bias, scatter)
    weights = np.exp(logs - logs.max())
    kept = weights > _NEGLIGIBLE * weights.sum()
    bias, scatter = (np.broadcast_to(one, kept.shape)[kept] for one in (bias, scatter))
    return replace(nodes, bias=bias, scatter=scatter, weights=weights[kept])


def _joint(
    nodes: Posterior, own: _OwnBulks, bulk: float, temperature: float, prior: Prior
) -> tuple[Array, Array]:
    """ln((Tc − bulk)/(temperature − bulk)) by node and bias, and the weights of both.

    The bias is a part of what a node moves y by; the critical temperature is the rest. `nodes`
    were made with a prior of the whole, in whose place both priors come, and by tests at the
    scene's bulk temperature alone, if there are others.
    """
    biases, log_prior = _biases(prior)
    logs = biases - nodes.bias[:, None]
    whole = -(WORTH + 1) / 2 * np.log1p(nodes.bias**2 / WORTH)
    u = logs + math.log((temperature - bulk) / _USUAL)
    joint = log_prior - (WORTH + 1) / 2 * np.log1p(u**2 / WORTH) - whole[:, None]
    temperatures = bulk + (temperature - bulk) * np.exp(logs)
    for one, at in own.results:
        if at != bulk:
            moved = _change(temperature, temperatures, at) + biases
            joint += one.log_likelihood(moved, nodes.scatter[:, None])
    joint += np.log(nodes.weights)[:, None]
    weights = np.exp(joint - joint.max())
    return logs, weights / weights.sum()


@np.errstate(under="ignore")
def infer(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Find the critical temperature of the lubricant from the tests of a scene.

    Before the tests ln(critical − bulk temperature) is Student's t with 4 degrees and a scale of 1,
    about 120 K above the bulk temperature. A critical temperature in the scene changes nothing.

    Returns
    -------
    Dataset
        ``critical_temperature``, the median; ``spread_another_rig``, its standard deviation on
        another rig, with the model's bias in it, and ``spread_this_rig`` on this one; ``at_least``
        and ``at_most``, where only mild or only severe tests bound it: there their likelihood is 5
        % of its largest value.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.infer("results/first_try.zarr")
    >>> (found["critical_temperature"] - 273.15).round(1).item()
    139.8
    """
    case = cases_of(ds)[0]
    own = judged(replace(case.sweep.conditions, critical_temperature=None), conditions)
    found = critical_temperature_of(case, specimen_of(case, own), own)
    values = {
        "critical_temperature": (found.temperature, "critical temperature by the tests, median"),
        "spread_another_rig": (
            found.spread_with_bias,
            "standard deviation on another rig (model bias included)",
        ),
        "spread_this_rig": (found.spread, "standard deviation on this rig (model bias excluded)"),
        "at_least": (found.at_least, "lower bound by mild tests alone"),
        "at_most": (found.at_most, "upper bound by severe tests alone"),
    }
    return xr.Dataset(
        {k: ((), value, {"units": "K", "long_name": name}) for k, (value, name) in values.items()}
    )
