"""Quantities with units, and hardness numbers: from text to SI."""

from __future__ import annotations

import functools
import json
import math
import re
import tomllib
from decimal import Decimal
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipeline.quantities import DIMENSIONS, ZERO
from tribo import InputError, TriboError

if TYPE_CHECKING:
    import pint


_MAX_LENGTH = 80  # letters of a quantity
_GRAVITY = Decimal("9.80665")  # [m/s²]
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
# Units have no "_", which excludes delta_degC, with which 25 °C would be read as 25 K.
_QUANTITY = re.compile(rf"\s*({NUMBER})\s*([A-Za-z0-9µμ°Ω²³⁻¹ .·*/^()-]*)", re.ASCII)
MAYBE_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}([.,]\d{3})+")
"""A number whose marks may divide thousands, or precede three decimals."""
_HARDNESS_SCALE = re.compile(r"(HV) ?[\d.]*|(HB)W?(?: ?[\d.]+/\d+)?|(HR)[Cc]")
_OTHER_SCALE = re.compile(r"H(R[ABD-Z]\w*|K|S|LD|M)")
_SCALE_FIRST = re.compile(r"^\s*(HV|HBW?|HR[Cc])\s*(\d.*)")

_PRINTED_SIGNS = str.maketrans({
    **dict(zip("−–µμº·⋅∙\xa0", "--uu°    ", strict=True)),
    "℃": "degC", "Å": "angstrom", "\u212b": "angstrom",
})  # fmt: skip
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_TIMES_TEN = re.compile(r"(?:\s*[×x]\s*10(?:\^|(?=[+-]))| +10\^)([+-]?\d{1,2})(?=\s*[A-Za-z])")
_SHARE = re.compile(rf"\s*({NUMBER})\s*(%|percent|per cent)?\s*", re.ASCII)
_SPELLINGS = tuple(
    (re.compile(pattern), replacement)
    for pattern, replacement in (
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


class Unit(NamedTuple):
    """A unit: the SI unit of its dimension in CF notation, its size, and its zero point in SI."""

    dimension: str
    size: Decimal
    zero: Decimal = Decimal(0)


@functools.lru_cache(maxsize=65536)  # cases repeat nearly all of their entries
def exact_si(text: str, like: str) -> Decimal:
    """Value in SI of a text such as ``"0.27 um"``, without rounding.

    `like` is any quantity of the required dimension. Hardness numbers are converted to a pressure.
    """
    dimension = si_unit(like)
    _require_short(text)
    number, unit = _number_and_unit(text)
    if unit.dimension != dimension:
        like_unit = like.partition(" ")[2]
        problem = "has no unit" if unit.dimension == "1" else f"cannot be converted to {like_unit}"
        raise UnitError(f"{_quoted(text)} {problem}")
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
    pipeline.units.UnitError: "7 kg" cannot be converted to N
    """
    for name, quantity in {"text": text, "like": like}.items():
        if not isinstance(quantity, str):
            words = " ".join(repr(quantity).split())  # an array has several lines
            raise UnitError(f"{name} is {words:.80}; give a number with a unit as text")
    value = float(exact_si(text, like))
    if math.isinf(value):
        raise UnitError(f"{_quoted(text)} is too large")
    return value


@functools.lru_cache(maxsize=256)
def si_unit(text: str) -> str:
    """SI unit of a quantity such as "45 W/(m K)", as CF conventions write it: ``"W m-1 K-1"``."""
    return _number_and_unit(text)[1].dimension


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    """The units known to pint; loaded when first needed, since loading takes 0.3 s."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _split(text: str) -> tuple[str, str]:
    """Split text into a number and a unit."""
    _require_short(text)
    plain = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+", lambda power: f"^{power[0].translate(_SUPERSCRIPTS)}", text)
    plain = _TIMES_TEN.sub(r"e\1", plain.translate(_PRINTED_SIGNS))
    match = _QUANTITY.fullmatch(_SCALE_FIRST.sub(r"\2 \1", plain))
    if match is None:
        advice = "; write decimals with a point, and no marks of thousands" if "," in text else ""
        raise UnitError(f"{_quoted(text)} is not a number with a unit{advice}")
    return match[1], match[2].strip()


def _require_short(text: str) -> None:
    """Raise a `UnitError` for a text that is too long for a quantity, before it is parsed."""
    if len(text) > _MAX_LENGTH:
        raise UnitError(f"{_quoted(text)} has {len(text)} characters; give {_MAX_LENGTH} at most")


def _number_and_unit(text: str) -> tuple[Decimal, Unit]:
    """Read a quantity as number and unit; a hardness number becomes a pressure."""
    number, unit_text = _split(text)
    try:
        if unit_text.startswith("H") and (scale := _HARDNESS_SCALE.fullmatch(unit_text)):
            return _hardness_pressure(Decimal(number), scale[scale.lastindex or 0]), _unit("Pa")
        if _OTHER_SCALE.fullmatch(unit_text):
            raise InputError("is on a scale that is not known: HRC, HV and HB are")
        return Decimal(number), _unit(unit_text)
    except InputError as error:
        raise UnitError(f"{_quoted(text)} {error}") from error


@functools.lru_cache(maxsize=1024)
def _unit(text: str) -> Unit:
    """Find a unit that is written as in data sheets; `InputError` if it is unknown."""
    for pattern, replacement in _SPELLINGS:
        text = pattern.sub(replacement, text)
    for cf_unit, dimension in DIMENSIONS.items():  # known without pint
        if text in dimension.units:
            return Unit(cf_unit, Decimal(dimension.units[text]), Decimal(ZERO.get(text, 0)))
    import pint

    registry = _registry()
    try:
        pint_unit = registry.parse_units(text)
        zero, first = (registry.Quantity(Decimal(k), pint_unit).to_base_units() for k in (0, 1))
    except pint.UndefinedUnitError as error:
        unknown = str(error).removesuffix(" is not defined in the unit registry")
        raise InputError(f"has an unknown unit: {unknown}") from error
    except Exception as error:  # pint raises errors that are not its own
        raise InputError("has a unit that cannot be read") from error
    size = first.magnitude - zero.magnitude
    for cf_unit, dimension in DIMENSIONS.items():
        if first.check(registry.parse_units(next(iter(dimension.units))).dimensionality):
            return Unit(cf_unit, size, zero.magnitude)
    base_units: Any = first.unit_items()
    powers = [(registry.get_symbol(name), int(power)) for name, power in base_units]
    powers.sort(key=lambda symbol_and_power: symbol_and_power[1] < 0)
    cf_unit = " ".join(f"{symbol}{power if power != 1 else ''}" for symbol, power in powers)
    return Unit(cf_unit or "1", size)


def _quoted(text: str) -> str:
    short = text if len(text) <= _MAX_LENGTH else f"{text[:_MAX_LENGTH]}..."
    return json.dumps(short, ensure_ascii=not short.isprintable())


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
            scale_name = "HRC" if scale == "HR" else scale
            raise InputError(
                f"is outside the range of the ASTM E140 conversion for steel ({numbers[0]} to "
                f"{numbers[-1]} {scale_name}); give HV or a pressure"
            )
        number = Decimal(float(np.interp(float(number), numbers, vickers)))
    return number * _GRAVITY * 10**6  # of kgf/mm²


def share_of(value: float | str) -> float:
    """Value of a share, as a number or as text such as ``"10%"`` or ``"10 percent"``."""
    if not isinstance(value, str):
        return value
    is_short = len(value) <= _MAX_LENGTH
    match = _SHARE.fullmatch(value.translate(_PRINTED_SIGNS)) if is_short else None
    if match is None:
        raise InputError(f"{_quoted(value)} is not a number; give one such as 0.1 or 10%")
    return float(match[1]) / (100 if match[2] else 1)


def typeset(text: str) -> str:
    """Write a unit, or a quantity, with signs as in print: µm, °, ² and ³."""
    for typed, sign in {"um": "µm", "deg": "°", "^2": "²", "^3": "³"}.items():
        text = text.replace(typed, sign)
    return text
