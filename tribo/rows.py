"""The metric in which pressure is measured where swept wear is much softer than the half-space.

Swept wear yields to the mean pressure of a row along y alone: it adds c·⟨p⟩_y to the displacement.
With c a million times the compliance of an element, plain gradients point almost nowhere but at
the rows' means. In the metric

    M = d·I + (c/ny) Σᵢ 1ᵢ1ᵢᵀ,    1ᵢ the nodes of row i,                                       (1)

with d the compliance of an element, the operator is as well conditioned as without wear. M is
inverted row by row (Sherman & Morrison), and the nearest pressure within bounds is found for all
rows at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["RowMetric"]

Array = NDArray[np.float64]

_ROUNDING = 1e-14
_MOST_STEPS = 200  # of a root finder that halves its bracket at the latest every second step


class RowMetric:
    """The metric of Eq. (1) for fields of a given shape.

    Parameters
    ----------
    compliance : float
        d [m/Pa].
    row_compliance : float
        c [m/Pa].
    shape : tuple of int
        ``(nx, ny)``.

    Examples
    --------
    >>> metric = RowMetric(compliance=1.0, row_compliance=4.0, shape=(1, 2))
    >>> metric.square(np.array([[1.0, 3.0]]))
    42.0
    >>> metric.raised(np.array([[1.0 + 2 * 4, 3.0 + 2 * 4]]))
    array([[1., 3.]])
    """

    def __init__(self, compliance: float, row_compliance: float, shape: tuple[int, int]) -> None:
        self._d, self._k = compliance, row_compliance / shape[1]
        self._shape = shape

    def square(self, step: Array) -> float:
        """StepᵀM step of a field."""
        rows = step.sum(axis=1)
        return self._d * float(np.sum(step * step)) + self._k * float(np.sum(rows * rows))

    def raised(self, gradient: Array) -> Array:
        """M⁻¹ gradient of a field: the direction in which the energy falls fastest."""
        mean = gradient.mean(axis=1, keepdims=True)
        softened = mean / (self._d + self._k * self._shape[1])
        direction: Array = (gradient - mean) / self._d + softened
        return direction

    def balanced(self, gradient: Array, nodes: NDArray[np.intp]) -> Array:
        """The same on some `nodes` alone, given by their flat index, and at constant load.

        That is M⁻¹(gradient − μ) with the μ for which it sums to 0.
        """
        rows = nodes // self._shape[1]
        count = np.bincount(rows, minlength=self._shape[0])
        softness = 1 / (self._d + self._k * count)
        mean = np.bincount(rows, gradient, minlength=self._shape[0]) / np.maximum(count, 1)
        direction = (gradient - mean[rows]) / self._d + (softness * mean)[rows]
        excess = float(np.sum(count * softness * mean)) / float(np.sum(count * softness))
        direction -= excess * softness[rows]
        return direction

    def nearest(self, field: Array, total: float, highest: float) -> Array:
        """The field nearest to `field` that sums to `total` and lies between 0 and `highest`.

        Within row i it is clip(q + sᵢ), q being the given field, with

            d·sᵢ + (c/ny)(Σ clip(q + sᵢ) − Σ q) = μ                                           (2)

        for every row. The left-hand side grows with sᵢ, and the sum of all with μ: one root inside
        another, each by Newton's method in a bracket.
        """
        q, top = field, min(highest, total)
        sums = q.sum(axis=1)
        reach = self._d * (top + float(np.abs(q).max()))
        reach += self._k * (float(np.abs(sums).max()) + self._shape[1] * top)
        low, high, mu = -reach, reach, 0.0
        shift = np.zeros(len(q))
        for _ in range(_MOST_STEPS):
            nearest, shift, moving = self._rows_at(mu, q, sums, shift, highest, top)
            excess = float(nearest.sum()) - total
            if abs(excess) <= 10 * _ROUNDING * total:
                break
            low, high = (low, mu) if excess > 0 else (mu, high)
            slope = float(np.sum(moving / (self._d + self._k * moving)))
            following = mu - excess / slope if slope else low
            if not low < following < high:
                following = (low + high) / 2
            if following == mu:
                break
            mu = following
        return nearest

    def _rows_at(
        self, mu: float, q: Array, sums: Array, shift: Array, highest: float, top: float
    ) -> tuple[Array, Array, NDArray[np.intp]]:
        """Solve Eq. (2) for every row: clip(q + s), s, and how many nodes are between the bounds.

        Where there is no root, all nodes of the row are at one bound, whatever s.
        """
        d, k = self._d, self._k
        low = np.full(shift.shape, -float(q.max()))
        high = np.full(shift.shape, top - float(q.min()))
        for _ in range(_MOST_STEPS):
            clipped = q + shift[:, None]
            moving = np.count_nonzero((clipped > 0) & (clipped < highest), axis=1)
            np.clip(clipped, 0.0, highest, out=clipped)
            carried = clipped.sum(axis=1)
            excess = d * shift + k * (carried - sums) - mu
            size = d * np.abs(shift) + k * (carried + np.abs(sums)) + abs(mu)
            over = excess > 0
            low, high = np.where(over, low, shift), np.where(over, shift, high)
            following = shift - excess / (d + k * moving)
            inside = (low < following) & (following < high)
            following = np.where(inside, following, (low + high) / 2)
            following = np.where(np.abs(excess) <= _ROUNDING * size, shift, following)
            if np.array_equal(following, shift):
                break
            shift = following
        return clipped, shift, moving
