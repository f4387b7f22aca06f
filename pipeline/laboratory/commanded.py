"""Load and velocity as they were commanded, estimated from measured ones, and the stages of both.

The course of all commands over time is simplified to straight pieces (Ramer–Douglas–Peucker). A
piece is a hold or a ramp; steps, short ramps between holds, and a run-down at the end are no stage.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from tribo.types import Array

_APART = 0.03  # least difference between two stages, over the highest load or velocity
_DRIFT = 0.05, 0.3  # drift of a hold, at most: over the highest value, and over its own
_CORNER = 0.02  # deviation of a command from straight pieces, over its highest value
_DEVIATIONS = 4.5  # that deviation, at least, in standard deviations of the command
_ALIKE = 10  # factor between the rates of two pieces of one ramp
_LEAST_OF_LINE = 7  # fewest rows from which the end of a ramp follows
_SHORT = 0.25  # a ramp or an excursion shorter than this share of the stage beside it is none
_BRIEF = 0.02  # so short a hold, relative to the longest stage, is an overshoot
_REST = 0.02  # share of the highest load or speed below which the rig is at rest
_STOPPED = 0.3  # share of its load or speed to which a run-down falls
_LEAST_ROWS = 3  # fewest rows of a stage
_FILTERED = 5  # rows of the shortest filter, which makes short holds at corners
_MOST_POINTS = 20_000  # of a command from which corners are found
_NEAR = 0.05  # relative deviation within which a level is held
_OF_SINE = 2 * math.sqrt(2) / math.pi  # mean of a rectified sine over its rms
_SINE_TOLERANCE = 0.02  # relative deviation of mean/rms from that ratio, for a sine
_SWING = 0.25  # amplitude of an oscillating signal, at least, over its mean
_MANY = 50  # this many oscillations are strokes, whatever the number of rows


class Piece(NamedTuple):
    """Consecutive rows of a trace in which all commands are held, or on a ramp."""

    rows: slice
    is_ramp: bool
    begin: Array  # commands at its first row, over their maxima, (n_command,)
    end: Array


def strokes(column: Array) -> int:
    """Number of times that a measured column crosses its mean, if it oscillates; else 0."""
    off = column / max(column.mean(), 1e-300) - 1
    crossings = np.count_nonzero(np.diff(np.sign(off[np.abs(off) > _SWING])))
    is_held = np.mean(np.abs(column - np.median(column)) <= 2 * _NEAR * np.median(column)) > 0.5
    is_many = crossings >= max(20, min(_MANY, len(column) / 40))
    return int(crossings) if is_many and not is_held else 0


class Commanded(NamedTuple):
    """Commanded load or velocity (n,), and the standard deviation of its estimate."""

    values: Array
    noise: float


def command_of(column: Array) -> Commanded:
    """Estimate the commanded load or velocity from the measured one, `column` (n,).

    The estimate is a mean over many strokes if the signal oscillates, else a running median.
    """
    if crossings := strokes(column):
        size = max(5, 20 * len(column) // crossings)
        return Commanded(uniform_filter1d(column, size, mode="reflect"), 0.0)
    # 80 % of steps are within 1.28 standard deviations, even if noise grows with load.
    noise = float(np.quantile(np.abs(np.diff(column)), 0.8)) / 1.28 / math.sqrt(2)
    # The median of n readings has 1.25/√n times the standard deviation of a reading. Four
    # standard deviations of the median must be below _APART.
    needed = (5 * noise / max(_APART * float(column.max()), 1e-300)) ** 2
    size = int(min(max(_FILTERED, needed), max(_FILTERED, len(column) // 20)))
    size += 1 - size % 2
    filtered: Array = median_filter(column, size=size, mode="reflect")
    return Commanded(filtered, 1.25 * noise / math.sqrt(size))


def at_rest(column: Array) -> Array:
    """Mask (n,) of the rows in which `column`, a load or velocity, is almost 0."""
    command = command_of(column).values
    result: Array = command <= _REST * command.max()
    return result


def held_level(column: Array, rows: slice) -> float:
    """Load or velocity that is held in most rows of a stage, else its mean over strokes."""
    values = column[rows]
    middle = float(np.median(values))
    if np.mean(np.abs(values - middle) <= _NEAR * middle) > 0.5:
        return middle
    mean, sine_mean = float(values.mean()), _OF_SINE * float(np.sqrt(np.mean(values**2)))
    return sine_mean if abs(mean / sine_mean - 1) < _SINE_TOLERANCE else mean


def ramp_level(column: Array, time: Array, rows: slice, is_end: bool) -> float:
    """Load or velocity at the beginning of a ramp, or at its end, from a line through a tenth."""
    count = max(_LEAST_OF_LINE, (rows.stop - rows.start) // 10)
    part = slice(max(rows.start, rows.stop - count), rows.stop)
    part = part if is_end else slice(rows.start, min(rows.stop, rows.start + count))
    at = time[part] - time[part.stop - 1 if is_end else part.start]
    values = column[part]
    for _ in range(3):  # rows that the drive's stop has already reached are off the line
        line = np.polyfit(at, values, 1) if np.ptp(at) > 0 else [0.0, np.median(values)]
        off = np.abs(values - np.polyval(line, at))
        is_near = off <= max(4 * float(np.median(off)), 1e-9 * float(np.abs(values).max()))
        at, values = at[is_near], values[is_near]
    return float(line[-1])


def cut_stages(commands: Sequence[Commanded], time: Array) -> list[Piece]:
    """Cut a trace into its stages, which are holds and ramps.

    `commands` are the load and velocity at each `time` in motion [s]. Rows between stages belong to
    none.
    """
    tops = [max(float(one.values.max()), 1e-300) for one in commands]
    shares = np.stack([one.values / top for one, top in zip(commands, tops, strict=True)], axis=1)
    noise = max(one.noise / top for one, top in zip(commands, tops, strict=True))
    return _stages_of(shares, time, max(_CORNER, _DEVIATIONS * noise))


def _stages_of(commands: Array, time: Array, tolerance: float) -> list[Piece]:
    """Stages of `commands` (n, n_command), over their maxima, which noise moves by `tolerance`."""
    joined = list[Piece]()
    for piece in _pieces(commands, time, tolerance):
        joined.append(piece)
        while (k := _joins_from(joined, time)) is not None:
            joined[k:] = [_piece(commands, slice(joined[k].rows.start, joined[-1].rows.stop))]
    longest = max(_span(time, piece) for piece in joined)
    held = list[Piece]()
    for k, piece in enumerate(joined):
        is_last = all(other.is_ramp for other in joined[k + 1 :])
        is_long = _span(time, piece) >= _BRIEF * longest or (is_last and _rows(piece) > _FILTERED)
        if piece.is_ramp or is_long:
            held.append(piece)
        elif held and held[-1].is_ramp and np.abs(held[-1].end - piece.begin).max() <= tolerance:
            held[-1] = _piece(commands, slice(held[-1].rows.start, piece.rows.stop))
    spans = [_span(time, piece) for piece in held]
    stages = [
        piece
        for k, piece in enumerate(held)
        if _rows(piece) >= _LEAST_ROWS and not (piece.is_ramp and _is_transition(held, spans, k))
    ]
    while stages[1:] and _is_run_down(stages, time):
        del stages[-1]
    return stages or [max(joined, key=lambda one: _span(time, one))]


def _pieces(commands: Array, time: Array, tolerance: float) -> Iterator[Piece]:
    """Yield the straight pieces of all commands together; each begins where the last one ends."""
    stride = -(-len(time) // _MOST_POINTS)
    places = np.arange(0, len(time), stride)
    corners = [*places[_corners(commands[places], time[places], tolerance)], len(time) - 1]
    for first, last in pairwise(corners):
        yield _piece(commands, slice(int(first), int(last) + 1))


def _piece(commands: Array, rows: slice) -> Piece:
    """The piece of some rows, which is a ramp if a command drifts too much."""
    values, quarter = commands[rows], max(1, (rows.stop - rows.start) // 4)
    begin, end = np.median(values[:quarter], axis=0), np.median(values[-quarter:], axis=0)
    change, own = np.abs(end - begin), np.minimum(begin, end)
    is_ramp = bool((change > np.minimum(_DRIFT[0], _DRIFT[1] * own)).any())
    return Piece(rows, is_ramp, *((values[0], values[-1]) if is_ramp else (begin, end)))


def _corners(commands: Array, time: Array, tolerance: float) -> list[int]:
    """Rows between which `commands` (n, n_command) are straight over `time` [s], by `tolerance`."""
    corners, open_pieces = {0}, [(0, len(time) - 1)]
    while open_pieces:
        first, last = open_pieces.pop()
        inner = slice(first + 1, last)
        share = (time[inner] - time[first]) / max(time[last] - time[first], 1e-300)
        chord = commands[first] + share[:, None] * (commands[last] - commands[first])
        off = np.abs(commands[inner] - chord).max(axis=1, initial=0.0)
        if off.size and off.max() > tolerance:
            corner = first + 1 + int(np.argmax(off))
            corners.add(corner)
            open_pieces += [(first, corner), (corner, last)]
    return sorted(corners)


def _joins_from(pieces: Sequence[Piece], time: Array) -> int | None:
    """Index from which the last pieces are one: a ramp goes on, or a hold after an excursion."""
    *others, last = pieces
    if others and (last.is_ramp or others[-1].is_ramp) and _goes_on(others[-1], last, time):
        return len(others) - 1
    if last.is_ramp:
        return None
    for k in range(len(others) - 1, max(-1, len(others) - 9), -1):
        first = others[k]
        if first.is_ramp or np.abs(first.end - last.begin).max() > _APART:
            continue
        away = others[k + 1 :]
        highest = max((float((one.end - first.end).max()) for one in away), default=0.0)
        lasts = sum(_span(time, one) for one in away)
        share = _BRIEF if highest > _APART else _SHORT  # what was higher decides the wear
        return k if lasts <= share * max(_span(time, first), _span(time, last)) else None
    return None


def _goes_on(before: Piece, ramp: Piece, time: Array) -> bool:
    """True if a ramp has the direction of the ramp before it, and nearly its rate."""
    ways = [one.end - one.begin for one in (before, ramp)]
    first, second = (float(np.linalg.norm(way)) for way in ways)
    rates = first * _span(time, ramp), second * _span(time, before)
    return float(ways[0] @ ways[1]) > 0.8 * first * second and max(rates) <= _ALIKE * min(rates)


def _is_transition(pieces: Sequence[Piece], spans: Sequence[float], k: int) -> bool:
    """True if ramp `k` only leads to the first stage, or from one hold to the next."""
    before = [span for span, one in zip(spans[:k], pieces[:k], strict=True) if not one.is_ramp]
    after = [
        span for span, one in zip(spans[k + 1 :], pieces[k + 1 :], strict=True) if not one.is_ramp
    ]
    if not before:
        return spans[k] <= _SHORT * max(spans[k + 1 :], default=0.0)
    # The last hold may be short, as a scuff ends it.
    # A last ramp is a stage: the test may have ended on it.
    return bool(after) and spans[k] <= (min if after[1:] else max)(before[-1], after[0])


def _is_run_down(stages: Sequence[Piece], time: Array) -> bool:
    """True if in the last stage the rig only runs down: its load or velocity is nearly 0."""
    *before, last = stages
    spans = [_span(time, piece) for piece in before]
    if last.is_ramp:
        return bool((last.end < _STOPPED * last.begin).any()) and _span(time, last) <= sum(spans)
    return bool((last.end < _STOPPED).any()) and _span(time, last) <= _SHORT * max(spans)


def _rows(piece: Piece) -> int:
    rows: int = piece.rows.stop - piece.rows.start
    return rows


def _span(time: Array, piece: Piece) -> float:
    return float(time[piece.rows.stop - 1] - time[piece.rows.start])
