"""Read scans: matrices of heights, and files of instruments.

Nothing is guessed: units are in the file or are arguments, and a file that is no map of heights,
such as a profile or a list of points, is refused.
"""

from __future__ import annotations

import io
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.messages import quoted
from pipeline.paths import is_binary, read_file, reason_of, user_path
from pipeline.quantities import display_sides
from pipeline.surface.instrument_file import (
    EXPORT,
    MIN_SIDE,
    POINTS,
    PROFILE,
    HeightFile,
    read_instrument_file,
    require_size,
)
from pipeline.surface.text_matrix import delimiter_of, matrix_of, numbers_of
from tribo import InputError
from tribo.types import Array

_LENGTH_TOLERANCE = 0.01  # relative difference below which two lengths agree


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
    """Heights with marks such as −9999 and infinity as NaN; and notes on these."""
    notes, is_huge = list[str](), np.abs(heights) > 1e30
    if is_huge.any():
        notes.append(f"{is_huge.sum()} heights beyond 1e+30 are treated as missing")
        heights = np.where(is_huge, np.nan, heights)
    while marks := _marks_in(np.unique(heights[np.isfinite(heights)])):
        for mark in marks:
            notes.append(f"{(heights == mark).sum()} heights of {mark:.6g} are treated as missing")
            heights[heights == mark] = np.nan
    values, counts = np.unique(heights[np.isfinite(heights)], return_counts=True)
    second_count, max_count = np.sort(np.append(counts, [0, 0]))[-2:].tolist()
    if max_count > max(0.01 * heights.size, 10 * second_count):
        value = values[counts.argmax()]
        notes.append(f"{max_count} heights are exactly {value:.6g}: write nan if these are missing")
    return heights, notes


def _marks_in(values: Array) -> list[float]:
    """The lowest or highest of ascending values, if far from all others: marks of no height."""
    if values.size < 4:
        return []
    min_gap = 4 * (values[-2] - values[1])
    gaps = {values[0]: values[1] - values[0], values[-1]: values[-1] - values[-2]}
    return [value for value, gap in gaps.items() if gap > min_gap]


def _read(path: Path, content: bytes) -> HeightFile:
    """Read a file in the format that its content has."""
    if content.startswith(b"\x93NUMPY"):
        return HeightFile(_require_map(_array(content)).T)
    if content.startswith(b"PK"):
        if b"xl/workbook" in content:
            raise InputError("a workbook; save its sheet of heights as .csv")
        if b".npy" in content:
            raise InputError("an archive of arrays; save one of them as .npy")
        return read_instrument_file(path, "")
    if is_binary(content):
        return read_instrument_file(path, "binary")
    is_utf16 = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    text = content.decode("utf-16" if is_utf16 else "utf-8-sig", errors="replace")
    text = text.replace("−", "-")
    first = next((line for line in text.splitlines() if line.strip()), "").strip(" ")
    if first and numbers_of([first], delimiter_of(first)) is None:  # headings, which may have sizes
        with suppress(InputError):
            if (file := read_instrument_file(path, "a text")).unit:
                return file
    headings, matrix = matrix_of(text)
    if matrix is None:
        raise InputError(f"a text without a matrix of numbers; {EXPORT}")
    if headings and min(matrix.shape) >= MIN_SIDE:
        raise InputError(
            f"its first lines are not heights ({quoted(headings[0][:60])}); delete what is above "
            "the numbers, and give height_unit and pixel_size"
        )
    notes = list[str]()
    if comments := [line for line in text.splitlines() if line.lstrip()[:1] == "#"]:
        notes.append(f"comments of the file are not used: {quoted(' '.join(comments)[:80])}")
    return HeightFile(_require_map(matrix).T, notes=tuple(notes))


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
    require_size(array.shape)
    return np.atleast_2d(array).astype(float)


def _require_map(matrix: Array) -> Array:
    """Return the matrix; `InputError` for a profile, a list of points, a table, or axes."""
    require_size(matrix.shape)
    short_side, long_side = sorted(matrix.shape)
    if short_side < MIN_SIDE:
        columns = matrix if matrix.shape[1] == long_side else matrix.T
        have_repeats = [np.unique(column).size < long_side / 2 for column in columns[:2]]
        content = (
            f"a table of {short_side} columns, such as profiles; give a map, or Ra and RSm of a "
            "profile by --ra and --rsm"
        )
        if short_side < 3:
            content = PROFILE
        elif short_side < 5 and all(have_repeats):
            content = POINTS
        raise InputError(f"{short_side} × {long_side} numbers are {content}, not a map of heights")
    for name, values in (("row", matrix[0]), ("column", matrix[:, 0])):
        steps = np.diff(values[1:])
        if steps[0] and np.allclose(steps, steps[0], rtol=0.02, atol=0):
            raise InputError(
                f"the first {name} rises evenly, from {values[1]:g} to {values[-1]:g}: no heights, "
                "but an axis or numbers of rows; leave it out"
            )
    return matrix
