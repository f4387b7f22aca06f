"""Pairs of load and velocity in a field: how they lie between its loads, and its values there."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.answers.pchip import Pchip
from pipeline.constants import RISE_EXPONENT
from tribo.types import Array, Indices, Mask

if TYPE_CHECKING:
    from pipeline.answers.field import Field


@dataclass(frozen=True, eq=False)
class FieldPoints:
    """k pairs of load and velocity in a field, and how they lie between its loads."""

    field: Field
    loads: Array
    velocities: Array

    @functools.cached_property
    def is_known(self) -> Mask:
        """True for each pair that is a known point (k,)."""
        axes, pairs = (self.field.loads, self.field.velocities), (self.loads, self.velocities)
        i, j = (
            np.minimum(np.searchsorted(axis, at), len(axis) - 1)
            for axis, at in zip(axes, pairs, strict=True)
        )
        is_on_grid = (axes[0][i] == self.loads) & (axes[1][j] == self.velocities)
        return np.asarray(is_on_grid & self.field.is_known[i, j])

    @functools.cached_property
    def rows(self) -> Indices:
        """Indices of the loads below and above each pair (2, k).

        Both are equal at a load with a curve, and at a known point. A load with a single known
        point has no value at other velocities, and does not bracket them.
        """
        loads, rows = self.field.loads, self.field.curve_rows
        candidates = rows if rows.size else np.arange(len(loads))
        upper = np.searchsorted(loads[candidates], self.loads)
        high = candidates[np.minimum(upper, len(candidates) - 1)]
        low = np.where(loads[high] == self.loads, high, candidates[np.maximum(upper - 1, 0)])
        exact = np.minimum(np.searchsorted(loads, self.loads), len(loads) - 1)
        return np.stack([np.where(self.is_known, exact, low), np.where(self.is_known, exact, high)])

    @functools.cached_property
    def weights(self) -> Array:
        """Weights of the loads below and above (2, k), linear in ln(load)."""
        low, high = self.field.loads[self.rows]
        with np.errstate(invalid="ignore", divide="ignore"):
            fraction = np.where(high > low, np.log(self.loads / low) / np.log(high / low), 0.0)
        return np.stack([1 - fraction, fraction])

    @functools.cached_property
    def row_velocities(self) -> Array:
        """Velocities (n_load, k) at which loads have about the rise of each pair.

        They stay within the known velocities of the bracketing loads, if those of the pairs do.
        """
        field, velocities = self.field, self.velocities
        rows, x, known_x = field.curve_rows, np.log(self.loads), np.log(field.loads)
        if rows.size < 2:
            return np.broadcast_to(velocities, (len(field.loads), len(velocities)))
        low, high = self.rows
        first, last = field.velocity_limits
        with np.errstate(divide="ignore", invalid="ignore"):
            max_slant = np.fmin(
                np.log(last[low] / velocities) / (x - known_x[low]),
                np.log(velocities / first[high]) / (known_x[high] - x),
            )
        gap = np.clip(np.searchsorted(rows, low), 0, len(rows) - 2)
        slant = np.clip(field.level_slants[gap], 0.0, np.maximum(np.nan_to_num(max_slant), 0.0))
        return np.asarray(velocities * np.exp(slant * (x - known_x[:, None])))

    @functools.cached_property
    def is_extrapolated(self) -> Mask:
        """True for each pair (k,) beyond the known velocities of a bracketing load."""
        (first, last), pairs = self.field.velocity_limits, np.arange(len(self.loads))
        at_rows = self.row_velocities[self.rows, pairs]
        is_inside = (first[self.rows] <= at_rows) & (at_rows <= last[self.rows])
        return np.asarray(~is_inside.all(axis=0))

    @functools.cached_property
    def row_values(self) -> Array:
        """Values of each load at its `row_velocities` (n_load, k), for interpolation over ln(load).

        A usual exponent moves them to the velocities of the pairs, so that they increase with
        load: a monotone cubic would be flat about an extremum.
        """
        values = np.full(self.row_velocities.shape, np.nan)
        for rows, curves in self.field.curves:
            values[rows] = curves.beyond(np.log(self.row_velocities[rows]).T).T
        return values + RISE_EXPONENT * np.log(self.velocities / self.row_velocities)

    @functools.cached_property
    def values(self) -> Array:
        """Values of the field (k,); NaN outside its loads."""
        values = np.full(self.loads.shape, np.nan)
        for known, pairs in group_equal_rows(np.isfinite(self.row_values).T):
            if known.any():
                x, pair_loads = self.field.loads[known], self.loads[pairs]
                curves = Pchip(np.log(x), self.row_values[np.ix_(known, pairs)])
                inside = (x[0] <= pair_loads) & (pair_loads <= x[-1])
                interpolated = curves.at(np.log(pair_loads), np.arange(len(pairs)))
                values[pairs] = np.where(inside, interpolated, np.nan)
        return values

    def bilinear(self, values: Array) -> Array:
        """Interpolate `values` (n_load, n_velocity) linearly in ln(velocity), then in ln(load).

        Beyond its known velocities a load has its outermost value. Error bounds at the points thus
        remain bounds between them, and are continuous.
        """
        return np.asarray(self.weighted_sides(values).sum(axis=0))

    def weighted_sides(self, values: Array) -> Array:
        """Summands (2, k) of `bilinear` from the loads below and above."""
        columns, column_weights = self._columns
        corners = _weighted(column_weights, values[self.rows, columns]).sum(axis=0)
        is_known = np.isfinite(self.field.velocity_limits[0][self.rows])
        return _weighted(self.weights, np.where(is_known, corners, np.nan))

    @functools.cached_property
    def _columns(self) -> tuple[Indices, Array]:
        """Known velocities below and above each pair on its two loads, and weights (2, 2, k)."""
        columns = np.zeros((2, *self.rows.shape), int)
        weights = np.zeros(columns.shape)
        for row in np.unique(self.rows).tolist():
            known = np.flatnonzero(self.field.is_known[row])
            if known.size:
                side, pairs = np.nonzero(self.rows == row)
                nodes = np.log(self.field.velocities[known])
                x = np.log(self.row_velocities[row, pairs])
                i = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, max(len(nodes) - 2, 0))
                j = np.minimum(i + 1, len(nodes) - 1)
                spacing = nodes[j] - nodes[i]
                fraction = np.divide(
                    x - nodes[i], spacing, out=np.zeros(x.shape), where=spacing > 0
                )
                fraction = np.clip(fraction, 0, 1)
                columns[:, side, pairs] = known[i], known[j]
                weights[:, side, pairs] = 1 - fraction, fraction
        return columns, weights


def group_equal_rows(known: Mask) -> list[tuple[Mask, Indices]]:
    """Group equal rows of a mask: each distinct row, with the indices of the rows equal to it."""
    if not len(known):
        return []
    if known.all():
        return [(known[0], np.arange(len(known)))]
    patterns, inverse = np.unique(known, axis=0, return_inverse=True)
    return [
        (pattern, np.flatnonzero(inverse.ravel() == index))
        for index, pattern in enumerate(patterns)
    ]


def _weighted(weights: Array, values: Array) -> Array:
    """Product of weights and values; 0 where the weight is 0, even if the value is NaN."""
    return np.where(weights > 0, weights * values, 0.0)
