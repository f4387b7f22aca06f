"""Export formats of test machines, described by ``exports/NAME.toml``.

The signs of a format are patterns of cells. A file has a format if at least two of the format's
signs match cells of the file. If several formats match, the one with the most matches is used.
"""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources

from pipeline.scene.faults import did_you_mean
from pipeline.scene.lines import Lines
from tribo import InputError

_LEAST_SIGNS = 2
_MOST_ROWS = 60  # rows searched for signs


@dataclass(frozen=True)
class Export:
    """Format of files that a test machine exports: how to recognise them, and their columns.

    `signs` are patterns of cells; a file has the format if at least two of them match.
    """

    title: str = ""
    signs: tuple[str, ...] = ()  # patterns of cells that identify it
    scene: str = ""  # name of the shipped scene that fits the rig
    columns: Mapping[str, str] = field(default_factory=dict)  # patterns of headings
    units: Mapping[str, str] = field(default_factory=dict)  # units of headings without a unit
    restarts: bool = False  # True if time restarts with each step
    sine: str = ""  # pattern of a cell which tells that the velocity is the peak of a sine
    step: str = ""  # load step of a stepwise test


@functools.cache
def exports() -> Mapping[str, Export]:
    """Formats of the files that test machines export, by name, from ``exports/*.toml``."""
    folder = resources.files("pipeline.laboratory").joinpath("exports")
    files = sorted((one for one in folder.iterdir() if one.name.endswith(".toml")), key=str)
    return {one.name[:-5]: Export(**tomllib.loads(one.read_text("utf-8"))) for one in files}


def find_export(tables: Sequence[Lines], named: str | None) -> Export:
    """Find the format of a file: the format `named`, else recognised by cells of its `tables`.

    Returns an empty format if no format matches. Raises an `InputError` if there is no format
    `named`.
    """
    if named is not None:
        if named not in exports():
            near = did_you_mean(named, exports())
            raise InputError(f'no form "{named}"{near}; give one of {", ".join(exports())}')
        return exports()[named]
    cells = {cell for table in tables for row in table.rows[:_MOST_ROWS] for cell in row.cells}
    counts = {
        name: sum(has_cell(cells, sign) for sign in one.signs) for name, one in exports().items()
    }
    name = max(counts, key=lambda one: counts[one])
    return exports()[name] if counts[name] >= _LEAST_SIGNS else Export()


def has_cell(cells: Iterable[str], pattern: str) -> bool:
    """True if a regular expression, in any case, matches a whole cell; empty cells do not count."""
    return any(cell and re.fullmatch(pattern, cell, re.IGNORECASE) for cell in cells)
