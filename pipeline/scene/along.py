"""Tables of operating points, and rows of ``[sweep] along``, which may also set entries."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated as A
from typing import Any

import numpy as np

from pipeline.paths import user_path
from pipeline.scene.choices import NO_CHOICES, Choices, TableFile, choices_of, read_sheet
from pipeline.scene.decimals import Typed
from pipeline.scene.declare import Declared, Table, table_of
from pipeline.scene.document import Document, Extend
from pipeline.scene.faults import Faults, quoted
from pipeline.scene.format import SceneFile
from pipeline.scene.kinds import BULK, CRITICAL, FRICTION, LOAD, SPEED, Share
from pipeline.scene.lines import Lines, SheetRow
from pipeline.scene.names import UNITS, Heading
from pipeline.scene.over import labels_of, with_rows
from pipeline.scene.sheet import Sheet, Written
from pipeline.scene.units import as_entry
from pipeline.sweep.conditions import FIELDS
from pipeline.sweep.limits import MOST_PLACES, MOST_SCENES
from pipeline.sweep.measurement import Place
from pipeline.sweep.model import Sweep
from pipeline.sweep.tables import CURVE, entry_at, flat
from pipeline.sweep.tables import FRICTION as COEFFICIENT
from pipeline.sweep.variants import PLACE_UNITS, Column, Row, dimension_of, numbered_rows
from tribo import InputError


class _ConditionsTable(Declared):
    load: A[float, LOAD]
    velocity: A[float, SPEED]
    friction: A[float | None, FRICTION] = None
    bulk_temperature: A[float | None, BULK] = None
    critical_temperature: A[float | None, CRITICAL] = None
    failing_share: A[float | None, Share(at_least=0, below=1)] = None


_PLACE = Table({name: table_of(_ConditionsTable).keys[name] for name in ("load", "velocity")})
_UNITS = {name: UNITS[name] for name in table_of(_ConditionsTable).keys}
CONDITIONS = {name: FIELDS[name] for name in _UNITS if name not in _PLACE.keys}
"""Conditions that each row may set, and their entries in a scene."""
_TABLES = tuple(f"{name}." for name in table_of(SceneFile).keys)
"""Beginnings of the key paths of entries, such as ``pin.``."""


@dataclass(frozen=True, slots=True)
class OperatingPoints:
    """Operating points, loads [N] and velocities [m/s], and other columns of their table.

    `conditions` has friction, bulk and critical temperature [K] of each point, if the table gives
    them. `counted` states how many rows were used and left out.
    """

    places: tuple[Place, ...]
    others: Mapping[str, Sequence[Any]]
    conditions: tuple[Mapping[str, float], ...] = ()
    remarks: tuple[str, ...] = ()  # columns that change no verdict, and sheets that were not read
    counted: str = ""  # rows used and left out, with the reasons, if any is left out

    @property
    def rows(self) -> list[tuple[Place, Mapping[str, float]]]:
        """Place and conditions of each row."""
        return [*zip(self.places, self.conditions or ({},) * len(self.places), strict=True)]

    @classmethod
    def read(
        cls,
        source: str | os.PathLike[str] | Mapping[str, Sequence[Any]],
        choices: Choices = NO_CHOICES,
        written: Written = "Python",
    ) -> OperatingPoints:
        """Read a file as CSV or Excel, or columns by heading, such as a data frame.

        `choices` are those of the user on columns and rows, and messages name them as `written`.
        Units are in the heading or in each cell; bare numbers of a mapping are in SI. Rows at rest,
        or without a load or a velocity, are left out and counted. An `InputError` lists all faults,
        by row and column.
        """
        listed = {} if isinstance(source, str | os.PathLike) else columns_of(source)
        given = Path(source) if isinstance(source, str | os.PathLike) else lines_of(listed)
        sheet = read_sheet(given, _UNITS, _PLACE.keys, _PLACE.keys, choices, written, MOST_PLACES)
        _, rows = sheet.entries(_ConditionsTable)
        sheet.faults[:0] = _column_faults(sheet)
        sheet.refuse_faults("load [N],velocity [m/s]")
        used = [sheet.places[name] for name in _PLACE.keys]
        others = {
            heading.text: [row.cells[k] for row in sheet.rows]
            for k, heading in enumerate(sheet.headings)
            if heading.text and k not in used
        }
        for head in others.keys() & listed.keys():  # as given by the caller, not as text
            others[head] = [listed[head][row.number - 1] for row in sheet.rows]
        conditions = tuple(
            {name: row[name] for name in CONDITIONS if row.get(name) is not None} for row in rows
        )
        places = tuple((row["load"], row["velocity"]) for row in rows)
        beside = ", ".join(sheet.unused)
        remarks = [f"columns shown, but not judged by: {beside}"] * bool(beside)
        remarks += filter(None, [sheet.other_sheets])
        bulk = sheet.heading("bulk_temperature") if "bulk_temperature" in sheet.places else None
        if bulk and bulk.name != "bulk_temperature":  # that of the oil
            taken = f"column {quoted(bulk.text)} is taken as the bulk temperature of both bodies"
            remarks.insert(0, taken)
        return cls(places, others, conditions, tuple(remarks), sheet.counted)


def columns_of(columns: Any) -> dict[str, list[Any]]:
    """Convert the columns of a mapping or a data frame to lists of values, by heading.

    Raises an `InputError` if `columns` is of another type, or the columns differ in length.
    """
    if not hasattr(columns, "keys"):
        raise InputError(
            f"points are of type {type(columns).__name__}; give a .csv or .xlsx file, or columns "
            'by heading such as {"load": ["500 N"], "velocity": ["2 m/s"]}'
        )
    listed = {str(head): np.atleast_1d(columns[head]).tolist() for head in columns}
    if len({*map(len, listed.values())}) > 1:
        counts = ", ".join(f"{head} {len(cells)}" for head, cells in listed.items())
        raise InputError(f"points: columns of unlike lengths: {counts}; give equal lengths")
    return listed


def lines_of(columns: Mapping[str, Sequence[Any]]) -> Lines:
    """Convert `columns`, values by heading, to the rows of a table, with all cells as text.

    The first row has the headings. Numbers without a unit are taken to be in SI.
    """
    heads = []
    for head, cells in columns.items():
        heading = Heading.of(head)
        is_bare = not (heading.unit or any(isinstance(cell, str) for cell in cells))
        unit = UNITS.get(heading.name) if is_bare else ""
        heads.append(f"{head} [{unit}]" if unit else head)
    rows = enumerate(zip(*columns.values(), strict=True), 1)
    texts = (SheetRow(number, [*map(_cell_text, row)]) for number, row in rows)
    return Lines([SheetRow(0, heads), *texts], [])


def _cell_text(value: Any) -> str:
    """Text of a value in Python, where points mark decimals."""
    text = "" if value is None else str(value)
    return text if "," in text else Typed(text)


def _column_faults(sheet: Sheet) -> Iterator[str]:
    """Yield a message for each repeated heading, and each column that would need a simulation."""
    heads = [heading.text for heading in sheet.headings if heading.text]
    for head in dict.fromkeys(head for head in heads if heads.count(head) > 1):
        yield f'column "{head}" appears twice; give each heading once'
    for heading in sheet.headings:
        is_entry = heading.name == "hold" or heading.title.startswith(_TABLES)
        if is_entry and heading.text in sheet.unused:
            yield (
                f'column "{heading.text}" cannot act after the simulation; leave it out, or name '
                "the table as sweep.along of a scene, so that each row is simulated"
            )


def begin(document: Document, faults: Faults) -> tuple[Document, Extend | None]:
    """Add defaults for the rows of ``sweep.along`` to a document, and prepare their variants.

    The defaults are the loads and velocities of all rows, and the entries of the first row. Returns
    the document, and the function that adds a variant for each row to a sweep. The function is None
    if there are no rows, or a row is faulty.
    """
    written = entry_at(document.entries(), "sweep.along")
    rows = list[dict[str, Any]]()
    if (isinstance(written, str) and written) or isinstance(written, dict):
        rows = _file_rows(document.file_of("sweep.along").parent, written, faults)
    elif isinstance(written, list) and all(isinstance(row, dict) for row in written):
        rows = [dict(flat(row)) for row in written]
    rows = [{CONDITIONS.get(head, head): cell for head, cell in row.items()} for row in rows]
    before = len(faults)
    loads, velocities = set[float](), set[float]()
    for number, row in enumerate(rows):
        if other := row.keys() ^ rows[0].keys():
            problem = f"not all rows have {', '.join(sorted(other))}; give it in each"
            faults.refuse(f"sweep.along[{number}]", problem)
        place = {name: row[name] for name in _PLACE.keys.keys() & row.keys()}
        read = _PLACE.read(place, f"sweep.along[{number}]", faults)
        loads.add(read["load"])
        velocities.add(read["velocity"])
    if not rows or len(faults) > before:
        return document, None
    places = {
        "sweep.loads": [f"{load!r} N" for load in sorted(loads)],
        "sweep.velocities": [f"{velocity!r} m/s" for velocity in sorted(velocities)],
    }
    first = {path: value for path, value in rows[0].items() if "." in path}  # no labels
    return document.defaulted(places | first), partial(_extend, rows)


def _extend(rows: list[dict[str, Any]], sweep: Sweep) -> Sweep:
    """The sweep with a variant for each of `rows` (entries by path); `InputError` for a fault."""
    if len(rows) > MOST_SCENES:
        raise InputError(f"sweep.along: {len(rows)} rows are too many; give {MOST_SCENES} at most")
    heads = sorted(rows[0], key=lambda head: head in PLACE_UNITS)
    found = {head: labels_of([row[head] for row in rows]) for head in heads}
    columns = [
        Column(
            dimension_of(head) if "." in head else head,
            PLACE_UNITS.get(head, unit),
            meaning=f"{head} of the row",
            entry=head if "." in head else "",
        )
        for head, (_, unit) in found.items()
    ]
    # A friction measured at one place replaces curves of friction.
    curves = {CURVE: None} if COEFFICIENT in found else {}
    table = (
        Row(
            {column.name: found[column.key][0][k] for column in columns},
            curves | {path: value for path, value in row.items() if "." in path},
        )
        for k, row in enumerate(rows)
    )
    return with_rows(sweep, numbered_rows(columns, table), "sweep.along")


def _file_rows(folder: Path, file: str | dict[str, Any], faults: Faults) -> list[dict[str, Any]]:
    """Read rows of a file as entries by heading; empty if a row is faulty."""
    kind, before = table_of(TableFile), len(faults)
    read = kind.read(file, "sweep.along", faults) if isinstance(file, dict) else file
    if len(faults) > before:
        return []
    name, choices = choices_of(read)
    path = folder / user_path(name)
    try:
        sheet = read_sheet(path, _UNITS, _PLACE.keys, _PLACE.keys, choices, most=MOST_SCENES)
    except InputError as error:
        faults.refuse("sweep.along", str(error))
        return []
    names = {place: name for name, place in sheet.places.items()}
    tables = [dict[str, Any]() for _ in sheet.rows]
    for place, heading in enumerate(sheet.headings):
        for (number, cells), table in zip(sheet.rows, tables, strict=True):
            if heading.text and place not in sheet.sources:
                if not cells[place]:
                    sheet.faults.append(f"row {number}, column {quoted(heading.text)} is empty")
                table[names.get(place, heading.title)] = as_entry(cells[place], heading.unit)
    for fault in sheet.told_faults:
        faults.refuse("sweep.along", f"{path}: {fault}")
    for note in filter(None, (sheet.other_sheets, sheet.counted)):
        faults.note("sweep.along", f"{path.name}, {note}")
    if not tables and not sheet.faults:
        faults.refuse("sweep.along", f"{path} has no rows; give a load and a velocity in each")
    return [] if sheet.faults else tables
