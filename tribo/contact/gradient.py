"""Projected gradient steps: slow, but each lowers the energy.

Steps have the length of Barzilai and Borwein and an exact line search (Birgin, Martínez & Raydan,
SIAM J. Optim. 10, 2000).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tribo.contact.problem import Evaluation, Iterate, Problem
from tribo.contact.simplex import nearest


class Gradient(NamedTuple):
    """State of the gradient steps: length of the next step, and number of consecutive failures.

    A step fails if it finds no lower energy.
    """

    length: float  # of the next step [Pa/m]; dimensionless if rows are soft
    failed_steps: int = 0  # consecutive steps that found no lower energy


def first_length(problem: Problem) -> float:
    """Length of the first gradient step: the decrease of pressure per unit gap [Pa/m].

    It is 1/d, where d is the displacement of an element by unit pressure on itself [m/Pa]. If steps
    use a `RowMetric`, which already converts the gap to a pressure, it is 1, without a unit.
    """
    return 1.0 if problem.soft.is_needed else 1 / problem.solid.self_influence


def gradient_step(
    problem: Problem, iterate: Iterate, evaluation: Evaluation, gradient: Gradient
) -> tuple[Iterate, Gradient]:
    """Move along the projected gradient to the lowest energy; return the iterate and the new state.

    `evaluation` has the gap and the nodes of the iterate, and `gradient` the state of the gradient
    steps. The displacement is updated along with the pressure instead of computed from it, which
    saves a convolution but loses digits. If no lower energy is found, neither changes.
    """
    pressure, nodes, gap = iterate.pressure, evaluation.nodes, evaluation.gap
    metric = problem.metric_on(nodes)
    if metric:
        old_pressure = pressure.take(nodes)
        target = old_pressure - gradient.length * metric.steepest_direction(gap.take(nodes))
        step = np.zeros(pressure.shape)
        step.reshape(-1)[nodes] = (
            problem.bounded_pressure(target, nodes, pressure, metric) - old_pressure
        )
    else:
        step = nearest(pressure - gradient.length * gap, problem.total, problem.hardness)
        step -= pressure
    response = problem.solid(step)
    counted = iterate._replace(convolutions=iterate.convolutions + 1, updates=iterate.updates + 1)
    curvature, slope = float((step * response).sum()), float((step * gap).sum())
    if not (curvature > 0 and slope < 0):
        return counted, Gradient(first_length(problem), gradient.failed_steps + 1)
    if metric:
        length = metric.square(step.take(nodes)) / curvature
    elif counted.convolutions % 2 < 1:  # alternate the two lengths of Barzilai and Borwein
        length = float((step * step).sum()) / curvature
    else:
        length = curvature / float((response * response).sum())
    fraction = min(1.0, -slope / curvature)
    step *= fraction
    step += pressure
    response *= fraction
    response += iterate.displacement
    return counted._replace(
        pressure=step.clip(0.0, problem.hardness, out=step), displacement=response
    ), Gradient(length)
