"""Draws of the unknown inputs, with weights, from the prior or given the tests."""

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
"""Probabilities of the quantiles that are printed and drawn."""
COUNT = 2**12
"""Number of draws of the scene's own distributions."""


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Random values of the unknown inputs (n, n_unknown) [SI], with weights (n,) that sum to 1.

    `faults` are reasons why the model does not fit the tests; empty if the model fits.
    """

    inputs: Array
    weights: Array
    faults: tuple[str, ...] = ()
    #: Candidates for the scatter between runs (n_scatter,) and their probability by draw
    #: (n, n_scatter); None without tests.
    scatters: Array | None = None
    by_scatter: Array | None = None

    @property
    def misfit(self) -> str:
        """Why the model does not fit the tests, and what to do; empty if it fits."""
        if not self.faults:
            return ""
        return (
            f"the model does not fit the tests ({'; '.join(self.faults)}): nothing is decided; "
            "check the scene and the ranges in [unknown]"
        )

    @property
    def effective(self) -> float:
        """Effective sample size: number of equally weighted draws with the same information."""
        return float(1 / np.sum(self.weights**2))

    def mean(self, values: Array) -> Any:
        """Weighted mean of `values` over their first axis, the draws."""
        return np.tensordot(self.weights, values, axes=1)

    def spread(self, values: Array) -> float:
        """Weighted standard deviation of `values` (n,), one for each draw."""
        return math.sqrt(float(self.mean((values - self.mean(values)) ** 2)))

    def quantile(self, values: Array, share: float) -> float:
        """Weighted quantile of `values` (n,), one for each draw, at the probability `share`."""
        return float(quantile(values, self.weights, share))

    def interval(self, values: Array) -> tuple[float, float, float]:
        """5, 50 and 95 % quantiles of the draws' `values` (n,)."""
        low, middle, high = (self.quantile(values, share) for share in QUANTILES)
        return low, middle, high


def prior(unknown: Sequence[Unknown], seed: int, count: int = COUNT) -> Draws:
    """Draw `count` values of each input from the scene's distributions, with equal weights."""
    inputs = drawn(tuple(unknown), seed, count)
    return Draws(inputs, np.full(count, 1 / count))


FRICTION, BULK, CRITICAL, SHARE = (
    "friction.coefficient", "temperature.bulk", "temperature.critical", "temperature.failing_share",
)  # fmt: skip
LEAST_FRICTION = 1e-3
"""Lower limit of friction, for the few draws of a wide distribution that are below it."""
