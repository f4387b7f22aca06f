"""Draws of a posterior in steps from the prior, each weighed a little more by the likelihood.

Sequential Monte Carlo (Del Moral, Doucet & Jasra, J. R. Stat. Soc. B 68 (2006) 411): from one power
of the likelihood to the next draws are weighed, resampled, and moved by random walks of Metropolis
in normal scores, whose steps follow the covariance of the draws.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import brentq
from scipy.special import logsumexp, ndtri

from pipeline.sweep.unknown import Unknown, at_scores, sequence
from tribo.types import Array

_KEPT = 0.5  # effective share of the draws that a step of the power leaves
_MOVES = 4  # random walks after each step
_STEPS = 60  # of the power, at most


def tempered(
    unknown: Sequence[Unknown],
    log_likelihood: Callable[[Array], Array],
    seed: int,
    count: int,
) -> tuple[Array, float]:
    """Draws of equal weight from prior times likelihood, shape (count, n_unknown) [SI].

    The logarithm of the likelihood is called with draws (n, n_unknown) [SI], and gives (n,). The
    second result is the logarithm of the evidence, the mean of the likelihood over the prior.

    Examples
    --------
    A normal prior of 0 ± 1 and a measurement of 3 ± 0.1:

    >>> inputs = [Unknown("friction.coefficient", "normal", (0.0, 1.0))]
    >>> def log_likelihood(x):
    ...     return -0.5 * ((x[:, 0] - 3) / 0.1) ** 2
    >>> draws, evidence = tempered(inputs, log_likelihood, seed=0, count=1000)
    >>> print(f"{draws.mean():.2f} {draws.std():.1f} {abs(evidence + 6.76) < 0.2}")
    2.97 0.1 True
    """
    rng = np.random.default_rng(seed)
    scores = ndtri(sequence(seed, count)[:, : len(unknown)])
    likelihood = log_likelihood(at_scores(unknown, scores))
    power, evidence = 0.0, 0.0
    for _ in range(_STEPS):
        step = _step(likelihood, 1.0 - power)
        total = float(logsumexp(step * likelihood))
        evidence += total - math.log(count)
        weights = np.exp(step * likelihood - total)
        power += step
        places = (rng.random() + np.arange(count)) / count
        kept = np.searchsorted(np.cumsum(weights), places).clip(max=count - 1)
        scores, likelihood = scores[kept], likelihood[kept]
        covariance = np.atleast_2d(np.cov(scores.T)) + 1e-9 * np.eye(len(unknown))
        walk = 2.38 / np.sqrt(len(unknown)) * np.linalg.cholesky(covariance)
        for _ in range(_MOVES):
            proposed = scores + rng.standard_normal(scores.shape) @ walk.T
            other = log_likelihood(at_scores(unknown, proposed))
            gain = power * (other - likelihood)
            gain += 0.5 * np.sum(scores**2 - proposed**2, axis=1)
            taken = np.log(rng.random(count)) < gain
            scores[taken], likelihood[taken] = proposed[taken], other[taken]
        if power >= 1.0:
            break
    return at_scores(unknown, scores), evidence


def _step(likelihood: Array, most: float) -> float:
    """Largest step of the power that leaves enough draws of effect."""

    def spare(step: float) -> float:
        log = step * likelihood
        return float(np.exp(2 * logsumexp(log) - logsumexp(2 * log)) / len(log)) - _KEPT

    return most if spare(most) >= 0 else max(brentq(spare, 0.0, most), 1e-6 * most)
