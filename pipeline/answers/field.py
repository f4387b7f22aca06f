"""ln(rise) of a specimen over load and velocity, by which all answers are computed.

The rise is that of the governing temperature, per unit friction coefficient [K]. Wear is severe if
it exceeds the allowable rise, (critical − bulk temperature)/friction. Answers use y = ln(rise
ratio), which is above 0 for severe wear.

Between points ln(rise) is interpolated by PCHIP, over ln(velocity) at each load, then over ln(load)
along a line on which the rise hardly changes, as along a boundary. So between two loads it rests on
the points near their own crossings. Beyond the velocities of a load it continues with the last
slope.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from pipeline.answers.case_results import CaseResults
from pipeline.answers.pchip import Pchip, roots
from pipeline.constants import MAX_SLANT, MIN_SLOPE, PARTS_OF_INTERVAL, RISE_EXPONENT
from tribo.simulation.film import film_excess
from tribo.types import Array, Indices, Mask

_NO_FILM = -50.0  # smallest ln(pressure over that of a fifth of the load)
_BEYOND_PARTS = 64  # nodes of a line beyond the computed velocities, on either side


@dataclass(frozen=True, eq=False)
class Field:
    """A quantity over load and velocity, known at points (n_load, n_velocity), else NaN."""

    loads: Array
    velocities: Array
    plane: Array

    @functools.cached_property
    def is_known(self) -> Mask:
        """True at known points."""
        return np.isfinite(self.plane)

    @functools.cached_property
    def velocity_limits(self) -> tuple[Array, Array]:
        """Lowest and highest known velocity of each load (n_load,); NaN without a known point."""
        is_known, x = self.is_known, self.velocities
        first, last = x[is_known.argmax(axis=1)], x[::-1][is_known[:, ::-1].argmax(axis=1)]
        is_unknown = ~is_known.any(axis=1)
        return np.where(is_unknown, np.nan, first), np.where(is_unknown, np.nan, last)

    @functools.cached_property
    def curve_rows(self) -> Indices:
        """Indices of loads with at least two known points, whose curves extend beyond these."""
        return np.flatnonzero(self.is_known.sum(axis=1) > 1)

    @functools.cached_property
    def interpolated_rows(self) -> Indices:
        """Indices of loads between which values have an error; at one velocity all known loads."""
        return self.curve_rows if len(self.velocities) > 1 else np.flatnonzero(self.is_known[:, 0])

    @functools.cached_property
    def curves(self) -> list[tuple[Indices, Pchip]]:
        """Curves over ln(velocity) of loads known at the same velocities."""
        return [
            (rows, Pchip(np.log(self.velocities[known]), self.plane[np.ix_(rows, known)].T))
            for known, rows in _group_equal_rows(self.is_known)
            if known.any()
        ]

    def rows(self, velocities: Array) -> Array:
        """Values at each load and each of `velocities` (n_load, m).

        A load with a single known point has a value at this point only.
        """
        values = np.full((len(self.loads), len(velocities)), np.nan)
        for rows, curves in self.curves:
            values[rows] = curves.beyond(np.log(velocities)[:, None]).T
        return values

    @functools.cached_property
    def level_slants(self) -> Array:
        """Exponents of velocity over 1/load at a constant rise, between `curve_rows`."""
        rows, x = self.curve_rows, np.log(self.velocities)
        fits, middles = [], []
        for is_known, y in zip(self.is_known[rows], self.plane[rows], strict=True):
            middles.append(x[is_known].mean())
            fits.append(np.polyfit(x[is_known] - middles[-1], y[is_known], 1))
        slopes, levels = np.transpose(fits)
        slope = np.maximum((slopes[1:] + slopes[:-1]) / 2, MIN_SLOPE)
        fall = np.diff(levels) / slope - np.diff(middles)
        return np.asarray(np.clip(fall / np.diff(np.log(self.loads[rows])), 0.0, MAX_SLANT))

    def places(self, loads: Array, velocities: Array) -> Places:
        """Where k pairs of load and velocity lie in the field."""
        return Places(self, loads, velocities)

    def __call__(self, loads: Array, velocities: Array) -> Array:
        """Values at k pairs of load and velocity; NaN outside the loads."""
        return self.places(loads, velocities).values

    def grid(self, loads: Array, velocities: Array) -> Array:
        """Values at each of k loads and m velocities (k, m); NaN outside the loads."""
        pairs = np.repeat(loads, len(velocities)), np.tile(velocities, len(loads))
        return self(*pairs).reshape(len(loads), len(velocities))

    # Lines through the field, and where they cross a level

    def along_velocity(self, loads: Array, levels: Array, reach: float = 1.0) -> Lines:
        """Lines along velocity at `loads` (k,), and where they cross `levels` (k,).

        A line ends where the verdict at a bracketing load is uncertain. With a `reach` above 1 it
        extends by this factor beyond all velocities.
        """
        x = self.velocities
        parts = 1 if np.isin(loads, self.loads).all() else PARTS_OF_INTERVAL
        inner = x[:-1, None] + np.diff(x)[:, None] * np.arange(parts) / parts
        factors = np.geomspace(1.0, reach, _BEYOND_PARTS if reach > 1 else 1)[1:]
        nodes = np.concatenate([x[0] / factors[::-1], inner.ravel(), x[-1:], x[-1] * factors])
        nodes[np.searchsorted(nodes, x)] = x  # exact values at the points
        values = self.grid(loads, nodes)
        is_defined = np.isfinite(values)
        is_inside = is_defined.copy()  # no value beyond the known loads
        for rows in self.places(loads[:, None], nodes).rows:
            is_known, is_certain = self._sides(rows, nodes, levels[:, None])
            is_inside &= is_known
            is_defined &= is_certain | (reach > 1)
        points = np.where(is_inside & np.isin(nodes, x), nodes, np.nan)
        return Lines.of(nodes, values, is_defined, levels, points, lambda v, k: self(loads[k], v))

    def along_load(self, velocities: Array, levels: Array) -> Lines:
        """Lines along load at `velocities` (k,), and where they cross `levels` (k,)."""
        unique_velocities, inverse = np.unique(velocities, return_inverse=True)
        values, rows = self.rows(unique_velocities)[:, inverse].T, np.arange(len(self.loads))
        is_inside, is_defined = self._sides(rows, velocities[:, None], levels[:, None])
        is_sampled = np.isin(velocities, self.velocities)  # there only known points count
        columns = np.searchsorted(self.velocities, velocities[is_sampled])
        is_inside[is_sampled] = is_defined[is_sampled] = self.is_known.T[columns]
        points = np.where(is_inside, self.loads, np.nan)
        return Lines.of(
            self.loads, values, is_defined, levels, points, lambda f, k: self(f, velocities[k])
        )

    def _sides(self, rows: Indices, velocities: Array, levels: Array) -> tuple[Mask, Mask]:
        """Masks: velocities within the known range of a load, and those with a certain verdict.

        The verdict is also certain below the first point of a load if this is mild, and above the
        last if that is severe.
        """
        first, last = (end[rows] for end in self.velocity_limits)
        is_inside = (first <= velocities) & (velocities <= last)
        end_columns = (
            np.searchsorted(self.velocities, np.nan_to_num(end)) for end in self.velocity_limits
        )
        last_column, all_rows = len(self.velocities) - 1, np.arange(len(self.loads))
        low, high = (
            self.plane[all_rows, np.minimum(column, last_column)][rows] for column in end_columns
        )
        is_mild, is_severe = (velocities < first) & (low <= levels), high > levels
        is_decided_beyond = is_mild | ((velocities > last) & is_severe)
        return is_inside, is_inside | (np.isin(rows, self.curve_rows) & is_decided_beyond)


@dataclass(frozen=True, eq=False)
class Places:
    """k pairs of load and velocity in a field, and how they lie between its loads."""

    field: Field
    loads: Array
    velocities: Array

    @functools.cached_property
    def is_point(self) -> Mask:
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
        return np.stack([np.where(self.is_point, exact, low), np.where(self.is_point, exact, high)])

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
        for known, pairs in _group_equal_rows(np.isfinite(self.row_values).T):
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


LineOutcome = IntEnum(
    "LineOutcome",
    "TRANSITION MILD SEVERE UNKNOWN OUTSIDE_MODEL",
    start=0,
)
"""Codes of what happens along a line of rising velocity, or of rising load.

Wear is mild or severe over the whole sweep; unknown if too few of its points are done.
"""


class Lines(NamedTuple):
    """Velocities or loads at which wear becomes severe, along k lines.

    The rise grows with velocity and with load. If it does not, `critical` is the lowest value at
    which wear becomes severe, which is on the safe side.
    """

    critical: Array  # (k,), NaN where wear does not change from mild to severe
    is_severe: Mask  # True where wear is severe from the first known position on
    low: Array  # lowest and highest simulated position (k,), NaN without any
    high: Array

    @classmethod
    def of(
        cls, nodes: Array, values: Array, is_defined: Mask, levels: Array, points: Array,
        function: Callable[[Array, Indices], Array],
    ) -> Lines:  # fmt: skip
        """Find the crossings between `nodes` (n,) on lines of `values` (k, n), where `is_defined`.

        `function` evaluates the field at positions on the lines whose indices are its second
        argument.
        """
        x, v, count = np.broadcast_to(nodes, is_defined.shape), values, is_defined.sum(axis=1)
        if not is_defined.all():
            order = np.argsort(~is_defined, axis=1, kind="stable")  # defined nodes first
            x, v = nodes[order], np.take_along_axis(values, order, axis=1)
        severe = (v > levels[:, None]) & (np.arange(len(nodes)) < count[:, None])
        first = severe.argmax(axis=1)
        row = np.flatnonzero(first)  # mild at the first node, severe at a later one
        critical = np.full(len(levels), np.nan)
        critical[row] = roots(
            lambda positions: function(positions, row) - levels[row],
            x[row, first[row] - 1],
            x[row, first[row]],
        )
        low, high = np.fmin.reduce(points, axis=1), np.fmax.reduce(points, axis=1)
        return cls(critical, severe[:, 0], low, high)

    def outcomes(self, ends: tuple[float, float]) -> Indices:
        """Codes of `LineOutcome` (k,); `ends` are the lowest and highest position in the sweep."""
        covers_sweep = np.where(self.is_severe, self.low <= ends[0], self.high >= ends[1])
        uniform = np.where(self.is_severe, LineOutcome.SEVERE, LineOutcome.MILD)
        cases = np.isfinite(self.critical), covers_sweep
        return np.select(cases, (LineOutcome.TRANSITION, uniform), LineOutcome.UNKNOWN)


def film_field(case: CaseResults, bulk: float) -> Field | None:
    """Ln of the pressure in the oil film over that which carries a fifth of the load.

    None if the film cannot be computed. A point above 0 is outside the model. Smooth bodies,
    balls and crowned pins have no stored film: their field is NaN.
    """
    oil = case.sweep.lubricant
    if oil is None or not oil.pressure_coefficient or not case.sweep.scene.friction_heat:
        return None
    names = [name for name in ("film_inlet", "film_pressure") if name in case.ds]
    if len(names) < 2 or not case.sweep.base.has_film:
        return Field(case.loads, case.velocities, np.full(case.status.shape[1:], np.nan))
    values = map(case.array, names)  # −1 where the film is not known
    logs = (
        np.log(np.where(surface_values > 0, surface_values, np.nan)) for surface_values in values
    )
    with warnings.catch_warnings():  # points without a result
        warnings.simplefilter("ignore", RuntimeWarning)
        inlet, pressure = (np.exp(np.nanmean(surface_values, axis=0)) for surface_values in logs)
    plane = np.full(inlet.shape, np.nan)
    for i, j in np.argwhere(np.isfinite(inlet * pressure)).tolist():
        point = float(case.loads[i]), float(case.velocities[j])
        excess = film_excess(
            case.sweep.scene, oil, *point, bulk, float(inlet[i, j]), float(pressure[i, j])
        )
        plane[i, j] = max(excess, _NO_FILM)
    return Field(case.loads, case.velocities, plane)


def _group_equal_rows(known: Mask) -> list[tuple[Mask, Indices]]:
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
