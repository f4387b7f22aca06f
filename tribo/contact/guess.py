"""Guesses of a contact's pressure: from coarser grids, and from the part of a grid that matters.

They need not be exact, since the contact is solved, and judged, on the whole grid. Both take the
solid's own map, restricted to fewer elements, so that they hold for whatever was added to it, as
wear.
"""

from __future__ import annotations

import math

import numpy as np

from tribo.contact.elasticity import ElasticHalfSpace
from tribo.contact.iteration import Limits, iterate
from tribo.contact.problem import Problem
from tribo.types import Array, Mask

__all__ = ["from_coarser_grids", "in_window"]


_COARSEST = 64**2  # elements of a grid on which a coarser one saves nothing
_COARSE_TOLERANCE, _COARSE_CONVOLUTIONS = 0.3, 100
_WINDOW = 0.6  # share of the grid below which a window is worth what it costs, two convolutions
_MARGIN = 2  # elements at least, on each side of those that carry load
_MULTIPLE = 8  # of elements along a window, for short transforms


def from_coarser_grids(
    solid: ElasticHalfSpace, heights: Array, total: float, hardness: float
) -> tuple[Array, float]:
    """Pressure of the contact of means over 2 × 2 elements, itself begun on a coarser grid.

    A block's elements get its pressure: more elements than will touch in the end, which the
    iteration sheds in fewer steps than it would take to find those that are missing.

    Parameters
    ----------
    solid, heights, total, hardness
        Those of `tribo.contact.problem.Problem`.

    Returns
    -------
    pressure : ndarray, shape (nx, ny)
        Guess of the pressure [Pa].
    work : float
        Convolutions that the guess took, each by its share of the elements.
    """
    if heights.size <= _COARSEST or any(n % 2 and n > 1 for n in heights.shape):
        return _springs(heights, total, hardness), 0.0
    (nx, ny), (fx, fy) = heights.shape, (min(n, 2) for n in heights.shape)
    blocks = fx * fy
    coarse, means = solid.coarsened(), heights.reshape(nx // fx, fx, ny // fy, fy).mean(axis=(1, 3))
    guess, work = from_coarser_grids(coarse, means, total / blocks, hardness)
    problem = Problem.of(coarse, means, total / blocks, hardness)
    found = iterate(problem, guess, Limits(_COARSE_TOLERANCE, _COARSE_CONVOLUTIONS), spent=work)
    pressure = found.pressure.repeat(fx, axis=0).repeat(fy, axis=1)
    return pressure, found.convolutions / blocks


def in_window(
    solid: ElasticHalfSpace,
    heights: Array,
    total: float,
    hardness: float,
    guess: Array,
    tolerance: float,
    max_convolutions: float,
) -> tuple[Array, float]:
    """Improve a guess on the part of the free axes that it loads, if that is small.

    Parameters
    ----------
    solid, heights, total, hardness, guess, tolerance, max_convolutions
        Those of `tribo.contact.problem.Problem` and `tribo.contact.iteration.Limits`.

    Returns
    -------
    pressure : ndarray, shape (nx, ny)
        Improved guess of the pressure [Pa]; 0 outside that part.
    work : float
        Convolutions that the improvement took, each by its share of the elements.
    """
    window = tuple(
        slice(0, n) if periodic else _extent(guess.max(axis=1 - axis) > 0)
        for axis, (n, periodic) in enumerate(zip(heights.shape, solid.grid.periodic, strict=True))
    )
    part = heights[window]
    if part.size >= _WINDOW * heights.size or total >= hardness * part.size:
        return guess, 0.0
    problem = Problem.of(solid.cropped(part.shape), part, total, hardness)
    found = iterate(problem, guess[window], Limits(tolerance, max_convolutions))
    pressure = np.zeros(heights.shape)
    pressure[window] = found.pressure
    return pressure, found.convolutions * part.size / heights.size


def _extent(loaded: Mask) -> slice:
    """The part of an axis from the first to the last loaded element, with a margin."""
    places = np.flatnonzero(loaded)
    if not places.size:
        return slice(0, loaded.size)
    first, last = int(places[0]), int(places[-1])
    size = math.ceil((last + 1 - first + 2 * _MARGIN) / _MULTIPLE) * _MULTIPLE
    start = max(0, (first + last + 1 - size) // 2)
    return slice(start, min(start + size, loaded.size))


def _springs(heights: Array, total: float, hardness: float) -> Array:
    """A bed of springs under the shape, its stiffness that of the load on its lowest tenth."""
    level = float(np.quantile(heights, 0.1))
    penetration = np.maximum(level - heights, 0.0)
    weight = float(penetration.sum())
    if weight == 0.0:
        return np.full(heights.shape, total / heights.size)
    return np.minimum(penetration * (total / weight), hardness)
