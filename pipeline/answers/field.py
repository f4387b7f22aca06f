"""ln(rise) of a specimen over load and velocity, from which every answer is read.

The rise is that of the contact temperature that is compared with the critical
temperature, per unit friction coefficient [K]. Wear is severe where it is above a limit, (critical
− bulk temperature)/friction. Answers speak of y = ln(rise/limit), which is severe above 0.

Between points ln(rise) is interpolated by PCHIP, over ln(velocity) at each load, then over ln(load)
at each velocity. Beyond the velocities of a load it goes on with the last slope.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from pipeline.answers.pchip import Pchip, roots
from pipeline.answers.results import CaseResults
from pipeline.constants import PARTS
from tribo.simulation.film import film_excess
from tribo.types import Array, Indices, Mask

TWINS = 1e-4
"""Distance in ln(load or velocity) up to which points are merged into one.

The slope between nearer points would be that of rounding, and PCHIP takes it for the curve's.
"""
_NO_FILM = -50.0  # ln(pressure over that of a fifth of the load), in place of that of no film
_BEYOND_PARTS = 64  # nodes of a line beyond the computed velocities, on either side


@dataclass(frozen=True, eq=False)
class Field:
    """A quantity over load and velocity, known at points (n_load, n_velocity), else NaN."""

    loads: Array
    velocities: Array
    plane: Array
    factor: Callable[[Array], Array] = np.ones_like  #: Multiplies exp(field), by velocity.

    @functools.cached_property
    def is_known(self) -> Mask:
        """True at known points."""
        return np.isfinite(self.plane)

    @functools.cached_property
    def _ends(self) -> tuple[Array, Array]:
        """First and last known velocity at each load; NaN if there is none."""
        known, x = self.is_known, self.velocities
        first, last = x[known.argmax(axis=1)], x[::-1][known[:, ::-1].argmax(axis=1)]
        none = ~known.any(axis=1)
        return np.where(none, np.nan, first), np.where(none, np.nan, last)

    @functools.cached_property
    def tells(self) -> Indices:
        """Loads with at least two known points, which go on beyond them."""
        return np.flatnonzero(self.is_known.sum(axis=1) > 1)

    @functools.cached_property
    def curves(self) -> list[tuple[Indices, Pchip]]:
        """Curves over ln(velocity), without the factor, of loads known at the same velocities."""
        return [
            (rows, Pchip(np.log(self.velocities[known]), self.plane[np.ix_(rows, known)].T))
            for known, rows in _alike(self.is_known)
            if known.any()
        ]

    def rows(self, velocities: Array) -> Array:
        """Values at each load and each of `velocities` (n_load, m).

        A load with a single known point has a value there alone.
        """
        found = np.full((len(self.loads), len(velocities)), np.nan)
        for rows, curves in self.curves:
            found[rows] = curves.beyond(np.log(velocities)).T
        return found if self._is_plain else found + np.log(self.factor(velocities))

    def __call__(self, loads: Array, velocities: Array) -> Array:
        """Values at k pairs of load and velocity; NaN outside the loads."""
        each, back = np.unique(velocities, return_inverse=True)
        rows = self.rows(each)
        found = np.full(loads.shape, np.nan)
        for known, columns in _alike(np.isfinite(rows).T):
            here = np.flatnonzero(np.isin(back, columns))
            if not known.any() or not here.size:
                continue
            x, own = self.loads[known], loads[here]
            curves = Pchip(np.log(x), rows[known])
            inside = (x[0] <= own) & (own <= x[-1])
            found[here] = np.where(inside, curves.at(np.log(own), back[here]), np.nan)
        return found

    def grid(self, loads: Array, velocities: Array) -> Array:
        """Values at each of k loads and m velocities (k, m); NaN outside the loads."""
        rows, found = self.rows(velocities), np.full((len(loads), len(velocities)), np.nan)
        for known, columns in _alike(np.isfinite(rows).T):
            if known.any():
                x = self.loads[known]
                inside = np.flatnonzero((x[0] <= loads) & (loads <= x[-1]))
                curves = Pchip(np.log(x), rows[np.ix_(known, columns)])
                found[np.ix_(inside, columns)] = curves.grid(np.log(loads[inside]))
        return found

    def beside(self, loads: Array) -> tuple[Indices, Indices]:
        """Indices of the loads between which each of `loads` (k,) lies; of its own load twice."""
        tells = self.tells if self.tells.size else np.arange(len(self.loads))
        after = np.searchsorted(self.loads[tells], loads)
        high = tells[np.minimum(after, len(tells) - 1)]
        low = np.where(self.loads[high] == loads, high, tells[np.maximum(after - 1, 0)])
        own = np.minimum(np.searchsorted(self.loads, loads), len(self.loads) - 1)
        is_own = (self.loads[own] == loads) & self.is_known[own].any(axis=1)
        own = np.where(is_own, own, -1)  # a load with one point has that
        return np.where(own >= 0, own, low), np.where(own >= 0, own, high)

    def way(self, loads: Array) -> Array:
        """Way in ln(load) of `loads` (k,) between those beside, from 0 to 1; 0 at one of them."""
        low, high = (self.loads[one] for one in self.beside(loads))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(high > low, np.log(loads / low) / np.log(high / low), 0.0)

    def bilinear(self, values: Array, loads: Array, velocities: Array) -> Array:
        """Values at points (n_load, n_velocity) between them: linear in ln(velocity), ln(load).

        Beyond the known velocities of a load its last value holds. So a bound of errors at points
        is one between them, and continuous.
        """
        (low, high), way = self.beside(loads), self.way(loads)
        x, found = np.log(velocities), np.full((2, len(loads)), np.nan)
        for side, rows in enumerate((low, high)):
            for row in np.unique(rows):
                here, known = rows == row, self.is_known[row]
                if known.any():
                    found[side, here] = _linear(
                        x[here], np.log(self.velocities[known]), values[row, known]
                    )
        return np.asarray(_weighed(1 - way, found[0]) + _weighed(way, found[1]))

    def is_point(self, loads: Array, velocities: Array) -> Mask:
        """True for those of k places that are known points."""
        i, j = np.searchsorted(self.loads, loads), np.searchsorted(self.velocities, velocities)
        i, j = np.minimum(i, len(self.loads) - 1), np.minimum(j, len(self.velocities) - 1)
        at = (self.loads[i] == loads) & (self.velocities[j] == velocities)
        return np.asarray(at & self.is_known[i, j])

    def is_extrapolated(self, loads: Array, velocities: Array) -> Mask:
        """True for those of k places that are beyond the known velocities of a load beside."""
        first, last = self._ends
        sides = [(first[i] <= velocities) & (velocities <= last[i]) for i in self.beside(loads)]
        return ~(sides[0] & sides[1])

    # Lines through the field, and where it passes a level along them

    def along_velocity(self, loads: Array, levels: Array, reach: float = 1.0) -> Lines:
        """Where the field passes `levels` (k,) along velocity, at `loads` (k,).

        Lines end where a load beside leaves the side of the level open; with a `reach` they go on
        by this factor beyond all velocities.
        """
        x = self.velocities
        parts = 1 if np.isin(loads, self.loads).all() and self._is_plain else PARTS
        inner = x[:-1, None] + np.diff(x)[:, None] * np.arange(parts) / parts
        far = np.geomspace(1.0, reach, _BEYOND_PARTS if reach > 1 else 1)[1:]
        nodes = np.concatenate([x[0] / far[::-1], inner.ravel(), x[-1:], x[-1] * far])
        nodes[np.searchsorted(nodes, x)] = x  # without rounding
        values = self.grid(loads, nodes)
        holds = np.isfinite(values)
        within = holds.copy()  # loads beyond the known ones have no value
        for rows in self.beside(loads):
            inside, certain = self._sides(rows[:, None], nodes, levels[:, None])
            within &= inside
            holds &= certain | (reach > 1)
        points = np.where(within & np.isin(nodes, x), nodes, np.nan)
        return Lines.of(nodes, values, holds, levels, points, lambda v, k: self(loads[k], v))

    def along_load(self, velocities: Array, levels: Array) -> Lines:
        """Where the field passes `levels` (k,) along load, at `velocities` (k,)."""
        each, back = np.unique(velocities, return_inverse=True)
        values, rows = self.rows(each)[:, back].T, np.arange(len(self.loads))
        within, holds = self._sides(rows, velocities[:, None], levels[:, None])
        is_own = np.isin(velocities, self.velocities)  # where points alone count
        own = np.searchsorted(self.velocities, velocities[is_own])
        within[is_own] = holds[is_own] = self.is_known.T[own]
        points = np.where(within, self.loads, np.nan)
        return Lines.of(
            self.loads, values, holds, levels, points, lambda f, k: self(f, velocities[k])
        )

    def _sides(self, rows: Indices, velocities: Array, levels: Array) -> tuple[Mask, Mask]:
        """Whether loads are known at velocities, and on a certain side of levels there.

        Below the first point of a load it is mild if it is so there, and severe above the last.
        """
        first, last = (end[rows] for end in self._ends)
        within = (first <= velocities) & (velocities <= last)
        if not self._is_plain:
            return within, within
        points = (np.searchsorted(self.velocities, np.nan_to_num(end)) for end in self._ends)
        most, each = len(self.velocities) - 1, np.arange(len(self.loads))
        low, high = (self.plane[each, np.minimum(one, most)][rows] for one in points)
        is_mild, is_severe = (velocities < first) & (low <= levels), high > levels
        open_ends = is_mild | ((velocities > last) & is_severe)
        return within, within | (np.isin(rows, self.tells) & open_ends)

    @property
    def _is_plain(self) -> bool:
        """True if the field grows with velocity beyond its points."""
        return self.factor is np.ones_like


Outcome = IntEnum(
    "Outcome",
    "TRANSITION MILD SEVERE MILD_TO_HIGHEST SEVERE_FROM_LOWEST SEVERAL UNKNOWN OUTSIDE_MODEL "
    "NO_LINE",
    start=0,
)
"""Codes of what happens along a line of rising velocity, or of rising load.

Wear is mild (severe) over the whole sweep, or up to the highest (down to the lowest) simulated
place; several are severe wear at one place and mild wear again at a higher one.
"""


class Lines(NamedTuple):
    """Where wear changes along k lines."""

    places: Array  # ascending (k, n), then NaN
    severe_at_start: Mask
    ends_severe: Mask
    low: Array  # lowest and highest computed place (k,), NaN if there is none
    high: Array

    @classmethod
    def of(
        cls, nodes: Array, values: Array, holds: Mask, levels: Array, points: Array,
        function: Callable[[Array, Indices], Array],
    ) -> Lines:  # fmt: skip
        """Find the changes between `nodes` (n,) where lines `values` (k, n) hold.

        `function` gives the field at places of the lines numbered by its second argument.
        """
        x, v, count = np.broadcast_to(nodes, holds.shape), values, holds.sum(axis=1)
        if not holds.all():
            order = np.argsort(~holds, axis=1, kind="stable")  # those that hold first
            x, v = nodes[order], np.take_along_axis(values, order, axis=1)
        severe = v > levels[:, None]
        changes = (severe[:, 1:] != severe[:, :-1]) & (np.arange(1, len(nodes)) < count[:, None])
        row, piece = np.nonzero(changes)
        found = roots(lambda at: function(at, row) - levels[row], x[row, piece], x[row, piece + 1])
        number = np.arange(len(row)) - np.searchsorted(row, row)
        places = np.full((len(levels), number.max(initial=0) + 1), np.nan)
        places[row, number] = found
        last = np.maximum(count - 1, 0)[:, None]
        begins, ends = severe[:, 0], np.take_along_axis(severe, last, axis=1)[:, 0]
        low, high = np.fmin.reduce(points, axis=1), np.fmax.reduce(points, axis=1)
        return cls(places, begins & (count > 0), ends & (count > 0), low, high)

    @property
    def critical(self) -> Array:
        """Lowest place at which wear turns severe (k,); NaN without one, or if severe before."""
        return np.where(self.severe_at_start, np.nan, np.fmin.reduce(self.places, axis=1))

    def outcomes(self, ends: tuple[float, float], turns_back: bool = False) -> Indices:
        """Codes of `Outcome` (k,); `ends` are the lowest and highest place of the sweep.

        `turns_back` is True if wear may change beyond either end of a line.
        """
        first, last = self.low <= ends[0], self.high >= ends[1]
        whole = first & last if turns_back else np.where(self.severe_at_start, first, last)
        count = np.isfinite(self.places).sum(axis=1)
        throughout = np.where(self.severe_at_start, Outcome.SEVERE, Outcome.MILD)
        beyond = np.where(self.severe_at_start, Outcome.SEVERE_FROM_LOWEST, Outcome.MILD_TO_HIGHEST)
        kinds = (count == 1) & ~self.severe_at_start, count > 0, np.isnan(self.low), whole
        codes = Outcome.TRANSITION, Outcome.SEVERAL, Outcome.UNKNOWN, throughout
        return np.select(kinds, codes, beyond)


def film_of(case: CaseResults, bulk: float) -> Field | None:
    """Ln of the pressure in the oil film over that which carries a fifth of the load.

    None if the scene has no oil whose film could be judged. Above 0 a place is outside the model.
    Unknown for smooth bodies, balls and crowned pins, of which nothing is stored.
    """
    oil = case.sweep.lubricant
    if oil is None or not oil.pressure_coefficient or not case.sweep.scene.friction_heat:
        return None
    names = [name for name in ("film_inlet", "film_pressure") if name in case.ds]
    if len(names) < 2 or not case.sweep.base.has_film:
        return Field(case.loads, case.velocities, np.full(case.status.shape[1:], np.nan))
    values = map(case.array, names)  # −1 where the film is not known
    logs = (np.log(np.where(one > 0, one, np.nan)) for one in values)
    with warnings.catch_warnings():  # points without a result
        warnings.simplefilter("ignore", RuntimeWarning)
        inlet, pressure = (np.exp(np.nanmean(one, axis=0)) for one in logs)
    plane = np.full(inlet.shape, np.nan)
    for i, j in np.argwhere(np.isfinite(inlet * pressure)).tolist():
        place = float(case.loads[i]), float(case.velocities[j])
        excess = film_excess(
            case.sweep.scene, oil, *place, bulk, float(inlet[i, j]), float(pressure[i, j])
        )
        plane[i, j] = max(excess, _NO_FILM)
    return Field(case.loads, case.velocities, plane)


def _alike(known: Mask) -> list[tuple[Mask, Indices]]:
    """Distinct rows of a mask, and the indices of the rows that are alike."""
    if not len(known):
        return []
    if known.all():
        return [(known[0], np.arange(len(known)))]
    each, back = np.unique(known, axis=0, return_inverse=True)
    return [(one, np.flatnonzero(back.ravel() == number)) for number, one in enumerate(each)]


def _linear(x: Array, nodes: Array, values: Array) -> Array:
    """As `numpy.interp`, but a value of NaN makes unknown only what rests on it."""
    i = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, max(len(nodes) - 2, 0))
    j = np.minimum(i + 1, len(nodes) - 1)
    gap = nodes[j] - nodes[i]
    way = np.clip(np.divide(x - nodes[i], gap, out=np.zeros(x.shape), where=gap > 0), 0, 1)
    return _weighed(1 - way, values[i]) + _weighed(way, values[j])


def _weighed(weights: Array, values: Array) -> Array:
    return np.where(weights > 0, weights * values, 0.0)
