"""Read heights from text files of Gwyddion, MountainsMap, Keyence, Zygo, NumPy and spreadsheets.

The text is a matrix or rows of x, y and z, with any common separator, decimal mark and mark
of missing heights.
"""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np

from pipeline.laboratory.instruments import RawScan
from pipeline.paths import decoded, read_file
from pipeline.scene.lines import find_separator, split_lines
from pipeline.scene.units import UnitError, to_si
from tribo import InputError
from tribo.types import Array

TEXT = (".csv", ".txt", ".xyz", ".asc", ".dat", ".tsv")
_HOLES = {"", "nan", "bad", "***", "---", "-", "--", "null", "none", "missing", "n/a", "nodata"}
_NO_DATA = re.compile(r"\bno[ _]?data\b", re.IGNORECASE)
_COMMENT = ("#", "%", "//", ";#", "*")
_BOTH = (
    r"pixel[ _-]?(?:size|spacing|width|pitch)?s?|xy[ -](?:calibration|kalibrierung)"
    r"|lateral resolution|resolution|pitch|spacing|pixelgröße"
)
_EACH = r"(?:spacing|step|pixel size|schrittweite|pas|d)[ _-]?{0}|{0}[ -](?:spacing|step|pixel)"
_SIZES = {
    name: re.compile(rf"\W*(?:{words})\s*(?:\[([^\]]*)\]\s*)?[:=;,\s]\s*(\S.*)", re.IGNORECASE)
    for name, words in {
        "width": r"width|breite|taille[ _]x|x[ -](?:axis[ -])?(?:size|length|range)",
        "height": r"height|höhe|taille[ _]y|y[ -](?:axis[ -])?(?:size|length|range)",
        "x step": _EACH.format("x"),
        "y step": _EACH.format("y"),
        "xy step": _BOTH,
        "unit": r"(?:value )?units?|z[ -](?:axis[ -])?units?|unité[ _]z|einheit(?:[ _]z)?|"
        r"(?:heights?|z) in",
    }.items()
}
"""Patterns of header lines that give a size, or the unit of heights."""
_SENTINEL = re.compile(r"no[ _]?data(?:[ _]value)?[\s:=]+(-?\d+\.?\d*(?:e[+-]?\d+)?)", re.I)
_HEAD = re.compile(r"\b([xyz])\b\s*[\[(/]\s*([^\])/\s;,\t]+)", re.IGNORECASE)
_AFTER_COMMA = re.compile(r",0\d")  # must be decimals: no whole number begins with 0
_LEAST_PLACES = 9  # rows from which a table of three columns is taken for x, y and z
_MOST_PROFILES, _LONGER = 12, 20  # columns of profiles, and rows over columns
_SAMPLE = 30  # lines used to find the separator
_TOLERANCE = 1e-3  # largest relative deviation of places from a regular grid


def read_text(path: Path) -> RawScan:
    """Read heights from text: a matrix with a line for each y, rows of x, y and z, or a profile.

    Raises an `InputError` if the text has no matrix of numbers, x and y are not on a regular grid,
    or there are several tables.
    """
    text, _ = decoded(read_file(path))
    try:
        head, table, above, blocks = _split([_NO_DATA.sub("nan", x) for x in text.splitlines()])
    except (InputError, csv.Error) as error:  # as by a field of 200 000 letters
        raise InputError(f"{path}: {error}") from error
    if hole := _SENTINEL.search("\n".join(head)):
        table[table == float(hole[1])] = np.nan
    sizes, units = _header_sizes(head)
    unit = sizes.get("unit", units.get("z"))
    is_long = table.shape[0] >= _LEAST_PLACES or path.suffix.lower() == ".xyz"
    if table.shape[1] == 3 and is_long and not (_are_profiles(table) and np.ptp(table[:, 1])):
        return _grid_heights(path, table, units, unit)
    if blocks > 1:
        raise InputError(f"{path}: {blocks} tables, separated by blank lines; give a file for each")
    if table.shape[1] == 1:
        return RawScan(table, unit=unit, places=np.arange(len(table), dtype=float))
    if _are_profiles(table):
        return RawScan(table[:, 1:], unit=unit, places=table[:, 0], place_unit=units.get("x"))
    is_sized = {"width", "height"} <= sizes.keys()
    table, steps = (table, None) if is_sized else _strip_axes(table, above)
    heights = np.ascontiguousarray(table.T)
    length, pixel = units.get("x", units.get("y")), None
    if is_sized:
        pixel = sizes["width"] / heights.shape[0], sizes["height"] / heights.shape[1]
    elif steps and length:
        pixel = steps[0] * length, steps[1] * length
    elif {"x step", "y step"} <= sizes.keys():
        pixel = sizes["x step"], sizes["y step"]
    return RawScan(heights, pixel, unit, steps)


def _are_profiles(table: Array) -> bool:
    """True for places along a line and the heights there, of a few profiles at most."""
    count, columns = table.shape
    steps = np.diff(table[:, 0])
    is_line = bool((steps > 0).all() or (steps < 0).all())
    return columns == 2 or (is_line and columns <= _MOST_PROFILES and count > _LONGER * columns)


def _step(line: Array) -> float:
    """Step between the coordinates in `line`; NaN if they are uneven, or fewer than four."""
    steps = np.diff(line)
    if len(steps) < 3 or not np.allclose(steps, steps[0], rtol=_TOLERANCE) or not steps[0]:
        return math.nan
    return float(abs(steps[0]))


def _strip_axes(table: Array, above: Array) -> tuple[Array, tuple[float, float] | None]:
    """Remove a column of y and a row of x (or line `above`); return heights, steps of x and y."""
    if min(table.shape) < 5:
        return table, None
    for first in (1, 0):
        down = _step(table[first:, 0])
        across = _step(table[0, 1:]) if first else _step(above)
        is_axis = math.isfinite(down) and not math.isfinite(_step(table[first:, 1]))
        if is_axis and (math.isfinite(across) or not first):
            steps = (across, down) if math.isfinite(across) else None
            return np.ascontiguousarray(table[first:, 1:]), steps
    return table, None


def _split(lines: list[str]) -> tuple[list[str], Array, Array, int]:
    """Split a text: header, table with NaN for gaps, x coordinates above it, count of tables."""
    filled = [line for line in lines if line.strip()]
    mark = find_separator(filled[len(filled) // 2 :][:_SAMPLE])
    rows = {row.number: [*map(_number, row.cells)] for row in split_lines(lines, mark)}
    sound = {k: row for k, row in rows.items() if None not in row and any(x == x for x in row)}
    if not sound:
        raise InputError("no line of numbers; give heights as text, a row in a line")
    widths = [len(row) for row in sound.values()]
    usual = max(widths, key=widths.count)
    first = next(k for k, row in sound.items() if len(row) == usual)
    while rows.get(first - 1) and len(rows[first - 1]) == usual and None not in rows[first - 1]:
        first -= 1  # a row that has only holes
    above = rows.get(first - 1, [])
    places = np.array(above[1:] if len(above) == usual else [], float)
    if not math.isfinite(_step(places)) and len(above) == usual > above.count(None) + 1:
        first -= 1  # it is a row of the table in which a word stands
    if mark == "," and any(_AFTER_COMMA.search(line) for line in lines[first - 1 :]):
        raise InputError(
            "commas stand between cells and before decimals; put semicolons between cells, or "
            "write decimals with points"
        )
    words, table, ends = lines[: first - 1], list[list[float]](), list[int]()
    for number, line in enumerate(lines[first - 1 :], first):
        row = rows.get(number, [])
        if not line.strip() or 2 * row.count(None) > len(row) or _is_comment(line, row):
            words.append(line)
            ends.append(len(table))
            continue
        if None in row:
            word = next(split_lines([line], mark)).cells[row.index(None)]
            raise InputError(
                f'"{word}" is not a number; write holes as NaN, and decimals all with the same mark'
            )
        # A row may end with holes, if all their separators are there.
        has_all = not mark.isspace() and line.count(mark) >= usual - 1
        if len(row) != usual and not (len(row) < usual and has_all):
            raise InputError(
                f'{len(row)} numbers in the row "{line.strip()[:40]}", but {usual} in others; all '
                "rows must be of equal length"
            )
        table.append([*(x for x in row if x is not None), *[math.nan] * (usual - len(row))])
    inner = sorted({end for end in ends if 0 < end < len(table)})
    if any(line.strip() for line in words[first - 1 :]) and inner:
        raise InputError("a second table stands in the file; give a file for each")
    blocks = len(inner) + 1 if inner and max(np.diff([0, *inner, len(table)])) > 1 else 1
    array = np.array(table, float)
    return words, array[:, ~np.isnan(array).all(axis=0)], places, blocks


def _is_comment(line: str, row: list[float | None]) -> bool:
    """True if a line begins with a comment sign, and has a word or fewer than two cells."""
    return line.lstrip().startswith(_COMMENT) and (None in row or len(row) < 2)


def _number(cell: str) -> float | None:
    """Read the number in a cell; NaN for a missing height such as "bad", None for another text."""
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return math.nan if cell.strip().lower() in _HOLES else None


def _header_sizes(head: list[str]) -> tuple[dict[str, float], dict[str, float]]:
    """Read lengths [m] from header lines: sizes by name, and units of columns x, y and z."""
    sizes: dict[str, float] = {}
    units: dict[str, float] = {}
    for line in head:
        for part in re.split(r"[,;](?=\s)", re.sub(r'"[,;\t]"', ";", line).replace('"', "")):
            for name, size in _SIZES.items():
                if match := size.fullmatch(part.strip()):
                    text = match[2].replace(",", ".").replace(";", " ")
                    text = f"{text} {match[1]}" if match[1] else text
                    if (length := _length(f"1 {text}" if name == "unit" else text)) is not None:
                        axes = ("x step", "y step") if name == "xy step" else (name,)
                        sizes |= {axis: sizes.get(axis, length) for axis in axes}
        below = zip("xyz", re.split(r"[\s;,]+", line.strip()), strict=False)
        for axis, unit in _HEAD.findall(line) or below:
            if (length := _length(f"1 {unit}")) is not None:
                units[axis.lower()] = length
    return sizes, units


def _length(text: str) -> float | None:
    try:
        return to_si(text, "1 um")
    except UnitError:
        return None


def _grid_heights(path: Path, table: Array, units: dict[str, float], unit: float | None) -> RawScan:
    """Heights (nx, ny), NaN for missing rows, from rows of x, y, z on a regular grid."""
    axes, places = [], []
    for axis, column in enumerate(table.T[:2]):
        values = np.unique(column[np.isfinite(column)])
        apart = np.diff(values)
        if not apart.size:
            other, length = 1 - axis, units.get("xy"[1 - axis])
            return RawScan(table[:, 2:], unit=unit, places=table[:, other], place_unit=length)
        step = float(np.median(apart[apart > _TOLERANCE * apart.max()]))
        place = (column - values[0]) / step
        if np.nanmax(np.abs(place - np.round(place))) > 100 * _TOLERANCE:
            raise InputError(f"{path}: x and y are not on a regular grid; give one, or a matrix")
        axes.append(step)
        places.append(np.round(place).astype(int))
    shape = tuple(int(place.max()) + 1 for place in places)
    if np.prod(shape) > 16 * len(table):
        raise InputError(f"{path}: x and y are not on a regular grid; give one, or a matrix")
    if len({*zip(*(place.tolist() for place in places), strict=True)}) < len(table):
        raise InputError(f"{path}: two heights at one place; give each scan in a file of its own")
    heights = np.full(shape, np.nan)
    heights[places[0], places[1]] = table[:, 2]
    steps = axes[0], axes[1]
    pixel = None
    if {"x", "y"} <= units.keys():
        pixel = axes[0] * units["x"], axes[1] * units["y"]
    return RawScan(heights, pixel, unit, steps)
