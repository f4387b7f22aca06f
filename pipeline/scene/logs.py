"""Tests of a laboratory's log in place of tables of the scene, and the transition in a trace.

A heading names an entry, with the unit of its column, such as ``load [N]`` or ``Normalkraft / N``;
a cell that is empty leaves the entry out. Columns of other names, as of dates and operators, are
not used. What was not named exactly is noted.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.scene.format import LOG, OUTCOMES, TEST, TRANSITION
from pipeline.scene.headings import Sheet, columns_for, heading_of, read_sheet, with_units_below
from pipeline.scene.kinds import Kind, Number, OneOf
from pipeline.scene.rows import Row, may_be_thousands, read_rows
from pipeline.scene.schema import Table
from pipeline.scene.units import UnitError, to_si
from tribo import InputError
from tribo.types import Array

_MILD = "mild ok okay io pass passed bestanden gut good leicht keinfresser buono bon bueno"
_SEVERE = (
    "severe fresser gefressen fressen scuff scuffed scuffing seizure seized fail failed nio schwer "
    "grippato grippaggio grippage grippé gripado notok niok"
)
_YES, _NO = "yes ja y j true wahr 1 x", "no nein n false falsch 0"
_SHOWN = 6  # rows of a fault that are named


def outcome_of(word: str, heading: str) -> str | None:
    """Outcome that a word below a heading means, None if it is not known."""
    mild, severe, asked = set(_MILD.split()), set(_SEVERE.split()), heading.lower()
    if re.search(r"scuff|fress|seiz|sever", asked):
        mild, severe = mild | set(_NO.split()), severe | set(_YES.split())
    elif re.search(r"pass|bestanden", asked):
        mild, severe = mild | set(_YES.split()), severe | set(_NO.split())
    plain = re.sub(r"[\W_]+", "", word.lower()).replace("freß", "fress")
    return "mild" if plain in mild else "severe" if plain in severe else None


@dataclass(frozen=True, slots=True)
class Log:
    """Rows of a log, and how they are understood."""

    path: Path
    sheet: Sheet  # its columns, and the entries of a test that they give
    words: dict[str, str]  # outcome for each word of the log that is not one itself
    rows: list[Row]  # of tests
    left_out: list[int]  # numbers of rows without load and velocity
    faults: list[str]  # of the file as a whole

    def cells(self, name: str) -> list[str]:
        """Cells of an entry."""
        return [row.cells[self.sheet.places[name]] for row in self.rows]

    @property
    def unused(self) -> list[str]:
        """Titles of the columns that are not used."""
        used = self.sheet.places.values()
        return [head for place, head in enumerate(self.sheet.heads) if place not in used]

    @property
    def guessed(self) -> list[str]:
        """Headings and words that were recognised, though not exact names."""
        said = [
            f'"{self.sheet.heads[place]}" as {name}'
            for name, place in self.sheet.places.items()
            if heading_of(self.sheet.heads[place]).name != name
        ]
        return said + [f'"{word}" as {outcome}' for word, outcome in self.words.items()]


def read_log(path: Path, entries: Mapping[str, Any] | None = None, row_of: Table = TEST) -> Log:
    """Read a log, and find the columns for the entries of a test.

    `entries` are columns, words and decimal mark, as a scene gives them beside the file.
    """
    given = entries or {}
    chosen = given.get("columns") or {}
    sheet = read_sheet(path, row_of.keys, row_of.needed, chosen, given.get("decimal"))
    faults, places = [*sheet.faults], sheet.places
    if faults and sheet.heads and not chosen:
        faults[-1] += '; name one by columns = { load = "HEADING" } or --column "load=HEADING"'
    needed = [places[name] for name in ("load", "velocity") if name in places]
    kept, left_out = list[Row](), list[int]()
    for row in sheet.rows:
        if not needed or any(row.cells[k] for k in needed):
            kept.append(row)
        else:
            left_out.append(row.number)
    if not kept and not faults:
        faults = [f'{path} has no rows; begin it with a line such as "load [N],velocity [m/s]"']
    log = Log(path, sheet, {}, kept, left_out, [*faults, *sheet.of_rows])
    if "outcome" in places:
        own, title = given.get("words") or {}, sheet.heading("outcome").title
        for word in dict.fromkeys(log.cells("outcome")):
            if word not in OUTCOMES and (outcome := own.get(word) or outcome_of(word, title)):
                log.words[word] = outcome
    return log


def entries_of_log(log: Log, row_of: Table = TEST) -> tuple[list[dict[str, Any]], list[str]]:
    """Tests of a log as tables of a scene; and faults, those of one kind in one line."""
    tests, faults = [], dict[tuple[str, str], tuple[str, list[int]]]()
    for row in log.rows:
        test = {}
        for name, place in log.sheet.places.items():
            cell = log.words.get(row.cells[place]) if name == "outcome" else None
            cell = cell or row.cells[place]
            if cell:
                test[name] = _value(cell, log.sheet.heading(name).unit, row_of.keys[name].kind)
        wrong = Faults()
        row_of.read(test, "", wrong)
        for name, problem, *_ in wrong:
            if name in row_of.keys and name not in log.sheet.places:
                continue  # a missing column is said once
            said = problem + _hint(log, name, row, problem)
            kind = re.sub(r'"(\\.|[^"\\])*"', "", problem)
            faults.setdefault((name, kind), (said, []))[1].append(row.number)
        ambiguous = [
            name
            for name, place in log.sheet.places.items()
            if log.sheet.decimal == "," and may_be_thousands(row.cells[place]) and name != "outcome"
        ]
        for name in ambiguous:
            cell = row.cells[log.sheet.places[name]]
            said = (
                f'"{cell}" beside decimal commas is {float(cell):g} or {cell.replace(".", "")}; '
                'give the decimal mark of the file, as decimal = "." or ","'
            )
            faults.setdefault((name, "mark"), (said, []))[1].append(row.number)
        if not wrong and not ambiguous:
            tests.append(test)
    listed = [f"{_rows(numbers)}, {key[0]}: {said}" for key, (said, numbers) in faults.items()]
    return tests, [*log.faults, *listed]


def _value(cell: str, unit: str, kind: Kind) -> Any:
    """A cell as a scene file has it: a number, or text with a unit."""
    if isinstance(kind, OneOf):
        return cell
    if not unit and isinstance(kind, Number):
        try:
            return float(cell)
        except ValueError:
            return cell
    return f"{cell} {unit}".strip()


def _hint(log: Log, name: str, row: Row, problem: str) -> str:
    """What else to do about a fault of a cell; empty if there is nothing."""
    if "has no unit" in problem:
        return f"; or the unit of the column in its heading, such as {name} [...]"
    if name == "outcome" and "is unknown" in problem:
        word = json.dumps(row.cells[log.sheet.places[name]], ensure_ascii=False)
        return f'; or say what it means, as words = {{ {word} = "severe" }}'
    return ""


def _rows(numbers: Sequence[int]) -> str:
    """Rows in words, such as "rows 2, 3 and 5"."""
    if len(numbers) == 1:
        return f"row {numbers[0]}"
    shown = [str(number) for number in numbers[:_SHOWN]]
    more = f"{len(numbers) - _SHOWN} more" if len(numbers) > _SHOWN else shown.pop()
    return f"rows {', '.join(shown)} and {more}"


def with_rows(entries: dict[str, Any], document: Document, faults: Faults) -> dict[str, Any]:
    """Entries with the rows of log files in the place of the tests that name them.

    Faults are named by row and column; columns that are not used are noted.
    """
    for key, row_of in (("measured", TRANSITION), ("tested", TEST)):
        listed = entries.get(key)
        if not isinstance(listed, list) or not listed:
            continue
        rows: list[Any] = []
        for number, entry in enumerate(listed):
            if isinstance(entry, dict) and isinstance(entry.get("file"), str):
                place, folder = f"{key}[{number}]", document.file_of(key).parent
                rows += _of_file(entry, place, folder, row_of, faults)
            else:
                rows.append(entry)
        entries = {name: value for name, value in entries.items() if name != key}
        if rows:  # otherwise all are faulty, which is said already
            entries[key] = rows
    return entries


def _of_file(
    entry: dict[str, Any], place: str, folder: Path, row_of: Table, faults: Faults
) -> list[dict[str, Any]]:
    """Tests of a file as tables of a scene; faults are named by row and column."""
    wrong = Faults()
    entries = LOG.read(entry, place, wrong)
    faults += wrong
    if wrong:
        return []
    place, path = f"{place}.file", folder / entry["file"]
    try:
        log = read_log(path, entries, row_of)
    except InputError as error:
        faults.note(place, str(error))
        return []
    tests, problems = entries_of_log(log, row_of)
    for problem in problems:
        faults.note(place, f"{path.name}, {problem}")
    if log.faults:
        shell = f"irg tests {path}"
        faults.note(place, f"what is understood of it is printed by: {shell}")
    if log.unused:
        faults.notes.append(f"{place}: columns not used: {', '.join(log.unused)}")
    if log.guessed:
        faults.notes.append(f"{place}: read {', '.join(log.guessed)}")
    if log.left_out:
        faults.notes.append(f"{place}: {_rows(log.left_out)} without load and velocity left out")
    return tests


_LIKE = {"time": "s", "friction": "", "load": "N", "velocity": "m/s", "friction_force": "N"}
_LEAST_ROWS = 20
_STANDARD_DEVIATIONS = 4.0  # of friction before, below which a rise is scatter
_LEAST_RISE = 0.2  # of friction before; less is running-in or a warmer film


@dataclass(frozen=True)
class Trace:
    """Friction over time."""

    time: Array  # [s]
    friction: Array
    load: Array | None = None  # [N], where it was recorded
    velocity: Array | None = None  # [m/s]

    @cached_property
    def row(self) -> int | None:
        """Row from which on friction is high, by least squares of one step upwards, if any is."""
        friction, count = self.friction, len(self.friction)
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


def read_trace(path: Path) -> Trace | None:
    """Read a trace of friction over time; None from a file of another kind."""

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
    return Trace(**columns) if known.sum() >= _LEAST_ROWS else None
