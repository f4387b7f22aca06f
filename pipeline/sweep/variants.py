"""Variants of a scene: a table with one row for each variant."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from pipeline.quantities import as_written
from tribo import InputError

VARIANT = "variant"
"""Dimension that numbers the rows of a table that is no full product of its columns."""
ROWS = {
    "realization": "seed of the random surface",
    VARIANT: "number of the row in the table of variants",
}
"""Dimensions that number rows, without an entry of the scene, and their meanings."""
PLACE_UNITS = {"load": "N", "velocity": "m/s"}
"""Columns with a load or a velocity of each row's own, and their units."""
Label = float | int | str
"""Value of a row in a column."""
Variant = tuple[tuple[str, Label], ...]
"""Name of a row: the dimensions in front of load and velocity, each with the row's value."""
SEED = "disk.roughness.seed"


def dimension_of(path: str) -> str:
    """Name of an entry's dimension, an identifier: "pin_radius" for "pin.radius"."""
    return path.replace(".", "_")


class Row(NamedTuple):
    """One variant of a scene: `labels` by column [SI], and `values` of entries that it replaces.

    Keys of `values` are paths. A label whose column stands for an entry (`Column.key`) replaces
    that entry too, unless `values` has it.
    """

    labels: Mapping[str, Label]
    values: Mapping[str, Any]  # as a scene file has them


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the table of variants: a dimension, or values that a dimension determines.

    The dimension is `along`; it is empty if the column is itself a dimension.
    """

    name: str
    unit: str | None = "1"  # None for words
    along: str = ""  # dimension that determines the values; empty for a dimension
    is_seed: bool = False  # rows that differ here alone are equally likely surfaces
    meaning: str = ""
    entry: str = ""  # path of the entry that the column sets, if the name is another

    @property
    def key(self) -> str:
        """Path of the scene entry that the column sets: `entry`, or the column's name."""
        return self.entry or self.name


@dataclass(frozen=True)
class Variants:
    """Table of the variants of a scene, a row for each variant.

    A column is a dimension, such as the seed of a random surface, or has values that a dimension
    determines. Each combination of values of the dimensions has a row. A row with its own velocity
    or load is simulated only at that velocity or load, all other rows at those of the sweep.
    """

    columns: tuple[Column, ...] = ()
    rows: tuple[Row, ...] = (Row({}, {}),)

    def __post_init__(self) -> None:
        _ = self.by_name  # raises for two rows with the same name

    def __len__(self) -> int:
        return len(self.rows)

    def __mul__(self, other: Variants) -> Variants:
        """Combine every row with every row of `other`, whose entries take precedence."""
        pairs = itertools.product(self.rows, other.rows)
        rows = (Row({**a.labels, **b.labels}, {**a.values, **b.values}) for a, b in pairs)
        return Variants(self.columns + other.columns, tuple(rows))

    @cached_property
    def by_name(self) -> dict[Variant, Row]:
        """Rows of the table by the names of variants.

        A name is a tuple of (dimension, label) pairs. Raises an `InputError` if two rows have the
        same name.
        """
        dims = [one.name for one in self.columns if not one.along]
        rows = {tuple([(dim, row.labels[dim]) for dim in dims]): row for row in self.rows}
        if len(rows) < len(self.rows):
            raise InputError("two rows of the sweep have the same values; give each value once")
        return rows

    @cached_property
    def names(self) -> tuple[Variant, ...]:
        """Name of each row: its labels along the dimensions of the table."""
        return tuple(self.by_name)

    @cached_property
    def axes(self) -> dict[str, tuple[Label, ...]]:
        """Labels along each dimension of the table."""
        dims = [one.name for one in self.columns if not one.along]
        return {dim: tuple(dict.fromkeys(row.labels[dim] for row in self.rows)) for dim in dims}

    @cached_property
    def coordinates(self) -> dict[Column, dict[Label, Label]]:
        """For each column whose value follows from a dimension's label, its values by that label.

        For example, a row's own load follows from the number of the row.
        """
        return {
            one: {row.labels[one.along]: row.labels[one.name] for row in self.rows}
            for one in self.columns
            if one.along
        }

    @property
    def chosen(self) -> tuple[Column, ...]:
        """Dimensions whose labels the user chose: all but seeds of random surfaces."""
        return tuple(one for one in self.columns if not (one.along or one.is_seed))

    @property
    def given(self) -> tuple[Variant, ...]:
        """Names of the variants that the user chose: all combinations of the chosen labels.

        A name is a tuple of (dimension, label) pairs. The dimension of random surfaces is left out.
        """
        return combinations({one.name: self.axes[one.name] for one in self.chosen})

    @property
    def without_surfaces(self) -> Variants:
        """Table of the variants that the user chose, without random surfaces."""
        seeds = {one.name for one in self.columns if one.is_seed}
        columns = tuple(one for one in self.columns if not one.is_seed)
        rows = dict[Variant, Row]()
        for labels, values in self.rows:
            own = {name: label for name, label in labels.items() if name not in seeds}
            others = {path: value for path, value in values.items() if path != SEED}
            rows.setdefault((*own.items(),), Row(own, others))
        return Variants(columns, tuple(rows.values()))

    def labels(self, name: str) -> tuple[Any, ...] | None:
        """Label of each row in a column; None if there is no such column."""
        is_there = any(one.name == name for one in self.columns)
        return tuple(row.labels[name] for row in self.rows) if is_there else None

    def values(self, name: Variant) -> Mapping[str, Any]:
        """New values of the scene's entries that a variant replaces, by path of the entry.

        `name` has the pairs (dimension, label) of the variant. It may leave out the dimension of
        random surfaces; then the result leaves out their seeds. Raises an `InputError` if the sweep
        has no such variant.
        """
        if name in self.by_name:
            labels, values = self.by_name[name]
            paths = [one for one in self.columns if "." in one.key and one.key not in values]
            return {one.key: as_written(labels[one.name], one.unit) for one in paths} | {**values}
        own = [row for full, row in self.by_name.items() if {*name} <= {*full}]
        if not own or {key for key, _ in name} != {one.name for one in self.chosen}:
            wanted = " and ".join(f"{key} {value}" for key, value in name)
            ends = "; ".join(f"{key} {one[0]} to {one[-1]}" for key, one in self.axes.items())
            raise InputError(f"the sweep has no {wanted}; it has {ends or 'one scene alone'}")
        seeds = {one.key for one in self.columns if one.is_seed}
        return {key: one for key, one in own[0].values.items() if key not in seeds}

    def written(self, name: Variant) -> dict[str, Any]:
        """Labels of a row by dimension, written as in a scene file."""
        values = self.values(name) if name else {}
        keys = {one.name: one.key for one in self.columns}
        return {dim: values.get(keys[dim], label) for dim, label in name}

    def surfaces_of(self, name: Variant) -> Variants:
        """Table of the random surfaces of one variant; a single row if it has none."""
        columns = tuple(one for one in self.columns if one.is_seed)
        own = [row for full, row in self.by_name.items() if {*name} <= {*full}]
        rows = (Row({one.name: row.labels[one.name] for one in columns}, row.values) for row in own)
        return Variants(columns, tuple(rows)) if columns else Variants()

    def union(self, other: Variants) -> Variants:
        """Join two tables with the same dimensions; a row that both have is taken from `other`.

        Raises
        ------
        InputError
            If neither table has a row for some combination of the labels of both tables.
        """
        axes = {dim: in_order([*self.axes[dim], *more]) for dim, more in other.axes.items()}
        names, rows = combinations(axes), self.by_name | other.by_name
        if gap := next((dict(name) for name in names if name not in rows), None):
            words = ", ".join(f"{label} {value}" for label, value in gap.items())
            raise InputError(
                f"a combination of values is missing, {words} (in SI); give each entry of "
                "sweep.over all of its values, those of the store included"
            )
        return replace(other, rows=tuple(rows[name] for name in names))


def combinations(axes: Mapping[str, Sequence[Label]]) -> tuple[Variant, ...]:
    """All combinations of the labels along some `axes`, as names of variants."""
    return tuple(
        tuple(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())
    )


def in_order(labels: Iterable[Any]) -> list[Any]:
    """Return labels, each once: numbers in ascending order, texts in the order given."""
    once = dict.fromkeys(labels)
    is_text = any(isinstance(label, str) for label in once)
    return [*once] if is_text else sorted(once)


def surfaces(seeds: Sequence[int]) -> Variants:
    """Table of variants on random surfaces, one for each seed; a single variant without seeds."""
    name = "realization"
    column = Column(name, is_seed=True, meaning=ROWS[name], entry=SEED)
    rows = tuple(Row({name: seed}, {SEED: seed}) for seed in seeds)
    return Variants((column,), rows) if seeds else Variants()


def numbered_rows(columns: Iterable[Column], rows: Iterable[Row]) -> Variants:
    """Table of variants numbered from 0, with `columns`."""
    number = Column(VARIANT, meaning=ROWS[VARIANT])
    along = (replace(one, along=VARIANT) for one in columns)
    numbered = (Row({VARIANT: k, **labels}, one) for k, (labels, one) in enumerate(rows))
    return Variants((number, *along), tuple(numbered))
