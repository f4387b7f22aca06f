"""Active-set steps: conjugate gradients on the nodes that are free, then back into the bounds.

Polonsky & Keer (Wear 231, 1999) take one iteration of conjugate gradients per step. Several
iterations, preconditioned by a `stencil`, get farther. Near the solution that is fast, but the
steps may return to the same sets of free nodes again and again.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tribo.contact.problem import Evaluation, Iterate, Problem
from tribo.numerics import Preconditioner, largest
from tribo.types import Array, Nodes

Stencil = Callable[[Array, Array], Array]

# Conjugate gradient iterations in the first active-set step. Each further step may take twice as
# many as the step before. A step ends once the residual has fallen to the first fraction or, if the
# set of free nodes has not changed, to the second.
_INNER_ITERATIONS = 2
_INNER_REDUCTION, _FINAL_REDUCTION = 0.2, 1e-4


class ActiveSet(NamedTuple):
    """State of the active-set steps, which each solve for the pressure at the free nodes.

    It has the number of iterations that the next step may take, and the free nodes of the last
    step.
    """

    iterations: int = _INNER_ITERATIONS  # largest number of conjugate gradient iterations
    nodes: Nodes | None = None  # free nodes of the last step

    def reduction(self, nodes: Nodes) -> float:
        """Fraction of the first residual at which the next step may stop.

        It is smaller if `nodes`, the nodes that are free now, are those of the last step.
        """
        settled = self.nodes is not None and np.array_equal(nodes, self.nodes)
        return _FINAL_REDUCTION if settled else _INNER_REDUCTION


def active_set_step(
    problem: Problem,
    iterate: Iterate,
    evaluation: Evaluation,
    active_set: ActiveSet,
    gap_goal: float,
    max_convolutions: float,
) -> tuple[Iterate, ActiveSet]:
    """Solve for the pressure at the free nodes, while all other nodes stay at their bounds.

    `evaluation` has the free nodes and the gap of the iterate. `active_set` is the state that the
    last active-set step returned. Conjugate gradients stop once the gap at the free nodes is at
    most `gap_goal` [m] or a fraction of its first value, or after `max_convolutions` convolutions.
    Returns the next iterate, and the state for the next active-set step.
    """
    nodes = evaluation.nodes
    stencil = problem.neighbourhood.stencil_on(nodes)
    pressure, iterations = _conjugate_gradients(
        problem,
        iterate.pressure.take(nodes),
        evaluation,
        _preconditioner(problem, nodes, stencil),
        (active_set.reduction(nodes), gap_goal),
        int(min(active_set.iterations, max_convolutions)),
    )
    if pressure.min() < 0 or pressure.max() > problem.hardness:
        metric = problem.metric_on(nodes)
        if not metric:
            pressure = _clip(problem, pressure, stencil)
        pressure = problem.bounded_pressure(pressure, nodes, iterate.pressure, metric)
    full_pressure = iterate.pressure.copy()
    full_pressure.reshape(-1)[nodes] = pressure
    return iterate.pressed(problem, full_pressure, iterations), ActiveSet(
        2 * active_set.iterations, nodes
    )


def _conjugate_gradients(
    problem: Problem,
    pressure: Array,
    evaluation: Evaluation,
    precondition: Preconditioner,
    goals: tuple[float, float],
    max_iterations: int,
) -> tuple[Array, int]:
    """Unbounded pressure [Pa] that equalizes the gap at the free nodes, and iterations."""
    nodes, (reduction, gap_goal) = evaluation.nodes, goals
    residual = evaluation.gap.take(nodes)
    residual -= residual.mean()
    # Scaled by the first residual and by the stencil's middle, residuals and directions are of
    # order 1, which single precision can represent.
    scale = largest(residual) or 1.0
    residual /= scale
    goal = max(reduction, gap_goal / scale)
    direction, square = np.zeros(nodes.size), math.inf
    field = np.zeros(problem.heights.shape)
    response_field = np.empty(problem.heights.shape)
    ny = problem.heights.shape[1]
    rows = int(nodes[0]) // ny, int(nodes[-1]) // ny + 1
    iterations = 0
    while iterations < max_iterations:
        steepest = precondition(residual)
        previous, square = square, float((residual * steepest).sum())
        if not square > 0:
            break
        direction *= square / previous
        direction += steepest
        field.reshape(-1)[nodes] = direction
        problem.fast(field, out=response_field, rows=rows)
        iterations += 1
        response = response_field.take(nodes)
        response -= float(response.sum()) / response.size
        curvature = float((response * direction).sum())
        if not curvature > 0:  # the residual consists of rounding errors
            break
        step_length = square / curvature
        pressure -= scale * step_length * direction
        response *= step_length
        residual -= response
        if largest(residual) <= goal:
            break
    return pressure, iterations


def _preconditioner(problem: Problem, nodes: Nodes, stencil: Stencil) -> Preconditioner:
    middle = problem.neighbourhood.inverse[1, 0]
    inverse = functools.partial(stencil, problem.neighbourhood.inverse / middle)
    rows = problem.row_indices(nodes) if problem.coupling else nodes
    return Preconditioner(inverse, rows, problem.coupling * middle)


def _clip(problem: Problem, pressure: Array, stencil: Stencil) -> Array:
    """Clip the pressure [Pa], and correct free nodes to keep the displacement about the same."""
    clipped = pressure.clip(0.0, problem.hardness)
    is_free = (clipped > 0) & (clipped < problem.hardness)
    change = is_free * stencil(problem.neighbourhood.influence, clipped - pressure)
    # The corrected values may leave the bounds slightly.
    clipped -= is_free * stencil(problem.neighbourhood.inverse, change)
    return clipped
