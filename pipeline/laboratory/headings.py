"""Headings as laboratories write them, in several languages, and what follows from columns."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from pipeline.laboratory.logs import outcome_of
from pipeline.laboratory.machines import form_of, read_form
from pipeline.laboratory.spreadsheet import may_be_thousands as may_be_thousands
from pipeline.laboratory.spreadsheet import read_rows as read_rows
from pipeline.scene.headings import UNITS, Heading, Sheet, is_unit, listed, misfit, usual_unit
from pipeline.scene.headings import heading_of as split_heading
from pipeline.scene.units import TURNS

_UNIT_AT_END = (
    re.compile(r"(?P<title>.*?)\s*\((?P<unit>[^()]*(?:\([^()]*\)[^()]*)?)\)"),
    re.compile(r"(?P<title>.*?)\s+in\s+(?P<unit>\S.*)"),
    re.compile(r"(?P<title>.*?)\s+/\s*(?P<unit>\S.*)"),
    re.compile(r"(?P<title>.*?),?\s+(?P<unit>\S+)"),
    re.compile(r"(?P<title>.*?)_(?P<unit>k?N|m?s|min|m/s|mm/s|degC|K|rpm)"),
    re.compile(r"(?P<title>[^/]*?)/(?P<unit>\S.*)"),
    re.compile(r"(?P<title>.*?)\s*,\s*(?P<unit>\S.*)"),
)
"""Ways to write a unit. They count only if what stands there is one."""
_NUMBER = re.compile(r"[<>≥+-]?\s*\d[\d.,]*(\s|\+|$)")
_ROUND = re.compile(r"(?:[^.]*\b)?\w*(radius|diameter|durchmesser)", re.IGNORECASE)
_TRACK = re.compile(
    r"track|spur|lauf(bahn|kreis|radius|durchmesser)|reib(bahn|kreis|radius|durchmesser|spur)"
    r"|wear (circle|path)",
    re.IGNORECASE,
)
_WORDS = {
    "load": (
        r"\b(load|force|(normal|prüf)?(kraft|last)|belastung|f ?n|f ?z|f)\b",
        r"\b(friction|reib\w*|tangential\w*|cell|step|stage|stufe|rate|limit|f ?[rtxy])\b",
    ),
    "velocity": (
        r"(\b(velocity|speed|v)\b|geschw)",
        r"(\b(entrain\w*|roll\w*|mean|sum\w*|hydro\w*)\b|mittlere|summen)",
    ),
    "friction": (
        r"(\b(cof|mu|µ|μ|friction)\b|reib(ungs)?(wert|zahl|koeff))",
        r"(\b(force|torque|work|power|energy)\b|kraft|moment)",
    ),
    "bulk_temperature": (
        r"(temp\b|\b(temperature|bulk|t)\b|temperatur)",
        r"(\b(contact|flash|room|ambient|crit\w*|krit\w*|max)\b"
        r"|raum|umgebung|kontakt|blitz|grenz)",
    ),
    "critical_temperature": (
        r"(\b(crit|krit)\w*\b.*temp|temp.*\b(crit|krit)\w*\b|grenztemperatur)", r"$^",
    ),
    "hold": (r"(\b(hold|dwell)\b|halte(zeit|dauer))", r"$^"),
    "number": (
        r"^((test|versuch)( (no|nr|n|number|nummer))?|no|nr|nummer)$", r"$^",
    ),
    "oil": (
        r"^(test )?(oil|öl|oel|lubricants?|lube|schmierstoff|fluid|grease|fett)"
        r"( ?(name|code|id|type|sorte))?$", r"$^",
    ),
    "run": (
        r"\b(run|specimen|lauf|prüfling|probe)\b",
        r"\b(running|run in|time|speed|length|temp\w*|out)\b",
    ),
    "outcome": (
        r"(\b(outcome|result|verdict|scuff\w*|seizure|wear|regime|pass|status)\b"
        r"|ergebnis|befund|bewertung|urteil|verschlei(ß|ss)(art|form)?$|fresse(r|n)\b)",
        r"\b(volume|rate|scar|depth|width|coefficient)\b",
    ),
    "friction_force": (
        r"((friction|tangential) ?(force)?|reib\w*kraft|\bf ?[rtx]\b)",
        r"\b(torque|work|power|energy)\b",
    ),
    "time": (r"(\b(time|t|zeit)\b)", r"\b(of day|date|stamp)\b"),
}  # fmt: skip
"""Words by which a heading names a quantity, and words by which it means another one."""


def heading_of(text: str) -> Heading:
    """Split a heading into title and unit: in parentheses, after / or "in"."""
    for way in _UNIT_AT_END:
        if match := way.fullmatch(text):
            unit = usual_unit(match["unit"])
            if unit in ("", "1") or (match["title"] and is_unit(unit)):
                return Heading(text, match["title"].strip(" /"), unit)
    return Heading(text, text, "")


def is_named(heading: Heading, name: str) -> bool:
    """True if the words of a heading are of a quantity, and its unit does not contradict."""
    if name not in _WORDS:
        return False
    words, unit = _words(heading), UNITS.get(name)
    of_it, of_another = _WORDS[name]
    if not re.search(of_it, words) or re.search(of_another, words):
        return False
    if heading.unit:
        return bool(unit) and not misfit(heading, name)
    # A lone letter without a unit, as t or v, may be anything.
    return not unit or len(words) > 2


def may_be(heading: Heading, name: str) -> bool:
    """True if the words or the unit of a heading are those of a quantity in another form."""
    if name == "velocity" and heading.unit in TURNS:
        return True
    return name in UNITS and re.search(_WORDS[name][0], _words(heading)) is not None


def _words(heading: Heading) -> str:
    """Words of a title, without signs and digits between them."""
    return re.sub(r"[\W_\d]+", " ", heading.title.lower()).strip()


def is_rig(headings: Sequence[Heading], stem: str) -> bool:
    """True of headings of a machine's form, or of a rotation beside its track."""
    is_turning = any(heading.unit in TURNS for heading in headings)
    has_track = any(_TRACK.search(heading.title) for heading in headings)
    return (is_turning and has_track) or form_of(headings, stem) is not None


def tidy(sheet: Sheet, stem: str, given: Mapping[str, Any] | None) -> None:
    """Take units from a first row that holds no number, and a velocity from a rotation.

    Of tests, where quantities may be given, load and velocity are taken from a machine's form.
    """
    first = sheet.rows[0].cells if sheet.rows else []
    units = [split_heading(f"x [{cell.strip('[]()')}]").unit for cell in first]
    known = [unit if unit == "%" or is_unit(unit) else "" for unit in units]
    if any(known) and not any(map(_NUMBER.match, first)):
        pairs = zip(sheet.headings, known, strict=True)
        sheet.headings = [replace(one, unit=one.unit or unit) for one, unit in pairs]
        del sheet.rows[0]
    has_runs = any(is_named(heading, "run") for heading in sheet.headings)
    if given is None or not read_form(sheet, f"{stem} {sheet.above}", given, has_runs):
        _take_velocity_of_turns(sheet)
    else:
        _name_outcome(sheet)


def _name_outcome(sheet: Sheet) -> None:
    """Take remarks for outcomes if all are, at least one is severe, and no column is called so."""
    heads = sheet.headings
    if any(is_named(heading, "outcome") for heading in heads):
        return
    told = {
        k: {outcome_of(row.cells[k], "") for row in sheet.rows if row.cells[k]}
        for k in range(len(heads))
    }
    remarks = [k for k, outcomes in told.items() if None not in outcomes and "severe" in outcomes]
    if len(remarks) == 1:
        heads[remarks[0]] = replace(heads[remarks[0]], title="outcome")


def _take_velocity_of_turns(sheet: Sheet) -> None:
    """Put a velocity in place of a rotation, where a column has the radius or diameter."""
    turning = [k for k, heading in enumerate(sheet.headings) if heading.unit in TURNS]
    round_ = [k for k, heading in enumerate(sheet.headings) if _ROUND.fullmatch(heading.title)]
    tracks = [k for k in round_ if _TRACK.search(sheet.headings[k].title)]
    if len(turning) != 1 or not round_:
        return
    (turn,) = turning
    if len(tracks) != 1:
        heads = listed(sheet.headings[k].text for k in round_)
        sheet.of_rows.append(
            f'column "{sheet.headings[turn].text}" is a rotation, and none of {heads} is surely '
            'its track; call that column "track diameter [mm]" or "track radius [mm]", or give a '
            "velocity"
        )
        return
    (k,) = tracks
    track = sheet.headings[k]
    is_radius = re.search(r"(radius|raggio|rayon)$", track.title.lower())
    which = "radius" if is_radius else "diameter"
    if not track.unit:
        sheet.of_rows.append(
            f'column "{track.text}" has no unit; name it like "track {which} [mm]"'
        )
        return
    sheet.made_of = {k}
    sheet.headings[turn] = split_heading("velocity")
    for _, cells in sheet.rows:
        at = f" at {which} {cells[k]} {track.unit}" if cells[k] else ""
        cells[turn] = cells[turn] and f"{cells[turn]} rpm{at}"
