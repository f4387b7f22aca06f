"""Correction of a guess whose displacement is known, without a convolution.

A guess that extrapolates earlier pressures is least accurate at nodes that enter or leave the
contact. These nodes affect their neighbours most, so that a stencil of the influences between
neighbours suffices for the correction.
"""

from __future__ import annotations

import numpy as np

from tribo.contact.problem import Problem, mean_approach
from tribo.contact.simplex import shifted_to_load
from tribo.types import Array

_LOCAL_STEPS = 2


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
