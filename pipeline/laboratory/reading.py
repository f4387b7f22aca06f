"""Read laboratory tables into a sheet with the quantities of tests or of a trace."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipeline.laboratory.exports import Export, find_export, has_cell
from pipeline.laboratory.tables import INGREDIENTS, WordNames, derive, units_of
from pipeline.laboratory.trace import LEAST_ROWS
from pipeline.scene.choices import Choices, choose, choose_unit, require_known
from pipeline.scene.declare import table_of
from pipeline.scene.format_of_tests import StagedRunTable, Test
from pipeline.scene.lines import SheetRow, read_lines
from pipeline.scene.sheet import Sheet, sheet_of
from pipeline.scene.units import to_si

_LISTED = dict.fromkeys([*table_of(Test).keys, *table_of(StagedRunTable).keys])
OF_TESTS = *(name for name in _LISTED if name != "with"), "transition_load"
"""Quantities that a log may have."""
NEEDED = "time", "friction", "load", "velocity"
"""Quantities from which stages and rises of a trace follow."""
OF_TRACE = *NEEDED, "friction_force", "friction_torque", "bulk_temperature", "outcome"
"""Quantities that a trace may have; an outcome tells a log from a trace."""
_ENDS = "mild_up_to", "severe_at"
_BEYOND = re.compile(r"(?:>=?|≥|über|beyond|above)\s*(\d\S*.*)|(\d[\d.]*)\s*\+")
_MOST = 0.95  # share of rows in which time must rise for a single run
_OF_SINE = 2 / np.pi  # mean of a rectified sine over its peak


class Read(NamedTuple):
    """A table, its export format, and reasons why some quantities cannot be computed."""

    sheet: Sheet
    export: Export
    missing: Mapping[str, str]


def read_table(
    path: Path, choices: Choices, form: str | None = None, wanted: Iterable[str] = OF_TESTS
) -> Read:
    """Read a table file for the quantities `wanted`, with the `choices` of the user.

    `form` is the name of the export that it is. Faults are listed in the sheet; an `InputError` is
    raised if a choice names no known quantity, or `form` no known export.
    """
    units, chosen = units_of([*wanted]), choices.columns or {}
    tables = read_lines(path, WordNames(units, chosen), choices.sheet)
    named = [
        one._replace(rows=[SheetRow(0, [path.stem.replace("_", " ")]), *one.rows]) for one in tables
    ]
    export = find_export(named, form)
    require_known(choices, {*OF_TESTS, *OF_TRACE, *INGREDIENTS})
    names = WordNames(units, chosen, export.columns)
    sheet = sheet_of(str(path), tables, names, choices.decimal)
    _join_units(sheet)
    for name, unit in export.units.items():
        if name not in chosen:
            choose_unit(sheet, name, unit)
    choose(sheet, choices, names.chosen)
    heads = [*sheet.above, *(one.text for one in sheet.headings)]
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


def add_hints(sheet: Sheet) -> None:
    """Add to faults on missing units, in place, the option that gives the unit."""
    for k, fault in enumerate(sheet.faults):
        if match := re.search(r", (\w+): \S+ has no unit", fault):
            unit = {"K": "degC"}.get(unit := sheet.units[match[1]] or "", unit)
            head = f"{sheet.heading(match[1]).text} [{unit}]"
            sheet.faults[k] += f'; write the unit in the heading, or --column "{match[1]}={head}"'


def _read_levels(sheet: Sheet, step: str) -> None:
    """Turn last mild and first severe levels into numbers; either is one `step` from the other."""
    beyond = {name: _read_more_than(sheet, name) for name in _ENDS}
    ends = [name for name in _ENDS if name in sheet.places]
    if not ends or not (step or any(beyond[name] for name in _ENDS)):
        return
    unknown = np.full(len(sheet.rows), np.nan)
    mild, severe = (sheet.numbers(x) if x in ends else unknown.copy() for x in _ENDS)
    # "> 12": level 12 was still mild, and no level was severe.
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
    """Numbers of the rows whose cell of `name` says "more than", which is taken off the cell."""
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
