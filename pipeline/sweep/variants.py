"""Variants of a scene: a table with one row for each variant."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from pipeline import extras
from pipeline.quantities import as_written
from tribo import InputError

VARIANT = "variant"
"""Dimension that numbers the rows of a table that is no full product of its columns."""
ROWS = {
    "realization": "seed of the random surface",
    VARIANT: "number of the row in the table of variants",
    "sample": "number of the sample of inputs",
}
"""Dimensions that number rows, without an entry of the scene, and their meanings."""
PLACE_UNITS = {"load": "N", "velocity": "m/s"}
"""Columns with a load or a velocity of each row's own, and their units."""
Label = float | int | str
"""Value of a row in a column."""
Variant = tuple[tuple[str, Label], ...]
"""Name of a row: the dimensions in front of load and velocity, each with the row's value."""
SEED = "disk.roughness.seed"


class Row(NamedTuple):
    """Labels of a row by column [SI], and the entries of the scene that it replaces by path.

    If a column is called by a path that is not among these entries, its label is the entry's value.
    """

    labels: Mapping[str, Label]
    values: Mapping[str, Any]  # as a scene file has them


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the table: a dimension, or values that follow from a dimension."""

    name: str
    unit: str | None = "1"  # None for words
    along: str = ""  # dimension from which the values follow; empty for a dimension
    is_drawn: bool = False  # rows that differ in it alone are equally likely draws
    meaning: str = ""
    entry: str = ""  # path of the entry that it gives, if not the name

    @property
    def key(self) -> str:
        """Path of the entry that the column sets: its `entry` or, without one, its name."""
        return self.entry or self.name


class Sampling(NamedTuple):
    """Properties of the rule by which rows were drawn, as the add-on that draws them reports."""

    unknown: tuple[str, ...] = ()  # paths of the inputs that have no single value
    movable: tuple[str, ...] = ()  # paths of unknown and fixed inputs that may have one value
    answers: Any = ()  # plain data that answers depend on [SI]
    rows: Any = ()  # plain data that the rows depend on [SI]
    per_contact: int = 1  # rows that follow each other and share their contacts


@dataclass(frozen=True)
class Variants:
    """A table of the variants of a scene: every combination of the labels of its dimensions.

    Rows with a velocity or a load are simulated there alone, others at every load and velocity.
    """

    columns: tuple[Column, ...] = ()
    rows: tuple[Row, ...] = (Row({}, {}),)
    # Rule by which rows were drawn, as plain data of the extra that draws them.
    draw: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        _ = self.by_name  # raises for two rows with the same name

    def __len__(self) -> int:
        return len(self.rows)

    def __mul__(self, other: Variants) -> Variants:
        """Every row of one table combined with every row of another, whose entries override."""
        pairs = itertools.product(self.rows, other.rows)
        rows = (Row({**a.labels, **b.labels}, {**a.values, **b.values}) for a, b in pairs)
        return Variants(self.columns + other.columns, tuple(rows), self.draw or other.draw)

    @cached_property
    def by_name(self) -> dict[Variant, Row]:
        """Rows by their names."""
        dims = [one.name for one in self.columns if not one.along]
        rows = {tuple([(dim, row.labels[dim]) for dim in dims]): row for row in self.rows}
        if len(rows) < len(self.rows):
            raise InputError("two rows of the sweep have the same values; give each value once")
        return rows

    @cached_property
    def names(self) -> tuple[Variant, ...]:
        """Name of each row."""
        return tuple(self.by_name)

    @cached_property
    def axes(self) -> dict[str, tuple[Label, ...]]:
        """Dimensions in front of load and velocity, with their values."""
        dims = [one.name for one in self.columns if not one.along]
        return {dim: tuple(dict.fromkeys(row.labels[dim] for row in self.rows)) for dim in dims}

    @cached_property
    def coordinates(self) -> dict[Column, dict[Label, Label]]:
        """Columns that follow from a dimension, each with its values by labels of the dimension."""
        return {
            one: {row.labels[one.along]: row.labels[one.name] for row in self.rows}
            for one in self.columns
            if one.along
        }

    @property
    def chosen(self) -> tuple[Column, ...]:
        """Dimensions whose values are no random draws."""
        return tuple(one for one in self.columns if not (one.along or one.is_drawn))

    @property
    def given(self) -> tuple[Variant, ...]:
        """Every combination of labels along the dimensions that are no random draws."""
        return combinations({one.name: self.axes[one.name] for one in self.chosen})

    def base(self, name: Variant) -> Variant:
        """Name of the scene of which a row is a sample; its own name if it is no sample."""
        return tuple(pair for pair in name if pair[0] != VARIANT) if self.draw else name

    @cached_property
    def rule(self) -> Sampling:
        """The rule by which rows were drawn; empty if none were drawn."""
        return extras.module("drawn").read_rule(self.draw) if self.draw else Sampling()

    def labels(self, name: str) -> tuple[Any, ...] | None:
        """Labels of the rows in a column; None without such a column."""
        is_there = any(one.name == name for one in self.columns)
        return tuple(row.labels[name] for row in self.rows) if is_there else None

    def values(self, name: Variant) -> Mapping[str, Any]:
        """Entries that a row replaces; for a name without its draws, those that are not drawn."""
        if name in self.by_name:
            labels, values = self.by_name[name]
            paths = [one for one in self.columns if "." in one.key and one.key not in values]
            return {one.key: as_written(labels[one.name], one.unit) for one in paths} | {**values}
        own = [row for full, row in self.by_name.items() if {*name} <= {*full}]
        if not own or len(name) != len(self.chosen):
            wanted = " and ".join(f"{key} {value}" for key, value in name)
            ends = "; ".join(f"{key} {one[0]} to {one[-1]}" for key, one in self.axes.items())
            raise InputError(f"the sweep has no {wanted}; it has {ends or 'one scene alone'}")
        drawn = {one.key for one in self._drawn}
        return {key: one for key, one in own[0].values.items() if key not in drawn}

    @property
    def _drawn(self) -> tuple[Column, ...]:
        """Columns whose values are random draws, or follow from a column of draws."""
        drawn = {one.name for one in self.columns if one.is_drawn}
        return tuple(one for one in self.columns if drawn & {one.name, one.along})

    def written(self, name: Variant) -> dict[str, Any]:
        """Values of a row along its dimensions, in the words of a scene file."""
        values = self.values(name) if name else {}
        keys = {one.name: one.key for one in self.columns}
        return {dim: values.get(keys[dim], label) for dim, label in name}

    def samples_of(self, name: Variant) -> Variants:
        """Rows drawn for one combination of the other labels; a single row if none are drawn."""
        columns = self._drawn
        own = [row for full, row in self.by_name.items() if {*name} <= {*full}]
        rows = (Row({one.name: row.labels[one.name] for one in columns}, row.values) for row in own)
        return Variants(columns, tuple(rows), self.draw) if columns else Variants()

    def union(self, other: Variants) -> Variants:
        """Rows of both tables, which have the same dimensions; a row in both is that of `other`.

        Raises
        ------
        InputError
            If neither has some combination of labels.
        """
        axes = {dim: in_order([*self.axes[dim], *more]) for dim, more in other.axes.items()}
        names, rows = combinations(axes), self.by_name | other.by_name
        if gap := next((dict(name) for name in names if name not in rows), None):
            words = ", ".join(f"{label} {value}" for label, value in gap.items())
            raise InputError(
                f"neither has all combinations of values, such as {words} (in SI); give each entry "
                "of sweep.over all of its values, those of the store included"
            )
        return replace(other, rows=tuple(rows[name] for name in names))


def combinations(axes: Mapping[str, Sequence[Label]]) -> tuple[Variant, ...]:
    """Every combination of the values of some dimensions; just ``()`` without dimensions."""
    return tuple(
        tuple(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())
    )


def in_order(labels: Iterable[Any]) -> list[Any]:
    """Labels, each once: numbers ascending, text in the order given."""
    once = dict.fromkeys(labels)
    is_text = any(isinstance(label, str) for label in once)
    return [*once] if is_text else sorted(once)


def surfaces(seeds: Sequence[int]) -> Variants:
    """Variants on random surfaces, by their seeds; a single one without seeds."""
    name = "realization"
    column = Column(name, is_drawn=True, meaning=ROWS[name], entry=SEED)
    rows = tuple(Row({name: seed}, {SEED: seed}) for seed in seeds)
    return Variants((column,), rows) if seeds else Variants()


def numbered_rows(
    columns: Iterable[Column], rows: Iterable[Row], draw: Mapping[str, Any] | None = None
) -> Variants:
    """Variants by the numbers of rows, with columns that follow from the numbers."""
    number = Column(VARIANT, is_drawn=draw is not None, meaning=ROWS[VARIANT])
    along = (replace(one, along=VARIANT) for one in columns)
    numbered = (Row({VARIANT: k, **labels}, one) for k, (labels, one) in enumerate(rows))
    return Variants((number, *along), tuple(numbered), draw)


def labelled_rows(
    name: str, changes: Mapping[Label, Mapping[str, Any]], **places: Sequence[float]
) -> Variants:
    """Variants by label: the entries that each changes, and its own load or velocity [SI]."""
    is_text = isinstance(next(iter(changes)), str)
    key = Column(name, None if is_text else "1", meaning=f"{name} of the scene")
    own = (Column(one, PLACE_UNITS[one], name, meaning=f"{one} of each {name}") for one in places)
    rows = (
        Row({name: label} | {one: float(values[k]) for one, values in places.items()}, change)
        for k, (label, change) in enumerate(changes.items())
    )
    return Variants((key, *own), tuple(rows))
