"""Read laboratory tables into a sheet with the quantities of tests or of a trace."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.laboratory.exports import Export, find_export, has_cell
from pipeline.laboratory.tables import INGREDIENTS, WordNames, derive, units_of
from pipeline.laboratory.trace import LEAST_ROWS
from pipeline.scene.declare import table_of
from pipeline.scene.faults import did_you_mean, quoted
from pipeline.scene.format import Stages, Test
from pipeline.scene.names import Heading
from pipeline.scene.sheet import Lines, Sheet, SheetRow, read_lines, sheet_of
from pipeline.scene.units import UnitError, to_si
from tribo import InputError

_LISTED = dict.fromkeys([*table_of(Test).keys, *table_of(Stages).keys])
OF_TESTS = *(name for name in _LISTED if name != "with"), "transition_load"
"""Quantities that a log may have."""
NEEDED = "time", "friction", "load", "velocity"
"""Quantities from which stages and rises of a trace follow."""
OF_TRACE = *NEEDED, "friction_force", "friction_torque", "bulk_temperature", "outcome"
"""Quantities that a trace may have; an outcome tells a log from a trace."""
_ENDS = "mild_up_to", "severe_at"
_BEYOND = re.compile(r"(?:>=?|≥|über|beyond|above)\s*(\d\S*.*)|(\d[\d.]*)\s*\+")
# Left out if the outcome is of several words, as the question may suggest their opposite.
_NEAR = re.compile(r" \(did you mean [^)]*\)")
_MOST = 0.95  # share of rows in which time must rise for a single run
_OF_SINE = 2 / np.pi  # mean of a rectified sine over its peak


class Read(NamedTuple):
    """A table, its export format, and reasons why some quantities cannot be computed."""

    sheet: Sheet
    export: Export
    missing: Mapping[str, str]


def read_table(path: Path, options: Mapping[str, Any], wanted: Iterable[str] = OF_TESTS) -> Read:
    """Read a table file for the quantities `wanted`, with the options of a scene's log.

    `options` may have the keys columns, given, skip, where, form, sheet and decimal. Faults are
    listed in the sheet; an `InputError` is raised if an option names no known quantity or form.
    """
    units, columns = units_of([*wanted]), options.get("columns") or {}
    tables = read_lines(path, WordNames(units, columns), options.get("sheet"))
    named = [
        Lines([SheetRow(0, [path.stem.replace("_", " ")]), *one.rows], one.form) for one in tables
    ]
    export = find_export(named, options.get("form"))
    known = {*OF_TESTS, *OF_TRACE, *INGREDIENTS}
    for option in ("columns", "given"):
        for name in (one for one in options.get(option) or () if one not in known):
            near, every = did_you_mean(name, known), ", ".join(sorted(known))
            raise InputError(f"{option}.{name}: no such quantity{near}; give one of {every}")
    names = WordNames(units, columns, export.columns)
    sheet = sheet_of(str(path), tables, names, options.get("decimal"))
    _join_units(sheet)
    heads = [*sheet.above, *(one.text for one in sheet.headings)]
    for name, head in names.chosen.items():
        _choose_unit(sheet, name, Heading.of(head).unit)
        is_there = head.partition(" [")[0] in " ".join(heads)
        if name not in sheet.places and (name in sheet.units or not is_there):
            every = ", ".join(quoted(one.text) for one in sheet.headings)
            sheet.faults.append(f"columns.{name}: no column {quoted(head)}; give one of {every}")
    for name, unit in export.units.items():
        _choose_unit(sheet, name, unit)
    _take_rows(sheet, options.get("where") or {}, is_kept=True)
    _take_rows(sheet, options.get("skip") or {}, is_kept=False)
    _add_given(sheet, options.get("given") or {})
    if export.sine and "velocity" in sheet.places and has_cell(heads, export.sine):
        _take_mean_of_sine(sheet)
    _read_levels(sheet, export.step)
    return Read(sheet, export, derive(sheet))


def _join_units(sheet: Sheet) -> None:
    """If a column contains units, append each unit to the number in the column before it."""
    for k, heading in enumerate(sheet.headings[1:], 1):
        if heading.title.lower() in ("unit", "units", "einheit"):
            sheet.sources.add(k)
            for row in sheet.rows:
                row.cells[k - 1] = " ".join(row.cells[k - 1 : k + 1]).strip()


def _choose_unit(sheet: Sheet, name: str, unit: str) -> None:
    """Set the unit of the column of quantity `name`, if the heading does not state a unit."""
    if name in sheet.places and unit and not (heading := sheet.heading(name)).unit:
        text = f"{heading.text} [{unit}]"
        sheet.headings[sheet.places[name]] = Heading(text, heading.title, unit)


def require(sheet: Sheet, needed: Iterable[str], moving: Iterable[str] = ()) -> None:
    """Add a fault to a sheet if columns `needed` are missing.

    The fault is a message that names the options by which a user supplies the missing columns.

    Rows in which a `needed` quantity is empty, or a quantity of `moving` is 0, are removed from the
    sheet.
    """
    before, needed = len(sheet.faults), [*needed]
    sheet.require(needed, [*moving])
    missing = [name for name in needed if name not in sheet.places]
    if len(sheet.faults) > before:
        options = (f'--given "{one}=... {sheet.units[one] or ""}'.strip() + '"' for one in missing)
        sheet.faults[-1] += f'; name it by --column "{missing[0]}=HEADING", or {" ".join(options)}'


def add_hints(sheet: Sheet) -> None:
    """Add hints to faults on missing units and unknown outcomes: the option that resolves each.

    The faults are messages of the `sheet`, and are changed in place. An outcome is unknown if the
    word in its column is not known to mean mild or severe.
    """
    for k, fault in enumerate(sheet.faults):
        if match := re.search(r", (\w+): \S+ has no unit", fault):
            unit = {"K": "degC"}.get(unit := sheet.units[match[1]] or "", unit)
            head = f"{sheet.heading(match[1]).text} [{unit}]"
            sheet.faults[k] += f'; write the unit in the heading, or --column "{match[1]}={head}"'
        if match := re.search(r', outcome: "((?:\\.|[^"])*)" is unknown', fault):
            message = _NEAR.sub("", fault) if " " in match[1] else fault
            sheet.faults[k] = f'{message}; or say what it means by --word "{match[1]}=severe"'


def _take_rows(sheet: Sheet, values: Mapping[str, Any], is_kept: bool) -> None:
    """Keep only the rows that have `values` in columns, or leave them out if not `is_kept`.

    `values` are by heading or quantity.
    """
    heads = [heading.text for heading in sheet.headings]
    for head, value in values.items():
        if head not in heads and head not in sheet.places:
            option, listed = "where" if is_kept else "skip", ", ".join(filter(None, heads))
            sheet.faults.append(f'{option}: there is no column "{head}"; give one of {listed}')
            continue
        place = heads.index(head) if head in heads else sheet.places[head]
        found = {row.number: row.cells[place] for row in sheet.rows}
        wanted = {number for number, cell in found.items() if cell == str(value)}
        if not wanted:
            listed = ", ".join(sorted({*filter(None, found.values())})[:20])
            sheet.faults.append(f'no row has "{value}" as {head}; give one of {listed}')
        left = found.keys() - wanted if is_kept else wanted
        reason = f"{'is not of' if is_kept else 'has'} {head} {value}"
        sheet.leave_out(dict.fromkeys(left, reason))


def _add_given(sheet: Sheet, given: Mapping[str, Any]) -> None:
    """Add columns for quantities that the file lacks, with the values `given` by the user.

    Quantities that this kind of table does not use are ignored.
    """
    for name, value in given.items():
        if name not in sheet.units:  # a log ignores what only traces need, and the reverse
            continue
        like = sheet.units[name]
        try:
            if like is not None and (like or not re.fullmatch(r"[\d.eE+-]+", str(value))):
                to_si(str(value), f"1 {like}")
        except UnitError as error:
            sheet.faults.append(f'given.{name}: {error}; give one such as "1 {like}"')
            continue
        sheet.add(name, "", [str(value)] * len(sheet.rows))


def _read_levels(sheet: Sheet, step: str) -> None:
    """Turn the last mild and first severe levels of stepwise tests in a sheet into numbers.

    A cell such as "> 12" means that level 12 was still mild, and that no level was severe. If the
    sheet has a column for only one of the two levels, the other level is one step of load away.
    `step` is this step as text, such as "100 N"; empty if it is not known.
    """
    beyond = {name: _read_more_than(sheet, name) for name in _ENDS}
    ends = [name for name in _ENDS if name in sheet.places]
    if not ends or not (step or any(beyond[name] for name in _ENDS)):
        return
    unknown = np.full(len(sheet.rows), np.nan)
    mild, severe = (sheet.numbers(x) if x in ends else unknown.copy() for x in _ENDS)
    is_open = np.zeros(len(sheet.rows), bool)
    for k, (number, _) in enumerate(sheet.rows):
        is_open[k] = number in beyond["mild_up_to"] or number in beyond["severe_at"]
    mild = np.where(is_open & np.isfinite(severe), severe, mild)
    severe = np.where(is_open, np.nan, severe)
    if step and len(ends) == 1:
        apart = to_si(step, f"1 {sheet.units['load']}")
        mild, severe = (
            np.where(np.isfinite(mild), mild, severe - apart),
            np.where(np.isfinite(severe) | is_open, severe, mild + apart),
        )
    for name, values in zip(_ENDS, (mild, severe), strict=True):
        sheet.sources |= {sheet.places[name]} if name in ends else set()
        sheet.add(name, sheet.units[name] or "", [f"{x:.12g}" if x > 0 else "" for x in values])


def _read_more_than(sheet: Sheet, name: str) -> set[int]:
    """Numbers of the rows whose cell of quantity `name` says "more than".

    Such a cell is replaced by the number in it; a cell without digits becomes empty.
    """
    rows, place = set[int](), sheet.places.get(name, 0)
    for number, cells in sheet.rows if name in sheet.places else ():
        if match := _BEYOND.fullmatch(cells[place]):
            rows.add(number)
            cells[place] = match[1] or match[2]
        elif not re.search(r"\d", cells[place]):  # words such as "no failure"
            cells[place] = ""
    return rows


def _take_mean_of_sine(sheet: Sheet) -> None:
    """Replace peak velocities of a sinusoidal motion by its mean speed."""
    place, speeds = sheet.places["velocity"], sheet.numbers("velocity")
    sheet.add("velocity", "m/s", [f"{_OF_SINE * speed:.12g}" for speed in speeds])
    sheet.sources.add(place)
    sheet.form.append("velocity is 2/π of the peak of a sine")


def is_trace(sheet: Sheet) -> bool:
    """True if the table can be a trace: it has time, friction and enough rows."""
    has_friction = {"friction", "friction_force", "friction_torque"} & sheet.places.keys()
    return "time" in sheet.places and bool(has_friction) and len(sheet.rows) >= LEAST_ROWS


def is_one_run(sheet: Sheet) -> bool:
    """True if the table is a record of friction in one run: time rises in almost all rows."""
    before = len(sheet.faults)
    steps = np.diff(sheet.numbers("time")) if is_trace(sheet) else np.zeros(1)
    del sheet.faults[before:]  # a log needs no time
    return bool(np.mean(steps > 0) > _MOST)
