"""The transition to severe wear along a line of points, with the computed range."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from pipeline.analysis.curve import Curve
from pipeline.analysis.dataset import stored_sweep
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


UNITS = {"velocity": "m/s", "load": "N"}


@dataclass(frozen=True, slots=True)
class Transition:
    """Where wear turns severe, or mild again, along a line of points, and why if it does not."""

    places: tuple[float, ...]  # velocities [m/s] or loads [N] at which wear turns, ascending
    begins_severe: bool  # wear is severe below the first of them
    outcome: int  # key of `outcomes`
    computed: tuple[float, float]  # lowest and highest that is done; NaN where none is
    missing: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())  # done ones, and those not done

    @classmethod
    def along(
        cls, curve: Curve, limit: float, ends: tuple[float, float], done: Array, missing: Array
    ) -> Transition:
        """Find where a curve of rises [K] passes a limit, along velocities [m/s] or loads [N].

        Done and missing are abscissae; the curve may go on beyond those that are done, where that
        leaves wear as it is. Ends are those of the sweep's own range.
        """
        computed = (float(done[0]), float(done[-1])) if done.size else (math.nan, math.nan)
        places = curve.crossings(limit)
        begins_severe = bool(curve.x.size) and Criterion.is_severe(curve.y[0], limit)
        if places:
            outcome = CROSSES if len(places) == 1 and not begins_severe else SEVERAL
        elif not done.size:
            outcome = UNKNOWN
        elif begins_severe:
            outcome = SEVERE if computed[0] <= ends[0] else BELOW
        else:
            outcome = MILD if computed[1] >= ends[1] else ABOVE
        about = (tuple(done.tolist()), tuple(missing.tolist())) if missing.size else ((), ())
        return cls(places, bool(begins_severe), outcome, computed, about)

    def nearest_or_beyond(self, here: float) -> float:
        """See `nearest`; infinite where wear is mild at all that is known, and 0 where severe."""
        if self.outcome in (MILD, ABOVE):
            return math.inf
        return 0.0 if self.outcome in (SEVERE, BELOW) else self.nearest(here)

    @property
    def place(self) -> float:
        """First place at which wear turns severe; NaN where there is none."""
        return next(iter(self.places[self.begins_severe :]), math.nan)

    def nearest(self, here: float) -> float:
        """The place at which wear turns that is nearest by its ratio; NaN where there is none."""
        return min(self.places, key=lambda place: abs(math.log(place / here)), default=math.nan)

    def bridged(self, place: float) -> int:
        """Number of points not done between the two done ones beside a place."""
        done, missing = self.missing
        below = max((x for x in done if x <= place and x not in missing), default=None)
        above = min((x for x in done if x >= place and x not in missing), default=None)
        if below is None or above is None:
            return 0
        return sum(below < x < above for x in missing)

    def severe(self) -> list[tuple[float, float]]:
        """Ranges in which wear is severe, from 0 and to infinity where they have no end."""
        turns = [0.0] * self.begins_severe + [*self.places]
        is_severe_beyond = self.outcome in (SEVERE, BELOW) or len(turns) % 2
        return [
            *zip(turns[::2], [*turns[1::2], *[math.inf] * bool(is_severe_beyond)], strict=False)
        ]


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
    words, unit = outcomes(along), UNITS[along]
    if outcome == words[SEVERAL]:
        places = [f"{place:.3g}" for place in turns if math.isfinite(place)]
        begins = [None, *places] if begins_severe else places
        ends = [*begins[1::2], None][: len(begins[::2])]
        parts = [
            f"up to {end}" if begin is None else f"from {begin} {f'to {end}' if end else 'on'}"
            for begin, end in zip(begins[::2], ends, strict=True)
        ]
        return f"severe {' and '.join(parts)} {unit}"
    low, high = (f"{end:.4g} {unit}" for end in computed)
    reached = {words[ABOVE]: f" (to {high})", words[BELOW]: f" (from {low})"}
    return outcome + reached.get(outcome, "")


def range_of(ds: xr.Dataset, axis: str) -> tuple[float, float]:
    """Lowest and highest velocity [m/s] or load [N] of a scene, without a 0 that has no point."""
    present = ds[axis].values.tolist()
    plane = stored_sweep(ds).plane
    of_scene = plane.loads if axis == "load" else plane.velocities
    asked = [value for value in of_scene if value or 0.0 in present] or present
    return float(min(asked)), float(max(asked))


class Turns(NamedTuple):
    """Transitions of the members of a field along an axis through a place, shape (m,)."""

    #: Nearest place at which wear turns; infinite where wear is mild at all that is known, 0 where
    #: severe, and NaN where nothing is known.
    nearest: Array
    outcome: Array  # keys of `outcomes`
    computed: tuple[float, float]  # lowest and highest place computed
    bridged: int  # most points not done that one of them is interpolated across
    places: tuple[tuple[float, ...], ...] = ()  # all places of each, where more than one is known

    @classmethod
    def of(cls, transitions: Sequence[Transition], here: float) -> Turns:
        """Turns of transitions about a velocity [m/s] or a load [N]."""
        nearest = np.array([one.nearest_or_beyond(here) for one in transitions])
        pairs = [*zip(transitions, nearest.tolist(), strict=True)]
        known = [one for one in transitions if one.outcome != UNKNOWN]
        return cls(
            nearest,
            np.array([one.outcome for one in transitions]),
            (
                min((one.computed[0] for one in known), default=math.nan),
                max((one.computed[1] for one in known), default=math.nan),
            ),
            max(one.bridged(place) for one, place in pairs),
            tuple(one.places for one in transitions),
        )
