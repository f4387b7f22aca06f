"""Rows of a table below headings: the quantity that each column stands for, and its unit.

Alone this reads plain CSV, whose headings name quantities exactly, with units in brackets. The
extra of laboratories brings the other ways to write them, as its module ``headings``.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline import extras
from pipeline.quantities import units_in_si
from pipeline.scene.compounds import Table
from pipeline.scene.faults import Fault, Faults, did_you_mean, fault_lines, quoted
from pipeline.scene.kinds import OneOf
from pipeline.scene.units import UnitError, si_unit, to_si
from pipeline.sweep.conditions import PATHS
from tribo import InputError
from tribo.errors import require_file

_IN_BRACKETS = re.compile(r"(?P<title>.*?)\s*\[(?P<unit>[^\[\]]*)\]")
_EXPONENT = re.compile(r"(?<=[A-Za-z])(-\d)")
_MEANT = {
    "C": "°C", "F": "°F", "kg": "kgf", "kp": "kgf", "lb": "lbf", "lbs": "lbf", "Nm": "N m",
}  # fmt: skip
"""Units meant by others: no log is of charges or capacitances, and a mass there is a weight."""
UNITS = units_in_si(
    "load", "velocity", "friction", "bulk_temperature", "hold", "time", "friction_force",
    "critical_temperature",
)  # fmt: skip
"""Units of quantities, empty of a number; of others nothing is guessed."""
_EXACT = {
    "normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature",
    **{path: name for name, path in PATHS.items() if name in UNITS},
}  # fmt: skip
BESIDE = "friction.", "temperature."
"""Beginnings of paths of a scene, which say exactly what a column is."""
_SHOWN = 6  # rows of a fault that are named
_ABSENT = "nan", "None", "NaT", "<NA>"  # what a cell of a data frame without a value is as text


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading: as it stands in the file, its title without the unit, and the unit."""

    text: str
    title: str
    unit: str

    @property
    def name(self) -> str:
        """Entry of a scene that it names exactly, if it is one."""
        name = self.title.lower().replace(" ", "_")
        return _EXACT.get(name, name)

    @property
    def label(self) -> str:
        """The heading with its unit, which may stand below it."""
        is_within = heading_of(self.text).unit == self.unit
        return self.text if is_within else f"{self.text} [{self.unit}]"


class Row(NamedTuple):
    """Cells of a row, and its number in the file."""

    number: int
    cells: list[str]


@cache
def _laboratory() -> Any:
    """Module that reads what laboratories write; None where that extra is not there."""
    return next(extras.modules("headings"), None)


def heading_of(text: str) -> Heading:
    """Split a heading into title and unit."""
    text = text.strip().strip('"')
    if match := _IN_BRACKETS.fullmatch(text):
        return Heading(text, match["title"].strip(" /"), usual_unit(match["unit"]))
    return _laboratory().heading_of(text) if _laboratory() else Heading(text, text, "")


def usual_unit(unit: str) -> str:
    """Unit without parentheses around it, and with powers that are read as such."""
    unit = unit.strip()
    if unit.startswith("(") and unit.endswith(")"):
        unit = unit[1:-1]
    unit = _MEANT.get(unit, unit)
    return "" if unit in ("-", "–", "–", "1") else _EXPONENT.sub(r"^\1", unit)


@cache
def is_unit(unit: str) -> bool:
    """True of a unit of any dimension."""
    try:
        # A lone µ, once a micron, is a coefficient of friction.
        return unit not in "µμ" and bool(si_unit(f"1 {unit}")) and not unit.isdigit()
    except UnitError:
        return False


def columns_for(
    headings: Sequence[Heading], wanted: Collection[str], named: Mapping[str, str] | None = None
) -> tuple[dict[str, int], list[str]]:
    """Places of the columns for wanted quantities, and faults.

    A column is one that the user chose, that names the quantity exactly, or the only one whose
    words and unit are of it.
    """
    heads, named = [heading.text for heading in headings], named or {}
    places: dict[str, int] = {}
    faults = []
    for name, head in named.items():
        if name not in wanted:
            hint = did_you_mean(name, wanted)
            faults.append(f"columns.{name}: no entry{hint}; give one of {', '.join(wanted)}")
        elif head in heads:
            places[name] = heads.index(head)
        else:
            faults.append(f"columns.{name}: there is no column {listed([head])}")
    for name in (name for name in wanted if name not in named):
        free = [place for place in range(len(heads)) if place not in places.values()]
        found = [place for place in free if headings[place].name == name]
        if name == "friction":  # one in newton is a force
            found = [k for k in found if not (headings[k].unit and is_unit(headings[k].unit))]
        exact = [k for k in free if _is_another(headings[k], name, wanted)]
        if _laboratory():
            others = [k for k in free if not (k in exact or headings[k].title.startswith(BESIDE))]
            found = found or [k for k in others if _laboratory().is_named(headings[k], name)]
        if len(found) == 1:
            places[name] = found[0]
        elif found:
            several = listed(heads[place] for place in found)
            faults.append(f'{len(found)} columns may be {name}: {several}; call one alone "{name}"')
    return places, faults


def _is_another(heading: Heading, name: str, wanted: Collection[str]) -> bool:
    """True if a heading names exactly another quantity that is wanted, in a unit of it."""
    is_named = heading.name in wanted and heading.name != name
    return is_named and not (
        heading.unit and heading.name in UNITS and misfit(heading, heading.name)
    )


def misfit(heading: Heading, name: str) -> str:
    """Reason why the unit of a heading is not one of a quantity; empty if it is."""
    try:
        to_si(f"1 {heading.unit}", f"1 {UNITS[name]}")
    except UnitError as error:
        return str(error)
    return ""


@dataclass(slots=True)
class Sheet:
    """Rows of a file or of columns, and the columns for wanted quantities."""

    headings: list[Heading]
    rows: list[Row]  # that are not empty, with decimal points
    places: dict[str, int]  # column of each quantity that was found
    faults: list[str]  # those of columns
    of_rows: list[str] = field(default_factory=list)  # faults of rows
    decimal: str = "."  # mark of decimals in the file
    form: list[str] = field(default_factory=list)  # words on separators, decimals and encoding
    made_of: set[int] = field(default_factory=set)  # columns of which others were made
    sure: set[int] = field(default_factory=set)  # columns that are made, or given beside the file
    above: str = ""  # text of the lines above the headings

    @property
    def others(self) -> list[int]:
        """Columns of no wanted quantity."""
        used = {*self.places.values(), *self.made_of}
        return [k for k in range(len(self.headings)) if k not in used]

    @property
    def sheet_notes(self) -> str:
        """Note on the sheet that was read, and on the other sheets; empty if there are none."""
        return next((words for words in self.form if "(not read: " in words), "")

    def heading(self, name: str) -> Heading:
        """Heading of a quantity."""
        return self.headings[self.places[name]]

    def doubt(self, cell: str) -> str:
        """Reason why a cell may be another number; empty if it is plain."""
        if self.decimal != "," or not _laboratory().may_be_thousands(cell):
            return ""
        number = cell.split(" ")[0]
        return (
            f'"{cell}" beside decimal commas is {float(number):g} or {number.replace(".", "")}; '
            'write it plainly, or give the decimal mark of the file, as decimal = "." or ","'
        )

    def entries(
        self, row_of: Table, words: Mapping[str, str]
    ) -> tuple[list[dict[str, Any]], list[dict[str, Any]], list[Fault]]:
        """Sound rows as tables of a scene, with outcomes for words; the same in SI; and faults."""
        tables, read, faults = [], [], list[Fault]()
        for row in self.rows:
            table, wrong = dict[str, Any](), Faults()
            for name, place in self.places.items():
                if not (cell := row.cells[place]):
                    continue
                if isinstance(row_of.keys[name].kind, OneOf):
                    table[name] = words.get(cell, cell)
                    continue
                table[name] = as_entry(cell, self.headings[place].unit)
                if place not in self.sure and (doubt := self.doubt(cell)):
                    wrong.refuse(name, doubt)
            if "number" in row_of.keys:
                table.setdefault("number", f"row {row.number}")
            values = row_of.read(table, "", wrong)
            if not wrong:
                tables.append(table)
                read.append(values)
            for name, problem, *_ in wrong:
                unit = f'such as "{name} [{UNITS.get(name, "...")}]"'
                hint = f"; or the unit of the column in its heading, {unit}"
                problem += hint * ("has no unit" in problem)
                if name in self.places or name not in row_of.keys:  # a missing one is said once
                    faults.append(Fault(name, problem, row=row.number))
        return tables, read, faults


def as_entry(cell: str, unit: str = "") -> str | float:
    """A cell as a scene file has it: a number, or text with a unit."""
    for number in (int, float) if not unit else ():
        with suppress(ValueError):
            return number(cell)
    return f"{cell} {unit}".strip()


def listed_faults(faults: Iterable[Fault]) -> list[str]:
    """Faults of rows, those of one kind in one line."""
    alike = dict[tuple[str, str], list[Fault]]()
    for one in faults:
        kind = re.sub(r'"(\\.|[^"\\])*"|[\d.]+', "", one.problem)
        alike.setdefault((one.key, kind), []).append(one)
    return [
        f"{numbered([one.row for one in some])}, {some[0].key}: {some[0].problem}"
        for some in alike.values()
    ]


def numbered(numbers: Sequence[int]) -> str:
    """Rows in words, such as "rows 2, 3 and 5"."""
    if len(numbers) == 1:
        return f"row {numbers[0]}"
    shown = [str(number) for number in numbers[:_SHOWN]]
    more = f"{len(numbers) - _SHOWN} more" if len(numbers) > _SHOWN else shown.pop()
    return f"rows {', '.join(shown)} and {more}"


def read_sheet(
    path: Path,
    wanted: Collection[str],
    needed: Collection[str],
    named: Mapping[str, str] | None = None,
    decimal: str | None = None,
    is_log: Callable[[Collection[str]], bool] = {"load", "velocity"}.issubset,
    sheet_name: str | None = None,
    given: Mapping[str, Any] | None = None,
) -> Sheet:
    """Read the rows of a file below headings; for the arguments see `columns_for`.

    If quantities are given, even an empty mapping, the rows are tests, perhaps in the form of a
    machine.
    """

    def is_heading(cells: list[str], above: str) -> bool:
        headings = [*map(heading_of, cells)]
        places, faults = columns_for(headings, wanted, named)
        said = f"{path.stem} {above}"
        is_form = given is not None and laboratory.is_rig(headings, said)
        return is_form or (is_log(places) and not (named and faults))

    needs_more = decimal or sheet_name or given is not None or path.suffix.lower() != ".csv"
    laboratory = extras.module("laboratory", "headings") if needs_more else _laboratory()
    if laboratory:
        sheet = laboratory.read_rows(path, is_heading, decimal, sheet_name)
        laboratory.tidy(sheet, path.stem, given)
    else:
        sheet = _read_csv(path)
    return _placed_columns(sheet, wanted, needed, named)


def _read_csv(path: Path) -> Sheet:
    """Read the rows of plain CSV; lines that begin with ``#`` are comments."""
    require_file(path)
    try:
        lines = [*csv.reader(path.read_text(encoding="utf-8-sig").splitlines())]
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(f"{path} cannot be read: {error}; save it as CSV in UTF-8") from error
    filled = [
        Row(number, [*map(str.strip, cells)])
        for number, cells in enumerate(lines, 1)
        if any(cells) and not cells[0].startswith("#")
    ]
    return sheet_below(filled[0].cells if filled else [], filled[1:])


def sheet_below(
    heads: Sequence[str], rows: Sequence[Row], decimal: str = ".", form: Sequence[str] = ()
) -> Sheet:
    """Sheet of headings and the rows below them; those of another length are left out as faults."""
    unlike = [row for row in rows if len(row.cells) != len(heads)]
    faults = [f"row {n}: {len(cells)} cells below {len(heads)} headings" for n, cells in unlike]
    whole = [row for row in rows if len(row.cells) == len(heads)]
    return Sheet([*map(heading_of, heads)], whole, {}, [], faults, decimal, [*form])


def read_table(
    source: Any,
    row_of: Table,
    needed: Collection[str],
    first_line: str,
    sheet_name: str | None = None,
    column_faults: Callable[[Sheet], Iterable[str]] = lambda _: (),
) -> tuple[Sheet, list[dict[str, Any]]]:
    """Read a file, or columns by heading as a data frame has them, and the rows in SI.

    An `InputError` names all faults at once, by row and column. A first line is asked for where
    there are no rows.
    """
    name = "points"
    if isinstance(source, str | os.PathLike):
        name, is_log = str(source), set(needed).issubset
        sheet = read_sheet(Path(source), row_of.keys, needed, is_log=is_log, sheet_name=sheet_name)
    else:
        sheet = sheet_of(source, row_of.keys, needed)
    _, rows, wrong = sheet.entries(row_of, {})
    faults = [*column_faults(sheet), *sheet.faults, *sheet.of_rows, *listed_faults(wrong)]
    if not sheet.rows and not faults:
        faults = [f'there are no rows; begin with a line "{first_line}"']
    if faults:
        more = f", {sheet.sheet_notes}; --sheet names another" if sheet.sheet_notes else ""
        raise InputError(fault_lines(name + more, faults))
    return sheet, rows


def sheet_of(columns: Any, wanted: Collection[str], needed: Collection[str]) -> Sheet:
    """Columns of a mapping or a data frame as those of a file, with bare numbers in SI."""
    if not hasattr(columns, "keys"):
        raise InputError(
            f"points are of type {type(columns).__name__}; give a .csv or .xlsx file, or columns "
            'by heading such as {"load": ["500 N"], "velocity": ["2 m/s"]}'
        )
    listed = {str(head): np.atleast_1d(columns[head]).tolist() for head in columns}
    lengths = {head: len(cells) for head, cells in listed.items()}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{head} {count}" for head, count in lengths.items())
        raise InputError(f"points: columns of unlike lengths: {counts}; give one of each in a row")
    rows = [Row(k, [*cells]) for k, cells in enumerate(zip(*listed.values(), strict=True), 1)]
    sheet = _placed_columns(sheet_below([*listed], rows), wanted, needed, None)
    for name, place in sheet.places.items():
        unit = "" if sheet.headings[place].unit else f" {UNITS.get(name, '')}"
        for row in rows:
            cell: Any = row.cells[place]
            if not isinstance(cell, str):
                row.cells[place] = "" if str(cell) in _ABSENT else f"{cell}{unit}"
    return sheet


def _placed_columns(
    sheet: Sheet, wanted: Collection[str], needed: Collection[str], named: Mapping[str, str] | None
) -> Sheet:
    """The sheet that has columns for the wanted quantities; some of them are needed."""
    places, faults = columns_for(sheet.headings, wanted, named)
    missing = [name for name in needed if name not in places]
    if missing and sheet.headings and not faults:
        wrong = [
            f'"{heading.text}": {wrong_unit}'
            for heading in sheet.headings
            for name in missing
            if heading.unit
            and _laboratory()
            and _laboratory().may_be(heading, name)
            and (wrong_unit := misfit(heading, name))
        ]
        near = "".join(did_you_mean(heading.name, missing) for heading in sheet.headings)
        columns = listed(f"{n} [{UNITS[n]}]" if UNITS.get(n) else n for n in missing)
        hint = f" ({'; '.join(wrong)})" if wrong else near
        faults = [f"no column {columns} in {listed(one.text for one in sheet.headings)}{hint}"]
    return replace(sheet, places=places, faults=faults)


def listed(texts: Iterable[str]) -> str:
    """Texts in quotes, one after the other."""
    return ", ".join(map(quoted, texts))
