"""A trace of friction over time, as a rig records it: the transition in it, to be confirmed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.scene.headings import columns_for, heading_of, with_units_below
from pipeline.scene.rows import read_rows
from pipeline.scene.units import UnitError, to_si
from tribo.types import Array

_LIKE = {"time": "s", "friction": "", "load": "N", "velocity": "m/s", "friction_force": "N"}
_LEAST_ROWS = 20
_STANDARD_DEVIATIONS = 4.0  # of friction before, below which a rise is scatter
_LEAST_RISE = 0.2  # of friction before; less is running-in or a warmer film


@dataclass(frozen=True, slots=True)
class Trace:
    r"""Friction over time, and the row from which on it is high.

    Attributes
    ----------
    time, friction : array, shape (n,)
        Time [s] and coefficient of friction.
    load, velocity : array, shape (n,), or None
        Normal load [N] and sliding velocity [m/s], where they were recorded.
    row : int or None
        Row from which on friction is high; None if it does not rise.

    Examples
    --------
    >>> friction = np.r_[np.full(30, 0.1), np.full(30, 0.3)]
    >>> trace = Trace.of(np.arange(60.0), friction, load=np.linspace(0, 590, 60))
    >>> trace.row
    30
    >>> print(*trace.toml(), sep="\n")
    [[measured]]
    load = "300 N"
    velocity = "... m/s"  # not in the trace
    friction = 0.1
    """

    time: Array
    friction: Array
    load: Array | None
    velocity: Array | None
    row: int | None

    @classmethod
    def of(
        cls, time: Array, friction: Array, load: Array | None = None, velocity: Array | None = None
    ) -> Trace:
        """The trace of some columns, with its rise."""
        return cls(time, friction, load, velocity, rise(friction))

    def lines(self) -> Iterator[str]:
        """Say where friction rises, or that it does not."""
        if self.row is None:
            middle = float(np.median(self.friction))
            yield f"no transition: friction stays about {middle:.3g} for {self.time[-1]:.4g} s"
            return
        before, after = (float(np.median(part)) for part in np.split(self.friction, [self.row]))
        load = "" if self.load is None else f", at a load of {self.load[self.row]:.4g} N"
        yield (
            f"transition: friction rises from {before:.3g} to {after:.3g} at "
            f"{self.time[self.row]:.4g} s{load}; confirm it in the trace and on the surface"
        )

    def toml(self) -> Iterator[str]:
        """Lines of a scene: a transition, or a test that stayed mild."""
        end = len(self.time) - 1 if self.row is None else self.row
        yield "[[tested]]" if self.row is None else "[[measured]]"
        for name, unit in (("load", "N"), ("velocity", "m/s")):
            column = getattr(self, name)
            if column is None:
                yield f'{name} = "... {unit}"  # not in the trace'
            else:
                yield f'{name} = "{column[end]:.4g} {unit}"'
        yield f"friction = {float(np.median(self.friction[: end or None])):.3g}"
        if self.row is None:
            yield 'outcome = "mild"'


def rise(friction: Array) -> int | None:
    """Row from which on friction is high, by least squares of one step upwards; None without one.

    Examples
    --------
    >>> rise(np.r_[np.full(30, 0.1), np.full(30, 0.3)]), rise(np.full(60, 0.1))
    (30, None)
    """
    count = len(friction)
    if count < _LEAST_ROWS:
        return None
    before = np.arange(1, count)
    sums = np.cumsum(friction)
    low, high = sums[:-1] / before, (sums[-1] - sums[:-1]) / (count - before)
    gain = np.where(high > low, before * (count - before) * (high - low) ** 2, 0.0)
    row = 1 + int(np.argmax(gain))
    level = float(np.median(friction[:row]))
    scatter = 1.4826 * float(np.median(np.abs(friction[:row] - level)))
    step = float(np.median(friction[row:])) - level
    return row if step > max(_STANDARD_DEVIATIONS * scatter, _LEAST_RISE * level) else None


def read_trace(path: Path) -> Trace | None:
    """Read a trace of friction over time; None from a file of another kind.

    Raises
    ------
    InputError
        If the file cannot be read.
    """

    def is_heading(cells: list[str]) -> bool:
        found = columns_for(cells, _LIKE)[0].keys()
        return {"time", "friction"} <= found or {"time", "friction_force", "load"} <= found

    read = read_rows(path, is_heading)
    if not is_heading(read.heads) or len(read.rows) < _LEAST_ROWS:
        return None
    places = columns_for(read.heads, _LIKE)[0]
    labelled, rows = with_units_below(read.heads, read.rows)
    columns = {}
    for name, place in places.items():
        unit = heading_of(labelled[place]).unit or _LIKE[name]
        try:
            factor = to_si(f"1 {unit}", f"1 {_LIKE[name]}") if _LIKE[name] else 1.0
            columns[name] = factor * np.array([float(row.cells[place] or "nan") for row in rows])
        except (UnitError, ValueError):
            return None
    force = columns.pop("friction_force", None)
    if force is not None and "friction" not in columns:
        with np.errstate(divide="ignore", invalid="ignore"):
            columns["friction"] = np.abs(force) / columns["load"]
    known = np.logical_and.reduce([np.isfinite(column) for column in columns.values()])
    columns = {name: column[known] for name, column in columns.items()}
    return Trace.of(**columns) if known.sum() >= _LEAST_ROWS else None
