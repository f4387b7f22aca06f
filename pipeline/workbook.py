"""Workbooks of Excel as rows of text, without more memory and time than a table needs."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any

from pipeline.messages import quoted
from pipeline.units import MAYBE_THOUSANDS
from tribo import InputError

_SAVE_AS = "save the table as .csv"
_MAX_BYTES = 10_000_000  # of a workbook, also when it is unpacked
_MAX_PARTS = 1000  # files in a workbook: two for each sheet or figure
_MAX_CELLS = 1_000_000  # of a sheet, with the empty cells before the last filled one
# Tags and attributes: about six for each cell. Those of other parts take five times as long.
_MAX_MARKS_OF_SHEETS, _MAX_MARKS_OF_OTHERS = 120_000, 30_000


def workbook_rows(path: Path, content: bytes) -> list[list[str]]:
    """Rows of the one sheet with cells, all of one length; `InputError` if there is another number.

    The cell of a formula has its stored value, or without one the formula.
    """
    try:
        _require_small(path, content)
        tables = {title: rows for title, rows in _sheets(path, content) if rows}
    except InputError:
        raise
    except Exception as error:  # of damaged files, errors of many kinds
        reason = " ".join(f"{error}".split()) or type(error).__name__
        raise InputError(f"{path} is not a workbook: {reason:.200}; {_SAVE_AS}") from error
    if not tables:
        raise InputError(f"{path} has no sheet with cells; fill one")
    if len(tables) > 1:
        titles = ", ".join(map(quoted, tables))
        raise InputError(f"{path} has {len(tables)} sheets with cells: {titles}; keep one")
    (rows,) = tables.values()
    return rows


def _require_small(path: Path, content: bytes) -> None:
    """Raise an `InputError` for a workbook that would take more time or memory than a table."""
    if len(content) > _MAX_BYTES:
        raise InputError(_too_large(path, f"{len(content) / 1e6:.3g} MB", _MAX_BYTES))
    with zipfile.ZipFile(io.BytesIO(content)) as book:
        members = book.infolist()
        if "[Content_Types].xml" not in book.namelist():
            raise InputError(f"{path} is an archive, not a workbook; {_SAVE_AS}")
        if len(members) > _MAX_PARTS:
            raise InputError(
                f"{path} has {len(members)} parts, of which {_MAX_PARTS} can be read; {_SAVE_AS}"
            )
        size = sum(member.file_size for member in members)
        if size > _MAX_BYTES:
            raise InputError(_too_large(path, f"{size / 1e6:.3g} MB unpacked", _MAX_BYTES))
        marks_of_sheets = [_count_marks(book, member) for member in members if _is_sheet(member)]
        marks_of_others = [
            _count_marks(book, member) for member in members if not _is_sheet(member)
        ]
        if (
            sum(marks_of_sheets) > _MAX_MARKS_OF_SHEETS
            or sum(marks_of_others) > _MAX_MARKS_OF_OTHERS
        ):
            raise InputError(f"{path} has more cells or styles than can be read; {_SAVE_AS}")


def _is_sheet(member: zipfile.ZipInfo) -> bool:
    return member.filename.startswith("xl/worksheets/")


def _count_marks(book: zipfile.ZipFile, member: zipfile.ZipInfo) -> int:
    """Number of tags and attributes in a part, which is not unpacked beyond its limit."""
    with book.open(member) as stream:
        part = stream.read(_MAX_BYTES)
    return part.count(b"<") + part.count(b"=")


def _too_large(path: Path, size: str, limit: int) -> str:
    return f"{path} has {size}, of which {limit / 1e6:g} MB can be read; {_SAVE_AS}"


def _sheets(path: Path, content: bytes) -> Iterator[tuple[str, list[list[str]]]]:
    """Yield the title and the rows of each sheet of a workbook, all of one length."""
    import openpyxl  # imported here, since few tables are workbooks

    values, formulas = (
        openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=data_only)
        for data_only in (True, False)
    )
    for sheet, formula_sheet in zip(values, formulas, strict=True):
        sheet.reset_dimensions()  # those in the file may be wrong
        formula_sheet.reset_dimensions()
        rows, widest = list[list[str]](), 0
        pairs = zip(sheet.iter_rows(), formula_sheet.iter_rows(), strict=True)
        for number, (cells, formula_cells) in enumerate(pairs, 1):
            widest = max(widest, len(cells))
            if number * widest > _MAX_CELLS:
                raise InputError(
                    f"{path} has more than {_MAX_CELLS} cells up to its last one, empty "
                    "ones included; delete what lies far from the table"
                )
            texts = [_cell_text(*pair) for pair in zip(cells, formula_cells, strict=True)]
            for cell, text in zip(cells, texts, strict=True):
                if (
                    cell.data_type == "s"
                    and "." in text
                    and MAYBE_THOUSANDS.fullmatch(text.strip())
                ):
                    raise InputError(
                        f"{path}: row {number}: {quoted(text)} is text, which may be a thousand "
                        "times as much; make it a number"
                    )
            rows.append(texts)
        is_empty = not any(cell.strip() for row in rows for cell in row)
        padded = [row + [""] * (widest - len(row)) for row in rows]
        yield sheet.title, [] if is_empty else padded


def _cell_text(cell: Any, formula_cell: Any) -> str:
    """Text of a cell of a workbook, as it is shown for a number in per cent."""
    value = cell.value
    if value is None or value == "":
        if formula_cell.data_type != "f":
            return ""
        formula = formula_cell.value
        return formula if isinstance(formula, str) else getattr(formula, "text", None) or "=table"
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if is_number and "%" in (cell.number_format or ""):
        return f"{(Decimal(repr(value)) * 100).normalize():f} %"
    return str(value)
