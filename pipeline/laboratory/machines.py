"""Forms in which usual machines report tests, as rows of load, velocity, outcome and run.

A form is an entry of `FORMS`: by which columns it is known, and what its columns make. What the
standards fix is in the library.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from pipeline.quantities import UNITS
from pipeline.scene.faults import Fault
from pipeline.scene.format import TEST
from pipeline.scene.headings import Heading, Row, Sheet, listed_faults, usual_unit
from pipeline.scene.library import library
from pipeline.scene.units import TURNS, UnitError, to_si


class Quantity(NamedTuple):
    """A column of a form: words of its heading, and its units, the first where that gives none."""

    words: str
    units: tuple[str, ...]


_BODY = r"(disc|disk|roller|ring|scheibe|rolle|shaft|body|welle)"
_SPEED = r"(speed|velocity|rpm|drehzahl|geschw\w*|[nuv])"
_TURNING = "m/s", "rpm"
COLUMNS = {
    "failed": Quantity(
        r"(fail\w*|scuff\w*)( load)? stage|fls|(schaden\w*|fress\w*)(kraft|last)stufe( sks)?|sks",
        ("",),
    ),
    "stage": Quantity(r"(load |test )?(stage|step)( no)?|(kraft|last)stufe|ks|ls", ("",)),
    "torque": Quantity(
        r"(pinion |test )?torque( on pinion| t ?1)?|ritzel(dreh)?moment|drehmoment|t ?1", ("N m",)
    ),
    "frequency": Quantity(r"frequency|freq|(schwing)?frequenz", ("Hz",)),
    "stroke": Quantity(r"stroke( length)?|(schwing)?hub(weg|länge)?|schwingweg", ("mm",)),
    "passed": Quantity(
        r"(ok|pass\w*|last pass\w*|last ok|gut) ?(load|last|kraft)|(load|last) (passed|ok)", ("N",)
    ),
    "seized": Quantity(
        r"((initial|first) )?(fail\w*|seizure|scor\w*|scuff\w*|fress) ?(load|last)", ("N",)
    ),
    "load": Quantity(
        r"((applied|test|normal|axial) )?(load|force)|(prüf|normal)?(last|kraft)|f ?n", ("N",)
    ),
    "velocity": Quantity(r"(sliding )?(velocity|speed)|gleitgeschw\w*", ("m/s",)),
    "ratio": Quantity(r"slide( to)? roll ratio|slip( ratio)?|schlupf|srr", ("%", "")),
    "rolling": Quantity(
        r"(rolling|entrain\w*|mean|average)( rolling)? ?(speed|velocity)|(roll|wälz)geschw\w*",
        ("m/s",),
    ),
    "first": Quantity(rf"{_SPEED}( of)?( {_BODY})? ?1|{_BODY} ?1 {_SPEED}", _TURNING),
    "second": Quantity(rf"{_SPEED}( of)?( {_BODY})? ?2|{_BODY} ?2 {_SPEED}", _TURNING),
    "diameter": Quantity(rf"({_BODY} )?diameter|({_BODY}n?)?durchmesser", ("mm",)),
}  # fmt: skip
"""Quantities of forms; their words match a whole title, in small letters and without signs."""

Values = Mapping[str, float]
Make = tuple[tuple[str, ...], Callable[..., float]]
"""What a quantity is made of, and how, in SI."""


def _fixed(machine: str, name: str) -> Any:
    return library()["machines"][machine][name]


def _stage_force(stage: float) -> float:
    """Normal force between teeth in a load stage [N]."""
    stages = _fixed("FZG", "stages")
    return _tooth_force(stages[round(stage) - 1]) if 1 <= stage <= len(stages) else math.nan


def _tooth_force(torque: float) -> float:
    return float(torque / _fixed("FZG", "base_radius"))


@dataclass(frozen=True, slots=True)
class Form:
    """A form in which a machine reports tests: stages of one specimen, until the load falls."""

    name: str
    #: Any of these sets of columns, or these words in a heading or the name of the file, tell it.
    signs: tuple[frozenset[str], ...]
    words: str
    makes: Mapping[str, tuple[Make, ...]]  #: Ways to make load and velocity; the first is asked.
    says: str  #: How they are made, in words.
    #: Quantity before one that failed, and after one that was passed.
    before: Callable[[float], float] | None = None
    after: Callable[[float], float] | None = None


def _signs(*sets: str) -> tuple[frozenset[str], ...]:
    return tuple(frozenset(one.split()) for one in sets)


FORMS = (
    Form(
        "FZG A/8.3/90", _signs("torque stage", "failed"),
        r"(?<![a-z])fzg(?![a-z])|kraftstufe|(pinion|ritzel).*(torque|moment)|torque on pinion"
        r"|\bt ?1\b.*\bn ?m\b",
        {
            "load": ((("torque",), _tooth_force), (("stage",), _stage_force),
                     (("failed",), _stage_force)),
            "velocity": ((("velocity",), float),),
        },
        "load is the pinion's torque over the radius of its base circle, velocity that of sliding "
        "where the contact lies on the flank",
        before=lambda stage: stage - 1,
    ),
    Form(
        "SRV", _signs("frequency", "stroke"), r"(?<![a-z])srv(?![a-z])",
        {
            "load": ((("load",), float), (("passed",), float), (("seized",), float)),
            "velocity": ((("frequency", "stroke"), lambda f, s: 2 * f * s),),
        },
        "velocity is the mean one, 2 × frequency × stroke",
        before=lambda load: load - _fixed("SRV", "step"),
        after=lambda load: load + _fixed("SRV", "step"),
    ),
    Form(
        "twin disc", _signs("ratio", "first second"), r"twin.?disc|zwei.?scheiben",
        {
            "load": ((("load",), float),),
            "velocity": (
                (("ratio", "rolling"), lambda ratio, mean: abs(ratio) * mean),
                (("first", "second"), lambda one, other: abs(one - other)),
            ),
        },
        "velocity is that of sliding, the difference of both surfaces",
    ),
)  # fmt: skip
_MACHINE = re.compile(r"\b(fzg|a 83 90|srv|(astm|din|iso|en|ip)( [a-z]?\d+)+)\b")
"""Names of machines and standards before a quantity in a title, in small letters without signs."""
_BEYOND = re.compile(r"(?:>=?|≥|über|beyond|above)\s*(\S.*)|(\d[\d.]*)\s*\+")
_PARTS = re.compile(r"([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*((?<=\s)\S.*|[^\d\s.,:].*)?")
"""Number and unit."""
_ENDS = ("failed", "seized", "passed")
_TARGETS = {name: UNITS[name] for name in ("load", "velocity")}
_CONTACT = ("N", "kN", "m/s", "mm/s")


def _add_given(sheet: Sheet, given: Mapping[str, Any]) -> dict[str, str]:
    """Append a column for each quantity that the file does not say; return what is wrong."""
    wrong = dict[str, str]()
    for name, value in given.items():
        if name not in COLUMNS and name not in TEST.keys:
            allowed = ", ".join(dict.fromkeys([*TEST.keys, *COLUMNS]))
            wrong[name] = f"no such quantity; give one of {allowed}"
            continue
        match = _PARTS.fullmatch(str(value)) if name in COLUMNS else None
        number, unit = match.groups("") if match else str(value).partition(" ")[::2]
        heading = Heading(f"{name}, given", name, unit.strip())
        read = (_value(one, number, heading) for one in _columns([heading]))
        if name in COLUMNS and all(map(math.isnan, read)):
            like = f"1.5 {COLUMNS[name].units[0]}".strip()
            wrong[name] = f'"{value}" is no {name}; give one like "{like}"'
            continue
        sheet.sure.add(len(sheet.headings))
        sheet.headings.append(heading)
        for row in sheet.rows:
            row.cells.append(number)
    sheet.of_rows += [f"given.{name}: {problem}" for name, problem in wrong.items()]
    return wrong


def _is_named(words: str, headings: Sequence[Heading], stem: str) -> bool:
    said = (stem, *(heading.label for heading in headings))
    return any(re.search(words, text, re.IGNORECASE) for text in said)


def form_of(headings: Sequence[Heading], stem: str = "") -> Form | None:
    """The form in which a machine reports tests below these headings, if it is one.

    The stem is the name of the file, with the lines above the headings.

    Columns with the names that a scene has for load and velocity are those of the contact.
    """
    exact = {heading.name for heading in headings if heading.unit in _CONTACT}
    if {"load", "velocity"} <= exact:
        return None
    found = _columns(headings)
    # A torque beside a load is that of friction.
    seen = found.keys() - ({"torque"} if "load" in found else set())
    contact = {name for name, k in found.items() if headings[k].unit in _CONTACT}
    for form in FORMS:
        is_made = any("load" in inputs for inputs, _ in form.makes["load"])
        if {"load", "velocity"} <= contact and not is_made:
            continue
        is_told = _is_named(form.words, headings, stem)
        is_load = any(name in found for name in ("load", "torque", "stage", *_ENDS))
        if any(signs <= seen for signs in form.signs) or (is_told and is_load):
            return form
    return None


def read_form(sheet: Sheet, stem: str, given: Mapping[str, Any], has_runs: bool) -> bool:
    """Put load, velocity, outcome and run in place of what a machine reports, if it is one."""
    wrong = _add_given(sheet, given)
    form = form_of(sheet.headings, stem)
    if form is None:
        return False
    found = _columns(sheet.headings)
    ends = [name for name in _ENDS if name in found]
    ways = {name: _way(form, name, found, ends) for name in _TARGETS}
    inputs = [one for ins, _ in ways.values() for one in ins]
    rims = [one for one in ("first", "second") if one in inputs and one in found]
    turning = [one for one in rims if _turns_of(sheet.headings[found[one]].unit)]
    inputs += ["diameter"] if turning else []
    inputs += ["seized"] if ends == ["passed"] and form.after is None else []
    missing = [one for one in inputs if one not in found and one not in wrong]
    if missing or wrong:
        _ask(sheet, form, missing)
        return True
    if "ratio" in found:
        _assume_percent(sheet, found["ratio"])
    faults = [*_cell_faults(sheet, {one: found[one] for one in (*inputs, *ends)})]
    sheet.of_rows += listed_faults(faults)
    faulty = {fault.row for fault in faults}
    rows, last, run = list[Row](), math.inf, 0
    for row in sheet.rows:
        values = {name: _value(name, row.cells[k], sheet.headings[k]) for name, k in found.items()}
        for one in turning:
            values[one] *= math.pi * values["diameter"]
        for outcome, load in _outcomes(form, row, found, values, ends):
            stage = values | {ways["load"][0][0]: load} if ends else values
            made = [make(*(stage[one] for one in ins)) for ins, make in ways.values()]
            if row.number in faulty and math.isnan(sum(made)):
                continue
            run += not made[0] > last
            last = made[0]
            label = str(row.number if ends else run)
            cells = ["" if math.isnan(one) else f"{one:.6g}" for one in made]
            cells += [outcome] * bool(ends) + [label] * (not has_runs)
            rows.append(Row(row.number, [*row.cells, *cells]))
    used = {found[one] for one in (*inputs, *ends, "stage") if one in found}
    appended = _TARGETS | ({"outcome": ""} if ends else {}) | ({} if has_runs else {"run": ""})
    sheet.sure |= {*range(len(sheet.headings), len(sheet.headings) + len(appended))}
    heads = [Heading(f"{name} of {form.name}", name, unit) for name, unit in appended.items()]
    _put_rows(sheet, rows, used, heads)
    sheet.form.append(f"form of {form.name}: {form.says}")
    return True


def _put_rows(sheet: Sheet, rows: list[Row], used: set[int], made: Sequence[Heading]) -> None:
    """Put rows with further columns in place of a sheet's; those that they are made of are used."""
    heads = [replace(one, title="") if k in used else one for k, one in enumerate(sheet.headings)]
    sheet.headings, sheet.rows, sheet.made_of = [*heads, *made], rows, used


def _cell_faults(sheet: Sheet, used: Mapping[str, int]) -> Iterator[Fault]:
    """What is wrong with cells of which others are made."""
    own = {name: k for name, k in used.items() if k not in sheet.sure}
    last = len(_fixed("FZG", "stages"))
    for number, cells in sheet.rows:
        values = {name: _value(name, cells[k], sheet.headings[k]) for name, k in own.items()}
        if all(map(math.isnan, values.values())):  # a remark, which is left out
            continue
        for name, k in own.items():
            # That nothing failed may be said in words.
            is_word = name in _ENDS and not re.search(r"\d", cells[k])
            problem = sheet.doubt(cells[k].lstrip("<>≥ "))
            if math.isnan(values[name]) and cells[k] and not is_word:
                problem = f'"{cells[k]}" cannot be read; write a number, or leave the cell empty'
            elif name in ("stage", "failed") and (values[name] < 1 or values[name] > last):
                problem = f'"{cells[k]}" is no load stage; give 1 to {last}, or > {last}'
            if problem:
                yield Fault(sheet.headings[k].text, problem, row=number)


def _assume_percent(sheet: Sheet, place: int) -> None:
    """Take ratios without a unit for percent if any is above 2, which none of two surfaces is."""
    heading = sheet.headings[place]
    values = (_value("ratio", row.cells[place], heading) for row in sheet.rows)
    if not heading.unit and any(abs(value) > 2 for value in values):
        sheet.headings[place] = replace(heading, unit="%")


def _columns(headings: Sequence[Heading]) -> dict[str, int]:
    """Columns of the quantities of forms."""
    found = dict[str, int]()
    for k, heading in enumerate(headings):
        title = re.sub(r"[\W_]+", " ", heading.title.lower().replace(".", ""))
        title = _MACHINE.sub("", title).strip()
        for name, quantity in COLUMNS.items():
            is_named = title == name or re.fullmatch(quantity.words, title)
            if name not in found and is_named and _fits(heading, title, quantity):
                found[name] = k
                break
    return found


def _fits(heading: Heading, title: str, quantity: Quantity) -> bool:
    """True if the unit of a heading is one of a quantity; a lone letter needs one."""
    unit = heading.unit
    if not unit:  # a bare speed may be one of rotation
        return "" in quantity.units or (len(title) > 2 and title != "speed")
    if unit in TURNS:
        return "rpm" in quantity.units
    for like in quantity.units:
        with suppress(UnitError):
            if unit == like or (like and like != "%" and to_si(f"1 {unit}", f"1 {like}")):
                return True
    return False


def _turns_of(unit: str) -> float | None:
    """Turns in a second of one of a unit, if it is of a rotation."""
    if unit in TURNS:
        return 1 / 60
    with suppress(UnitError):
        return to_si(f"1 {unit}", "1 Hz") / (2 * math.pi if "rad" in unit else 1)
    return None


def _value(name: str, cell: str, heading: Heading) -> float:
    """Value of a cell, a rotation in turns a second [SI]; NaN of one that is no number."""
    match, usual = _BEYOND.fullmatch(cell), COLUMNS[name].units[0]
    parts = _PARTS.fullmatch(((match[1] or match[2]) if match else cell).strip())
    if parts is None:
        return math.nan
    number, own = parts[1], parts[2] or ""
    unit = usual_unit(own) or heading.unit or usual
    try:
        if name == "ratio":
            value = float(number)
            return value / 100 if own == "%" or heading.unit == "%" else value
        if not usual:
            return float(number)
        turns = _turns_of(unit)
        return float(number) * turns if turns else to_si(f"{number} {unit}", f"1 {usual}")
    except (ValueError, UnitError):
        return math.nan


def _way(form: Form, name: str, found: Collection[str], ends: Sequence[str]) -> Make:
    """What load or velocity is made of: the first way for which there is all, else the first."""
    ways = form.makes[name]
    if name == "velocity" and name in found:
        return (name,), float
    if name == "load" and ends:
        ways = tuple(way for way in ways if way[0][0] in ends) or ways
    return next((way for way in ways if {*way[0]} <= {*found}), ways[0])


def _outcomes(
    form: Form, row: Row, found: Mapping[str, int], values: Values, ends: Sequence[str]
) -> Iterator[tuple[str, float]]:
    """Outcomes of a row and their stages or loads; one without both where it has none."""
    if not ends:
        yield "", math.nan
        return
    stages = dict[str, float]()
    for name in ends:  # a load that was passed comes last, and is surer than the step before
        value, is_beyond = values[name], bool(_BEYOND.fullmatch(row.cells[found[name]]))
        if math.isnan(value):
            continue
        if name == "passed" or is_beyond:
            stages["mild"] = value
            if name == "passed" and len(ends) == 1 and form.after and not is_beyond:
                stages["severe"] = form.after(value)
        else:
            stages |= {"mild": form.before(value) if form.before else math.nan, "severe": value}
    told = [(outcome, value) for outcome, value in sorted(stages.items()) if value > 0]
    yield from told or [("", math.nan)]


def _ask(sheet: Sheet, form: Form, missing: Sequence[str]) -> None:
    """Say in a line what a form does not, if anything; then there are no rows."""
    names = dict.fromkeys(missing)
    values = [f"{name}=... {COLUMNS[name].units[0]}".strip() for name in names]
    options = " ".join(f'--given "{value}"' for value in values)
    entry = ", ".join(value.replace("=", ' = "', 1) + '"' for value in values)
    if names:
        sheet.of_rows.append(
            f"the form of {form.name} ({form.says}) does not say {' or '.join(names)}; give "
            f"{options}, in a scene given = {{ {entry} }}"
        )
    targets = [Heading(name, name, unit) for name, unit in _TARGETS.items()]
    _put_rows(sheet, [], {*_columns(sheet.headings).values()}, targets)
