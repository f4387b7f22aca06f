"""Cases of a sweep: by ``[sweep] over``, ``along`` and ``realizations``.

A case is read as if its values were in the file, or set by ``--set``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from pipeline.condition_kinds import CONDITIONS
from pipeline.faults import Faults
from pipeline.kinds import LOAD, POINT_KINDS, SPEED, faults_in
from pipeline.limits import MAX_CASES, MAX_ON_AXIS, MAX_VARIED_ENTRIES
from pipeline.messages import is_unprintable, quoted
from pipeline.scene.build import BuiltScene, Files, build_case, realizations_of
from pipeline.scene.entries import Entries, entry_at, flat, merged, replace_values
from pipeline.scene.format import LOAD_FACTORS, TableFile, number_at, scene_entries
from pipeline.scene.table_kinds import TableKind
from pipeline.sweep.case import Case
from pipeline.sweep.case_table import (
    AREAS_ENTRY,
    CASE,
    PLACE_UNITS,
    SEED_ENTRY,
    CaseTable,
    Column,
    Label,
    dimension_of,
    numbered_cases,
    surface_table,
)
from pipeline.sweep.codec import digest
from pipeline.table import Table, TableColumn, read_table
from pipeline.units import UnitError, si_unit, to_si
from tribo import InputError, SelfAffineRoughness

_ENTRIES = {name: condition.entry for name, condition in CONDITIONS.items()}
_UNVARIED_TABLES = ("sweep", "title", "note", "extends", "without", "tests", "uncertainty")
"""Entries and tables that cannot take several values."""


@dataclass(frozen=True)
class Cases:
    """A table of cases, and the entries that each of them replaces, by path."""

    table: CaseTable = field(default_factory=CaseTable)
    changes: Sequence[Entries] = ({},)

    def __mul__(self, other: Cases) -> Cases:
        changes = [{**first, **second} for first in self.changes for second in other.changes]
        return Cases(self.table * other.table, changes)


def with_first_case(
    entries: Entries, files: Files, faults: Faults
) -> tuple[Entries, list[dict[str, Any]] | None]:
    """Entries with the first value of ``over``, and the first row of ``along``, as defaults.

    Also returns the rows of ``along``, as entries by path and labels by heading; None if they have
    faults, which are added to `faults`.
    """
    over, along = entry_at(entries, "sweep.over"), entry_at(entries, "sweep.along")
    varied = [*flat(over)] if isinstance(over, dict) else []
    if len(varied) > MAX_VARIED_ENTRIES:
        varied = []  # refused by the format
    firsts = {path: values[0] for path, values in varied if isinstance(values, list) and values}
    entries = merged(replace_values({}, firsts), entries)
    if not along or (isinstance(along, list) and len(along) > MAX_ON_AXIS):
        return entries, []  # a list that is empty or too long is refused by the format
    rows = list[dict[str, Any]]()
    with faults.at("sweep.along"):
        rows = _rows_along(along, files, faults)
    if not rows:
        return entries, None
    factors = _load_factors(entries)
    if len(rows) * len(factors) > MAX_ON_AXIS:
        problem = f"{len(factors)} factors of {len(rows)} rows exceed {MAX_ON_AXIS} loads in all"
        faults.refuse("sweep.load_factors", f"{problem}; give fewer factors or rows")
        return entries, None
    loads, velocities = (
        {kind.value(row[name]) for row in rows} for name, kind in POINT_KINDS.items()
    )
    table = CaseTable(load_factors=factors)
    loads = {factored for load in loads for factored in table.loads_of({"load": load})}
    axes = {
        "sweep.loads": [f"{load!r} {LOAD.unit}" for load in sorted(loads)],
        "sweep.velocities": [f"{velocity!r} {SPEED.unit}" for velocity in sorted(velocities)],
    }
    row_entries = {path: value for path, value in rows[0].items() if "." in path}  # no labels
    return merged(replace_values({}, row_entries), replace_values(entries, axes)), rows


def _load_factors(entries: Entries) -> tuple[float, ...]:
    """Shares of the loads of rows at which they are simulated; faulty ones are refused later."""
    factors = entry_at(entries, "sweep.load_factors")
    return LOAD_FACTORS.read(factors, "", Faults()) or () if factors else ()


def _rows_along(along: Any, files: Files, faults: Faults) -> list[dict[str, Any]]:
    """Rows of ``along``, in the scene or in a file, as entries by path and labels by heading."""
    if isinstance(along, list):
        table = _table_of_scene([dict(flat(row)) for row in along if isinstance(row, dict)])
    else:
        entry = {"file": along} if isinstance(along, str) else along
        declared = TableKind(TableFile).read(entry, "sweep.along", file_faults := Faults())
        faults += file_faults
        if file_faults:
            return []
        path = files.path("sweep.along", declared.file)
        table = read_table(path, MAX_ON_AXIS, declared.decimal, declared.ignore, _ENTRIES)
    entries = [path for path in scene_entries() if path.partition(".")[0] not in _UNVARIED_TABLES]
    paths = [column.name for column in table.columns if "." in column.name]
    known = [*POINT_KINDS, *paths, *entries]
    rows = table.rows(known, partial(faults_in, kinds=POINT_KINDS), needed=POINT_KINDS)
    for column in table.columns:
        if column.name not in known:
            for row, cell in zip(rows, column.cells, strict=True):
                row[column.name] = cell
    return rows


def _table_of_scene(rows: list[dict[str, Any]]) -> Table:
    """Table of rows that are listed in a scene."""
    names = [*dict.fromkeys(name for row in rows for name in row)]
    if len(names) > MAX_VARIED_ENTRIES:
        raise InputError(
            f"rows have {len(names)} different entries; give {MAX_VARIED_ENTRIES} at most"
        )
    columns = [
        TableColumn(name, _ENTRIES.get(name, name), "", [str(row.get(name, "")) for row in rows])
        for name in names
    ]
    return Table("the rows", columns, range(1, len(rows) + 1))


def listed_cases(scene: BuiltScene, along: list[dict[str, Any]]) -> Cases:
    """Cases of a scene: the rows of ``along``, by ``over``, by the seeds of its surfaces."""
    sweep, cases = scene.tables.sweep, Cases()
    if along:
        cases *= _cases_along(along, sweep.load_factors or ())
    if sweep.over:
        cases *= _cases_over(sweep.over)
    changes: list[Entries]
    if isinstance(scene.case.scene.roughness, SelfAffineRoughness):
        realizations = realizations_of(sweep.realizations, entry_at(scene.tables, SEED_ENTRY))
        changes = [{SEED_ENTRY: seed} for seed in realizations]
    else:
        realizations = realizations_of(sweep.realizations, 0)
        changes = [{AREAS_ENTRY: [area]} for area in realizations]
    return cases * Cases(surface_table(realizations), changes or [{}])


def _cases_over(over: dict[str, Any]) -> Cases:
    if (count := math.prod(map(len, over.values()))) > MAX_CASES:
        raise InputError(f"sweep.over: {count} cases exceed the limit of {MAX_CASES}")
    cases = Cases()
    for path, values in over.items():
        labels, unit = labels_of(values)
        pairs = [*zip(labels, values, strict=True)]
        if unit is not None:  # quantities ascend, texts keep their order
            pairs.sort(key=lambda pair: pair[0])
        column = _column(dimension_of(path), unit, f"{path} of the scene", path)
        table = CaseTable((column,), tuple({column.name: label} for label, _ in pairs))
        cases *= Cases(table, [{path: value} for _, value in pairs])
    return cases


def _cases_along(rows: list[dict[str, Any]], load_factors: Sequence[float]) -> Cases:
    for text in (text for row in rows for pair in row.items() for text in pair):
        if isinstance(text, str) and is_unprintable(text):
            raise InputError(
                f"sweep.along: {quoted(text)} has a line break or a control character; leave it out"
            )
    columns, case_labels = list[Column](), [dict[str, Label]() for _ in rows]
    for heading in sorted(rows[0], key=lambda heading: heading in PLACE_UNITS):
        is_entry = "." in heading
        values = [row[heading] for row in rows]
        # Load, velocity and entries are in SI; other columns have words.
        is_quantity = is_entry or heading in PLACE_UNITS
        labels, unit = labels_of(values) if is_quantity else (values, None)
        name, entry = (dimension_of(heading), heading) if is_entry else (heading, "")
        unit = PLACE_UNITS.get(heading, unit)
        columns.append(_column(name, unit, f"{heading} of the row", entry))
        for row_labels, label in zip(case_labels, labels, strict=True):
            row_labels[name] = label
    changes = [{path: value for path, value in row.items() if "." in path} for row in rows]
    return Cases(numbered_cases(columns, case_labels, load_factors), changes)


def _column(name: str, unit: str | None, meaning: str, entry: str) -> Column:
    display_unit = number_at(entry).unit if entry and unit is not None else ""
    return Column(name, unit, meaning=meaning, entry=entry, display_unit=display_unit)


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


def read_cases(
    entries: Entries, files: Files, scene: BuiltScene, listed: Cases, key: str
) -> list[Case]:
    """Read the listed cases; those that differ in the seed of a random surface are read once.

    Raises an `InputError` for the first faulty case, which names `key`, the entry that lists
    these cases.
    """
    for path in listed.changes[0]:
        if path.partition(".")[0] in _UNVARIED_TABLES and path != AREAS_ENTRY:
            raise InputError(
                f"{key}.{quoted(path)} cannot take several values; use a scene entry such as "
                '"pin.radius"'
            )
    case_by_changes, cases = dict[str, Case](), list[Case]()
    for name, changes in zip(listed.table.names, listed.changes, strict=True):
        unseeded = {path: value for path, value in changes.items() if path != SEED_ENTRY}
        if (text := repr(unseeded)) not in case_by_changes:
            row = dict(name).get(CASE)
            location = key if row is None else f"{key}[{row}]"
            case_by_changes[text] = _build_case(entries, files, scene, unseeded, location)
        case = replace(case_by_changes[text], name=name)
        if SEED_ENTRY in changes and isinstance(case.scene.roughness, SelfAffineRoughness):
            case = case.on_surface(changes[SEED_ENTRY])
        cases.append(case)
    over = scene.tables.sweep.over
    if over and len({*map(digest, case_by_changes.values())}) == 1 < len(case_by_changes):
        raise InputError(f"{key}: {' and '.join(over)} changes nothing here; leave it out")
    return cases


def _build_case(
    entries: Entries, files: Files, base: BuiltScene, changes: Entries, key: str
) -> Case:
    """Case of the scene `base` with some changes; its stored fields must have the same grid."""
    if not changes:
        return base.case
    faults = Faults()
    try:
        built = build_case(base, entries, changes, files, faults)
        faults.raise_first()
        assert built
        if base.tables.sweep.fields and built.case.scene.grid != base.case.scene.grid:
            raise InputError(
                "this changes the grid of the stored fields, which must be equal in all cases; set "
                "sweep.fields = false, or run each value into its own store"
            )
    except InputError as error:
        key = AREAS_ENTRY if changes.keys() == {AREAS_ENTRY} else key
        changed = (
            f"{path} = {quoted(value)}" for path, value in changes.items() if value is not None
        )
        raise InputError(f"{key}: {', '.join(changed)}: {error}") from error
    return built.case
