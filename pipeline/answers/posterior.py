"""Probability of severe wear from tests: the result of each specimen is an interval of y.

Wear is severe at a point if y + b + c + s e > 0. y = ln(rise/allowable rise) is computed. b is the
model's bias, common to all specimens: Student's t with 4 degrees of freedom. c is 0 if the critical
temperature Tc is known; if it is inferred, c is the change of y from the Tc of the computation to
another one. e is standard normal for each specimen; its scale, the scatter s, has a prior with the
weight of 4 results (scaled inverse χ²). b and s have the same heavy tail, so that an outlier is
shared between them at any distance.

Probabilities are sums over a grid of b + c, b and s. Panels of b + c are halved until no factor
changes much within a panel; then each has five nodes of Gauss and Legendre.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from pipeline.answers.pchip import Pchip, roots
from pipeline.constants import PRIOR_WEIGHT
from tribo.types import Array, Mask

NARROW = 1e-3
"""Width of an interval in y below which it is a transition at a point."""
_DISTANT_Y = 0.3  # |y| of a test above which P is also computed at nodes around it
_SCATTERS = 80  # nodes of ln(scatter), evenly spaced
_BIASES, _FARTHEST_BIAS = 101, 7.0  # nodes beside an inferred Tc; sinh(7) scales are 550
_FARTHEST = 60.0  # |y| of a level, and largest b + c
_MAX_CHANGE = 40.0  # of y by Tc, also if it is not above a bulk temperature
_MAX_LOG_CHANGE = 5.0  # of the posterior within a significant panel
_LOG_RANGE = 18.0  # ln(posterior) of significant panels, below its maximum
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_MAX_HALVINGS = 40
_LEAST_BIAS = 1e-5  # smallest scale of the bias, if Tc is known
_NEGLIGIBLE = 1e-10  # weight of omitted nodes
_BIN_WIDTH = 0.25  # difference of biases over the scatter, within which nodes are merged
_TABLE = np.sinh(np.linspace(-7.8, 7.8, 301)) * 0.05  # y at which P is computed, to ±61


@dataclass(frozen=True, slots=True)
class Prior:
    """Scales of the model error before any test, relative to the rise.

    `bias` is common to all specimens, and `scatter` is between specimens. `critical_change` is the
    change of y by the median of Tc before any test; it is None if Tc is known. The scale of this
    change is 1.
    """

    bias: float = 0.15
    scatter: float = 0.055
    critical_change: float | None = None

    @property
    def log_scatters(self) -> Array:
        """Nodes of ln(scatter)."""
        top = max(50.0, 10 * self.scatter)
        return np.linspace(math.log(0.05 * self.scatter), math.log(top), _SCATTERS)

    def divide(self, total: Array) -> tuple[Array, Array]:
        """Biases (n, m) that are parts of the total change of y (n, 1), and their ln(prior).

        The rest is the change by Tc.
        """
        if self.critical_change is None:
            return total, _log_student(total / max(self.bias, _LEAST_BIAS))
        u = np.linspace(-_FARTHEST_BIAS, _FARTHEST_BIAS, _BIASES) if self.bias else np.zeros(1)
        bias = self.bias * np.sinh(u)[None]
        log_prior = _log_student(np.sinh(u)) + np.log(np.cosh(u))
        return bias, log_prior + _log_student(total - bias - self.critical_change)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of one specimen: severe at `severe`, mild at `mild`, both values of y.

    A value is infinite if the specimen was only severe, or only mild. Both are equal for a
    transition; if the mild y is the higher one, the transition is halfway between them.
    `added_scatter` is that of this specimen alone, such as by inputs of its own. `warmth` is its
    bulk temperature above that of the scene, over the same difference of Tc.
    """

    severe: float = math.inf
    mild: float = -math.inf
    added_scatter: float = 0.0
    warmth: float = 0.0

    def log_likelihood(self, change: Array, scatter: Array) -> Array:
        """ln(probability of the result), at each change of its y and each scatter."""
        scatter = np.hypot(scatter, self.added_scatter)
        if self.severe - self.mild < NARROW:
            variance = scatter**2 + (self.severe - self.mild) ** 2 / 12
            distance = change + (self.severe + self.mild) / 2
            return np.asarray(-0.5 * (distance**2 / variance + np.log(2 * np.pi * variance)))
        low, high = (-self.severe - change) / scatter, (-self.mild - change) / scatter
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
    """Parameters after the tests: nodes with weights whose sum is 1."""

    bias: Array
    change: Array  # of y by Tc, at the scene's bulk temperature
    scatter: Array
    weights: Array
    table: Array = field(default_factory=_TABLE.copy)  #: y at which P is computed.

    def at(self, warmth: float) -> Posterior:
        """Posterior of points at another bulk temperature, see `Outcome`; its change is 0.

        Nodes with close biases and equal scatter are merged; the variance of these biases is added
        to that of the scatter.
        """
        bias = change_at(warmth, self.bias + self.change, self.bias)
        bins = np.floor(bias / (_BIN_WIDTH * self.scatter))
        _, group = np.unique(self.scatter + 1j * bins, return_inverse=True)
        weights: Array = np.bincount(group, self.weights).astype(float)
        means, squares, scatters = (
            np.bincount(group, self.weights * values) / weights
            for values in (bias, bias**2, self.scatter)
        )
        scatter = np.hypot(scatters, np.sqrt(np.maximum(squares - means**2, 0.0)))
        return replace(
            self, bias=means, change=np.zeros(means.shape), scatter=scatter, weights=weights
        )

    @functools.cached_property
    def _probit(self) -> Pchip:
        """Probit of P over y, which is nearly straight."""
        merged = self.at(0.0)
        probabilities = [
            ndtr((y[:, None] + merged.bias) / merged.scatter) @ merged.weights
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


def change_at(warmth: float, total: Array, bias: Array) -> Array:
    """Change of y at another bulk temperature if it is `total`, with `bias`, at the scene's."""
    if not warmth:
        return total
    excess = np.maximum(np.exp(bias - total) - warmth, 1e-300) / (1 - warmth)
    return np.asarray(bias + np.minimum(-np.log(excess), _MAX_CHANGE))


@functools.lru_cache(maxsize=16)
def update(results: tuple[Outcome, ...], prior: Prior) -> Posterior:
    """Update the prior by the results of tests, one for each specimen."""
    edges, v, is_significant = _panels(results, prior)
    is_panel = (is_significant[:-1] | is_significant[1:]).any(axis=(1, 2))
    v = v[is_significant.any(axis=(0, 1))]
    total, log_widths = _nodes_of(edges[:-1][is_panel], edges[1:][is_panel])
    bias, log_posterior, _ = _log_posterior(total, results, prior, v)
    log_posterior += log_widths[:, None, None]
    weights = np.exp(log_posterior - log_posterior.max())
    is_kept = weights > _NEGLIGIBLE * weights.sum()
    total, bias, scatter = (
        np.broadcast_to(array, weights.shape)[is_kept]
        for array in (total[:, None, None], bias[:, :, None], np.exp(v))
    )
    weights = weights[is_kept] / weights[is_kept].sum()
    return Posterior(bias, total - bias, scatter, weights, _table_near(results))


def density(total: Array, results: tuple[Outcome, ...], prior: Prior) -> Array:
    """Posterior density of total changes of y (n,), up to a factor."""
    logs = _log_posterior(total, results, prior, prior.log_scatters)[1]
    return np.asarray(np.exp(logs - logs.max()).sum(axis=(1, 2)))


def leave_one_out(results: tuple[Outcome, ...], prior: Prior) -> tuple[float, ...]:
    """Leave-one-out probability of each result: of its outcome, or twice the smaller tail."""
    edges, v, _ = _panels(results, prior)
    total, log_widths = _nodes_of(edges[:-1], edges[1:])
    bias, log_posterior, log_likelihoods = _log_posterior(total, results, prior, v)
    log_posterior += log_widths[:, None, None]
    probabilities = []
    for result, log_likelihood in zip(results, log_likelihoods, strict=True):
        log_weights = log_posterior - log_likelihood
        weights = np.exp(log_weights - log_weights.max())
        weights /= weights.sum()
        scatter = np.hypot(np.exp(v), result.added_scatter)
        change = change_at(result.warmth, total[:, None], bias)[..., None]
        severe = float((weights * ndtr((result.severe + change) / scatter)).sum())
        mild = float((weights * ndtr(-(result.mild + change) / scatter)).sum())
        both = min(1.0, 2 * min(severe, mild))
        probabilities.append(
            severe if math.isinf(result.mild) else mild if math.isinf(result.severe) else both
        )
    return tuple(probabilities)


def _panels(results: tuple[Outcome, ...], prior: Prior) -> tuple[Array, Array, Mask]:
    """Edges of panels of the total change, halved until the posterior changes little within each.

    Also the nodes of v = ln(scatter), and where the posterior is significant, by edge, bias and v.
    """
    v = prior.log_scatters
    edges = np.sinh(np.linspace(-8, 8, 65)) * 0.05
    edges = np.unique(np.clip([*edges, *_test_changes(results)], -_FARTHEST, _FARTHEST))
    logs = _log_posterior(edges, results, prior, v)[1]
    for _ in range(_MAX_HALVINGS):
        significant_logs = np.maximum(logs, logs.max() - _LOG_RANGE)
        is_steep = np.abs(np.diff(significant_logs, axis=0)) > _MAX_LOG_CHANGE
        is_split = is_steep.any(axis=(1, 2)) & (np.diff(edges) > 1e-7)
        if not is_split.any():
            break
        middle = (edges[1:] + edges[:-1])[is_split] / 2
        positions = np.flatnonzero(is_split) + 1
        edges = np.insert(edges, positions, middle)
        middle_logs = _log_posterior(middle, results, prior, v)[1]
        logs = np.insert(logs, positions, middle_logs, axis=0)
    return edges, v, logs > logs.max() - _LOG_RANGE


def _nodes_of(low: Array, high: Array) -> tuple[Array, Array]:
    """Nodes (n,) of panels (k,), and ln(width) of each."""
    half = (high - low)[:, None] / 2
    return (low[:, None] + half * (1 + _NODES)).ravel(), np.log(half * _WEIGHTS).ravel()


def _log_posterior(
    total: Array, results: tuple[Outcome, ...], prior: Prior, v: Array
) -> tuple[Array, Array, list[Array]]:
    """Biases (n, m) and ln(posterior) (n, m, k), up to a constant, at total changes of y (n,).

    v (k,) is ln(scatter). The list has the part of each result.
    """
    bias, log_prior = prior.divide(total[:, None])
    log_likelihoods = [
        result.log_likelihood(change_at(result.warmth, total[:, None], bias)[..., None], np.exp(v))
        for result in results
    ]
    log_prior_scatter = -PRIOR_WEIGHT * (v + prior.scatter**2 / (2 * np.exp(2 * v)))
    return bias, sum(log_likelihoods) + log_prior[..., None] + log_prior_scatter, log_likelihoods


def _log_student(x: Array) -> Array:
    """ln(density) of Student's t, up to a constant."""
    return np.asarray(-(PRIOR_WEIGHT + 1) / 2 * np.log1p(x**2 / PRIOR_WEIGHT))


def _test_changes(results: tuple[Outcome, ...]) -> list[float]:
    """Changes of y that make a test critical."""
    return [-y for result in results for y in (result.severe, result.mild) if math.isfinite(y)]


def _table_near(results: tuple[Outcome, ...]) -> Array:
    """The y at which P is computed, dense also near those of distant tests."""
    distant_changes = {
        round(y, 1)
        for y in np.clip(_test_changes(results), -_FARTHEST, _FARTHEST)
        if abs(y) > _DISTANT_Y
    }
    near_tests = (_TABLE[100:-100:2] - y for y in sorted(distant_changes))
    return np.unique(np.concatenate([_TABLE, *near_tests]))
