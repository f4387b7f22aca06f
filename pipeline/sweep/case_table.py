"""Table of the cases of a scene, a row for each."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from pipeline.quantities import DIMENSIONS, display
from tribo import InputError

LEAST_DISTANCE = 1e-4
"""Least relative distance of loads and velocities; a slope between nearer ones would be noise."""
CASE = "case"
"""Dimension that numbers the rows of a table that is no full product of its columns."""
ROWS = {
    "realization": "seed of the random surface, or number of the area of a scan",
    CASE: "number of the row in the table of cases",
}
"""Dimensions that number rows, without an entry of the scene, and their meanings."""
LOAD_FACTOR = "load_factor"
"""Dimension of the shares of a row's load at which it is simulated."""
PLACE_UNITS = {"load": "N", "velocity": "m/s"}
"""Columns with the load or velocity of each row, and their units."""
Label = float | int | str
"""Value of a row in a column."""
CaseRow = Mapping[str, Label]
"""A row: its labels [SI] by column."""
CaseName = tuple[tuple[str, Label], ...]
"""Name of a case: the dimensions in front of load and velocity, each with the row's label."""
SEED_ENTRY = "disk.roughness.seed"
AREAS_ENTRY = "sweep.realizations"
"""Entry whose first value is the area of a scan that a case is simulated on."""


def dimension_of(path: str) -> str:
    """Name of an entry's dimension, an identifier: "pin_radius" for "pin.radius"."""
    return path.replace(".", "_")


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the table of cases: a dimension, or values that a dimension determines.

    The dimension is `along`; it is empty if the column is itself a dimension.
    """

    name: str
    unit: str | None = "1"  # in SI; None for words
    along: str = ""  # dimension that determines the values; empty for a dimension
    is_seed: bool = False  # rows that differ only in this column are equally likely surfaces
    meaning: str = ""
    entry: str = ""  # path of the entry that the column sets, unless it is the name
    display_unit: str = ""  # unit of the labels in output

    @property
    def key(self) -> str:
        """Path of the scene entry that the column sets: `entry`, or the column's name."""
        return self.entry or self.name

    def to_text(self, label: Label) -> Label:
        """A label with its unit as people write it, such as "2 mm"."""
        if isinstance(label, str) or self.unit is None:
            return label
        usual_unit = next(iter(DIMENSIONS[self.unit].units)) if self.unit in DIMENSIONS else ""
        if unit := self.display_unit or usual_unit:
            return display(label, unit)
        return int(label) if isinstance(label, float) and label.is_integer() else label


@dataclass(frozen=True)
class CaseTable:
    """Table of the cases of a scene, a row for each case.

    A column is a dimension, such as the seed of a random surface, or has values that a dimension
    determines. Each combination of values of the dimensions has a row. A row with its own velocity
    or load is simulated only at that velocity or load, all other rows at those of the sweep. With
    `load_factors`, which ascend, a row is simulated at these shares of its load.
    """

    columns: tuple[Column, ...] = ()
    rows: tuple[CaseRow, ...] = ({},)
    load_factors: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if any(row.keys() != {column.name for column in self.columns} for row in self.rows):
            raise InputError("a row of the sweep has other columns than its table")
        _ = self.by_name  # raises for two rows with the same name

    def __len__(self) -> int:
        return len(self.rows)

    def __mul__(self, other: CaseTable) -> CaseTable:
        """Combine every row with every row of `other`."""
        rows = ({**a, **b} for a, b in itertools.product(self.rows, other.rows))
        factors = self.load_factors or other.load_factors
        return CaseTable(self.columns + other.columns, tuple(rows), factors)

    @cached_property
    def by_name(self) -> dict[CaseName, CaseRow]:
        """Rows of the table by the names of cases; `InputError` if two have the same name."""
        dims = [column.name for column in self.columns if not column.along]
        rows = {tuple([(dim, row[dim]) for dim in dims]): row for row in self.rows}
        if len(rows) < len(self.rows):
            raise InputError("two cases of the sweep have the same values; list each once")
        return rows

    @cached_property
    def names(self) -> tuple[CaseName, ...]:
        """Name of each row: its labels along the dimensions of the table."""
        return tuple(self.by_name)

    @cached_property
    def axes(self) -> dict[str, tuple[Label, ...]]:
        """Labels along each dimension of the table."""
        dims = [column.name for column in self.columns if not column.along]
        return {dim: tuple(dict.fromkeys(row[dim] for row in self.rows)) for dim in dims}

    @cached_property
    def coordinates(self) -> dict[Column, dict[Label, Label]]:
        """For each column whose value follows from a dimension's label, its values by that label.

        For example, a row's own load follows from the number of the row.
        """
        return {
            column: {row[column.along]: row[column.name] for row in self.rows}
            for column in self.columns
            if column.along
        }

    @property
    def chosen_columns(self) -> tuple[Column, ...]:
        """Dimensions whose labels the user chose: all but seeds of random surfaces."""
        return tuple(column for column in self.columns if not (column.along or column.is_seed))

    @property
    def without_surfaces(self) -> CaseTable:
        """Table of the cases that the user chose, without random surfaces."""
        seeds = {column.name for column in self.columns if column.is_seed}
        columns = tuple(column for column in self.columns if not column.is_seed)
        rows = dict[CaseName, CaseRow]()
        for row in self.rows:
            labels = {name: label for name, label in row.items() if name not in seeds}
            rows.setdefault((*labels.items(),), labels)
        return replace(self, columns=columns, rows=tuple(rows.values()))

    def loads_of(self, row: CaseRow) -> tuple[float, ...]:
        """Loads of a row with a load of its own, at each of the load factors [N]; else empty.

        They are rounded, so that equal loads of two rows are equal numbers.
        """
        if "load" not in row:
            return ()
        load = float(row["load"])
        return tuple(
            load if factor == 1 else float(f"{load * factor:.12g}")
            for factor in self.load_factors or (1.0,)
        )

    def load_factor(self, name: CaseName, load: float) -> float:
        """The factor at which a case is simulated with a `load` [N]."""
        return self.load_factors[self.loads_of(self.by_name[name]).index(load)]

    def column(self, name: str) -> tuple[Any, ...] | None:
        """Label of each case in a column; None if there is no such column."""
        has_column = any(column.name == name for column in self.columns)
        return tuple(row[name] for row in self.rows) if has_column else None

    def unknown_case(self, name: CaseName) -> InputError:
        """The error for a case that the sweep does not have."""
        requested = " and ".join(f"{key} {value}" for key, value in name)
        ends = "; ".join(f"{key} {labels[0]} to {labels[-1]}" for key, labels in self.axes.items())
        return InputError(f"the sweep has no {requested}; it has {ends or 'one case'}")

    def to_text(self, name: CaseName) -> dict[str, Label]:
        """Labels of a name by dimension, each with its unit, such as "2 mm"."""
        columns = {column.name: column for column in self.columns}
        return {dim: columns[dim].to_text(label) for dim, label in name}

    def surfaces_of(self, name: CaseName) -> CaseTable:
        """Table of the random surfaces of one case; a single row if it has none."""
        columns = tuple(column for column in self.columns if column.is_seed)
        labels = {*name}
        case_rows = [row for row_name, row in self.by_name.items() if labels <= {*row_name}]
        rows = ({column.name: row[column.name] for column in columns} for row in case_rows)
        return CaseTable(columns, tuple(rows)) if columns else CaseTable()

    def union(self, other: CaseTable) -> CaseTable:
        """Join two tables with the same dimensions; a row that both have is taken from `other`.

        Raises
        ------
        InputError
            If neither table has a row for some combination of the labels of both tables.
        """
        axes = {dim: in_order([*self.axes[dim], *more]) for dim, more in other.axes.items()}
        names = [
            tuple(zip(axes, labels, strict=True)) for labels in itertools.product(*axes.values())
        ]
        rows = self.by_name | other.by_name
        if gap := next((dict(name) for name in names if name not in rows), None):
            words = ", ".join(f"{label} {value}" for label, value in gap.items())
            raise InputError(
                f"a combination of values is missing: {words} (in SI); list all values of each "
                "entry of sweep.over, including those already in the store"
            )
        return replace(other, rows=tuple(rows[name] for name in names))


def in_order(labels: Iterable[Any]) -> list[Any]:
    """Return labels, each once: numbers in ascending order, texts in the order given."""
    unique = dict.fromkeys(labels)
    is_text = any(isinstance(label, str) for label in unique)
    return [*unique] if is_text else sorted(unique)


def surface_table(seeds: Sequence[int]) -> CaseTable:
    """Table of cases on random surfaces, one for each seed; a single case without seeds."""
    name = "realization"
    column = Column(name, is_seed=True, meaning=ROWS[name], entry=SEED_ENTRY)
    return CaseTable((column,), tuple({name: seed} for seed in seeds)) if seeds else CaseTable()


def numbered_cases(
    columns: Iterable[Column], rows: Iterable[CaseRow], load_factors: Sequence[float]
) -> CaseTable:
    """Table of cases numbered from 0, with `columns`, each at some shares of its load."""
    number = Column(CASE, meaning=ROWS[CASE])
    dependent_columns = (replace(column, along=CASE) for column in columns)
    return CaseTable(
        (number, *dependent_columns),
        tuple({CASE: k, **row} for k, row in enumerate(rows)),
        tuple(load_factors),
    )
