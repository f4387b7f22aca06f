"""Read scans: matrices of heights, and files of instruments by the library SurfaceTopography.

Nothing is guessed: units are in the file or are arguments, and a file that is no map of heights,
such as a profile or a list of points, is refused.
"""

from __future__ import annotations

import io
import itertools
import math
import re
import warnings
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.messages import quoted
from pipeline.paths import kind_of, read_file, reason_of, user_path
from pipeline.quantities import display_sides
from pipeline.units import GROUPED
from tribo import InputError
from tribo.types import Array

_PROFILE = (
    "a profile; the Ra and RSm that its instrument prints are enough: irg surface --ra RA --rsm RSM"
)
_GIVE_MAP = "give a map, or Ra and RSm of a profile by --ra and --rsm"
_POINTS = "a list of points x, y, z; make it a matrix, a row for each y"
_SAVE = "export the heights as .npy or as a matrix in text, without headings"
_LIBRARY = "pip install SurfaceTopography"
_MAX_BYTES = 2**28
_MAX_HEIGHTS = 2**24  # 4096 × 4096; the form of more takes gigabytes
_MAX_HEADINGS = 200  # lines of headings above the numbers of a text
_MIN_SIDE = 9  # heights along a side of a map; less are columns of a table
_EVEN = 0.02  # relative difference of steps, below which numbers rise evenly
_EQUAL_LENGTHS = 0.01  # relative difference below which two lengths agree
_MAX_HEIGHT = 1.0  # height [m] from which the unit must be wrong
_MISSING_ABOVE = 1e30  # numbers above it, and infinity, are marks of missing heights
_MARK_GAP = 4.0  # distance of a mark of missing heights from all heights, over their range
_FILLER = 0.01, 10.0  # least share of heights of one value, and ratio to the count of the next
_WORDS = re.compile(
    r"(?<![\w.+-])(-?1\.#\w+|-{2,}|\*+|n/?a|no ?data|bad|void)(?![\w.])", re.IGNORECASE
)
"""Words for a missing height other than "nan" and an empty cell."""
_COMMA = re.compile(r"[-+]?\d+(,\d+)+(e[-+]?\d+)?", re.IGNORECASE)
"""A number with a comma, before decimals or thousands."""
_INTEGER = re.compile(r"[-+]?[1-9]\d*")
_HALF = re.compile(r"(?:^|,) *(-0|0\d+) *(?=,|$)", re.MULTILINE)
"""Half of a number that was split at a decimal comma: whole numbers have no leading zeros."""


@dataclass(frozen=True, slots=True)
class Scan:
    """Measured heights [m], shape (nx, ny), NaN where one is missing; sides of a pixel [m]."""

    heights: Array
    pixel_size: tuple[float, float]
    notes: tuple[str, ...] = ()  # on holes, and on arguments that override the file

    @property
    def missing(self) -> int:
        """Number of heights that the instrument did not measure."""
        return int(np.isnan(self.heights).sum())

    @property
    def missing_words(self) -> str:
        """Number and share of missing heights in words."""
        share = 100 * self.missing / self.heights.size
        return f"{self.missing} of {self.heights.size} heights ({share:.2g} %) are missing"


class _File(NamedTuple):
    """Heights in a file's unit, shape (nx, ny); unit and sides [m] are None if it has none."""

    heights: Array
    unit: float | None = None
    pixel_size: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()


def read_scan(
    path: str | Path,
    height_unit: float | None = None,
    pixel_size: tuple[float, float] | None = None,
) -> Scan:
    """Read a map of heights, in which x goes from column to column.

    Parameters
    ----------
    path : str or Path
        Plain array (.npy), matrix in text, or the file of an instrument.
    height_unit : float, optional
        Unit of the heights [m]; it replaces that of the file.
    pixel_size : tuple of float, optional
        Sides of a pixel along x and y [m]; they replace those of the file.

    Raises
    ------
    InputError
        If the file is no map, cannot be read, or lacks a unit or sizes that are not given.
    """
    path = user_path(path)
    try:
        content = read_file(path, _MAX_BYTES)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    try:
        return _scan(_read(path, content), height_unit, pixel_size)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _scan(file: _File, height_unit: float | None, pixel_size: tuple[float, float] | None) -> Scan:
    notes = ["x, the sliding direction, goes from column to column", *file.notes]
    unit, file_sides = height_unit or file.unit, file.pixel_size
    sides = pixel_size or file_sides
    missing = ["the unit of its heights (height_unit)"] * (not unit)
    missing += ["the sides of a pixel (pixel_size)"] * (not sides)
    if not unit or not sides:
        raise InputError(f"the file does not have {' and '.join(missing)}; add what is missing")
    if file.unit and abs(unit / file.unit - 1) > _EQUAL_LENGTHS:
        notes.append(f"the given height unit, {unit:g} m, replaces the file's, {file.unit:g} m")
    if file_sides and not np.allclose(file_sides, sides, rtol=_EQUAL_LENGTHS, atol=0):
        notes.append(f"the given pixels replace the file's {display_sides(file_sides)}")
    heights, mark_notes = _without_marks(file.heights.astype(float))
    heights *= unit
    highest = np.abs(heights[np.isfinite(heights)]).max(initial=0.0)
    if highest > _MAX_HEIGHT:
        raise InputError(f"heights of {highest:.3g} m; give the right unit, height_unit")
    return Scan(np.ascontiguousarray(heights), (sides[0], sides[1]), (*notes, *mark_notes))


def _without_marks(heights: Array) -> tuple[Array, list[str]]:
    """Heights with marks such as −9999 and infinity as NaN; and notes on these."""
    notes, is_huge = list[str](), np.abs(heights) > _MISSING_ABOVE
    if is_huge.any():
        notes.append(f"{is_huge.sum()} heights beyond {_MISSING_ABOVE:g} are taken for missing")
        heights = np.where(is_huge, np.nan, heights)
    while True:
        values = np.unique(heights[np.isfinite(heights)])
        if values.size < 4:
            break
        min_gap = _MARK_GAP * (values[-2] - values[1])
        gaps = {values[0]: values[1] - values[0], values[-1]: values[-1] - values[-2]}
        marks = [value for value, gap in gaps.items() if gap > min_gap]
        for mark in marks:
            notes.append(f"{(heights == mark).sum()} heights of {mark:.6g} are taken for missing")
            heights[heights == mark] = np.nan
        if not marks:
            break
    values, counts = np.unique(heights[np.isfinite(heights)], return_counts=True)
    second, max_count = np.sort(np.append(counts, [0, 0]))[-2:].tolist()
    if max_count > max(_FILLER[0] * heights.size, _FILLER[1] * second):
        value = values[counts.argmax()]
        notes.append(f"{max_count} heights are exactly {value:.6g}: write nan if these are missing")
    return heights, notes


def _read(path: Path, content: bytes) -> _File:
    """Read a file in the format that its content has."""
    if content.startswith(b"\x93NUMPY"):
        return _File(_require_map(_array(content)).T)
    if content.startswith(b"PK"):
        if b"xl/workbook" in content:
            raise InputError("a workbook; save its sheet of heights as .csv")
        if b".npy" in content:
            raise InputError("an archive of arrays; save one of them as .npy")
        return _instrument(path, "")
    if kind := kind_of(content):
        return _instrument(path, kind)
    is_utf16 = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    text = content.decode("utf-16" if is_utf16 else "utf-8-sig", errors="replace")
    first = next((line for line in text.splitlines() if line.strip()), "").strip(" ")
    if first and _numbers([first], _delimiter(first)) is None:  # a head, which may have sizes
        with suppress(InputError):
            if (file := _instrument(path, "a text")).unit:
                return file
    head, matrix = _matrix(text)
    if matrix is None:
        raise InputError(f"a text without a matrix of numbers; {_SAVE}")
    if head and min(matrix.shape) >= _MIN_SIDE:
        raise InputError(
            f"its first lines are no heights ({quoted(head[0][:60])}); delete all {len(head)} "
            "lines above the numbers, and give height_unit and pixel_size"
        )
    remarks = [line for line in text.splitlines() if line.lstrip()[:1] == "#"]
    comment_note = (f"comments of the file are not used: {quoted(' '.join(remarks)[:80])}",)
    return _File(_require_map(matrix).T, notes=comment_note[: len(remarks)])


def _array(content: bytes) -> Array:
    try:
        array = np.load(io.BytesIO(content), allow_pickle=False)
    except Exception as error:  # of a damaged file, errors of many kinds
        raise InputError(f"not a plain array of numbers: {error}") from error
    if array.ndim not in (1, 2) or array.size == 0 or array.dtype.kind not in "fiu":
        raise InputError(
            f"an array of shape {array.shape} and type {array.dtype}; needed are two-dimensional "
            "real numbers, a row for each y"
        )
    if array.size > _MAX_HEIGHTS:
        raise InputError(_too_many(array.shape))
    return np.atleast_2d(array).astype(float)


def _matrix(text: str) -> tuple[list[str], Array | None]:
    """Headings above the numbers of a text, and the matrix, a row for each y; None without one."""
    rows = text.splitlines()
    numbered = [(k, row.strip(" ")) for k, row in enumerate(rows, 1) if row.strip()]
    numbered = [(k, row) for k, row in numbered if row.lstrip()[0] != "#"]
    lines, head = [row for _, row in numbered], 0
    for line in lines[:_MAX_HEADINGS]:
        delimiter = _delimiter(line)
        if _numbers([line], delimiter) is not None:
            break
        cells = line.split(delimiter if delimiter != "," else None)
        if len(cells) > 1 and all(map(_COMMA.fullmatch, map(str.strip, cells))):
            raise InputError(_comma_problem(cells))
        head += 1
    else:
        return lines, None
    _require_single_table([k for k, _ in numbered[head:]])
    _require_decimals(lines[head:], delimiter)
    if delimiter == "," and (half := _HALF.search("\n".join(lines[head:]))):
        raise InputError(
            f"commas stand between numbers and before decimals ({quoted(half[1])} is no whole "
            "number); write decimals with points"
        )
    try:
        return lines[:head], _numbers(lines[head:], delimiter, strict=True)
    except InputError:
        raise
    except ValueError as error:
        why = str(error).partition(";")[0].partition(", please")[0]
        raise InputError(
            f"not a matrix of numbers, as many in each row: {why}; write nan for a missing "
            "height, and decimals with a point"
        ) from error


def _comma_problem(cells: list[str]) -> str:
    """Why numbers with commas are refused, and how to write them."""
    if all(map(GROUPED.fullmatch, map(str.strip, cells))):
        return _thousands_problem(cells[0].strip())
    return f"decimals have commas ({quoted(cells[0])}); write them with points"


def _thousands_problem(number: str) -> str:
    plain, decimals = number.replace(",", "").replace(".", ""), number.replace(",", ".")
    return (
        f"{quoted(number)} may be {plain} or {decimals}, a thousand times less; write the heights "
        "without marks of thousands, and decimals with points"
    )


def _require_single_table(numbers: list[int]) -> None:
    """Raise an `InputError` if the rows of numbers, by their lines, are parted by other lines."""
    starts = [k for k, (a, b) in enumerate(itertools.pairwise(numbers), 1) if b > a + 1]
    if starts and len(starts) < len(numbers) - 1:  # else a line is empty below each row
        sizes = [b - a for a, b in itertools.pairwise([0, *starts, len(numbers)])]
        raise InputError(
            f"{len(sizes)} tables of {', '.join(map(str, sizes[:4]))} rows, the second from line "
            f"{numbers[starts[0]]} on; keep one of them"
        )


def _require_decimals(lines: list[str], delimiter: str | None) -> None:
    """Raise an `InputError` if points may divide thousands, as in 23.173 beside 476."""
    marked, has_integer = "", False
    for cell in (cell.strip() for line in lines for cell in line.split(delimiter)):
        if "." in cell:
            if delimiter == "," or not GROUPED.fullmatch(cell):
                return
            marked = marked or cell
        has_integer |= _INTEGER.fullmatch(cell) is not None
    if marked and has_integer:
        raise InputError(_thousands_problem(marked))


def _delimiter(line: str) -> str | None:
    """Delimiter of the numbers of a line; None for spaces."""
    return next((delimiter for delimiter in "\t;," if delimiter in line), None)


def _numbers(lines: list[str], delimiter: str | None, strict: bool = False) -> Array | None:
    """Numbers of lines; None if there are other words, or a `ValueError` if `strict`."""
    if delimiter:
        while lines[0].endswith(delimiter) and all(line.endswith(delimiter) for line in lines):
            lines = [line[:-1] for line in lines]
        first = [k for k, cell in enumerate(lines[0].split(delimiter)) if not cell.strip()]
        for k in first if strict else []:
            if not any("".join(line.split(delimiter)[k : k + 1]).strip() for line in lines):
                raise InputError(f"column {k + 1} is empty, as between two tables; keep one table")
        empty = re.compile(rf"(?:^|(?<={delimiter})) *(?={delimiter}|$)")
        lines = [empty.sub("nan", line) for line in lines]
    lines = [_WORDS.sub("nan", line) for line in lines]
    try:
        return np.loadtxt(lines, delimiter=delimiter, ndmin=2, comments=None)
    except ValueError:
        if strict:
            raise
        return None


def _require_map(matrix: Array) -> Array:
    """Return the matrix; `InputError` for a profile, a list of points, a table, or axes."""
    if matrix.size > _MAX_HEIGHTS:
        raise InputError(_too_many(matrix.shape))
    few, many = sorted(matrix.shape)
    if few < _MIN_SIDE:
        columns = matrix if matrix.shape[1] == many else matrix.T
        repeated = [np.unique(column).size < many / 2 for column in columns[:2]]
        kind = f"a table of {few} columns, such as profiles; {_GIVE_MAP}"
        if few < 3:
            kind = _PROFILE
        elif few < 5 and all(repeated):
            kind = _POINTS
        raise InputError(f"{few} × {many} numbers are no map of heights, but {kind}")
    for name, line in (("row", matrix[0]), ("column", matrix[:, 0])):
        steps = np.diff(line[1:])
        if steps[0] and np.allclose(steps, steps[0], rtol=_EVEN, atol=0):
            raise InputError(
                f"the first {name} rises evenly, from {line[1]:g} to {line[-1]:g}: no heights, but "
                "an axis or numbers of rows; leave it out"
            )
    return matrix


def _instrument(path: Path, kind: str) -> _File:
    """Read a file in any format that SurfaceTopography knows."""
    kind = kind or path.suffix.lower() or "file"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings of the library do not concern the user
            from SurfaceTopography.IO import open_topography

            return _from_library(open_topography(str(path)))
    except ImportError as error:
        raise InputError(f"{kind}: get its reader by {_LIBRARY}, or {_SAVE}") from error
    except InputError:
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        why = _library_message(error, path.suffix.lower())
        raise InputError(f"{kind}: {why}; {_SAVE}") from error


def _library_message(error: Exception, suffix: str) -> str:
    text, name = str(error).strip(), type(error).__name__
    if name == "CannotDetectFileFormat":  # its text lists the errors of all readers
        reader_message = re.search(
            rf"tried {re.escape(suffix[1:])}reader:\s*(.*)", text, re.IGNORECASE
        )
        if not suffix or not reader_message:
            return "SurfaceTopography has no reader for it"
        text = reader_message[1]
    elif isinstance(error, LookupError) or not text:
        text = f"{name} {text}".strip()
    if re.fullmatch(r"'[^']*'", text):  # the key of a table
        text = f"{text} is missing"
    return f"SurfaceTopography cannot read it ({text.splitlines()[0].rstrip('.')})"


def _from_library(reader: Any) -> _File:
    channel = reader.default_channel
    if channel.physical_sizes is None:
        raise InputError(f"a file without the size of its pixels; {_SAVE}")
    if math.prod(channel.nb_grid_pts) > _MAX_HEIGHTS:
        raise InputError(_too_many(channel.nb_grid_pts))
    topography = reader.topography()
    if topography.dim != 2:
        raise InputError(f"no map of heights, but {_PROFILE}")
    if type(reader).__name__ == "XYZReader" or not topography.is_uniform:
        raise InputError(f"no map of heights, but {_POINTS}")
    if type(reader).__name__ == "TMDReader":
        raise InputError(f"readers of .tmd differ by a factor of 1000 in its heights; {_SAVE}")
    heights: Any = np.ma.masked_invalid(np.ma.array(topography.heights(), dtype=float))
    heights = np.ma.filled(heights, np.nan)
    if min(heights.shape) < _MIN_SIDE:
        size = " × ".join(map(str, heights.shape))
        raise InputError(f"{size} heights are too few; give {_MIN_SIDE} along each side")
    names = [other_channel.name for other_channel in reader.channels]
    channel_note = (f"{channel.name} is read, of the channels {', '.join(names)}",)
    notes = channel_note[: len(names) - 1]
    if topography.unit is None:
        return _File(heights, notes=notes)
    sides = [float(side) for side in topography.to_unit("m").pixel_size]
    unit = sides[0] / float(topography.pixel_size[0])
    return _File(heights, unit, (sides[0], sides[1]), notes)


def _too_many(shape: Iterable[int]) -> str:
    size = " × ".join(map(str, shape))
    return f"{size} heights are too many; cut out {_MAX_HEIGHTS} at most"
