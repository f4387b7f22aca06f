"""Where wear changes along a line of loads or velocities, and why it does not, in words."""

from __future__ import annotations

import enum
import functools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pipeline.analysis.curve import Curve
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


class Turns(NamedTuple):
    """Where wear changes along k lines, of rising velocity or of rising load."""

    places: Array  # ascending velocities [m/s] or loads [N] (k, n) at which it does, then NaN
    begins_severe: Mask  # True if wear is severe at the line's beginning (k,)
    outcome: Array  # codes (k,), whose texts are in `outcomes`
    computed: tuple[Array, Array]  # lowest and highest computed velocity or load, each (k,)

    @property
    def first(self) -> Array:
        """Lowest velocity [m/s] or load [N] at which wear turns severe (k,).

        It is minus infinity if wear is severe from the line's beginning, infinity if it is mild on
        the whole line, and NaN if unknown.
        """
        place = np.fmin.reduce(self.places, axis=-1)
        place = np.where(np.isnan(place), math.inf, place)
        place = np.where(self.begins_severe, -math.inf, place)
        return np.where(self.outcome == UNKNOWN, math.nan, place)

    @property
    def critical(self) -> Array:
        """`first` where it is a velocity or a load (k,); else NaN."""
        return np.where(np.isfinite(self.first), self.first, math.nan)

    def texts(self, axis: str) -> Iterator[str]:
        """Yield the outcome of each line in words, along "velocity" or "load"."""
        for number, code in enumerate(self.outcome.tolist()):
            ends = [float(end[number]) for end in self.computed]
            turns, begins = self.places[number].tolist(), bool(self.begins_severe[number])
            yield in_words(outcomes(axis)[code], ends, axis, turns, begins)


def turns_of(
    nodes: Array,
    lines: Array,
    limit: Array | float,
    done: Array,
    ends: tuple[float, float],
    turns_back: bool = False,
) -> Turns:
    """Find where k lines of rises (k, n) over ascending `nodes` (n,) pass the limit [K].

    With several limits (m,) the arrays of the result have the shape (k, m) in place of (k,).

    `done` (k, n) has the computed places, else NaN. `ends` are the lowest and the highest place of
    the sweep. `turns_back` is True if wear may change beyond either end of a line.
    """
    curve = Curve(nodes, lines)
    own = (slice(None), *[None] * np.ndim(limit))
    places = curve.crossings(np.asarray(limit), np.arange(len(lines))[own])
    begins_severe = np.asarray(Criterion.is_severe(curve.end(0)[1][own], limit))
    low, high = np.fmin.reduce(done, axis=-1)[own], np.fmax.reduce(done, axis=-1)[own]
    is_first, is_last = low <= ends[0], high >= ends[1]
    is_whole = np.where(begins_severe, is_first, is_last)
    is_whole = is_first & is_last if turns_back else is_whole
    count = np.isfinite(places).sum(axis=-1)
    kinds = (count == 1) & ~begins_severe, count > 0, np.isnan(low), is_whole
    throughout = np.where(begins_severe, SEVERE, MILD)
    beyond = np.where(begins_severe, BELOW, ABOVE)
    outcome = np.select(kinds, [CROSSES, SEVERAL, UNKNOWN, throughout], beyond)
    unknown = outcome == UNKNOWN
    computed = np.where(unknown, math.nan, low), np.where(unknown, math.nan, high)
    return Turns(places, begins_severe, outcome, computed)


def in_words(
    outcome: str,
    computed: Iterable[float],
    axis: str,
    turns: Sequence[float] = (),
    begins_severe: bool = False,
) -> str:
    """Describe an outcome in words, such as "mild at every velocity computed (to 3 m/s)".

    `outcome` is one of the texts of `outcomes`, and `axis` is "velocity" or "load". `computed` has
    the lowest and highest computed velocity or load. `turns` are the values at which wear changes.
    If wear changes several times, the ranges of severe wear are stated. `begins_severe` is True if
    wear is severe below the first of `turns`.
    """
    words = outcomes(axis)
    if outcome == words[SEVERAL] and len(turns):
        return severe_ranges(turns, begins_severe, axis)
    low, high = (f"{end:.4g} {UNITS[axis]}" for end in computed)
    reached = {words[ABOVE]: f" (to {high})", words[BELOW]: f" (from {low})"}
    return outcome + reached.get(outcome, "")


def severe_ranges(turns: Iterable[float], begins_severe: bool, axis: str) -> str:
    """Ranges of severe wear in words, from the values `turns` at which wear changes.

    `begins_severe` is True if wear is severe below the first of `turns`. `axis` is "velocity" or
    "load". Values of NaN are ignored.
    """
    places = [f"{place:.3g}" for place in turns if math.isfinite(place)]
    begins = ["", *places] if begins_severe else places
    ends = [*begins[1::2], ""][: len(begins[::2])]
    unit = UNITS[axis]
    parts = [
        f"from {begin} to {end} {unit}" if begin and end
        else f"from {begin} {unit} on" if begin else f"up to {end} {unit}"
        for begin, end in zip(begins[::2], ends, strict=True)
    ]  # fmt: skip
    return f"severe {' and '.join(parts)}"
