"""Quantities with units, and hardness numbers: from text to SI."""

from __future__ import annotations

import functools
import json
import math
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from decimal import (
    ROUND_HALF_EVEN,
    Context,
    Decimal,
    DivisionByZero,
    InvalidOperation,
    Overflow,
    localcontext,
)
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.quantities import DIMENSIONS, ZERO
from tribo import InputError, TriboError

if TYPE_CHECKING:
    import pint


_LONGEST = 80
_GRAVITY = 9.80665  # [m/s²], of weights
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
# The unit's characters leave out "_", and so delta_degC, which would make 25 K of 25 °C.
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*([A-Za-z0-9µμ°Ω²³⁻¹ .·*/^()-]*)", re.ASCII)
TURNS = ("rpm", "1/min", "min^-1", "U/min")
"""Units of a rotation, which is a velocity at a radius or a diameter."""
_TURNS = re.compile(
    rf"\s*(?P<number>{_NUMBER})\s*(?:{'|'.join(map(re.escape, TURNS))})\s+at\s+"
    r"(?P<which>radius|diameter)\s+(?P<length>.+)"
)
_COMMA = re.compile(r"\s*[+-]?\d+,\d")
_SCALE_FIRST = re.compile(r"^\s*(HV|HBW?|HR[Cc])\s*(\d.*)")
_RANGE = re.compile(
    rf"\s*({_NUMBER})\s*(-|to|\.\.\.?|…|\+/-|±|\+)\s*({_NUMBER})\s*(HV[\d.]*|HBW?|HRC)\s*"
)

_SIGNS_OF_PRINT = str.maketrans(
    {**dict(zip("−–µμº·⋅∙\xa0", "--uu°    ", strict=True)), "℃": "degC"}
)
_RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+"
_TIMES_TEN = re.compile(r"(?:\s*[×x]\s*10\s*\^?| +10\^)([+-]?\d{1,2})(?=\s*[A-Za-z])")
_PRINTED = tuple(
    (re.compile(pattern), read)
    for pattern, read in (
        (r"°\s*([CF])\b|\b[Dd]eg(?:rees?)?\.?\s+([CF])\b", r"deg\1\2"),
        (r"(?<=[A-Za-z])(-?\d)", r"^\1"),  # mm2
        (r"(\^-?\d)(?=[A-Za-z])", r"\1 "),  # m^2K
        (r"(?<=[A-Za-z])[.*-](?=[A-Za-z])", " "),  # mPa.s, W/m-K
        (r"^\s*/", "1/"),  # /GPa
        (r"\b(k?N)(m)\b|\b(m?Pa)(s)\b|\b(k?g)(K|degC)\b", r"\1\3\5 \2\4\6"),
        (r"(?<=W/)(\(?[cm]?m)(K|degC)\b", r"\1 \2"),  # no millikelvin
        (r"^([^/]*)/\s*((?!.*\^-)[^/()]* [^/()]*)$", r"\1/(\2)"),  # all behind the line
        (r"(?<= )degC(?=\))", "K"),  # a difference
        (r"\bkp\b", "kgf"),
    )
)
"""Ways in which data sheets write units, and how they are read; in this order."""

_CLOCK = re.compile(
    r"(?:.*[\sT])?(\d{1,2}):(\d\d)(?::(\d\d(?:[.,]\d+)?))?\s*([AP]M)?(?:Z|[+-]\d\d:?\d\d)?", re.I
)
_OF_TABLES = {
    "C": "degC", "F": "degF", "kg": "kgf", "lb": "lbf", "lbs": "lbf", "sec": "s",
    "m_s": "m/s", "mm_s": "mm/s", "newton": "N", "newtons": "N", "celsius": "degC", "m/s": "m/s",
    **dict.fromkeys(("g", "gram", "grams"), "gf"), **dict.fromkeys(TURNS, "rpm"),
    **dict.fromkeys(("-", "–", "1", "hh:mm:ss", "hh:mm"), ""),
}  # fmt: skip
"""Units meant in tables: none is of charges or capacitances, and a mass there is a weight."""


class UnitError(TriboError, ValueError):
    """Text that is not a quantity of the dimension that is needed."""


_TRAPS = [InvalidOperation, DivisionByZero, Overflow]


@contextmanager
def exact_decimals() -> Iterator[None]:
    """Compute with decimals of 28 digits, whatever the caller's context is."""
    with localcontext(Context(prec=28, rounding=ROUND_HALF_EVEN, traps=_TRAPS)):
        yield


@functools.lru_cache(maxsize=65536)  # samples repeat nearly all of their entries
@exact_decimals()
def exact_si(text: str, like: str) -> Decimal:
    """Value in SI of a quantity such as ``"0.27 um"``, without rounding; hardness is a pressure."""
    needed = _split_hardness(like)[1]
    if needed in ("m/s", "mm/s") and (turns := _TURNS.fullmatch(text)):
        radius = exact_si(turns["length"], "1 m") / (1 if turns["which"] == "radius" else 2)
        if radius <= 0:
            which = f"{turns['which']} of the track"
            raise UnitError(f"{_quoted(text)}: the {which} is not above 0; give its own")
        return Decimal(turns["number"]) / 60 * Decimal(2 * math.pi) * radius
    number, unit = _split_hardness(text)
    for one in DIMENSIONS.values():  # which need no pint
        if unit in one.units and needed in one.units:
            return Decimal(number) * Decimal(one.units[unit]) + ZERO.get(unit, 0)
    quantity = _parsed(text)
    try:
        value: Decimal = quantity.to_base_units().magnitude
    except Exception as error:  # pint raises more than its own
        raise UnitError(f"{_quoted(text)} cannot be expressed in SI") from error
    if not quantity.check(_parsed(like).dimensionality):
        if quantity.unitless:
            raise UnitError(f"{_quoted(text)} has no unit")
        if unit in ("C", "F") and needed in ("K", "degC"):
            raise UnitError(f"{_quoted(text)} has no unit of temperature; write {number} deg{unit}")
        hint = _what_to_give(quantity, needed)
        raise UnitError(f"{_quoted(text)} cannot be converted to {needed}{hint}")
    return value


def to_si(text: str, like: str) -> float:
    """Value in SI of a quantity such as ``"0.27 um"``, the nearest double.

    Parameters
    ----------
    text : str
        Number and unit; hardness numbers such as ``"62 HRC"`` are pressures.
    like : str
        Quantity of the dimension that is needed.

    Raises
    ------
    UnitError
        If the text is not a quantity, or is one of another dimension.

    Examples
    --------
    >>> from pipeline import to_si
    >>> to_si("1.2e-6 mm^3/(N m)", like="1 m^2/N")
    1.2e-15
    >>> to_si("7 kg", like="750 N")
    Traceback (most recent call last):
        ...
    pipeline.scene.units.UnitError: "7 kg" cannot be converted to N; its weight is 68.65 N
    """
    return float(exact_si(text, like))


def difference_in_si(text: str, like: str) -> float:
    """Value in SI of a difference of quantities, which is in K for temperatures."""
    difference = to_si(text, like)
    unit = _parts(text)[1]
    if unit and to_si(f"0 {unit}", like) != 0:
        raise UnitError(f'"{text}" is a temperature; give a difference, such as "8 K"')
    return difference


@functools.lru_cache(maxsize=256)
@exact_decimals()
def si_unit(text: str) -> str:
    """SI unit of the dimension of a quantity, as CF writes units, such as ``"W m-1 K-1"``."""
    unit = _split_hardness(text)[1]
    for cf, one in DIMENSIONS.items():
        if unit in one.units:
            return cf
    quantity = _parsed(text)
    for cf, one in DIMENSIONS.items():
        if quantity.check(_parsed(one.limits[0]).dimensionality):
            return cf
    parts: Any = quantity.to_base_units().unit_items()
    powers = [(_registry().get_symbol(name), int(power)) for name, power in parts]
    powers.sort(key=lambda power: power[1] < 0)
    return " ".join(f"{name}{power if power != 1 else ''}" for name, power in powers) or "1"


def unit_of_table(unit: str) -> str:
    """Unit of a column as it is meant, without parentheses around it; empty of a number."""
    unit = re.sub(r"^\((.*)\)$", r"\1", unit.strip())
    return _OF_TABLES.get(unit, _OF_TABLES.get(unit.lower(), unit))


def as_entry(cell: str, unit: str = "") -> str | float:
    """A cell as a scene file has it: a number, or text with a unit."""
    for number in (int, float) if not unit else ():
        with suppress(ValueError):
            return number(cell)
    return f"{cell} {unit}".strip()


@functools.cache
def is_unit(unit: str, like: str | None = None) -> bool:
    """True of a unit of any dimension, or of that of another one; a number may be in percent."""
    try:
        if like is not None:
            return unit == "%" if like == "" else to_si(f"1 {unit}", f"1 {like}") is not None
        # A lone µ, once a micron, is a coefficient of friction.
        return unit == "%" or (
            unit not in "µμ" and not unit.isdigit() and bool(si_unit(f"1 {unit}"))
        )
    except UnitError:
        return False


def clock_time(text: str) -> float:
    """Time of day of a clock, perhaps behind a date [s].

    Examples
    --------
    >>> clock_time("04.05.2026 10:00:00,5"), clock_time("1:30 PM")
    (36000.5, 48600.0)
    """
    if (match := _CLOCK.fullmatch(text)) is None:
        raise UnitError(f"{_quoted(text)} is no time of a clock")
    hours, minutes, seconds = (float((x or "0").replace(",", ".")) for x in match.groups()[:3])
    if match[4]:
        hours = hours % 12 + 12 * (match[4].upper() == "PM")
    return 3600 * hours + 60 * minutes + seconds


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    """All known units, made when first needed, since that takes 0.3 s."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _parts(text: str) -> tuple[str, str]:
    """Split text into a number and a unit."""
    typed = re.sub(f"[{_RAISED[0]}]+", lambda raised: f"^{raised[0]}", text)
    typed = typed.translate(str.maketrans(*_RAISED)).translate(_SIGNS_OF_PRINT)
    typed = _SCALE_FIRST.sub(r"\2 \1", _TIMES_TEN.sub(r"e\1", typed))
    match = _QUANTITY.fullmatch(typed) if len(text) <= _LONGEST else None
    if match is None:
        marks = "; write decimals with a point, and thousands without a mark"
        hint = marks if _COMMA.match(text) else ""
        raise UnitError(f"{_quoted(text)} is not a number followed by a unit{hint}")
    return match[1], match[2].strip()


def _split_hardness(text: str) -> tuple[str, str]:
    """Split text into a number and a unit, with the pressure in place of a hardness number."""
    number, unit = _parts(text)
    try:
        pressure = hardness_pressure(Decimal(number), unit)
    except InputError as error:
        raise UnitError(f"{_quoted(text)} {error}") from error
    return (number, _typed(unit)) if pressure is None else (str(pressure), "Pa")


@functools.lru_cache(maxsize=256)
def _typed(unit: str) -> str:
    """A unit as data sheets print it, as pint reads it."""
    for pattern, read in _PRINTED:
        unit = pattern.sub(read, unit)
    return unit


def middle_of_range(text: str) -> str | None:
    """The middle of a range of hardness numbers; None of other text.

    Examples
    --------
    >>> middle_of_range("60-62 HRC"), middle_of_range("HRC 60 +4"), middle_of_range("700 HV")
    ('61 HRC', '62 HRC', None)
    """
    match = _RANGE.fullmatch(_SCALE_FIRST.sub(r"\2 \1", text.translate(_SIGNS_OF_PRINT)))
    if match is None:
        return None
    low, sign, high, scale = Decimal(match[1]), match[2], Decimal(match[3]), match[4]
    ends = {"+": 2 * low + high, "+/-": 2 * low, "±": 2 * low}
    return f"{ends.get(sign, low + high) / 2} {scale}"


def _parsed(text: str) -> pint.Quantity[Decimal]:
    number, unit = _split_hardness(text)
    import pint

    try:
        return _registry().Quantity(Decimal(number), _registry().parse_units(unit))
    except pint.UndefinedUnitError as error:
        raise UnitError(f"{_quoted(text)} has an unknown unit: {error}") from error
    except Exception as error:  # pint raises more than its own
        raise UnitError(f"{_quoted(text)} has a unit that cannot be read") from error


def _what_to_give(quantity: pint.Quantity[Decimal], needed: str) -> str:
    """What a mass stands for where a force is due, or rotation where a speed is."""
    if needed in ("N", "kN") and quantity.check("[mass]"):
        weight = float(quantity.to("kg").magnitude) * _GRAVITY
        return f"; its weight is {weight:.4g} N"
    if needed == "m/s" and quantity.check("1/[time]"):
        return '; give its track, too, such as "500 rpm at radius 30 mm"'
    return ""


def _quoted(text: str) -> str:
    short = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
    return json.dumps(short, ensure_ascii=False)


_KGF_PER_MM2 = Decimal("9.80665e6")  # Pa
_SCALE = re.compile(r"(HV) ?[\d.]*|(HB)W?(?: ?[\d.]+/\d+)?|(HRC)")


@functools.cache
def _hardness_of_steel() -> dict[str, tuple[list[int], list[int]]]:
    """Numbers of two scales, and Vickers numbers beside them."""
    file = resources.files("pipeline.scene").joinpath("hardness.toml")
    vickers, brinell = tomllib.loads(file.read_text(encoding="utf-8")).values()
    return {"HRC": ([*range(20, 69)], vickers), "HB": (brinell, vickers[: len(brinell)])}


def hardness_pressure(number: Decimal, unit: str) -> Decimal | None:
    """Pressure of a hardness number [Pa]; None if the unit is not HV, HB, HBW or HRC."""
    match = _SCALE.fullmatch(unit.strip().replace("HRc", "HRC"))
    if match is None:
        return None
    scale = str(match[match.lastindex or 0])
    if scale == "HV":
        return number * _KGF_PER_MM2
    numbers, vickers = _hardness_of_steel()[scale]
    if not numbers[0] <= number <= numbers[-1]:
        raise InputError(
            f"is outside the conversion of ASTM E140 for steel, {numbers[0]} to {numbers[-1]} "
            f"{scale}; give it in HV, or as a pressure"
        )
    return Decimal(float(np.interp(float(number), numbers, vickers))) * _KGF_PER_MM2


def in_si(name: str, value: float | str, like: str) -> float:
    """Value in SI of a number in SI, or of text with a unit like that of the example."""
    if not isinstance(value, str):
        return float(value)
    try:
        return to_si(value, like)
    except UnitError as error:
        raise InputError(f'{name}: {error}; give one such as "{like}"') from error


def require_count(name: str, value: float) -> None:
    """Raise an `InputError` unless a value is a whole number of at least 1."""
    if value < 1 or value % 1:
        raise InputError(f"{name} is {value}; it must be a whole number of at least 1")


def share_of(value: float | str) -> float:
    """Value of a share, as a number or as text such as ``"10%"``."""
    if not isinstance(value, str):
        return value
    text = value.strip()
    try:
        return float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        raise InputError(f'"{value}": give a share such as 10% or 0.1') from None


_SIGNS = {"um": "µm", "deg": "°", "^2": "²", "^3": "³"}


def typeset(text: str) -> str:
    """A unit, or a quantity, with the signs of print."""
    for typed, sign in _SIGNS.items():
        text = text.replace(typed, sign)
    return text
