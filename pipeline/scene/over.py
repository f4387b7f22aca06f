"""Entries with several values: ``[sweep] over``, by the paths of entries.

Every combination is read as if its values stood in the file, or were given by ``--set``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from pipeline.scene.declare import table_of
from pipeline.scene.document import Document
from pipeline.scene.extensions import Extend, Reading
from pipeline.scene.faults import Faults, quoted
from pipeline.scene.format import Oil
from pipeline.scene.reading import contents_of
from pipeline.scene.units import UnitError, si_unit, to_si
from pipeline.sweep.limits import MOST_SCENES
from pipeline.sweep.model import Parts, Sweep
from pipeline.sweep.remarks import remarks
from pipeline.sweep.tables import entry_at, flat, replace_values
from pipeline.sweep.variants import VARIANT, Column, Label, Variant, Variants
from tribo import InputError

_LIKE = {"oil": "oil.like"}
"""Entry of a table that is given by the name of one of the library."""
_FIXED = ("sweep", "title", "extends", "without", "measured", "tested", "unknown")


def begin(document: Document, faults: Faults) -> tuple[Document, Extend]:
    """The document with the first values as its lowest layer, and what makes their table."""
    over = entry_at(document.entries(), "sweep.over")
    listed = flat(over) if isinstance(over, dict) else ()
    return document.above({path: v[0] for path, v in listed if isinstance(v, list) and v}), _extend


def _extend(sweep: Sweep, reading: Reading) -> Sweep:
    """The sweep with a row for every combination; `InputError` at the first that is unfit."""
    asked = reading.scene.sweep.over
    if not asked:
        return sweep
    axes = {path: _axis(path, values) for path, values in asked.items()}
    if (count := math.prod(len(axis) for _, axis in axes.values())) > MOST_SCENES:
        raise InputError(f"sweep.over: {count} values are too many; give {MOST_SCENES} at most")
    listed = [axis for _, axis in axes.values()]
    rows = [dict(zip(axes, pairs, strict=True)) for pairs in itertools.product(*listed)]
    columns = tuple(
        replace(
            column,
            values=tuple(row[path][0] for row in rows),
            entry="oil.like" if path == "oil" else "",
        )
        for path, (column, _) in axes.items()
    )
    written = tuple(
        {key: one for path, (_, text) in row.items() for key, one in _entries(path, text)}
        for row in rows
    )
    made = with_rows(sweep, Variants(columns, written), "sweep.over")
    scenes = [made.variant(name) for name in made.variants.given]
    read = [(scene.scene, scene.conditions, scene.about) for scene in scenes]
    if len(read) > 1 and all(one == read[0] for one in read):
        raise InputError(
            f"sweep.over: {' and '.join(asked)} changes nothing in this scene; leave it out"
        )
    return made


def _entries(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """What a value of an entry replaces: the name of an oil its whole table."""
    if path in _LIKE:
        yield from ((f"{path}.{key}", None) for key in table_of(Oil).keys)
    yield _LIKE.get(path, path), value


def notes_on_first_values(table: Variants) -> Iterator[str]:
    """Notes that a command prints which computes one value of each entry alone."""
    for column in table.chosen:
        words = (
            f"sweep.over is ignored here; {column.name} is the scene's own or the first listed: "
            f'--set "{column.name}=..." takes another'
        )
        if column.name == VARIANT:
            words = (
                "sweep.along is ignored here; the scene's own values are taken, or those of its "
                "first row: --set takes others"
            )
        yield from remarks("note", words)


def column_of(path: str, values: Sequence[Any], owner: str) -> Column:
    """Values of an entry in SI, or words where they are not of one dimension."""
    meaning, first = f"{path} of the {owner}", values[0]
    try:
        if isinstance(first, str):
            in_si = tuple(to_si(str(value), like=first) for value in values)
            return Column(path, in_si, si_unit(first), meaning=meaning)
        return Column(path, tuple(map(float, values)), meaning=meaning)
    except (UnitError, TypeError, ValueError):
        return Column(path, tuple(map(str, values)), None, meaning=meaning)


def _axis(path: str, values: tuple[Any, ...]) -> tuple[Column, list[tuple[Label, Any]]]:
    """An entry, and its values in SI in rising order, or as words, each beside its text."""
    key = f"sweep.over.{quoted(path)}"
    if path.partition(".")[0] in _FIXED:
        raise InputError(
            f"{key}: this cannot take several values; give an entry of the scene, such as "
            '"pin.radius"'
        )
    if len({isinstance(value, str) for value in values}) > 1:
        raise InputError(f"{key}: {quoted(list(values))}: give all with a unit, or none")
    column = column_of(path, values, "scene")
    pairs = [*zip(column.values, values, strict=True)]
    if column.unit is None:
        return column, pairs
    pairs.sort(key=lambda pair: pair[0])
    for (one, text), (other, again) in itertools.pairwise(pairs):
        if one == other:
            both = f"{quoted(text)} and {quoted(again)}"
            raise InputError(f"{key}: {both} are the same; give each value once")
    return column, pairs


def with_rows(sweep: Sweep, table: Variants, key: str) -> Sweep:
    """The sweep with rows in front of its own; raises at the first that is faulty.

    What was read of a file for a row is named in it.
    """
    made, rows = replace(sweep, variants=table, made=dict(sweep.made)), []
    for name in table.names:
        row = dict(table.row(name))
        words = ", ".join(f"{path} = {quoted(value)}" for path, value in row.items() if "." in path)
        try:
            parts = made.parts(name)
        except InputError as error:
            raise InputError(f"{key}: {words}: {error}") from error
        require_alike(made.variant(name), sweep, f"{key}: {words}")
        written, contents = replace_values(made.written, row), contents_of(parts)
        read = {path: one for path, one in contents.items() if entry_at(written, path) != one}
        rows.append(row | read)
    table = replace(table, rows=tuple(rows))
    kept: dict[Variant, Parts] = {(): made.parts()}
    kept = kept if sweep.variants.columns else made.made
    return replace(sweep, variants=table * sweep.variants, made=kept)


def require_alike(scene: Sweep, sweep: Sweep, place: str) -> None:
    """Raise an `InputError` if a row of a sweep has other axes."""
    first, second = ((s.plane, s.scene.unequal_bulks, s.record.steps) for s in (scene, sweep))
    names = "loads and velocities", "unequal bulks", "steps"
    for name, one, other in zip(names, first, second, strict=True):
        if one != other:
            raise InputError(
                f"{place} changes the {name}, which must be the same for all values; sweep each "
                "value into a separate store"
            )
    if sweep.record.fields and scene.scene.grid != sweep.scene.grid:
        raise InputError(
            f"{place} changes the grid of the stored fields, which every value has in common; "
            "leave out sweep.fields, or give an entry that keeps the grid"
        )
