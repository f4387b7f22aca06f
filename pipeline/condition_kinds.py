"""Conditions that act on stored results, and operating points with conditions of each.

`CONDITIONS` has all that scenes, tables, commands and answers know of a condition.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypedDict

import numpy as np

from pipeline.kinds import POINT_KINDS, Kind, Quantity, Share, faults_in
from pipeline.table import Table, read_table
from tribo.simulation.usual_values import USUAL

if TYPE_CHECKING:
    import xarray as xr

OIL_WORKS = "-53 degC", "627 degC"
"""Bulk temperatures between which an oil may work."""


class Condition(NamedTuple):
    """A condition: path of its entry in a scene, kind of its values, and its meaning."""

    entry: str
    kind: Kind
    meaning: str


FRICTION = Share(at_least=0, usual=USUAL["friction"].ends)
BULK = Quantity("25 degC", usual=USUAL["bulk_temperature"].ends, ends=OIL_WORKS)
CRITICAL = Quantity(
    "145 degC", usual=USUAL["critical_temperature"].ends, ends=(OIL_WORKS[0], "1e5 degC")
)
CONDITIONS = {
    "friction": Condition("friction.coefficient", FRICTION, "coefficient of friction"),
    "bulk_temperature": Condition(
        "temperature.bulk", BULK, "temperature of the bodies far from the contact"
    ),
    "critical_temperature": Condition(
        "temperature.critical", CRITICAL, "contact temperature at which the lubricant fails"
    ),
    "critical_area_fraction": Condition(
        "temperature.critical_area_fraction",
        Share(at_least=0, below=1),
        "fraction of the contact above the critical temperature from which wear is severe",
    ),
    "added_rise_fraction": Condition(
        "model.rise",
        Share(above=-1, usual=USUAL["added_rise_fraction"].ends),
        "relative rise added for effects outside the model",
    ),
}
"""Conditions by the names of the attributes of `tribo.Conditions`."""
ConditionValue: TypeAlias = (
    "float | str | Sequence[float | str] | np.ndarray[Any, Any] | xr.DataArray"
)
"""One value in SI or text with its unit, or several values along a new dimension."""


class ConditionValues(TypedDict, total=False):
    """Conditions that replace those of the scene, as keywords of answers."""

    friction: ConditionValue | None
    bulk_temperature: ConditionValue | None
    critical_temperature: ConditionValue | None
    critical_area_fraction: ConditionValue | None
    added_rise_fraction: ConditionValue | None


_KINDS = POINT_KINDS | {name: condition.kind for name, condition in CONDITIONS.items()}
"""Kinds of the columns that act, by name."""
_SI_UNITS = {name: kind.si_unit for name, kind in _KINDS.items() if kind.si_unit}


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
        condition_names = {entry: name for name, (entry, *_) in CONDITIONS.items()}
        max_rows = 100_000  # which are judged within a minute
        table = read_table(path_or_columns, max_rows, decimal, ignore, condition_names, _SI_UNITS)
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
