"""Headings of a laboratory's columns: the quantity that each stands for, and its unit."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.scene.faults import did_you_mean
from pipeline.scene.rows import Row, Rows, read_rows
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
_TRACK = re.compile(r"(?:[^.]*\b)?(radius|diameter|durchmesser)", re.IGNORECASE)
_EXPONENT = re.compile(r"(?<=[A-Za-z])(-\d)")
_DIMENSION = {
    "load": "N", "velocity": "m s-1", "friction": "1", "bulk_temperature": "K", "hold": "s",
    "time": "s", "friction_force": "N",
}  # fmt: skip
"""Units in SI of quantities; of others nothing is guessed."""
_EXACT = {
    "normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature",
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
        r"(\b(contact|flash|room|ambient|crit\w*|max)\b|raum|umgebung|kontakt|blitz)",
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
    if unit == "C":  # no log is of charges
        return "°C"
    return "" if unit in ("-", "–", "–", "1") else _EXPONENT.sub(r"^\1", unit)


@cache
def is_unit(unit: str) -> bool:
    """True of a unit of any dimension."""
    try:
        return bool(si_unit(f"1 {unit}")) and not unit.isdigit()
    except UnitError:
        return False


def columns_for(
    heads: Sequence[str], wanted: Collection[str], chosen: Mapping[str, str] | None = None
) -> tuple[dict[str, int], list[str]]:
    """Places of the columns for wanted quantities, and faults.

    A column is one that the user chose by its heading, or that names the quantity exactly, or the
    only one whose words and unit are of that quantity.
    """
    headings = [heading_of(head) for head in heads]
    chosen = chosen or {}
    places: dict[str, int] = {}
    faults = []
    for name, head in chosen.items():
        if name not in wanted:
            hint = did_you_mean(name, wanted)
            faults.append(f"columns.{name}: no entry{hint}; give one of {', '.join(wanted)}")
        elif head in heads:
            places[name] = heads.index(head)
        else:
            faults.append(f"columns.{name}: there is no column {_listed([head])}")
    for name in wanted:
        if name in chosen:
            continue
        free = [place for place in range(len(heads)) if place not in places.values()]
        found = [place for place in free if headings[place].name == name]
        if name == "friction":  # one in newton is a force
            found = [place for place in found if not is_unit(headings[place].unit)]
        found = found or [place for place in free if _means(headings[place], name)]
        if len(found) == 1:
            places[name] = found[0]
        elif found:
            several = _listed(heads[place] for place in found)
            faults.append(f'{len(found)} columns may be {name}: {several}; call one alone "{name}"')
    return places, faults


def _means(heading: Heading, name: str) -> bool:
    """True if the words of a heading are of a quantity, and its unit does not contradict."""
    if name not in _WORDS:
        return False
    words = _words(heading)
    of_it, of_another = _WORDS[name]
    if not re.search(of_it, words) or re.search(of_another, words):
        return False
    needed = _DIMENSION.get(name)
    if heading.unit:
        return needed not in (None, "1") and _is_of(heading.unit, str(needed))
    # A lone letter without a unit, as t or v, may be anything.
    return needed in (None, "1") or len(words) > 2


def _is_of(unit: str, needed: str) -> bool:
    degrees = {"C": "degC", "F": "degF"} if needed == "K" else {}
    unit = degrees.get(unit, unit)
    return is_unit(unit) and si_unit(f"1 {unit}") == needed


def with_units_below(heads: list[str], rows: list[Row]) -> tuple[list[str], list[Row]]:
    """Headings with the units of a first row that holds nothing else, and the other rows."""
    first = rows[0].cells if rows else []
    units = [heading_of(f"x [{cell.strip('[]()')}]").unit for cell in first]
    if not any(map(is_unit, filter(None, units))) or not all(
        not unit or is_unit(unit) for unit in units
    ):
        return heads, rows
    return [
        f"{head} [{unit}]" if unit and not heading_of(head).unit else head
        for head, unit in zip(heads, units, strict=True)
    ], rows[1:]


def with_velocity_of_turns(read: Rows) -> Rows:
    """Rows with a velocity in place of a rotation, where a column has the radius or diameter."""
    headings = [heading_of(head) for head in read.heads]
    turning = [k for k, heading in enumerate(headings) if heading.unit in TURNS]
    lengths = [
        (k, match[1]) for k, one in enumerate(headings) if (match := _TRACK.fullmatch(one.title))
    ]
    if len(turning) != 1 or len(lengths) != 1:
        return read
    (turn,), ((length, word),) = turning, lengths
    which = "radius" if word.lower() == "radius" else "diameter"
    if not headings[length].unit:
        fault = f'column "{read.heads[length]}" has no unit; name it like "track {which} [mm]"'
        return read._replace(faults=[*read.faults, fault])
    heads = [*read.heads[:turn], "velocity", *read.heads[turn + 1 :]]
    rows = []
    for number, cells in read.rows:
        track = f" at {which} {cells[length]} {headings[length].unit}" if cells[length] else ""
        said = f"{cells[turn]} rpm{track}" if cells[turn] else ""
        rows.append(Row(number, [*cells[:turn], said, *cells[turn + 1 :]]))
    return read._replace(heads=heads, rows=rows)


class Sheet(NamedTuple):
    """Rows of a file or of columns, as `Rows`, and the columns for wanted quantities."""

    heads: list[str]
    labelled: list[str]  # headings with units that stand in a row below them
    places: dict[str, int]  # column of each quantity that was found
    rows: list[Row]
    decimal: str
    form: list[str]
    faults: list[str]  # of columns
    of_rows: list[str]  # faults of rows

    def heading(self, name: str) -> Heading:
        """Heading of a quantity."""
        return heading_of(self.labelled[self.places[name]])


def read_sheet(
    path: Path,
    wanted: Collection[str],
    needed: Collection[str],
    named: Mapping[str, str] | None = None,
    decimal: str | None = None,
) -> Sheet:
    """Read the rows of a file below headings of a load and a velocity; see `columns_for`."""

    def is_heading(cells: list[str]) -> bool:
        places, faults = columns_for(cells, wanted, named)
        return not faults and {"load", "velocity"} <= places.keys()

    read = with_velocity_of_turns(read_rows(path, is_heading, decimal))
    labelled, rows = with_units_below(read.heads, read.rows)
    places, faults = columns_for(read.heads if named else labelled, wanted, named)
    if (missing := [name for name in needed if name not in places]) and read.heads and not faults:
        faults = [missing_columns(labelled, missing)]
    form = read.decimal, read.form
    return Sheet(read.heads, labelled, places, rows, *form, faults, read.faults)


def sheet_of(columns: Any, wanted: Collection[str]) -> Sheet:
    """Columns of a mapping or a data frame as those of a file; all the wanted ones are needed."""
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
    heads = [*listed]
    rows = [Row(k, [*cells]) for k, cells in enumerate(zip(*listed.values(), strict=True), 1)]
    places, faults = columns_for(heads, wanted)
    if (missing := [name for name in wanted if name not in places]) and not faults:
        faults = [missing_columns(heads, missing)]
    return Sheet(heads, heads, places, rows, ".", [], faults, [])


def missing_columns(heads: Sequence[str], missing: Sequence[str]) -> str:
    """Say which columns are missing among those of a file."""
    wrong = []
    for heading in map(heading_of, heads):
        meant = [name for name in missing if _has_words(heading, name)]
        if "velocity" in missing and heading.unit in TURNS:
            meant = ["velocity"]
        if heading.unit and any(not _is_of(heading.unit, _DIMENSION.get(n, "1")) for n in meant):
            said = f"{_listed([heading.text])} is in {heading.unit}"
            wrong.append(said + _cure(heading.unit, _DIMENSION.get(meant[0], "1")))
    near = "".join(did_you_mean(heading_of(head).name, missing) for head in heads)
    units = {"load": "load [N]", "velocity": "velocity [m/s]"}
    wanted = _listed(units.get(name, name) for name in missing)
    hint = f" ({'; '.join(wrong)})" if wrong else near
    return f"no column {wanted} in {_listed(heads)}{hint}"


def _cure(unit: str, needed: str) -> str:
    """What to give for a column in a unit of another dimension, such as rpm for m/s."""
    try:
        to_si(f"1 {unit}", f"1 {needed.replace(' s-1', '/s')}")
    except UnitError as error:
        return "".join(str(error).partition("; ")[1:])
    return ""


def _has_words(heading: Heading, name: str) -> bool:
    return name in _WORDS and re.search(_WORDS[name][0], _words(heading)) is not None


def _words(heading: Heading) -> str:
    """Words of a title, without signs and digits between them."""
    return re.sub(r"[\W_\d]+", " ", heading.title.lower()).strip()


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(json.dumps(text, ensure_ascii=False) for text in texts)
