"""Correlated unknown inputs: a Gaussian copula over the shares by which each of them is drawn.

A share u of an input's probability has the normal score z = Φ⁻¹(u). With the triangular factor L of
the matrix of correlations, L Lᵀ = R, independent scores become correlated ones, L z, and these
shares again: each input keeps its own distribution (Nelsen, An Introduction to Copulas, 2006).
"""

from __future__ import annotations

import math

import numpy as np
import scipy  # its special functions take 0.2 s to load

from tribo.types import Array

OUTERMOST = 2.0**-40
"""Share beyond which nothing is drawn at either end of a distribution."""
_LEAST = 1e-6  # of the variance of an input's score that the others must leave open


def correlated(correlations: Array, shares: Array) -> list[Array]:
    """Shares by which to draw each input, from independent ones, shape (n, n_unknown or more).

    Those of inputs that are correlated with none before them are as they were.

    Examples
    --------
    >>> first, second = correlated(np.array([[1, 0.6], [0.6, 1]]), np.array([[0.8413447, 0.5]]))
    >>> print(f"{first[0]:.4f} {second[0]:.4f}")  # the second's score is 0.6
    0.8413 0.7257
    """
    columns = list(shares.T[: len(correlations)])
    dependent = [i for i, row in enumerate(correlations) if row[:i].any()]
    if not dependent:
        return columns
    factor = np.linalg.cholesky(correlations)
    scores = [scipy.special.ndtri(column) for column in columns]
    for i in dependent:
        # One after the other, so that a sample does not depend on how many there are.
        score = sum(factor[i, j] * scores[j] for j in range(i + 1))
        columns[i] = np.clip(scipy.special.ndtr(score), OUTERMOST, 1 - OUTERMOST)
    return columns


def first_unfit(correlations: Array) -> int | None:
    """Number of the first input that cannot be correlated with those before it as it is said to."""
    for i in range(1, len(correlations)):
        before, last = correlations[:i, :i], correlations[i, :i]
        if 1 - last @ np.linalg.solve(before, last) < _LEAST:
            return i
    return None


def allowed(correlations: Array, i: int, j: int) -> tuple[float, float] | None:
    """Ends of what the correlation of an input with one before it may be, given all the others.

    None if there is no such value.

    Examples
    --------
    >>> of_three = np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.8], [0.0, 0.8, 1.0]])
    >>> low, high = allowed(of_three, 2, 0)
    >>> print(f"{low:.2f} {high:.2f}")
    0.28 1.00
    """
    inverse = np.linalg.inv(correlations[:i, :i])
    others = correlations[i, :i].copy()
    others[j] = 0.0
    a, b, c = inverse[j, j], inverse[j] @ others, others @ inverse @ others - (1 - _LEAST)
    if b * b < a * c:
        return None
    half = math.sqrt(b * b - a * c)
    return float((-b - half) / a), float((-b + half) / a)
