"""Read rows of Excel workbooks."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

from pipeline.quantities import display
from pipeline.scene.decimals import Typed
from pipeline.scene.lines import Lines, SheetRow
from pipeline.sweep.limits import MOST_BYTES_OF_BOOK, MOST_CELLS_OF_SHEET
from tribo import InputError


def unpacked_size(path: Path) -> int:
    """Number of bytes that a zip archive unpacks to, according to its directory."""
    with zipfile.ZipFile(path) as archive:
        return sum(entry.file_size for entry in archive.infolist())


def read_book(path: Path, wanted: str | None = None) -> list[Lines]:
    """Rows of each sheet of a workbook, or of the sheet `wanted`.

    A formula without a stored value is read as text. Raises an `InputError` if the file is not a
    sound .xlsx file, has no such sheet, or is too large, or if openpyxl is not installed.
    """
    values, formulas = _open_book(path)
    names = [sheet.title for sheet in values.worksheets]
    if wanted is not None and wanted not in names:
        raise InputError(f'{path} has no sheet "{wanted}"; give one of {", ".join(names)}')
    return [
        _read_sheet(path, name, names, values[name], formulas[name])
        for name in ([wanted] if wanted else names)
    ]


def _open_book(path: Path) -> tuple[Any, Any]:
    """Open a workbook twice, by openpyxl: with values, and with formulas."""
    try:
        import openpyxl  # here, as few tables are workbooks

        if (size := unpacked_size(path)) > MOST_BYTES_OF_BOOK:
            raise InputError(
                f"{path}: unpacks to {display(size, 'MB', 4)}; at most "
                f"{display(MOST_BYTES_OF_BOOK, 'MB')} are read of a workbook; keep the sheet and "
                "rows that are needed, or save it as CSV"
            )
        return (
            openpyxl.load_workbook(path, read_only=True, data_only=True),
            openpyxl.load_workbook(path, read_only=True),
        )
    except ImportError as error:
        raise InputError(
            f"{path}: openpyxl reads .xlsx, and is not installed; get it with "
            '"pip install openpyxl", or save the sheet as CSV'
        ) from error
    except (OSError, InputError):
        raise
    except Exception as error:  # from the archive, its XML, or openpyxl
        raise InputError(
            f"{path} is a damaged .xlsx file, or another archive: {error}; save it again"
        ) from error


def _read_sheet(path: Path, name: str, names: list[str], values: Any, formulas: Any) -> Lines:
    """Rows of the sheet `name` of a workbook, and a note on the sheets that are not read."""
    rows, widest = list[SheetRow](), 0
    for sheet in (values, formulas):
        sheet.reset_dimensions()  # the dimensions in the file may be wrong
    both = zip(*(sheet.iter_rows(values_only=True) for sheet in (values, formulas)), strict=True)
    for number, (cells, typed) in enumerate(both, 1):
        widest = max(widest, len(cells))
        if number * widest > MOST_CELLS_OF_SHEET:
            raise InputError(
                f'{path}: sheet "{name}" has more than {MOST_CELLS_OF_SHEET} cells up to its last '
                "one, empty ones included; delete what lies far from the table"
            )
        texts = [*map(_cell_text, cells, typed)]
        rows += [SheetRow(number, texts)] if any(texts) else []
    others = ", ".join(other for other in names if other != name)
    return Lines(
        rows,
        [f'sheet "{name}"' + (f" (not read: {others}; --sheet names another)" if others else "")],
    )


def _cell_text(value: Any, typed: Any) -> str:
    """Text of a cell: its value, or a remark that its formula `typed` has none; else empty."""
    if value is None:
        return f"{typed} without a stored value" if typed is not None else ""
    if isinstance(value, int | float):
        return Typed(value)
    return str(value).removesuffix(" 00:00:00").strip()
