"""Rounding in an iteration: digits lost, digits that can be restored, and when to give up.

Gradient steps update the displacement along with the pressure, which costs digits. Before a result
is returned, that loss has to be within the tolerance, or the displacement is computed anew.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tribo.contact.problem import Iterate, Judgement, Problem
from tribo.contact.simplex import LOAD_ERROR, scaled_to_load
from tribo.numerics import largest

# Largest error of an updated displacement, fixed and per update, in rounding errors of its largest
# value. Observed: 8 for all updates of a solution together, 70 where it began far off.
_UPDATE_ERROR, _ERROR_PER_UPDATE = 100.0, 10.0
_AT_ROUNDING = 32.0  # in the same unit, a residual that rounding keeps from falling further
_TRANSFORM_ERROR = 3.0  # in the same unit, the error of a displacement just computed; observed: 2
_STALLED = 40  # iterations without progress at the level of rounding after which to give up
_MOST_WAITED, _MOST_IDLE = 1000, 20  # iterations without progress; gradient steps that fail
_FARTHEST_DATUM = 4.0  # datum to surface, in largest displacements: beyond, heights lose digits
_MOST_SHIFTS = 3  # moves of the datum; one is enough unless heights have no digits left


def update_error(updates: int, rounding: float, displacement: float) -> float:
    """Bound on the rounding error of a displacement [m] that was updated, not recomputed.

    `updates` is the number of updates, `displacement` the largest displacement [m], and `rounding`
    the machine epsilon.
    """
    return (_UPDATE_ERROR + _ERROR_PER_UPDATE * updates) * rounding * displacement


def transform_error(rounding: float, displacement: float) -> float:
    """Bound on the rounding error of a displacement [m] that one convolution has computed.

    `displacement` is the largest displacement [m], and `rounding` the machine epsilon.
    """
    return _TRANSFORM_ERROR * rounding * displacement


def restore_digits(
    problem: Problem, iterate: Iterate, judged: Judgement, slack: float, exhausted: bool
) -> Iterate | None:
    """Return an iterate with smaller rounding errors, or None if they are small enough.

    `judged` is the judgement of the iterate. One thing is repaired in each call: the zero level of
    the gap (datum), the load or the displacement. `slack` is the tolerance minus the residual. If
    `exhausted`, the iteration must end, and no convolution is spent on the load.
    """
    displacement = largest(iterate.displacement)
    is_far = abs(judged.level) > _FARTHEST_DATUM * (displacement + judged.unit)
    if is_far and iterate.shifts < _MOST_SHIFTS:
        datum = iterate.datum + judged.level
        separation = problem.heights - datum
        return iterate._replace(datum=datum, separation=separation, shifts=iterate.shifts + 1)
    if not exhausted and iterate.load_error(problem.total) > LOAD_ERROR:
        pressure = scaled_to_load(iterate.pressure, problem.total, problem.hardness)
        return iterate.pressed(problem, pressure)
    error = update_error(iterate.updates, problem.solid.rounding, displacement)
    # Not `error > …`: a displacement that is no number is computed again, too.
    if iterate.updates and not error <= slack * judged.unit:
        return iterate.pressed(problem, iterate.pressure)
    return None


class LowestResidual(NamedTuple):
    """The lowest residual so far, and the convolutions spent until then."""

    lowest: float = math.inf
    convolutions: float = 0.0  # spent until it was reached

    def updated(self, residual: float, convolutions: float) -> LowestResidual:
        """The lowest residual after one more iterate, and the convolutions spent until then.

        `residual` and `convolutions` are those of the new iterate. They replace the old values if
        the new residual is lower by more than a tenth.
        """
        return LowestResidual(residual, convolutions) if residual < 0.9 * self.lowest else self

    def has_stalled(self, problem: Problem, iterate: Iterate, judged: Judgement, idle: int) -> bool:
        """True if the residual no longer falls, so that the iteration should end.

        `iterate` is the last iterate, and `judged` has its residual. `idle` is the number of
        gradient steps in a row that failed.
        """
        waited = iterate.convolutions - self.convolutions
        if waited <= _STALLED:
            return False
        size = largest(iterate.displacement) + abs(judged.level)
        at_rounding = self.lowest * judged.unit <= _AT_ROUNDING * problem.solid.rounding * size
        return at_rounding or waited > _MOST_WAITED or idle > _MOST_IDLE
