"""Headings of a laboratory's columns: the quantity that each stands for, and its unit."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.laboratory.spreadsheet import Row, may_be_thousands, read_rows
from pipeline.scene.compounds import Table
from pipeline.scene.faults import Faults, did_you_mean, quoted
from pipeline.scene.kinds import OneOf
from pipeline.scene.units import TURNS, UnitError, si_unit, to_si
from tribo import InputError

_UNIT_AT_END = (
    re.compile(r"(?P<title>.*?)\s*\[(?P<unit>[^\[\]]*)\]"),
    re.compile(r"(?P<title>.*?)\s*\((?P<unit>[^()]*(?:\([^()]*\)[^()]*)?)\)"),
    re.compile(r"(?P<title>.*?)\s+in\s+(?P<unit>\S.*)"),
    re.compile(r"(?P<title>.*?)\s+/\s*(?P<unit>\S.*)"),
    re.compile(r"(?P<title>.*?),?\s+(?P<unit>\S+)"),
    re.compile(r"(?P<title>.*?)_(?P<unit>k?N|m?s|min|m/s|mm/s|degC|K|rpm)"),
    re.compile(r"(?P<title>[^/]*?)/(?P<unit>\S.*)"),
    re.compile(r"(?P<title>.*?)\s*,\s*(?P<unit>\S.*)"),
)
"""Ways to write a unit. All but the first count only if what stands there is a unit."""
_ROUND = re.compile(
    r"(?:[^.]*\b)?\w*(radius|diameter|durchmesser|raggio|diametro|rayon)", re.IGNORECASE
)
_TRACK = re.compile(
    r"track|spur|lauf(bahn|kreis|radius|durchmesser)|reib(bahn|kreis|radius|durchmesser|spur)"
    r"|piste|pista|huella|wear (circle|path)",
    re.IGNORECASE,
)
_EXPONENT = re.compile(r"(?<=[A-Za-z])(-\d)")
UNITS = {
    "load": "N", "velocity": "m/s", "friction": "", "bulk_temperature": "K", "hold": "s",
    "time": "s", "friction_force": "N", "critical_temperature": "K",
}  # fmt: skip
"""Units of quantities, empty of a number; of others nothing is guessed."""
_EXACT = {
    "normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature",
    "temperature.bulk": "bulk_temperature", "friction.coefficient": "friction",
    "temperature.critical": "critical_temperature",
}  # fmt: skip
_WORDS = {
    "load": (
        r"\b(load|force|normalkraft|kraft|last|belastung|charge|carico|carga|f ?n|f ?z|f)\b",
        r"\b(friction|reib\w*|tangential\w*|cell|step|stage|stufe|rate|limit|f ?[rtxy])\b",
    ),
    "velocity": (
        r"(\b(velocity|speed|v|vitesse)\b|geschw|velocit|velocidad)",
        r"(\b(entrain\w*|roll\w*|mean|sum\w*|hydro\w*)\b|mittlere|summen)",
    ),
    "friction": (
        r"(\b(cof|mu|µ|μ|friction)\b|reib(ungs)?(wert|zahl|koeff)|frottement|attrito|rozamiento)",
        r"(\b(force|torque|work|power|energy)\b|kraft|moment)",
    ),
    "bulk_temperature": (
        r"(\b(temp|temperature|bulk|t)\b|temperatur)",
        r"(\b(contact|flash|room|ambient|crit\w*|krit\w*|max)\b"
        r"|raum|umgebung|kontakt|blitz|grenz)",
    ),
    "critical_temperature": (
        r"(\b(crit|krit)\w*\b.*temp|temp.*\b(crit|krit)\w*\b|grenztemperatur)", r"$^",
    ),
    "hold": (r"(\b(hold|dwell)\b|halte(zeit|dauer))", r"$^"),
    "outcome": (
        r"(\b(outcome|result|verdict|scuff\w*|seizure|wear|regime|pass|status|résultat|esito|resultado)\b"
        r"|ergebnis|befund|bewertung|urteil|verschlei(ß|ss)(art|form)?$|fresse(r|n)\b)",
        r"\b(volume|rate|scar|depth|width|coefficient)\b",
    ),
    "friction_force": (
        r"((friction|tangential|frott|attrito) ?(force)?|reib\w*kraft|\bf ?[rtx]\b)",
        r"\b(torque|work|power|energy)\b",
    ),
    "time": (r"(\b(time|t|zeit|temps)\b)", r"\b(of day|date|stamp)\b"),
}  # fmt: skip
"""Words by which a heading names a quantity, and words by which it means another one."""
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


def heading_of(text: str) -> Heading:
    """Split a heading into title and unit: in brackets, in parentheses, after / or "in"."""
    text = text.strip().strip('"')
    for number, way in enumerate(_UNIT_AT_END):
        if match := way.fullmatch(text):
            unit = _usual_unit(match["unit"])
            if number == 0 or unit in ("", "1") or (match["title"] and is_unit(unit)):
                return Heading(text, match["title"].strip(" /"), unit)
    return Heading(text, text, "")


def _usual_unit(unit: str) -> str:
    """Unit without parentheses around it, and with powers that are read as such."""
    unit = unit.strip()
    if unit.startswith("(") and unit.endswith(")"):
        unit = unit[1:-1]
    if unit in ("C", "F"):  # no log is of charges or capacitances
        return f"°{unit}"
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
            faults.append(f"columns.{name}: there is no column {_listed([head])}")
    for name in (name for name in wanted if name not in named):
        free = [place for place in range(len(heads)) if place not in places.values()]
        found = [place for place in free if headings[place].name == name]
        if name == "friction":  # one in newton is a force
            found = [k for k in found if not (headings[k].unit and is_unit(headings[k].unit))]
        exact = [k for k in free if _is_another(headings[k], name, wanted)]
        found = found or [k for k in free if k not in exact and _means(headings[k], name)]
        if len(found) == 1:
            places[name] = found[0]
        elif found:
            several = _listed(heads[place] for place in found)
            faults.append(f'{len(found)} columns may be {name}: {several}; call one alone "{name}"')
    return places, faults


def _is_another(heading: Heading, name: str, wanted: Collection[str]) -> bool:
    """True if a heading names exactly another quantity that is wanted, in a unit of it."""
    is_named = heading.name in wanted and heading.name != name
    return is_named and not (
        heading.unit and heading.name in UNITS and _misfit(heading, heading.name)
    )


def _means(heading: Heading, name: str) -> bool:
    """True if the words of a heading are of a quantity, and its unit does not contradict."""
    if name not in _WORDS:
        return False
    words, unit = _words(heading), UNITS.get(name)
    of_it, of_another = _WORDS[name]
    if not re.search(of_it, words) or re.search(of_another, words):
        return False
    if heading.unit:
        return bool(unit) and not _misfit(heading, name)
    # A lone letter without a unit, as t or v, may be anything.
    return not unit or len(words) > 2


def _misfit(heading: Heading, name: str) -> str:
    """Reason why the unit of a heading is not one of a quantity; empty if it is."""
    try:
        to_si(f"1 {heading.unit}", f"1 {UNITS[name]}")
    except UnitError as error:
        return str(error)
    return ""


def _words(heading: Heading) -> str:
    """Words of a title, without signs and digits between them."""
    return re.sub(r"[\W_\d]+", " ", heading.title.lower()).strip()


def _with_units_below(headings: list[Heading], rows: list[Row]) -> tuple[list[Heading], list[Row]]:
    """Headings with the units of a first row that holds nothing else, and the other rows."""
    first = rows[0].cells if rows else []
    units = [heading_of(f"x [{cell.strip('[]()')}]").unit for cell in first]
    if not any(units) or not all(is_unit(unit) for unit in units if unit):
        return headings, rows
    pairs = zip(headings, units, strict=True)
    return [replace(one, unit=one.unit or unit) for one, unit in pairs], rows[1:]


class CellFault(NamedTuple):
    """What is wrong with an entry of a row."""

    row: int
    name: str
    problem: str


@dataclass(slots=True)
class Sheet:
    """Rows of a file or of columns, and the columns for wanted quantities."""

    headings: list[Heading]
    rows: list[Row]
    places: dict[str, int]  # column of each quantity that was found
    faults: list[str]  # of columns
    of_rows: list[str] = field(default_factory=list)  # faults of rows
    decimal: str = "."
    form: list[str] = field(default_factory=list)  # words on how the file was read
    track: int | None = None  # column of the track, of which velocities were made

    @property
    def others(self) -> list[int]:
        """Columns of no wanted quantity."""
        used = (*self.places.values(), self.track)
        return [k for k in range(len(self.headings)) if k not in used]

    @property
    def of_several(self) -> str:
        """Words on the sheet that was read, and on the workbook's others; empty if it has none."""
        return next((words for words in self.form if "(not read: " in words), "")

    def heading(self, name: str) -> Heading:
        """Heading of a quantity."""
        return self.headings[self.places[name]]

    def doubt(self, cell: str) -> str:
        """Reason why a cell may be another number; empty if it is plain."""
        if self.decimal != "," or not may_be_thousands(cell):
            return ""
        number = cell.split(" ")[0]
        return (
            f'"{cell}" beside decimal commas is {float(number):g} or {number.replace(".", "")}; '
            'write it plainly, or give the decimal mark of the file, as decimal = "." or ","'
        )

    def entries(
        self, row_of: Table, words: Mapping[str, str]
    ) -> tuple[list[dict[str, Any]], list[dict[str, Any]], list[CellFault]]:
        """Sound rows as tables of a scene, with outcomes for words; the same in SI; and faults."""
        tables, read, faults = [], [], list[CellFault]()
        for row in self.rows:
            table, wrong = dict[str, Any](), Faults()
            for name, place in self.places.items():
                if not (cell := row.cells[place]):
                    continue
                if isinstance(row_of.keys[name].kind, OneOf):
                    table[name] = words.get(cell, cell)
                    continue
                table[name] = as_entry(cell, self.headings[place].unit)
                if doubt := self.doubt(cell):
                    wrong.note(name, doubt)
            values = row_of.read(table, "", wrong)
            if not wrong:
                tables.append(table)
                read.append(values)
            for name, problem, *_ in wrong:
                unit = f'such as "{name} [{UNITS.get(name, "...")}]"'
                hint = f"; or the unit of the column in its heading, {unit}"
                problem += hint * ("has no unit" in problem)
                if name in self.places or name not in row_of.keys:  # a missing one is said once
                    faults.append(CellFault(row.number, name, problem))
        return tables, read, faults


def as_entry(cell: str, unit: str = "") -> str | float:
    """A cell as a scene file has it: a number, or text with a unit."""
    for number in (int, float) if not unit else ():
        with suppress(ValueError):
            return number(cell)
    return f"{cell} {unit}".strip()


def listed_faults(faults: Iterable[CellFault]) -> list[str]:
    """Faults of rows, those of one kind in one line."""
    alike = dict[tuple[str, str], list[CellFault]]()
    for one in faults:
        kind = re.sub(r'"(\\.|[^"\\])*"|[\d.]+', "", one.problem)
        alike.setdefault((one.name, kind), []).append(one)
    return [
        f"{numbered([one.row for one in some])}, {some[0].name}: {some[0].problem}"
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
) -> Sheet:
    """Read the rows of a file below headings; for the arguments see `columns_for`."""

    def is_heading(cells: list[str]) -> bool:
        places, faults = columns_for([*map(heading_of, cells)], wanted, named)
        return is_log(places) and not (named and faults)

    read = read_rows(path, is_heading, decimal, sheet_name)
    headings, rows = _with_units_below([*map(heading_of, read.heads)], read.rows)
    sheet = Sheet(headings, rows, {}, [], [*read.faults], read.decimal, read.form)
    _take_velocity_of_turns(sheet)
    return _with_places(sheet, wanted, needed, named)


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
    sheet = _with_places(Sheet([*map(heading_of, listed)], rows, {}, []), wanted, needed)
    for name, place in sheet.places.items():
        unit = "" if sheet.headings[place].unit else f" {UNITS.get(name, '')}"
        for row in rows:
            cell: Any = row.cells[place]
            if not isinstance(cell, str):
                row.cells[place] = "" if str(cell) in _ABSENT else f"{cell}{unit}"
    return sheet


def _with_places(
    sheet: Sheet,
    wanted: Collection[str],
    needed: Collection[str],
    named: Mapping[str, str] | None = None,
) -> Sheet:
    """The sheet with the columns for wanted quantities, of which some are needed."""
    places, faults = columns_for(sheet.headings, wanted, named)
    missing = [name for name in needed if name not in places]
    if missing and sheet.headings and not faults:
        wrong = [
            f'"{heading.text}": {misfit}'
            for heading in sheet.headings
            for name in missing
            if heading.unit and _may_be(heading, name) and (misfit := _misfit(heading, name))
        ]
        near = "".join(did_you_mean(heading.name, missing) for heading in sheet.headings)
        columns = _listed(f"{n} [{UNITS[n]}]" if UNITS.get(n) else n for n in missing)
        hint = f" ({'; '.join(wrong)})" if wrong else near
        faults = [f"no column {columns} in {_listed(one.text for one in sheet.headings)}{hint}"]
    return replace(sheet, places=places, faults=faults)


def _may_be(heading: Heading, name: str) -> bool:
    """True if the words or the unit of a heading are those of a quantity in another form."""
    if name == "velocity" and heading.unit in TURNS:
        return True
    return name in UNITS and re.search(_WORDS[name][0], _words(heading)) is not None


def _take_velocity_of_turns(sheet: Sheet) -> None:
    """Put a velocity in place of a rotation, where a column has the radius or diameter."""
    turning = [k for k, heading in enumerate(sheet.headings) if heading.unit in TURNS]
    round_ = [k for k, heading in enumerate(sheet.headings) if _ROUND.fullmatch(heading.title)]
    tracks = [k for k in round_ if _TRACK.search(sheet.headings[k].title)]
    if len(turning) == 1 and round_ and len(tracks) != 1:
        heads = [sheet.headings[k].text for k in round_]
        sheet.of_rows.append(
            f'column "{sheet.headings[turning[0]].text}" is a rotation, and none of '
            f'{_listed(heads)} is surely its track; call that column "track diameter [mm]" or '
            '"track radius [mm]", or give a velocity'
        )
    if len(turning) != 1 or len(tracks) != 1:
        return
    (turn,), (k,) = turning, tracks
    track = sheet.headings[k]
    is_radius = re.search(r"(radius|raggio|rayon)$", track.title.lower())
    which = "radius" if is_radius else "diameter"
    if not track.unit:
        fault = f'column "{track.text}" has no unit; name it like "track {which} [mm]"'
        sheet.of_rows.append(fault)
        return
    sheet.track = k
    sheet.headings[turn] = heading_of("velocity")
    for _, cells in sheet.rows:
        at = f" at {which} {cells[k]} {track.unit}" if cells[k] else ""
        cells[turn] = cells[turn] and f"{cells[turn]} rpm{at}"


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(map(quoted, texts))
