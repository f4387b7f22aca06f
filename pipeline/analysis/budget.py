"""What makes a verdict uncertain at a place: shares of the variance of y, and what would help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np
import pandas as pd

from pipeline.analysis.at import ConditionKeywords, asked_at
from pipeline.analysis.judge import Judge, judge_of
from pipeline.analysis.likelihood import Belief, condition
from pipeline.analysis.margin_frame import margin
from pipeline.analysis.reading import ResultsLike
from pipeline.analysis.tables import frame_of
from pipeline.constants import LITTLE_HELP
from pipeline.sweep.shown import shown
from tribo.types import Array

BIAS, SCATTER = "the model's bias", "scatter of specimens"
HEADS = "uncertain", "before the tests [%]", "after the tests [%]", "knowing it takes [%]"
_TRANSITION = "a further transition here"


@shown
@dataclass(frozen=True, eq=False)
class Budget:
    """Shares of the variance of ln(rise/limit) at a place, which add up to 1.

    Each is the covariance of one cause with the total, over the variance of the total. It is
    negative where tests make a cause offset others.
    """

    names: tuple[str, ...]  #: Causes: uncertain inputs by their paths, then bias and scatter.
    before: Array  #: Share of each cause before the tests.
    after: Array  #: Share of each cause after the tests.
    takes: Array  #: Part of the variance that goes if an input becomes known, for each input.
    transition: float  #: Part of the variance that a further transition at the place takes.
    spreads: tuple[float, float]  #: Standard deviations of the total before and after the tests.
    error: float  #: Relative numerical error of the rise.

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
    def table(self) -> pd.DataFrame:
        """Data frame with a row for each cause, their sum, and what stands below the sum."""
        takes = [*self.takes.tolist(), None, None]
        parts = zip(self.names, self.before.tolist(), self.after.tolist(), takes, strict=True)
        below = [
            ("sum", float(self.before.sum()), float(self.after.sum()), None),
            ("standard deviation of the rise", *self.spreads, None),
            ("numerical error of the rise", self.error, self.error, None),
        ]
        return frame_of(HEADS, [*parts, *below])


@np.errstate(under="ignore")
def budget(
    ds: ResultsLike,
    load: float | str,
    velocity: float | str,
    **conditions: Unpack[ConditionKeywords],
) -> Budget:
    """Find what makes the verdict on an operating point uncertain, and what would help most.

    Parameters
    ----------
    ds, load, velocity, **conditions
        As for the margin of one operating point, `pipeline.margin`.

    Returns
    -------
    Budget
        Shares of the variance; ``table`` has them as a data frame, ``advice`` says what would help
        most.

    Raises
    ------
    InputError
        As `pipeline.margin`.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.budget("results/first_try.zarr", "400 N", "2.2 m/s")
    >>> found.names, f"{found.after.sum():.3f}"
    (("the model's bias", 'scatter of specimens'), '1.000')
    """
    data = asked_at(ds, conditions)
    place = margin(data, load, velocity)
    return budget_at(judge_of(next(data.scenes)), place.load, place.velocity)


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
