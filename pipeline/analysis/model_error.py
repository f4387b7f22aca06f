"""The model's own error: how far the critical velocity of a further laboratory run may be off.

The distribution of this error in ln(velocity) follows from the tests of a scene. It is Student's t
with 4 + n degrees of freedom and the scale √((4·s² + Σr²)/(4 + n)). r is ln(measured/computed) of n
transitions at their own conditions. s is a prior of 10 %, which counts like four tests, so that few
tests change little.

A wrong outcome, at the distance r from the computed transition, widens the half of the distribution
on its side. The farthest wrong outcomes count, as many as make the scale largest, and they add no
degree of freedom. So no wrong outcome narrows the error, or makes the other outcome more likely. A
right outcome does not count.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from tribo.types import Array

USUAL = 0.10
"""Prior of the relative scatter of a run about the model."""
AGREED = "no test contradicts it"
"""Reason for the prior if all tests that can be compared are right."""
WORTH = 4  # the prior weighs as much as this number of tests


@dataclass(frozen=True, slots=True)
class ModelError:
    """The model's own error in ln(velocity): Student's t with a scale for each sign.

    `residuals` are ln(measured/computed) of transitions, and `wrong` those of wrong outcomes.
    """

    residuals: tuple[float, ...] = ()  #: ln(measured/computed) of transitions.
    wrong: tuple[float, ...] = ()  #: ln(measured/computed) of tests with a wrong outcome.
    usual: float = USUAL  #: Prior of the relative scatter.
    reason: str = "no test confirms or contradicts it"  #: Why only the prior counts.

    @property
    def degrees(self) -> int:
        """Degrees of freedom of Student's t."""
        return WORTH + len(self.residuals)

    @property
    def scales(self) -> tuple[float, float]:
        """Scales of Student's t in ln(velocity), below and above the computed critical velocity."""
        known = WORTH * self.usual**2 + sum(r * r for r in self.residuals)
        low, high = (
            sorted((r * r for r in self.wrong if r * side > 0), reverse=True) for side in (-1, 1)
        )
        return self._widest(known, low), self._widest(known, high)

    def _widest(self, known: float, squares: Iterable[float]) -> float:
        """Scale of Student's t, with as many wrong outcomes as make the scale largest.

        `squares` are the squared residuals of the wrong outcomes, the largest first. With the first
        n of them the scale is √((known + their sum)/(degrees + n)). `known` is the weighted
        variance of the prior plus the squared residuals of the transitions.
        """
        sums = enumerate(itertools.accumulate(squares, initial=known), self.degrees)
        return math.sqrt(max(total / count for count, total in sums))

    def below(self, distances: Array) -> Array:
        """Probability that a further run's deviation from the model is below each of `distances`.

        A deviation is in ln(velocity), and positive if wear is severer than in the model: a run at
        velocity V is like the model at V·exp(deviation).
        """
        severer, milder = self.scales
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = distances / np.where(distances > 0, severer, milder)
        return np.asarray(stdtr(self.degrees, np.where(distances == 0, 0.0, ratios)))

    @property
    def text(self) -> str:
        """Size and basis, such as "± 10 % in velocity, assumed; no test contradicts it"."""
        if n := len(self.residuals) + len(self.wrong):
            tests = "1 test" if n == 1 else f"{n} tests"
            prior = f"a prior of {100 * self.usual:g} %"
            low, high = (f"{100 * scale:.2g}" for scale in self.scales)
            size = f"± {low}" if low == high else f"−{low} to +{high}"
            return f"{size} % in velocity, from {tests} and {prior}"
        if self.usual == 0:
            return "none, as the scene says"
        return f"± {100 * self.usual:g} % in velocity, assumed; {self.reason}"
