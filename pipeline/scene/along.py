"""Tables of operating points, and rows of ``[sweep] along``, which may also set entries."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated as A
from typing import Any

from pipeline.paths import user_path
from pipeline.scene.declare import Declared, Table, table_of
from pipeline.scene.document import Document, Extend
from pipeline.scene.faults import Faults
from pipeline.scene.kinds import BULK, CRITICAL, FRICTION, LOAD, SPEED, Share
from pipeline.scene.over import labels_of, with_rows
from pipeline.scene.table import read_columns, rows_of
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
CONDITIONS = {
    name: FIELDS[name] for name in table_of(_ConditionsTable).keys if name not in _PLACE.keys
}
"""Conditions that each row may set, and their entries in a scene."""


@dataclass(frozen=True, slots=True)
class OperatingPoints:
    """Operating points, loads [N] and velocities [m/s], and other columns of their table.

    `conditions` has friction, bulk and critical temperature [K] of each point, if the table gives
    them. `counted` states how many rows were used and left out.
    """

    places: tuple[Place, ...]
    others: Mapping[str, Sequence[Any]]
    conditions: tuple[Mapping[str, float], ...] = ()

    @property
    def rows(self) -> list[tuple[Place, Mapping[str, float]]]:
        """Place and conditions of each row."""
        return [*zip(self.places, self.conditions or ({},) * len(self.places), strict=True)]

    @classmethod
    def read(cls, source: str | os.PathLike[str] | Mapping[str, Sequence[Any]]) -> OperatingPoints:
        """Read a file as CSV or Excel, or columns by heading, such as a data frame.

        Columns of quantities that are no condition are passed on. Raises an `InputError` if the
        table is unreadable, lacks a column, or has a faulty row.
        """
        given = Path(source) if isinstance(source, str | os.PathLike) else source
        columns = read_columns(given, MOST_PLACES)
        written = rows_of(columns, _ConditionsTable, _PLACE.keys)
        if not written:
            raise InputError("the table of operating points has no rows; give one at least")
        read = [vars(table_of(_ConditionsTable).read(row, "", Faults())) for row in written]
        others = {one.head: one.cells for one in columns if one.name not in read[0]}
        conditions = tuple(
            {name: row[name] for name in CONDITIONS if row.get(name) is not None} for row in read
        )
        return cls(tuple((row["load"], row["velocity"]) for row in read), others, conditions)


def begin(document: Document, faults: Faults) -> tuple[Document, Extend | None]:
    """Add defaults for the rows of ``sweep.along`` to a document, and prepare their variants.

    The defaults are the loads and velocities of all rows, and the entries of the first row. Returns
    the document, and the function that adds a variant for each row to a sweep. The function is None
    if there are no rows, or a row is faulty.
    """
    written = entry_at(document.entries(), "sweep.along")
    rows = list[dict[str, Any]]()
    if isinstance(written, str) and written:
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


def _file_rows(folder: Path, file: str, faults: Faults) -> list[dict[str, Any]]:
    """Read rows of a file as entries by heading; empty if it is faulty."""
    with faults.at("sweep.along"):
        columns = read_columns(folder / user_path(file), MOST_SCENES)
        rows_of(columns, _ConditionsTable, _PLACE.keys)  # raises if a place is faulty
        return [{one.name: one.entry(k) for one in columns} for k in range(len(columns[0].cells))]
    return []
