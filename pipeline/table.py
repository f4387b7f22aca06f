"""Tables of tests, operating points and loads: CSV or Excel, with headings such as "load [N]".

All cells are text here, and nothing is guessed: a row that has not as many cells as there are
headings, a heading that stands twice, and one that is nearly that of a quantity are refused.
"""

from __future__ import annotations

import csv
import difflib
import io
import re
import zipfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from pipeline.limits import MOST_BYTES_OF_BOOK, MOST_CELLS_OF_SHEET
from pipeline.paths import kind_of, read_file, reason_of, user_path
from pipeline.units import as_entry, to_si
from pipeline.words import fault_lines, quoted
from tribo import InputError
from tribo.types import Array

_HEADING = re.compile(r"(.+?)\s*\[([^\[\]]*)\]")
_SAME = {"normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature"}
_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_GROUPED = re.compile(r"[-+]?\d{1,3}([.,]\d{3})+")  # thousands, or three decimals
_SI = {"load": "N", "velocity": "m/s", "bulk_temperature": "K", "critical_temperature": "K"}
"""Units of columns of numbers that are given in Python without one."""
_OTHER_WORDS = {
    **dict.fromkeys(("cof", "mu", "µ", "friction_coefficient", "coefficient_of_friction"),
                    "friction"),
    **dict.fromkeys(("speed", "sliding_speed"), "velocity"),
    **dict.fromkeys(("force", "normal_force"), "load"),
    **dict.fromkeys(("temperature", "oil_temperature"), "bulk_temperature"),
    "result": "outcome",
}  # fmt: skip
"""Headings that are not read, and what may be meant by them."""


class Column(NamedTuple):
    """A column: its heading, the name of its quantity or entry, its unit, and its cells as text."""

    head: str
    name: str
    unit: str
    cells: list[str]

    @classmethod
    def of(cls, head: str, cells: Sequence[str] = ()) -> Column:
        """A column by its heading, such as "load [N]"."""
        found = _HEADING.fullmatch(head.strip())
        name, unit = (found[1], found[2]) if found else (head.strip(), "")
        bare = name if "." in name else name.lower().replace(" ", "_")
        return cls(head.strip(), _SAME.get(bare, bare), unit, [cell.strip() for cell in cells])

    def entry(self, row: int) -> str | float:
        """The entry of a row; a cell without a unit of its own has that of the column."""
        cell = self.cells[row]
        return as_entry(cell, self.unit if _NUMBER.fullmatch(cell) else "")


class Sheet(NamedTuple):
    """Columns of a table, and the numbers of its rows in the file."""

    columns: list[Column]
    lines: list[int]

    def named(self, needed: Collection[str], known: Collection[str]) -> dict[str, Column]:
        """Columns by name; `InputError` if one is missing, or nearly has the name of one known."""
        found = {one.name: one for one in self.columns}
        heads = ", ".join(quoted(one.head) for one in self.columns)
        for name in found.keys() - set(known):
            near = difflib.get_close_matches(name, known, 1, 0.8)
            near += [other for other in known if len(name) > 3 and other.startswith(name)]
            near += [other for word, other in _OTHER_WORDS.items() if word == name]
            if near and near[0] in known and near[0] not in found:
                raise InputError(
                    f"the column {quoted(found[name].head)} is not known (did you mean "
                    f"{quoted(near[0])}?); change its heading, or leave it out"
                )
        if missing := [name for name in needed if name not in found]:
            raise InputError(f"no column {', '.join(missing)} in {heads}; give it, with its unit")
        return found


def read_table(
    source: str | Path | Mapping[str, Sequence[Any]], most: int, decimal: str = "."
) -> Sheet:
    """Read a .csv or .xlsx file, or columns by heading such as a data frame.

    In CSV cells are divided by the first of tab, semicolon and comma in the headings. `decimal` is
    the decimal mark of its numbers. Raises an `InputError` with all rows that are faulty.
    """
    if isinstance(source, str | Path):
        path = user_path(source)
        try:
            rows = _rows(path)
        except OSError as error:
            raise InputError(f"{path} cannot be read: {reason_of(error, path)}") from error
        except (
            ValueError,
            ImportError,
            KeyError,
            SyntaxError,
            csv.Error,
            zipfile.BadZipFile,
        ) as error:
            raise InputError(f"{path} is no table with a row of headings: {error}") from error
    else:
        path, frame = Path("the table"), pd.DataFrame({str(k): [*x] for k, x in source.items()})
        numeric = frame.select_dtypes("number")
        frame = frame.rename(columns={x: f"{x} [{_SI[x]}]" for x in numeric if x in _SI})
        cells = ["" if pd.isna(cell) else str(cell) for cell in frame.to_numpy(object).ravel()]
        width = len(frame.columns)
        body = [cells[k : k + width] for k in range(0, len(cells), width or 1)]
        rows = [*enumerate([[*frame], *body], start=1)]
    if len(rows) < 2:
        raise InputError(f"{path} has no rows below its headings; give one at least")
    if len(rows) - 1 > most:
        raise InputError(f"{path} has {len(rows) - 1} rows; at most {most} are read")
    return _sheet(str(path), rows, decimal)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Rows of a file with their numbers, headings first; without empty rows and comments."""
    content = read_file(path)
    if content.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(content)) as book:
            size = sum(one.file_size for one in book.infolist())
            if "[Content_Types].xml" not in book.namelist() or size > MOST_BYTES_OF_BOOK:
                raise InputError(
                    f"{path} is no workbook, or unpacks to {size / 1e6:.3g} MB, of which "
                    f"{MOST_BYTES_OF_BOOK / 1e6:g} can be read; save the table as .csv"
                )
        filled = [sheet for sheet in _sheets(path, content) if sheet]
        if len(filled) != 1:
            raise InputError(f"{path} has {len(filled)} sheets with cells; keep one")
        rows = [*enumerate(filled[0], start=1)]
    elif kind := kind_of(content):
        raise InputError(f"{path} is {kind}; save the table as .csv")
    else:
        wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
        try:
            text = content.decode("utf-16" if wide else "utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("cp1252", errors="replace")  # as Excel writes in the west
        lines = ["" if one.startswith("#") else one for one in text.splitlines()]
        head = next((one for one in lines if one.strip()), "")
        mark = next((one for one in "\t;," if one in head), ",")
        reader = csv.reader(lines, delimiter=mark, strict=True)
        rows = [(reader.line_num, row) for row in reader]
    return [(line, row) for line, row in rows if any(cell.strip() for cell in row)]


def _sheets(path: Path, content: bytes) -> Iterator[list[list[str]]]:
    """Yield the rows of each sheet of a workbook, all of one length."""
    import openpyxl  # here, as few tables are workbooks

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
            rows.append(["" if cell is None else str(cell) for cell in cells])
        yield [row + [""] * (widest - len(row)) for row in rows]


def _sheet(name: str, rows: list[tuple[int, list[str]]], decimal: str) -> Sheet:
    """Columns of rows; `InputError` with all rows whose cells do not fit the headings."""
    (_, heads), *body = rows
    width, said = len(heads), list[str]()
    for line, row in body:
        extra = row[width:]
        if len(row) < width or any(cell.strip() for cell in extra):
            said.append(f"row {line} has {len(row)} cells below {width} headings; give as many")
    columns = [
        Column.of(head, [row[k] if k < len(row) else "" for _, row in body])
        for k, head in enumerate(heads)
    ]
    columns = [one for one in columns if one.head or any(one.cells)]
    names = [one.name for one in columns]
    said += [
        f"the heading {quoted(one.head)} stands twice; leave one out" if one.head
        else "a column has no heading; give one" for k, one in enumerate(columns)
        if not one.head or one.name in names[:k]
    ]  # fmt: skip
    for one in columns if not said else ():
        for k, cell in enumerate(one.cells):
            where = f"row {body[k][0]}, {one.head}"
            if decimal == "," and _GROUPED.fullmatch(cell) and "." in cell:
                said.append(f"{where}: {cell} has a point, though decimals have commas")
            elif decimal == "," and _NUMBER.fullmatch(cell.replace(",", ".")):
                one.cells[k] = cell.replace(",", ".")
            elif decimal == "." and one.unit and re.fullmatch(r"[-+]?\d+,\d+", cell):
                hint = 'give decimal "," if decimals have commas'
                if _GROUPED.fullmatch(cell):
                    hint = "write thousands without a mark, and decimals with a point"
                said.append(f"{where}: {cell} has a comma; {hint}")
    if said:
        raise InputError(fault_lines(name, [*dict.fromkeys(said)]))
    return Sheet(columns, [line for line, _ in body])


def rows_of(
    sheet: Sheet,
    names: Collection[str],
    faults_in: Callable[[dict[str, Any]], Iterable[Sequence[Any]]],
    needed: Collection[str] = (),
    strict: bool = False,
) -> list[dict[str, Any]]:
    """Entries in each row, as a scene file has them, of the columns in `names`.

    Empty cells are left out. Other columns are left out, too, or refused if `strict`. Raises an
    `InputError` with all faults: pairs (name, reason) that `faults_in` finds in a row, each with
    its row and column.
    """
    known, said, rows = sheet.named(needed, names), list[str](), list[dict[str, Any]]()
    if strict and (other := [one.head for one in known.values() if one.name not in names]):
        raise InputError(
            f"{', '.join(map(quoted, other))} is no entry of a test; leave out the column, or give "
            f"it one of the headings {', '.join(names)}"
        )
    for number, line in enumerate(sheet.lines):
        own = [one for one in known.values() if one.name in names and one.cells[number]]
        row = {one.name: one.entry(number) for one in own}
        heads = {one.name: one.head for one in own}
        said += [f"row {line}, {heads.get(name, name)}: {why}" for name, why, *_ in faults_in(row)]
        rows.append(row)
    if said:
        raise InputError(fault_lines("the table", said))
    return rows


def numbers_of(sheet: Sheet, units: Mapping[str, str]) -> dict[str, Array]:
    """Values in SI of the columns named in `units`, whose headings or cells have units."""
    known, said = sheet.named(units, units), list[str]()
    values: dict[str, list[float]] = {name: [] for name in units}
    for name, unit in units.items():
        for line, number in zip(sheet.lines, range(len(sheet.lines)), strict=True):
            try:
                values[name].append(to_si(str(known[name].entry(number)), f"1 {unit}"))
            except ValueError as error:
                said.append(f"row {line}, {known[name].head}: {error}")
    if said:
        raise InputError(fault_lines("the table", said))
    return {name: np.array(one) for name, one in values.items()}
