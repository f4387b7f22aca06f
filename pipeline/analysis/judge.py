"""The judge of one case: how likely severe wear is at any place, and which tests forbid a verdict.

y = ln(rise/limit) is computed (`pipeline.analysis.rises`), with its numerical error e. What tests
say of it is the evidence (`pipeline.analysis.tested`). A further run is mild if it is severe with a
probability of at most 5 % at y + e, severe if with at least 95 % at y − e, else not decided.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.analysis.film import OUTSIDE, is_outside
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import rise_errors, totals
from pipeline.analysis.rises import Places, Rises, places_of, rises_of
from pipeline.analysis.tested import Evidence, evidence_of, forbidden
from pipeline.constants import DECIDED
from pipeline.sweep.conditions import Conditions, known_critical_temperature
from tribo.types import Array, Mask

NOT_DECIDED = "not decided"
"""Verdict if a further run is neither mild nor severe with 95 % probability."""


@dataclass(frozen=True, eq=False)
class Judge:
    """Rises and evidence of one case, under the conditions of `rises`."""

    rises: Rises
    evidence: Evidence  #: What the tests say.

    @property
    def conditions(self) -> Conditions:
        """Conditions by which places are judged."""
        return self.rises.conditions

    @property
    def source(self) -> Results:
        """Results of the case."""
        return self.rises.source

    def judged_by(self, own: Mapping[str, float]) -> Judge:
        """The judge under conditions of one operating point in place of the scene's.

        Friction and bulk temperature move the place alone; a critical temperature and a failing
        share move the tests, too.
        """
        given = [name for name, value in own.items() if value is not None]
        if not given:
            return self
        rises = self.rises.judged_by(own)
        if {"critical_temperature", "failing_share"} & {*given}:
            return _judge(self.source, rises)
        return replace(self, rises=rises)

    def chances(self, loads: Places, velocities: Places) -> tuple[Array, Array, Array]:
        """Probabilities of severe wear (k,): lowest, as computed and highest by numerical error.

        Where the error is unknown, the lowest probability is 0 and the highest 1.
        """
        loads, velocities = places_of(loads, velocities)
        y, error = self.rises.y(loads, velocities), self.errors(loads, velocities)
        is_known = np.isfinite(error)
        width = np.where(is_known, np.log1p(error), 0.0)
        ends = np.stack([y - width, y, y + width])
        low, middle, high = self.evidence.belief.probability(ends)
        return np.where(is_known, low, 0.0), middle, np.where(is_known, high, 1.0)

    def errors(self, loads: Places, velocities: Places) -> Array:
        """Relative numerical errors of the rise (k,); NaN where unknown."""
        return totals(rise_errors(self.rises, loads, velocities))

    def forbidden(self, loads: Places, velocities: Places) -> tuple[Mask, Mask, list[str]]:
        """Places at which tests forbid mild wear, and severe wear (k,), and their names."""
        loads, velocities = places_of(loads, velocities)
        no_mild, no_severe, names = forbidden(
            self.evidence, self.source, self.conditions, loads, velocities
        )
        open_sides = self.evidence.open_sides
        return no_mild | open_sides[0], no_severe | open_sides[1], names

    def outside(self, loads: Places, velocities: Places) -> Mask:
        """True where a film carries more of the load than the model allows (k,)."""
        return is_outside(self.rises, loads, velocities)

    def verdicts(self, loads: Places, velocities: Places) -> Array:
        """Verdicts (k,) as texts: mild, severe, not decided, outside; empty if y is unknown."""
        low, middle, high = self.chances(loads, velocities)
        no_mild, no_severe, _ = self.forbidden(loads, velocities)
        return np.select(
            [
                np.isnan(middle),
                self.outside(loads, velocities),
                (high <= DECIDED[0]) & ~no_mild,
                (low >= DECIDED[-1]) & ~no_severe,
            ],
            ["", OUTSIDE, "mild", "severe"],
            NOT_DECIDED,
        )

    @functools.cached_property
    def levels(self) -> tuple[float, float, float]:
        """Y at which a place is severe with 5, 50 and 95 %."""
        low, middle, high = map(self.evidence.belief.level, DECIDED)
        return low, middle, high

    def tested_velocities(self, loads: Array) -> Array:
        """Velocities with tests at k loads (3, k): first P = 5 %, first 50 %, and last 95 % [m/s].

        NaN where there is none up to 3 times beyond the computed velocities.
        """
        places, begins, ends = self.rises.crossings(loads, self.levels)
        first, last = np.fmin.reduce(places, axis=2), np.fmax.reduce(places, axis=2)
        found = np.where(begins, math.nan, first)
        found[:, -1] = np.where(ends[:, -1], last[:, -1], math.nan)
        return found.T


def judge_of(data: Results, conditions: Conditions | None = None) -> Judge:
    """Judge of one case, under `conditions`; None for those of `data`."""
    return _judge(data, rises_of(data, conditions or data.conditions))


def _judge(data: Results, rises: Rises) -> Judge:
    _ = known_critical_temperature(rises.conditions)  # raises, as without it there is no verdict
    return Judge(rises, evidence_of(data, rises.conditions))
