"""Data frames of results with units in their headings: as text, JSON, CSV, Markdown and HTML."""

from __future__ import annotations

import itertools
import json
import math
import os
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeGuard

import pandas as pd

from pipeline.paths import store_file, sync
from pipeline.quantities import SIZES, in_unit
from tribo import InputError

_UNIT_OF_HEADING = re.compile(r".+ \[(.+)\]")
_LAYOUTS = (80, 10, 1000, "  "), (80, 9, 1000, "  "), (100, 10, 1000, "  "), (100, 8, 22, " ")
"""Layouts of a table: length of a line, widths of headings and cells, and gap between columns."""


def frame_of(headings: Sequence[str], rows: Iterable[Sequence[Any]]) -> pd.DataFrame:
    """Data frame of rows in SI, converted to the units of headings such as ``load [N]``."""
    units = [_unit_of(heading) for heading in headings]
    converted = [
        tuple(
            _in_unit(value, unit) if unit and _is_number(value) else value
            for value, unit in zip(row, units, strict=True)
        )
        for row in rows
    ]
    return pd.DataFrame(converted, columns=pd.Index(headings))


def _in_unit(value: float, unit: str) -> float:
    """The value in a unit, with 15 digits: 0.116 is 11.6 %, not 11.600000000000001."""
    return float(f"{in_unit(value, unit):.15g}")


def without_columns(frame: pd.DataFrame, without: Iterable[str] = ()) -> pd.DataFrame:
    """The frame without empty columns, and without the columns named in `without`."""
    return frame.drop(columns=[*without], errors="ignore").dropna(axis="columns", how="all")


def transposed(frame: pd.DataFrame) -> pd.DataFrame:
    """Transpose a frame of one row: each column that is not empty becomes a row."""
    columns = without_columns(frame)
    (cells,) = cells_of(columns, "-")
    return pd.DataFrame({"quantity": [*map(str, columns)], "value": cells})


def lines_of(frame: pd.DataFrame) -> list[str]:
    """Lines of text with aligned columns, headings first.

    Headings are broken between words, if possible to lines of 80 letters; else cells of the last
    column are broken to lines of 100. If this is not enough, all cells are broken, and columns move
    closer. A word of more than 100 letters is cut.
    """
    rows = [
        [re.sub(r"(\S{99})\S\S+", r"\1…", text) for text in row] for row in cells_of(frame, "-")
    ]
    min_last_width = 20  # of a column whose cells are broken
    for length, max_heading_width, max_cell_width, gap in _LAYOUTS:
        headings = [_broken_lines(str(heading), max_heading_width) for heading in frame]
        broken_rows = [[_broken_lines(text, max_cell_width) for text in row] for row in rows]
        columns = (itertools.chain(*column) for column in zip(headings, *broken_rows, strict=True))
        widths = [max(map(len, column), default=0) for column in columns]
        last_width = length - sum(width + len(gap) for width in widths[:-1])
        if last_width >= (widths[-1] if length == 80 else min(widths[-1], min_last_width)):
            break
    lines = [*itertools.zip_longest(*headings, fillvalue="")]
    for row in rows:
        broken_cells = map(_broken_lines, row, [*widths[:-1], max(last_width, min_last_width)])
        lines += itertools.zip_longest(*broken_cells, fillvalue="")
    return [
        gap.join(f"{cell:<{width}}" for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    ]


def _broken_lines(text: str, width: int) -> list[str]:
    """Lines of a text, broken between words to at most `width` letters; none without text."""
    if len(text) <= width:  # the wrapping is slow
        return [text] if text else []
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)


def write_frames(frames: Sequence[pd.DataFrame], out: Path) -> Path:
    """Write the rows of frames as CSV, Markdown or JSON, by the suffix of the file."""
    frame, suffix = pd.concat(frames), out.suffix.lower()
    if suffix == ".csv":
        cells = frame.reset_index(drop=True).apply(_as_cells).rename(columns=_as_cell)
        text = cells.to_csv(index=False, float_format="%.6g")
    else:
        text = json_of(records(frames)) if suffix == ".json" else "\n".join(markdown_of(frame))
        text += "\n"
    return write_text(text, out)


def _as_cells(column: pd.Series) -> pd.Series:
    if column.dtype.kind in "biuf":
        return column
    return pd.Series([*map(_as_cell, column)], dtype=column.dtype, name=column.name)


def _as_cell(value: Any) -> Any:
    """A value of a CSV; an apostrophe before a text that a spreadsheet would take for a formula."""
    if isinstance(value, str) and value.startswith(("=", "+", "-", "−", "@", "\t", "\r")):
        with suppress(ValueError):
            float(value)
            return value
        return f"'{value}"
    return value


def records(frames: Iterable[pd.DataFrame]) -> list[dict[str, Any]]:
    """Rows of frames as dictionaries by heading, for JSON."""
    return [
        {str(heading): None if pd.isna(value) else value for heading, value in row.items()}
        for frame in frames
        for row in frame.to_dict("records")
    ]


def json_of(document: Any) -> str:
    """A document as JSON; NaN and infinity, which JSON lacks, become null."""
    return json.dumps(_finite(document), indent=2, ensure_ascii=False, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def markdown_of(frame: pd.DataFrame) -> Iterator[str]:
    """Yield the lines of the frame as a Markdown table."""
    for number, row in enumerate([[*map(str, frame)], *cells_of(frame, "")]):
        cells = [re.sub(r"[\\|<]", r"\\\g<0>", cell) for cell in row]
        yield f"| {' | '.join(cells)} |"
        if number == 0:
            yield "|---" * len(row) + "|"


def cells_of(frame: pd.DataFrame, missing: str, digits: int = 4) -> list[list[str]]:
    """Values of a frame as text, row by row; `missing` stands for NaN and None."""
    rows = frame.itertuples(index=False, name=None)
    return [
        [missing if pd.isna(value) else cell_text(value, digits) for value in row] for row in rows
    ]


def cell_text(value: Any, digits: int) -> str:
    """A value of a cell as text, a number with at most `digits` significant digits."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not _is_number(value):
        return str(value)
    return f"{value:.0f}" if abs(value) >= 10**digits else f"{value:.{digits}g}"


def _is_number(value: Any) -> TypeGuard[float]:
    is_numeric = isinstance(value, int | float) and not isinstance(value, bool)
    return is_numeric and not math.isnan(value)


def _unit_of(heading: str) -> str:
    """Unit of a heading; empty if it has none that is known."""
    match = _UNIT_OF_HEADING.fullmatch(heading)
    return match[1] if match and match[1] in SIZES else ""


def write_text(text: str, out: Path) -> Path:
    """Write text to a file in UTF-8, completely or not at all; see `write_bytes`."""
    return write_bytes(text.encode(), out)


def write_bytes(content: bytes, out: Path) -> Path:
    """Write a file `out` completely, or keep the old file and raise an `InputError`."""
    try:
        file = Path(os.path.realpath(out))  # keeps a symbolic link in place
        sync(store_file(file.parent, file.name, content))
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror or error}") from error
    return out
