"""Transitions to severe wear along a line of points, and their outcome in words."""

from __future__ import annotations

import enum
import functools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.analysis.curve import Curve
from pipeline.analysis.model_error import ModelError
from pipeline.analysis.results import Results
from pipeline.quantities import UNITS
from tribo import Criterion
from tribo.types import Array, Mask

Outcome = enum.IntEnum("Outcome", "CROSSES MILD SEVERE UNKNOWN ABOVE BELOW SEVERAL", start=0)
"""Codes of the outcome along a line; `outcomes` has their texts."""
CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL = Outcome


@functools.cache
def outcomes(axis: str) -> Mapping[int, str]:
    """Texts for the codes of outcomes along ``"velocity"`` or ``"load"``."""
    return {
        CROSSES: "crosses",
        MILD: "mild throughout",
        SEVERE: "severe throughout",
        UNKNOWN: "not known yet",
        ABOVE: f"mild at every {axis} computed",
        BELOW: f"severe at every {axis} computed",
        SEVERAL: f"severe at some {axis} and mild at a higher one",
    }


@dataclass(frozen=True, eq=False)
class Line:
    """Rise along velocity at a load, or along load at a velocity, and where wear changes.

    Arrays may have leading axes: a curve on each surface, through each operating point. To compare
    a curve with several limits, `rows` has the number of the curve for each limit.
    """

    #: Rises [K] over velocities [m/s] or loads [N]. The curve may extend beyond the computed
    #: values, if wear does not change there.
    curve: Curve
    limit: Array  # rise above which wear is severe [K]
    ends: tuple[float, float]  # lowest and highest velocity or load of the sweep
    done: Array  # computed velocities or loads (..., n), ascending; else NaN
    continued: Curve  #: The curve extrapolated beyond its ends, where known.
    turns_back: bool  #: True if wear may change beyond either end, by velocity-dependent friction.
    rows: Any = ...  # row of each limit; by default one limit for each row

    @functools.cached_property
    def places(self) -> Array:
        """Ascending velocities [m/s] or loads [N] (..., n) at which wear changes, then NaN."""
        return self.curve.crossings(self.limit, self.rows)

    @functools.cached_property
    def begins_severe(self) -> Mask:
        """True if wear is severe at the line's lowest velocity or load."""
        return np.asarray(Criterion.is_severe(self.curve.end(0)[1][self.rows], self.limit))

    @property
    def computed(self) -> tuple[Array, Array]:
        """Lowest and highest computed value on the horizontal axis of each curve, as two arrays.

        They are velocities [m/s] if the curves run along velocity, and loads [N] if along load. A
        value is NaN if no point of the curve is computed.
        """
        return np.fmin.reduce(self.done, axis=-1), np.fmax.reduce(self.done, axis=-1)

    @functools.cached_property
    def outcome(self) -> Array:
        """Code of the outcome along each curve; `outcomes` has the texts of the codes."""
        count, (low, high) = np.isfinite(self.places).sum(axis=-1), self.computed
        is_first, is_last = low <= self.ends[0], high >= self.ends[1]
        turns_back = self.turns_back & (self.continued.count > 0)
        is_whole = np.where(self.begins_severe, is_first, is_last)
        is_whole = np.where(turns_back, is_first & is_last, is_whole)
        beyond = np.where(self.begins_severe, BELOW, ABOVE)
        throughout = np.where(self.begins_severe, SEVERE, MILD)
        kinds = (count == 1) & ~self.begins_severe, count > 0, np.isnan(low), is_whole
        return np.select(kinds, [CROSSES, SEVERAL, UNKNOWN, throughout], beyond)

    @property
    def first(self) -> Array:
        """Lowest velocities [m/s] or loads [N] at which wear turns severe, one for each limit.

        The array has the shape of `Line.limit`, the rises [K] above which wear is severe. A value
        is minus infinity if wear is severe from the line's beginning, infinity if wear is mild on
        the whole line, and NaN if unknown.
        """
        place = np.fmin.reduce(self.places, axis=-1)
        place = np.where(np.isnan(place), math.inf, place)
        place = np.where(self.begins_severe, -math.inf, place)
        return np.where(self.outcome == UNKNOWN, math.nan, place)

    def texts(self, along: str) -> Array:
        """Outcome in words of each curve, along ``"velocity"`` or ``"load"``."""
        ends, texts = self.computed, np.empty(self.outcome.shape, object)
        for line, code in np.ndenumerate(self.outcome):
            computed = [float(end[line]) for end in ends]
            begins, turns = bool(self.begins_severe[line]), self.places[line].tolist()
            texts[line] = in_words(outcomes(along)[int(code)], computed, along, turns, begins)
        return texts.astype(str)

    @property
    def _turns_severe(self) -> Mask:
        """True for each value in `Line.places` at which wear turns from mild to severe.

        The direction is that of rising velocity or load. Values of the opposite change, and those
        that are NaN, are False.
        """
        number = np.cumsum(np.isfinite(self.places), axis=-1) - self.begins_severe[..., None]
        return np.asarray(np.isfinite(self.places) & (number % 2 == 1))

    def nearest(
        self, here: Array | float, to_severe: bool = False, continued: bool = False
    ) -> Array:
        """Velocity [m/s] or load [N] at which wear changes, nearest to `here` by ratio.

        With `to_severe` only changes from mild to severe wear count. With `continued`, a line on
        which wear does not change is extrapolated. If wear does not change there either, the result
        is infinity (all mild), minus infinity (all severe) or NaN (unknown), as in `Line.first`.
        """
        places, is_severe = self.places, self._turns_severe
        is_counted = is_severe if to_severe else np.isfinite(places)
        if continued:
            others, is_severe, _ = self._all_turns
            is_other = np.isfinite(others) & (is_severe | (not to_severe))
            is_other &= ~np.any(is_counted, axis=-1, keepdims=True)
            is_other &= (self.outcome != UNKNOWN)[..., None]
            places = np.append(places, others, axis=-1)
            is_counted = np.append(is_counted, is_other, axis=-1)
        places = np.where(is_counted, places, math.inf)
        ways = np.abs(np.log(places / np.asarray(here)[..., None]))
        found = np.take_along_axis(places, ways.argmin(axis=-1)[..., None], -1)[..., 0]
        return np.where(is_counted.any(axis=-1), found, self.first)

    @functools.cached_property
    def _all_turns(self) -> tuple[Array, Mask, Mask]:
        """Velocities [m/s] or loads [N] (..., n) at which wear changes, and two masks.

        Changes beyond the ends of a curve are included. There the rise follows a power law of
        velocity or load, or is not extrapolated if a value on the curve is not positive. Unused
        elements are NaN. The first mask (..., n) is True where wear turns from mild to severe. The
        second mask (...) is True if wear is severe beyond the last change.
        """
        if self.curve is not self.continued:
            return replace(self, curve=self.continued)._all_turns
        has_law = (self.curve.is_log & (self.curve.count > 0))[self.rows]
        has_law = has_law & np.isfinite(self.limit) & (self.limit > 0)
        is_severe = self.begins_severe ^ (np.isfinite(self.places).sum(axis=-1) % 2 == 1)
        first, last = (
            np.where(has_law & goes_on, self._continued_end(end), math.nan)[..., None]
            for end, goes_on in ((0, self.begins_severe), (-1, ~is_severe))
        )
        beyond = np.ones(first.shape, bool)
        places = np.concatenate([first, self.places, last], axis=-1)
        turns_severe = np.concatenate([beyond, self._turns_severe, beyond], axis=-1)
        return places, turns_severe, has_law | is_severe

    @property
    def transitions(self) -> Transitions:
        """Whether wear turns severe along each curve, and where it first does.

        `Transitions.first` has these velocities [m/s] or loads [N].
        """
        low, high = (np.where(self.outcome == UNKNOWN, math.nan, end) for end in self.computed)
        ends = np.fmin.reduce(low, axis=0), np.fmax.reduce(high, axis=0)
        alone = self.places[0] if len(self.places) == 1 else np.empty((0, 0))
        return Transitions(self.outcome, self.first, ends, alone)

    def severe_chance(self, velocities: Array, scatter: ModelError) -> Array:
        """Probability that a run is severe at each of `velocities` [m/s].

        The result has the shape of `Line.outcome`, to which the velocities are broadcast. A run at
        velocity V behaves like the model at V·exp(ε), where ε has the distribution `scatter`.
        """
        places, turns_severe, is_severe = self._all_turns
        below = scatter.below(np.log(places / np.asarray(velocities)[..., None]))
        shares = np.where(turns_severe, -below, below)
        shares = np.where(np.isnan(places), 0.0, shares).sum(axis=-1)
        return np.asarray(np.clip(shares + is_severe, 0.0, 1.0))

    def _continued_end(self, end: int) -> Array:
        """Velocity or load at which the power law beyond an end of each curve reaches the limit.

        `end` is 0 for the first point of a curve, -1 for the last.
        """
        parts = *self.curve.end(end), self.curve.end_exponent(end)
        x, y, slope = (part[self.rows] for part in parts)
        with np.errstate(all="ignore"):
            turn: Array = x * (self.limit / y) ** (1 / slope)
        return np.asarray(np.minimum(turn, x) if end == 0 else np.maximum(turn, x))


def in_words(
    outcome: str,
    computed: Iterable[float],
    along: str,
    turns: Sequence[float] = (),
    begins_severe: bool = False,
) -> str:
    """Describe an outcome in words, such as "mild at every velocity computed (to 3 m/s)".

    `outcome` is one of the texts of `outcomes`, and `along` is "velocity" or "load". `computed` has
    the lowest and highest computed velocity or load. `turns` are the values at which wear changes.
    If wear changes several times, the ranges of severe wear are stated. `begins_severe` is True if
    wear is severe below the first of `turns`.
    """
    words = outcomes(along)
    if outcome == words[SEVERAL] and len(turns):
        return severe_ranges(turns, begins_severe, along)
    low, high = (f"{end:.4g} {UNITS[along]}" for end in computed)
    reached = {words[ABOVE]: f" (to {high})", words[BELOW]: f" (from {low})"}
    return outcome + reached.get(outcome, "")


def severe_ranges(turns: Iterable[float], begins_severe: bool, along: str) -> str:
    """Ranges of severe wear in words, from the values `turns` at which wear changes.

    `begins_severe` is True if wear is severe below the first of `turns`. `along` is "velocity" or
    "load". Values of NaN are ignored.
    """
    places = [f"{place:.3g}" for place in turns if math.isfinite(place)]
    begins = ["", *places] if begins_severe else places
    ends = [*begins[1::2], ""][: len(begins[::2])]
    unit = UNITS[along]
    parts = [
        f"from {begin} to {end} {unit}" if begin and end
        else f"from {begin} {unit} on" if begin else f"up to {end} {unit}"
        for begin, end in zip(begins[::2], ends, strict=True)
    ]  # fmt: skip
    return f"severe {' and '.join(parts)}"


def range_of(data: Results, axis: str) -> tuple[float, float]:
    """Lowest and highest velocity [m/s] or load [N] (`axis`) of a scene, without 0."""
    present = (data.loads if axis == "load" else data.velocities).tolist()
    of_scene = data.sweep.loads if axis == "load" else data.sweep.velocities
    moving = [value for value in of_scene if value > 0] or present
    return float(min(moving)), float(max(moving))


class Transitions(NamedTuple):
    """Outcome along velocity or load on m surfaces, and where wear first turns severe.

    There is one line along velocity or load through each of k operating points.
    """

    outcome: Array  # codes (m, k), whose texts are in `outcomes`
    first: Array  # lowest velocity [m/s] or load [N] of severe wear (m, k), as `Line.first`
    computed: tuple[Array, Array]  # lowest and highest computed velocity or load, each (k,)
    places: Array = np.empty((0, 0))  # changes of wear (k, n) of a single surface; else empty

    def outcome_texts(self, along: str) -> Iterator[str]:
        """Yield the outcome in words for each operating point, along "velocity" or "load".

        If surfaces differ, the words count those on which wear changes, by outcome; if it
        changes on none, those with each outcome.
        """
        words = outcomes(along)
        for number, all_codes in enumerate(self.outcome.T.tolist()):
            codes = sorted(set(all_codes))
            ends, first = [end[number] for end in self.computed], self.first[0, number]
            turns = self.places[number] if len(self.places) else ()
            if len(codes) == 1:
                yield in_words(words[codes[0]], ends, along, turns, first == -math.inf)
                continue
            kinds = [code for code in codes if code in (CROSSES, SEVERAL)] or codes
            counts = [f"{words[kind]} on {all_codes.count(kind)}" for kind in kinds]
            yield f"{', '.join(counts)} of {len(all_codes)}"
