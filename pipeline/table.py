"""Tables of tests, operating points, rows and loads: CSV, or columns of Python.

All tables have one contract. Headings are like "load [N]". Each column acts, is ignored by the
user, or holds words; a number is never a label. Nothing is guessed: an empty cell in a column that
acts, a row with more or fewer cells than headings, a repeated heading and an ambiguous number are
refused: all faults at once, each with its row and column.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from pipeline.arguments import plain_value
from pipeline.messages import did_you_mean, fault_lines, quoted
from pipeline.paths import (
    is_binary,
    is_workbook,
    read_file,
    reason_of,
    user_path,
    workbook_problem,
)
from pipeline.units import MAYBE_THOUSANDS, NUMBER, si_unit, to_si
from tribo import InputError
from tribo.types import Array

NAME = "number"
"""Column with the numbers or names of specimens and rows, which stay as they are written."""
Source = str | Path | Mapping[str, Sequence[Any]]
_HEADING = re.compile(r"(.+?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))")
_DATE = re.compile(r"\d{4}[-/.]\d\d?[-/.]\d\d?\b|\d\d?[-/.]\d\d?[-/.]\d{2,4}\b")
_LONG_NAMES = {"normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature"}
_NUMBER = re.compile(NUMBER, re.ASCII)
_NUMERIC = re.compile(
    r"[~≈<>≤≥±=]*\s*[-+]?\.?\d|[-+]?(nan|inf)\b|=.|#[A-Z]+[/!?\d]|(HV|HBW?|HR[A-C]?) *\d",
    re.IGNORECASE,
)
"""Beginning of a cell that is no word: a number, a formula, or an error of a spreadsheet."""
_PLAIN_CHARACTERS = str.maketrans("−–\xa0\u202f\u2009", "--   ")
_NO_VALUE = {"-", "--", "—"}  # after `_PLAIN_CHARACTERS`
_NUMBER_UNITS = {"-", "–", "—", "−", "1"}


class TableError(InputError):
    """A table cannot be read; `faults` has all of its faults, a line for each kind."""

    def __init__(self, name: str, faults: list[str]) -> None:
        self.faults = _grouped(faults)
        super().__init__(fault_lines(name, self.faults))


def _grouped(faults: Sequence[str]) -> list[str]:
    """Faults in which more than three of one kind are one, with its first three rows."""
    kinds = dict[str, list[str]]()
    for fault in faults:
        kinds.setdefault(re.sub(r'"[^"]*"|[\d.,+-]*\d', "", fault), []).append(fault)
    lines = list[str]()
    for same in kinds.values():
        rows = [fault.split(maxsplit=1)[1] for fault in same if fault.startswith("row ")]
        if len(same) <= 3 or len(rows) < len(same):
            lines += same
            continue
        numbers = [re.match(r"\d+", row)[0] for row in rows[:3]]  # type: ignore[index]
        rest = rows[0].removeprefix(numbers[0])
        lines.append(f"rows {', '.join(numbers)} and {len(rows) - 3} more{rest}")
    return lines


class TableColumn(NamedTuple):
    """A column: its heading, the name of its quantity or entry, its unit, and its cells as text."""

    heading: str
    name: str
    unit: str
    cells: list[str]

    @classmethod
    def from_heading(cls, heading: str, cells: Iterable[str] = ()) -> TableColumn:
        """A column by its heading, such as "load [N]" or "load (N)"; `[-]` has no unit."""
        heading = " ".join(heading.split())
        match = _HEADING.fullmatch(heading)
        if match and match[3] is not None and not _is_unit(match[3].strip()):
            match = None  # words in parentheses
        name, unit = (match[1], (match[2] or match[3] or "").strip()) if match else (heading, "")
        key = name if "." in name else name.lower().replace(" ", "_")
        unit = "" if unit in _NUMBER_UNITS else unit
        return cls(heading, _LONG_NAMES.get(key, key), unit, [cell.strip() for cell in cells])

    def entry(self, row: int) -> str | float:
        """The entry of a row: a number, or text; a number in text has the unit of the column.

        A name stays as it is written.
        """
        cell = self.cells[row]
        if self.name == NAME or not _NUMBER.fullmatch(cell):
            return cell
        if self.unit:
            return f"{cell} {self.unit}"
        with suppress(ValueError):
            return int(cell)
        return float(cell)


@dataclass(frozen=True)
class Table:
    """Columns of a table, the numbers of its rows in the file, and the faults found so far."""

    name: str
    columns: list[TableColumn]
    lines: Sequence[int]
    faults: list[str] = field(default_factory=list)
    decimal: str | None = None  # decimal mark given by the user
    has_commas: bool = True  # False where cells are not divided by commas: "1.200" may be 1200

    def rows(
        self,
        known: Collection[str],
        faults_in: Callable[[dict[str, Any]], Iterable[tuple[str, str]]],
        needed: Collection[str] = (),
        omissible: Collection[str] = (),
    ) -> list[dict[str, Any]]:
        """Entries in each row, as a scene file has them, of the columns in `known`.

        A dash in an `omissible` column leaves out the entry of its row. Raises a `TableError` with
        all faults: of the table, and pairs (name, reason) that `faults_in` finds in a row, each
        with its row and column.
        """
        faults, columns = [*self.faults], list[TableColumn]()
        headings = {column.name: column.heading for column in self.columns}
        for column in self.columns:
            if column.name in known:
                cells = [*self._cells(column, column.name in omissible, faults)]
                columns.append(column._replace(cells=cells))
            elif fault := self._fault_of_words(column, [*known]):
                faults.append(fault)
        for name in needed:
            if name not in headings:
                listed = ", ".join(map(quoted, headings.values()))
                faults.append(f"no column {name} in {listed}; add it, with its unit")
        rows, faulty_locations = list[dict[str, Any]](), {text.split(": ")[0] for text in faults}
        for index, line in enumerate(self.lines):
            filled = [column for column in columns if column.cells[index]]
            rows.append({column.name: column.entry(index) for column in filled})
            for name, reason in faults_in(rows[-1]):
                location = f"row {line}, {headings.get(name, name)}"
                if location not in faulty_locations and (name in headings or name not in needed):
                    faults.append(f"{location}: {reason}")
        if faults:
            raise TableError(self.name, faults)
        return rows

    def _fault_of_words(self, column: TableColumn, known: Sequence[str]) -> str:
        """Why a column of an unknown name cannot pass as words; empty if it can."""
        if column.name == NAME:
            return ""
        names = {column.name for column in self.columns}
        hint = did_you_mean(column.name, {*known} - names)
        cells = zip(self.lines, column.cells, strict=True)
        numbers = (pair for pair in cells if _NUMERIC.match(pair[1].translate(_PLAIN_CHARACTERS)))
        number = next(numbers, None)
        if not hint and number is None and "." not in column.name:
            return ""
        if number and _DATE.match(number[1]):
            ignore = quoted(column.heading)
            return (
                f"the column {ignore} has dates ({quoted(number[1])} in row {number[0]}); ignore "
                f"it: ignore = [{ignore}] (--ignore {ignore})"
            )
        choices = f"one of {', '.join(known)}" if len(known) <= 12 else "the path of an entry"
        reason = f"has numbers ({quoted(number[1])} in row {number[0]}), but " if number else ""
        heading = quoted(column.heading)
        return (
            f"the column {heading} {reason}is unknown{hint}; rename it to {choices}, to {NAME} if "
            f"it has names, or ignore it: ignore = [{heading}] (--ignore {heading})"
        )

    def _cells(self, column: TableColumn, is_omissible: bool, faults: list[str]) -> Iterator[str]:
        """Yield the cells of a column that acts, with decimal points; others are faults."""
        for line, cell in zip(self.lines, column.cells, strict=True):
            location = f"row {line}, {column.heading}"
            plain_cell = cell.translate(_PLAIN_CHARACTERS)
            if not cell:
                dash = ", or a dash where it does not apply" if is_omissible else ""
                faults.append(f"{location}: empty; give a value in each row{dash}")
                yield ""
            elif column.name == NAME:
                yield cell
            elif is_omissible and plain_cell in _NO_VALUE:
                yield ""
            else:
                match = re.fullmatch(r"([-+]?\d[\d.,]*)(\D.*)?", plain_cell)
                number, rest = (match[1], match[2] or "") if match else ("", plain_cell)
                if problem := self._fault_of_marks(number):
                    faults.append(f"{location}: {cell} {problem}")
                yield number.replace(",", ".") + rest

    def _fault_of_marks(self, number: str) -> str:
        """Why the marks in a number are not decimal marks of the table; empty if they are."""
        marks = {*number} & {",", "."}
        if self.decimal is None and not self.has_commas and MAYBE_THOUSANDS.fullmatch(number):
            return 'may be a thousand times as much; set decimal = "." or "," (--decimal ".")'
        if marks <= {self.decimal or "."}:
            return ""
        if self.decimal == ",":
            return "has a point, though decimals have commas; write the number that you mean"
        return 'has a comma; write a point, or set decimal = "," (--decimal ",")'

    def numbers(self, units: Mapping[str, str]) -> dict[str, Array]:
        """Values in SI of the columns named in `units`, whose headings or cells have units."""

        def faults_in(row: dict[str, Any]) -> Iterator[tuple[str, str]]:
            for name, cell in row.items():
                try:
                    to_si(str(cell), f"1 {units[name]}")
                except ValueError as error:
                    yield name, str(error)

        rows = self.rows(units, faults_in, needed=units)
        return {
            name: np.array([to_si(str(row[name]), f"1 {unit}") for row in rows])
            for name, unit in units.items()
        }


def _is_unit(text: str) -> bool:
    """True for a unit that columns may have, such as "N" or "%"."""
    with suppress(ValueError):
        return text in _NUMBER_UNITS or text == "%" or bool(si_unit(f"1 {text}"))
    return False


def read_table(
    source: Source,
    max_rows: int,
    decimal: str | None = None,
    ignore: Collection[str] = (),
    names: Mapping[str, str] | None = None,
    si_units: Mapping[str, str] | None = None,
) -> Table:
    """Read a CSV file, or columns by heading such as a data frame.

    In CSV cells are divided by the first of tab, semicolon and comma in the headings. `decimal` is
    the decimal mark of its numbers. Columns whose headings are in `ignore` are left out. `names`
    has other names of columns, by those of their headings, and `si_units` the units of numbers that
    are given in Python without one.
    """
    name, has_commas = "the table", True
    if isinstance(source, str | Path):
        path = user_path(source)
        name = str(path)
        try:
            rows, has_commas = _rows_of_file(path)
        except OSError as error:
            raise InputError(f"{path} cannot be read: {reason_of(error, path)}") from error
    else:
        rows = _rows_of_columns(source, si_units or {})
    rows = [(line, row) for line, row in rows if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        raise InputError(f"{name} has no rows below its headings; add one")
    if len(rows) - 1 > max_rows:
        raise InputError(f"{name} has {len(rows) - 1} rows; at most {max_rows} are read")
    (_, headings), *body = rows
    width = _filled_length(headings)
    if width > 1000:
        raise InputError(f"{name} has {width} columns; at most 1000 are read")
    sound_rows, faults = list[tuple[int, list[str]]](), list[str]()
    for line, row in body:
        if len(row) < width or _filled_length(row) > width:
            count = max(_filled_length(row), min(len(row), width))
            faults.append(f"row {line} has {count} cells below {width} headings; give one for each")
        else:
            sound_rows.append((line, row))
    columns = [
        TableColumn.from_heading(headings[k], [row[k] for _, row in sound_rows])
        for k in range(width)
    ]
    columns = [
        column._replace(name=(names or {}).get(column.name, column.name))
        for column in _without_ignored(columns, ignore, faults)
        if column.heading or any(column.cells)
    ]
    for k, column in enumerate(columns):
        if not 0 < len(column.heading) <= 200:
            faults.append("a column has no heading, or a very long one; give one for each column")
        elif any(column.name == other.name for other in columns[:k]):
            faults.append(f"the heading {quoted(column.heading)} occurs twice; leave one out")
    return Table(name, columns, [line for line, _ in sound_rows], faults, decimal, has_commas)


def _without_ignored(
    columns: list[TableColumn], ignore: Collection[str], faults: list[str]
) -> list[TableColumn]:
    """Columns whose headings, with or without the unit, are not in `ignore`."""
    for heading in ignore:
        key = heading.strip().lower()
        kept = [
            column
            for column in columns
            if key
            not in (column.heading.lower(), re.split(r"\[|\(", column.heading)[0].strip().lower())
        ]
        if len(kept) == len(columns):
            names = ", ".join(quoted(column.heading) for column in columns)
            problem = f"there is no column {quoted(heading)} to ignore in {names}"
            faults.append(f"{problem}; give a heading of the table")
        columns = kept
    return columns


def _filled_length(row: Sequence[str]) -> int:
    """Number of cells of a row without the empty ones at its end."""
    return max((k + 1 for k, cell in enumerate(row) if cell.strip()), default=0)


def _rows_of_columns(
    source: Mapping[str, Sequence[Any]], si_units: Mapping[str, str]
) -> list[tuple[int, list[str]]]:
    """Rows of columns by heading, numbered from 1; headings first."""
    if isinstance(source, pd.DataFrame):
        if index_names := [str(name) for name in source.index.names if name is not None]:
            raise InputError(f"the index {quoted(index_names[0])} is not read; use reset_index()")
        columns = [(str(heading), source.iloc[:, k]) for k, heading in enumerate(source.columns)]
    elif hasattr(source, "dims"):
        raise InputError("a Dataset is not a table; give its variables as load and velocity")
    else:
        columns = [(str(heading), cells) for heading, cells in source.items()]
    cell_columns = list[list[str]]()
    for heading, values in columns:
        plain_values = plain_value(f"column {quoted(heading)}", values)
        if not isinstance(plain_values, list):
            raise InputError(f"column {quoted(heading)} is not a list; give one value for each row")
        column = TableColumn.from_heading(heading)
        unit = "" if column.unit else si_units.get(column.name, "")
        cell_columns.append([_cell_of_value(value, unit) for value in plain_values])
    if len({*map(len, cell_columns)}) > 1:
        counts = ", ".join(
            f"{quoted(heading)} {len(cells)}"
            for (heading, _), cells in zip(columns, cell_columns, strict=True)
        )
        raise InputError(f"columns have different numbers of rows: {counts}; give each the same")
    rows = [[heading for heading, _ in columns], *map(list, zip(*cell_columns, strict=True))]
    return [*enumerate(rows)]


def _cell_of_value(value: Any, unit: str) -> str:
    """Cell of a value of Python; a number has the `unit`."""
    if value is None or value != value:  # NaN
        return ""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return f"{value!r} {unit}" if is_number and unit else str(value)


def _rows_of_file(path: Path) -> tuple[list[tuple[int, list[str]]], bool]:
    """Rows of a file with their numbers, headings first; and if commas divide its cells."""
    content = read_file(path, max_bytes=40_000_000)
    if is_workbook(path, content):
        raise InputError(f"{path} is {workbook_problem(path)}")
    if is_binary(content):
        raise InputError(f"{path} is binary; give a table as text, .csv")
    is_utf16 = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    try:
        text = content.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")  # as Excel writes in the west
    lines = text.splitlines()
    is_comment = (not line.strip() or line.startswith("#") for line in lines)
    start = next((k for k, comment in enumerate(is_comment) if not comment), len(lines))
    headings = re.sub('"[^"]*"', "", lines[start]) if lines[start:] else ""
    delimiter = next((mark for mark in "\t;," if mark in headings), ",")
    reader = csv.reader(lines[start:], delimiter=delimiter, strict=True)
    try:
        return [(start + reader.line_num, row) for row in reader], delimiter == ","
    except csv.Error as error:  # such as a quote that is not closed
        raise InputError(f"{path}: row {start + reader.line_num}: {error}; correct it") from error
