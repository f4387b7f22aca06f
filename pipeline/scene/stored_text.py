"""The text of a sweep in a store: its entries in full, and rows that replace some of them.

The text is JSON that a person can read. Contents of files are stored beside it, by digest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, get_type_hints

from pipeline.scene.parts import Contents
from pipeline.scene.reading import SceneReader
from pipeline.scene.source import Source, read_sweep
from pipeline.sweep.model import Sweep
from pipeline.sweep.remarks import FromLibrary, Remark
from pipeline.sweep.stations import Stations
from pipeline.sweep.tables import replace_value
from pipeline.sweep.variants import Column, Row, Variants
from tribo import InputError, TriboError
from tribo.surface import array_digest
from tribo.types import Array

FORM = 1
"""Number of the form of the text."""


class SweepTextError(InputError):
    """A text in a store does not describe a sweep."""


def sweep_text(sweep: Sweep) -> str:
    """Write a sweep as JSON text, which `parse_sweep` reads."""
    table = sweep.variants
    values = [row.values for row in table.rows]
    # Loads, velocities, steps and tests may have been replaced since the sweep was read.
    entries, read = {**sweep.entries}, sweep.source.parts.declared.sweep
    if not sweep.tests:
        entries = {k: one for k, one in entries.items() if k not in ("measured", "tested")}
    for name, unit in (("loads", "N"), ("velocities", "m/s")):
        if (present := getattr(sweep, name)) != getattr(read, name):
            quantities = [f"{one!r} {unit}" for one in present]
            entries = replace_value(entries, f"sweep.{name}", quantities)
    for name in ("fields", "steps"):
        if (present := getattr(sweep, name)) != getattr(read, name):
            entries = replace_value(entries, f"sweep.{name}", present)
    text = {
        "form": FORM,
        "name": sweep.name,
        "entries": entries,
        "columns": [asdict(one) | {"values": table.labels(one.name)} for one in table.columns],
        "rows": values if any(values) else (),
        "notes": [*(one for one in sweep.notes if one.grade == "note"), *sweep.doubts],
        "sources": sweep.sources,
        "stations": sweep.stations and asdict(sweep.stations),
    }
    return json.dumps({key: one for key, one in text.items() if one}, ensure_ascii=False)


def file_contents(sweep: Sweep) -> dict[str, Array]:
    """Contents of the files that a scene names, as arrays by their SHA-256."""
    return dict(sweep.source.reader.contents.arrays)


def parse_sweep(text: str, arrays: Mapping[str, Array]) -> Sweep:
    """Read a sweep from the JSON text of `sweep_text`; `SweepTextError` for any other text.

    `arrays` are the contents of the files that the scene names, by SHA-256.
    """
    key = text, tuple(map(array_digest, arrays.values()))
    if (sweep := _KNOWN.get(key)) is None:
        sweep = _KNOWN[key] = _read(text, arrays)
        if len(_KNOWN) > _MOST_KNOWN:
            _KNOWN.pop(next(iter(_KNOWN)), None)
    return sweep


def remember_sweep(text: str, sweep: Sweep) -> None:
    """Let `parse_sweep` return a sweep for its `text`, which then need not be read again."""
    _KNOWN[text, tuple(map(array_digest, file_contents(sweep).values()))] = sweep


_MOST_KNOWN = 8
_KNOWN = dict[tuple[str, tuple[str, ...]], Sweep]()
"""Sweeps by their text and the digests of contents, the last ones that were read."""


def _read(text: str, arrays: Mapping[str, Array]) -> Sweep:
    try:
        read = json.loads(text)
        if read["form"] != FORM:
            raise ValueError(f"it is of form {read['form']}, and not {FORM}")
        name, written, variants = str(read["name"]), dict(read["entries"]), _variants(read)
        notes = tuple(Remark(*one) for one in read.get("notes", ()))
        sources = tuple(FromLibrary(*one) for one in read.get("sources", ()))
        stations = Stations(**read["stations"]) if read.get("stations") else None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise SweepTextError(f"the attribute scene is not the text of a sweep: {error}") from error
    source = Source(written, SceneReader(Contents(dict(arrays)), is_stored=True))
    try:
        return read_sweep(name, source, variants, notes, sources, stations)
    except TriboError as error:  # any other error is a fault of this program
        raise SweepTextError(f"the attribute scene is not the text of a sweep: {error}") from error


def _variants(text: Any) -> Variants:
    """Variants of a sweep from decoded JSON: columns of labels, and the entries to replace."""
    labels = {one["name"]: one["values"] for one in text.get("columns", ())}
    if not labels:
        return Variants()
    fields = ({k: one for k, one in own.items() if k != "values"} for own in text["columns"])
    columns = tuple(Column(**one) for one in fields)
    hints = get_type_hints(Column)
    if not all(isinstance(getattr(one, key), hints[key]) for one in columns for key in hints):
        raise ValueError("a column has values of other types")
    several = [*zip(*labels.values(), strict=True)]
    values = text.get("rows") or [{}] * len(several)
    pairs = zip(several, values, strict=True)
    rows = (Row(dict(zip(labels, own, strict=True)), dict(one)) for own, one in pairs)
    return Variants(columns, tuple(rows))
