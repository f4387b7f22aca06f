"""Operating points to be judged: loads and velocities, with conditions of each, from a table."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.messages import quoted
from pipeline.sweep.case import CONDITION_ENTRIES, OIL_WORKS
from pipeline.table import Table, read_table
from pipeline.units import share_of, to_si
from tribo import InputError

_LIKE = {
    "load": "200 N", "velocity": "1.25 m/s",
    "bulk_temperature": "25 degC", "critical_temperature": "145 degC",
}  # fmt: skip
_LOAD_AND_VELOCITY = "load", "velocity"
_COLDEST, _HOTTEST = (to_si(end, "1 K") for end in OIL_WORKS)
_RANGES = {
    "load": (math.ulp(0.0), math.inf, "above 0"),
    "velocity": (math.ulp(0.0), math.inf, "above 0"),
    "friction": (0.0, math.inf, "at least 0"),
    "bulk_temperature": (_COLDEST, _HOTTEST, " to ".join(OIL_WORKS)),
    "critical_temperature": (math.ulp(0.0), math.inf, "above 0 K"),
    "critical_area_fraction": (0.0, math.nextafter(1.0, 0.0), "at least 0 and below 1"),
}
"""Least and largest values of each column [SI], and what is allowed in words."""


class OperatingPoints(NamedTuple):
    """Operating points, and conditions of each, from a table.

    `columns` has loads [N], velocities [m/s] and the conditions that the table gives [SI].
    `labels` are its columns of words.
    """

    columns: dict[str, list[float]]
    labels: Mapping[str, Sequence[Any]]

    @classmethod
    def read(
        cls,
        source: str | os.PathLike[str] | Mapping[str, Sequence[Any]],
        decimal: str | None = None,
        ignore: Collection[str] = (),
    ) -> OperatingPoints:
        """Read a file as CSV, or columns by heading, such as a data frame.

        `decimal` is the decimal mark of the file, and `ignore` has headings of columns to leave
        out. Columns of words are labels, which are passed on. Raises an `InputError` with all
        faults of the table.
        """
        path_or_columns = Path(source) if isinstance(source, str | os.PathLike) else source
        condition_names = {path: name for name, path in CONDITION_ENTRIES.items()}
        max_rows = 100_000  # which are judged within a minute
        table = read_table(path_or_columns, max_rows, decimal, ignore, condition_names)
        table = _without_answers(table)
        rows = table.rows(_RANGES, _faults_in, _LOAD_AND_VELOCITY)
        columns = {
            name: [_value(name, row[name]) for row in rows] for name in _RANGES if name in rows[0]
        }
        label_columns = (column for column in table.columns if column.name not in _RANGES)
        return cls(columns, {column.heading: column.cells for column in label_columns})


def _without_answers(table: Table) -> Table:
    """A table of the command ``irg margin`` without what it answers; another table unchanged."""
    names = [column.name for column in table.columns]
    if not {*_LOAD_AND_VELOCITY, "verdict", "probability"} <= {*names}:
        return table
    last = max(names.index(name) for name in _LOAD_AND_VELOCITY)
    point_columns = [
        column for k, column in enumerate(table.columns) if k < last or column.name in _RANGES
    ]
    return replace(table, columns=point_columns)


def _faults_in(row: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the columns of a row whose cells have no value, or one out of range, and why."""
    for name, cell in row.items():
        try:
            _value(name, cell)
        except ValueError as error:
            yield name, str(error)


def _value(name: str, cell: Any) -> float:
    """Value of a cell in SI; `InputError` or ValueError if it has none, or is out of range."""
    if name not in _LIKE:
        value = float(share_of(cell))
    elif isinstance(cell, str):
        value = to_si(cell, _LIKE[name])
    else:
        raise InputError(f"{cell} has no unit; give one such as {_LIKE[name]}")
    lowest, highest, allowed = _RANGES[name]
    if not lowest <= value <= highest or math.isinf(value):
        raise InputError(f"{quoted(cell)} is outside the allowed range; it must be {allowed}")
    return value
