"""Draws of the unknown inputs, before or after they are weighed by measurements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.sweep.unknown import Unknown, drawn
from tribo.types import Array

QUANTILES = (0.05, 0.5, 0.95)
"""Probabilities of which values are given, and lines drawn."""
COUNT = 2**12
"""Number of draws of the scene's own distributions."""
_AT_A_TIME = 256


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Values of the unknown inputs, each with a weight.

    Attributes
    ----------
    inputs : ndarray, shape (n, n_unknown)
        Values [SI].
    weights : ndarray, shape (n,)
        Probabilities; their sum is 1.
    """

    inputs: Array
    weights: Array

    @property
    def effective(self) -> float:
        """Number of draws of equal weight that would tell as much."""
        return float(1 / np.sum(self.weights**2))

    def parts(self) -> Iterator[Draws]:
        """The draws in parts, of which many values at a time take little memory."""
        for begin in range(0, len(self.weights), _AT_A_TIME):
            part = slice(begin, begin + _AT_A_TIME)
            yield Draws(self.inputs[part], self.weights[part])

    def mean(self, values: Array) -> Any:
        """Weighted mean over the draws, the first axis."""
        return np.tensordot(self.weights, values, axes=1)

    def quantile(self, values: Array, share: float) -> float:
        """Value that a share of the probability stays below; values may be infinite."""
        order = np.argsort(values)
        below = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        return float(np.interp(share, below, values[order]))

    def interval(self, values: Array) -> tuple[float, float, float]:
        """Values that 5, 50 and 95 % of the probability stay below."""
        low, middle, high = (self.quantile(values, share) for share in QUANTILES)
        return low, middle, high


def prior(unknown: Sequence[Unknown], seed: int, count: int = COUNT) -> Draws:
    """Draw from the distributions that the scene gives its unknown inputs.

    Examples
    --------
    >>> friction = Unknown("friction.coefficient", "normal", (0.1, 0.005))
    >>> draws = prior([friction], seed=0)
    >>> print(f"{draws.mean(draws.inputs)[0]:.4f}")
    0.1000
    """
    inputs = drawn(tuple(unknown), seed, count)
    return Draws(inputs, np.full(count, 1 / count))
