"""Exports of machines, as data of ``exports/NAME.toml``.

A file is of an export if at least two of its signs match cells; the one with most signs counts.
"""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources

from pipeline.scene.faults import did_you_mean
from pipeline.scene.sheet import Lines
from tribo import InputError

_LEAST_SIGNS = 2
_MOST_ROWS = 60  # in which signs are sought


@dataclass(frozen=True)
class Export:
    """What a machine writes: signs by which it is known, its columns, and what they mean."""

    title: str = ""
    signs: tuple[str, ...] = ()  # patterns of cells
    scene: str = ""  # that fits the rig
    columns: Mapping[str, str] = field(default_factory=dict)  # patterns of headings; "" for none
    units: Mapping[str, str] = field(default_factory=dict)  # of columns without one
    unit_row: str = ""  # first cell of a row above the headings that has their units
    step_row: str = ""  # the same, that has the step of the time, where the rows have none
    restarts: bool = False  # the time begins anew with each step
    sine: str = ""  # pattern of cells that tell that the velocity is the highest of a sine
    stages: bool = False  # rows of a log are stages of one specimen
    step: str = ""  # of the load of a test by steps


@functools.cache
def exports() -> Mapping[str, Export]:
    """All exports, by name."""
    folder = resources.files("pipeline.laboratory").joinpath("exports")
    files = sorted((one for one in folder.iterdir() if one.name.endswith(".toml")), key=str)
    return {one.name[:-5]: Export(**tomllib.loads(one.read_text("utf-8"))) for one in files}


def find_export(tables: Sequence[Lines], named: str | None) -> Export:
    """The export of a file, or the user's choice; an empty export if no machine is recognised."""
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
    """True if any filled cell is as a pattern says."""
    return any(cell and re.fullmatch(pattern, cell, re.IGNORECASE) for cell in cells)
