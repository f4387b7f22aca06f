"""The model's own error: how far ln(velocity) of the next run is off, by the tests of a scene.

It follows Student's t with 4 + n degrees of freedom and the scale √((4·s² + Σr²)/(4 + n)): r is
ln(measured/computed) of n transitions at their own conditions, and s is 10 %, which counts like
four tests. So few tests say little, and who leaves tests out gains nothing. An outcome that the
model has wrong counts with its distance from the nearest transition; a right one does not count.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import stdtr

from tribo.types import Array

USUAL = 0.10
"""Scatter of a run about the model where no test tells it."""
_WORTH = 4  # tests that the usual scatter counts like


class Scatter(Protocol):
    """Distribution of ln(velocity) of the next run about the model's."""

    @property
    def worded(self) -> str:
        """What it rests on."""

    def below(self, distances: Array) -> Array:
        """Probability that it is below distances."""


@dataclass(frozen=True, slots=True)
class ModelError:
    """Student's t about the model."""

    residuals: tuple[float, ...] = ()  #: ln(measured/computed) of the tests that count.
    usual: float = USUAL  #: Relative scatter that stands in for tests.
    untold: str = "no test here"  #: Why no test counts, where none does.

    @property
    def scale(self) -> float:
        """Scale of Student's t."""
        n = len(self.residuals)
        return math.sqrt(
            (_WORTH * self.usual**2 + sum(r * r for r in self.residuals)) / (_WORTH + n)
        )

    def below(self, distances: Array) -> Array:
        """See `Scatter`."""
        if self.scale == 0:
            return np.where(distances > 0, 1.0, np.where(distances < 0, 0.0, 0.5))
        return np.asarray(stdtr(_WORTH + len(self.residuals), distances / self.scale))

    @property
    def worded(self) -> str:
        """See `Scatter`."""
        if n := len(self.residuals):
            tests = "1 test" if n == 1 else f"{n} tests"
            prior = f"a prior of {100 * self.usual:g} %"
            return f"± {100 * self.scale:.2g} % in velocity, from {tests} and {prior}"
        if self.usual == 0:
            return "none, as the scene says"
        return f"± {100 * self.usual:g} % in velocity, a prior; {self.untold}"


Ranges = Sequence[tuple[float, float]]
"""Velocities between which wear is severe [m/s], from 0 and to infinity where they have no end."""


def severe_share(ranges: Ranges, velocities: Array, scatter: Scatter) -> Array:
    """Probability that the next run is severe, by velocity, of wear with these ranges.

    A run at V behaves like the model at V·exp(ε), where ε has the scatter.
    """
    share = np.zeros(np.shape(velocities))
    with np.errstate(divide="ignore"):
        for begin, end in ranges:
            low, high = (np.log(x) - np.log(velocities) for x in (begin, end))
            share += scatter.below(high) - scatter.below(low)
    return np.clip(share, 0.0, 1.0)
