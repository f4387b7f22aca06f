"""Draws of the unknown inputs given tests, by adaptive importance sampling.

The weight of a draw is prior × likelihood over the density that it was drawn from. That density is
a mixture of Student's t distributions in normal scores, fitted to the previous draws. The first
draws are of the prior. If few draws agree with the tests, the likelihood is first tempered, that is
raised to a power below 1 (Cappé, Douc, Guillin, Marin & Robert, Stat. Comput. 18 (2008) 447). Draws
are Sobol' points, independent of each other, so that their weights give the effective sample size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import gammaincinv, gammaln, logsumexp, ndtri, softmax

from pipeline.uncertain.unknown import Unknown, score_values, sequence
from tribo.types import Array

_AT_LEAST = 0.1  # effective share of the draws that a tempered likelihood must leave
_ENOUGH = 0.5  # effective share at which the fits end
_ROUNDS = 12  # most fits
_PARTS, _FITS = 6, 12  # components of the mixture, and steps of a fit
_FREEDOM = 8.0  # degrees of freedom of Student's t; its tails must cover the posterior's
_WIDER = 1.1  # ratio of a component's standard deviation to that of the draws it is fitted to
_LEAST = 0.005  # share of the whole covariance added to each component's


def sample(
    unknown: Sequence[Unknown], log_likelihood: Callable[[Array], Array], seed: int, count: int
) -> tuple[Array, Array]:
    """Draw the unknown inputs from prior × likelihood, by adaptive importance sampling.

    `log_likelihood` returns ln(likelihood) (count,) of draws (count, n_unknown) [SI]. Returns
    `count` draws, and the logarithms of their weights (count,). Only with these weights do the
    draws follow prior × likelihood. The mean of the weights is the evidence.
    """
    n, power = len(unknown), 0.0
    scores, mixture = ndtri(sequence(seed, count, n)), None
    best, most = (scores, np.zeros(count)), 0.0
    for number in range(_ROUNDS):
        inputs = score_values(unknown, scores)
        likelihood, over = log_likelihood(inputs), np.zeros(count)
        if mixture:
            log_prior = -0.5 * (np.sum(scores**2, axis=1) + n * math.log(2 * math.pi))
            over = log_prior - mixture.log_density(scores)
        power = _next_exponent(likelihood, over, power)
        share = effective_share(likelihood + over)
        if share >= most:
            best, most = (inputs, likelihood + over), share
        if share >= _ENOUGH:
            break
        chance = np.random.default_rng((seed, number))
        mixture = Mixture.fit(scores, softmax(power * likelihood + over), chance)
        scores = mixture.draw(sequence(seed + number + 1, count, n + 2))
    return best


def effective_share(log_weights: Array) -> float:
    """Effective sample size, divided by the number of draws, from logarithms of weights (n,)."""
    total = 2 * logsumexp(log_weights) - logsumexp(2 * log_weights)
    return float(np.exp(total)) / len(log_weights)


def _next_exponent(likelihood: Array, over: Array, power: float) -> float:
    """Choose the exponent of the likelihood for the next fit, from `power` up to 1.

    An exponent below 1 flattens the likelihood, so that more draws keep a noticeable weight. The
    result is the largest exponent with an effective share of the draws of at least `_AT_LEAST`, or
    `power` if there is none. `likelihood` is ln(likelihood) of each draw (count,), and `over` is
    ln(prior/density that the draw was drawn from) (count,).
    """

    def excess(other: float) -> float:
        return effective_share(other * likelihood + over) - _AT_LEAST

    if excess(1.0) >= 0:
        return 1.0
    return float(brentq(excess, power, 1.0)) if excess(power) > 0 else power


class Mixture(NamedTuple):
    """Mixture of Student's t distributions for the unknown inputs, each as its normal score.

    A normal score is the input, converted so that its prior is the standard normal distribution.
    """

    shares: Array  # (n_part,)
    centres: Array  # (n_part, n_unknown)
    factors: Array  # Cholesky factors of the covariances, (n_part, n_unknown, n_unknown)

    @classmethod
    def fit(cls, scores: Array, weights: Array, chance: np.random.Generator) -> Mixture:
        """Fit a mixture to the normal scores of weighted draws, by expectation maximisation.

        `scores` (n, n_unknown) are n draws of the unknown inputs, each converted to a standard
        normal value. `weights` (n,) add up to 1. `chance` picks the first centres of the
        components, whose number is fixed.
        """
        n = scores.shape[1]
        spread = np.cov(scores.T, aweights=weights, ddof=0).reshape(n, n) + 1e-9 * np.eye(n)
        centres = scores[chance.choice(len(scores), _PARTS, p=weights)]
        factors: Array = np.linalg.cholesky(np.array([spread] * _PARTS))
        parts = cls(np.full(_PARTS, 1 / _PARTS), centres, factors)
        for _ in range(_FITS):
            odds = softmax(
                [log - 0.5 * squares for squares, log in parts._distances(scores)], axis=0
            )
            odds = odds * weights + 1e-6 / len(scores)
            totals = odds.sum(axis=1)
            centres = odds @ scores / totals[:, None]
            apart = scores - centres[:, None]
            covariances = np.einsum("kn,kni,knj->kij", odds, apart, apart, optimize=True)
            covariances = covariances / totals[:, None, None] + _LEAST * spread
            parts = cls(totals / totals.sum(), centres, np.linalg.cholesky(covariances))
        return parts._replace(factors=_WIDER * parts.factors)

    def draw(self, points: Array) -> Array:
        """Convert uniform points (n, n_unknown + 2) to draws (n, n_unknown) from the mixture.

        A draw is a component's centre plus a normal step × a random factor, which makes the step
        follow Student's t. The last coordinate of a point chooses the component, the last but one
        gives the factor, and the others give the normal step.
        """
        part = np.searchsorted(np.cumsum(self.shares)[:-1], points[:, -1])
        wider = np.sqrt(_FREEDOM / 2 / gammaincinv(_FREEDOM / 2, points[:, -2]))
        steps = np.einsum("nij,nj->ni", self.factors[part], ndtri(points[:, :-2]))
        return np.asarray(self.centres[part] + wider[:, None] * steps)

    def log_density(self, scores: Array) -> Array:
        """Logarithm of the mixture's density (n,) at normal scores (n, n_unknown)."""
        n, freedom = self.centres.shape[1], _FREEDOM
        constant = gammaln((freedom + n) / 2) - gammaln(freedom / 2)
        constant -= 0.5 * n * math.log(freedom * math.pi)
        parts = [
            log - 0.5 * (freedom + n) * np.log1p(z2 / freedom)
            for z2, log in self._distances(scores)
        ]
        return np.asarray(constant + logsumexp(parts, axis=0))

    def _distances(self, scores: Array) -> list[tuple[Array, float]]:
        """Pairs by component: squared Mahalanobis distances (n,) of scores, and ln(share/volume).

        The volume is the root of the determinant of the component's covariance.
        """
        return [
            (
                np.sum(np.linalg.solve(factor, (scores - centre).T) ** 2, axis=0),
                math.log(share) - float(np.log(np.diag(factor)).sum()),
            )
            for share, centre, factor in zip(*self, strict=True)
        ]
