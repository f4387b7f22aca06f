"""Read scans: matrices of heights, and files of instruments.

Nothing is guessed: units are in the file or are arguments, and a file that is no map of heights,
such as a profile or a list of points, is refused.
"""

from __future__ import annotations

import io
import itertools
import math
import re
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.messages import quoted
from pipeline.paths import is_binary, read_file, reason_of, user_path
from pipeline.quantities import display_sides
from pipeline.units import MAYBE_THOUSANDS
from tribo import InputError
from tribo.types import Array

_LENGTH_TOLERANCE = 0.01  # relative difference below which two lengths agree
_MIN_SIDE = 9  # heights along a side of a map; less are columns of a table
_EXPORT = "export the heights as .npy or as a matrix in text, without headings"
_SPLIT_DECIMAL = re.compile(r"(?m)(?:^|,) *(-0|0\d+) *(?=,|$)")
"""Decimals that a decimal comma cut off: whole numbers have no leading zeros."""
_NO_MAP = (
    "no map of heights, but maybe a profile, or a list of points; give a matrix, a row for each y"
)


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


class HeightFile(NamedTuple):
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
        content = read_file(path, max_bytes=2**28)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error, path)}") from error
    try:
        return _scan(_read(path, content), height_unit, pixel_size)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _scan(
    file: HeightFile, height_unit: float | None, pixel_size: tuple[float, float] | None
) -> Scan:
    """Scan of the heights of a file, in m, with the unit and pixels of the user or of the file."""
    notes = ["x, the sliding direction, goes from column to column", *file.notes]
    unit, sides = height_unit or file.unit, pixel_size or file.pixel_size
    missing = [] if unit else ["the unit of its heights (height_unit)"]
    if not sides:
        missing.append("the sides of a pixel (pixel_size)")
    if not unit or not sides:
        raise InputError(f"the file does not have {' and '.join(missing)}; add what is missing")
    if file.unit and abs(unit / file.unit - 1) > _LENGTH_TOLERANCE:
        notes.append(f"the given height unit, {unit:g} m, replaces the file's, {file.unit:g} m")
    if file.pixel_size and not np.allclose(file.pixel_size, sides, _LENGTH_TOLERANCE, 0):
        notes.append(f"the given pixels replace the file's {display_sides(file.pixel_size)}")
    heights, mark_notes = _without_marks(file.heights.astype(float))
    heights *= unit
    highest = np.abs(heights[np.isfinite(heights)]).max(initial=0.0)
    if highest > 1.0:
        raise InputError(f"heights of {highest:.3g} m; give the right unit, height_unit")
    return Scan(np.ascontiguousarray(heights), (sides[0], sides[1]), (*notes, *mark_notes))


def _without_marks(heights: Array) -> tuple[Array, list[str]]:
    """Heights with marks of missing ones, such as −9999 or infinity, as NaN; and notes on these."""
    notes, heights = list[str](), np.where(np.isfinite(heights), heights, np.nan)
    while (values := np.unique(heights[np.isfinite(heights)])).size > 3:
        min_gap = 4 * (values[-2] - values[1])
        gaps = {values[0]: values[1] - values[0], values[-1]: values[-1] - values[-2]}
        mark = max(gaps, key=lambda value: gaps[value])
        if gaps[mark] <= min_gap:  # not far from all others
            break
        notes.append(f"{(heights == mark).sum()} heights of {mark:.6g} are treated as missing")
        heights[heights == mark] = np.nan
    values, counts = np.unique(heights[np.isfinite(heights)], return_counts=True)
    second_count, max_count = np.sort(np.append(counts, [0, 0]))[-2:].tolist()
    if max_count > max(0.01 * heights.size, 10 * second_count):
        value = values[counts.argmax()]
        notes.append(f"{max_count} heights are exactly {value:.6g}: write nan if these are missing")
    return heights, notes


def _read(path: Path, content: bytes) -> HeightFile:
    """Read a file in the format that its content has."""
    if content.startswith(b"\x93NUMPY"):
        return HeightFile(_require_map(_array(content)).T)
    if content.startswith(b"PK") or is_binary(content):
        return _read_instrument_file(path)
    is_utf16 = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    text = content.decode("utf-16" if is_utf16 else "utf-8-sig", errors="replace")
    lines = [line.strip(" ") for line in text.replace("−", "-").splitlines()]
    comments = [*itertools.takewhile(lambda line: not line or line.startswith("#"), lines)]
    rows = "\n".join(lines[len(comments) :]).rstrip("\n").splitlines()
    if any(comments) or not rows or rows[0][:1].isalpha():  # headings, which may have units
        with suppress(InputError):
            if (file := _read_instrument_file(path)).unit:
                return file
    notes = [f"comments of the file are not used: {quoted(' '.join(comments)[:80])}"]
    matrix = _require_map(_matrix(rows))
    return HeightFile(matrix.T, notes=tuple(notes) if any(comments) else ())


def _matrix(rows: list[str]) -> Array:
    """Numbers in rows of text, a row for each y; an empty cell and nan are missing heights."""
    delimiter = next((mark for mark in "\t;," if rows and mark in rows[0]), None)
    if delimiter and all(row.endswith(delimiter) for row in rows):
        rows = [row[:-1] for row in rows]
    counts = [*dict.fromkeys(len(row.split(delimiter)) for row in rows)]
    if len(counts) != 1:
        raise InputError(
            f"its rows have {', '.join(map(str, counts[:4])) or 'no'} numbers; give one matrix, "
            "without headings and empty lines"
        )
    zeros = _SPLIT_DECIMAL.search("\n".join(rows)) if delimiter == "," else None
    if zeros:
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
        raise InputError(
            f"not a matrix of numbers: {error}; write nan for a missing height, and decimals with "
            "points"
        ) from error
    if np.isnan(matrix).all(axis=0).any():
        raise InputError("a column is empty, as between two tables; keep one table")
    return matrix


def _maybe_thousands(rows: list[str], delimiter: str | None) -> str:
    """A number with a point that may divide thousands, if all with points are; else empty."""
    number = ""
    for cell in (cell.strip() for row in rows for cell in row.split(delimiter)):
        if "." in cell:
            number = cell
            if not MAYBE_THOUSANDS.fullmatch(cell):
                return ""
    return number


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
    return np.atleast_2d(array).astype(float)


def _require_map(matrix: Array) -> Array:
    """Return the matrix; `InputError` for a profile, a list of points, a table, or axes."""
    _require_size(matrix.shape)
    if min(matrix.shape) < _MIN_SIDE:
        raise InputError(f"{matrix.shape[1]} × {matrix.shape[0]} numbers are {_NO_MAP}")
    for name, values in (("row", matrix[0]), ("column", matrix[:, 0])):
        steps = np.diff(values[1:])
        if steps[0] and np.allclose(steps, steps[0], rtol=0.02, atol=0):
            raise InputError(
                f"the first {name} rises evenly, from {values[1]:g} to {values[-1]:g}: no heights, "
                "but an axis or numbers of rows; leave it out"
            )
    return matrix


def _require_size(shape: Sequence[int]) -> None:
    """Raise an `InputError` for more heights than can be processed."""
    max_count = 2**24  # 4096 × 4096; the form of more takes gigabytes
    if math.prod(shape) > max_count:
        size = " × ".join(map(str, shape))
        raise InputError(f"{size} heights are too many; cut out {max_count} at most")


def _read_instrument_file(path: Path) -> HeightFile:
    """Read a file in any format that the library SurfaceTopography knows."""
    kind = path.suffix.lower() or "file"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings of the library do not concern the user
            from SurfaceTopography.IO import open_topography

            return _default_channel(open_topography(str(path)))
    except ImportError as error:
        problem = f"{kind}: get its reader by pip install SurfaceTopography, or {_EXPORT}"
        raise InputError(problem) from error
    except InputError:
        raise
    except Exception as error:  # readers of damaged files raise errors of any kind
        reason = f"{type(error).__name__} {error}".splitlines()[0][:200]
        problem = f"{kind}: SurfaceTopography cannot read it ({reason}); {_EXPORT}"
        raise InputError(problem) from error


def _default_channel(reader: Any) -> HeightFile:
    """Heights of the default channel of a reader of SurfaceTopography."""
    channel, name = reader.default_channel, type(reader).__name__
    if channel.physical_sizes is None:
        raise InputError(f"a file without the size of its pixels; {_EXPORT}")
    _require_size(channel.nb_grid_pts)
    topography = reader.topography()
    if topography.dim != 2 or name == "XYZReader" or not topography.is_uniform:
        raise InputError(_NO_MAP)
    if name == "TMDReader":
        raise InputError(f"readers of .tmd differ by a factor of 1000 in its heights; {_EXPORT}")
    heights: Any = np.ma.filled(np.ma.array(topography.heights(), dtype=float), np.nan)
    if min(heights.shape) < _MIN_SIDE:
        raise InputError(_NO_MAP)
    notes: tuple[str, ...] = ()
    if len(reader.channels) > 1:
        names = ", ".join(file_channel.name for file_channel in reader.channels)
        notes = (f"{channel.name} is read, of the channels {names}",)
    if topography.unit is None:
        return HeightFile(heights, notes=notes)
    x, y = map(float, topography.to_unit("m").pixel_size)
    return HeightFile(heights, x / float(topography.pixel_size[0]), (x, y), notes)
