"""Heights in text, as Gwyddion, MountainsMap, Keyence, NumPy and spreadsheets write them.

A matrix, or rows of x, y and z, with any usual separator, decimal mark and sign of a hole.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from pipeline.laboratory.spreadsheet import decoded
from pipeline.scene.units import UnitError, to_si
from tribo import InputError
from tribo.types import Array

TEXT = (".csv", ".txt", ".xyz", ".asc", ".dat", ".tsv")
_HOLES = {"", "nan", "bad", "***", "---", "-", "null", "none", "missing"}
_COMMENT = ("#", "%", "//", ";#", "*")
_SIZES = {
    name: re.compile(rf"\W*(?:{words})\s*[:=;\s]\s*(\S.*)", re.IGNORECASE)
    for name, words in {
        "width": r"width|breite|taille[ _]x|x[ -](?:axis[ -])?(?:size|length)",
        "height": r"height|höhe|taille[ _]y|y[ -](?:axis[ -])?(?:size|length)",
        "x step": r"(?:spacing|step|pixel size|schrittweite|pas|d)[ _-]?x|x[ -](?:spacing|step)",
        "y step": r"(?:spacing|step|pixel size|schrittweite|pas|d)[ _-]?y|y[ -](?:spacing|step)",
        "xy step": r"xy[- ](?:calibration|kalibrierung)",
        "unit": r"(?:value )?units?|z[ -](?:axis[ -])?units?|unité[ _]z|einheit(?:[ _]z)?|"
        r"(?:heights?|z) in",
    }.items()
}
"""Words for sizes, and for the unit of heights, at the beginning of a line or of a part of it."""
_NO_DATA = re.compile(r"no[ _]?data(?:[ _]value)?[\s:=]+(-?\d+\.?\d*(?:e[+-]?\d+)?)", re.IGNORECASE)
_HEAD = re.compile(r"\b([xyz])\b\s*[\[(/]\s*([^\])/\s;,\t]+)", re.IGNORECASE)
_AFTER_COMMA = re.compile(r",0\d")  # decimals, for no whole number begins with 0
_LEAST_PLACES = 9  # rows of three numbers from which on they are x, y and z
_MOST_BYTES = 2**30
_TOLERANCE = 1e-3  # share of a step within which places are on a grid


Size = tuple[float, float] | None


def read_text(path: Path) -> tuple[Array, Size, float | None]:
    """Heights by x and y in their unit, NaN in holes; sides of a pixel [m] and unit [m], if said.

    A matrix has a line for each y, in which x goes from column to column.
    Raise an `InputError` if there is no matrix of numbers, nor rows of x, y and z on a grid.
    """
    if path.stat().st_size > _MOST_BYTES:
        raise InputError(f"{path}: more than 1 GiB; crop or average the surface first")
    text, _ = decoded(path.read_bytes())
    lines = [_unquoted(line) for line in text.splitlines() if line.strip()]
    head, table, above = _table(path, lines)
    if hole := _NO_DATA.search("\n".join(head)):
        table[table == float(hole[1])] = np.nan
    sizes, units = _said(head)
    if table.shape[1] == 3 and (table.shape[0] >= _LEAST_PLACES or path.suffix.lower() == ".xyz"):
        return _placed_heights(path, table, units)
    unit = sizes.get("unit", units.get("z"))
    is_sized = {"width", "height"} <= sizes.keys()
    table, steps = (table, None) if is_sized else _stripped_axes(table, above)
    heights = np.ascontiguousarray(table.T)
    length = units.get("x", units.get("y"))
    pixel = None
    if is_sized:
        pixel = sizes["width"] / heights.shape[0], sizes["height"] / heights.shape[1]
    elif steps and length:
        pixel = steps[0] * length, steps[1] * length
    elif {"x step", "y step"} <= sizes.keys():
        pixel = sizes["x step"], sizes["y step"]
    return heights, pixel, unit


def _step(line: Array) -> float:
    """Step of places that are evenly spaced; NaN if they are not."""
    steps = np.diff(line)
    if len(steps) < 3 or not np.allclose(steps, steps[0], rtol=_TOLERANCE) or not steps[0]:
        return math.nan
    return float(abs(steps[0]))


def _stripped_axes(table: Array, above: Array) -> tuple[Array, tuple[float, float] | None]:
    """Heights without a column, or a column and a row, of even places; their steps by x and y."""
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


def _table(path: Path, lines: list[str]) -> tuple[list[str], Array, Array]:
    """Comments and words above; numbers of the rows, NaN in holes; places in the line above."""
    head = [line for line in lines if _is_comment(line)]
    body = [line for line in lines if not _is_comment(line)]
    separator = _separator(body[-min(len(body) // 2 + 1, 50) :])
    first = next((k for k, line in enumerate(body) if _is_row(line, separator)), len(body))
    if first == len(body):
        raise InputError(f"{path}: no line of numbers; give heights as text, a row in a line")
    width = len(_row(body[first], separator))
    while first and None not in (row := _row(body[first - 1], separator)) and len(row) == width:
        first -= 1  # a row of holes alone
    above = _row(body[first - 1], separator) if first else []
    places = np.array(above[1:], float)
    is_size = first and any(size.fullmatch(body[first - 1].strip()) for size in _SIZES.values())
    if not (is_size or math.isfinite(_step(places))) and len(above) > above.count(None):
        first -= len(above) == len(_cells(body[first], separator))  # it is a row with a word
    rows = [_row(line, separator) for line in body[first:]]
    usual = max(map(len, rows))
    for line, row in zip(body[first:], rows, strict=True):
        if None in row:
            word = _cells(line, separator)[row.index(None)].strip()
            raise InputError(
                f'{path}: "{word}" is not a number; write holes as NaN, and decimals all with the '
                "same mark"
            )
        # Holes may stand at the end of a row, behind which there is a separator each.
        has_all = separator is not None and line.count(separator) >= usual - 1
        if len(row) < usual and not has_all:
            raise InputError(
                f'{path}: {len(row)} numbers in the row "{line.strip()[:40]}", but {usual} in '
                "others; all rows must be of equal length"
            )
    if separator == "," and any(map(_AFTER_COMMA.search, body[first:])):
        raise InputError(
            f"{path}: commas stand between cells and before decimals; put semicolons between "
            "cells, or write decimals with points"
        )
    table = np.array([[*row, *[math.nan] * (usual - len(row))] for row in rows], float)
    return [*head, *body[:first]], table, places


def _is_comment(line: str) -> bool:
    """True of a line that begins as a comment, and not as a row that begins with a hole."""
    if not line.lstrip().startswith(_COMMENT):
        return False
    rows = [_row(line, separator) for separator in (";", "\t", None, ",")]
    return not any(len(row) > 1 and None not in row for row in rows)


def _separator(lines: list[str]) -> str | None:
    """What stands between the cells of some lines; None for blanks."""
    for separator in (";", "\t", " ", ","):
        if all(separator in (line.strip() if separator == " " else line) for line in lines):
            between = None if separator == " " else separator
            if between in (";", "\t") or all(None not in _row(line, between) for line in lines):
                return between
    return None


def _unquoted(line: str) -> str:
    """A line whose cells stand in quotation marks without these, and semicolons between cells."""
    bare = line.strip().rstrip(",;")
    if len(bare) < 2 or not bare[0] == bare[-1] == '"':
        return line
    return ";".join(re.split(r'"[,;\t]"', bare[1:-1]))


def _cells(line: str, separator: str | None) -> list[str]:
    """Cells of a line, without empty ones at its end."""
    return (line if separator is None else line.rstrip(f"{separator} \t")).split(separator)


def _number(cell: str) -> float | None:
    """A cell with a point or a comma of decimals; NaN in a hole; None if it is a word."""
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return math.nan if cell.strip().lower() in _HOLES else None


def _row(line: str, separator: str | None) -> list[float | None]:
    """The cells of a line as numbers."""
    return [*map(_number, _cells(line, separator))]


def _is_row(line: str, separator: str | None) -> bool:
    """True if each cell is a number or a hole, and any is a number."""
    numbers = _row(line, separator)
    return None not in numbers and any(number == number for number in numbers)


def _said(head: list[str]) -> tuple[dict[str, float], dict[str, float]]:
    """Sizes and the unit of the heights, and units of columns x, y and z, of comments [m]."""
    sizes: dict[str, float] = {}
    units: dict[str, float] = {}
    for line in head:
        for part in re.split(r"[,;](?=\s)", line):
            for name, size in _SIZES.items():
                if match := size.fullmatch(part.strip()):
                    said = match[1].replace(",", ".").replace(";", " ")
                    if (length := _length(f"1 {said}" if name == "unit" else said)) is not None:
                        axes = ("x step", "y step") if name == "xy step" else (name,)
                        sizes |= dict.fromkeys(axes, length)
        for axis, unit in _HEAD.findall(line):
            if (length := _length(f"1 {unit}")) is not None:
                units[axis.lower()] = length
    return sizes, units


def _length(text: str) -> float | None:
    try:
        return to_si(text, "1 um")
    except UnitError:
        return None


def _placed_heights(
    path: Path, table: Array, units: dict[str, float]
) -> tuple[Array, Size, float | None]:
    """Heights of rows of x, y and z on a regular grid; places without a row are holes."""
    axes, places = [], []
    for column in table.T[:2]:
        values = np.unique(column[np.isfinite(column)])
        steps = np.diff(values)
        if not steps.size:
            raise InputError(f"{path}: rows of x, y, z at one x or y alone; give a map of heights")
        step = float(np.median(steps[steps > _TOLERANCE * steps.max()]))
        place = (column - values[0]) / step
        if np.nanmax(np.abs(place - np.round(place))) > 100 * _TOLERANCE:
            raise InputError(f"{path}: x and y are not on a regular grid; give one, or a matrix")
        axes.append(step)
        places.append(np.round(place).astype(int))
    shape = tuple(int(place.max()) + 1 for place in places)
    if np.prod(shape) > 16 * len(table):
        raise InputError(f"{path}: x and y are not on a regular grid; give one, or a matrix")
    heights = np.full(shape, np.nan)
    heights[places[0], places[1]] = table[:, 2]
    pixel = None
    if {"x", "y"} <= units.keys():
        pixel = axes[0] * units["x"], axes[1] * units["y"]
    return heights, pixel, units.get("z")
