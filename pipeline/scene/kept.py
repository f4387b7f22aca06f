"""A sweep as the text that a store keeps of it: its entries in full, and rows that replace some.

The text is JSON that a person can read. What was read of files lies beside it, by its digest.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
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
    keys = {one.name: one.key for one in table.columns}
    rows = [
        {name: label for name, label in labels.items() if keys[name] not in values} | {**values}
        for labels, values in table.rows
    ]
    text = {
        "name": sweep.name,
        "entries": sweep.entries,
        "columns": {k: {n: v for n, v in one.items() if v} for k, one in columns.items()},
        "rows": (_packed(rows, table) if table.draw else rows) if columns else (),
        "notes": sweep.notes,
        "sources": sweep.sources,
        "selection": selection and asdict(replace(selection, choices=(), points=())),
        "stations": sweep.stations and asdict(sweep.stations),
        "samples": table.draw,
        "chosen": None if sweep.chosen is None else True,
    }
    told = {key: value for key, value in text.items() if value not in (None, (), {})}
    return json.dumps(told, ensure_ascii=False)


def _packed(rows: Sequence[Mapping[str, Any]], table: Variants) -> Any:
    """Rows of samples by columns: numbers [SI] with a unit, or values as they are."""
    if len({tuple(row) for row in rows}) > 1:
        return rows
    packed: dict[str, Any] = {key: [row[key] for row in rows] for key in rows[0]}
    for key, values in packed.items():
        unit, numbers = str(values[0]).partition(" ")[2], table.labels(key)
        if numbers and values == [f"{number!r} {unit}" for number in numbers]:
            packed[key] = {"unit": unit, "values": numbers}
    return packed


def _unpacked(rows: Any) -> Iterator[tuple[Mapping[str, Any], Mapping[str, float]]]:
    """Rows as they are written, each with those of its labels that are known [SI]."""
    if isinstance(rows, list):
        yield from ((row, {}) for row in rows)
        return
    known = {key: one["values"] for key, one in rows.items() if isinstance(one, dict)}
    written = {
        key: [f"{x!r} {rows[key]['unit']}" for x in known[key]] if key in known else one
        for key, one in rows.items()
    }
    for number, row in enumerate(zip(*written.values(), strict=True)):
        labels = {key: values[number] for key, values in known.items()}
        yield dict(zip(written, row, strict=True)), labels


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
