"""Quantities as a user gives them in Python, in SI or as text with a unit, and is shown them."""

from __future__ import annotations

from pipeline.scene.units import SI_UNITS, UnitError, to_si
from tribo import InputError

_FACTORS = {
    "mm": 1e3, "µm": 1e6, "GPa": 1e-9, "%": 1e2, "MB": 1e-6, "mm³/(N m)": 1e9, "1/GPa": 1e9,
    "mm³": 1e9, "mm² K/W": 1e6, "MJ/(m³ K)": 1e-6, "mm²/s": 1e6,
}  # fmt: skip
"""Values in these units of one in SI; any other unit is that of SI, but for °C."""


def in_si(name: str, value: float | str, like: str) -> float:
    """Value in SI of a number in SI, or of text with a unit like that of the example.

    Examples
    --------
    >>> in_si("load", 600.0, like="750 N"), in_si("load", "0.6 kN", like="750 N")
    (600.0, 600.0)
    """
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
    """Value of a share, as a number or as text such as ``"10%"``.

    Examples
    --------
    >>> share_of(0.1), share_of("10%"), share_of("0.1")
    (0.1, 0.1, 0.1)
    """
    if not isinstance(value, str):
        return value
    number = value.strip().removesuffix("%")
    try:
        return float(number) / 100 if number != value.strip() else float(number)
    except ValueError:
        raise InputError(f'"{value}": give a share such as 10% or 0.1') from None


def shown_in(value: float, unit: str) -> float:
    """Value of a quantity in a unit in which such quantities are shown.

    Examples
    --------
    >>> shown_in(298.15, "°C"), shown_in(2e-3, "mm")
    (25.0, 2.0)
    """
    return value - 273.15 if unit == "°C" else value * _FACTORS.get(unit, 1.0)


def si_of(value: float, unit: str) -> float:
    """Value in SI of one in a unit in which such quantities are shown.

    Examples
    --------
    >>> si_of(25.0, "°C"), si_of(2.0, "mm")
    (298.15, 0.002)
    """
    return round(value + 273.15, 9) if unit == "°C" else value / _FACTORS.get(unit, 1.0)


def is_shown_unit(unit: str) -> bool:
    """Whether quantities are shown in a unit: one of SI, or of those that have factors here."""
    return unit == "°C" or unit in _FACTORS or unit in SI_UNITS


def display(value: float, unit: str, digits: int = 6) -> str:
    """Write an SI value as text in a unit such as °C, N, m/s, µm or GPa.

    Examples
    --------
    >>> display(298.15, "°C"), display(1.25, "m/s"), display(2.7e-7, "µm")
    ('25 °C', '1.25 m/s', '0.27 µm')
    """
    return f"{shown_in(value, unit):.{digits}g} {unit}"
