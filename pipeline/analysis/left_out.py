"""Rises at loads that a search of the boundary has left out, from the loads computed beside them.

Computed points lie along the boundary, so that neighbouring loads have few velocities in common.
Rises are therefore interpolated along lines of equal rise, not at equal velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.curve import Curve
from pipeline.constants import LEAST_BENT, RISE_SLOPES, ROUGH_GAP, UNSEEN_BENT
from tribo.types import Array, Indices, Mask


@dataclass(frozen=True, eq=False)
class Alignment:
    """Velocities of equal rise at the computed loads of one surface.

    `rows` (r,) are the indices of these loads, with two or more points each. `centres` (r,) are
    ln(velocity) of the common rise.
    """

    loads: Array
    velocities: Array
    rises: Array  # (load, velocity); NaN where not computed
    rows: Indices
    centres: Array

    @classmethod
    def of(cls, loads: Array, velocities: Array, rises: Array) -> Alignment:
        """Align the loads of a plane of rises (load, velocity)."""
        is_known = np.isfinite(rises) & (rises > 0) & (velocities > 0)
        rows = np.flatnonzero(is_known.sum(axis=1) >= 2)
        known = is_known[rows]
        x = np.broadcast_to(np.log(np.where(velocities > 0, velocities, 1.0)), known.shape)
        y = np.log(np.where(known, rises[rows], 1.0))
        if not rows.size:
            return cls(loads, velocities, rises, rows, np.empty(0))
        means = [np.mean(part, axis=1, where=known) for part in (x, y)]
        ways = x - means[0][:, None]
        slopes = np.sum(ways * y, axis=1, where=known) / np.sum(ways**2, axis=1, where=known)
        level = np.median(y[known])
        return cls(
            loads, velocities, rises, rows,
            means[0] + (level - means[1]) / np.clip(slopes, *RISE_SLOPES),
        )  # fmt: skip

    def shifts(self, loads: Array) -> Array:
        """ln(velocity) at each computed load minus that at each of k `loads` (r, k)."""
        here = Curve(self.loads[self.rows], np.exp(self.centres))(loads)
        return np.asarray(self.centres[:, None] - np.log(here))

    def without(self, row: int) -> Alignment:
        """The alignment without the computed load at this place in `rows`."""
        others = np.delete(np.arange(len(self.rows)), row)
        return Alignment(
            self.loads, self.velocities, self.rises, self.rows[others], self.centres[others]
        )

    def at(self, load: float, velocities: Array) -> Array:
        """Rises at one load and k velocities, interpolated along lines of equal rise."""
        places = velocities * np.exp(self.shifts(np.array([load])))
        along = Curve(self.velocities, self.rises[self.rows])(places, continued=True)
        return Curve(self.loads[self.rows], along.T)(np.array([load]))[:, 0]

    def is_near(self, load: float) -> Mask:
        """Mask of the velocities about those computed at the loads beside, and one on each side.

        The computed ones count as they are, as wear may turn by friction there, and shifted along
        lines of equal rise. If both loads have an end of the velocities, all up to this end are
        near.
        """
        above = int(np.searchsorted(self.loads[self.rows], load).clip(1, len(self.rows) - 1))
        beside = [above - 1, above]
        known = np.isfinite(self.rises[self.rows[beside]])
        shifted = self.velocities * np.exp(-self.shifts(np.array([load]))[beside])
        places = np.concatenate([shifted[known], self.velocities[known.any(axis=0)]])
        first, last = np.searchsorted(self.velocities, [places.min(), places.max()])
        number = np.arange(len(self.velocities))
        is_above = (number >= first - 1) | known[:, 0].all()
        return np.asarray(is_above & ((number <= last) | known[:, -1].all()))


def fill_left_out(loads: Array, velocities: Array, rises: Array, is_left_out: Mask) -> Array:
    """Estimate rises at loads that were left out, in planes (..., load, velocity).

    `is_left_out` (..., load) is True for loads without a point that was to be computed. Rises are
    estimated near the computed points of the loads beside.
    """
    if not is_left_out.any():
        return rises
    filled = rises.copy()
    for place in np.ndindex(rises.shape[:-2]):
        aligned = Alignment.of(loads, velocities, rises[place])
        if len(aligned.rows) < 2:
            continue
        first, last = aligned.rows[[0, -1]]
        for load in np.flatnonzero(is_left_out[place]):
            if first < load < last:
                near = aligned.is_near(loads[load])
                filled[(*place, load, near)] = aligned.at(loads[load], velocities[near])
    return filled


def gap_bounds(x: Array, y: Array) -> Array:
    """Bounds of the error of y between n points, (n - 1,); `x` are ln(velocity), ascending.

    Between two points the cubic through all differs from the chord by what is known of the
    curvature. It is halved between points that have further ones on both sides.
    """
    widths = np.diff(x)
    least = np.full_like(widths, LEAST_BENT if len(x) > 2 else UNSEEN_BENT) * widths**2 / 8
    rough = ROUGH_GAP * widths
    if len(x) < 3:
        return np.asarray(np.hypot(least, rough))
    between = Curve(np.exp(x), np.exp(y))(np.exp(x[:-1] + widths / 2))
    bows = np.abs(np.log(between) - (y[:-1] + y[1:]) / 2)
    bounds = np.maximum(bows, least)
    bounds[1:-1] /= 2
    return np.asarray(np.hypot(bounds, rough))
