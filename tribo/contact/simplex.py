"""Pressures within bounds that carry a load: 0 ≤ p ≤ H and Σp = F/dA, the capped simplex."""

from __future__ import annotations

import math

import numpy as np

from tribo.types import Array

LOAD_ERROR = 1e-12
"""Relative error of the load up to which a pressure counts as carrying it."""

SMALLEST, LARGEST = 1e-280, 1e280
"""Range of the squares and products in the solver that double precision can hold."""

# Nodes that yield in a guess stay at the hardness if the guess is within this factor of the load.
_NEAR_RATIO = 2.0


def scaled_to_load(guess: Array, total: float, hardness: float) -> Array:
    """Scale a guess of the pressure to the sum `total` [Pa], within 0 and the hardness.

    What would exceed the hardness is spread evenly over the other loaded elements. If the loaded
    elements cannot carry the load, all elements share it.

    Examples
    --------
    >>> scaled_to_load(np.array([0.0, 1.0, 3.0]), total=8.0, hardness=5.0)
    array([0., 3., 5.])
    """
    largest, smallest = float(guess.max()), float(guess.min())
    is_bounded = smallest >= 0 and largest <= hardness
    if is_bounded and abs(float(guess.sum()) - total) <= 0.1 * LOAD_ERROR * total:
        return guess.copy()
    # Squares and products of such a guess would over- or underflow.
    if not SMALLEST**0.5 < largest < LARGEST**0.5:
        return nearest(np.zeros(guess.shape), total, hardness)
    pressure = guess.clip(0.0, hardness)
    loaded = pressure > 0
    if total >= hardness * np.count_nonzero(loaded):
        return nearest(pressure, total, hardness)
    # If the guess is near the load, nodes that yield in it are kept at the hardness.
    free = loaded & (pressure < hardness)
    free_sum = float(pressure[free].sum())
    free_load = total - (float(pressure.sum()) - free_sum)
    is_near = free_sum > 0 and 1 / _NEAR_RATIO < free_load / free_sum < _NEAR_RATIO
    if not (is_near and free_load < hardness * np.count_nonzero(free)):
        free, free_sum, free_load = loaded, float(pressure.sum()), total
    pressure[free] = nearest(free_load / free_sum * pressure[free], free_load, hardness)
    return pressure


def shifted_to_load(pressure: Array, total: float, hardness: float) -> Array:
    """Clip a pressure to 0 and the hardness, then shift the values in between evenly.

    The shift makes the sum `total` [Pa]. If these values cannot make up the sum, all values are
    shifted.

    Examples
    --------
    >>> shifted_to_load(np.array([-3.0, 1.0, 2.0]), total=4.0, hardness=5.0)
    array([0. , 1.5, 2.5])
    """
    clipped = pressure.clip(0.0, hardness)
    clipped_sum = float(clipped.sum())
    if abs(clipped_sum - total) <= 0.1 * LOAD_ERROR * total:
        return clipped
    free_nodes = np.flatnonzero((clipped > 0) & (clipped < hardness))
    free_values = clipped.take(free_nodes)
    free_load = total - clipped_sum + float(free_values.sum())
    if 0 < free_load < hardness * free_values.size:
        clipped.reshape(-1)[free_nodes] = nearest(free_values, free_load, hardness)
        return clipped
    return nearest(pressure, total, hardness)


def nearest(pressure: Array, total: float, hardness: float) -> Array:
    """Pressure within 0 and the hardness, with the sum `total`, that is nearest to `pressure` [Pa].

    It is clip(p + s), with the given pressure p and one shift s for all elements.

    Examples
    --------
    >>> nearest(np.array([-3.0, 1.0, 6.0]), total=8.0, hardness=5.0)
    array([0., 3., 5.])
    """
    for _ in range(3):
        field, shift = _shift_and_clip(pressure, total, hardness)
        if abs(float(field.sum()) - total) <= 0.1 * LOAD_ERROR * total:
            break
        pressure = pressure + shift  # continuing from the shifted field gains digits
    return field


def _shift_and_clip(pressure: Array, total: float, hardness: float) -> tuple[Array, float]:
    """Find s so that clip(p + s), to 0 and the hardness, sums to `total`; return both [Pa]."""
    bound = total if hardness == math.inf else hardness
    low = -float(pressure.max())
    high = bound - float(pressure.min())
    shift = 0.0 if low <= 0 <= high else (low + high) / 2
    field = np.empty(pressure.shape)
    # The sum is a continuous, piecewise linear, growing function of s. Newton's method finds its
    # root in a few steps, with bisection wherever a step would leave the bracket.
    for _ in range(200):
        np.add(pressure, shift, out=field)
        field.clip(0.0, hardness, out=field)
        excess = float(field.sum()) - total
        if abs(excess) <= 1e-14 * total or low >= high:
            break
        if excess > 0:
            high = shift
        else:
            low = shift
        free_count = np.count_nonzero((field > 0) & (field < hardness))
        next_shift = shift - excess / free_count if free_count else (low + high) / 2
        if not low < next_shift < high:
            next_shift = (low + high) / 2
        if next_shift == shift:
            break
        shift = next_shift
    return field, shift
