"""Read tables of operating points, tests, cases and loads: text, Excel, or columns of Python."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.arguments import plain_value
from pipeline.messages import pluralized, quoted
from pipeline.paths import is_binary, read_file, reason_of, user_path
from pipeline.table import PYTHON, Advice, Column, Sheet, TableFaults, split_number
from pipeline.units import MAYBE_THOUSANDS
from pipeline.workbook import workbook_rows
from tribo import InputError

Source = str | Path | Mapping[str, Sequence[Any]]
_SPREADSHEET_ERROR = re.compile(r"#(N/A|DIV/0!|NAME\?|NULL!|NUM!|REF!|VALUE!)")
_PYTHON_UNITS = {
    "load": "N",
    "velocity": "m/s",
    "bulk_temperature": "K",
    "critical_temperature": "K",
}
"""Units of numbers that are given in Python without one."""


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
        except (ValueError, ImportError, csv.Error) as error:
            raise InputError(f"{path} is not a table with a row of headings: {error}") from error
    else:
        path, rows, is_local = Path("the table"), _rows_of_frame(source), False
    if len(rows) < 2:
        raise InputError(f"{path} has no rows below its headings; add one")
    if len(rows) - 1 > max_rows:
        raise InputError(f"{path} has {len(rows) - 1} rows; at most {max_rows} are read")
    sheet = replace(_sheet(str(path), rows, ignore), advice=advice, decimal=decimal)
    cells = [cell for column in sheet.columns for cell in column.cells]
    # A number with a point and not three decimals shows that points are decimal marks.
    with_points = [number for number, _ in map(split_number, cells) if "." in number]
    return replace(sheet, is_local=is_local and all(map(MAYBE_THOUSANDS.fullmatch, with_points)))


def _rows_of_frame(
    source: Mapping[str, Sequence[Any]],
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
    headings, cell_columns = [heading for heading, _ in columns], list[list[str]]()
    for heading, values in columns:
        plain_values = plain_value(f"column {quoted(heading)}", values)
        if not isinstance(plain_values, list):
            raise InputError(f"column {quoted(heading)} is not a list; give one value for each row")
        column = Column.from_heading(heading)
        cell_columns.append([_cell_text(column, value) for value in plain_values])
    if len({*map(len, cell_columns)}) > 1:
        pairs = zip(headings, cell_columns, strict=True)
        counts = ", ".join(f"{quoted(heading)} {len(cells)}" for heading, cells in pairs)
        raise InputError(f"columns have different numbers of rows: {counts}; give each the same")
    return [*enumerate([headings, *map(list, zip(*cell_columns, strict=True))])]


def _cell_text(column: Column, value: Any) -> str:
    """Cell of a value of Python; a number under a heading without a unit is in SI."""
    if value is None or value != value:  # NaN
        return ""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if is_number and not column.unit and column.name in _PYTHON_UNITS:
        return f"{value!r} {_PYTHON_UNITS[column.name]}"
    return str(value)


def _rows(path: Path, max_rows: int) -> tuple[list[tuple[int, list[str]]], bool]:
    """Rows of a file with their numbers, headings first, without empty ones and comments above.

    Also true if points of numbers may divide thousands: where cells are not divided by commas.
    """
    content = read_file(path, max_bytes=40_000_000)
    if content.startswith(b"PK"):
        rows, delimiter = [*enumerate(workbook_rows(path, content), start=1)], ","
    elif is_binary(content):
        raise InputError(f"{path} is binary; save the table as .csv")
    else:
        _require_few_lines(path, content, max_rows)
        rows, delimiter = _rows_of_text(path, _decoded(content))
    filled_rows = [(line, row) for line, row in rows if any(cell.strip() for cell in row)]
    return filled_rows, delimiter != ","


def _require_few_lines(path: Path, content: bytes, max_rows: int) -> None:
    """Raise an `InputError` for a text with too many or too long lines, before it is parsed."""
    count = content.count(b"\n")
    if count > 2 * max_rows + 1000:  # with an empty line below each row, and lines above the table
        raise InputError(f"{path} has {count} lines; at most {max_rows} rows are read")
    max_length, max_cells = 100_000, 5_000_000  # a cell becomes an object of 60 bytes
    if (longest := max(map(len, io.BytesIO(content)), default=0)) > max_length:
        raise InputError(f"{path} has a line of {longest} bytes; {max_length} at most are read")
    if (cells := max(map(content.count, (b"\t", b";", b",")))) > max_cells:
        raise InputError(f"{path} has {cells} cells; at most {max_cells} are read")


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
    table_lines = (k for k, line in enumerate(lines) if line.strip() and line[0] != "#")
    start = next(table_lines, len(lines))
    headings = re.sub('"[^"]*"', "", lines[start]) if lines[start:] else ""
    delimiter = next((mark for mark in "\t;," if mark in headings), ",")
    reader = csv.reader(lines[start:], delimiter=delimiter, strict=True)
    try:
        return [(start + reader.line_num, row) for row in reader], delimiter
    except csv.Error as error:
        if re.match("unexpected end of data|field larger", str(error)):
            raise InputError(f"{path}: a quote is not closed; close or remove it") from error
        raise InputError(f"{path}: row {start + reader.line_num}: {error}") from error


def _sheet(name: str, rows: list[tuple[int, list[str]]], ignore: Collection[str]) -> Sheet:
    """Columns of a table; rows with more or fewer cells than headings are faults, and left out."""
    (first, headings), *body = rows
    width = _filled_length(headings)
    faults, body_rows = TableFaults(name), list[tuple[int, list[str]]]()
    if width > 1000:
        raise InputError(f"{name} has {width} columns; at most 1000 are read")
    for line, row in body:
        if len(row) < width or any(cell.strip() for cell in row[width:]):
            count = len(row) if len(row) < width else _filled_length(row)
            cells = pluralized(count, "cell", "cells")
            below = pluralized(width, "heading", "headings")
            faults.append(f"row {line} has {cells} below {below}; give one for each")
        else:
            body_rows.append((line, row))
    if len(faults) == len(body) and width == 1:
        fault = f"row {first} has one cell, and rows below have more; leave out the title"
        faults = TableFaults(name, [fault])
    columns, positions = list[Column](), dict[str, int]()
    ignored, skipped = {heading.strip().lower(): heading for heading in ignore}, set[str]()
    for k in range(width):
        column = Column.from_heading(headings[k], [row[k] for _, row in body_rows])
        keys = {
            column.heading.lower(),
            column.heading.partition("[")[0].strip().lower(),
        } & ignored.keys()
        if keys:
            skipped |= keys
        elif len(column.heading) > 200:
            faults.append(f"the heading of column {k + 1} is too long; give a short one")
        elif not column.heading:
            if any(column.cells):
                faults.append(f"column {k + 1} has no heading; give one, and merge no cells")
        elif column.name in positions:
            first = positions[column.name]
            faults.append(
                f"the heading {quoted(column.heading)} occurs twice, in columns {first} and "
                f"{k + 1}; leave one out"
            )
        else:
            columns.append(column)
            positions[column.name] = k + 1
            faults.extend(_faults_of_formulas(column, [line for line, _ in body_rows]))
    heading_list = ", ".join(quoted(column.heading) for column in columns)
    faults.extend(
        f"there is no column {quoted(ignored[key])} to ignore in {heading_list}; give a heading "
        "of the table"
        for key in ignored.keys() - skipped
    )
    return Sheet(name, columns, [line for line, _ in body_rows], faults)


def _faults_of_formulas(column: Column, lines: Sequence[int]) -> Iterator[str]:
    """Faults of cells with a formula instead of its value, or with an error of a spreadsheet."""
    for line, cell in zip(lines, column.cells, strict=True):
        if re.match(r"=[^=\s]", cell):
            yield (
                f"row {line}, {column.heading}: the formula {quoted(cell)} has no stored value; "
                "open and save the table in a spreadsheet program, or write the number"
            )
        elif _SPREADSHEET_ERROR.match(cell):
            yield f"row {line}, {column.heading}: {cell} is an error of a formula; correct it"


def _filled_length(row: Sequence[str]) -> int:
    """Number of cells of a row without the empty ones at its end."""
    return max((k + 1 for k, cell in enumerate(row) if cell.strip()), default=0)
