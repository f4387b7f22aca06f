"""Entries with several values: ``[sweep] over``, by the paths of entries.

Every combination is read as if its values stood in the file, or were given by ``--set``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from pipeline.scene.declare import table_of
from pipeline.scene.document import Document, Extend
from pipeline.scene.faults import Faults, quoted
from pipeline.scene.format import OilTable
from pipeline.scene.parts import Parts
from pipeline.scene.source import Source
from pipeline.scene.units import UnitError, si_unit, to_si
from pipeline.sweep.limits import MOST_SCENES
from pipeline.sweep.model import Sweep, digest
from pipeline.sweep.remarks import remarks
from pipeline.sweep.tables import entry_at, flat, replace_values
from pipeline.sweep.variants import VARIANT, Column, Label, Row, Variants, dimension_of
from tribo import InputError

_LIKE = {"oil": "oil.like"}
"""Entry of a table that may be given by a name of the library."""
_FIXED = ("sweep", "title", "caveat", "extends", "without", "measured", "tested")
"""Entries and tables that cannot take several values."""


def begin(document: Document, faults: Faults) -> tuple[Document, Extend]:
    """Make the first value of each entry in ``sweep.over`` the entry's default.

    Returns the document, and the function that adds the variants to a sweep.
    """
    over = entry_at(document.entries(), "sweep.over")
    listed = flat(over) if isinstance(over, dict) else ()
    return document.defaulted({p: v[0] for p, v in listed if isinstance(v, list) and v}), _extend


def _extend(sweep: Sweep) -> Sweep:
    """The sweep with a variant for each combination of values; `InputError` for a fault."""
    source: Source = sweep.source
    over = source.parts.declared.sweep.over
    if not over:
        return sweep
    if (count := math.prod(map(len, over.values()))) > MOST_SCENES:
        raise InputError(f"sweep.over: {count} values are too many; give {MOST_SCENES} at most")
    table = Variants()
    for path, values in over.items():
        labels, unit = labels_of(values)
        pairs = [*zip(labels, values, strict=True)]
        if unit is not None:  # quantities ascend, texts keep their order
            pairs.sort(key=lambda pair: pair[0])
        key, others = path, dict[str, None]()
        if path in _LIKE:  # a name of the library, which replaces the whole table
            key, others = _LIKE[path], {f"{path}.{one}": None for one in table_of(OilTable).keys}
        name, entry = dimension_of(path), _LIKE.get(path, path)
        column = Column(name, unit, meaning=f"{path} of the scene", entry=entry)
        rows = [Row({name: label}, {**others, key: value}) for label, value in pairs]
        table *= Variants((column,), tuple(rows))
    made = with_rows(sweep, table, "sweep.over")
    bases = [digest(made._take(name).base) for name in made.variants.given]
    if len({*bases}) == 1 < len(bases):
        raise InputError(f"sweep.over: {' and '.join(over)} changes nothing here; leave it out")
    return made


def labels_of(values: Sequence[Any]) -> tuple[tuple[Label, ...], str | None]:
    """Convert the values of an entry to labels, and return the labels and their unit.

    The labels are numbers in SI, and the unit is their SI unit, "1" for plain numbers. If a value
    is not a number or a quantity, all labels are texts, and the unit is None.
    """
    first = values[0]
    try:
        if isinstance(first, str):
            return tuple(to_si(str(value), like=first) for value in values), si_unit(first)
        return tuple(map(float, values)), "1"
    except (UnitError, TypeError, ValueError):
        return tuple(map(str, values)), None


def notes_on_first_values(table: Variants) -> Iterator[str]:
    """Yield a note on each entry with several values in the `table` of variants.

    A command uses only the first of them.
    """
    for column in table.chosen:
        key, what = "over", f"{column.name} is the scene's own or the first listed"
        if column.name == VARIANT:
            key, what = "along", "values are the scene's own or those of its first row"
        yield from remarks("note", f"sweep.{key} is ignored here; {what}; choose another by --set")


def with_rows(sweep: Sweep, table: Variants, key: str) -> Sweep:
    """Add the variants in `table` to a sweep, as its outer axis.

    If a row names a material or oil of the library, the library's values are added to the row. If a
    row names a file, the SHA-256 of this file is added. Raises an `InputError` for the first faulty
    row. Its message names `key`, the entry of the scene that asks for these variants.
    """
    for path in table.rows[0].values:
        if path.partition(".")[0] in _FIXED:
            raise InputError(
                f"{key}.{quoted(path)}: this cannot take several values; give an entry of the "
                'scene, such as "pin.radius"'
            )
    source: Source = sweep.source
    base = source.parts
    rows = list[Row]()
    for row in table.rows:
        written = replace_values(source.written, row.values)
        given = {path: one for path, one in row.values.items() if one is not None}
        try:
            parts = source.reader.read(written)
            _require_alike(parts, base)
        except InputError as error:
            words = ", ".join(f"{path} = {quoted(value)}" for path, value in given.items())
            raise InputError(f"{key}: {words}: {error}") from error
        own = source.reader.complete_changes(given, written, parts, sweep.entries, base)
        rows.append(row._replace(values=own))
    variants = replace(table, rows=tuple(rows)) * sweep.variants
    return source.read_again(sweep, source.written, variants)


def _require_alike(row: Parts, base: Parts) -> None:
    """Raise an `InputError` if a variant (`row`) stores other variables than the sweep (`base`)."""
    has_fields = base.declared.sweep.fields
    for name, is_other in (
        ("unequal bulks", row.case.scene.unequal_bulks != base.case.scene.unequal_bulks),
        ("grid of the stored fields", has_fields and row.case.scene.grid != base.case.scene.grid),
    ):
        if is_other:
            raise InputError(
                f"this changes the {name}, which must be the same for all values; sweep each "
                "value into a separate store"
            )
