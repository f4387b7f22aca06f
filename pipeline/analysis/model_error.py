"""The model's own error: how far ln(velocity) of the next run is off, by the tests of a scene.

It follows Student's t with 4 + n degrees of freedom and the scale √((4·s² + Σr²)/(4 + n)): r is
ln(measured/computed) of n transitions at their own conditions, and s is 10 %, which counts like
four tests. So few tests say little.

An outcome that the model has wrong, at the distance r from the computed transition, widens the half
of the distribution on its side. Of these outcomes the farthest count, as many as make the scale
largest, and they add no degree of freedom: so no wrong outcome narrows the error, nor makes the
other outcome likelier. A right outcome does not count.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import stdtr

from tribo.types import Array

USUAL = 0.10
"""Scatter of a run about the model where no test tells it."""
AGREED = "no test contradicts it"
"""Why no test counts, where all that can be compared are right."""
WORTH = 4  # tests that the usual scatter counts like


class Scatter(Protocol):
    """Distribution of ln(velocity) of the next run about the model's."""

    @property
    def text(self) -> str:
        """What it rests on."""

    def below(self, distances: Array) -> Array:
        """Probability that it is below distances."""


@dataclass(frozen=True, slots=True)
class ModelError:
    """Student's t about the model, with a scale for each half."""

    residuals: tuple[float, ...] = ()  #: ln(measured/computed) of transitions.
    wrong: tuple[float, ...] = ()  #: The same of outcomes that the model has wrong.
    usual: float = USUAL  #: Relative scatter that stands in for tests.
    reason: str = "no test confirms or contradicts it"  #: Why no test counts, where none does.
    oil: str = ""  #: Oil whose tests count, if they name it.

    @property
    def degrees(self) -> int:
        """Degrees of freedom."""
        return WORTH + len(self.residuals)

    @property
    def scales(self) -> tuple[float, float]:
        """Scales of runs that turn severe below the computed velocity, and above it."""
        known = WORTH * self.usual**2 + sum(r * r for r in self.residuals)
        low, high = (
            sorted((r * r for r in self.wrong if r * side > 0), reverse=True) for side in (-1, 1)
        )
        return self._widest(known, low), self._widest(known, high)

    def _widest(self, known: float, squares: Iterable[float]) -> float:
        """Largest scale by a sum of squares that counts, and by the first of others, descending."""
        sums = enumerate(itertools.accumulate(squares, initial=known), self.degrees)
        return math.sqrt(max(total / count for count, total in sums))

    def below(self, distances: Array) -> Array:
        """See `Scatter`."""
        severer, milder = self.scales
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = distances / np.where(distances > 0, severer, milder)
        return np.asarray(stdtr(self.degrees, np.where(distances == 0, 0.0, ratios)))

    @property
    def text(self) -> str:
        """See `Scatter`."""
        if n := len(self.residuals) + len(self.wrong):
            tests = f"{'1 test' if n == 1 else f'{n} tests'}{self.oil and f' of oil {self.oil}'}"
            prior = f"a prior of {100 * self.usual:g} %"
            low, high = (f"{100 * scale:.2g}" for scale in self.scales)
            size = f"± {low}" if low == high else f"−{low} to +{high}"
            return f"{size} % in velocity, from {tests} and {prior}"
        if self.usual == 0:
            return "none, as the scene says"
        reason = f"{self.reason}{self.oil and f', of oil {self.oil}'}"
        return f"± {100 * self.usual:g} % in velocity, assumed; {reason}"
