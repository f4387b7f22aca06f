"""The iteration that finds the pressure of a contact.

Two kinds of steps take turns. An *active-set step* (`active_set`) is fast near the solution, but
may cycle. A *projected gradient step* (`gradient`) is slower, but always lowers the energy. It
starts the iteration where much of the contact is still to change, and takes over for longer each
time that the active-set steps stop making progress. The iteration therefore converges from any
start. If the elements of a row displace each other much, both kinds of steps use the metric of
`soft_rows`. `problem` computes the error of an iterate, and `rounding` the digits that it has lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tribo.contact.active_set import ActiveSet, active_set_step
from tribo.contact.gradient import Gradient, first_length, gradient_step
from tribo.contact.problem import Evaluation, Iterate, Problem, evaluate, mean_approach
from tribo.contact.rounding import LowestResidual, restore_digits, transform_error
from tribo.contact.simplex import scaled_to_load, shifted_to_load
from tribo.numerics import largest
from tribo.types import Array

_SETTLED_SHARE = 0.3  # largest share of nodes at a wrong bound at which active-set steps start
_PATIENCE = 3  # active-set steps without progress before gradient steps take over
_FIRST_GRADIENT_STEPS = 8  # at the first such change, doubled at each further change
_GOAL_SHARE = 0.5  # share of the tolerance that active-set steps aim at
_LOCAL_STEPS = 2


class Limits(NamedTuple):
    """When an iteration ends: at which residual, or after how many convolutions."""

    tolerance: float  # largest residual
    convolutions: float  # after which to give up, including the convolutions for the guess


@dataclass(frozen=True, slots=True, eq=False)
class IterationResult:
    """Last pressure of an iteration, its displacement and gap, and errors of gap and load."""

    pressure: Array  # [Pa]
    displacement: Array  # [m]
    gap: Array  # [m]
    approach: float  # distance of the bodies from the datum of the solid [m]
    residual: float  # in units of D_self·max(p), with the error of rounding
    load_error: float  # relative
    convolutions: float  # including the convolutions for the guess
    converged: bool
    stalled: bool  # the residual does not fall any further


class StepCounters(NamedTuple):
    """Counters that decide whether the next step is a gradient step or an active-set step."""

    gradient_steps: float = math.inf  # to be taken before the next active-set step
    next_gradient_steps: int = _FIRST_GRADIENT_STEPS  # after the next failure of active-set steps
    best: float = math.inf  # lowest residual since the kind of steps last changed
    without_progress: int = 0  # steps since the residual was lowest

    def updated(self, residual: float, has_settled: bool) -> StepCounters:
        """Return the counters after one more iterate, whose residual is `residual`.

        The iteration begins with gradient steps. They end once `has_settled` is True: then few
        nodes have zero pressure although the bodies overlap, or have the hardness as their pressure
        although the bodies are apart. Later, gradient steps take over again whenever the residual
        has not fallen by a tenth for three steps, each time twice as many.
        """
        steps, next_steps, best, waiting_time = self
        if steps == math.inf and has_settled:
            steps = 0
        best, waiting_time = (residual, 0) if residual < 0.9 * best else (best, waiting_time + 1)
        if steps <= 0 and waiting_time >= _PATIENCE:
            return StepCounters(next_steps, 2 * next_steps, residual, 0)
        return StepCounters(steps, next_steps, best, waiting_time)


def iterate(
    problem: Problem,
    guess: Array,
    limits: Limits,
    displacement: Array | None = None,
    guess_cost: float = 0.0,
) -> IterationResult:
    """Iterate from a guess of the pressure [Pa] until the residual is small, or no longer falls.

    `limits` has the largest residual and the maximal number of convolutions. The last iterate
    is returned, whether it has converged or not. `displacement` is caused by the guess [m]. If it
    is given, the guess has to carry the load, but may exceed the bounds. `guess_cost` is the number
    of convolutions that the guess took.
    """
    state = _first_iterate(problem, guess, displacement, guess_cost)
    counters, progress = StepCounters(), LowestResidual()
    active_set, gradient = ActiveSet(), Gradient(first_length(problem))
    while True:
        evaluation = evaluate(problem, state)
        progress = progress.updated(evaluation.residual, state.convolutions)
        is_saturated = not evaluation.nodes.size  # all nodes in contact rightly carry the hardness
        stalled = is_saturated or progress.has_stalled(
            problem, state, evaluation, gradient.failed_steps
        )
        exhausted = state.convolutions >= limits.convolutions or not math.isfinite(
            evaluation.residual
        )
        slack = limits.tolerance - evaluation.residual
        if slack >= 0 or stalled or exhausted:
            restored = restore_digits(problem, state, evaluation, slack, exhausted)
            if restored is not None:
                if restored.shifts > state.shifts:  # residuals for another datum are not comparable
                    progress = progress._replace(lowest=math.inf)
                state = restored
                continue
            evaluation = _add_rounding(problem, state, evaluation)
            converged = evaluation.residual <= limits.tolerance
            if converged or stalled or exhausted:
                return _iteration_result(problem, state, evaluation, converged, stalled)
        counters = counters.updated(
            evaluation.residual, evaluation.at_wrong_bound <= _SETTLED_SHARE * evaluation.in_contact
        )
        if counters.gradient_steps > 0:
            state, gradient = gradient_step(problem, state, evaluation, gradient)
            counters = counters._replace(gradient_steps=counters.gradient_steps - 1)
        else:
            remaining = limits.convolutions - state.convolutions
            gap_goal = _GOAL_SHARE * limits.tolerance * evaluation.unit
            state, active_set = active_set_step(
                problem, state, evaluation, active_set, gap_goal, remaining
            )


def _first_iterate(
    problem: Problem, guess: Array, displacement: Array | None, guess_cost: float
) -> Iterate:
    """Scale a guess of the pressure [Pa] to the load, and move it into the bounds."""
    # Heights are relative to a datum near the contact, since large values would lose digits.
    datum = float(problem.heights.min())
    separation = problem.heights - datum
    if displacement is not None:
        guess = correct_guess(problem, separation, guess, displacement)
    pressure = scaled_to_load(guess, problem.total, problem.hardness)
    return Iterate(pressure, problem.solid(pressure), datum, separation, guess_cost + 1)


def _add_rounding(problem: Problem, state: Iterate, evaluation: Evaluation) -> Evaluation:
    """Copy of `evaluation` whose residual includes a bound on the rounding error of `state`."""
    rounding_error = transform_error(problem.solid.rounding, largest(state.displacement))
    return evaluation._replace(residual=evaluation.residual + rounding_error / evaluation.unit)


def _iteration_result(
    problem: Problem,
    state: Iterate,
    evaluation: Evaluation,
    converged: bool,
    stalled: bool,
) -> IterationResult:
    return IterationResult(
        pressure=state.pressure,
        displacement=state.displacement,
        gap=evaluation.gap,
        approach=state.datum + evaluation.level,
        residual=evaluation.residual,
        load_error=state.load_error(problem.total),
        convolutions=state.convolutions,
        converged=converged,
        stalled=stalled,
    )


def correct_guess(problem: Problem, separation: Array, guess: Array, displacement: Array) -> Array:
    """Improve a guess of the pressure [Pa] using only influences between neighbouring elements.

    `guess` causes the `displacement` [m], and carries the load. It may exceed the bounds, 0 and the
    hardness; the result carries the load within the bounds. `separation` is the distance of the
    undeformed surfaces [m].
    """
    neighbourhood, hardness = problem.neighbourhood, problem.hardness
    gap = displacement + separation
    loaded = guess > 0
    gap -= mean_approach(gap, loaded, np.flatnonzero(loaded & (guess < hardness)))
    nodes = np.flatnonzero((guess != 0) | (gap < 0))
    stencil = neighbourhood.stencil_on(nodes)
    known_pressure, known_gap = guess.take(nodes), gap.take(nodes)
    pressure = known_pressure.clip(0.0, hardness)
    for _ in range(_LOCAL_STEPS):
        gap = known_gap + stencil(neighbourhood.influence, pressure - known_pressure)
        loaded, elastic = pressure > 0, pressure < hardness
        free = loaded & elastic
        gap -= mean_approach(gap, loaded, np.flatnonzero(free))
        moving = free | (elastic & (gap < 0)) | (loaded & (gap > 0))
        gap -= float((gap * moving).sum()) / max(1, int(np.count_nonzero(moving)))
        change = moving * stencil(neighbourhood.inverse, moving * gap)
        pressure = shifted_to_load(pressure - change, problem.total, hardness)
    result = np.zeros(guess.shape)
    result.reshape(-1)[nodes] = pressure
    return result
