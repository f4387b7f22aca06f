"""The transition to severe wear along a line of points, with the computed range."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from pipeline.analysis.curve import Curve
from pipeline.analysis.dataset import stored_sweep
from pipeline.quantities import UNITS
from tribo import Criterion
from tribo.types import Array

CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL = range(7)
"""Values of the variables ``outcome_at_load`` and ``outcome_at_velocity``."""

BEYOND = (ABOVE, BELOW)
"""Outcomes that more points would tell."""


@functools.cache
def outcomes(axis: str) -> Mapping[int, str]:
    """Meanings of the outcomes along ``"velocity"`` or ``"load"``, in the words used everywhere."""
    return {
        CROSSES: "crosses",
        MILD: "mild throughout",
        SEVERE: "severe throughout",
        UNKNOWN: "not known yet",
        ABOVE: f"mild at every {axis} computed",
        BELOW: f"severe at every {axis} computed",
        SEVERAL: f"severe at some {axis} and mild at a higher one",
    }


LEAST_SLOPE = 0.05
"""Least slope of ln(rise) over ln(velocity or load), by which a line goes on beyond its ends."""


@dataclass(frozen=True, eq=False)
class Line:
    """Rises of a member of a field along velocities or loads, and where wear turns."""

    #: Rises [K] over velocities [m/s] or loads [N]. It may go on beyond the places that are done,
    #: where that leaves wear as it is.
    curve: Curve
    limit: float  # rise above which wear is severe [K]
    ends: tuple[float, float]  # of the sweep's own range
    done: Array  # places that are done, ascending
    #: The curve far beyond its ends, where it is no power law: friction by velocity is known there.
    continued: Curve | None = None

    @functools.cached_property
    def places(self) -> tuple[float, ...]:
        """Velocities [m/s] or loads [N] at which wear turns, ascending."""
        return self.curve.crossings(self.limit)

    @functools.cached_property
    def begins_severe(self) -> bool:
        """Wear is severe below the first of these places."""
        return bool(self.curve.x.size) and bool(Criterion.is_severe(self.curve.y[0], self.limit))

    @property
    def computed(self) -> tuple[float, float]:
        """Lowest and highest place that is done; NaN where none is."""
        return (float(self.done[0]), float(self.done[-1])) if self.done.size else (math.nan,) * 2

    @property
    def outcome(self) -> int:
        """Key of `outcomes`."""
        if self.places:
            return CROSSES if len(self.places) == 1 and not self.begins_severe else SEVERAL
        if not self.done.size:
            return UNKNOWN
        is_whole = (self.computed[0] <= self.ends[0], self.computed[1] >= self.ends[1])
        if self.continued:  # friction by velocity may turn wear at either end
            is_whole = (all(is_whole),) * 2
        if self.begins_severe:
            return SEVERE if is_whole[0] else BELOW
        return MILD if is_whole[1] else ABOVE

    @property
    def first(self) -> float:
        """First place at which wear turns severe.

        It is -infinite if wear is severe at the lowest place, infinite if wear is mild at every
        place, and NaN if nothing is known.
        """
        if self.outcome == UNKNOWN:
            return math.nan
        if self.begins_severe:
            return -math.inf
        return self.places[0] if self.places else math.inf

    def nearest(self, here: float, to_severe: bool = False, continued: bool = False) -> float:
        """The turn nearest by its ratio, or the nearest to severe wear; without one as `first`.

        If continued, a line without a turn has those of `severe`.
        """
        counted: Sequence[float] = (
            self.places[self.begins_severe :: 2] if to_severe else self.places
        )
        if continued and not counted:
            ends = [place for ends in self.severe() for place in ends[: 1 if to_severe else 2]]
            counted = [place for place in ends if 0 < place < math.inf]
        return min(counted, key=lambda place: abs(math.log(place / here)), default=self.first)

    def severe(self) -> list[tuple[float, float]]:
        """Ranges in which wear is severe, where the line goes on by the power law of its ends.

        They begin at 0, or go on to infinity, where it has no such law.
        """
        if self.continued:
            return replace(self, curve=self.continued, continued=None).severe()
        x, y = self.curve.x, self.curve.y
        turns = [0.0] * self.begins_severe + [*self.places]
        tops = [*turns[1::2], *[math.inf] * (len(turns) % 2)]
        ranges = [*zip(turns[::2], tops, strict=True)]
        if not (len(x) and 0 < self.limit < math.inf and (x > 0).all() and (y > 0).all()):
            return ranges

        def continued_end(end: int) -> float:
            slope = 1.0  # at most, of a point by itself
            if len(x) > 1:
                slope = max(self.curve.end_exponent(end), LEAST_SLOPE)
            return float(x[end] * (self.limit / y[end]) ** (1 / slope))

        if ranges and ranges[0][0] == 0:
            ranges[0] = (min(continued_end(0), float(x[0])), ranges[0][1])
        if not ranges or ranges[-1][1] < math.inf:
            ranges.append((max(continued_end(-1), float(x[-1])), math.inf))
        return ranges


def in_words(
    outcome: str,
    computed: Iterable[float],
    along: str,
    turns: Sequence[float] = (),
    begins_severe: bool = False,
) -> str:
    """One of `outcomes` along ``"velocity"`` or ``"load"``, with how far was computed.

    Where wear turns several times, the ranges in which it is severe instead, if turns are given.
    """
    words = outcomes(along)
    if outcome == words[SEVERAL] and len(turns):
        return severe_ranges(turns, begins_severe, along)
    low, high = (f"{end:.4g} {UNITS[along]}" for end in computed)
    reached = {words[ABOVE]: f" (to {high})", words[BELOW]: f" (from {low})"}
    return outcome + reached.get(outcome, "")


def severe_ranges(turns: Iterable[float], begins_severe: bool, along: str) -> str:
    """Ranges of severe wear between its turns, of which those that are NaN are none, in words."""
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


def range_of(ds: xr.Dataset, axis: str) -> tuple[float, float]:
    """Lowest and highest velocity [m/s] or load [N] of a scene, above 0."""
    present = ds[axis].values.tolist()
    plane = stored_sweep(ds).plane
    of_scene = plane.loads if axis == "load" else plane.velocities
    asked = [value for value in of_scene if value > 0] or present
    return float(min(asked)), float(max(asked))


class Transitions(NamedTuple):
    """Where wear first turns severe on the members of a field, along an axis through a place."""

    outcome: Array  # of each member, (m,): keys of `outcomes`
    first: Array  # of each member, (m,); see `Line.first`
    computed: tuple[float, float]  # lowest and highest place computed
    places: tuple[float, ...] = ()  # of a single member, all places at which wear turns

    @classmethod
    def of(cls, lines: Sequence[Line]) -> Transitions:
        """Transitions of lines over velocities [m/s] or loads [N]."""
        ends = [line.computed for line in lines if line.outcome != UNKNOWN]
        return cls(
            np.array([line.outcome for line in lines]),
            np.array([line.first for line in lines]),
            (
                min((low for low, _ in ends), default=math.nan),
                max((high for _, high in ends), default=math.nan),
            ),
            lines[0].places if len(lines) == 1 else (),
        )

    def worded(self, along: str) -> str:
        """Outcome along ``"velocity"`` or ``"load"``, or on how many of the members wear turns."""
        words, codes = outcomes(along), np.unique(self.outcome).tolist()
        if len(codes) == 1:
            begins_severe = bool(self.first[0] == -math.inf)
            return in_words(words[codes[0]], self.computed, along, self.places, begins_severe)
        kinds = [code for code in codes if code in (CROSSES, SEVERAL)] or codes
        counts = [f"{words[kind]} on {np.sum(self.outcome == kind)}" for kind in kinds]
        return f"{', '.join(counts)} of {len(self.outcome)}"
