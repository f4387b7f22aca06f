"""The iteration that finds the pressure of a contact.

Two kinds of steps take turns. An *active-set step* (`active_set`) is fast near the solution, but
may cycle. A *projected gradient step* (`gradient`) is slower, but always lowers the energy. It
starts the iteration where much of the contact is still to change, and takes over for longer each
time that the active-set steps stop making progress. So the iteration converges from any start.
Where the elements of a row displace each other much, both kinds of steps use the metric of `rows`.
`problem` judges how far an iterate is from the solution, and `rounding` how many digits it has
lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tribo.contact.active_set import ActiveSet, active_set_step
from tribo.contact.correction import correct_guess
from tribo.contact.gradient import Gradient, first_length, gradient_step
from tribo.contact.problem import Iterate, Judgement, Problem, judge
from tribo.contact.rounding import LowestResidual, restore_digits, transform_error
from tribo.contact.simplex import scaled_to_load
from tribo.numerics import largest
from tribo.types import Array

_SETTLED = 0.3  # active-set steps start once at most this share of the nodes is at a wrong bound
_PATIENCE = 3  # active-set steps without progress before gradient steps take over
_FIRST_GRADIENT_STEPS = 8  # at the first such change; twice as many at each further one
_GOAL = 0.5  # share of the tolerance that active-set steps aim at


class Limits(NamedTuple):
    """When an iteration ends: at which error (`tolerance`), or after how many convolutions.

    The error is the residual of the contact, or the last change of the pressure if `by_change`.
    """

    tolerance: float  # largest error
    convolutions: float  # after which to give up, including the convolutions for the guess
    by_change: bool = False  # the error is the last change of the pressure, not the residual


@dataclass(frozen=True, slots=True, eq=False)
class IterationResult:
    """Last pressure of an iteration, its displacement and gap, and errors of gap and load."""

    pressure: Array  # [Pa]
    displacement: Array  # [m]
    gap: Array  # [m]
    approach: float  # distance of the bodies from the datum of the solid [m]
    residual: float  # in units of D_self·max(p), with the error of rounding
    error: float  # the residual, or the change of the pressure if the limits are by change
    load_error: float  # relative
    convolutions: float  # including the convolutions for the guess
    converged: bool
    stalled: bool  # the residual does not fall any further


class StepCounters(NamedTuple):
    """Counters that decide whether the next step is a gradient step or an active-set step."""

    gradient_steps: float = math.inf  # to be taken before the next active-set step
    next_gradient_steps: int = _FIRST_GRADIENT_STEPS  # when active-set steps next fail
    best: float = math.inf  # lowest residual since the kind of steps last changed
    without_progress: int = 0  # steps since the residual was lowest

    def updated(self, residual: float, has_settled: bool) -> StepCounters:
        """Return the counters after one more iterate, whose residual is `residual`.

        The iteration begins with gradient steps. They end once `has_settled` is True: then few
        nodes have zero pressure although the bodies overlap, or have the hardness as their pressure
        although the bodies are apart. Later, gradient steps take over again whenever the residual
        has not fallen by a tenth for three steps, each time twice as many.
        """
        steps, next_steps, best, waited = self
        if steps == math.inf and has_settled:
            steps = 0
        best, waited = (residual, 0) if residual < 0.9 * best else (best, waited + 1)
        if steps <= 0 and waited >= _PATIENCE:
            return StepCounters(next_steps, 2 * next_steps, residual, 0)
        return StepCounters(steps, next_steps, best, waited)


def iterate(
    problem: Problem,
    guess: Array,
    limits: Limits,
    displacement: Array | None = None,
    spent: float = 0.0,
) -> IterationResult:
    """Iterate from a guess of the pressure [Pa] until the error is small, or no longer falls.

    `limits` has the tolerance of the error and the most convolutions. The last iterate is returned,
    whether it has converged or not. `displacement` is caused by the guess [m]. If it is given, the
    guess has to carry the load, but may exceed the bounds. `spent` is the number of convolutions
    that the guess took.
    """
    state = _first_iterate(problem, guess, displacement, spent)
    counters, progress, change = StepCounters(), LowestResidual(), math.inf
    active, gradient = ActiveSet(), Gradient(first_length(problem))
    while True:
        judged = judge(problem, state)
        progress = progress.updated(judged.residual, state.convolutions)
        is_saturated = not judged.nodes.size  # all nodes in contact rightly carry the hardness
        stalled = is_saturated or progress.has_stalled(problem, state, judged, gradient.idle)
        exhausted = state.convolutions >= limits.convolutions or not math.isfinite(judged.residual)
        error, slack = judged.residual, limits.tolerance - judged.residual
        if limits.by_change:
            error, slack = change if judged.residual else 0.0, math.inf
        if error <= limits.tolerance or stalled or exhausted:
            better = restore_digits(problem, state, judged, slack, exhausted)
            if better is not None:
                if better.shifts > state.shifts:  # residuals from another datum do not compare
                    progress = progress._replace(lowest=math.inf)
                state = better
                continue
            judged = _add_rounding(problem, state, judged)
            error = error if limits.by_change else judged.residual
            converged = error <= limits.tolerance
            if converged or stalled or exhausted:
                return _outcome(problem, state, judged, error, converged, stalled)
        counters = counters.updated(judged.residual, judged.wrong <= _SETTLED * judged.touching)
        before = state.pressure
        if counters.gradient_steps > 0:
            state, gradient = gradient_step(problem, state, judged, gradient)
            counters = counters._replace(gradient_steps=counters.gradient_steps - 1)
        else:
            remaining = limits.convolutions - state.convolutions
            gap_goal = _GOAL * limits.tolerance * judged.unit
            state, active = active_set_step(problem, state, judged, active, gap_goal, remaining)
        if limits.by_change:
            change = float(np.abs(state.pressure - before).sum()) / problem.total


def _first_iterate(
    problem: Problem, guess: Array, displacement: Array | None, spent: float
) -> Iterate:
    """Scale a guess of the pressure [Pa] to the load, and move it into the bounds."""
    # Heights count from a datum near the contact: far from 0 they would have few digits.
    datum = float(problem.heights.min())
    separation = problem.heights - datum
    if displacement is not None:
        guess = correct_guess(problem, separation, guess, displacement)
    pressure = scaled_to_load(guess, problem.total, problem.hardness)
    return Iterate(pressure, problem.solid(pressure), datum, separation, spent + 1)


def _add_rounding(problem: Problem, state: Iterate, judged: Judgement) -> Judgement:
    """Copy of `judged` whose residual includes a bound on the rounding error of `state`."""
    hidden = transform_error(problem.solid.rounding, largest(state.displacement))
    return judged._replace(residual=judged.residual + hidden / judged.unit)


def _outcome(
    problem: Problem,
    state: Iterate,
    judged: Judgement,
    error: float,
    converged: bool,
    stalled: bool,
) -> IterationResult:
    return IterationResult(
        pressure=state.pressure,
        displacement=state.displacement,
        gap=judged.gap,
        approach=state.datum + judged.level,
        residual=judged.residual,
        error=error,
        load_error=state.load_error(problem.total),
        convolutions=state.convolutions,
        converged=converged,
        stalled=stalled,
    )
