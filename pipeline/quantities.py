"""Quantities: the units of each dimension and their sizes, and the unit in which each is shown."""

from __future__ import annotations

import math
from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from typing import Any, NamedTuple


class Dimension(NamedTuple):
    """A physical dimension: its name, the lowest and highest value in a scene, and its units.

    `units` maps each unit to its size in SI, as decimal text. The SI unit stands first.
    """

    name: str
    limits: tuple[str, str]
    units: dict[str, str]


DIMENSIONS = {
    "m": Dimension("a length", ("1e-12 m", "1e5 m"),
        {"m": "1", "nm": "1e-9", "um": "1e-6", "µm": "1e-6", "mm": "1e-3", "cm": "1e-2"},
    ),
    "m s-1": Dimension("a velocity", ("1e-9 m/s", "1e5 m/s"), {"m/s": "1", "mm/s": "1e-3"}),
    "s": Dimension("a duration", ("1e-9 s", "1e12 s"), {"s": "1", "ms": "1e-3", "min": "60"}),
    "K": Dimension("a temperature", ("1e-9 K", "1e5 K"), {"K": "1", "degC": "1", "°C": "1"}),
    "N": Dimension("a load", ("1e-9 N", "1e9 N"), {"N": "1", "kN": "1e3", "mN": "1e-3"}),
    "N s-1": Dimension("a loading rate", ("1e-9 N/s", "1e12 N/s"), {"N/s": "1"}),
    "Pa": Dimension("a pressure", ("1e-3 Pa", "1e15 Pa"), {"Pa": "1", "MPa": "1e6", "GPa": "1e9"}),
    "Pa s": Dimension("a viscosity", ("1e-9 Pa s", "1e9 Pa s"), {"Pa s": "1", "mPa s": "1e-3"}),
    "kg m-3": Dimension("a density", ("1e-3 kg/m^3", "1e6 kg/m^3"), {"kg/m^3": "1"}),
    "W m-1 K-1": Dimension("a conductivity", ("1e-6 W/(m K)", "1e6 W/(m K)"), {"W/(m K)": "1"}),
    "J kg-1 K-1": Dimension(
        "a specific heat", ("1e-3 J/(kg K)", "1e7 J/(kg K)"), {"J/(kg K)": "1"}),
    "m2 s-1": Dimension(
        "a kinematic viscosity", ("1e-12 m^2/s", "1e3 m^2/s"),
        {"m^2/s": "1", "mm^2/s": "1e-6", "mm²/s": "1e-6"},
    ),
    "m2 N-1": Dimension(
        "a specific wear rate", ("1e-30 m^2/N", "1e-3 m^2/N"),
        {"m^2/N": "1", "mm^3/(N m)": "1e-9", "mm³/(N m)": "1e-9", "1/GPa": "1e-9"},
    ),
}  # fmt: skip
"""Dimensions of scenes, by the unit of SI as CF writes it.

The limits are far beyond any machine, and far from where products of them leave double precision.
"""
ZERO = {"degC": Decimal("273.15"), "°C": Decimal("273.15")}
"""Temperatures at which these units are 0 [K]."""
_OUTPUT_SIZES = {
    "%": "1e-2", "kB": "1e3", "MB": "1e6", "GB": "1e9", "mm³": "1e-9",
    "MJ/(m³ K)": "1e6", "N m": "1", "°": "0.017453292519943295",
}  # fmt: skip
"""Sizes in SI of units that only output uses, not scenes."""
UNITS = {
    "load": "N", "normal_load": "N", "critical_load": "N", "friction_force": "N",
    "velocity": "m/s", "critical_velocity": "m/s", "time": "s", "hold": "s", "spacing": "µm",
    "bulk_temperature": "°C", "critical_temperature": "°C",
    "governing_temperature": "°C", "end_temperature": "°C", "temperature_error": "K",
    "surface_error": "K",
    "distance": "K", "friction": "",
    "critical_area_fraction": "", "viscosities": "mm²/s",
    "thermal_diffusivity": "mm²/s", "heat_capacity": "MJ/(m³ K)",
    "pressure_coefficient": "1/GPa",
}  # fmt: skip
"""Units in which quantities are shown, by the names of columns and fields; empty for a number."""
SIZES = _OUTPUT_SIZES | {
    unit: size for dimension in DIMENSIONS.values() for unit, size in dimension.units.items()
}
"""Size of each unit in SI."""
ROUNDING = 5e-6
"""Relative difference up to which numbers agree in the six digits that are printed."""
_FACTORS = {unit: float(1 / Fraction(size)) for unit, size in SIZES.items()}


def in_unit(value: Any, unit: str) -> Any:
    """Convert a value, or an array, from SI to a unit; unchanged if the unit is not known.

    Examples
    --------
    >>> in_unit(418.0, "°C"), in_unit(2.5e-6, "µm")
    (144.85000000000002, 2.5)
    """
    return value * _FACTORS.get(unit, 1.0) - float(ZERO.get(unit, 0))


def snap(value: float, low: float, high: float) -> float:
    """Return a value, or `low` or `high` if the value exceeds it only by rounding.

    Examples
    --------
    >>> snap(400.0001, 200.0, 400.0), snap(401.0, 200.0, 400.0)
    (400.0, 401.0)
    """
    within = min(max(value, low), high)
    return within if math.isclose(within, value, rel_tol=ROUNDING) else value


def display(value: float, unit: str, form: int | str = 6) -> str:
    """Write an SI value as text in a unit; `form` is the number of digits or a form like ``".0f"``.

    Examples
    --------
    >>> display(1.234e-5, "µm", 3), display(418.4, "°C", ".0f")
    ('12.3 µm', '145 °C')
    """
    return f"{format(in_unit(value, unit), f'.{form}g' if isinstance(form, int) else form)} {unit}"


def display_sides(sides: Iterable[float]) -> str:
    """Write sides of a window or a pixel as text, such as ``102.4 × 51.2 µm``."""
    return " × ".join(f"{in_unit(side, 'µm'):.4g}" for side in sides) + " µm"
