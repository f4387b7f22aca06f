"""Read a table from a file or from columns in Python, by the names of its quantities."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from pipeline import extras
from pipeline.paths import user_path
from pipeline.scene.choices import NO_CHOICES, Choices, choose, require_known
from pipeline.scene.lines import Lines, read_lines
from pipeline.scene.names import Names
from pipeline.scene.option_words import Written
from pipeline.scene.sheet import Sheet, sheet_of
from pipeline.sweep.limits import MOST_ROWS


def read_sheet(
    source: Path | Lines, units: Mapping[str, str | None], needed: Collection[str],
    moving: Collection[str] = (), choices: Choices = NO_CHOICES, written: Written = "scene",
    most: int = MOST_ROWS,
) -> Sheet:  # fmt: skip
    """Read a table from a file or from lines (`source`), and find the columns of quantities.

    `units` has the quantities to look for, with their SI units. Rows that lack a `needed` quantity,
    or in which a quantity of `moving` is 0, are left out and counted. `choices` are those of the
    user, and messages name them as they are `written`. `most` is the largest number of rows of a
    text.
    """
    words: Any = next(extras.modules("tables"), None)
    chosen = choices.columns or {}
    names = words.WordNames(units, chosen) if words else Names(units, chosen)
    require_known(choices, {*names.units})
    name, tables = "points", [source] if isinstance(source, Lines) else []
    if isinstance(source, Path):
        name, tables = str(source), read_lines(user_path(source), names, choices.sheet, most)
    found = sheet_of(name, tables, names, choices.decimal)
    choose(found, choices, chosen)
    if words:
        words.derive(found, needed)
    found.require(needed, moving)
    found.written = written
    return found
