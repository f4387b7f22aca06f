"""Tables of tests, operating points, rows and loads: CSV or Excel, with headings like "load [N]".

Cells are text here, and nothing is guessed. A row with more or fewer cells than headings, a
repeated heading, an unknown column and an ambiguous number are refused: all faults at once, each
with its row and column.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from pipeline.limits import MOST_BYTES_OF_BOOK, MOST_CELLS_OF_SHEET
from pipeline.paths import kind_of, read_file, reason_of, user_path
from pipeline.units import UnitError, as_entry, si_unit, to_si
from pipeline.words import did_you_mean, fault_lines, quoted
from tribo import InputError
from tribo.types import Array

Source = str | Path | Mapping[str, Sequence[Any]]
_HEADING = re.compile(r"(.+?)\s*\[([^\[\]]*)\]")
_SAME = {"normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature"}
_PATH = re.compile(r"\w+(\.\w+)+")  # of an entry
_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}([.,]\d{3})+")  # thousands, or three decimals
_SI = {"load": "N", "velocity": "m/s", "bulk_temperature": "K", "critical_temperature": "K"}
"""Units of columns of numbers that are given in Python without one."""
_MAX_LISTED = 12  # names that a message lists
_QUANTITIES = {"N", "m s-1", "K"}
"""SI units of loads, velocities and temperatures; a column with one of them is no label."""
_SYNONYMS = {
    "cof": "friction", "mu": "friction", "friction_coefficient": "friction",
    "coefficient_of_friction": "friction", "speed": "velocity", "sliding_speed": "velocity",
    "force": "load", "t_oil": "bulk_temperature", "result": "outcome",
}  # fmt: skip
"""Headings that are refused, and the name that is suggested for each."""


class TableError(InputError):
    """A table cannot be read; `faults` has all of its faults, a line each."""

    def __init__(self, name: str, faults: list[str]) -> None:
        super().__init__(fault_lines(name, faults))
        self.faults = faults


class Column(NamedTuple):
    """A column: its heading, the name of its quantity or entry, its unit, and its cells as text."""

    head: str
    name: str
    unit: str
    cells: list[str]

    @classmethod
    def from_heading(cls, head: str, cells: Sequence[str] = ()) -> Column:
        """A column by its heading, such as "load [N]"."""
        match = _HEADING.fullmatch(head.strip())
        name, unit = (match[1], match[2]) if match else (head.strip(), "")
        bare = name if "." in name else name.lower().replace(" ", "_")
        return cls(head.strip(), _SAME.get(bare, bare), unit, [cell.strip() for cell in cells])

    def entry(self, row: int) -> str | float:
        """The entry of a row; a cell without a unit has that of the column."""
        cell = self.cells[row]
        return as_entry(cell, self.unit if _NUMBER.fullmatch(cell) else "")

    @property
    def is_label(self) -> bool:
        """True if the cells are words, or quantities that no condition has, such as angles.

        A path, such as pin.radius, is no label: it would be shown and would not act.
        """
        return not _PATH.fullmatch(self.name) and not any(
            self._is_condition(k) for k, cell in enumerate(self.cells) if cell
        )

    def _is_condition(self, row: int) -> bool:
        entry = self.entry(row)
        if not isinstance(entry, str):
            return True
        try:
            return si_unit(entry) in _QUANTITIES
        except (UnitError, InputError):
            return False


@dataclass(frozen=True)
class Sheet:
    """Columns of a table, the numbers of its rows in the file, and its faults.

    The reader of the cells raises these faults together with its own.
    """

    name: str
    columns: list[Column]
    lines: list[int]
    faults: list[str]
    decimal: str | None = None  # decimal mark given by the user
    is_local: bool = False  # True if points of numbers may divide thousands

    def renamed(self, names: Mapping[str, str]) -> Sheet:
        """The sheet with renamed columns; a repeated name is a fault."""
        columns, faults = list[Column](), [*self.faults]
        for original in self.columns:
            column = original._replace(name=names.get(original.name, original.name))
            if column.name in {other.name for other in columns}:
                faults.append(f"the heading {quoted(original.head)} stands twice; leave one out")
            else:
                columns.append(column)
        return Sheet(self.name, columns, self.lines, faults, self.decimal, self.is_local)

    def select(
        self, known: Collection[str], needed: Collection[str] = (), labels: bool = False
    ) -> tuple[list[Column], list[str]]:
        """Columns of the names in `known`, in which numbers have decimal points; and all faults.

        A column of another name is a fault, unless `labels` are allowed and it is one; these are
        among the columns, too.
        """
        faults, selected = [*self.faults], list[Column]()
        names = {column.name for column in self.columns}
        for column in self.columns:
            name = _SYNONYMS.get(column.name.lower(), column.name)
            hint = did_you_mean(name, {*known} - names)
            if column.name in known or (labels and column.is_label and not hint):
                selected.append(column)
                continue
            listed = (
                "the path of an entry" if len(known) > _MAX_LISTED else f"one of {', '.join(known)}"
            )
            advice = "rename it" if hint else f"rename it to {listed}"
            faults.append(
                f"the column {quoted(column.head)} is unknown{hint}; {advice}, or ignore it "
                "(--ignore)"
            )
        heads = ", ".join(quoted(column.head) for column in self.columns)
        missing = [name for name in needed if name not in names]
        faults += [f"no column {name} in {heads}; add it, with its unit" for name in missing]
        columns = [
            column
            if column.name not in known
            else column._replace(cells=[*self._points(column, faults)])
            for column in selected
        ]
        return columns, faults

    def _points(self, column: Column, faults: list[str]) -> Iterator[str]:
        """Yield the cells of a column with decimal points; those with two meanings are faults."""
        for line, cell in zip(self.lines, column.cells, strict=True):
            where, (number, unit) = f"row {line}, {column.head}: {cell}", _split(cell)
            if self.decimal == "," and "." in number:
                faults.append(f"{where} has a point, though decimals have commas")
            elif self.decimal is None and self.is_local and _GROUPED.fullmatch(number):
                faults.append(f'{where} may be a thousand times as much; set decimal to "." or ","')
            elif self.decimal != "," and "," in number:
                hint = 'set decimal to "," if commas are decimal marks'
                if _GROUPED.fullmatch(number):
                    hint = "write thousands without a mark, and decimals with a point"
                faults.append(f"{where} has a comma; {hint}")
            yield number.replace(",", ".") + unit


def _split(cell: str) -> tuple[str, str]:
    """A cell as its number, with all of its marks, and what follows; no number is empty."""
    match = re.fullmatch(r"([-+]?\d[\d.,]*)(\D.*)?", cell)
    return (match[1], match[2] or "") if match else ("", cell)


def read_table(
    source: Source, max_rows: int, decimal: str | None = None, ignore: Collection[str] = ()
) -> Sheet:
    """Read a .csv or .xlsx file, or columns by heading such as a data frame.

    In CSV cells are divided by the first of tab, semicolon and comma in the headings. `decimal` is
    the decimal mark of its numbers. Columns whose headings are in `ignore` are left out.
    """
    if isinstance(source, str | Path):
        path = user_path(source)
        try:
            rows, is_local = _rows(path)
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
    sheet = _sheet(str(path), rows, ignore)
    cells = [cell for column in sheet.columns for cell in column.cells]
    # A number with a point and not three decimals shows that points are decimal marks.
    points = [number for number, _ in map(_split, cells) if "." in number]
    is_local = is_local and all(map(_GROUPED.fullmatch, points))
    return Sheet(sheet.name, sheet.columns, sheet.lines, sheet.faults, decimal, is_local)


_UNREADABLE = ValueError, ImportError, KeyError, SyntaxError, csv.Error, zipfile.BadZipFile


def _rows_of_frame(source: Mapping[str, Sequence[Any]]) -> list[tuple[int, list[str]]]:
    """Rows of columns by heading, numbered from 1; headings first."""
    if lone := [head for head, cells in source.items() if not np.ndim(cells)]:
        raise InputError(f"column {quoted(str(lone[0]))} is no list; give one with a value per row")
    columns = {str(head): [*cells] for head, cells in source.items()}
    if len({len(cells) for cells in columns.values()}) > 1:
        sizes = ", ".join(f"{quoted(head)} {len(cells)}" for head, cells in columns.items())
        raise InputError(f"columns differ in their numbers of rows: {sizes}; give each as many")
    frame = pd.DataFrame(columns)
    numeric = frame.select_dtypes("number")
    heads = [f"{name} [{_SI[name]}]" if name in numeric and name in _SI else name for name in frame]
    cells = ["" if pd.isna(cell) else str(cell) for cell in frame.to_numpy(object).ravel()]
    width = len(heads)
    return [*enumerate([heads, *(cells[k : k + width] for k in range(0, len(cells), width or 1))])]


def _rows(path: Path) -> tuple[list[tuple[int, list[str]]], bool]:
    """Rows of a file with their numbers, headings first, without empty ones and comments above.

    Also true if points of numbers may divide thousands: where cells are not divided by commas.
    """
    content = read_file(path)
    if content.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(content)) as book:
            size = sum(member.file_size for member in book.infolist())
            if "[Content_Types].xml" not in book.namelist() or size > MOST_BYTES_OF_BOOK:
                raise InputError(
                    f"{path} is no workbook, or unpacks to {size / 1e6:.3g} MB, of which "
                    f"{MOST_BYTES_OF_BOOK / 1e6:g} can be read; save the table as .csv"
                )
        filled = {title: rows for title, rows in _sheets(path, content) if rows}
        if len(filled) != 1:
            titles = f": {', '.join(map(quoted, filled))}" * bool(filled)
            raise InputError(f"{path} has {len(filled)} sheets with cells{titles}; keep one")
        rows, mark = [*enumerate(next(iter(filled.values())), start=1)], ","
    elif kind := kind_of(content):
        raise InputError(f"{path} is {kind}; save the table as .csv")
    else:
        rows, mark = _rows_of_text(path, _decoded(content))
    return [(line, row) for line, row in rows if any(cell.strip() for cell in row)], mark != ","


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
        if "unexpected end of data" in str(error):
            raise InputError(f"{path}: a quote is not closed; close or remove it") from error
        raise InputError(f"{path}: row {above + reader.line_num}: {error}") from error


def _sheets(path: Path, content: bytes) -> Iterator[tuple[str, list[list[str]]]]:
    """Yield the title and the rows of each sheet of a workbook, all of one length."""
    import openpyxl  # imported here, since few tables are workbooks

    for sheet in openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True):
        sheet.reset_dimensions()  # those in the file may be wrong
        rows, widest = list[list[str]](), 0
        for number, cells in enumerate(sheet.iter_rows(values_only=True), 1):
            widest = max(widest, len(cells))
            if number * widest > MOST_CELLS_OF_SHEET:
                raise InputError(
                    f"{path} has more than {MOST_CELLS_OF_SHEET} cells up to its last one, empty "
                    "ones included; delete what lies far from the table"
                )
            for cell in cells:
                if isinstance(cell, str) and "." in cell and _GROUPED.fullmatch(cell.strip()):
                    raise InputError(
                        f"{path}: row {number}: {quoted(cell)} is text, which may be a thousand "
                        "times as much; make it a number"
                    )
            rows.append(["" if cell is None else str(cell) for cell in cells])
        filled = any(cell.strip() for row in rows for cell in row)
        yield sheet.title, [row + [""] * (widest - len(row)) for row in rows] if filled else []


def _sheet(name: str, rows: list[tuple[int, list[str]]], ignore: Collection[str]) -> Sheet:
    """Columns of a table; rows with more or fewer cells than headings are faults, and left out."""
    (first, heads), *body = rows
    width = max((k + 1 for k, head in enumerate(heads) if head.strip()), default=0)
    faults, fit = list[str](), list[tuple[int, list[str]]]()
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
        faults = [f"row {first} has one cell, and rows below have more; leave out the title"]
    columns, names = list[Column](), set[str]()
    ignored, skipped = {heading.strip().lower(): heading for heading in ignore}, set[str]()
    for k in range(width):
        column = Column.from_heading(heads[k], [row[k] for _, row in fit])
        keys = {column.head.lower(), column.head.partition("[")[0].strip().lower()} & ignored.keys()
        if keys:
            skipped |= keys
        elif not column.head:
            faults += ["a column has no heading; give one"] * any(column.cells)
        elif column.name in names:
            faults.append(f"the heading {quoted(column.head)} stands twice; leave one out")
        else:
            columns.append(column)
            names.add(column.name)
    listed = ", ".join(quoted(column.head) for column in columns)
    faults += [
        f"there is no column {quoted(ignored[key])} to ignore in {listed}; give a heading "
        "of the table"
        for key in ignored.keys() - skipped
    ]
    return Sheet(name, columns, [line for line, _ in fit], faults)


def _stripped(row: list[str]) -> list[str]:
    """A row without empty cells at its end."""
    return row[: max((k + 1 for k, cell in enumerate(row) if cell.strip()), default=0)]


def rows_of(
    sheet: Sheet,
    names: Collection[str],
    faults_in: Callable[[dict[str, Any]], Iterable[Sequence[Any]]],
    needed: Collection[str] = (),
    labels: bool = False,
) -> list[dict[str, Any]]:
    """Entries in each row, as a scene file has them, of the columns in `names`.

    Empty cells are left out. Other columns are refused, but for `labels` if these are allowed.
    Raises an `InputError` with all faults: of the sheet, and pairs (name, reason) that `faults_in`
    finds in a row, each with its row and column.
    """
    columns, faults = sheet.select(names, needed, labels)
    rows, heads = list[dict[str, Any]](), {column.name: column.head for column in columns}
    faulty = {fault.partition(": ")[0] for fault in faults}  # includes locations of cells
    for number, line in enumerate(sheet.lines):
        filled = [column for column in columns if column.cells[number] and column.name in names]
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
