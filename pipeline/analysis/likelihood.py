"""What tests say of places: one likelihood, in which the result of a test is an interval.

A place is severe where y + b + e > 0. y = ln(rise/limit) is computed. b is the model's bias, which
all specimens share, and e is each specimen's own. The prior of b is Student's t with 4 degrees; the
scale of e has a prior that is worth 4 results. Both have the same heavy tail, so that a surprise is
shared between them at every distance.

The scales of b and e are integrated over their whole tails; b is found by expectation propagation
at each pair of scales (Minka 2001).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtr

from pipeline.constants import WORTH
from tribo.types import Array

NARROW = 1e-3
"""Width of an interval in y below which it counts as a Gaussian factor."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)
_SWEEPS, _SETTLED = 60, 1e-4  # most sweeps over the results, and relative change at which they stop
_NEGLIGIBLE = 1e-9  # weight of a pair of scales, beside the largest, that is left out
_FARTHEST = 60.0  # |y| within which a level is sought
_HALVINGS = 55  # which exhaust double precision
_AT_ONCE = 4_000_000  # numbers in memory at a time


@dataclass(frozen=True, slots=True)
class Prior:
    """How far the model may be off before any test, as parts of the rise.

    `bias` is shared by all specimens, and `scatter` is each specimen's own.
    """

    bias: float = 0.05
    scatter: float = 0.055


@dataclass(frozen=True, slots=True)
class SpecimenResult:
    """The result of one specimen: severe at `y`, and mild at `y` − `width`.

    A width of infinity stands for a specimen that was only severe. `sign` −1 mirrors the result:
    mild at `y` alone. A width below `NARROW` is a transition at `y`.
    """

    y: float
    sign: int = 1
    width: float = math.inf
    own: float = 0.0  #: Standard deviation of an error of this result alone.

    @property
    def is_transition(self) -> bool:
        """True if the result is a transition at one place."""
        return self.width < NARROW


@dataclass(frozen=True, eq=False)
class Belief:
    """Bias and scatter after the tests: a mixture over g pairs of scales.

    `weights` add up to 1. `mean` and `variance` (g,) are those of the bias over its scale. `bias`
    and `scatter` (g,) are the scales.
    """

    weights: Array
    mean: Array
    variance: Array
    bias: Array
    scatter: Array
    #: Probability of each result by the others, in their order: of its outcome,
    #: or twice the smaller tail of an interval.
    expected: tuple[float, ...] = ()

    def probability(self, y: Array | float) -> Array:
        """Probability that a place is severe, at each of `y`."""
        width = np.sqrt(self.scatter**2 + self.bias**2 * self.variance)
        places = np.asarray(y, float)
        found, flat = np.empty(places.size), places.reshape(-1, 1)
        step = max(1, _AT_ONCE // len(self.weights))
        for begin in range(0, len(flat), step):
            part = slice(begin, begin + step)
            found[part] = ndtr((flat[part] + self.bias * self.mean) / width) @ self.weights
        return np.where(np.isnan(places), math.nan, np.clip(found, 0.0, 1.0).reshape(places.shape))

    def level(self, probability: float) -> float:
        """The y at which a place is severe with this probability, found by halving."""
        return _halved(lambda y: float(self.probability(y)) < probability)

    def bias_below(self, share: float) -> float:
        """The quantile of the bias at a share."""
        spread = self.bias * np.sqrt(self.variance)
        at = self.bias * self.mean
        return _halved(lambda x: float(self.weights @ ndtr((x - at) / spread)) < share)

    @property
    def bias_moments(self) -> tuple[float, float]:
        """Mean and standard deviation of the bias."""
        at = self.bias * self.mean
        mean = float(self.weights @ at)
        square = float(self.weights @ (self.bias**2 * self.variance + at**2))
        return mean, math.sqrt(max(square - mean**2, 0.0))


def _halved(is_below: Callable[[float], bool]) -> float:
    low, high = -_FARTHEST, _FARTHEST
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if is_below(middle) else (low, middle)
    return (low + high) / 2


@functools.lru_cache(maxsize=64)
def condition(results: tuple[SpecimenResult, ...], prior: Prior) -> Belief:
    """Update the prior by the results of tests, one for each specimen."""
    bias, scatter, log_weight = _scales(prior)
    found = _Conditioned(results, bias, scatter)
    log_weight = log_weight + found.log_evidence
    weight = np.exp(log_weight - log_weight.max())
    expected = found.expected(log_weight)
    keep = weight > _NEGLIGIBLE * weight.max()
    return Belief(
        weight[keep] / weight[keep].sum(),
        found.mean[keep],
        found.variance[keep],
        bias[keep],
        scatter[keep],
        expected,
    )


def _scales(prior: Prior) -> tuple[Array, Array, Array]:
    """Scales of bias and scatter at 40 × 40 nodes, with the logarithm of their prior weight."""

    def nodes(low: float, high: float) -> tuple[Array, Array]:
        half = 0.5 * (high - low)
        return half * _NODES + 0.5 * (high + low), np.log(half * _WEIGHTS)

    # A bias of Student's t is Gaussian with precision Gamma(2, 2) over its scale.
    # The whole tails: else one slip three decades off would make the whole plane severe.
    u, weight_u = nodes(math.log(1e-6), math.log(20.0))
    v, weight_v = nodes(math.log(0.1 * prior.scatter), math.log(max(50.0, 10 * prior.scatter)))
    log_u = WORTH / 2 * (u - np.exp(u)) + weight_u
    log_v = -WORTH * v - WORTH * prior.scatter**2 / (2 * np.exp(2 * v)) + weight_v
    bias, scatter = np.meshgrid(prior.bias / np.sqrt(np.exp(u)), np.exp(v), indexing="ij")
    return bias.ravel(), scatter.ravel(), (log_u[:, None] + log_v).ravel()


class _Conditioned:
    """Gaussians of the bias at each pair of scales, by expectation propagation.

    `mean` and `variance` (g,) are those of the bias over its scale. Each result has a Gaussian
    factor, of which `precision` and `shift` (n, g) are the natural parameters. That of a
    transition is exact.
    """

    def __init__(self, results: Sequence[SpecimenResult], bias: Array, scatter: Array) -> None:
        g, n = len(bias), len(results)
        self.results, self.bias, self.scatter = results, bias, scatter
        self.mean, self.variance = np.zeros(g), np.ones(g)
        self.precision, self.shift = np.zeros((n, g)), np.zeros((n, g))
        for i, result in enumerate(results):
            if result.is_transition:
                own = 1 / self._variance(result)
                self._replace(i, own, -(result.y - result.sign * result.width / 2) * own)
        intervals = [i for i, result in enumerate(results) if not result.is_transition]
        for _ in range(_SWEEPS if intervals else 0):
            before = self.precision[intervals]
            for i in intervals:
                self._replace(i, *self._matched(i))
            after = self.precision[intervals]
            if np.all(np.abs(after - before) <= _SETTLED * np.maximum(after.max(axis=0), 1e-12)):
                break

    def _variance(self, result: SpecimenResult) -> Array:
        """Variance of a result about the latent value, without inputs and bias."""
        width = result.width**2 / 12 if result.is_transition else 0.0
        return self.scatter**2 + result.own**2 + width

    def _cavity(self, i: int) -> tuple[Array, Array, Array, Array]:
        """Mean and variance (g,) of the bias; then those without result i."""
        m, v = self.bias * self.mean, self.bias**2 * self.variance
        rest = np.maximum(1 - v * self.precision[i], 1e-9)
        return m, v, (m - v * self.shift[i]) / rest, v / rest

    def _matched(self, i: int) -> tuple[Array, Array]:
        """Natural parameters of the Gaussian that has the moments of result i's own factor."""
        result = self.results[i]
        _, _, m, v = self._cavity(i)
        own = self._variance(result)
        _, first, second = _interval(result, result.y + m, v + own)
        second = np.clip(second, 0, (1 - 1e-12) / (v + own))
        rest = 1 - v * second
        return second / rest, (first + m * second) / rest

    def _replace(self, i: int, precision: Array, shift: Array) -> None:
        """Give result i another Gaussian factor, and update mean and variance."""
        change, (m, v, *_) = precision - self.precision[i], self._cavity(i)
        along, scale = self.variance * self.bias, 1 / (1 + change * v)
        self.mean = self.mean + along * (shift - self.shift[i] - change * m) * scale
        self.variance = self.variance - along**2 * change * scale
        self.precision[i], self.shift[i] = precision, shift

    @property
    def log_evidence(self) -> Array:
        """Logarithm of the probability of all results at each pair of scales (g,)."""
        total: Array = 0.5 * (np.log(self.variance) + self.mean**2 / self.variance)
        for i in range(len(self.results)):
            m, v, m_rest, v_rest = self._cavity(i)
            total = total + self._log_share(i) + 0.5 * (m_rest**2 / v_rest + np.log(v_rest / v))
            total = total - 0.5 * m**2 / v
        return total

    def _log_share(self, i: int) -> Array:
        """Logarithm of the probability of result i by the others, at each pair of scales (g,)."""
        result = self.results[i]
        *_, m, v = self._cavity(i)
        variance = v + self._variance(result)
        if result.is_transition:
            middle = result.y - result.sign * result.width / 2 + m
            return np.asarray(-0.5 * (middle**2 / variance + np.log(2 * np.pi * variance)))
        return _interval(result, result.y + m, variance)[0]

    def expected(self, log_weight: Array) -> tuple[float, ...]:
        """Probability of each result by the others; `log_weight` (g,) is that with all results."""
        found = []
        for i, result in enumerate(self.results):
            without = log_weight - self._log_share(i)
            without = np.exp(without - without.max())
            without = without / without.sum()
            *_, m, v = self._cavity(i)
            k = np.sqrt(v + self._variance(result))
            severe = float(without @ ndtr(result.sign * (result.y + m) / k))
            if math.isinf(result.width):
                found.append(severe)
                continue
            mild = float(without @ ndtr((result.width - result.sign * (result.y + m)) / k))
            found.append(min(1.0, 2 * min(severe, mild)))
        return tuple(found)


def _interval(result: SpecimenResult, m: Array, variance: Array) -> tuple[Array, Array, Array]:
    """Ln of an interval's probability, its first derivative by `m`, and minus its second."""
    k = np.sqrt(variance)
    high, low = result.sign * m / k, (result.sign * m - result.width) / k
    if math.isinf(result.width):
        log_share: Array = log_ndtr(high)
        ratio_low: Array | float = 0.0
        bent: Array | float = 0.0
    else:
        # In the upper tail both are mirrored, so that their difference keeps its digits.
        swap = low > 0
        top, bottom = np.where(swap, -low, high), np.where(swap, -high, low)
        gap = np.minimum(log_ndtr(bottom) - log_ndtr(top), -1e-15)
        log_share = log_ndtr(top) + np.log(-np.expm1(gap))
        ratio_low = np.exp(_log_normal(low) - log_share)
        bent = low * ratio_low
    ratio_high = np.exp(_log_normal(high) - log_share)
    first = (ratio_high - ratio_low) / k
    return log_share, result.sign * first, first**2 + (high * ratio_high - bent) / variance


def _log_normal(x: Array) -> Array:
    return np.asarray(-0.5 * x * x - 0.5 * math.log(2 * math.pi))
