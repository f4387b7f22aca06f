"""Heights of surfaces and records of loads, read from plain files."""

from __future__ import annotations

import csv
import re
import tokenize
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribo.errors import InputError, require_positive
from tribo.loading import MeasuredLoad
from tribo.loading.record import fault
from tribo.types import Array

_MOST_HEIGHTS = 10**8  # of a surface; 0.8 GB
_MOST_ROWS = 1_000_000  # of a load record
_UNITS = {"time": {"s": 1.0, "ms": 1e-3, "min": 60.0}, "load": {"N": 1.0, "kN": 1e3, "mN": 1e-3}}


def read_heights(path: str | Path, unit: float = 1.0, *, allow_missing: bool = False) -> Array:
    """Heights [m] of a measured surface from ``.npy`` or comma-separated ``.csv``.

    Parameters
    ----------
    path : str or Path
        A two-dimensional array: one row for each x, one column for each y.
    unit : float
        Length of one unit of the file [m].
    allow_missing : bool
        True to allow missing heights: NaN in either format, or nothing between two commas.

    Raises
    ------
    InputError
        If the file cannot be read, is not a two-dimensional array of numbers, or holds inf, or
        NaN where none is allowed; the message says where.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "heights.csv")
    ...     _ = file.write_text("1,2,3")
    ...     read_heights(file, unit=1e-6)
    array([[1.e-06, 2.e-06, 3.e-06]])
    """
    path = Path(path)
    require_positive(unit=unit)
    require_file(path)
    try:
        match path.suffix.lower():
            case ".npy":
                heights = _read_npy(path)
            case ".csv":
                heights = _read_csv(path, allow_missing)
            case suffix:
                raise InputError(f"{path}: format {suffix!r} is not known; use .npy or .csv")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    except (ValueError, EOFError, csv.Error, tokenize.TokenError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: not a plain array of numbers: {error}") from error
    if heights.ndim != 2 or heights.size == 0 or heights.dtype.kind not in "fiu":
        raise InputError(
            f"{path}: an array of shape {heights.shape} and type {heights.dtype}; "
            "needed are two-dimensional real numbers, rows along x and columns along y"
        )
    with np.errstate(over="ignore"):
        scaled: Array = heights.astype(np.float64) * unit
    bad = np.argwhere(np.isinf(scaled) if allow_missing else ~np.isfinite(scaled))
    if bad.size:
        row, column = bad[0].tolist()
        raise InputError(
            f"{path}: {len(bad)} of {heights.size} heights are not finite, the first at "
            f"row {row}, column {column} (counted from 0); fill or crop them before"
        )
    return scaled


def require_file(path: Path) -> None:
    """Raise for a file without an end, such as a device or a FIFO that nobody writes to."""
    with suppress(OSError):  # opening it reports the reason better
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: cannot be read: it is not a file")


def reason_of(error: OSError, path: Path) -> str:
    """Reason why a file cannot be read; for a missing one with a path that may be meant."""
    reason = error.strerror or str(error)
    return f"{reason}{near_path(path)}" if isinstance(error, FileNotFoundError) else reason


def near_path(path: Path) -> str:
    """Ask whether a path with a like name was meant; empty if there is none."""
    wrong = next((part for part in (path, *path.parents) if part.parent.is_dir()), path)
    with suppress(OSError):
        names = sorted(entry.name for entry in wrong.parent.iterdir())
        longer = [name for name in names if name.startswith(f"{wrong.name}.")]
        for name in longer or get_close_matches(wrong.name, names, 1, 0.8):
            near = wrong.with_name(name) / path.relative_to(wrong)
            return f' (did you mean "{near}"?)' if near.exists() else ""
    return ""


def _read_npy(path: Path) -> NDArray[Any]:
    """The array of the file, unless it is a packed archive, or too large to be a surface."""
    with path.open("rb") as file:
        magic = file.read(len(np.lib.format.MAGIC_PREFIX))
    if magic != np.lib.format.MAGIC_PREFIX:
        raise ValueError("the file does not begin as NumPy writes arrays")
    if path.stat().st_size > 2 * 8 * _MOST_HEIGHTS:
        raise _too_large(path, f"{path.stat().st_size / 2**30:.1f} GiB")
    try:
        array: NDArray[Any] = np.load(path, allow_pickle=False)
    except MemoryError as error:
        raise ValueError(f"its header asks for more than there is memory: {error}") from error
    if array.size > _MOST_HEIGHTS:
        raise _too_large(path, f"{array.size} heights")
    return array


def _read_csv(path: Path, allow_missing: bool) -> Array:
    """Rows of numbers; the error names the line."""
    rows: list[Array] = []
    count = 0
    missing = "nan" if allow_missing else ""
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file)
        for cells in reader:
            if not cells:
                continue
            where = f"{path}, line {reader.line_num}"
            try:
                rows.append(np.array([float(cell.strip() or missing) for cell in cells]))
            except ValueError as error:
                hint = _hint(cells) or ("" if rows else "; leave a header out")
                raise InputError(f"{where}: {_shortened(str(error))}{hint}") from error
            if len(rows[-1]) != len(rows[0]):
                raise InputError(
                    f"{where}: {len(rows[-1])} numbers, but {len(rows[0])} in the "
                    "first row; all rows must be of equal length"
                )
            count += len(cells)
            if count > _MOST_HEIGHTS:
                raise _too_large(path, f"more than {_MOST_HEIGHTS} heights up to {where}")
    return np.array(rows)


def _shortened(reason: str) -> str:
    """A reason that may quote a whole row, cut to a line."""
    return reason if len(reason) <= 80 else f"{reason[:80]}…"


def _hint(cells: list[str]) -> str:
    """Advice for a row that is not numbers between commas; empty if it is unclear."""
    row = ",".join(cells).strip()
    point = "write decimals with a point"
    for separator, name in ((";", "semicolons"), ("\t", "tabs"), (" ", "spaces")):
        if separator in row and (separator != " " or row[0] in "+-.0123456789"):
            between = f"; put commas between numbers, in place of {name}"
            return between + (f", and {point}" if len(cells) > 1 else "")
    if len(cells) == 4 and all(cell.strip("+- ").isdigit() for cell in cells):
        return f"; {point}"
    return ""


def _too_large(path: Path, size: str) -> InputError:
    return InputError(
        f"{path}: {size}; at most {_MOST_HEIGHTS} heights are read. Crop or average them before"
    )


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
    >>> import tribo
    >>> record = tribo.read_load("workflows/fig8_load_record.csv")
    >>> len(record.times), f"{max(record.loads):.0f} N"
    (300, '605 N')
    """
    path = Path(path)
    require_file(path)
    lines: list[int] = []
    rows: list[tuple[float, float]] = []
    factors: tuple[float, float] | None = None
    load_first = False
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            for cells in reader:
                if not "".join(cells).strip() or cells[0].lstrip().startswith("#"):
                    continue
                where = f"{path}, line {reader.line_num}"
                if len(cells) != 2:
                    raise InputError(
                        f"{where}: {len(cells)} columns; give two, time and load{_hint(cells)}"
                    )
                if factors is None:
                    factors, load_first = _header(cells, where)
                    continue
                if len(rows) == _MOST_ROWS:
                    raise InputError(f"{where}: more than {_MOST_ROWS} rows; thin the record out")
                lines.append(reader.line_num)
                rows.append(_numbers(cells, where))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not comma-separated text in UTF-8: {error}") from error
    if factors is None or len(rows) < 2:
        raise InputError(
            f"{path}: {len(rows)} rows; needed are a header such as 'time [s], load [N]' and at "
            "least two rows"
        )
    columns = np.array(rows).T * np.array(factors)[:, None]
    times, loads = columns[::-1] if load_first else columns
    if reason := fault(times, loads):
        row, why = reason
        raise InputError(f"{path}, line {lines[row]}: {why}")
    try:
        return MeasuredLoad(times, loads, reference_load)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _header(cells: list[str], where: str) -> tuple[tuple[float, float], bool]:
    """Factors of both columns to SI, and whether the load stands first."""
    columns = []
    for cell in cells:
        match = re.search(r"[\[(]\s*(\S*)\s*[\])]\s*$", cell)
        unit = match[1] if match else None
        for kind, units in _UNITS.items():
            if unit in units:
                columns.append((kind, units[unit]))
    if sorted(kind for kind, _ in columns) != ["load", "time"]:
        allowed = " or ".join(", ".join(units) for units in _UNITS.values())
        raise InputError(
            f"{where}: the header is {','.join(cells)!r}; it must give a unit of time and one of "
            f"load in brackets, {allowed}, as 'time [s], load [N]' does"
        )
    (first, factor), (_, other) = columns
    return (factor, other), first == "load"


def _numbers(cells: list[str], where: str) -> tuple[float, float]:
    try:
        return float(cells[0]), float(cells[1])
    except ValueError as error:
        raise InputError(f"{where}: {_shortened(str(error))}{_hint(cells)}") from error
