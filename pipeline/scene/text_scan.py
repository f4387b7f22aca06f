"""Heights in text, as Gwyddion, MountainsMap, numpy.savetxt and spreadsheets write them.

A matrix, or rows of x, y and z; behind comments or words; between tabs, semicolons, commas or
blanks; with points or decimal commas; with holes as NaN, as nothing, or as a word.
"""

from __future__ import annotations

import io
import math
import re
from pathlib import Path

import numpy as np

from pipeline.scene.rows import decoded
from pipeline.scene.units import UnitError, to_si
from tribo import InputError
from tribo.types import Array

TEXT = (".csv", ".txt", ".xyz", ".asc", ".dat", ".tsv")
_HOLES = [
    "", "nan", "NaN", "NAN", "bad", "BAD", "Bad", "***", "---", "-", "null", "None", "missing",
]  # fmt: skip
_COMMENT = ("#", "%", "//", ";#", "*")
_NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*([eE][+-]?\d+)?|[.,]\d+([eE][+-]?\d+)?|inf)")
_SIZES = {
    name: re.compile(rf"\W*(?:{words})\s*[:=\s]\s*(\S.*)", re.IGNORECASE)
    for name, words in {
        "width": r"width|breite|taille[ _]x|x[ -](?:axis[ -])?(?:size|length)",
        "height": r"height|höhe|taille[ _]y|y[ -](?:axis[ -])?(?:size|length)",
        "x step": r"(?:spacing|step|pixel size|schrittweite|pas|d)[ _-]?x|x[ -](?:spacing|step)",
        "y step": r"(?:spacing|step|pixel size|schrittweite|pas|d)[ _-]?y|y[ -](?:spacing|step)",
        "unit": r"value units?|z[ -](?:axis[ -])?units?|unité[ _]z|einheit(?:[ _]z)?|"
        r"(?:heights?|z) in",
    }.items()
}
"""Words for sizes, and for the unit of heights, at the beginning of a line or of a part of it."""
_NO_DATA = re.compile(r"no[ _]?data(?:[ _]value)?[\s:=]+(-?[\d.]+)", re.IGNORECASE)
_HEAD = re.compile(r"\b([xyz])\b\s*[\[(/]\s*([^\])/\s;,\t]+)", re.IGNORECASE)
_LEAST_PLACES = 9  # rows of three numbers from which on they are x, y and z
_BLANKS = r"\s+"
_MOST_BYTES = 2**30
_TOLERANCE = 1e-3  # of a step, within which places are on a grid


Size = tuple[float, float] | None


def read_text(path: Path) -> tuple[Array, Size, float | None]:
    """Heights along x and then y, NaN in holes, the sides of a pixel [m], and the unit [m].

    Heights are in their unit; of sizes and unit what the text says. `InputError` is raised if
    there is no matrix of numbers, nor rows of x, y and z on a grid.
    """
    if path.stat().st_size > _MOST_BYTES:
        raise InputError(f"{path}: more than 1 GiB; crop or average the surface first")
    text, _ = decoded(path.read_bytes())
    head, body = _split(text.splitlines())
    if not body:
        raise InputError(f"{path}: no line of numbers; give heights as text, a row in a line")
    separator, decimal = _form(body)
    _require_equal_rows(path, head, body, separator)
    table = _table(path, body, separator, decimal)
    if hole := _NO_DATA.search("\n".join(head)):
        table[table == float(hole[1])] = np.nan
    sizes, units = _said(head)
    if table.shape[1] == 3 and (table.shape[0] >= _LEAST_PLACES or path.suffix.lower() == ".xyz"):
        return _of_places(path, table, units)
    unit = sizes.get("unit", units.get("z"))
    if {"width", "height"} <= sizes.keys():  # as Gwyddion writes it: a line for each y
        table = np.ascontiguousarray(table.T)
        x, y = sizes["width"] / table.shape[0], sizes["height"] / table.shape[1]
        return table, (x, y), unit
    table, steps = _without_axes(table, head[-1:])
    length = units.get("x", units.get("y"))
    if steps and length:
        return table, (steps[0] * length, steps[1] * length), unit
    pixel = (sizes["x step"], sizes["y step"]) if {"x step", "y step"} <= sizes.keys() else None
    return table, pixel, unit


def _step(line: Array) -> float:
    """Step of places that are evenly spaced; NaN if they are not."""
    steps = np.diff(line)
    if len(steps) < 3 or not np.allclose(steps, steps[0], rtol=_TOLERANCE) or not steps[0]:
        return math.nan
    return float(abs(steps[0]))


def _without_axes(table: Array, above: list[str]) -> tuple[Array, tuple[float, float] | None]:
    """Heights without a column, or a column and a row, of places; and the steps of these.

    The row may be the line above the numbers. A matrix whose second column is as even has none.
    """
    if min(table.shape) < 5:
        return table, None
    for first in (1, 0):
        down = _step(table[first:, 0])
        across = _step(table[0, 1:]) if first else _step(np.array(_places_in(above)))
        is_axis = math.isfinite(down) and not math.isfinite(_step(table[first:, 1]))
        if is_axis and (math.isfinite(across) or not first):
            steps = (down, across) if math.isfinite(across) else None
            return np.ascontiguousarray(table[first:, 1:]), steps
    return table, None


def _places_in(lines: list[str]) -> list[float]:
    """Numbers behind the first word of a line; none if others stand among them."""
    for line in lines:
        words = line.replace(";", "\t").replace(",", "\t" if "." in line else ".").split("\t")[1:]
        if words and all(_NUMBER.fullmatch(word.strip()) for word in words):
            return [float(word) for word in words]
    return []


def _require_equal_rows(path: Path, head: list[str], body: list[str], separator: str) -> None:
    """Raise unless all rows have as many cells, and no row of numbers counts as a heading."""

    def count(line: str) -> int:
        line = line.strip() if separator == _BLANKS else line.rstrip(f"{separator} \t")
        return len(line.split()) if separator == _BLANKS else line.count(separator) + 1

    counts = [count(line) for line in body]
    # Holes may stand at the end of a row, behind which there is a separator each.
    usual = max(counts)
    if separator == _BLANKS or min(counts) == 1 < usual:
        for line, cells in zip(body, counts, strict=True):
            if cells != usual:
                raise InputError(
                    f'{path}: {cells} numbers in the row "{line.strip()[:40]}", but {usual} in '
                    "others; all rows must be of equal length"
                )
    for line in head:
        if line.lstrip().startswith(_COMMENT):
            continue
        is_size = any(size.fullmatch(line.strip()) for size in _SIZES.values())
        if is_size or math.isfinite(_step(np.array(_places_in([line])))):
            continue
        words = re.split(r"[;,\t ]+", line.strip())
        wrong = [word for word in words if not _NUMBER.fullmatch(word)]
        if len(words) == usual and len(wrong) < usual:
            raise InputError(f'{path}: "{wrong[0]}" is not a number; write holes as NaN')


def _table(path: Path, body: list[str], separator: str, decimal: str) -> Array:
    """Numbers of all rows; NaN in holes."""
    import pandas as pd  # here, since few scenes have heights in text, and workers read none

    try:
        frame = pd.read_csv(
            io.StringIO("\n".join(body)), sep=separator, header=None, decimal=decimal,
            na_values=_HOLES, skipinitialspace=True, engine="c",
        )  # fmt: skip
    except pd.errors.ParserError as error:
        raise InputError(f"{path}: rows of unequal length: {error}") from error
    if frame.shape[1] > 1 and frame.iloc[:, -1].isna().all():
        frame = frame.iloc[:, :-1]  # behind a separator at the end of each row
    for column in frame:
        if frame[column].dtype.kind not in "fiu":
            values = frame[column]
            is_wrong = pd.to_numeric(values, errors="coerce").isna() & values.notna()
            problem = f'"{values[is_wrong].iloc[0]}" is not a number; write holes as NaN'
            raise InputError(f"{path}: {problem}, and decimals all with the same mark")
    table: Array = frame.to_numpy(dtype=np.float64, copy=True)  # for holes to be written
    return table


def _split(lines: list[str]) -> tuple[list[str], list[str]]:
    """Comments and words above, and the lines of numbers."""
    filled = [line for line in lines if line.strip()]
    body = [line for line in filled if not line.lstrip().startswith(_COMMENT)]
    first = next((k for k, line in enumerate(body) if _is_numeric(line)), len(body))
    head = [line for line in filled if line.lstrip().startswith(_COMMENT)]
    return head + body[:first], body[first:]


def _is_numeric(line: str) -> bool:
    """True if each cell is a number or a hole, and any is a number."""

    def is_row(cells: list[str]) -> bool:
        numbers = [cell for cell in cells if _NUMBER.fullmatch(cell)]
        return bool(numbers) and {*cells} <= {*numbers, *_HOLES}

    cells = re.split(r"[;\t ]+|,(?=\s|[+-]?\d*\.)", line.strip())
    return is_row([cell.strip(",") for cell in cells if cell]) or is_row(
        [cell.strip() for cell in line.split(",")]
    )


def _form(body: list[str]) -> tuple[str, str]:
    """Separator of the cells and mark of decimals."""
    lines = body[:50]
    for mark in (";", "\t"):
        if all(mark in line for line in lines):
            return mark, "," if any("," in line for line in lines) else "."
    if all("," in line for line in lines):
        blanks = all(re.search(r"\d\s+[+-]?\d", line) for line in lines)
        return (_BLANKS, ",") if blanks else (",", ".")
    return _BLANKS, "."


def _said(head: list[str]) -> tuple[dict[str, float], dict[str, float]]:
    """Sizes and the unit of the heights, and units of columns x, y and z, of comments [m]."""
    sizes: dict[str, float] = {}
    units: dict[str, float] = {}
    for line in head:
        for part in re.split(r"[,;](?=\s)", line):
            for name, size in _SIZES.items():
                if match := size.fullmatch(part.strip()):
                    text = f"1 {match[1]}" if name == "unit" else match[1].replace(",", ".")
                    if (length := _length(text)) is not None:
                        sizes[name] = length
        for axis, unit in _HEAD.findall(line):
            if (length := _length(f"1 {unit}")) is not None:
                units[axis.lower()] = length
    return sizes, units


def _length(text: str) -> float | None:
    try:
        return to_si(text, "1 um")
    except UnitError:
        return None


def _of_places(
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
