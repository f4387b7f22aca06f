"""Where wear turns severe along the velocities of one load, from as few points as possible.

y = ln(rise/limit) is known at the computed points. Between and beyond them y − ln(µ) rises with
ln(velocity), with slopes in `RISE_SLOPES`: this bounds y, so that its sign is known or open.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from pipeline.answers.error import curve_errors
from pipeline.answers.pchip import Pchip
from pipeline.constants import CURVATURE, FLATTEST, RISE_SLOPES, ROUGH_LINE, STEEPEST
from tribo.types import Array, Indices, Mask

_NARROW = 1e-9  # in place of a range of velocities of 0
_PARTS = 64  # parts of an interval of velocities at which the sign is looked at


@dataclass(frozen=True, eq=False)
class Line:
    """ln(rise/limit) at the velocities of one load.

    `x` (n,) is ln(velocity), ascending, of the points that can be computed; `y` (n,) is NaN where
    they are not computed. `friction` is ln(µ) relative to the nominal coefficient, at `places`.
    """

    x: Array
    y: Array
    friction: Array

    @classmethod
    def of_heat(cls, x: Array, heat: Array, friction: Array) -> Self:
        """Line from y − ln(µ) at the velocities, and ln(µ) at the places of `places_along`."""
        return cls(x, heat + friction[::_PARTS][: len(x)], friction)

    @functools.cached_property
    def known(self) -> Indices:
        """Indices of the computed points."""
        return np.flatnonzero(np.isfinite(self.y))

    @functools.cached_property
    def _places(self) -> Array:
        return places_along(self.x)

    @property
    def _bends(self) -> bool:
        """True if friction varies with velocity, so that the sign may change several times."""
        return bool(np.ptp(self.friction) > 0)

    @functools.cached_property
    def _curve(self) -> tuple[Array, Array, Array]:
        """Lower bound, estimate and upper bound of y at all places."""
        at, x = self._places, self.x[self.known]
        heat = (self.y - self.friction[::_PARTS])[self.known]  # y − ln(µ)
        slopes = np.diff(heat) / np.diff(x)
        # Wider than usual if computed points have shown other slopes.
        shown, (gentle, steep) = slopes[np.abs(slopes) < STEEPEST], RISE_SLOPES
        gentle, steep = min(gentle, shown.min(initial=gentle)), max(steep, shown.max(initial=steep))
        away = at - x[:, None]
        ends = [
            np.where(away > 0, one, other) * away + heat[:, None]
            for one, other in ((gentle, steep), (steep, gentle))
        ]
        low, high = np.sort([ends[0].max(axis=0), ends[1].min(axis=0)], axis=0)
        middle = (low + high) / 2
        if len(x) > 1:
            # A monotone cubic, with the mean slope beyond the computed points.
            inner, mean = np.clip(at, x[0], x[-1]), (heat[-1] - heat[0]) / (x[-1] - x[0])
            cubic = Pchip(x, heat[:, None]).beyond(inner)[:, 0] + mean * (at - inner)
            middle = np.clip(cubic, low, high)
            off = ROUGH_LINE + CURVATURE * _bow(x, at)
            low, high = np.maximum(low, middle - off), np.minimum(high, middle + off)
        return low + self.friction, middle + self.friction, high + self.friction

    def crossings(self) -> Array:
        """ln(velocity) at which wear changes, ascending."""
        if not self.known.size:
            return np.empty(0)
        x, y = self._places, self._curve[1]
        (k,) = np.nonzero((y[:-1] > 0) != (y[1:] > 0))
        return np.asarray(x[k] - y[k] * (x[k + 1] - x[k]) / (y[k + 1] - y[k]))

    @property
    def turns(self) -> bool:
        """True if wear changes along the line, by the estimate."""
        return bool(self.crossings().size)

    @property
    def is_severe(self) -> bool:
        """True if wear is severe at the lowest velocity, by the estimate."""
        return bool(self.known.size and self._curve[1][0] > 0)

    def wanted(self, guess: float, tolerance: float) -> int | None:
        """Index of the velocity to compute next; None if none is needed.

        `guess` is ln(velocity) at which to begin, `tolerance` the error of a crossing in
        ln(velocity).
        """
        is_open = np.isnan(self.y)
        if not is_open.any():
            return None
        if not self.known.size:
            return int(np.argmin(np.abs(self.x - guess)))
        steps = (
            self._doubtful(is_open),
            self._unsure(is_open, tolerance),
            self._touching(is_open),
            self._end(is_open),
        )
        return next((step for step in steps if step is not None), None)

    def _doubtful(self, is_open: Mask) -> int | None:
        """The velocity not computed next to which the sign is most in doubt."""
        low, _, high = self._curve
        depth = np.minimum(high, -low)
        # Each place belongs to the nearer of the two velocities about it that is not computed.
        cell = np.minimum(np.arange(len(depth)) // _PARTS, len(self.x) - 1)
        above = np.minimum(cell + (np.arange(len(depth)) % _PARTS > 0), len(self.x) - 1)
        depth = np.where(is_open[cell] | is_open[above], depth, -math.inf)
        place = int(np.argmax(depth))
        if depth[place] <= 0:
            return None
        sides = [side for side in (int(cell[place]), int(above[place])) if is_open[side]]
        return min(sides, key=lambda side: float(abs(self.x[side] - self._places[place])))

    def _unsure(self, is_open: Mask, tolerance: float) -> int | None:
        """A velocity beside a crossing whose error by points left out is too large."""
        x, known = self.x, self.known
        heat = (self.y - self.friction[::_PARTS])[known]
        for crossing in self.crossings():
            error = curve_errors(x[known], heat, np.array([crossing]))[0]
            slope = max(np.diff(heat).sum() / max(np.ptp(x[known]), _NARROW), FLATTEST)
            after = int(np.searchsorted(x[known], crossing))
            low = known[after - 1] if after else -1
            high = known[after] if after < len(known) else len(x)
            is_within = 0 < after < len(known)
            if is_within and error <= tolerance * slope:
                continue
            within = np.flatnonzero(is_open[low + 1 : high]) + low + 1
            if within.size:
                return int(within[np.argmin(np.abs(x[within] - crossing))])
            for beside in (low - 1, high + 1):
                if 0 <= beside < len(x) and is_open[beside]:
                    return int(beside)
        return None

    def _touching(self, is_open: Mask) -> int | None:
        """A velocity beside two of one sign, between which varying friction may turn y."""
        low, _, high = self._curve
        for first in np.flatnonzero(~is_open[:-1] & ~is_open[1:]).tolist():
            inside = slice(_PARTS * first + 1, _PARTS * (first + 1))
            may_turn = self._bends and np.any((low[inside] < 0) & (high[inside] > 0))
            if may_turn and (self.y[first] > 0) == (self.y[first + 1] > 0):
                for beside in (first - 1, first + 2):
                    if 0 <= beside < len(self.x) and is_open[beside]:
                        return int(beside)
        return None

    def _end(self, is_open: Mask) -> int | None:
        """A velocity at an end, if wear does not change: an answer then says "throughout"."""
        if self.crossings().size:
            return None
        # With constant friction one end decides: the highest if wear is mild, else the lowest.
        # The point beside it shows how the rise goes on.
        last = len(self.x) - 1
        end, beside, other = (0, 1, last) if self.is_severe else (last, last - 1, 0)
        wanted = (end, other) if self._bends else (end, beside)
        return next((one for one in wanted if 0 <= one <= last and is_open[one]), None)


def places_along(x: Array) -> Array:
    """ln(velocity) at which the sign is looked at: each of `x`, and 63 places in each interval."""
    return np.interp(np.arange(_PARTS * (len(x) - 1) + 1) / _PARTS, np.arange(len(x)), x)


def _bow(x: Array, at: Array) -> Array:
    """Distance of a curve with second derivative 1 from its chord, or beyond from its tangent."""
    last = np.searchsorted(x, at).clip(1, len(x) - 1)
    within = (at - x[last - 1]) * (x[last] - at) / 2
    beyond = np.maximum(x[0] - at, at - x[-1])
    return np.asarray(np.where(beyond > 0, beyond, within))
