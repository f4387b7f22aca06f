"""Draws of the unknown inputs, before or after tests weigh them, and inputs that are fixed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.analysis.field import quantile
from pipeline.uncertain.unknown import Unknown, drawn
from tribo.types import Array

QUANTILES = (0.05, 0.5, 0.95)
"""Probabilities of which values are given, and lines drawn."""
COUNT = 2**12
"""Number of draws of the scene's own distributions."""


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Values of the unknown inputs (n, n_unknown) [SI], each with a weight; their sum is 1.

    Faults are reasons why the model does not fit the tests that weigh them.
    """

    inputs: Array
    weights: Array
    faults: tuple[str, ...] = ()
    #: Scatters of runs that tests allow, and the odds of each by draw (n, n_scatter), if any do.
    scatters: Array | None = None
    by_scatter: Array | None = None

    @property
    def misfit(self) -> str:
        """Why the model does not fit, and what to do; empty if nothing speaks against it."""
        if not self.faults:
            return ""
        return (
            f"the model does not fit: {'; '.join(self.faults)}; nothing is decided by it: look at "
            "the scene and at [unknown]"
        )

    @property
    def effective(self) -> float:
        """Effective sample size: number of equally weighted draws with the same information."""
        return float(1 / np.sum(self.weights**2))

    def mean(self, values: Array) -> Any:
        """Weighted mean over the draws, the first axis."""
        return np.tensordot(self.weights, values, axes=1)

    def spread(self, values: Array) -> float:
        """Weighted standard deviation over the draws, the first axis."""
        return math.sqrt(float(self.mean((values - self.mean(values)) ** 2)))

    def quantile(self, values: Array, share: float) -> float:
        """Value that a share of the probability stays below; values may be infinite."""
        return float(quantile(values, self.weights, share))

    def interval(self, values: Array) -> tuple[float, float, float]:
        """Values that 5, 50 and 95 % of the probability stay below."""
        low, middle, high = (self.quantile(values, share) for share in QUANTILES)
        return low, middle, high


def prior(unknown: Sequence[Unknown], seed: int, count: int = COUNT) -> Draws:
    """Draw from the distributions that the scene gives its unknown inputs."""
    inputs = drawn(tuple(unknown), seed, count)
    return Draws(inputs, np.full(count, 1 / count))


FRICTION, BULK, CRITICAL, SHARE = (
    "friction.coefficient", "temperature.bulk", "temperature.critical", "temperature.failing_share",
)  # fmt: skip
LEAST_FRICTION = 1e-3
"""Friction of the few draws of a wide distribution that are lower, or negative."""
