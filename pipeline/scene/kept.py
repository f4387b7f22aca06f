"""A sweep as the text that a store keeps of it: its entries in full, and rows that replace some.

The text is JSON that a person can read. What was read of files lies beside it, by its digest.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from typing import Any

import tribo
from pipeline.scene.parts import Contents
from pipeline.scene.reading import SceneReader, contents_of
from pipeline.scene.units import to_si
from pipeline.sweep.about import FromLibrary
from pipeline.sweep.model import Sweep
from pipeline.sweep.remarks import Remark
from pipeline.sweep.selection import Selection
from pipeline.sweep.stations import Stations
from pipeline.sweep.variants import Column, Row, Variants
from tribo import InputError
from tribo.types import Array


class SweepTextError(InputError):
    """Text that is not that of a sweep."""


def sweep_text(sweep: Sweep) -> str:
    """JSON of a sweep."""
    table, selection = sweep.variants, sweep.selection
    columns = {one.name: asdict(one) for one in table.columns}
    text = {
        "name": sweep.name,
        "entries": sweep.entries,
        "columns": {k: {n: v for n, v in one.items() if v} for k, one in columns.items()},
        "rows": _rows(table) if columns else (),
        "notes": sweep.notes,
        "sources": sweep.sources,
        "selection": selection and asdict(replace(selection, choices=(), points=())),
        "stations": sweep.stations and asdict(sweep.stations),
        "samples": table.draw,
        "chosen": None if sweep.chosen is None else True,
    }
    told = {key: value for key, value in text.items() if value}
    return json.dumps(told, ensure_ascii=False)


def _rows(table: Variants) -> Any:
    """Rows; those of samples by columns, and numbers with their units."""
    first = table.rows[0].values
    if not table.draw or any(row.values.keys() != first.keys() for row in table.rows):
        keys = {one.name: one.key for one in table.columns}
        pairs = ((row.labels, table.values(name)) for name, row in table.by_name.items())
        return [
            {name: label for name, label in labels.items() if keys[name] not in values} | {**values}
            for labels, values in pairs
        ]
    columns: dict[str, Any] = {path: [row.values[path] for row in table.rows] for path in first}
    for one in table.columns:
        if one.key not in first:
            labels = table.labels(one.name)
            is_number = "." in one.name
            columns[one.name] = {"unit": one.unit, "values": labels} if is_number else labels
    return columns


def _unpacked(rows: Any) -> Iterator[tuple[Mapping[str, Any], Mapping[str, float]]]:
    """Rows as they are written, each with those of its labels that are known [SI]."""
    if isinstance(rows, list):
        yield from ((row, {}) for row in rows)
        return
    known = {key: one["values"] for key, one in rows.items() if isinstance(one, dict)}
    others = {key: one for key, one in rows.items() if key not in known}
    for number, row in enumerate(zip(*others.values(), strict=True)):
        labels = {key: values[number] for key, values in known.items()}
        yield dict(zip(others, row, strict=True)), labels


def files_of(sweep: Sweep) -> dict[str, Array]:
    """What was read of files for a sweep, by its digests."""
    held: Any = sweep.reader
    values = itertools.chain(*(row.values.items() for row in sweep.rows))
    rows = (value for path, value in values if path.endswith(".content") and value)
    digests = dict.fromkeys([*contents_of(sweep.parts()).values(), *rows])
    return {digest: held.contents.arrays[digest] for digest in digests}


def text_sweep(text: str, arrays: Mapping[str, Array]) -> Sweep:
    """Read a sweep from its JSON, and from no file; raise a `SweepTextError` for any other text."""
    try:
        told = json.loads(text)
        sweep = Sweep(
            name=str(told["name"]),
            written=told["entries"],
            reader=SceneReader(Contents(dict(arrays)), is_stored=True),
            variants=_variants(told),
            notes=tuple(Remark(*one) for one in told.get("notes", ())),
            sources=tuple(FromLibrary(*one) for one in told.get("sources", ())),
            selection=_selection(told.get("selection")),
            stations=_stations(told.get("stations")),
            chosen=() if "chosen" in told else None,
        )
        sweep.parts()
    except Exception as error:  # a forged text may fail in any way, and is one error
        raise SweepTextError(f"it is not the text of a sweep: {error}") from error
    return sweep


def _variants(told: Any) -> Variants:
    columns = tuple(
        Column(**one | {"unit": one.get("unit")}) for one in told.get("columns", {}).values()
    )
    rows = (
        Row(
            {
                one.name: known[one.name] if one.name in known else _label(one, row[one.key])
                for one in columns
            },
            {path: value for path, value in row.items() if "." in path},
        )
        for row, known in _unpacked(told.get("rows", [{}]))
    )
    return Variants(columns, tuple(rows), told.get("samples"))


def _label(column: Column, value: Any) -> Any:
    """Label of a row, by its text [SI]."""
    if column.unit is None:
        return str(value)
    if isinstance(value, str):
        return to_si(value, like=value)
    return float(value) if "." in column.name else value


def _selection(told: Any) -> Selection | None:
    return told and Selection(**told | {"fidelity": tribo.Fidelity(**told["fidelity"])})


def _stations(told: Any) -> Stations | None:
    return told and Stations(**told | {"holds": tuple(told["holds"])})
