"""Tables of tests, operating points, rows and loads: CSV or Excel, with headings like "load [N]".

All tables have one contract. Each column acts, is left out by the user, or holds words; a number is
never a label. Cells are text here, and nothing is guessed: an empty cell in a column that acts, a
formula without a stored value, a row with more or fewer cells than headings, a repeated heading and
an ambiguous number are refused: all faults at once, each with its row and column.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from pipeline.arguments import plain_value
from pipeline.limits import (
    MOST_BYTES_OF_LINE,
    MOST_BYTES_OF_TEXT,
    MOST_CELLS_OF_TEXT,
    MOST_COLUMNS,
    MOST_FAULTS,
)
from pipeline.messages import did_you_mean, fault_lines, quoted
from pipeline.paths import kind_of, read_file, reason_of, user_path
from pipeline.units import GROUPED, NUMBER, to_si
from pipeline.workbook import workbook_rows
from tribo import InputError
from tribo.types import Array

Source = str | Path | Mapping[str, Sequence[Any]]
NAME = "number"
"""Column with the numbers or names of specimens and rows, which stay as they are written."""
_HEADING = re.compile(r"(.+?)\s*\[([^\[\]]*)\]")
_SAME = {"normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature"}
_NUMBER = re.compile(NUMBER, re.ASCII)
_NUMERIC = re.compile(
    r"[~≈<>≤≥±=]*\s*[-+]?\.?\d|[-+]?(nan|inf)\b|=.|#[A-Z]+[/!?\d]|(HV|HBW?|HR[A-C]?) *\d",
    re.IGNORECASE,
)
"""Beginning of a cell that is no word: a number, a formula, or an error of a spreadsheet."""
_ERRORS = re.compile(r"#(N/A|DIV/0!|NAME\?|NULL!|NUM!|REF!|VALUE!)")
_SIGNS = str.maketrans("−–\xa0\u202f\u2009", "--   ")
_NO_VALUE = {"-", "--", "—"}  # after `_SIGNS`
_NUMBER_UNITS = {"-", "–", "—", "−", "1"}
_SI = {"load": "N", "velocity": "m/s", "bulk_temperature": "K", "critical_temperature": "K"}
"""Units of numbers that are given in Python without one."""
_MAX_LISTED = 12  # names that a message lists
_MOST_HEADINGS = 1000  # lines above the rows
_LONGEST_HEADING = 200
_SYNONYMS = {
    "cof": "friction", "mu": "friction", "μ": "friction", "µ": "friction",
    "friction_coefficient": "friction", "coefficient_of_friction": "friction",
    "speed": "velocity", "sliding_speed": "velocity", "force": "load", "t_oil": "bulk_temperature",
    "result": "outcome", "radius": "pin.radius", "ra": "disk.roughness.ra",
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
        if len(self) >= MOST_FAULTS:
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

    head: str
    name: str
    unit: str
    cells: list[str]

    @classmethod
    def from_heading(cls, head: str, cells: Sequence[str] = ()) -> Column:
        """A column by its heading, such as "load [N]"; `[-]` and `[1]` are units of numbers."""
        head = " ".join(head.split())
        match = _HEADING.fullmatch(head)
        name, unit = (match[1], match[2].strip()) if match else (head, "")
        bare = name if "." in name else name.lower().replace(" ", "_")
        unit = "" if unit in _NUMBER_UNITS else unit
        return cls(head, _SAME.get(bare, bare), unit, [cell.strip() for cell in cells])

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
            if column.name in {other.name for other in columns}:
                faults.append(f"the heading {quoted(original.head)} stands twice; leave one out")
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
        acting, words = list[Column](), list[Column]()
        names = {column.name for column in self.columns}
        for column in self.columns:
            if column.name in known:
                cells = [*self._cells(column, column.name in omissible, faults)]
                acting.append(column._replace(cells=cells))
            elif fault := self._fault_of_words(column, known, names):
                faults.append(fault)
            else:
                words.append(column)
        heads = ", ".join(quoted(column.head) for column in self.columns)
        missing = [name for name in needed if name not in names]
        faults.extend(f"no column {name} in {heads}; add it, with its unit" for name in missing)
        return acting, words, faults

    def _fault_of_words(self, column: Column, known: Collection[str], names: set[str]) -> str:
        """Why a column of an unknown name cannot pass as words; empty if it can."""
        if column.name == NAME:
            return ""
        name = _SYNONYMS.get(column.name.lower(), column.name)
        hint = did_you_mean(name, {*known} - names)
        cells = zip(self.lines, column.cells, strict=True)
        number = next(((line, cell) for line, cell in cells if _NUMERIC.match(cell)), None)
        if not hint and number is None and "." not in column.name:
            return ""
        head, ignore = quoted(column.head), self.advice.ignore.format(quoted(column.head))
        if hint:
            return f"the column {head} is unknown{hint}; rename it, or {ignore}"
        listed = (
            "the path of an entry" if len(known) > _MAX_LISTED else f"one of {', '.join(known)}"
        )
        if number is None:
            return f"the column {head} is unknown; rename it to {listed}, or {ignore}"
        return (
            f"the column {head} has numbers ({quoted(number[1])} in row {number[0]}), but is "
            f"unknown; rename it to {listed}, to {NAME} if it has names, or {ignore}"
        )

    def _cells(self, column: Column, is_omissible: bool, faults: TableFaults) -> Iterator[str]:
        """Yield the cells of a column that acts, with decimal points; others are faults."""
        for line, cell in zip(self.lines, column.cells, strict=True):
            where, plain = f"row {line}, {column.head}", cell.translate(_SIGNS)
            if not cell:
                faults.append(f"{where}: empty; give a value in each row{_DASH * is_omissible}")
                yield ""
            elif column.name == NAME:
                yield cell
            elif is_omissible and plain in _NO_VALUE:
                yield ""
            else:
                number, rest = _split(plain)
                if problem := self._fault_of_marks(number):
                    faults.append(f"{where}: {cell} {problem}")
                yield number.replace(",", ".") + rest

    def _fault_of_marks(self, number: str) -> str:
        """Why the marks in a number have two meanings, or another than that of the table."""
        marks = {*number} & {",", "."}
        if self.decimal == "," and "." in marks:
            return "has a point, though decimals have commas; write the number that is meant"
        if not marks or self.decimal == "," or (marks == {"."} and not self._may_group()):
            return ""
        if self.decimal is None and GROUPED.fullmatch(number):
            thousands = number.replace(",", "").replace(".", "")
            mark = number.strip("+-0123456789")[0]
            decimals = number.replace(",", ".")
            if decimals.count(".") > 1:
                return f"may be {thousands}; write it without marks of thousands"
            choice = f"may be {thousands} or {decimals}; write the one that is meant"
            if self.advice is PYTHON:
                return choice
            return f"{choice}, or {self.advice.decimal.format(quoted(mark))}"
        if "," in marks:
            advice = self.advice.decimal.format(quoted(","))
            return f"has a comma; {advice}, if commas are decimal marks"
        return ""

    def _may_group(self) -> bool:
        return self.decimal is None and self.is_local


_DASH = ", or a dash where it does not apply"


def _split(cell: str) -> tuple[str, str]:
    """A cell as its number, with all of its marks, and what follows; no number is empty."""
    match = re.fullmatch(r"([-+]?\d[\d.,]*)(\D.*)?", cell)
    return (match[1], match[2] or "") if match else ("", cell)


def read_table(
    source: Source,
    max_rows: int,
    decimal: str | None = None,
    ignore: Collection[str] = (),
    advice: Advice = PYTHON,
) -> Sheet:
    """Read a .csv or .xlsx file, or columns by heading such as a data frame.

    In CSV cells are divided by the first of tab, semicolon and comma in the headings. `decimal` is
    the decimal mark of its numbers. Columns whose headings are in `ignore` are left out. `advice`
    is how its user states both.
    """
    if isinstance(source, str | Path):
        path = user_path(source)
        try:
            rows, is_local = _rows(path, max_rows)
        except InputError:
            raise
        except OSError as error:
            raise InputError(f"{path} cannot be read: {reason_of(error, path)}") from error
        except _UNREADABLE as error:
            raise InputError(f"{path} is no table with a row of headings: {error}") from error
    else:
        path, rows, is_local = Path("the table"), _rows_of_frame(source), False
    if len(rows) < 2:
        raise InputError(f"{path} has no rows below its headings; add one")
    if len(rows) - 1 > max_rows:
        raise InputError(f"{path} has {len(rows) - 1} rows; at most {max_rows} are read")
    sheet = replace(_sheet(str(path), rows, ignore), advice=advice, decimal=decimal)
    cells = [cell for column in sheet.columns for cell in column.cells]
    # A number with a point and not three decimals shows that points are decimal marks.
    points = [number for number, _ in map(_split, cells) if "." in number]
    return replace(sheet, is_local=is_local and all(map(GROUPED.fullmatch, points)))


_UNREADABLE = ValueError, ImportError, csv.Error


def _rows_of_frame(
    source: Mapping[str, Sequence[Any]],
) -> list[tuple[int, list[str]]]:
    """Rows of columns by heading, numbered from 1; headings first."""
    if isinstance(source, pd.DataFrame):
        if named := [str(name) for name in source.index.names if name is not None]:
            raise InputError(f"the index {quoted(named[0])} is not read; use reset_index()")
        columns = [(str(head), source.iloc[:, k]) for k, head in enumerate(source.columns)]
    elif hasattr(source, "dims"):
        raise InputError("a Dataset is no table; give its variables as load and velocity")
    else:
        columns = [(str(head), cells) for head, cells in source.items()]
    lists, sizes = list[list[str]](), dict[str, int]()
    for head, cells in columns:
        plain, column = plain_value(f"column {quoted(head)}", cells), Column.from_heading(head)
        if not isinstance(plain, list):
            raise InputError(f"column {quoted(head)} is no list; give one with a value per row")
        lists.append([_text(column, item) for item in plain])
        sizes[head] = len(plain)
    if len({*sizes.values()}) > 1:
        counts = ", ".join(f"{quoted(head)} {size}" for head, size in sizes.items())
        raise InputError(f"columns differ in their numbers of rows: {counts}; give each as many")
    heads = [head for head, _ in columns]
    return [*enumerate([heads, *map(list, zip(*lists, strict=True))])]


def _text(column: Column, value: Any) -> str:
    """Cell of a value of Python; a number under a heading without a unit is in SI."""
    if value is None or value != value:  # NaN
        return ""
    is_bare = isinstance(value, int | float) and not isinstance(value, bool) and not column.unit
    return f"{value!r} {_SI[column.name]}" if is_bare and column.name in _SI else str(value)


def _rows(path: Path, max_rows: int) -> tuple[list[tuple[int, list[str]]], bool]:
    """Rows of a file with their numbers, headings first, without empty ones and comments above.

    Also true if points of numbers may divide thousands: where cells are not divided by commas.
    """
    content = read_file(path, MOST_BYTES_OF_TEXT)
    if content.startswith(b"PK"):
        rows, mark = [*enumerate(workbook_rows(path, content), start=1)], ","
    elif kind := kind_of(content):
        raise InputError(f"{path} is {kind}; save the table as .csv")
    else:
        _require_few_lines(path, content, max_rows)
        rows, mark = _rows_of_text(path, _decoded(content))
    return [(line, row) for line, row in rows if any(cell.strip() for cell in row)], mark != ","


def _require_few_lines(path: Path, content: bytes, max_rows: int) -> None:
    """Raise an `InputError` for a text with too many or too long lines, before it is parsed."""
    count = content.count(b"\n")
    if count > 2 * max_rows + _MOST_HEADINGS:  # with an empty line below each row
        raise InputError(f"{path} has {count} lines; at most {max_rows} rows are read")
    if (longest := max(map(len, io.BytesIO(content)), default=0)) > MOST_BYTES_OF_LINE:
        raise InputError(
            f"{path} has a line of {longest} bytes; {MOST_BYTES_OF_LINE} at most are read"
        )
    if (cells := max(map(content.count, (b"\t", b";", b",")))) > MOST_CELLS_OF_TEXT:
        raise InputError(f"{path} has {cells} cells; at most {MOST_CELLS_OF_TEXT} are read")


def _decoded(content: bytes) -> str:
    is_utf16 = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    try:
        return content.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")  # as Excel writes in the west


def _rows_of_text(path: Path, text: str) -> tuple[list[tuple[int, list[str]]], str]:
    """Rows of CSV with their numbers, and the delimiter of cells."""
    if "\0" in text:
        raise InputError(f"{path} is binary; save the table as .csv")
    lines = text.splitlines()
    above = next((k for k, row in enumerate(lines) if row.strip() and row[0] != "#"), len(lines))
    head = re.sub('"[^"]*"', "", lines[above]) if lines[above:] else ""
    mark = next((delimiter for delimiter in "\t;," if delimiter in head), ",")
    reader = csv.reader(lines[above:], delimiter=mark, strict=True)
    try:
        return [(above + reader.line_num, row) for row in reader], mark
    except csv.Error as error:
        if re.match("unexpected end of data|field larger", str(error)):
            raise InputError(f"{path}: a quote is not closed; close or remove it") from error
        raise InputError(f"{path}: row {above + reader.line_num}: {error}") from error


def _sheet(name: str, rows: list[tuple[int, list[str]]], ignore: Collection[str]) -> Sheet:
    """Columns of a table; rows with more or fewer cells than headings are faults, and left out."""
    (first, heads), *body = rows
    width = max((k + 1 for k, head in enumerate(heads) if head.strip()), default=0)
    faults, fit = TableFaults(name), list[tuple[int, list[str]]]()
    if width > MOST_COLUMNS:
        raise InputError(f"{name} has {width} columns; at most {MOST_COLUMNS} are read")
    for line, row in body:
        if len(row) < width or any(cell.strip() for cell in row[width:]):
            count = len(row) if len(row) < width else len(_stripped(row))
            faults.append(
                f"row {line} has {count} cell{'s' * (count != 1)} below {width} heading"
                f"{'s' * (width != 1)}; give one for each"
            )
        else:
            fit.append((line, row))
    if len(faults) == len(body) and width == 1:
        fault = f"row {first} has one cell, and rows below have more; leave out the title"
        faults = TableFaults(name, [fault])
    columns, positions = list[Column](), dict[str, int]()
    ignored, skipped = {heading.strip().lower(): heading for heading in ignore}, set[str]()
    for k in range(width):
        column = Column.from_heading(heads[k], [row[k] for _, row in fit])
        keys = {column.head.lower(), column.head.partition("[")[0].strip().lower()} & ignored.keys()
        if keys:
            skipped |= keys
        elif len(column.head) > _LONGEST_HEADING:
            faults.append(f"the heading of column {k + 1} is too long; give a short one")
        elif not column.head:
            problem = f"column {k + 1} has no heading; give one, and merge no cells"
            faults.extend([problem] * any(column.cells))
        elif column.name in positions:
            both = f"in columns {positions[column.name]} and {k + 1}"
            faults.append(f"the heading {quoted(column.head)} stands twice, {both}; leave one out")
        else:
            columns.append(column)
            positions[column.name] = k + 1
            faults.extend(_faults_of_formulas(column, [line for line, _ in fit]))
    listed = ", ".join(quoted(column.head) for column in columns)
    faults.extend(
        f"there is no column {quoted(ignored[key])} to ignore in {listed}; give a heading "
        "of the table"
        for key in ignored.keys() - skipped
    )
    return Sheet(name, columns, [line for line, _ in fit], faults)


def _faults_of_formulas(column: Column, lines: Sequence[int]) -> Iterator[str]:
    """Faults of cells with a formula instead of its value, or with an error of a spreadsheet."""
    for line, cell in zip(lines, column.cells, strict=True):
        if re.match(r"=[^=\s]", cell):
            yield (
                f"row {line}, {column.head}: the formula {quoted(cell)} has no stored value; open "
                "and save the table in a spreadsheet program, or write the number"
            )
        elif _ERRORS.match(cell):
            yield f"row {line}, {column.head}: {cell} is an error of a formula; correct it"


def _stripped(row: list[str]) -> list[str]:
    """A row without empty cells at its end."""
    return row[: max((k + 1 for k, cell in enumerate(row) if cell.strip()), default=0)]


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
    rows, heads = list[dict[str, Any]](), {column.name: column.head for column in columns}
    faulty = {fault.partition(": ")[0] for fault in faults}  # includes locations of cells
    for number, line in enumerate(sheet.lines):
        filled = [column for column in columns if column.cells[number]]
        rows.append({column.name: column.entry(number) for column in filled})
        for name, reason, *_ in faults_in(rows[-1]):
            location = f"row {line}, {heads.get(name, name)}"
            if location not in faulty and (name in heads or name not in needed):
                faults.append(f"{location}: {reason}")
    if faults:
        raise TableError(sheet.name, faults)
    return rows


def numbers_of(sheet: Sheet, units: Mapping[str, str]) -> dict[str, Array]:
    """Values in SI of the columns named in `units`, whose headings or cells have units."""

    def faults_in(row: dict[str, Any]) -> Iterator[tuple[str, str]]:
        for name, unit in units.items():
            try:
                to_si(str(row.get(name, "")), f"1 {unit}")
            except ValueError as error:
                yield name, str(error) if name in row else f"missing; give one in {unit}"

    rows = rows_of(sheet, units, faults_in, needed=units)
    return {
        name: np.array([to_si(str(row[name]), f"1 {unit}") for row in rows])
        for name, unit in units.items()
    }
