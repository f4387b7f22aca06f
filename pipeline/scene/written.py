"""Entries as text: a scene in full and in the user's units, which reads as the same scene."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import tribo
from pipeline.quantities import DIMENSIONS, ZERO, display
from pipeline.quantities import UNITS as VARIABLE_UNITS
from pipeline.scene.declare import ByPath, Each, Either, List, Table, Tables, attribute_of, table_of
from pipeline.scene.fidelity import FidelityTable, complete_fidelity
from pipeline.scene.kinds import Kind, Quantity
from pipeline.scene.units import si_unit, to_si, typeset
from pipeline.sweep.conditions import PATHS
from pipeline.sweep.model import Sweep
from pipeline.sweep.tables import Entries, flat

_FEWEST, _MOST = 6, 17  # fewest and most digits of a number


def entries_of(kind: Kind, value: Any) -> Any:
    """Convert a value in SI to what a scene file would say for it, such as the text "600 N".

    `kind` says how the entry is read: as a quantity, list or table, for example. A list gives a
    list of converted values, a table a dictionary of them. The result is None if `value` is None,
    infinite or an empty tuple, or `kind` is `ByPath` without texts: a scene file then leaves out
    the entry.
    """
    match kind:
        case _ if value is None or value == math.inf or (isinstance(value, tuple) and not value):
            return None
        case Either():
            return entries_of(form_of(kind, value), value)
        case Table(keys):
            found = (
                (key, one.kind, getattr(value, attribute_of(key))) for key, one in keys.items()
            )
            texts = {key: entries_of(of, one) for key, of, one in found}
            return {key: text for key, text in texts.items() if text is not None}
        case List(of):
            return [entries_of(of, one) for one in value]
        case Each(kinds):
            return [*map(entries_of, kinds, value)]
        case Tables(of):
            return {key: entries_of(of, one) for key, one in value.items()}
        case ByPath():  # such tables are stored as rows, or as the user wrote them
            return None
        case Quantity():
            return _quantity_text(kind, value)
    return value


def keep_written(tables: Any, written: Any) -> Any:
    """Copy of `tables` in which entries that the user has `written` stand as written.

    Both are nested tables, lists or single values. Other entries stay as in `tables`.
    """
    match tables, written:
        case dict(), dict():
            return {key: keep_written(value, written.get(key)) for key, value in tables.items()}
        case list(), list() if len(tables) == len(written):
            return [*map(keep_written, tables, written)]
        case dict(), _:
            return tables
    return tables if written is None else written


def with_fidelity(sweep: Sweep, made: tribo.Fidelity, preset: str | None = None) -> Sweep:
    """The sweep with numerical choices replaced by `made`; `preset` is their name, or None."""
    choices = entries_of(table_of(FidelityTable), complete_fidelity(preset, made))
    return sweep.changed("fidelity", choices)


def scene_entries(sweep: Sweep, entries: Entries | None = None) -> dict[str, str]:
    """Text of each entry's value, by the path of the entry.

    The entries are those of the sweep, or `entries` if given. In both cases, the conditions in
    `Sweep.judged` replace the entries that have the same paths. The title and seeds of several
    surfaces are left out.
    """
    left_out = {"title", *(one.key for one in sweep.variants.columns if one.is_seed)}
    leaves = _leaves(entries or sweep.entries)
    texts = {path: in_words(value) for path, value in leaves if path not in left_out}
    named = {PATHS[name]: (name, one) for name, one in sweep.judged.items() if name in PATHS}
    return texts | {
        path: display(one, VARIABLE_UNITS.get(name, "")) if isinstance(one, float) else str(one)
        for path, (name, one) in named.items()
    }


def differing_entries(one: Sweep, other: Sweep) -> Iterator[tuple[str, str, str]]:
    """Yield path and both values, in words, of each entry whose meaning differs between sweeps."""
    sweeps = one, other
    words = [scene_entries(sweep) for sweep in sweeps]
    sources = [sweep.source for sweep in sweeps]
    # In usual units, not as written.
    read = [source.reader.complete({}, source.parts) for source in sources]
    plain = [scene_entries(*pair) for pair in zip(sweeps, read, strict=True)]
    for path in {**words[0], **words[1]}:
        if plain[0].get(path) != plain[1].get(path):
            yield path, words[0].get(path, ""), words[1].get(path, "")


def _leaves(tables: Any) -> Iterator[tuple[str, Any]]:
    """Yield pairs (path, value) of nested tables; the tables of a list are numbered from 1 on."""
    for path, value in flat(tables):
        if isinstance(value, list) and value and isinstance(value[0], dict):
            inner = {str(number): one for number, one in enumerate(value, 1)}
            yield from ((f"{path}.{place}", one) for place, one in _leaves(inner))
        else:
            yield path, value


def in_words(value: Any) -> str:
    """Write the value of an entry as text for people."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, dict):
        return " ".join(f"{key} {in_words(one)}" for key, one in value.items())
    if isinstance(value, list):
        return ", ".join(map(in_words, value))
    if not isinstance(value, str):
        return f"{value:g}"
    number, _, unit = value.partition(" ")
    is_quantity = unit and number[-1:].isdigit() and "," not in unit
    return f"{number} {typeset(unit)}" if is_quantity else value


def form_of(kind: Either, value: Any) -> Kind:
    """Find by which of the kinds in `kind` a value was read."""
    for one in kind.kinds:
        is_table = isinstance(one, Table) and isinstance(value, one.make)  # type: ignore[arg-type]
        if is_table or (isinstance(one, List) and isinstance(value, tuple)):
            return one
    return kind.kinds[0]


def _quantity_text(kind: Quantity, value: float) -> str:
    """Write a quantity [SI] in its usual unit, with the fewest digits that give back the value."""
    unit, zero = kind.unit, float(ZERO.get(kind.unit, 0))
    one = 1.0 if zero else to_si(f"1 {unit}", kind.example)
    fewest = _FEWEST
    if one == 1 and not zero:  # in SI Python's own text has the fewest digits that give it back
        number, _, _ = repr(float(value)).partition("e")
        fewest = max(_FEWEST, len(number.lstrip("-").replace(".", "").strip("0")))
    texts = (f"{(value - zero) / one:.{digits}g} {unit}" for digits in range(fewest, _MOST + 1))
    exact = f"{value!r} {next(iter(DIMENSIONS[si_unit(kind.example)].units))}"
    return next((text for text in texts if to_si(text, kind.example) == value), exact)
