"""What tests say of places: one likelihood, in which the result of a specimen is an interval.

A place is severe where y + b + s e > 0. y = ln(rise/limit) is computed. b is the model's bias,
which all specimens share: Student's t with 4 degrees. e is each specimen's own, standard normal;
its scale s has a prior that is worth 4 results (scaled inverse χ²). Both have the same heavy tail,
so that a surprise is shared between them at every distance.

All is a sum over a grid of bias and scatter. Its panels are halved until no factor changes much
within one; then each has five nodes of Gauss and Legendre.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from pipeline.answers.pchip import Pchip, roots
from pipeline.constants import WORTH
from tribo.types import Array

NARROW = 1e-3
"""Width of an interval in y below which it is a transition at one place."""
_FAR = 0.3  # |y| of a test from which P is computed at nodes around it, too
_SCATTERS = 100  # nodes of ln(scatter), evenly spaced
_FARTHEST = 60.0  # |y| of a level, and largest bias
_MOST_CHANGE = 1.5  # of the logarithm of the posterior within a panel that counts
_COUNTS = 25.0  # of the logarithm below its largest value
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_MOST_HALVINGS = 40
LEAST_BIAS = 1e-5
"""Scale of the bias in place of 0."""
_NEGLIGIBLE = 3e-6  # weight of nodes, all together, that are left out
_TABLE = np.sinh(np.linspace(-7.8, 7.8, 301)) * 0.05  # y at which P is computed, to ±61


@dataclass(frozen=True, slots=True)
class Prior:
    """How far the model may be off before any test, as parts of the rise.

    `bias` is shared by all specimens, and `scatter` is each specimen's own.
    """

    bias: float = 0.15
    scatter: float = 0.055


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of one specimen: severe at `severe`, mild at `mild`, both values of y.

    Infinity where it says nothing: only severe, or only mild. Both the same at a transition; a
    specimen that contradicts itself, mild where y is higher, counts as one halfway.
    """

    severe: float = math.inf
    mild: float = -math.inf

    def log_likelihood(self, bias: Array, scatter: Array) -> Array:
        """ln(probability of the result), at each bias and scatter."""
        if self.severe - self.mild < NARROW:
            variance = scatter**2 + (self.severe - self.mild) ** 2 / 12
            off = bias + (self.severe + self.mild) / 2
            return np.asarray(-0.5 * (off**2 / variance + np.log(2 * np.pi * variance)))
        low, high = (-self.severe - bias) / scatter, (-self.mild - bias) / scatter
        if math.isinf(self.mild):
            return np.asarray(log_ndtr(-low))
        if math.isinf(self.severe):
            return np.asarray(log_ndtr(high))
        swap = low > 0  # in the upper tail both are mirrored, so that a difference keeps its digits
        top, bottom = np.where(swap, -low, high), np.where(swap, -high, low)
        gap = np.minimum(log_ndtr(bottom) - log_ndtr(top), -1e-300)
        return np.asarray(log_ndtr(top) + np.log(-np.expm1(gap)))


@dataclass(frozen=True, eq=False)
class Posterior:
    """Bias and scatter after the tests: nodes with weights that add up to 1."""

    bias: Array
    scatter: Array
    weights: Array
    #: Probability of each result by the others: of its outcome, or twice the smaller tail.
    expected: tuple[float, ...] = ()
    table: Array = field(default_factory=_TABLE.copy)  #: y at which P is computed.

    @functools.cached_property
    def _probit(self) -> Pchip:
        """Probit of P over y, which is nearly straight."""
        found = [
            ndtr((y[:, None] + self.bias) / self.scatter) @ self.weights
            for y in np.array_split(self.table, 40)
        ]
        probits = ndtri(np.clip(np.concatenate(found), 1e-300, 1 - 1e-16))
        return Pchip(self.table, probits[:, None])

    def probit(self, y: Array) -> Array:
        """Probit of the probability that a place is severe, at each of `y`."""
        at = np.clip(np.nan_to_num(y), self.table[0], self.table[-1])
        return np.where(np.isnan(y), np.nan, self._probit.at(at, np.zeros(at.shape, int)))

    def probability(self, y: Array) -> Array:
        """Probability that a place is severe, at each of `y`."""
        return np.asarray(ndtr(self.probit(y)))

    def level(self, probability: float) -> float:
        """The y at which a place is severe with this probability."""
        aim, found = ndtri(probability), self._probit.y[:, 0]
        i = int(np.clip(np.searchsorted(found, aim), 1, len(found) - 1))
        ends = (self.table[i - 1 : i], self.table[i : i + 1])
        return float(roots(lambda y: self.probit(y) - aim, *ends)[0])


def log_prior_scatter(v: Array, prior: Prior) -> Array:
    """ln(density) of v = ln(scatter) before any test."""
    return np.asarray(-WORTH * v - WORTH * prior.scatter**2 / (2 * np.exp(2 * v)))


@functools.lru_cache(maxsize=64)
def update(results: tuple[Outcome, ...], prior: Prior) -> Posterior:
    """Update the prior by the results of tests, one for each specimen."""
    v = np.linspace(
        math.log(0.05 * prior.scatter), math.log(max(50.0, 10 * prior.scatter)), _SCATTERS
    )
    scatter, log_scatter = np.exp(v), log_prior_scatter(v, prior)

    def log_prior(bias: Array) -> Array:
        t = bias[:, None] / max(prior.bias, LEAST_BIAS)
        return -(WORTH + 1) / 2 * np.log1p(t**2 / WORTH) + log_scatter

    def log_likelihoods(bias: Array) -> list[Array]:
        return [one.log_likelihood(bias[:, None], scatter) for one in results]

    edges = np.sinh(np.linspace(-8, 8, 65)) * 0.05
    own = [-y for one in results for y in (one.severe, one.mild) if math.isfinite(y)]
    edges = np.unique(np.clip([*edges, *own], -_FARTHEST, _FARTHEST))
    logs = sum(log_likelihoods(edges), start=log_prior(edges))
    for _ in range(_MOST_HALVINGS):
        counts = logs > logs.max() - _COUNTS
        steep = np.abs(np.diff(logs, axis=0)) > _MOST_CHANGE
        split = (steep & (counts[1:] | counts[:-1])).any(axis=1) & (np.diff(edges) > 1e-7)
        if not split.any():
            break
        middle = (edges[1:] + edges[:-1])[split] / 2
        new, places = (
            sum(log_likelihoods(middle), start=log_prior(middle)),
            np.flatnonzero(split) + 1,
        )
        edges, logs = np.insert(edges, places, middle), np.insert(logs, places, new, axis=0)
    half = np.diff(edges)[:, None] / 2
    bias = (edges[:-1, None] + half * (1 + _NODES)).ravel()
    shares = log_likelihoods(bias)
    whole = sum(shares, start=log_prior(bias) + np.log(half * _WEIGHTS).reshape(-1, 1))
    weights = np.exp(whole - whole.max())
    weights /= weights.sum()
    expected = tuple(
        _expected(one, whole - share, bias[:, None], scatter)
        for one, share in zip(results, shares, strict=True)
    )
    flat = weights.ravel()
    order = np.argsort(flat)
    keep = np.sort(order[np.searchsorted(np.cumsum(flat[order]), _NEGLIGIBLE) :])
    i, j = np.unravel_index(keep, weights.shape)
    far = {round(y, 1) for y in np.clip(own, -_FARTHEST, _FARTHEST) if abs(y) > _FAR}
    table = np.unique(np.concatenate([_TABLE, *(_TABLE[100:-100:2] - y for y in sorted(far))]))
    return Posterior(bias[i], scatter[j], flat[keep] / flat[keep].sum(), expected, table)


def _expected(result: Outcome, others: Array, bias: Array, scatter: Array) -> float:
    """Probability of a result by the others, whose ln(weight) is `others` (bias, scatter)."""
    weights = np.exp(others - others.max())
    weights /= weights.sum()
    severe = float((weights * ndtr((result.severe + bias) / scatter)).sum())
    mild = float((weights * ndtr(-(result.mild + bias) / scatter)).sum())
    if math.isinf(result.mild):
        return severe
    return mild if math.isinf(result.severe) else min(1.0, 2 * min(severe, mild))
