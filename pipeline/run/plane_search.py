"""Which points of a plane its boundary needs: loads by halving, at each a search by velocity."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pipeline.run.line_search import Line
from tribo.types import Array

FEWEST_LOADS, OF_CROSSING, OF_PREDICTION = 3, 1 / 3, 1 / 6
_SLOPE = -0.8  # of ln(critical velocity) over ln(load), for a first guess


def next_points(loads: Array, lines: Sequence[Line], tolerance: float) -> list[tuple[int, int]]:
    """Indices of load and velocity of the points to compute next; empty once the boundary is known.

    `loads` are logarithms, ascending. It depends on computed points alone, and each load on those
    that were searched before it, so that a search that was killed asks for the same points again.
    """
    found: dict[int, Array] = {}
    for level in _levels(loads, lines, found, tolerance):
        guesses = {number: _guess(loads, lines, found, number) for number in level}
        steps = [
            (number, step)
            for number, guess in guesses.items()
            if (step := lines[number].wanted(guess, OF_CROSSING * tolerance)) is not None
        ]
        if steps:
            return steps
        found |= {number: lines[number].crossings() for number in level}
    return []


def _levels(
    loads: Array, lines: Sequence[Line], found: Mapping[int, Array], tolerance: float
) -> Iterator[list[int]]:
    """Yield loads to search together: the ends, then middles of spans whose crossings are known."""
    last = len(loads) - 1
    yield [0]
    if not last:
        return
    yield [last]
    spans = [(0, last)]
    while spans := [span for span in spans if span[1] - span[0] > 1]:
        before = dict(found)
        middles = []
        for first, end in spans:
            off_centre = np.abs(loads[first + 1 : end] - (loads[first] + loads[end]) / 2)
            middles.append(first + 1 + int(np.argmin(off_centre)))
        yield middles
        halves = []
        for (first, end), middle in zip(spans, middles, strict=True):
            spanned = [lines[one] for one in (first, middle, end)]
            patterns = {(line.is_severe, len(line.crossings())) for line in spanned}
            told = _predicted(loads, before, middle, len(found[middle]))
            off = 0.0 if told is None else np.max(np.abs(told - found[middle]), initial=0.0)
            if told is None or len(patterns) > 1 or off > OF_PREDICTION * tolerance:
                halves += [(first, middle), (middle, end)]
        spans = halves


def _predicted(loads: Array, found: Mapping[int, Array], number: int, count: int) -> Array | None:
    """Crossings at a load from the loads `found` that have as many; None if these are too few."""
    from scipy.interpolate import PchipInterpolator

    if not count:
        return np.empty(0)
    alike = sorted(one for one in found if len(found[one]) == count)
    if len(alike) < FEWEST_LOADS:
        return None
    curves = PchipInterpolator(loads[alike], [found[one] for one in alike], extrapolate=True)
    return np.asarray(curves(loads[number]))


def _guess(loads: Array, lines: Sequence[Line], found: Mapping[int, Array], number: int) -> float:
    """ln(velocity) at which to begin the search of a load: near the boundary of the loads found."""
    known = sorted(one for one in found if found[one].size)
    if not known:
        return float(lines[number].x.mean())
    nearest = sorted(sorted(known, key=lambda one: abs(loads[one] - loads[number]))[:2])
    first = np.array([found[one][0] for one in nearest])
    at = loads[nearest]
    slope = (first[-1] - first[0]) / (at[-1] - at[0]) if len(nearest) > 1 else _SLOPE
    return float(first[0] + slope * (loads[number] - at[0]))
