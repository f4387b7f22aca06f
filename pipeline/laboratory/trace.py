"""A record of friction over time: its stages of load and velocity, and where scuffing begins."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from pipeline.quantities import UNITS, display
from pipeline.scene.names import UNITS as SI_UNITS
from tribo.types import Array

LEAST_ROWS = 20
"""Fewest rows of a trace."""
_APART = 0.03  # least difference between two stages, over the highest load or velocity
_SHORT = 0.25  # a shorter ramp or level, relative to the stage beside it, is ignored
_LEAST_OF_STAGE = 3  # fewest rows of a stage
_REST = 0.02  # share of the highest load or speed below which the rig is at rest
_NEAR = 0.05  # relative deviation within which a level is held
_START = 0.1  # share of the first stage in which friction still settles
_LEAST_RISE = 0.3  # relative rise of friction; less is running-in or a change of film
_SURE_RISE = 1.0  # relative rise above which it need not be sudden
_SUDDEN = 0.05  # half of a sudden rise comes within this share of the stage
_STANDARD_DEVIATIONS = 4.0  # a rise below this multiple of friction's noise is scatter
_OF_SINE = 2 * math.sqrt(2) / math.pi  # mean of a rectified sine over its rms
_SINE_TOLERANCE = 0.02  # relative deviation of mean/rms from that ratio, for a sine
_SWING = 0.25  # amplitude of an oscillating signal, at least, over its mean
_MANY = 50  # this many oscillations are strokes, whatever the number of rows
_COMMANDS = "load", "velocity"


class LoadStage(NamedTuple):
    """A stage of a trace: its rows, load [N] and velocity [m/s]; on a ramp these are means.

    Load or velocity is None if the trace does not have it.
    """

    rows: slice
    load: float | None
    velocity: float | None
    is_ramp: bool = False


class Candidate(NamedTuple):
    """A rise of friction that may be scuffing, and the reason if it does not count as scuffing.

    `row` is the index, counted from 0, in the arrays of `Trace` at which the rise happens. `stage`
    is the number of the stage, counted from 1. `low` and `high` are the friction coefficients
    before and after the rise. `why_not` is the reason; it is empty for scuffing.
    """

    row: int
    stage: int
    low: float
    high: float
    why_not: str = ""


@dataclass(frozen=True)
class Trace:
    """Record of friction over time, without rows at rest; all arrays have shape (n,)."""

    time: Array  # [s]
    friction: Array
    load: Array | None = None  # [N], where it was recorded
    velocity: Array | None = None  # [m/s], positive in both directions
    bulk_temperature: Array | None = None  # [K]

    @cached_property
    def stages(self) -> list[LoadStage]:
        """Stages of constant load and velocity, and ramps; short ramps between stages are left out.

        Without load and velocity the whole trace is one stage.
        """
        columns = [x for name in _COMMANDS if (x := getattr(self, name)) is not None]
        ends = [slice(0, len(self.time))]
        ramps = [False]
        if columns:
            commands = np.stack([_setpoint(x) / max(x.max(), 1e-300) for x in columns], axis=1)
            ends, ramps = _cut_stages(commands, self.time)
        return [
            LoadStage(rows, _level(self.load, rows), _level(self.velocity, rows), is_ramp)
            for rows, is_ramp in zip(ends, ramps, strict=True)
        ]

    @cached_property
    def candidates(self) -> list[Candidate]:
        """Rises of friction, up to and including the first rise that counts as scuffing."""
        found, end, last = list[Candidate](), math.inf, None
        for number, stage in enumerate(self.stages, 1):
            friction, noise = self._smoothed_friction(stage.rows)
            is_first = last is None
            slowest = (1 - _APART) * (last.velocity or 0) if last else 0
            is_slower = (stage.velocity or 0) < slowest
            previous = math.inf if is_first or is_slower else end
            skipped = max(2, math.ceil(_START * len(friction))) if previous == math.inf else 0
            faster = end if is_slower else math.inf
            rises = _rises(friction, previous, skipped, faster, _STANDARD_DEVIATIONS * noise)
            for row, low, high, why in rises:
                reason = f"{why} with a lower speed" if why == "begins" and is_slower else why
                reason = f"{why} the first stage" if why == "begins" and is_first else reason
                found.append(Candidate(stage.rows.start + row, number, low, high, reason))
                if not reason:
                    return found
            end, last = float(np.median(friction[-max(3, len(friction) // 4) :])), stage
        return found

    @property
    def scuff(self) -> Candidate | None:
        """The rise of friction that counts as scuffing; None without scuffing."""
        return next((one for one in self.candidates if not one.why_not), None)

    def _smoothed_friction(self, rows: slice) -> tuple[Array, float]:
        """Median-filtered friction of a stage (n,), and the standard deviation of its noise."""
        friction = self.friction[rows]
        size = max(3, len(friction) // 20)
        size += 1 - size % 2
        course: Array = median_filter(friction, size=size, mode="reflect")
        steps = np.abs(np.diff(friction)) if len(friction) > 1 else np.zeros(1)
        # A difference of two readings has √2 times the standard deviation of a reading. The median
        # of n readings has 1.25/√n times that of a reading.
        return course, 1.4826 * float(np.median(steps)) / math.sqrt(2) * 1.25 / math.sqrt(size)

    def lines(self) -> Iterator[str]:
        """Yield lines on each stage, and on each rise of friction and whether it is scuffing."""
        spans = (
            _span_text(name, [getattr(one, name) for one in self.stages]) for name in _COMMANDS
        )
        number = len(self.stages)
        count = "one stage" if number == 1 else f"{number} stages"
        yield ", ".join(filter(None, [count, *spans]))
        if self.scuff is None:
            middle = float(np.median(self.friction))
            duration = self.time[-1] - self.time[0]
            yield f"no transition: friction stays about {middle:.3g} for {duration:.4g} s"
        for one in self.candidates:
            load = "" if self.load is None else f", {self.load[one.row]:.4g} N"
            what = f"no scuffing, since it {one.why_not}" if one.why_not else "scuffing"
            yield (
                f"friction rises from {one.low:.3g} to {one.high:.3g} at {self.time[one.row]:.4g} s"
                f"{load}, in stage {one.stage}: {what}"
            )
        if self.scuff:
            yield "confirm it in the trace (-o trace.png) and on the surface"

    def tests(self) -> list[dict[str, str | float]]:
        """Tests found in the trace, as tables of a scene file.

        A trace may give one table with the ends of a stepwise run, a table for each stage, a single
        test, or a transition on a ramp.
        """
        severe = self.scuff
        number = severe.stage if severe else len(self.stages)
        stages = self.stages[:number]
        longest = max(_span(self.time, stage.rows) for stage in stages)
        mild = stages[: number - 1] if severe else stages
        mild = [one for one in mild if _span(self.time, one.rows) >= _SHORT * longest] or mild[-1:]
        # The hardest stage represents a mild run.
        last = stages[-1] if severe else max(mild, key=lambda x: (x.load or 1) * (x.velocity or 1))
        common = self._median_entries(last.rows, severe)
        if last.is_ramp:
            row = severe.row if severe else last.rows.stop - 1
            place = {name: getattr(self, name) for name in _COMMANDS}
            values = {name: None if x is None else float(x[row]) for name, x in place.items()}
            return [_place_as_text(values) | common | ({} if severe else {"outcome": "mild"})]
        outcomes = [(one, "mild") for one in mild] + ([(last, "severe")] if severe else [])
        if len(outcomes) == 1:
            return [_place_as_text(last._asdict()) | common | {"outcome": outcomes[0][1]}]
        varied = [
            name for name in _COMMANDS if _is_varied([getattr(one, name) for one, _ in outcomes])
        ]
        if len(varied) == 1:
            (name,) = varied
            ends = [getattr(one, name) for one, _ in outcomes]
            top = ends[-1] if severe else math.inf
            held = [value for value in ends[: len(mild)] if value < top]
            run = {"mild_up_to": _text(name, max(held))} if held else {}
            run |= {"severe_at": _text(name, top)} if severe else {}
            return [run | _place_as_text(last._asdict(), without=name) | common]
        return [
            _place_as_text(one._asdict())
            | self._median_entries(one.rows, severe if outcome == "severe" else None)
            | {"outcome": outcome, "run": 1}
            for one, outcome in outcomes
        ]

    def _median_entries(self, rows: slice, severe: Candidate | None) -> dict[str, str | float]:
        """Entries of a test, by name: median friction of a stage, and median bulk temperature.

        `rows` are the rows of the stage. `severe` is the rise of friction at which the stage
        scuffs, or None; both medians leave out the rows from this rise on. If that leaves up to
        three rows, friction is the median since the beginning of the trace. Bulk temperature, text
        with a unit, is always such a median; it is left out if it was not recorded.
        """
        end = severe.row if severe else rows.stop
        begin = rows.start if end > rows.start + _LEAST_OF_STAGE else 0
        values: dict[str, str | float] = {
            "friction": float(f"{np.median(self.friction[begin:end]):.3g}")
        }
        if self.bulk_temperature is not None:
            warm = float(np.nanmedian(self.bulk_temperature[: max(end, 1)]))
            values["bulk_temperature"] = display(warm, "°C", 4).replace("°", "deg")
        return values


def _span_text(name: str, levels: Sequence[float | None]) -> str:
    """Range of `levels` as text such as "100 N to 600 N", or "100 N" if they are equal.

    `levels` are loads [N] or velocities [m/s], as `name` ("load" or "velocity") tells. Levels of
    None are left out; without others the text is empty.
    """
    known = [level for level in levels if level is not None]
    ends = dict.fromkeys(_text(name, one) for one in (min(known), max(known))) if known else {}
    return " to ".join(ends)


def _text(name: str, value: float) -> str:
    return f"{value:.4g} {UNITS[name]}"


def _place_as_text(values: dict[str, float | None], without: str = "") -> dict[str, str | float]:
    """Load and velocity of a test by name, each as text with its unit, such as "600 N".

    A value of None becomes a text such as "... N", for the user to fill in. `without` is the name
    of the one to leave out; by default none is left out.
    """
    return {
        name: f"... {SI_UNITS[name]}" if (value := values[name]) is None else _text(name, value)
        for name in _COMMANDS
        if name != without
    }


def _is_varied(levels: Sequence[float | None]) -> bool:
    """True if the `levels` of load or velocity differ between stages."""
    known = [level for level in levels if level is not None]
    return bool(known) and max(known) - min(known) > _APART * max(known)


def _level(column: Array | None, rows: slice) -> float | None:
    """Load or velocity that is held for most of a stage, else the mean; None without a column."""
    if column is None:
        return None
    values = column[rows]
    middle = float(np.median(values))
    if np.mean(np.abs(values - middle) <= _NEAR * middle) > 0.5:
        return middle
    mean, sine_mean = float(values.mean()), _OF_SINE * float(np.sqrt(np.mean(values**2)))
    return sine_mean if abs(mean / sine_mean - 1) < _SINE_TOLERANCE else mean


def at_rest(column: Array) -> Array:
    """Mask (n,) of the rows in which `column`, a load or velocity, is almost 0."""
    command = _setpoint(column)
    result: Array = command <= _REST * command.max()
    return result


def _setpoint(column: Array) -> Array:
    """Estimate the commanded load or velocity (n,) from the measured one, `column`.

    The estimate is a mean over many strokes if the signal oscillates, else a running median.
    """
    off = column / max(column.mean(), 1e-300) - 1
    crossings = np.count_nonzero(np.diff(np.sign(off[np.abs(off) > _SWING])))
    is_held = np.mean(np.abs(column - np.median(column)) <= 2 * _NEAR * np.median(column)) > 0.5
    if is_held or crossings < max(20, min(_MANY, len(column) / 40)):
        # 80 % of steps are within 1.28 standard deviations, even if noise grows with load.
        noise = float(np.quantile(np.abs(np.diff(column)), 0.8)) / 1.28 / math.sqrt(2)
        # The median of n readings has 1.25/√n times the standard deviation of a reading. Four
        # standard deviations of the median must be below _APART.
        needed = (5 * noise / max(_APART * float(column.max()), 1e-300)) ** 2
        size = int(min(max(5, needed), max(5, len(column) // 20)))
        filtered: Array = median_filter(column, size=size + 1 - size % 2, mode="reflect")
        return filtered
    mean: Array = uniform_filter1d(column, max(5, 20 * len(column) // crossings), mode="reflect")
    return mean


def _cut_stages(commands: Array, time: Array) -> tuple[list[slice], list[bool]]:
    """Cut a trace into stages; return the rows of each, and whether it is a ramp.

    `commands` (n, n_command) are load and velocity at each `time` [s], divided by their maxima.
    Rows of a short ramp beside a stage belong to no stage.
    """
    ends, level, count, away = [0], commands[0].copy(), 1, 0
    for row, now in enumerate(commands):
        if np.abs(now - level).max() > _APART:
            away += 1
            if away == 2:  # a single row may be noise
                ends.append(row - 1)
                level, count, away = now.copy(), 1, 0
        else:
            away, count = 0, count + 1
            level += (now - level) / count
    cuts = [slice(a, b) for a, b in zip(ends, [*ends[1:], len(commands)], strict=True)]
    pieces, levels = cuts[:1], [np.median(commands[cuts[0]], axis=0)]
    for piece in cuts[1:]:
        if np.abs(np.median(commands[piece], axis=0) - levels[-1]).max() <= _APART:
            piece = slice(pieces.pop().start, piece.stop)  # noise separated the pieces
            levels.pop()
        pieces.append(piece)
        levels.append(np.median(commands[piece], axis=0))
    merged = [(pieces[0], levels[0], _is_ramp(commands, pieces, levels, 0))]
    for k, piece in enumerate(pieces[1:], 1):
        is_ramp = _is_ramp(commands, pieces, levels, k)
        before, _, was_ramp = merged[-1]
        if was_ramp and (is_ramp or _continues_ramp(commands, time, before, piece)):
            merged[-1] = slice(before.start, piece.stop), levels[k], True
            continue
        merged.append((piece, levels[k], is_ramp))
        if len(merged) > 2:  # a short excursion from a level and back
            (first, own, _), (middle, *_), (last, now, _) = merged[-3:]
            length = max(_span(time, first), _span(time, last))
            is_back = np.abs(own - now).max() <= _APART and not is_ramp
            if is_back and _span(time, middle) <= _SHORT * length:
                merged[-3:] = [(slice(first.start, last.stop), own, False)]
    kept = []
    for k, (piece, _, is_ramp) in enumerate(merged):
        beside = [
            _span(time, other) for other, _, ramp in merged[max(0, k - 1) : k + 2] if not ramp
        ]
        if not is_ramp or not beside or _span(time, piece) > _SHORT * max(beside):
            kept.append((piece, is_ramp))
    return [piece for piece, _ in kept], [is_ramp for _, is_ramp in kept]


def _continues_ramp(commands: Array, time: Array, ramp: slice, piece: slice) -> bool:
    """True if a short `piece` after a `ramp` continues at half the ramp's rate or more.

    Both are rows of the trace, with load and velocity in `commands` (n, n_command).
    """
    if _span(time, piece) >= _SHORT * _span(time, ramp):
        return False
    way, other = (commands[one.stop - 1] - commands[one.start] for one in (ramp, piece))
    leading = int(np.argmax(np.abs(way)))
    rate = way[leading] / _span(time, ramp)
    return bool(other[leading] * rate >= rate**2 * _span(time, piece) / 2)


def _span(time: Array, rows: slice) -> float:
    return float(time[rows.stop - 1] - time[rows.start])


def _is_ramp(commands: Array, pieces: Sequence[slice], levels: Sequence[Array], k: int) -> bool:
    """True if piece `k` of a trace is a ramp, not a stage of constant load and velocity.

    `commands` (n, n_command) are load and velocity in each row, divided by their maxima. `levels`
    are medians of `commands` in each of the `pieces`. A ramp has very few rows, or its load or
    velocity drifts by over a third of the step to a neighbouring piece.
    """
    rows = commands[pieces[k]]
    quarter = max(1, len(rows) // 4)
    drift = np.abs(np.median(rows[-quarter:], axis=0) - np.median(rows[:quarter], axis=0)).max()
    ways = [np.abs(levels[k] - levels[j]).max() for j in (k - 1, k + 1) if 0 <= j < len(levels)]
    return bool(ways) and bool(drift > min(ways) / 3 or len(rows) < _LEAST_OF_STAGE)


def _rises(
    friction: Array, previous: float, skipped: int, previous_faster: float, scatter: float
) -> Iterator[tuple[int, float, float, str]]:
    """Yield large rises of friction in a stage, each as a tuple (row, low, high, why_not).

    `row` is counted from the beginning of the stage. `low` and `high` are friction before and after
    the rise. `why_not` is the reason why the rise is not scuffing, empty if it is scuffing.

    - `friction` (n,) is the smoothed coefficient of friction in each row of the stage.
    - `previous` is friction at the end of the previous stage. It is infinite if there is no
      previous stage, or if that stage was faster.
    - `skipped` is the number of rows at the beginning in which friction still settles. A rise in
      these rows is not scuffing.
    - `previous_faster` is friction at the end of the previous stage if that stage was faster, else
      infinite.
    - `scatter` is an allowance for noise. A rise is large if it exceeds a fixed share of `low` by
      more than `scatter`.
    """
    own = friction[skipped:]
    first = previous if math.isfinite(previous) else own[0]
    lowest = np.minimum.accumulate(np.concatenate([[first], own]))[:-1]
    least = np.minimum.accumulate(own[::-1])[::-1]
    limit = lowest * (1 + _LEAST_RISE) + scatter
    start = min(float(friction[: skipped + 1].min()), previous_faster)
    if skipped and own[0] > start * (1 + _LEAST_RISE) + scatter:
        yield 0, start, float(own[0]), "begins"
    row = 0
    while row < len(own):
        if own[row] <= limit[row]:
            row += 1
            continue
        low, high = float(lowest[row]), float(np.median(own[row:]))
        if least[row] > limit[row]:
            is_sudden = _is_sudden(np.concatenate([[low], own]), row + 1, (high - low) / 2)
            if not is_sudden:  # the rise may continue to the end
                high = max(high, float(np.median(own[-max(3, (len(own) - row) // 4) :])))
            is_sure = is_sudden or high > low * (1 + _SURE_RISE)
            yield skipped + row, low, high, "" if is_sure else "comes slowly"
            return
        end = row + int(np.argmax(own[row:] <= limit[row]))
        yield skipped + row, low, float(own[row:end].max()), "falls back"
        row = end + 1


def _is_sudden(friction: Array, row: int, half: float) -> bool:
    """True if friction rises by `half` or more near index `row`, within a small share of a stage.

    `friction` (n,) is the coefficient of friction in each row of one stage: a level or ramp of
    load and velocity. `half` is half of the rise, from the lowest friction before index `row` to
    the median friction after it.
    """
    reach = max(2, math.ceil(_SUDDEN * len(friction)))
    near = friction[max(0, row - reach) : row + 2 * reach]
    steps = near[min(reach, len(near) - 1) :] - near[: max(1, len(near) - reach)]
    return bool(steps.max() >= half)
