"""Guesses of a contact's pressure: from coarser grids, and from the loaded part of the grid.

The guesses need not be exact, since the contact is then solved on the whole grid. Both restrict the
solid's map from pressure to displacement to fewer elements, and so include what was added to this
map, such as wear.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from tribo.contact.elasticity import ElasticHalfSpace
from tribo.contact.iteration import Limits, iterate
from tribo.contact.problem import Problem
from tribo.types import Array, Mask

_MAX_COARSE_SIZE = 64**2  # number of elements up to which a coarser grid saves no time
_COARSE_TOLERANCE, _COARSE_CONVOLUTIONS = 0.3, 100
_MAX_WINDOW_SHARE = 0.6  # share of the grid up to which a window saves time
_MARGIN = 2  # least number of elements on each side of the loaded elements
_SIZE_MULTIPLE = 8  # divisor of a window's sides, for fast transforms


def coarser_guess(problem: Problem) -> tuple[Array, float]:
    """Guess the pressure [Pa] by solving the contact on a grid of blocks of 2 × 2 elements.

    The contact of blocks is itself guessed from a coarser grid. Elements of the coarsest grid are
    taken as independent springs: a grid of few elements, or with an odd number along an axis. All
    elements of a block get the block's pressure, so that too many are loaded: the iteration drops
    surplus elements in fewer steps than it finds missing ones. Returns the guess and its cost in
    convolutions. A convolution on a coarser grid counts as a fraction, by the number of elements.
    """
    heights = problem.heights
    if heights.size <= _MAX_COARSE_SIZE or any(n % 2 and n > 1 for n in heights.shape):
        return _spring_pressure(heights, problem.total, problem.hardness), 0.0
    fx, fy = (min(n, 2) for n in heights.shape)
    blocks = fx * fy
    means = heights if fy == 1 else heights[:, ::2] + heights[:, 1::2]
    means = (means if fx == 1 else means[::2] + means[1::2]) / blocks
    solid, total = problem.solid.coarsened(), problem.total / blocks
    coarse = Problem.from_solid(solid, means, total, problem.hardness)
    guess, cost = coarser_guess(coarse)
    result = iterate(
        coarse, guess, Limits(_COARSE_TOLERANCE, _COARSE_CONVOLUTIONS), guess_cost=cost
    )
    pressure = result.pressure.repeat(fx, axis=0).repeat(fy, axis=1)
    return pressure, result.convolutions / blocks


def window_guess(problem: Problem, guess: Array, limits: Limits) -> tuple[Array, float]:
    """Improve a guess of the pressure [Pa] by solving the contact on the loaded part of the grid.

    The part is a rectangle around the elements that the guess loads. Along periodic axes it has all
    elements. `limits` end the iteration on the part. Returns the better guess, which is 0 outside
    the part, and its cost in convolutions on the whole grid. A convolution on the part counts as a
    fraction, by the number of elements. If the part is not much smaller than the grid, or cannot
    carry the load, the guess is returned unchanged.
    """
    heights, total, hardness = problem.heights, problem.total, problem.hardness
    axes = zip(heights.shape, problem.solid.grid.periodic, strict=True)
    window = tuple(
        slice(0, n) if periodic else _loaded_extent(guess.max(axis=1 - axis) > 0)
        for axis, (n, periodic) in enumerate(axes)
    )
    part = heights[window]
    if part.size >= _MAX_WINDOW_SHARE * heights.size or total >= hardness * part.size:
        return guess, 0.0
    cropped = Problem.from_solid(_cropped_solid(problem.solid, part.shape), part, total, hardness)
    result = iterate(cropped, guess[window], limits)
    pressure = np.zeros(heights.shape)
    pressure[window] = result.pressure
    return pressure, result.convolutions * part.size / heights.size


@functools.lru_cache(maxsize=2)  # contacts at all positions of the disk share a solid
def _cropped_solid(solid: ElasticHalfSpace, shape: tuple[int, int]) -> ElasticHalfSpace:
    return solid.cropped(shape)


def _loaded_extent(loaded: Mask) -> slice:
    """Slice of an axis with all loaded elements and a margin; the whole axis if there are none."""
    loaded_indices = np.flatnonzero(loaded)
    if not loaded_indices.size:
        return slice(0, loaded.size)
    first, last = int(loaded_indices[0]), int(loaded_indices[-1])
    size = math.ceil((last + 1 - first + 2 * _MARGIN) / _SIZE_MULTIPLE) * _SIZE_MULTIPLE
    start = max(0, (first + last + 1 - size) // 2)
    return slice(start, min(start + size, loaded.size))


def _spring_pressure(heights: Array, total: float, hardness: float) -> Array:
    """Pressure [Pa] if elements were independent springs, and a tenth of them carried the load."""
    level = float(np.quantile(heights, 0.1))
    penetration = np.maximum(level - heights, 0.0)
    weight = float(penetration.sum())
    if weight == 0.0:
        return np.full(heights.shape, total / heights.size)
    return np.minimum(penetration * (total / weight), hardness)
