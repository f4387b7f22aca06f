"""A record of friction over time: the friction in each of its stages, and its largest rises."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from pipeline.laboratory.commanded import Commanded, command_of, cut_stages, held_level, ramp_level
from tribo.types import Array

LEAST_ROWS = 20
"""Fewest rows of a trace."""
COMMANDS = "load", "velocity"
_FIRST = 3.0  # [s] at the beginning and at the end of a stage, at most a tenth of it
_LEAST_RISE = 0.1  # rise of friction that is listed, at least, over the median friction
_COARSER = 5  # factor between the lengths of filters that look for slower rises
_MOST_RISES = 3

Level = float | tuple[float, float] | None
"""Load [N] or velocity [m/s] of a stage; both ends of a ramp; None if it was not recorded."""


class LoadStage(NamedTuple):
    """A stage of a trace: its rows, and what was held in it."""

    rows: slice
    load: Level
    velocity: Level


class StageFriction(NamedTuple):
    """Friction in a stage, as medians: in its first seconds, overall, and in its last seconds."""

    begin: float
    steady: float
    highest: float
    end: float


class Rise(NamedTuple):
    """A rise of friction: the row at which half of it is reached, and friction before and after."""

    row: int
    low: float
    high: float


@dataclass(frozen=True)
class Trace:
    """Record of friction over time, without rows at rest; all arrays have shape (n,)."""

    time: Array  # from the first row of the record [s]
    running: Array  # the same without the time at rest [s]
    friction: Array
    load: Array | None = None  # [N], where it was recorded
    velocity: Array | None = None  # [m/s], positive in both directions
    bulk_temperature: Array | None = None  # [K]
    period: int = 1  # rows of one stroke to and fro; 1 without strokes

    @cached_property
    def commands(self) -> dict[str, Commanded]:
        """Commanded load and velocity in each row, those of both that were recorded."""
        columns = {name: getattr(self, name) for name in COMMANDS}
        return {name: command_of(x) for name, x in columns.items() if x is not None}

    @cached_property
    def stages(self) -> list[LoadStage]:
        """Stages of commanded load and velocity; without both the whole trace is one."""
        if not self.commands:
            return [LoadStage(slice(0, len(self.time)), None, None)]
        pieces = cut_stages([*self.commands.values()], self.running)
        stages = list[LoadStage]()
        for rows, is_ramp, begin, end in pieces:
            moved = dict(zip(self.commands, np.abs(end - begin) > 0.03, strict=True))
            levels: list[Level] = []
            for name in COMMANDS:
                column: Array | None = getattr(self, name)
                if column is None:
                    levels.append(None)
                elif is_ramp and moved[name]:
                    source = column if self.period == 1 else self.commands[name].values
                    low, high = (
                        ramp_level(source, self.running, rows, one) for one in (False, True)
                    )
                    levels.append((low, high))
                else:
                    levels.append(held_level(column, rows))
            stages.append(LoadStage(rows, *levels))
        return stages

    @cached_property
    def course(self) -> Array:
        """Friction (n,) without lone rows that stand out, and without turns of the stroke."""
        size = max(3, self.period + 1 - self.period % 2)
        course: Array = median_filter(self.friction, size=size, mode="mirror")
        return course

    def duration_of(self, stage: LoadStage) -> float:
        """Duration of a stage in motion [s], to the end of the interval of its last row."""
        time = self.running[stage.rows]
        return float(time[-1] - time[0] + np.median(np.diff(time)))

    def friction_of(self, stage: LoadStage) -> StageFriction:
        """Friction at the beginning of a stage, steady, highest and at its end."""
        time, course = self.time[stage.rows], self.course[stage.rows]
        reach = min(_FIRST, float(time[-1] - time[0]) / 10)
        first = course[: max(3, int(np.searchsorted(time, time[0] + reach)))]
        last = course[min(-3, -int(np.count_nonzero(time > time[-1] - reach))) :]
        steady = float(np.median(self.friction[stage.rows]))
        return StageFriction(
            float(np.median(first)), steady, float(course.max()), float(np.median(last))
        )

    def temperature_of(self, rows: slice) -> float | None:
        """Median bulk temperature [K] in some rows; None if it was not recorded there."""
        if self.bulk_temperature is None:
            return None
        values = self.bulk_temperature[rows]
        values = values[np.isfinite(values)]
        return float(np.median(values)) if values.size else None

    @cached_property
    def rises(self) -> list[Rise]:
        """The three largest lasting rises of friction, the largest first.

        The record is searched unfiltered, and then filtered over more and more rows as long as
        noise hides rises: no filter is longer than the rise that it shows.
        """
        noise = float(np.median(np.abs(np.diff(self.friction)))) * 1.4826 / math.sqrt(2)
        # Of n normal numbers the lowest and the highest are 2 √(2 ln n) standard deviations apart.
        noise *= 1 + 2 * math.sqrt(2 * math.log(len(self.time)))
        usual, size, found = float(np.median(self.course)), 1, list[tuple[Rise, slice]]()
        while True:
            course = uniform_filter1d(self.course, size, mode="nearest")
            scatter = noise / math.sqrt(size)
            for low, high in _upward_legs(course, max(_LEAST_RISE * usual, scatter)):
                rise = _rise(course, low, high, size)
                reach = slice(max(0, low - size), high + size)
                is_known = any(reach.start <= one.row <= reach.stop for one, _ in found)
                if not is_known:
                    found.append((rise, reach))
            size *= _COARSER
            if scatter <= _LEAST_RISE * usual or size > len(self.time) // 10:
                break
        rises = [rise for rise, _ in found if rise.high > rise.low]
        return sorted(rises, key=lambda one: one.low - one.high)[:_MOST_RISES]

    def stage_at(self, time: float) -> int:
        """Index of the stage at a time [s]; of the next one between stages, of the last at the end.

        Friction that rises while the load is raised belongs to the stage that begins.
        """
        ends = [float(self.time[stage.rows.stop - 1]) for stage in self.stages]
        return min(int(np.searchsorted(ends, time)), len(ends) - 1)


def _upward_legs(values: Array, least: float) -> Iterator[tuple[int, int]]:
    """Yield the ends (low, high) of rises by more than `least` that no such fall interrupts."""
    low, high, is_rising = 0, 0, False
    course = values.tolist()
    for row, value in enumerate(course):
        if not is_rising:
            if value < course[low]:
                low = row
            elif value > course[low] + least:
                high, is_rising = row, True
        elif value > course[high]:
            high = row
        elif value < course[high] - least:
            yield low, high
            low, is_rising = row, False
    if is_rising:
        yield low, high


def _rise(course: Array, low: int, high: int, size: int) -> Rise:
    """The rise between rows `low` and `high` of a course that was filtered over `size` rows."""
    leg = course[low : high + 1]
    height, reach = leg[-1] - leg[0], max(5, size)
    row = low + 1 + int(np.flatnonzero(leg < leg[0] + height / 2)[-1])
    begins = low + int(np.flatnonzero(leg[: row - low] <= leg[0] + height / 10)[-1])
    ends = row + int(np.argmax(leg[row - low :] >= leg[-1] - height / 10))
    before = course[max(0, begins + 1 - 2 * reach) : begins + 1]
    after = course[ends : ends + 2 * reach]
    return Rise(row, float(np.median(before)), float(np.median(after)))
