"""Probability of severe wear from tests: the result of each specimen is an interval of y.

Wear is severe at a point if y + b + s e > 0. y = ln(rise/allowable rise) is computed. b is the
model's bias, common to all specimens: Student's t with 4 degrees of freedom. e is standard normal
for each specimen; its scale, the scatter s, has a prior with the weight of 4 results (scaled
inverse χ²). Both have the same heavy tail, so that an outlier is shared between them at any
distance.

Probabilities are sums over a grid of bias and scatter. Its panels are halved until no factor
changes much within a panel; then each has five nodes of Gauss and Legendre.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from pipeline.answers.pchip import Pchip, roots
from pipeline.constants import PRIOR_WEIGHT
from tribo.types import Array

NARROW = 1e-3
"""Width of an interval in y below which it is a transition at a point."""
_DISTANT_Y = 0.3  # |y| of a test above which P is also computed at nodes around it
_SCATTERS = 100  # nodes of ln(scatter), evenly spaced
_FARTHEST = 60.0  # |y| of a level, and largest bias
_MAX_LOG_CHANGE = 1.5  # of the posterior within a significant panel
_LOG_RANGE = 25.0  # ln(posterior) of significant panels, below its maximum
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_MAX_HALVINGS = 40
LEAST_BIAS = 1e-5
"""Smallest scale of the bias."""
_NEGLIGIBLE = 3e-6  # largest sum of weights of omitted nodes
_TABLE = np.sinh(np.linspace(-7.8, 7.8, 301)) * 0.05  # y at which P is computed, to ±61


@dataclass(frozen=True, slots=True)
class Prior:
    """Scales of the model error before any test, relative to the rise.

    `bias` is common to all specimens, and `scatter` is between specimens.
    """

    bias: float = 0.15
    scatter: float = 0.055


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of one specimen: severe at `severe`, mild at `mild`, both values of y.

    A value is infinite if the specimen was only severe, or only mild. Both are equal for a
    transition; if the mild y is the higher one, the transition is halfway between them.
    `added_scatter` is that of this specimen alone, such as by inputs of its own.
    """

    severe: float = math.inf
    mild: float = -math.inf
    added_scatter: float = 0.0

    def log_likelihood(self, bias: Array, scatter: Array) -> Array:
        """ln(probability of the result), at each bias and scatter."""
        scatter = np.hypot(scatter, self.added_scatter)
        if self.severe - self.mild < NARROW:
            variance = scatter**2 + (self.severe - self.mild) ** 2 / 12
            distance = bias + (self.severe + self.mild) / 2
            return np.asarray(-0.5 * (distance**2 / variance + np.log(2 * np.pi * variance)))
        low, high = (-self.severe - bias) / scatter, (-self.mild - bias) / scatter
        if math.isinf(self.mild):
            return np.asarray(log_ndtr(-low))
        if math.isinf(self.severe):
            return np.asarray(log_ndtr(high))
        is_upper_tail = low > 0  # mirror the upper tail, to avoid cancellation
        upper, lower = np.where(is_upper_tail, -low, high), np.where(is_upper_tail, -high, low)
        log_ratio = np.minimum(log_ndtr(lower) - log_ndtr(upper), -1e-300)
        return np.asarray(log_ndtr(upper) + np.log(-np.expm1(log_ratio)))


@dataclass(frozen=True, eq=False)
class Posterior:
    """Bias and scatter after the tests: nodes with weights whose sum is 1."""

    bias: Array
    scatter: Array
    weights: Array
    #: Leave-one-out probability of each result: of its outcome, or twice the smaller tail.
    loo_probabilities: tuple[float, ...] = ()
    table: Array = field(default_factory=_TABLE.copy)  #: y at which P is computed.

    @functools.cached_property
    def _probit(self) -> Pchip:
        """Probit of P over y, which is nearly straight."""
        probabilities = [
            ndtr((y[:, None] + self.bias) / self.scatter) @ self.weights
            for y in np.array_split(self.table, 40)
        ]
        probits = ndtri(np.clip(np.concatenate(probabilities), 1e-300, 1 - 1e-16))
        return Pchip(self.table, probits[:, None])

    def probit(self, y: Array) -> Array:
        """Probit of the probability of severe wear at each of `y`."""
        clipped = np.clip(np.nan_to_num(y), self.table[0], self.table[-1])
        return np.where(np.isnan(y), np.nan, self._probit.at(clipped, np.zeros(clipped.shape, int)))

    def probability(self, y: Array) -> Array:
        """Probability of severe wear at each of `y`."""
        return np.asarray(ndtr(self.probit(y)))

    def level(self, probability: float) -> float:
        """The y at which severe wear has this probability."""
        target, probits = ndtri(probability), self._probit.y[:, 0]
        i = int(np.clip(np.searchsorted(probits, target), 1, len(probits) - 1))
        bracket = (self.table[i - 1 : i], self.table[i : i + 1])
        return float(roots(lambda y: self.probit(y) - target, *bracket)[0])


def log_prior_scatter(v: Array, prior: Prior) -> Array:
    """ln(density) of v = ln(scatter) before any test."""
    return np.asarray(-PRIOR_WEIGHT * v - PRIOR_WEIGHT * prior.scatter**2 / (2 * np.exp(2 * v)))


@functools.lru_cache(maxsize=64)
def update(results: tuple[Outcome, ...], prior: Prior) -> Posterior:
    """Update the prior by the results of tests, one for each specimen."""
    top = math.log(max(50.0, 10 * prior.scatter))
    v = np.linspace(math.log(0.05 * prior.scatter), top, _SCATTERS)
    test_biases = [
        -y for result in results for y in (result.severe, result.mild) if math.isfinite(y)
    ]
    edges = _panel_edges(results, prior, v, test_biases)
    half = np.diff(edges)[:, None] / 2
    bias, scatter = (edges[:-1, None] + half * (1 + _NODES)).ravel(), np.exp(v)
    log_likelihoods = [result.log_likelihood(bias[:, None], scatter) for result in results]
    log_weights = np.log(half * _WEIGHTS).reshape(-1, 1)
    log_posterior = sum(log_likelihoods, start=_log_prior(bias, v, prior) + log_weights)
    weights = np.exp(log_posterior - log_posterior.max())
    weights /= weights.sum()
    loo_probabilities = tuple(
        _loo_probability(result, log_posterior - log_likelihood, bias[:, None], scatter)
        for result, log_likelihood in zip(results, log_likelihoods, strict=True)
    )
    flat_weights = weights.ravel()
    order = np.argsort(flat_weights)
    significant = np.sort(order[np.searchsorted(np.cumsum(flat_weights[order]), _NEGLIGIBLE) :])
    i, j = np.unravel_index(significant, weights.shape)
    weights = flat_weights[significant] / flat_weights[significant].sum()
    return Posterior(bias[i], scatter[j], weights, loo_probabilities, _table_near(test_biases))


def _panel_edges(
    results: tuple[Outcome, ...], prior: Prior, v: Array, test_biases: list[float]
) -> Array:
    """Edges of panels of the bias, halved until the posterior changes little within each."""
    edges = np.sinh(np.linspace(-8, 8, 65)) * 0.05
    edges = np.unique(np.clip([*edges, *test_biases], -_FARTHEST, _FARTHEST))
    logs = _log_posterior(edges, results, prior, v)
    for _ in range(_MAX_HALVINGS):
        is_significant = logs > logs.max() - _LOG_RANGE
        is_steep = np.abs(np.diff(logs, axis=0)) > _MAX_LOG_CHANGE
        is_split = (is_steep & (is_significant[1:] | is_significant[:-1])).any(axis=1)
        is_split &= np.diff(edges) > 1e-7
        if not is_split.any():
            break
        middle = (edges[1:] + edges[:-1])[is_split] / 2
        positions = np.flatnonzero(is_split) + 1
        edges = np.insert(edges, positions, middle)
        middle_logs = _log_posterior(middle, results, prior, v)
        logs = np.insert(logs, positions, middle_logs, axis=0)
    return edges


def _log_posterior(bias: Array, results: tuple[Outcome, ...], prior: Prior, v: Array) -> Array:
    """ln(posterior), up to a constant, at each bias and each v = ln(scatter)."""
    scatter = np.exp(v)
    log_likelihoods = (result.log_likelihood(bias[:, None], scatter) for result in results)
    return sum(log_likelihoods, start=_log_prior(bias, v, prior))


def _log_prior(bias: Array, v: Array, prior: Prior) -> Array:
    """ln(prior), up to a constant, at each bias and each v = ln(scatter)."""
    t = bias[:, None] / max(prior.bias, LEAST_BIAS)
    return np.asarray(
        -(PRIOR_WEIGHT + 1) / 2 * np.log1p(t**2 / PRIOR_WEIGHT) + log_prior_scatter(v, prior)
    )


def _table_near(test_biases: list[float]) -> Array:
    """The y at which P is computed, dense also near those of distant tests."""
    distant_biases = {
        round(y, 1) for y in np.clip(test_biases, -_FARTHEST, _FARTHEST) if abs(y) > _DISTANT_Y
    }
    near_tests = (_TABLE[100:-100:2] - y for y in sorted(distant_biases))
    return np.unique(np.concatenate([_TABLE, *near_tests]))


def _loo_probability(result: Outcome, log_weights: Array, bias: Array, scatter: Array) -> float:
    """Leave-one-out probability of a result.

    `log_weights` (bias, scatter) are those without this result.
    """
    weights = np.exp(log_weights - log_weights.max())
    weights /= weights.sum()
    scatter = np.hypot(scatter, result.added_scatter)
    severe = float((weights * ndtr((result.severe + bias) / scatter)).sum())
    mild = float((weights * ndtr(-(result.mild + bias) / scatter)).sum())
    if math.isinf(result.mild):
        return severe
    return mild if math.isinf(result.severe) else min(1.0, 2 * min(severe, mild))
