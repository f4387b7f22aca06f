"""Rows of a file as instruments and offices write them: CSV in any usual form, or Excel."""

from __future__ import annotations

import csv
import itertools
import re
import statistics
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.quantities import display
from pipeline.scene.headings import Row, Sheet, sheet_below
from pipeline.sweep.limits import MOST_BYTES_OF_BOOK, MOST_CELLS_OF_SHEET
from tribo import InputError
from tribo.errors import reason_of, require_file

ROW_FILES = (".csv", ".txt", ".tsv", ".dat", ".asc", ".xlsx")
_NAMES = {";": "semicolons", "\t": "tabs", ",": "commas"}
_SURE_COMMA = re.compile(r"[+-]?(?:0,\d+|\d+,(?:\d{1,2}|\d{4,}))")
_COMMA = re.compile(r"([+-]?(?:\d{1,3}(?:\.\d{3})+|\d+)),(\d+)(?![\d,.])(.*)", re.DOTALL)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d")
_MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+(?!\d)")
_MARKS = {",": "decimal commas", ".": "decimal points"}
_MOST_ABOVE = 500  # rows among which that of the headings is sought, each with all above it


def read_rows(
    path: Path,
    is_heading: Callable[[list[str], str], bool],
    decimal: str | None = None,
    sheet: str | None = None,
) -> Sheet:
    """Read the rows of a file below the first line that is a heading, given the text above it.

    Cells stand between semicolons, tabs or commas; lines that begin with ``#`` are comments.
    Decimal commas are found unless the mark is given. Of a workbook it is the first sheet unless
    one is named.
    """
    require_file(path)
    is_book = path.suffix.lower() == ".xlsx"
    if sheet is not None and not is_book:
        raise InputError(f'{path} has no sheets, so none called "{sheet}"; leave it out')
    if path.suffix.lower() not in ROW_FILES:
        raise InputError(
            f"{path} cannot be read: rows are read from {', '.join(ROW_FILES)}; save it as .xlsx "
            "or CSV"
        )
    try:
        lines, form, separator = _read_excel(path, sheet) if is_book else _read_text(path)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {reason_of(error, path)}") from error
    filled = [Row(number, cells) for number, cells in enumerate(lines, 1) if any(cells)]
    plain = [Row(row.number, _uncommented(row.cells)) for row in filled]
    first = enumerate(plain[:_MOST_ABOVE])
    said = (row for k, row in first if is_heading(row.cells, _text_of(plain[:k])))
    bare = (row for row in filled if not row.cells[0].startswith("#"))
    heading = next(itertools.chain(said, bare, plain), Row(0, []))
    heads = _trim_end(heading.cells)
    below = [
        Row(row.number, _trim_end(row.cells, len(heads)))
        for row in filled
        if row.number > heading.number and not row.cells[0].startswith("#")
    ]
    is_sure = decimal is not None
    if decimal is None:
        cells = (cell for row in below for cell in row.cells)
        # Between commas they are quoted; those before three digits alone may be thousands.
        mark = _SURE_COMMA if separator == "," else _COMMA
        decimal = "," if any(map(mark.fullmatch, cells)) else "."
    rows = [
        Row(row.number, [_plain(cell, decimal, is_sure) for cell in row.cells]) for row in below
    ]
    above = _text_of([row for row in plain if row.number < heading.number])
    return replace(sheet_below(heads, rows, decimal, [*form, _MARKS[decimal]]), above=above)


def _text_of(rows: Sequence[Row]) -> str:
    return " ".join(cell for row in rows for cell in row.cells)


def decoded(content: bytes) -> tuple[str, bool]:
    """Text of a file in UTF-8, UTF-16 or Latin-1; true if it is the last."""
    is_latin = False
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = content.decode("utf-16", errors="replace")
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text, is_latin = content.decode("cp1252", errors="replace"), True
    return text.replace("\0", ""), is_latin


def _read_text(path: Path) -> tuple[list[list[str]], list[str], str]:
    """Cells of all lines of a text file, words on its form, and its separator."""
    text, is_latin = decoded(path.read_bytes())
    form = ["Latin-1"] if is_latin else []
    lines = text.splitlines()
    filled = [line for line in lines if line.strip()]
    # In a file with decimal commas these may be as many as semicolons.
    usual = [mark for mark in _NAMES if 2 * sum(mark in line for line in filled) >= len(filled)]
    blanks = [re.sub(r"^\s*#\s*", "#", line).split() for line in lines]
    if not usual and filled and statistics.mode(len(row) for row in blanks if row) > 1:
        return blanks, ["blanks between cells", *form], " "
    separator = (usual or [","])[0]
    try:
        cells = [list(map(str.strip, line)) for line in csv.reader(lines, delimiter=separator)]
    except csv.Error as error:
        raise InputError(f"{path} cannot be read: {error}; save it as CSV again") from error
    return cells, [f"{_NAMES[separator]} between cells", *form], separator


def _read_excel(path: Path, wanted: str | None) -> tuple[list[list[str]], list[str], str]:
    """Cells of all lines of a sheet of an Excel file, and words on it and on the others."""
    import pandas as pd  # here, since few scenes have rows in a sheet

    try:
        _require_few_bytes(path)
        with pd.ExcelFile(path, engine="openpyxl") as book:
            names = [str(name) for name in book.sheet_names]
            name = names[0] if wanted is None else wanted
            if name not in names:
                raise InputError(f'{path} has no sheet "{name}"; give one of {", ".join(names)}')
            _require_few_cells(path, book.book[name])
            sheet = pd.read_excel(book, name, header=None, dtype=str, na_filter=False)
    except ImportError as error:
        raise InputError(
            f"{path}: openpyxl reads .xlsx, and is not installed; get it with "
            '"pip install openpyxl", or save the sheet as CSV'
        ) from error
    except (OSError, InputError):
        raise
    except Exception as error:  # from the archive, its XML, or openpyxl
        raise InputError(f"{path} is no sound .xlsx file: {error}; save it again") from error
    lines = [[cell.removesuffix(" 00:00:00").strip() for cell in line] for line in sheet.to_numpy()]
    others = [other for other in names if other != name]
    more = f" (not read: {', '.join(others)})" if others else ""
    return lines, [f'sheet "{name}"{more}'], ""


def _require_few_cells(path: Path, sheet: Any) -> None:
    """Refuse a sheet that would be larger than what is read, for one cell far away is enough."""
    sheet.reset_dimensions()  # what the file says of them need not be so
    widest = 0
    for count, row in enumerate(sheet.iter_rows(values_only=True), 1):
        widest = max(widest, len(row))
        if count * widest > MOST_CELLS_OF_SHEET:
            raise InputError(
                f'{path}: sheet "{sheet.title}" has more than {MOST_CELLS_OF_SHEET} cells up to '
                "its last one, empty ones included; delete what lies far from the table"
            )


def unpacked_size(path: Path) -> int:
    """Bytes that an archive unpacks to, as it says itself."""
    with zipfile.ZipFile(path) as archive:
        return sum(entry.file_size for entry in archive.infolist())


def _require_few_bytes(path: Path) -> None:
    """Refuse a workbook that unpacks to more text than its cells may have."""
    size = unpacked_size(path)
    if size > MOST_BYTES_OF_BOOK:
        raise InputError(
            f"{path}: unpacks to {display(size, 'MB', 4)}; at most "
            f"{display(MOST_BYTES_OF_BOOK, 'MB')} are read of a workbook; keep the sheet and rows "
            "that are needed, or save it as CSV"
        )


def _uncommented(cells: list[str]) -> list[str]:
    """Cells of a line that may be a heading behind a ``#``, as `numpy.savetxt` writes it."""
    return [cells[0].lstrip("# "), *cells[1:]] if cells[0].startswith("#") else cells


def _trim_end(cells: Sequence[str], least: int = 0) -> list[str]:
    """Cells without empty ones at the end, beyond a number of them."""
    end = len(cells)
    while end > least and not cells[end - 1]:
        end -= 1
    return list(cells[:end])


def _plain(cell: str, decimal: str, is_sure: bool) -> str:
    """Cell with a decimal point and no marks of thousands; one that may have them stays a fault."""
    if decimal == "," and (match := _COMMA.fullmatch(cell)):
        whole, decimals, unit = match.groups()
        # A digit more, since 1.250 may be thousands and 1,250 is none here.
        more = "0" if len(decimals) == 3 else ""
        return f"{whole.replace('.', '')}.{decimals}{more}{unit}"
    if decimal == "," and is_sure and may_be_thousands(cell):
        number, *unit_of_it = cell.split(" ")
        return " ".join([number.replace(".", ""), *unit_of_it])
    return cell.replace(",", "") if decimal == "." and _THOUSANDS.match(cell) else cell


def may_be_thousands(cell: str) -> bool:
    """True of ``1.250`` beside decimal commas, which is 1.25 or 1250."""
    return _MAYBE_THOUSANDS.fullmatch(cell.split(" ")[0]) is not None
