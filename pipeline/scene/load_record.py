"""Records of a load in files of comma-separated text."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pipeline.quantities import DIMENSIONS
from tribo import InputError, MeasuredLoad
from tribo.errors import hint_of_row, reason_of, require_file, shortened
from tribo.loading.record import fault

_MOST_ROWS = 1_000_000  # in a file
_UNITS = {"time": DIMENSIONS["s"].units, "load": DIMENSIONS["N"].units}
Columns = dict[str, tuple[int, float]]
"""Place of the column of time and of that of load, and their factors to SI."""


def read_load(path: str | Path, reference_load: float | None = None) -> MeasuredLoad:
    """Read a load record from comma-separated text.

    Parameters
    ----------
    path : str or Path
        Two columns, time and load in either order, below a header with their units, such as
        ``time [s], normal load [N]``; s, ms, min and N, kN, mN are known. Empty lines and lines
        that begin with # are left out.
    reference_load : float, optional
        See `MeasuredLoad`.

    Raises
    ------
    InputError
        If the file cannot be read or is no such record; the message names the line.

    Examples
    --------
    >>> record = read_load("workflows/fig8_load_record.csv")
    >>> len(record.times), f"{max(record.loads):.0f} N"
    (300, '605 N')
    """
    path = Path(path)
    require_file(path)
    lines, rows = list[int](), list[tuple[float, float]]()
    columns: Columns | None = None
    for line, cells in _filled_lines(path):
        where = f"{path}, line {line}"
        if len(cells) != 2:
            hint = hint_of_row(cells)
            raise InputError(f"{where}: {len(cells)} columns; give two, time and load{hint}")
        if columns is None:
            columns = _header(cells, where)
            continue
        if len(rows) == _MOST_ROWS:
            raise InputError(f"{where}: more than {_MOST_ROWS} rows; thin the record out")
        lines.append(line)
        rows.append(_numbers(cells, where))
    if columns is None or len(rows) < 2:
        raise InputError(
            f"{path}: {len(rows)} rows; needed are a header such as 'time [s], load [N]' and at "
            "least two rows"
        )
    times, loads = (
        factor * np.array(rows)[:, place] for place, factor in (columns[name] for name in _UNITS)
    )
    if reason := fault(times, loads):
        row, why = reason
        raise InputError(f"{path}, line {lines[row]}: {why}")
    try:
        return MeasuredLoad(times, loads, reference_load)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _filled_lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of each line that is neither empty nor a comment."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            for cells in reader:
                if "".join(cells).strip() and not cells[0].lstrip().startswith("#"):
                    yield reader.line_num, cells
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not comma-separated text in UTF-8: {error}") from error


def _header(cells: list[str], where: str) -> Columns:
    """Columns of time and load below a header."""
    columns: Columns = {}
    for place, cell in enumerate(cells):
        match = re.search(r"[\[(]\s*(\S*)\s*[\])]\s*$", cell)
        unit = match[1] if match else ""
        columns |= {kind: (place, float(of[unit])) for kind, of in _UNITS.items() if unit in of}
    if columns.keys() != _UNITS.keys():
        allowed = " or ".join(", ".join(units) for units in _UNITS.values())
        raise InputError(
            f"{where}: the header is {','.join(cells)!r}; it must give a unit of time and one of "
            f"load in brackets, {allowed}, as 'time [s], load [N]' does"
        )
    return columns


def _numbers(cells: list[str], where: str) -> tuple[float, float]:
    try:
        return float(cells[0]), float(cells[1])
    except ValueError as error:
        raise InputError(f"{where}: {shortened(str(error))}{hint_of_row(cells)}") from error
