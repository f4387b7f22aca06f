"""Variants of a scene: a table with one row a variant, whoever filled it."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.sweep.samples import Draw
from pipeline.sweep.unknown import Unknown
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
Part = tuple[tuple[str, Any], ...]
"""What a row changes: fields of a sweep's parts, or of theirs, such as ``roughness.seed``."""


@dataclass(frozen=True, slots=True)
class Column:
    """Labels of the rows of a table: values along a dimension, or values that follow from them."""

    name: str
    values: tuple[Label, ...]  # one for each row [SI]
    unit: str | None = "1"  # None for words
    along: str = ""  # dimension that the values follow from; empty of a dimension
    is_drawn: bool = False  # rows that differ in it alone differ by chance, each as likely
    meaning: str = ""
    texts: tuple[Any, ...] = ()  # values as the scene writes them, if otherwise

    def taken(self, numbers: Sequence[int]) -> Column:
        """The column with the values of some rows, in their order."""
        texts = tuple(self.texts[i] for i in numbers) if self.texts else ()
        return replace(self, values=tuple(self.values[i] for i in numbers), texts=texts)

    def joined(self, later: Column) -> Column:
        """A later column with the values of this one before its own."""
        texts = (self.texts or self.values) + (later.texts or later.values)
        return replace(later, values=self.values + later.values, texts=texts)

    @property
    def text_of(self) -> dict[Label, Any]:
        """The text of each value."""
        return dict(zip(self.values, self.texts or self.values, strict=True))


@dataclass(frozen=True, slots=True)
class Variants:
    """A table of the variants of a scene, one row each: a product of labels, or numbered rows."""

    # Those named "velocity" and "load" are the place at which a row alone is simulated [m/s, N];
    # without them all rows share the plane.
    columns: tuple[Column, ...] = ()
    parts: tuple[Part, ...] = ((),)  # what each row changes
    # What each combination of the dimensions changes that are not drawn; by default each row, or
    # nothing where rows are drawn.
    given: Mapping[Variant, Part] = field(default_factory=dict, hash=False)
    draw: Draw | None = None  # rule by which rows were drawn
    _rows: Mapping[Variant, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        keys = [column for column in self.columns if not column.along]
        labels = zip(*(key.values for key in keys), strict=True) if keys else [()]
        names = [tuple(zip((key.name for key in keys), row, strict=True)) for row in labels]
        is_product = tuple(names) == combinations(self.axes)
        if not is_product:
            names = [((VARIANT, number),) for number in range(len(self.parts))]
            columns = (_numbers(len(names)), *(replace(one, along=VARIANT) for one in self.columns))
            object.__setattr__(self, "columns", columns)
        if not (is_product and self.given):
            is_drawn = is_product and any(key.is_drawn for key in keys)
            given = {(): ()} if is_drawn else dict(zip(names, self.parts, strict=True))
            object.__setattr__(self, "given", given)
        object.__setattr__(self, "_rows", {name: number for number, name in enumerate(names)})

    def __len__(self) -> int:
        return len(self.parts)

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
            parts=tuple(self.parts[i] + other.parts[k] for i, k in zip(first, second, strict=True)),
            given={
                name + then: part + change
                for name, part in self.given.items()
                for then, change in other.given.items()
            },
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
    def unknown(self) -> tuple[Unknown, ...]:
        """Unknown inputs of samples that have no single value."""
        return self.draw.unknown if self.draw else ()

    @property
    def drawn_fields(self) -> tuple[str, ...]:
        """Paths of inner fields, such as ``roughness.seed``, that drawn rows change."""
        of_given = {path for part in self.given.values() for path, _ in part}
        return tuple(path for path, _ in self.parts[0] if "." in path and path not in of_given)

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

    def part(self, name: Variant) -> Part:
        """What a row changes, or a combination of the dimensions that are not drawn."""
        if name in self._rows:
            return self.parts[self._rows[name]]
        if name in self.given:
            return self.given[name]
        unknown = [(key, value) for key, value in name if value not in self.axes.get(key, ())]
        key, value = unknown[0] if unknown else ("the variant", dict(name))
        held = ", ".join(map(str, self.axes.get(key, ()))) or "none"
        raise InputError(f"{key} is {value}, which the sweep does not have; it has {held}")

    def below(self, name: Variant) -> Variants:
        """Rows that are drawn for a combination of labels that are not; one if none is drawn."""
        drawn = {column.name for column in self.columns if column.is_drawn and not column.along}
        if not drawn:
            return Variants()
        numbers = [k for row, k in self._rows.items() if {*name} <= {*row}]
        columns = [one for one in self.columns if (one.along or one.name) in drawn]
        return _select(columns, self.parts, numbers, {}, self.draw)

    def within(self, axes: Mapping[str, Collection[Label]]) -> Variants:
        """Rows whose labels are among those of some axes."""

        def is_within(name: Variant) -> bool:
            return all(value in axes.get(label, ()) for label, value in name)

        numbers = [k for name, k in self._rows.items() if is_within(name)]
        given = {name: part for name, part in self.given.items() if is_within(name)}
        return _select(self.columns, self.parts, numbers, given, self.draw)

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
        mine = {column.name: column for column in self.columns}
        columns = [mine[column.name].joined(column) for column in other.columns]
        chosen = combinations({one.name: axes[one.name] for one in other.chosen})
        both = {**self.given, **other.given}
        given = {name: both[name] for name in chosen if name in both}
        rows = [numbers[name] for name in names]
        return _select(columns, (*self.parts, *other.parts), rows, given, other.draw)

    def plane_of(
        self, name: Variant, loads: tuple[float, ...], velocities: tuple[float, ...]
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Loads and velocities of a row: its own place, or those of the plane."""
        at, own = self._rows[name], [self._places(axis) for axis in ("load", "velocity")]
        return (own[0][at],) if own[0] else loads, (own[1][at],) if own[1] else velocities


def _select(
    columns: Iterable[Column],
    parts: Sequence[Part],
    numbers: Sequence[int],
    given: Mapping[Variant, Part],
    draw: Draw | None,
) -> Variants:
    """A table of some rows, by their numbers."""
    taken = tuple(column.taken(numbers) for column in columns)
    return Variants(taken, tuple(parts[k] for k in numbers), given, draw)


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


def written_of(table: Variants, name: Variant) -> dict[str, Any]:
    """Values of a row along its dimensions, as the scene writes them."""
    texts = {column.name: column.text_of for column in table.columns}
    return {path: texts[path][value] for path, value in name}


def _numbers(count: int, is_drawn: bool = False) -> Column:
    """Numbers of rows that are no full product."""
    return Column(VARIANT, tuple(range(count)), is_drawn=is_drawn, meaning=ROWS[VARIANT])


def surfaces(seeds: Sequence[int]) -> Variants:
    """The scene on random surfaces, by their seeds."""
    if not seeds:
        return Variants()
    column = Column("realization", tuple(seeds), is_drawn=True, meaning=ROWS["realization"])
    return Variants((column,), tuple((("roughness.seed", seed),) for seed in seeds))


def drawn_rows(draw: Draw, count: int) -> Variants:
    """Samples of inputs that are not known exactly, each with its own velocity."""
    values, velocities = draw.design.draw(count)
    meaning = "value of an input that is not known exactly"
    sample = Column("sample", tuple(range(count)), "1", VARIANT, meaning=ROWS["sample"])
    inputs = (
        Column(one.path, tuple(column), one.unit, VARIANT, meaning=meaning)
        for one, column in zip(draw.design.inputs, values.T.tolist(), strict=True)
    )
    words = "sliding velocity of the sample"
    velocity = Column("velocity", tuple(velocities.tolist()), "m/s", VARIANT, meaning=words)
    columns = (_numbers(count, is_drawn=True), sample, *inputs, velocity)
    return Variants(columns, ((),) * count, draw=draw)


def placed_rows(
    parts: Sequence[Part],
    columns: Sequence[Column],
    loads: Sequence[float],
    velocities: Sequence[float],
) -> Variants:
    """Rows with a place each."""
    numbers = _numbers(len(parts))
    places = [("load", loads, "N"), ("velocity", velocities, "m/s")]
    along = [
        *(replace(column, along=VARIANT) for column in columns),
        *(Column(k, tuple(held), u, VARIANT, meaning=f"{k} of the row") for k, held, u in places),
    ]
    return Variants((numbers, *along), tuple(parts))


def rows(
    name: str,
    changes: Mapping[Label, Mapping[str, Any]],
    velocities: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
) -> Variants:
    """Rows by hand: by label what each changes, as ``pin.radius``, and its place [SI], if any."""
    labels = tuple(changes)
    own = [
        Column(axis, tuple(map(float, values)), unit, name, meaning=f"{axis} of each {name}")
        for axis, values, unit in (("velocity", velocities, "m/s"), ("load", loads, "N"))
        if values is not None
    ]
    unit = None if isinstance(labels[0], str) else "1"
    key = Column(name, labels, unit, meaning=f"{name} of the scene")
    return Variants((key, *own), tuple(tuple(change.items()) for change in changes.values()))
