"""Tables of tests, operating points, rows and loads, with headings like "load [N]".

All tables have one contract. Each column acts, is left out by the user, or holds words; a number is
never a label. Cells are text here, and nothing is guessed: an empty cell in a column that acts, a
formula without a stored value, a row with more or fewer cells than headings, a repeated heading and
an ambiguous number are refused: all faults at once, each with its row and column.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pipeline.limits import MAX_FAULTS
from pipeline.messages import did_you_mean, fault_lines, quoted
from pipeline.units import MAYBE_THOUSANDS, NUMBER, to_si
from tribo import InputError
from tribo.types import Array

NAME = "number"
"""Column with the numbers or names of specimens and rows, which stay as they are written."""
_HEADING = re.compile(r"(.+?)\s*\[([^\[\]]*)\]")
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
_SYNONYMS = {
    "cof": "friction", "mu": "friction", "μ": "friction", "µ": "friction",
    "friction_coefficient": "friction", "coefficient_of_friction": "friction",
    "speed": "velocity", "sliding_speed": "velocity", "force": "load", "t_oil": "bulk_temperature",
    "critical": "critical_temperature", "result": "outcome", "radius": "pin.radius",
    "ra": "disk.roughness.ra",
}  # fmt: skip
"""Headings that are refused, and the name that is suggested for each."""


class TableError(InputError):
    """A table cannot be read; `faults` has all of its faults, a line each."""

    def __init__(self, name: str, faults: list[str]) -> None:
        super().__init__(fault_lines(name, faults))
        self.faults = faults


class TableFaults(list[str]):
    """Faults of a table by its `name`; the last one that is listed is raised with the others."""

    def __init__(self, name: str, faults: Iterable[str] = ()) -> None:
        super().__init__()
        self.name = name
        self.extend(faults)

    def append(self, fault: str) -> None:
        """Add a fault."""
        super().append(fault)
        if len(self) >= MAX_FAULTS:
            raise TableError(self.name, self)

    def extend(self, faults: Iterable[str]) -> None:
        """Add faults."""
        for fault in faults:
            self.append(fault)


class Advice(NamedTuple):
    """How the user of a table leaves out a column, and states the decimal mark of its numbers."""

    ignore: str
    decimal: str


PYTHON = Advice("leave it out", "write decimals with points")
COMMAND = Advice("ignore it: --ignore {}", "set --decimal {}")
SCENE = Advice("ignore it: ignore = [{}] below file", "set decimal = {} below file")


class Column(NamedTuple):
    """A column: its heading, the name of its quantity or entry, its unit, and its cells as text."""

    heading: str
    name: str
    unit: str
    cells: list[str]

    @classmethod
    def from_heading(cls, heading: str, cells: Sequence[str] = ()) -> Column:
        """A column by its heading, such as "load [N]"; `[-]` and `[1]` are units of numbers."""
        heading = " ".join(heading.split())
        match = _HEADING.fullmatch(heading)
        name, unit = (match[1], match[2].strip()) if match else (heading, "")
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
class Sheet:
    """Columns of a table, the numbers of its rows in the file, and its faults.

    The reader of the cells raises these faults together with its own.
    """

    name: str
    columns: list[Column]
    lines: list[int]
    faults: TableFaults
    advice: Advice = PYTHON
    decimal: str | None = None  # decimal mark given by the user
    is_local: bool = False  # True if points of numbers may divide thousands

    def renamed(self, names: Mapping[str, str]) -> Sheet:
        """The sheet with renamed columns; a repeated name is a fault."""
        columns, faults = list[Column](), TableFaults(self.name, self.faults)
        for original in self.columns:
            column = original._replace(name=names.get(original.name, original.name))
            if any(column.name == renamed.name for renamed in columns):
                faults.append(f"the heading {quoted(original.heading)} occurs twice; leave one out")
            else:
                columns.append(column)
        return replace(self, columns=columns, faults=faults)

    def select(
        self, known: Collection[str], needed: Collection[str] = (), omissible: Collection[str] = ()
    ) -> tuple[list[Column], list[Column], TableFaults]:
        """Columns that act, columns of words, and all faults.

        The first have a name in `known`; their numbers have decimal points. A dash in an
        `omissible` column leaves out the entry of its row.
        """
        faults = TableFaults(self.name, self.faults)
        acting_columns, word_columns = list[Column](), list[Column]()
        names = {column.name for column in self.columns}
        for column in self.columns:
            if column.name in known:
                cells = [*self._cells(column, column.name in omissible, faults)]
                acting_columns.append(column._replace(cells=cells))
            elif fault := self._fault_of_words(column, known, names):
                faults.append(fault)
            else:
                word_columns.append(column)
        headings = ", ".join(quoted(column.heading) for column in self.columns)
        missing = [name for name in needed if name not in names]
        faults.extend(f"no column {name} in {headings}; add it, with its unit" for name in missing)
        return acting_columns, word_columns, faults

    def _fault_of_words(self, column: Column, known: Collection[str], names: set[str]) -> str:
        """Why a column of an unknown name cannot pass as words; empty if it can."""
        if column.name == NAME:
            return ""
        name = _SYNONYMS.get(column.name.lower(), column.name)
        hint = did_you_mean(name, {*known} - names)
        cells = zip(self.lines, column.cells, strict=True)
        number = next((pair for pair in cells if _is_numeric(pair[1])), None)
        if not hint and number is None and "." not in column.name:
            return ""
        heading, ignore = quoted(column.heading), self.advice.ignore.format(quoted(column.heading))
        if hint:
            return f"the column {heading} is unknown{hint}; rename it, or {ignore}"
        choices = f"one of {', '.join(known)}" if len(known) <= 12 else "the path of an entry"
        if number is None:
            return f"the column {heading} is unknown; rename it to {choices}, or {ignore}"
        return (
            f"the column {heading} has numbers ({quoted(number[1])} in row {number[0]}), but is "
            f"unknown; rename it to {choices}, to {NAME} if it has names, or {ignore}"
        )

    def _cells(self, column: Column, is_omissible: bool, faults: TableFaults) -> Iterator[str]:
        """Yield the cells of a column that acts, with decimal points; others are faults."""
        for line, cell in zip(self.lines, column.cells, strict=True):
            location = f"row {line}, {column.heading}"
            plain_cell = cell.translate(_PLAIN_CHARACTERS)
            if not cell:
                advice = "give a value in each row"
                if is_omissible:
                    advice = "give a value in each row, or a dash where it does not apply"
                faults.append(f"{location}: empty; {advice}")
                yield ""
            elif column.name == NAME:
                yield cell
            elif is_omissible and plain_cell in _NO_VALUE:
                yield ""
            else:
                number, rest = split_number(plain_cell)
                if problem := self._fault_of_marks(number):
                    faults.append(f"{location}: {cell} {problem}")
                yield number.replace(",", ".") + rest

    def _fault_of_marks(self, number: str) -> str:
        """Why the marks in a number have two meanings, or another than that of the table."""
        marks = {*number} & {",", "."}
        if self.decimal == "," and "." in marks:
            return "has a point, though decimals have commas; write the number that you mean"
        if not marks or self.decimal == ",":
            return ""
        if marks == {"."} and not (self.decimal is None and self.is_local):
            return ""
        if self.decimal is None and MAYBE_THOUSANDS.fullmatch(number):
            without_marks = number.replace(",", "").replace(".", "")
            with_point = number.replace(",", ".")
            if with_point.count(".") > 1:
                return f"may be {without_marks}; write it without marks of thousands"
            problem = f"may be {without_marks} or {with_point}; write the one that you mean"
            if self.advice is PYTHON:
                return problem
            mark = number.strip("+-0123456789")[0]
            return f"{problem}, or {self.advice.decimal.format(quoted(mark))}"
        if "," in marks:
            advice = self.advice.decimal.format(quoted(","))
            return f"has a comma; {advice}, if commas are decimal marks"
        return ""


def _is_numeric(cell: str) -> bool:
    return _NUMERIC.match(cell.translate(_PLAIN_CHARACTERS)) is not None


def split_number(cell: str) -> tuple[str, str]:
    """A cell as its number, with all of its marks, and what follows; no number is empty."""
    match = re.fullmatch(r"([-+]?\d[\d.,]*)(\D.*)?", cell)
    return (match[1], match[2] or "") if match else ("", cell)


def rows_of(
    sheet: Sheet,
    names: Collection[str],
    faults_in: Callable[[dict[str, Any]], Iterable[Sequence[Any]]],
    needed: Collection[str] = (),
    omissible: Collection[str] = (),
) -> list[dict[str, Any]]:
    """Entries in each row, as a scene file has them, of the columns in `names`.

    Entries are left out where an `omissible` column has a dash. Columns of words are not used.
    Raises an `InputError` with all faults: of the sheet, and pairs (name, reason) that `faults_in`
    finds in a row, each with its row and column.
    """
    columns, _, faults = sheet.select(names, needed, omissible)
    rows, headings = list[dict[str, Any]](), {column.name: column.heading for column in columns}
    faulty_locations = {fault.partition(": ")[0] for fault in faults}
    for index, line in enumerate(sheet.lines):
        filled = [column for column in columns if column.cells[index]]
        rows.append({column.name: column.entry(index) for column in filled})
        for name, reason, *_ in faults_in(rows[-1]):
            location = f"row {line}, {headings.get(name, name)}"
            if location not in faulty_locations and (name in headings or name not in needed):
                faults.append(f"{location}: {reason}")
    if faults:
        raise TableError(sheet.name, faults)
    return rows


def numbers_of(sheet: Sheet, units: Mapping[str, str]) -> dict[str, Array]:
    """Values in SI of the columns named in `units`, whose headings or cells have units."""
    rows = rows_of(sheet, units, functools.partial(_quantity_faults, units), needed=units)
    return {
        name: np.array([to_si(str(row[name]), f"1 {unit}") for row in rows])
        for name, unit in units.items()
    }


def _quantity_faults(units: Mapping[str, str], row: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the columns named in `units` that have no quantity in a row, and why."""
    for name, unit in units.items():
        try:
            to_si(str(row.get(name, "")), f"1 {unit}")
        except ValueError as error:
            yield name, str(error) if name in row else f"missing; give one in {unit}"
