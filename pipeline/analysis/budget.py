"""What makes a verdict uncertain at a place: shares of the variance of y, and what would help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pipeline.analysis.judge import Judge
from pipeline.analysis.likelihood import Belief, condition
from pipeline.analysis.tables import frame_of
from pipeline.constants import LITTLE_HELP
from tribo.types import Array

BIAS, SCATTER = "the model's bias", "scatter of specimens"
HEADS = "uncertain", "before the tests [%]", "after the tests [%]", "knowing it takes [%]"
_TRANSITION = "a further transition here"


@dataclass(frozen=True, eq=False)
class Budget:
    """Shares of the variance of ln(rise/limit) at a place, which add up to 1.

    Each is the covariance of one cause with the total, over the variance of the total. It is
    negative where tests make a cause offset others. `takes` is the part of the variance that goes
    if an input becomes known, and `transition` the part that a further transition at the place
    takes. `spreads` are the standard deviations of the total before and after the tests.
    """

    names: tuple[str, ...]  # inputs, then bias and scatter
    before: Array
    after: Array
    takes: Array  # by input
    transition: float
    spreads: tuple[float, float]
    error: float  # numerical, of the rise

    @property
    def advice(self) -> str:
        """What would help most, in words."""
        if not self.takes.size or self.takes.max() < LITTLE_HELP:
            return "none of these: a test here"
        best = int(self.takes.argmax())
        options = {f"knowing {self.names[best]}": self.takes[best], _TRANSITION: self.transition}
        order = sorted(options, key=lambda name: -options[name])
        return "; ".join(
            f"{name} takes {100 * options[name]:.0f} % of the variance" for name in order
        )

    @property
    def frame(self) -> pd.DataFrame:
        """Data frame with a row for each cause, their sum, and what stands below the sum."""
        takes = [*self.takes.tolist(), None, None]
        parts = zip(self.names, self.before.tolist(), self.after.tolist(), takes, strict=True)
        below = [
            ("sum", float(self.before.sum()), float(self.after.sum()), None),
            ("standard deviation of the rise", *self.spreads, None),
            ("numerical error of the rise", self.error, self.error, None),
        ]
        return frame_of(HEADS, [*parts, *below])


def budget_at(judge: Judge, load: float, velocity: float) -> Budget:
    """Budget at one load [N] and velocity [m/s], under the conditions of the judge."""
    effects, place = judge.effects, (np.array([load]), np.array([velocity]))
    prior = condition((), judge.source.prior, len(effects.inputs))
    critical = effects.conditions.critical_temperature
    at_first = replace(judge.conditions, critical_temperature=critical)
    before, _, first, _ = _moments(prior, effects.at(at_first, *place)[0])
    belief, a = judge.evidence.belief, effects.at(judge.tested_conditions, *place)[0]
    after, variances, last, scatter = _moments(belief, a)
    with np.errstate(divide="ignore", invalid="ignore"):
        takes = np.nan_to_num((after * last) ** 2 / (variances * last))[: len(a)]
    shared = last - scatter
    return Budget(
        (*(one.path for one in effects.inputs), BIAS, SCATTER),
        before,
        after,
        takes,
        shared**2 / last**2,
        (first**0.5, last**0.5),
        float(judge.errors(*place)[0]),
    )


def _moments(belief: Belief, a: Sequence[float] | Array) -> tuple[Array, Array, float, float]:
    """Shares and variances of inputs, bias and scatter; variance of the total and of scatter."""
    size = np.column_stack([np.broadcast_to(a, (len(belief.bias), len(a))), belief.bias])
    weights, means = belief.weights, size * belief.means
    within = np.einsum("g,gk,gkl,gl->kl", weights, size, belief.covariances, size)
    mean = weights @ means
    covariance = within + np.einsum("g,gk,gl->kl", weights, means, means) - np.outer(mean, mean)
    scatter = float(weights @ belief.scatter**2)
    total = float(covariance.sum()) + scatter
    shares = np.append(covariance.sum(axis=1), scatter) / total
    return shares, np.append(np.diag(covariance), scatter), total, scatter
