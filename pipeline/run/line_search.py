"""Critical velocities at one load, from as few points as possible.

y = ln(rise/limit) is known at the simulated points. Between and beyond them, it is assumed to rise
with ln(velocity) with slopes in `RISE_SLOPES`. This bounds y, whose sign is then known or open.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from pipeline.answers.error import curve_errors
from pipeline.answers.pchip import Pchip
from pipeline.constants import (
    FLATTEST_SLOPE,
    MAX_CURVATURE,
    RISE_SLOPES,
    ROUGHNESS_DEVIATION,
    STEEPEST_SLOPE,
)
from tribo.types import Array, Indices, Mask

_MIN_RANGE = 1e-9  # of ln(velocity), if there is only one velocity
_PARTS = 64  # parts of an interval of velocities, at whose ends the sign is evaluated


@dataclass(frozen=True, eq=False)
class Line:
    """ln(rise/limit) at the velocities of one load.

    `x` (n,) is ln(velocity), ascending, of the points that can be computed; `y` (n,) is NaN where
    not computed.
    """

    x: Array
    y: Array

    @functools.cached_property
    def known(self) -> Indices:
        """Indices of the computed points."""
        return np.flatnonzero(np.isfinite(self.y))

    @functools.cached_property
    def _grid(self) -> Array:
        """ln(velocity) at which the sign is evaluated: `x`, and 63 values in each interval."""
        count = len(self.x)
        return np.interp(np.arange(_PARTS * (count - 1) + 1) / _PARTS, np.arange(count), self.x)

    @functools.cached_property
    def _curve(self) -> tuple[Array, Array, Array]:
        """Lower bound, estimate and upper bound of y on the grid."""
        grid, x, y = self._grid, self.x[self.known], self.y[self.known]
        slopes = np.diff(y) / np.diff(x)
        # The range of slopes includes those between computed points.
        usual, (gentle, steep) = slopes[np.abs(slopes) < STEEPEST_SLOPE], RISE_SLOPES
        gentle, steep = min(gentle, usual.min(initial=gentle)), max(steep, usual.max(initial=steep))
        distance = grid - x[:, None]
        bounds = [
            np.where(distance > 0, below, above) * distance + y[:, None]
            for below, above in ((gentle, steep), (steep, gentle))
        ]
        low, high = np.sort([bounds[0].max(axis=0), bounds[1].min(axis=0)], axis=0)
        estimate = (low + high) / 2
        if len(x) > 1:
            # A monotone cubic, continued with the mean slope beyond the computed points.
            clipped, mean_slope = np.clip(grid, x[0], x[-1]), (y[-1] - y[0]) / (x[-1] - x[0])
            cubic = Pchip(x, y[:, None]).beyond(clipped[:, None])[:, 0] + mean_slope * (
                grid - clipped
            )
            estimate = np.clip(cubic, low, high)
            margin = ROUGHNESS_DEVIATION + MAX_CURVATURE * _sagitta(x, grid)
            low, high = np.maximum(low, estimate - margin), np.minimum(high, estimate + margin)
        return low, estimate, high

    @functools.cached_property
    def crossing(self) -> float:
        """ln(velocity) at which wear becomes severe, by the estimate; NaN if it does not."""
        if not self.known.size:
            return math.nan
        x, y = self._grid, self._curve[1]
        if not (k := int(np.argmax(y > 0))):  # none is severe, or the first
            return math.nan
        return float(x[k - 1] - y[k - 1] * (x[k] - x[k - 1]) / (y[k] - y[k - 1]))

    @property
    def has_crossing(self) -> bool:
        """True if wear becomes severe along the line, by the estimate."""
        return math.isfinite(self.crossing)

    @property
    def is_severe(self) -> bool:
        """True if wear is severe at the lowest velocity, by the estimate."""
        return bool(self.known.size and self._curve[1][0] > 0)

    def next_velocity(self, guess: float, tolerance: float) -> int | None:
        """Index of the velocity to compute next; None if none is needed.

        `guess` is ln(velocity) at which to begin, `tolerance` the error of a crossing in
        ln(velocity).
        """
        is_open = np.isnan(self.y)
        if not is_open.any():
            return None
        if not self.known.size:
            return int(np.argmin(np.abs(self.x - guess)))
        indices = (
            self._most_doubtful(is_open),
            self._near_uncertain_crossing(is_open, tolerance),
            self._end_velocity(is_open),
        )
        return next((index for index in indices if index is not None), None)

    def _most_doubtful(self, is_open: Mask) -> int | None:
        """Uncomputed velocity nearest to where the sign is most in doubt."""
        low, _, high = self._curve
        doubt = np.minimum(high, -low)
        # A grid position counts if one of the two velocities around it is not computed.
        lower = np.minimum(np.arange(len(doubt)) // _PARTS, len(self.x) - 1)
        upper = np.minimum(lower + (np.arange(len(doubt)) % _PARTS > 0), len(self.x) - 1)
        doubt = np.where(is_open[lower] | is_open[upper], doubt, -math.inf)
        position = int(np.argmax(doubt))
        if doubt[position] <= 0:
            return None
        candidates = [k for k in (int(lower[position]), int(upper[position])) if is_open[k]]
        return min(candidates, key=lambda k: float(abs(self.x[k] - self._grid[position])))

    def _near_uncertain_crossing(self, is_open: Mask, tolerance: float) -> int | None:
        """Uncomputed velocity next to a crossing whose interpolation error is too large."""
        if not self.has_crossing:
            return None
        x, y, known = self.x, self.y, self.known
        error = curve_errors(x[known], y[known], np.array([self.crossing]))[0]
        slope = max(np.diff(y[known]).sum() / max(np.ptp(x[known]), _MIN_RANGE), FLATTEST_SLOPE)
        after = int(np.searchsorted(x[known], self.crossing))
        if 0 < after < len(known) and error <= tolerance * slope:
            return None
        low = known[after - 1] if after else -1
        high = known[after] if after < len(known) else len(x)
        candidates = np.flatnonzero(is_open[low + 1 : high]) + low + 1
        if candidates.size:
            return int(candidates[np.argmin(np.abs(x[candidates] - self.crossing))])
        neighbours = (k for k in (low - 1, high + 1) if 0 <= k < len(x) and is_open[k])
        return next(map(int, neighbours), None)

    def _end_velocity(self, is_open: Mask) -> int | None:
        """Uncomputed velocity at an end of a line without a crossing, to confirm this."""
        if self.has_crossing:
            return None
        # One end decides: the highest if wear is mild, else the lowest. The point next to it gives
        # the slope there.
        last = len(self.x) - 1
        candidates = (0, 1) if self.is_severe else (last, last - 1)
        return next((k for k in candidates if 0 <= k <= last and is_open[k]), None)


def _sagitta(x: Array, grid: Array) -> Array:
    """Sagitta of a chord at a second derivative of 1; outside the points, distance from them."""
    last = np.searchsorted(x, grid).clip(1, len(x) - 1)
    inside = (grid - x[last - 1]) * (x[last] - grid) / 2
    beyond = np.maximum(x[0] - grid, grid - x[-1])
    return np.asarray(np.where(beyond > 0, beyond, inside))
