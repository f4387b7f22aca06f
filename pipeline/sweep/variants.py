"""Variants of a scene: a table with one row a variant, whoever filled it."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tribo import InputError

VARIANT = "variant"
"""Dimension of rows that are no full product; it numbers them."""
ROWS = {
    "realization": "seed of the random surface",
    VARIANT: "number of the row in the table of variants",
    "sample": "number of the sample of inputs",
}
"""Meanings of the whole numbers that tell rows apart, where no entry of the scene does."""
Label = float | int | str
"""Value of a row in a column."""
Variant = tuple[tuple[str, Label], ...]
"""Name of a row: the dimensions in front of load and velocity, each with the row's value."""
Row = Mapping[str, Any]
"""Labels of a row, and the entries of the scene that it replaces, by their paths."""
SEED = "disk.roughness.seed"


@dataclass(frozen=True, slots=True)
class Column:
    """Labels of the rows of a table: values along a dimension, or values that follow from them."""

    name: str
    values: tuple[Label, ...]  # one for each row [SI]
    unit: str | None = "1"  # None for words
    along: str = ""  # dimension that the values follow from; empty of a dimension
    is_drawn: bool = False  # rows that differ in it alone differ by chance, each as likely
    meaning: str = ""
    entry: str = ""  # key of the values in the rows, if not the name

    @property
    def key(self) -> str:
        """Key of the values in the rows, as they were written."""
        return self.entry or self.name

    def taken(self, numbers: Sequence[int]) -> Column:
        """The column with the values of some rows, in their order."""
        return replace(self, values=tuple(self.values[i] for i in numbers))


@dataclass(frozen=True, slots=True)
class Variants:
    """A table of the variants of a scene, one row each: a product of the labels of dimensions."""

    # Those named "velocity" and "load" are the place at which a row alone is simulated [m/s, N];
    # without them all rows share the plane.
    columns: tuple[Column, ...] = ()
    rows: tuple[Row, ...] = field(default=({},), hash=False, compare=False)
    # Rule by which rows were drawn, as plain data; it names the inputs that are not known exactly.
    draw: Mapping[str, Any] | None = field(default=None, hash=False)
    _rows: Mapping[Variant, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        keys = [column for column in self.columns if not column.along]
        labels = zip(*(key.values for key in keys), strict=True) if keys else [()]
        names = [tuple(zip((key.name for key in keys), row, strict=True)) for row in labels]
        if not len({*names}) == len(names) == len(self.rows):
            raise InputError("the rows of the sweep do not have a label each")
        object.__setattr__(self, "_rows", {name: number for number, name in enumerate(names)})

    def __len__(self) -> int:
        return len(self.rows)

    def __contains__(self, name: object) -> bool:
        return name in self._rows

    def __mul__(self, other: Variants) -> Variants:
        """Every row of one table with every row of another, whose changes come later."""
        if shared := {one.name for one in self.columns} & {one.name for one in other.columns}:
            raise InputError(f"two tables of variants have {', '.join(sorted(shared))}; give one")
        first = [i for i in range(len(self)) for _ in range(len(other))]
        second = [*range(len(other))] * len(self)
        return Variants(
            columns=(
                *(column.taken(first) for column in self.columns),
                *(column.taken(second) for column in other.columns),
            ),
            rows=tuple({**row, **then} for row in self.rows for then in other.rows),
            draw=self.draw or other.draw,
        )

    @property
    def names(self) -> tuple[Variant, ...]:
        """Name of each row."""
        return tuple(self._rows)

    @property
    def axes(self) -> dict[str, tuple[Label, ...]]:
        """Dimensions in front of load and velocity, with their values."""
        return {
            column.name: tuple(dict.fromkeys(column.values))
            for column in self.columns
            if not column.along
        }

    @property
    def coordinates(self) -> dict[Column, dict[Label, Label]]:
        """Columns that follow from a dimension, each with its values by those along that."""
        along = {column.name: column.values for column in self.columns}
        return {
            column: dict(zip(along[column.along], column.values, strict=True))
            for column in self.columns
            if column.along
        }

    @property
    def chosen(self) -> tuple[Column, ...]:
        """Dimensions that are not drawn."""
        return tuple(one for one in self.columns if not (one.along or one.is_drawn))

    @property
    def unknown(self) -> tuple[str, ...]:
        """Paths of the unknown inputs of samples that have no single value."""
        return tuple(one["path"] for one in self.draw["unknown"]) if self.draw else ()

    @property
    def given(self) -> tuple[Variant, ...]:
        """Combinations of the labels that are not drawn."""
        return combinations({one.name: self.axes[one.name] for one in self.chosen})

    @property
    def rule(self) -> Any:
        """The rule by which rows were drawn, without the units that it is written in."""
        return _in_si(self.draw)

    @property
    def velocities(self) -> tuple[float, ...] | None:
        """Velocity at which each row alone is simulated [m/s]; None if they share a plane."""
        return self._places("velocity")

    @property
    def has_plane(self) -> bool:
        """True if all rows share a plane, so that none has its own place."""
        return self.velocities is None and self._places("load") is None

    def _places(self, name: str) -> tuple[Any, ...] | None:
        return next((column.values for column in self.columns if column.name == name), None)

    def row(self, name: Variant) -> Row:
        """A row, or what the rows of a combination of the labels share that are not drawn."""
        if name in self._rows:
            return self.rows[self._rows[name]]
        matching = [k for row, k in self._rows.items() if {*name} <= {*row}]
        if not matching or len(name) != len(self.chosen):
            unknown = [(key, one) for key, one in name if one not in self.axes.get(key, ())]
            key, value = unknown[0] if unknown else ("the variant", dict(name))
            held = ", ".join(map(str, self.axes.get(key, ()))) or "none"
            raise InputError(f"{key} is {value}, which the sweep does not have; it has {held}")
        drawn = {one.name for one in self.columns if one.is_drawn}
        keys = {one.key for one in self.columns if drawn & {one.name, one.along}}
        return {key: one for key, one in self.rows[matching[0]].items() if key not in keys}

    def written(self, name: Variant) -> dict[str, Any]:
        """Values of a row along its dimensions, as the scene writes them."""
        row = self.row(name) if name else {}
        keys = {one.name: one.key for one in self.columns}
        return {label: row.get(keys[label], value) for label, value in name}

    def below(self, name: Variant) -> Variants:
        """Rows that are drawn for a combination of labels that are not; one if none is drawn."""
        drawn = {column.name for column in self.columns if column.is_drawn and not column.along}
        if not drawn:
            return Variants()
        numbers = [k for row, k in self._rows.items() if {*name} <= {*row}]
        columns = [one for one in self.columns if (one.along or one.name) in drawn]
        return _select(columns, self.rows, numbers, self.draw)

    def union(self, other: Variants) -> Variants:
        """Rows of both tables, which have the same dimensions; what both have is the other's.

        Raises
        ------
        InputError
            If neither has some combination of labels.
        """
        axes = {name: in_order([*self.axes[name], *values]) for name, values in other.axes.items()}
        names = combinations(axes)
        numbers = {name: number for number, name in enumerate([*self._rows, *other._rows])}
        if gap := next((dict(name) for name in names if name not in numbers), None):
            words = ", ".join(f"{label} {value}" for label, value in gap.items())
            raise InputError(
                f"neither has all combinations of values, such as {words} (in SI); give each entry "
                "of sweep.over all of its values, those of the store included"
            )
        mine = {column.name: column.values for column in self.columns}
        columns = [replace(one, values=mine[one.name] + one.values) for one in other.columns]
        rows = [numbers[name] for name in names]
        return _select(columns, (*self.rows, *other.rows), rows, other.draw)

    def plane_of(
        self, name: Variant, loads: tuple[float, ...], velocities: tuple[float, ...]
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Loads and velocities of a row: its own place, or those of the plane."""
        at, own = self._rows[name], [self._places(axis) for axis in ("load", "velocity")]
        return (own[0][at],) if own[0] else loads, (own[1][at],) if own[1] else velocities


def _select(
    columns: Iterable[Column], rows: Sequence[Row], numbers: Sequence[int], draw: Any
) -> Variants:
    """A table of some rows, by their numbers."""
    taken = tuple(column.taken(numbers) for column in columns)
    return Variants(taken, tuple(rows[k] for k in numbers), draw)


def _in_si(told: Any) -> Any:
    if isinstance(told, Mapping):
        return {key: _in_si(one) for key, one in told.items() if key != "written"}
    return [*map(_in_si, told)] if isinstance(told, list) else told


def combinations(axes: Mapping[str, Sequence[Label]]) -> tuple[Variant, ...]:
    """Every combination of the values of some dimensions; one, ``()``, of no dimensions."""
    return tuple(
        tuple(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())
    )


def in_order(labels: Iterable[Any]) -> list[Any]:
    """Labels, each once, numbers ascending."""
    once = dict.fromkeys(labels)
    is_text = any(isinstance(label, str) for label in once)
    return [*once] if is_text else sorted(once)


def numbers(count: int, is_drawn: bool = False) -> Column:
    """Numbers of rows, as a dimension."""
    return Column(VARIANT, tuple(range(count)), is_drawn=is_drawn, meaning=ROWS[VARIANT])


def surfaces(seeds: Sequence[int]) -> Variants:
    """The scene on random surfaces, by their seeds."""
    if not seeds:
        return Variants()
    column = Column(
        "realization", tuple(seeds), is_drawn=True, meaning=ROWS["realization"], entry=SEED
    )
    return Variants((column,), tuple({SEED: seed} for seed in seeds))


def placed_rows(
    rows: Sequence[Row],
    columns: Sequence[Column],
    loads: Sequence[float],
    velocities: Sequence[float],
) -> Variants:
    """Numbered rows with a place each."""
    places = [
        Column(name, tuple(held), unit, VARIANT, meaning=f"{name} of the row")
        for name, held, unit in (("load", loads, "N"), ("velocity", velocities, "m/s"))
    ]
    along = [*(replace(column, along=VARIANT) for column in columns), *places]
    labels = [column for column in columns if "." not in column.name]
    numbered = [
        {VARIANT: k, **_texts(places, k), **row, **{one.name: one.values[k] for one in labels}}
        for k, row in enumerate(rows)
    ]
    return Variants((numbers(len(rows)), *along), tuple(numbered))


def _texts(columns: Iterable[Column], number: int) -> Row:
    """Labels of a row as text that reads as the same numbers."""
    return {one.name: f"{one.values[number]!r} {one.unit}" for one in columns}


def labelled_rows(
    name: str,
    changes: Mapping[Label, Row],
    velocities: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
) -> Variants:
    """Rows by hand: by label the entries that each changes, and its place [SI], if any."""
    labels = tuple(changes)
    own = [
        Column(axis, tuple(map(float, values)), unit, name, meaning=f"{axis} of each {name}")
        for axis, values, unit in (("velocity", velocities, "m/s"), ("load", loads, "N"))
        if values is not None
    ]
    unit = None if isinstance(labels[0], str) else "1"
    key = Column(name, labels, unit, meaning=f"{name} of the scene")
    rows = (
        {name: label, **_texts(own, number), **change}
        for number, (label, change) in enumerate(changes.items())
    )
    return Variants((key, *own), tuple(rows))
