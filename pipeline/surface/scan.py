"""Read scans: matrices of heights, as arrays or text.

Nothing is guessed: the unit of the heights is an argument, and a file that is no map of heights,
such as a profile or a list of points, is refused.
"""

from __future__ import annotations

import io
import itertools
import math
import re
from contextlib import suppress
from pathlib import Path

import numpy as np

from pipeline.messages import quoted
from pipeline.paths import (
    is_binary,
    is_workbook,
    read_file,
    reason_of,
    user_path,
    workbook_problem,
)
from pipeline.units import MAYBE_THOUSANDS
from tribo import InputError
from tribo.types import Array

_MIN_SIDE = 9  # heights along a side of a map; less are columns of a table
_FARTHER = 4  # of a line that rises from end to end, over the range of all heights inside
_SPLIT_DECIMAL = re.compile(r"(?m)(?:^|,) *(-0|0\d+) *(?=,|$)")
"""Decimals that a decimal comma cut off: whole numbers have no leading zeros."""


def read_scan(path: str | Path, height_unit: float) -> tuple[Array, list[str]]:
    """Read a map of heights, in which x goes from column to column.

    Parameters
    ----------
    path : str or Path
        Plain array (.npy), or matrix in text.
    height_unit : float
        Unit of the heights [m].

    Returns
    -------
    heights : ndarray, shape (nx, ny)
        Heights [m], NaN where one is missing.
    notes : list of str
        How missing heights were recognized.

    Raises
    ------
    InputError
        If the file is no map, or cannot be read.
    """
    path = user_path(path)
    try:
        content = read_file(path, max_bytes=2**28)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    try:
        is_array = content.startswith(b"\x93NUMPY")
        if not is_array:
            _require_text(path, content)
        matrix = _require_map(_array(content) if is_array else _matrix(content))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    heights, notes = _without_marks(matrix.T)
    heights *= height_unit
    highest = np.abs(heights[np.isfinite(heights)]).max(initial=0.0)
    if highest > 1.0:
        raise InputError(f"{path}: heights of {highest:.3g} m; give the right unit, height_unit")
    return heights, ["x, the sliding direction, goes from column to column", *notes]


def _without_marks(heights: Array) -> tuple[Array, list[str]]:
    """Heights with marks of missing ones, such as −9999 or infinity, as NaN; and notes on these."""
    notes, heights = list[str](), np.where(np.isfinite(heights), heights, np.nan)
    values = np.unique(heights[np.isfinite(heights)])
    for mark in _marks_in(values):
        notes.append(f"{(heights == mark).sum()} heights of {mark:.6g} are treated as missing")
        heights[heights == mark] = np.nan
    values, counts = np.unique(heights[np.isfinite(heights)], return_counts=True)
    second_count, max_count = np.sort(np.append(counts, [0, 0]))[-2:].tolist()
    if max_count > max(0.01 * heights.size, 10 * second_count):
        value = values[counts.argmax()]
        notes.append(f"{max_count} heights are exactly {value:.6g}: write nan if these are missing")
    return np.ascontiguousarray(heights), notes


def _marks_in(values: Array) -> list[float]:
    """At most three values at each end of ascending `values` that are far from all others."""
    marks, inner = list[float](), values
    for _ in range(2):  # at either end
        for count in (3, 2, 1):
            if inner.size < count + 3:
                continue
            if _is_far(inner, count):
                marks, inner = marks + inner[:count].tolist(), inner[count:]
                break
            if _is_far(-inner[::-1], count):
                marks, inner = marks + inner[-count:].tolist(), inner[:-count]
                break
    return marks


def _is_far(values: Array, count: int) -> bool:
    """True if the lowest values, `count` of them, are far below all others, without the highest."""
    others = values[count:]
    most_others = others[:-3] if others.size > 9 else others[:-1]
    return bool(others[0] - values[count - 1] > 4 * np.ptp(most_others))


def _require_text(path: Path, content: bytes) -> None:
    """Raise an `InputError` for a workbook, and for another file that is no text."""
    if is_workbook(path, content):
        raise InputError(workbook_problem(path))
    if is_binary(content):
        array = path.with_suffix(".npy").name
        raise InputError(
            "no text, maybe a file of an instrument: write its heights as an array in Python: "
            f"surface = SurfaceTopography.open_topography({quoted(path.name)}).topography()"
            f'.to_unit("um"); np.save({quoted(array)}, np.ma.filled(surface.heights(), np.nan).T); '
            f'then set file = {quoted(array)} and height_unit = "um"'
        )


def _array(content: bytes) -> Array:
    """Numbers of a .npy file in two dimensions."""
    try:
        array = np.load(io.BytesIO(content), allow_pickle=False)
    except Exception as error:  # of a damaged file, errors of many kinds
        raise InputError(f"not a plain array of numbers: {error}") from error
    if array.ndim not in (1, 2) or array.size == 0 or array.dtype.kind not in "fiu":
        raise InputError(
            f"an array of shape {array.shape} and type {array.dtype}; give a two-dimensional array "
            "of real numbers, a row for each y"
        )
    return np.array(array, dtype=float, ndmin=2)


def _matrix(content: bytes) -> Array:
    """Numbers in rows of text, a row for each y; an empty cell and nan are missing heights."""
    is_utf16 = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    text = content.decode("utf-16" if is_utf16 else "utf-8-sig", errors="replace")
    if re.search(r'"-?\d+,\d+"', text):
        raise InputError("numbers in quotes have commas; write decimals with points")
    text = text.replace("−", "-").replace('"', "").rstrip("\n")
    numbered = enumerate((line.strip(" ") for line in text.splitlines()), start=1)
    numbered_rows = [
        *itertools.dropwhile(lambda row: not row[1] or row[1].startswith("#"), numbered)
    ]
    rows = [row for _, row in numbered_rows]
    delimiter = next((mark for mark in "\t;," if rows and mark in rows[0]), None)
    if delimiter and all(row.endswith(delimiter) for row in rows):
        rows = [row[:-1] for row in rows]
    counts = [*dict.fromkeys(len(row.split(delimiter)) for row in rows)]
    if len(counts) != 1:
        lengths = (len(row.split(delimiter)) for row in rows)
        pairs = zip(numbered_rows, lengths, strict=True)
        unequal = (row[0] for row, length in pairs if length != counts[0])
        raise InputError(
            f"its rows have {', '.join(map(str, counts[:4])) or 'no'} numbers; give one matrix, "
            f"without headings and empty lines (line {next(unequal, 1)} is the first that differs)"
        )
    if delimiter == "," and (zeros := _SPLIT_DECIMAL.search("\n".join(rows))):
        raise InputError(
            f"commas separate both numbers and decimals ({quoted(zeros[1])} is no whole "
            "number); write decimals with points"
        )
    if delimiter != "," and (number := _maybe_thousands(rows, delimiter)):
        raise InputError(
            f"{quoted(number)} may be a thousand times as much; write the heights without marks of "
            "thousands, and with four decimals"
        )
    if delimiter:  # loadtxt reads no empty cell
        cells = ([cell.strip() or "nan" for cell in row.split(delimiter)] for row in rows)
        rows = [*map(delimiter.join, cells)]
    try:
        matrix = np.loadtxt(rows, delimiter=delimiter, ndmin=2, comments=None)
    except ValueError as error:
        words = (
            (line, cell)
            for line, row in numbered_rows
            for cell in row.split(delimiter)
            if not _is_number(cell)
        )
        line, word = next(words, (1, ""))
        raise InputError(
            f"not a matrix of numbers: line {line} has {quoted(word.strip())}; write nan for a "
            "missing height, and decimals with points"
        ) from error
    if np.isnan(matrix).all(axis=0).any():
        raise InputError("a column is empty, as between two tables; keep one table")
    return matrix


def _is_number(cell: str) -> bool:
    with suppress(ValueError):
        return not cell.strip() or isinstance(float(cell), float)
    return False


def _maybe_thousands(rows: list[str], delimiter: str | None) -> str:
    """A number with a point that may divide thousands, if all with points are; else empty."""
    number = ""
    for cell in (cell.strip() for row in rows for cell in row.split(delimiter)):
        if "." in cell:
            number = cell
            if not MAYBE_THOUSANDS.fullmatch(cell):
                return ""
    return number


def _require_map(matrix: Array) -> Array:
    """Return the matrix; `InputError` for a profile, a list of points, a table, or axes."""
    max_count = 2**24  # 4096 × 4096; the form of more takes gigabytes
    if math.prod(matrix.shape) > max_count:
        size = " × ".join(map(str, matrix.shape))
        raise InputError(f"{size} heights are too many; cut out {max_count} at most")
    if min(matrix.shape) < _MIN_SIDE:
        raise InputError(
            f"{matrix.shape[1]} × {matrix.shape[0]} numbers are no map of heights, but maybe a "
            "profile, or a list of points; give a matrix, a row for each y"
        )
    edges = {
        "first row": matrix[0], "first column": matrix[:, 0],
        "last row": matrix[-1], "last column": matrix[:, -1],
    }  # fmt: skip
    inner = matrix[1:-1, 1:-1]
    height_range = float(np.ptp(inner[np.isfinite(inner)])) if np.isfinite(inner).any() else np.inf
    for name, values in edges.items():
        if _is_axis(values[1:-1], height_range):  # corners may be of another axis
            verb = "rises" if values[-2] > values[1] else "falls"
            raise InputError(
                f"the {name} {verb} evenly, from {values[1]:g} to {values[-2]:g}: no heights, but "
                "an axis or numbers of rows; leave it out"
            )
    return matrix


def _is_axis(values: Array, height_range: float) -> bool:
    """True for values that rise or fall evenly, within half of their last printed digit.

    Measured positions are less even; they exceed the range of the heights.
    """
    steps = np.diff(values)
    if not np.isfinite(values).all() or not ((steps > 0).all() or (steps < 0).all()):
        return False
    if abs(values[-1] - values[0]) > _FARTHER * height_range:
        return True
    decimals = next((d for d in range(-3, 9) if np.allclose(values, values.round(d), 0, 1e-12)), 9)
    line = np.polyval(np.polyfit(np.arange(values.size), values, 1), np.arange(values.size))
    half_digit = 0.55 * 10.0**-decimals if decimals < 9 else 0.0
    return bool(
        (np.abs(values - line) <= half_digit).all() or np.allclose(steps, steps[0], 0.02, 0)
    )
