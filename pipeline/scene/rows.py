"""Rows of a CSV file, whose headings name quantities and their units, such as ``load [N]``."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import NamedTuple

_HEAD = re.compile(r"\s*(?P<title>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
_USUAL = {"normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature"}


class Row(NamedTuple):
    """Cells of a row, and its number in the file."""

    number: int
    cells: list[str]


def read_rows(path: Path) -> tuple[list[str], list[Row], list[str]]:
    """Headings of a file in UTF-8, its rows that are not empty, and faults in their lengths.

    Cells stand between commas, semicolons or tabs: those that the first line has most of.
    """
    text = path.read_text(encoding="utf-8-sig")
    separator = max(",;\t", key=text.partition("\n")[0].count)
    lines = csv.reader(text.splitlines(), delimiter=separator)
    rows = [Row(number, list(map(str.strip, cells))) for number, cells in enumerate(lines, 1)]
    heads, *others = [row for row in rows if any(row.cells)] or [Row(1, [])]
    faults = [
        f"row {number}: {len(cells)} cells below {len(heads.cells)} headings"
        for number, cells in others
        if len(cells) != len(heads.cells)
    ]
    return heads.cells, others, faults


def quantity_and_unit(heading: str) -> tuple[str, str]:
    """Quantity that a heading stands for, and its unit.

    Examples
    --------
    >>> quantity_and_unit("Normal load [kN]"), quantity_and_unit("outcome")
    (('load', 'kN'), ('outcome', ''))
    """
    match = _HEAD.fullmatch(heading)
    if match is None:
        return heading.strip(), ""
    name = match["title"].lower().replace(" ", "_")
    return _USUAL.get(name, name), match["unit"] or ""
