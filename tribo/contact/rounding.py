"""Rounding in an iteration: digits lost, digits that can be restored, and when to give up.

Gradient steps update the displacement along with the pressure, which costs digits. Before a result
is returned, this loss has to be within the tolerance, or the displacement is recomputed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tribo.contact.problem import Evaluation, Iterate, Problem
from tribo.contact.simplex import LOAD_ERROR, scaled_to_load
from tribo.numerics import largest

# Largest error of an updated displacement, fixed and per update, in rounding errors of its largest
# value. Observed: 8 for all updates of a solution together, 70 where it began far off.
_UPDATE_ERROR, _ERROR_PER_UPDATE = 100.0, 10.0
_AT_ROUNDING = 32.0  # in the same unit, the residual that rounding allows
_TRANSFORM_ERROR = 3.0  # in the same unit, the error of a displacement just computed; observed: 2
_STALL_TIME = 40  # iterations without progress after which to stop at the level of rounding
_MAX_WAITING_TIME = 1000  # iterations without progress
_MAX_FAILED_STEPS = 20  # consecutive gradient steps without progress
_MAX_DATUM_DISTANCE = 4.0  # datum to surface, in largest displacements: beyond, heights lose digits
_MAX_SHIFTS = 3  # moves of the datum; one is enough unless heights have no digits left


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
    problem: Problem, iterate: Iterate, evaluation: Evaluation, slack: float, exhausted: bool
) -> Iterate | None:
    """Return an iterate with smaller rounding errors, or None if they are small enough.

    `evaluation` is that of the iterate. Each call repairs one property: the zero level of the gap
    (datum), the load or the displacement. `slack` is the tolerance minus the residual. If
    `exhausted`, the iteration must end, and no convolution is spent on the load.
    """
    displacement = largest(iterate.displacement)
    is_far = abs(evaluation.level) > _MAX_DATUM_DISTANCE * (displacement + evaluation.unit)
    if is_far and iterate.shifts < _MAX_SHIFTS:
        datum = iterate.datum + evaluation.level
        separation = problem.heights - datum
        return iterate._replace(datum=datum, separation=separation, shifts=iterate.shifts + 1)
    if not exhausted and iterate.load_error(problem.total) > LOAD_ERROR:
        pressure = scaled_to_load(iterate.pressure, problem.total, problem.hardness)
        return iterate.pressed(problem, pressure)
    error = update_error(iterate.updates, problem.solid.rounding, displacement)
    # `not error <= …` also recomputes a displacement that is NaN.
    if iterate.updates and not error <= slack * evaluation.unit:
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

    def has_stalled(
        self, problem: Problem, iterate: Iterate, evaluation: Evaluation, failed_steps: int
    ) -> bool:
        """True if the residual no longer falls, so that the iteration should end.

        `iterate` is the last iterate, and `evaluation` has its residual. `failed_steps` is the
        number of gradient steps in a row that failed.
        """
        waiting_time = iterate.convolutions - self.convolutions
        if waiting_time <= _STALL_TIME:
            return False
        scale = largest(iterate.displacement) + abs(evaluation.level)
        at_rounding = self.lowest * evaluation.unit <= _AT_ROUNDING * problem.solid.rounding * scale
        return at_rounding or waiting_time > _MAX_WAITING_TIME or failed_steps > _MAX_FAILED_STEPS
