"""Verdicts that tests rule out, at points and along lines of rising velocity.

A severe test rules out mild wear at points whose load, velocity, friction and bulk temperature are
no lower, if the scene is the same, with a film or without. A mild test rules out severe wear where
they are no higher, unless a film carried too much of its load. A transition without a step does
both, at points that differ from it. A test without a result may rule a verdict out, so this verdict
is withheld at all points.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.answers.condition_values import Operation
from pipeline.answers.evidence import Evidence, outcome_of, waiting_text
from pipeline.answers.results import CaseResults
from tribo.types import Array, Mask

_SAME = 1e-9  # relative rounding difference of equal conditions
MILD, SEVERE = "mild", "severe"


class RulingTest(NamedTuple):
    """A test that rules out the verdict `excluded`, from or up to its own point and conditions."""

    excluded: str  # "mild" or "severe"
    point: Operation  # its single operating point
    is_strict: bool  # True if the verdict is possible at the point itself
    name: str

    def signs(self, points: Operation) -> Array:
        """Signs (4, k) of points minus test; reversed if the test excludes severe wear."""
        signs = np.array([_sign(a, b.item()) for a, b in zip(points, self.point, strict=True)])
        return signs if self.excluded == MILD else -signs

    def excludes(self, points: Operation) -> Mask:
        """True at points (k,) at which the verdict is ruled out."""
        signs = self.signs(points)
        return np.asarray((signs >= 0).all(axis=0) & ((signs > 0).any(axis=0) | ~self.is_strict))

    def limits(self, points: Operation) -> Array:
        """Velocity (k,) from which, or up to which, the verdict is ruled out at the loads."""
        velocity = self.point.velocity.item()
        is_excluded = (self.signs(points._replace(velocity=0 * points.load + velocity)) >= 0).all(0)
        return np.where(is_excluded, velocity, math.inf if self.excluded == MILD else 0.0)


@dataclass(frozen=True, eq=False)
class Rulings:
    """The verdicts that the tests of a case rule out."""

    case: CaseResults
    evidence: Evidence

    @functools.cached_property
    def tests(self) -> list[RulingTest]:
        """Tests that rule a verdict out at some points."""
        return [*self._tests()]

    def _tests(self) -> Iterator[RulingTest]:
        for row in self.evidence.rows:
            test, conditions = row.test, row.conditions
            if conditions is None or test.case.scene != self.case.sweep.scene:
                continue
            is_strict = test.outcome == "transition" and len(test.points) == 1
            points = [
                Operation.under(conditions, *map(np.atleast_1d, point)) for point in test.points
            ]
            if test.outcome in ("severe", "transition"):
                yield RulingTest(MILD, points[-1], is_strict, str(row))
            if test.outcome in ("mild", "transition") and not row.is_outside:
                yield RulingTest(SEVERE, points[0], is_strict, str(row))

    @functools.cached_property
    def withheld(self) -> dict[str, str]:
        """Reason to withhold a verdict at all points, by verdict; empty if there is none."""
        evidence, reason = self.evidence, waiting_text(self.evidence)
        outcomes = {row.test.outcome for row in evidence.without_result}
        reasons = {
            MILD: reason if outcomes & {"severe", "transition"} else "",
            SEVERE: reason if outcomes & {"mild", "transition"} else "",
        }
        if evidence.critical is not None:
            results = [*map(outcome_of, evidence.specimens)]
            for excluded, needed in ((MILD, SEVERE), (SEVERE, MILD)):
                has_needed = any(math.isfinite(getattr(result, needed)) for result in results)
                if not (reasons[excluded] or has_needed):
                    reasons[excluded] = (
                        f"the critical temperature is found by tests, of which none was {needed}"
                    )
        return reasons

    def reasons(self, excluded: str, points: Operation) -> list[str]:
        """Reason why each point (k,) cannot be `excluded`, "mild" or "severe"; empty if it can."""
        if self.withheld[excluded]:
            return [self.withheld[excluded]] * len(points.load)
        names: list[dict[str, None]] = [{} for _ in points.load]
        for test in self.tests:
            if test.excluded == excluded:
                for k in np.flatnonzero(test.excludes(points)).tolist():
                    names[k][test.name] = None
        return [f"{', '.join(tests)} rules it out" if tests else "" for tests in names]

    def velocity_limits(self, excluded: str, points: Operation) -> tuple[Array, list[str]]:
        """Velocity (k,) from which mild, or up to which severe wear is ruled out at the loads.

        It is 0 (infinite) if mild (severe) wear is withheld at all velocities, and infinite (0) if
        no test rules it out. The names are those of the tests.
        """
        is_mild = excluded == MILD
        is_possible = is_mild != bool(self.withheld[excluded])
        velocities = np.full(len(points.load), math.inf if is_possible else 0.0)
        names = [""] * len(points.load)
        if self.withheld[excluded]:
            return velocities, names
        for test in self.tests:
            if test.excluded != excluded:
                continue
            limits = test.limits(points)
            is_closer = limits < velocities if is_mild else limits > velocities
            for k in np.flatnonzero(is_closer).tolist():
                velocities[k], names[k] = limits[k], test.name
        return velocities, names


def _sign(a: Array, b: float) -> Array:
    """Sign of a − b; 0 if they differ only by rounding."""
    return np.where(np.abs(a - b) <= _SAME * abs(b), 0.0, np.sign(a - b))
