"""Cases of a sweep: by ``[sweep] over``, ``along`` and ``realizations``.

A case is read as if its values were in the file, or set by ``--set``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.limits import MOST_ON_AXIS, MOST_SCENES, MOST_VARIED
from pipeline.messages import is_unprintable, quoted
from pipeline.scene.build import Built, Files, build_case, realizations_of
from pipeline.scene.declared_tables import Entry, Table, table_of
from pipeline.scene.entries import Entries, entry_at, flat, merged, replace_values
from pipeline.scene.faults import Faults
from pipeline.scene.format import TableFile, number_at, scene_entries
from pipeline.scene.kinds import LOAD, SPEED
from pipeline.sweep.case import CONDITION_ENTRIES, Case
from pipeline.sweep.case_table import (
    AREAS_ENTRY,
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
from pipeline.table import SCENE, Advice, Sheet, TableError, TableFaults
from pipeline.table import Column as TableColumn
from pipeline.table_reader import read_table
from pipeline.units import UnitError, si_unit, to_si
from tribo import InputError, SelfAffineRoughness

_UNVARIED_TABLES = ("sweep", "title", "note", "extends", "without", "tests")
"""Entries and tables that cannot take several values."""
_POINT = Table({"load": Entry(LOAD, is_needed=True), "velocity": Entry(SPEED, is_needed=True)})
_CASE_ADVICE = Advice(
    "ignore it: along = {{ file = ..., ignore = [{}] }}",
    "set along = {{ file = ..., decimal = {} }}",
)
CaseRow = dict[str, Any]


@dataclass(frozen=True)
class Cases:
    """A table of cases, and the entries that each of them replaces, by path."""

    table: CaseTable = field(default_factory=CaseTable)
    changes: Sequence[Entries] = ({},)

    def __mul__(self, other: Cases) -> Cases:
        both = [{**a, **b} for a in self.changes for b in other.changes]
        return Cases(self.table * other.table, both)


def with_first_case(
    entries: Entries, files: Files, faults: Faults
) -> tuple[Entries, list[CaseRow]]:
    """Entries with the first value of ``over``, and the first row of ``along``, as defaults.

    Also returns the rows of ``along``, as entries by heading. Faulty rows are added to `faults`,
    and left out, so that they have no further faults.
    """
    over = entry_at(entries, "sweep.over")
    listed = [*flat(over)] if isinstance(over, dict) else []
    if len(listed) > MOST_VARIED:
        faults.refuse(
            "sweep.over", f"{len(listed)} entries are too many; vary {MOST_VARIED} at most"
        )
        return replace_values(entries, {"sweep.over": None}), []
    first = {path: values[0] for path, values in listed if isinstance(values, list) and values}
    entries = merged(replace_values({}, first), entries)
    before, rows = len(faults), _listed_rows(entry_at(entries, "sweep.along"), files, faults)
    row_points = [_read_point(k, row, rows[0], faults) for k, row in enumerate(rows)]
    if len(faults) > before:
        return replace_values(entries, {"sweep.along": None}), []
    if not rows:
        return entries, []
    axes = {
        f"sweep.{name}": [
            f"{value!r} {unit}" for value in sorted({point[head] for point in row_points})
        ]
        for name, head, unit in (("loads", "load", "N"), ("velocities", "velocity", "m/s"))
    }
    row_entries = {path: value for path, value in rows[0].items() if "." in path}  # no labels
    return merged(replace_values({}, row_entries), replace_values(entries, axes)), rows


def _listed_rows(written: Any, files: Files, faults: Faults) -> list[CaseRow]:
    """Rows of ``along``, in the scene or in a file, as entries by path and labels by heading."""
    if isinstance(written, list) and len(written) > MOST_ON_AXIS:
        return []  # refused by the format
    if isinstance(written, list) and all(isinstance(row, dict) for row in written):
        rows = [dict(flat(row)) for row in written]
        names = list(dict.fromkeys(name for row in rows for name in row))
        if len(names) > MOST_VARIED:
            problem = f"rows have {len(names)} different entries; give {MOST_VARIED} at most"
            faults.refuse("sweep.along", problem)
            return []
        columns = [
            TableColumn(name, name, "", [str(row.get(name, "")) for row in rows]) for name in names
        ]
        sheet = Sheet("the rows", columns, [*range(1, len(rows) + 1)], TableFaults("the rows"))
        with faults.at("sweep.along"):
            entries, _ = _read_columns(sheet, ())
            paths = {column.name for column in entries}
            renamed = [{CONDITION_ENTRIES.get(k, k): v for k, v in row.items()} for row in rows]
            return [
                {k: value if k in paths else str(value) for k, value in row.items()}
                for row in renamed
            ]
        return []
    table = {"file": written} if isinstance(written, str) else written
    before = len(faults)
    table_file = table and table_of(TableFile).read(table, "sweep.along", faults)
    if not table_file or len(faults) > before:
        return []
    with faults.at("sweep.along"):
        path = files.path("sweep.along", table_file.file)
        advice = _CASE_ADVICE if isinstance(written, str) else SCENE
        sheet = read_table(path, MOST_ON_AXIS, table_file.decimal, table_file.ignore, advice)
        entries, words = _read_columns(sheet, tuple(_POINT.keys))
        return [
            {column.name: column.entry(k) for column in entries}
            | {column.name: column.cells[k] for column in words}
            for k in range(len(sheet.lines))
        ]
    return []


def _read_columns(
    sheet: Sheet, needed: tuple[str, ...]
) -> tuple[list[TableColumn], list[TableColumn]]:
    """Columns of rows with point and entries by their paths, and columns of words."""
    sheet = sheet.renamed(CONDITION_ENTRIES)
    entries = [path for path in scene_entries() if path.partition(".")[0] not in _UNVARIED_TABLES]
    paths = [column.name for column in sheet.columns if "." in column.name]
    columns, words, faults = sheet.select([*_POINT.keys, *paths, *entries], needed)
    if faults:
        raise TableError(sheet.name, faults)
    return columns, words


def _read_point(number: int, row: CaseRow, first: CaseRow, faults: Faults) -> CaseRow:
    """Load and velocity of a row."""
    if other := row.keys() ^ first.keys():
        problem = f"not every row has {', '.join(sorted(other))}; add it to all rows"
        faults.refuse(f"sweep.along[{number}]", problem)
    values = {name: row[name] for name in _POINT.keys.keys() & row.keys()}
    read: CaseRow = _POINT.read(values, f"sweep.along[{number}]", faults)
    return read


def listed_cases(scene: Built, along: list[CaseRow]) -> Cases:
    """Cases of a scene: the rows of ``along``, by ``over``, by the seeds of its surfaces."""
    sweep, cases = scene.tables.sweep, Cases()
    if along:
        cases *= _cases_along(along)
    if sweep.over:
        cases *= _cases_over(sweep.over)
    if isinstance(scene.case.scene.roughness, SelfAffineRoughness):
        seeds = realizations_of(sweep.realizations, entry_at(scene.tables, SEED_ENTRY))
        changes: list[Entries] = [{SEED_ENTRY: seed} for seed in seeds]
    else:
        seeds = realizations_of(sweep.realizations, 0)
        changes = [{AREAS_ENTRY: [area]} for area in seeds]
    return cases * Cases(surface_table(seeds), changes or [{}])


def _cases_over(over: dict[str, Any]) -> Cases:
    if (count := math.prod(map(len, over.values()))) > MOST_SCENES:
        raise InputError(f"sweep.over: {count} cases exceed the limit of {MOST_SCENES}")
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


def _cases_along(rows: list[CaseRow]) -> Cases:
    texts = (text for row in rows for pair in row.items() for text in pair)
    if unprintable := [text for text in texts if isinstance(text, str) and is_unprintable(text)]:
        problem = f"{quoted(unprintable[0])} has a line break or a control character; leave it out"
        raise InputError(f"sweep.along: {problem}")
    heads = sorted(rows[0], key=lambda head: head in PLACE_UNITS)
    parsed = {head: _row_labels(head, [row[head] for row in rows]) for head in heads}
    columns = {
        head: _column(
            dimension_of(head) if "." in head else head,
            PLACE_UNITS.get(head, unit),
            f"{head} of the row",
            head if "." in head else "",
        )
        for head, (_, unit) in parsed.items()
    }
    labels = [{columns[head].name: parsed[head][0][k] for head in heads} for k in range(len(rows))]
    changes = [{path: value for path, value in row.items() if "." in path} for row in rows]
    return Cases(numbered_cases(columns.values(), labels), changes)


def _row_labels(head: str, values: Sequence[Any]) -> tuple[tuple[Label, ...], str | None]:
    """Labels of rows: the values of an entry, a load or a velocity in SI, or words."""
    is_quantity = "." in head or head in PLACE_UNITS
    return labels_of(values) if is_quantity else (tuple(values), None)


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


def read_cases(entries: Entries, files: Files, scene: Built, listed: Cases, key: str) -> list[Case]:
    """Read the listed cases; those that differ in the seed of a random surface are read once.

    Raises an `InputError` for the first faulty case, which names `key`, the entry that lists
    these cases.
    """
    if wrong := [
        p for p in listed.changes[0] if p.partition(".")[0] in _UNVARIED_TABLES and p != AREAS_ENTRY
    ]:
        raise InputError(
            f"{key}.{quoted(wrong[0])} cannot take several values; use a scene entry such as "
            '"pin.radius"'
        )
    known, cases = dict[str, Case](), list[Case]()
    for name, changes in zip(listed.table.names, listed.changes, strict=True):
        unseeded = {path: value for path, value in changes.items() if path != SEED_ENTRY}
        if (text := repr(unseeded)) not in known:
            known[text] = _build_case(entries, files, scene, unseeded, key)
        case = replace(known[text], name=name)
        if SEED_ENTRY in changes and isinstance(case.scene.roughness, SelfAffineRoughness):
            case = case.on_surface(changes[SEED_ENTRY])
        cases.append(case)
    over = scene.tables.sweep.over
    if over and len({*map(digest, known.values())}) == 1 < len(known):
        words = " and ".join(over)
        raise InputError(f"{key}: {words} changes nothing here; leave it out")
    return cases


def _build_case(entries: Entries, files: Files, base: Built, changes: Entries, key: str) -> Case:
    if not changes:
        return base.case
    faults = Faults()
    try:
        row = build_case(base, entries, changes, files, faults)
        faults.raise_first()
        assert row
        _require_same_grid(row, base)
    except InputError as error:
        key = AREAS_ENTRY if changes.keys() == {AREAS_ENTRY} else key
        changed = (
            f"{path} = {quoted(value)}" for path, value in changes.items() if value is not None
        )
        raise InputError(f"{key}: {', '.join(changed)}: {error}") from error
    return row.case


def _require_same_grid(row: Built, base: Built) -> None:
    """Raise an `InputError` if a row stores other variables than the scene itself (`base`)."""
    if base.tables.sweep.fields and row.case.scene.grid != base.case.scene.grid:
        raise InputError(
            "this changes the grid of the stored fields, which must be equal in all cases; run "
            "each value into its own store"
        )
