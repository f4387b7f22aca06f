"""Read a table as a trace: rows in motion, the sign of the load, and what is left out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from pipeline.laboratory.commanded import at_rest, strokes
from pipeline.laboratory.reading import NEEDED, Read, add_hints
from pipeline.laboratory.trace import LEAST_ROWS, Trace
from pipeline.scene.faults import fault_lines
from pipeline.scene.sheet import Sheet
from tribo import InputError
from tribo.types import Array

_MOST_FRICTION = 2.0  # largest plausible median of friction
_FEWEST_TURNS = 20  # changes of friction's sign that are turns of a stroke
_FEWEST_IDLE, _IDLE = 3, 0.003  # rows at rest, and load in them over the highest, that are told


def read_trace(read: Read) -> Trace:
    """Convert a table to a trace of friction over time; raises an `InputError` with all faults.

    Rows with gaps, and rows at rest, are left out of the trace and of the table's sheet. The load
    is positive where it is largest; what the load cell shows at rest is told.
    """
    sheet, columns = read.sheet, _columns(read)
    commands = [name for name in ("load", "velocity") if name in columns]
    needed = [columns[name] for name in ("time", *commands)]
    _drop(sheet, columns, "has a gap", ~np.isfinite(needed).all(axis=0))
    if sheet.rows:
        _require_rising_time(sheet, columns["time"])
        _drop_rest(sheet, columns, commands)
    _drop(sheet, columns, "has a gap", ~np.isfinite(columns["friction"]))
    if len(sheet.rows) < LEAST_ROWS:
        needed_words = f"{len(sheet.rows)} rows in motion; a trace needs {LEAST_ROWS}"
        raise InputError("; ".join(filter(None, (f"{sheet.name}: {needed_words}", sheet.counted))))
    turns = int(np.count_nonzero(np.diff(np.sign(columns.pop("friction_force")))))
    columns["friction"] = np.abs(columns["friction"])  # its sign changes with the stroke
    if (level := np.median(columns["friction"])) > _MOST_FRICTION:
        raise InputError(
            f"{sheet.name}: friction is {level:.4g}; in a contact it is at most "
            f"{_MOST_FRICTION:g}; give a column of the coefficient itself, or of friction force"
        )
    # The speed crosses its mean twice in each stroke.
    swings = strokes(columns["velocity"]) // 2 if "velocity" in columns else 0
    turns = max(turns if turns >= _FEWEST_TURNS else 0, swings)
    return Trace(**columns, period=max(1, 2 * len(sheet.rows) // turns) if turns else 1)


def _columns(read: Read) -> dict[str, Array]:
    """Columns of a trace in SI, by name; the friction force is friction itself if there is none."""
    sheet, export, missing = read
    if "friction" not in sheet.places:  # all missing quantities are named at once
        sheet.faults += [missing[name] for name in ("friction", "velocity") if name in missing]
    sheet.require(["time", "friction"])
    names = *NEEDED, "bulk_temperature", "friction_force"
    columns = {name: sheet.numbers(name) for name in names if name in sheet.places}
    add_hints(sheet)
    if sheet.faults:
        raise InputError(fault_lines(sheet.name, sheet.faults))
    if export.restarts or "step" in sheet.heading("time").title.lower():
        columns["time"] = _unwrap_time(columns["time"])
    columns.setdefault("friction_force", columns["friction"])
    return columns


def _drop_rest(sheet: Sheet, columns: dict[str, Array], commands: Iterable[str]) -> None:
    """Orient load and velocity, leave out rows at rest, and add the time in motion [s]."""
    time = columns["time"] = columns["time"] - columns["time"][0]
    if "velocity" in columns:
        columns["velocity"] = np.abs(columns["velocity"])
    rest = {name: np.zeros(len(time), bool) for name in commands}
    if "load" in columns:
        load = columns["load"] = _signed_load(sheet, columns["load"])
        rest["load"] = at_rest(load)
        idle = load[rest["load"]]
        if idle.size >= _FEWEST_IDLE and abs(np.median(idle)) > _IDLE * load.max():
            sheet.form.append(f"idle load {np.median(idle):.3g} N, not taken off")
    if "velocity" in columns:
        rest["velocity"] = at_rest(columns["velocity"])
    is_rest = np.any([np.zeros(len(time), bool), *rest.values()], axis=0)
    columns["running"] = np.cumsum(np.where(is_rest, 0.0, np.diff(time, prepend=0.0)))
    _drop(sheet, columns, "is at rest", is_rest)


def _signed_load(sheet: Sheet, load: Array) -> Array:
    """Load (n,) that is positive where it is largest, lone readings apart."""
    middle = median_filter(load, size=5, mode="nearest")
    if middle[np.argmax(np.abs(middle))] >= 0:
        return load
    sheet.form.append("loads below 0 are normal forces downwards")
    result: Array = -load
    return result


def _drop(sheet: Sheet, columns: dict[str, Array], reason: str, rows: Any) -> None:
    """Leave out the rows of a mask, for a reason, from the table and from arrays in `columns`."""
    numbers = [row.number for row, is_out in zip(sheet.rows, rows, strict=True) if is_out]
    sheet.leave_out(dict.fromkeys(numbers, reason))
    columns |= {name: values[~rows] for name, values in columns.items()}


def _require_rising_time(sheet: Sheet, time: Array) -> None:
    """Raise an `InputError` where time [s] falls."""
    fallen = np.flatnonzero(np.diff(time) < 0)
    if fallen.size:
        before, now = time[fallen[0] : fallen[0] + 2]
        raise InputError(
            f"{sheet.name}, row {sheet.rows[fallen[0] + 1].number}: time falls from {before:.4g} "
            f"to {now:.4g} s, but a trace is one run; give each run in a file of its own, or by "
            "--where, in the order of time"
        )


def _unwrap_time(time: Array) -> Array:
    """Continuous time [s] from a time that restarts with each step."""
    steps = np.diff(time)
    usual = float(np.nanmedian(steps[steps > 0]))
    jumps = np.where(steps < 0, usual - steps, 0.0)
    return np.asarray(time + np.concatenate([[0.0], np.cumsum(jumps)]))
