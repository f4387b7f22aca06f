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
from pipeline.answers.field_points import FieldPoints, group_equal_rows
from pipeline.answers.pchip import Pchip, roots
from pipeline.constants import MAX_SLANT, MIN_SLOPE, PARTS_OF_INTERVAL
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
            for known, rows in group_equal_rows(self.is_known)
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

    def at(self, loads: Array, velocities: Array) -> FieldPoints:
        """Where k pairs of load and velocity lie in the field."""
        return FieldPoints(self, loads, velocities)

    def __call__(self, loads: Array, velocities: Array) -> Array:
        """Values at k pairs of load and velocity; NaN outside the loads."""
        return self.at(loads, velocities).values

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
        for rows in self.at(loads[:, None], nodes).rows:
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
