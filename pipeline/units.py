"""Quantities with units, and hardness numbers: from text to SI."""

from __future__ import annotations

import functools
import json
import math
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
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
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipeline.quantities import DIMENSIONS, ZERO, shown_in
from tribo import InputError, TriboError

if TYPE_CHECKING:
    import pint


_MAX_LENGTH = 80
_GRAVITY = Decimal("9.80665")  # [m/s²], of weights
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
# Units have no "_", which excludes delta_degC, with which 25 °C would be read as 25 K.
_QUANTITY = re.compile(rf"\s*({NUMBER})\s*([A-Za-z0-9µμ°Ω²³⁻¹ .·*/^()-]*)", re.ASCII)
_PER_MINUTE = ("rpm", "1/min", "/min", "min^-1", "min⁻¹", "min-1", "U/min", "rev/min", "r/min")
_PER_SECOND = ("Hz", "1/s", "/s", "s^-1", "s⁻¹", "rev/s")
GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}([.,]\d{3})+")
"""A number whose marks may divide thousands, or precede three decimals."""
TURNS = {
    **dict.fromkeys(_PER_MINUTE, 2 * math.pi / 60), **dict.fromkeys(_PER_SECOND, 2 * math.pi),
}  # fmt: skip
"""Units of rotational speed [rad/s]; with a radius or diameter it is a velocity."""
_TURNS = re.compile(
    rf"\s*(?P<number>{NUMBER})\s*(?P<unit>{'|'.join(map(re.escape, TURNS))})\s+at\s+"
    r"(?P<which>radius|diameter)\s+(?P<length>.+)"
)
_COMMA = re.compile(r"\s*([+-]?\d+(?:,\d+)+(?:\.\d*)?)(.*)", re.ASCII | re.DOTALL)
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(,\d{3})+")
_SCALE_FIRST = re.compile(r"^\s*(HV|HBW?|HR[Cc])\s*(\d.*)")

_SIGNS_OF_PRINT = str.maketrans(
    {**dict(zip("−–µμº·⋅∙\xa0", "--uu°    ", strict=True)), "℃": "degC"}
)
_RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+"
_TIMES_TEN = re.compile(r"(?:\s*[×x]\s*10(?:\^|(?=[+-]))| +10\^)([+-]?\d{1,2})(?=\s*[A-Za-z])")
_SHARE = re.compile(rf"\s*({NUMBER})\s*(%|percent|per cent)?\s*", re.ASCII)
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
        (r"^([^/]*)/\s*((?!.*\^-)[^/()]* [^/()]*)$", r"\1/(\2)"),  # W/m K is W/(m K)
        (r"(?<= )degC(?=\))", "K"),  # a difference
        (r"\bkp\b", "kgf"),
    )
)
"""Patterns of units in data sheets, and their replacements, in this order."""


class UnitError(TriboError, ValueError):
    """A text is not a quantity of the needed dimension."""


_TRAPS = [InvalidOperation, DivisionByZero, Overflow]


@contextmanager
def exact_decimals() -> Iterator[None]:
    """Context manager: compute with decimals of 28 digits, whatever context the caller has."""
    with localcontext(Context(prec=28, rounding=ROUND_HALF_EVEN, traps=_TRAPS)):
        yield


class Unit(NamedTuple):
    """A unit: the SI unit of its dimension in CF notation, its size, and its zero point in SI."""

    dimension: str
    size: Decimal
    zero: Decimal = Decimal(0)


@functools.lru_cache(maxsize=65536)  # cases repeat nearly all of their entries
@exact_decimals()
def exact_si(text: str, like: str) -> Decimal:
    """Value in SI of a text such as ``"0.27 um"``, without rounding.

    `like` is any quantity of the required dimension. Hardness numbers are converted to a pressure.
    """
    needed = si_unit(like)
    _require_short(text)
    if needed == "m s-1" and (turns := _TURNS.fullmatch(text)):
        radius = exact_si(turns["length"], "1 m") / (1 if turns["which"] == "radius" else 2)
        if radius <= 0:
            which = f"{turns['which']} of the track"
            raise UnitError(f"{_quoted(text)}: the {which} is not above 0; give a length above 0")
        return Decimal(turns["number"]) * Decimal(TURNS[turns["unit"]]) * radius
    if needed == "rad s-1":
        revolutions, speed_unit = _parts(text)
        if speed_unit in TURNS:
            return Decimal(revolutions) * Decimal(TURNS[speed_unit])
    number, unit = _read(text)
    if unit.dimension != needed:
        raise UnitError(f"{_quoted(text)} {_misfit(text, unit, like)}")
    return number * unit.size + unit.zero


def to_si(text: str, like: str) -> float:
    """Value in SI of a quantity such as ``"0.27 um"``, rounded to the nearest double.

    Parameters
    ----------
    text : str
        Number and unit. Hardness numbers such as ``"62 HRC"`` are converted to pressures.
    like : str
        Any quantity of the required dimension.

    Raises
    ------
    UnitError
        If the text is not a quantity, or has another dimension.

    Examples
    --------
    >>> from pipeline import to_si
    >>> to_si("1.2e-6 mm^3/(N m)", like="1 m^2/N")
    1.2e-15
    >>> to_si("7 kg", like="750 N")
    Traceback (most recent call last):
        ...
    pipeline.units.UnitError: "7 kg" cannot be converted to N; its weight is 68.65 N
    """
    for name, quantity in {"text": text, "like": like}.items():
        if not isinstance(quantity, str):
            raise UnitError(f"{name} is {f'{quantity!r}':.80}; give a number with a unit as text")
    value = float(exact_si(text, like))
    if math.isinf(value):
        raise UnitError(f"{_quoted(text)} is too large")
    return value


@functools.lru_cache(maxsize=256)
@exact_decimals()
def si_unit(text: str) -> str:
    """SI unit of a quantity such as "45 W/(m K)", as CF conventions write it: ``"W m-1 K-1"``."""
    return _read(text)[1].dimension


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    """The units known to pint; loaded when first needed, since loading takes 0.3 s."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _parts(text: str) -> tuple[str, str]:
    """Split text into a number and a unit."""
    _require_short(text)
    typed = re.sub(f"[{_RAISED[0]}]+", lambda raised: f"^{raised[0]}", text)
    typed = typed.translate(str.maketrans(*_RAISED)).translate(_SIGNS_OF_PRINT)
    typed = _SCALE_FIRST.sub(r"\2 \1", _TIMES_TEN.sub(r"e\1", typed))
    match = _QUANTITY.fullmatch(typed)
    if match is None:
        raise UnitError(f"{_quoted(text)} is not a number with a unit{_comma_hint(text)}")
    return match[1], match[2].strip()


def _require_short(text: str) -> None:
    """Raise a `UnitError` for a text that is too long for a quantity, before it is parsed."""
    if len(text) > _MAX_LENGTH:
        raise UnitError(f"{_quoted(text)} has {len(text)} characters; give {_MAX_LENGTH} at most")


def _comma_hint(text: str) -> str:
    """Advice for a number with a comma, which may divide thousands or precede decimals."""
    if not (match := _COMMA.fullmatch(text)):
        return ""
    number, rest = match[1], match[2]
    decimals = f"{number.replace(',', '.')}{rest}"
    if _THOUSANDS.fullmatch(number):
        return f"; write {number.replace(',', '')}{rest} or {decimals}, whichever you mean"
    return f"; write {decimals}" if number.count(",") == 1 else "; use a decimal point"


def _read(text: str) -> tuple[Decimal, Unit]:
    """Read a quantity as number and unit; a hardness number becomes a pressure."""
    number, unit = _parts(text)
    try:
        scale = _SCALE.fullmatch(unit) if unit.startswith("H") else None
        if scale:
            return _hardness_pressure(Decimal(number), scale[scale.lastindex or 0]), _unit("Pa")
        return Decimal(number), _unit(unit)
    except InputError as error:
        raise UnitError(f"{_quoted(text)} {error}") from error


@functools.lru_cache(maxsize=1024)
@exact_decimals()
def _unit(unit: str) -> Unit:
    """Find a unit that is written as in data sheets; `InputError` if it is unknown."""
    for pattern, read in _PRINTED:
        unit = pattern.sub(read, unit)
    for cf, dimension in DIMENSIONS.items():  # known without pint
        if unit in dimension.units:
            return Unit(cf, Decimal(dimension.units[unit]), Decimal(ZERO.get(unit, 0)))
    import pint

    registry = _registry()
    try:
        parsed = registry.parse_units(unit)
        zero, one_unit = (registry.Quantity(Decimal(k), parsed).to_base_units() for k in (0, 1))
    except pint.UndefinedUnitError as error:
        raise InputError(f"has an unknown unit: {error}") from error
    except Exception as error:  # pint raises errors that are not its own
        raise InputError("has a unit that cannot be read") from error
    size = one_unit.magnitude - zero.magnitude
    for cf, dimension in DIMENSIONS.items():
        if one_unit.check(registry.parse_units(next(iter(dimension.units))).dimensionality):
            return Unit(cf, size, zero.magnitude)
    parts: Any = one_unit.unit_items()
    powers = [(registry.get_symbol(name), int(power)) for name, power in parts]
    powers.sort(key=lambda power: power[1] < 0)
    cf = " ".join(f"{name}{power if power != 1 else ''}" for name, power in powers)
    return Unit(cf or "1", size)


def _misfit(text: str, unit: Unit, like: str) -> str:
    """Reason why a quantity in `unit` does not have the dimension of `like`, with advice."""
    (number, typed), needed = _parts(text), _parts(like)[1]
    if unit.dimension == "1":
        return "has no unit"
    if typed in ("C", "F") and si_unit(like) == "K":
        return f"has no temperature unit; write {number} deg{typed}"
    hint = ""
    if (unit.dimension, si_unit(like)) == ("kg", "N"):
        hint = f"; its weight is {Decimal(number) * unit.size * _GRAVITY:.4g} N"
    if unit.dimension in ("rad s-1", "s-1") and si_unit(like) == "m s-1":
        hint = '; add the track, such as "500 rpm at radius 30 mm"'
    return f"cannot be converted to {needed}{hint}"


def _quoted(text: str) -> str:
    short = text if len(text) <= _MAX_LENGTH else f"{text[:_MAX_LENGTH]}..."
    return json.dumps(short, ensure_ascii=not short.isprintable())


_SCALE = re.compile(r"(HV) ?[\d.]*|(HB)W?(?: ?[\d.]+/\d+)?|(HR)[Cc]")


@functools.cache
def _hardness_of_steel() -> dict[str, tuple[list[int], list[int]]]:
    """By scale, "HR" (HRC) or "HB": hardness numbers of steel, and their Vickers numbers."""
    file = resources.files("pipeline").joinpath("hardness.toml")
    vickers, brinell = tomllib.loads(file.read_text(encoding="utf-8")).values()
    return {"HR": ([*range(20, 69)], vickers), "HB": (brinell, vickers[: len(brinell)])}


def _hardness_pressure(number: Decimal, scale: str) -> Decimal:
    """Pressure of a hardness number on a `scale` such as "HV" [Pa]."""
    if scale != "HV":
        numbers, vickers = _hardness_of_steel()[scale]
        if not numbers[0] <= number <= numbers[-1]:
            name = {"HR": "HRC"}.get(scale, scale)
            raise InputError(
                f"is outside the range of the ASTM E140 conversion for steel ({numbers[0]} to "
                f"{numbers[-1]} {name}); give HV or a pressure"
            )
        number = Decimal(float(np.interp(float(number), numbers, vickers)))
    return number * _GRAVITY * 10**6  # of kgf/mm²


def share_of(value: float | str) -> float:
    """Value of a share, as a number or as text such as ``"10%"`` or ``"10 percent"``."""
    if not isinstance(value, str):
        return value
    match = (
        _SHARE.fullmatch(value.translate(_SIGNS_OF_PRINT)) if len(value) <= _MAX_LENGTH else None
    )
    if match is None:
        raise InputError(f"{_quoted(value)} is not a number; give one such as 0.1 or 10%")
    return float(match[1]) / (100 if match[2] else 1)


_SIGNS = {"um": "µm", "deg": "°", "^2": "²", "^3": "³"}


def typeset(text: str) -> str:
    """Write a unit, or a quantity, with signs as in print: µm, °, ² and ³."""
    for typed, sign in _SIGNS.items():
        text = text.replace(typed, sign)
    return text


def unusual(value: float, usual: tuple[float, float] | None, unit: str) -> str:
    """Warning that `value` [SI] is outside its usual range; else empty.

    `usual` has both ends of this range in `unit`, in which the warning states them. If `usual` is
    None, no value is unusual.
    """
    (low, high), unit = usual or (-math.inf, math.inf), typeset(unit)
    converted, suffix = shown_in(value, unit), f" {unit}" if unit else ""
    if low <= converted <= high:
        return ""
    return (
        f"{converted:.3g}{suffix} is unusual ({low:g} to {high:g}{suffix} is common): "
        "check number and unit"
    )
