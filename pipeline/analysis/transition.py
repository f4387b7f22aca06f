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
    missing: Array  # places that are not
    #: The curve far beyond its ends, where it is no power law: friction by velocity is known there.
    continued: Curve | None = None

    @functools.cached_property
    def places(self) -> tuple[float, ...]:
        """Velocities [m/s] or loads [N] at which wear turns, ascending."""
        return self.curve.crossings(self.limit)

    @functools.cached_property
    def begins_severe(self) -> bool:
        """Wear is severe below the first of them."""
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
    def place(self) -> float:
        """First place at which wear turns severe; NaN where there is none."""
        return next(iter(self.places[self.begins_severe :]), math.nan)

    def nearest(self, here: float) -> float:
        """The place at which wear turns that is nearest by its ratio; NaN where nothing is known.

        It is infinite where wear is mild at all that is known, and 0 where severe.
        """
        if self.outcome in (MILD, ABOVE):
            return math.inf
        if self.outcome in (SEVERE, BELOW):
            return 0.0
        return min(self.places, key=lambda place: abs(math.log(place / here)), default=math.nan)

    def bridged(self, place: float) -> int:
        """Number of points not done between the two done ones beside a place."""
        done = np.setdiff1d(self.done, self.missing)
        below, above = done[done <= place], done[done >= place]
        if not (below.size and above.size):
            return 0
        return int(np.sum((self.missing > below[-1]) & (self.missing < above[0])))

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
    turns: Iterable[float] = (),
    begins_severe: bool = False,
) -> str:
    """One of `outcomes` along ``"velocity"`` or ``"load"``, with how far was computed.

    Of several turns the ranges in which wear is severe instead.
    """
    words = outcomes(along)
    if outcome == words[SEVERAL]:
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
    """Lowest and highest velocity [m/s] or load [N] of a scene, without a 0 that has no point."""
    present = ds[axis].values.tolist()
    plane = stored_sweep(ds).plane
    of_scene = plane.loads if axis == "load" else plane.velocities
    asked = [value for value in of_scene if value or 0.0 in present] or present
    return float(min(asked)), float(max(asked))


class Turns(NamedTuple):
    """Where wear turns on the members of a field, along an axis through a place."""

    outcome: Array  # of each member, (m,): keys of `outcomes`
    computed: tuple[float, float]  # lowest and highest place computed
    bridged: int  # most points not done that one of them is interpolated across
    places: Array  # places at which any member turns, (n,)
    steps: Array  # weights of these members, negative where they turn to mild wear, (n,)
    begins: float  # share of the members that are severe below all of them
    by_member: tuple[tuple[float, ...], ...] = ()  # the places of each, where members are few

    def shared(self, share: float = 0.5) -> tuple[tuple[float, ...], bool]:
        """Places beyond which more, or less, than a share of the members is severe, ascending.

        And whether more is below the first of them. Of members that turn once these are their
        quantiles.
        """
        order = np.argsort(self.places, kind="stable")
        places, steps = self.places[order], self.steps[order]
        after = self.begins + np.cumsum(steps)
        # From one turn to the next of its kind the share changes steadily, and else at turns alone.
        is_other = np.diff(steps > 0, prepend=np.nan, append=np.nan) != 0
        is_node = np.column_stack([is_other[:-1], np.ones_like(places, dtype=bool), is_other[1:]])
        shares = np.column_stack([after - steps, after - steps / 2, after])[is_node]
        x = np.repeat(places, 3)[is_node.ravel()]
        signs = np.sign((shares - share).round(12))
        (known,) = signs.nonzero()
        found = []
        (turning,) = np.nonzero(np.diff(signs[known]))
        for low, high in zip(known[turning], known[turning + 1], strict=True):
            if high == low + 1:
                part = (share - shares[low]) / (shares[high] - shares[low])
                found.append(float(x[low] + part * (x[high] - x[low])))
            else:  # in the middle, where exactly this share is severe
                found.append(float(x[low + 1] + x[high - 1]) / 2)
        return tuple(found), bool(signs[known[0]] > 0 if known.size else self.begins >= share)

    def nearest(self, here: float, share: float = 0.5, to_severe: bool = False) -> float:
        """The place nearest by its ratio at which half turns, or of another share beside that.

        It is infinite where the share is mild at all that is known, 0 where it is severe, and NaN
        where that of a member is not known; likewise where another share does not turn between
        the turns of the half beside that. Turns to severe wear alone may be asked for.
        """
        if (self.outcome == UNKNOWN).any():
            return math.nan
        places, begins = self.shared(share)
        half, half_begins = self.shared()
        none = 0.0 if begins else math.inf
        if counted := half[int(half_begins) :: 2] if to_severe else half:
            here = min(counted, key=lambda place: abs(math.log(place / here)))
            number = half.index(here)
            is_rise = number % 2 == half_begins
            # Another turn of the half ends the reach of this one.
            low, _, high = (0.0, *half, math.inf)[number : number + 3]
            same = places[int(begins == is_rise) :: 2]
            places = tuple(place for place in same if low < place < high)
            # There a smaller share is severe all along, and a larger one nowhere.
            none = 0.0 if (share < 0.5) == is_rise else math.inf
        elif to_severe:
            places = ()
        return min(places, key=lambda place: abs(math.log(place / here)), default=none)

    @classmethod
    def of(cls, lines: Sequence[Line], here: float) -> Turns:
        """Turns of lines about a velocity [m/s] or a load [N]."""
        known = [line for line in lines if line.outcome != UNKNOWN]
        weight = 1 / len(lines)
        steps = [
            weight if number % 2 == line.begins_severe else -weight
            for line in lines
            for number in range(len(line.places))
        ]
        return cls(
            np.array([line.outcome for line in lines]),
            (
                min((line.computed[0] for line in known), default=math.nan),
                max((line.computed[1] for line in known), default=math.nan),
            ),
            max(line.bridged(line.nearest(here)) for line in lines),
            np.array([place for line in lines for place in line.places]),
            np.array(steps),
            weight * sum(line.begins_severe for line in lines),
            tuple(line.places for line in lines),
        )
