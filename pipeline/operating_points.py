"""Operating points to be judged: loads and velocities, with conditions of each, from a table."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.kinds import CONDITION_KINDS, POINT_KINDS, faults_in
from pipeline.sweep.case import CONDITION_ENTRIES
from pipeline.table import Table, read_table

_KINDS = POINT_KINDS | {name: CONDITION_KINDS[name] for name in CONDITION_ENTRIES}
"""Kinds of the columns that act, by name."""


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
        rows = table.rows(_KINDS, partial(faults_in, kinds=_KINDS), POINT_KINDS)
        columns = {
            name: [kind.value(row[name]) for row in rows]
            for name, kind in _KINDS.items()
            if name in rows[0]
        }
        label_columns = (column for column in table.columns if column.name not in _KINDS)
        return cls(columns, {column.heading: column.cells for column in label_columns})


def _without_answers(table: Table) -> Table:
    """A table of the command ``irg margin`` without what it answers; another table unchanged."""
    names = [column.name for column in table.columns]
    if not {*POINT_KINDS, "verdict", "probability"} <= {*names}:
        return table
    last = max(names.index(name) for name in POINT_KINDS)
    point_columns = [
        column for k, column in enumerate(table.columns) if k < last or column.name in _KINDS
    ]
    return replace(table, columns=point_columns)
