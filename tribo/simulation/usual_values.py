"""Usual ranges of the values of a scene and its conditions, and warnings of values outside them.

A value outside its range most often has another unit than SI. The warning names the unit in which
the same number would be usual.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from tribo.loading import Ramp
from tribo.simulation.conditions import Conditions
from tribo.simulation.scene import Scene

_ZERO_CELSIUS = 273.15  # [K]


class UsualRange(NamedTuple):
    """Usual values of a quantity, in a unit in which people state it."""

    low: float
    high: float
    unit: str
    size: float = 1.0  # of the unit, in SI
    si_unit: str = ""  # SI unit of `tribo`, if it is another one
    mistaken: tuple[tuple[str, float], ...] = ()  # further units that are mistaken for SI: sizes

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the range, in its unit."""
        return self.low, self.high

    def contains(self, value: float) -> bool:
        """True if a value in SI is in the range."""
        shift = _ZERO_CELSIUS if self.unit == "°C" else 0.0
        return self.low <= (value - shift) / self.size <= self.high

    def likely_unit(self, number: float) -> str:
        """Unit in which a number is in the range, although it was meant in SI; empty if none is."""
        if self.unit == "°C":
            return self.unit if self.low <= number <= self.high else ""
        units = ((self.unit, self.size), *self.mistaken)
        return next(
            (unit for unit, size in units if size != 1 and self.contains(number * size)), ""
        )


_LENGTHS = (("µm", 1e-6), ("cm", 1e-2))
_PRESSURES = (("MPa", 1e6), ("kPa", 1e3))
USUAL = {
    "elastic_modulus": UsualRange(1, 1200, "GPa", 1e9, "Pa", _PRESSURES),
    "hardness": UsualRange(0.01, 100, "GPa", 1e9, "Pa", _PRESSURES),
    "hardness_share": UsualRange(0.001, 0.2, "times the elastic modulus"),
    "thermal_conductivity": UsualRange(0.05, 2500, "W/(m K)"),
    "density": UsualRange(500, 25000, "kg/m³", mistaken=(("g/cm³", 1e3),)),
    "specific_heat": UsualRange(100, 5000, "J/(kg K)", mistaken=(("kJ/(kg K)", 1e3),)),
    "radius": UsualRange(0.1, 1000, "mm", 1e-3, "m", _LENGTHS),
    "length": UsualRange(0.1, 1000, "mm", 1e-3, "m", _LENGTHS),
    "crown_radius": UsualRange(0.1, 1e5, "mm", 1e-3, "m", _LENGTHS),
    "ra": UsualRange(0.001, 10, "µm", 1e-6, "m", (("nm", 1e-9),)),
    "specific_wear_rate": UsualRange(1e-11, 1e-2, "mm³/(N m)", 1e-9, "m²/N", (("mm²/N", 1e-6),)),
    "slide_roll_ratio": UsualRange(-20, 20, "", mistaken=(("%", 0.01),)),
    "velocity": UsualRange(0, 100, "m/s", mistaken=(("mm/s", 1e-3),)),
    "duration": UsualRange(0.05, 1e6, "s"),
    "reference_load": UsualRange(0.01, 100, "times the load"),
    "friction": UsualRange(0, 1, "", mistaken=(("%", 0.01),)),
    "bulk_temperature": UsualRange(-50, 250, "°C", 1.0, "K"),
    "critical_temperature": UsualRange(50, 800, "°C", 1.0, "K"),
    "added_rise_fraction": UsualRange(0, 0.5, "", mistaken=(("%", 0.01),)),
}
"""Usual ranges by quantity. The bounds of hardness are wide: lead has 0.003 of its elastic modulus,
diamond 0.1."""


def unusual_values(
    scene: Scene,
    load: float,
    velocity: float,
    conditions: Conditions | None = None,
    duration: float | None = None,
) -> Iterator[str]:
    """Yield a warning of each value of a scene and a point that is outside its usual range.

    The point has a `load` [N], a `velocity` [m/s] and, if known, the `duration` of its loading [s].
    """
    points = [("velocity", "velocity", abs(velocity)), ("loading", "duration", duration)]
    if isinstance(scene.loading, Ramp) and load:
        ratio = scene.loading.reference_load / load
        points.append(("loading.reference_load", "reference_load", ratio))
    for path, quantity, value in (*_values(scene, conditions), *points):
        usual = USUAL[quantity]
        if not value or not math.isfinite(value) or usual.contains(value):
            continue
        number = f"{value:.4g} {usual.si_unit or usual.unit}".strip()
        common = f"{usual.low:g} to {usual.high:g} {usual.unit}".strip()
        if unit := usual.likely_unit(value):
            yield (
                f"{path}: {number} is unusual ({common} is common): convert the number to SI, if "
                f"it is in {unit}"
            )
        else:
            yield f"{path}: {number} is unusual ({common} is common): check number and unit"


def _values(scene: Scene, conditions: Conditions | None) -> Iterator[tuple[str, str, Any]]:
    """Yield path, quantity and value of each value that has a usual range."""
    for path, material in (("pin.material", scene.pin.material), ("disk", scene.disk)):
        for name in ("elastic_modulus", "hardness", "thermal_conductivity", "density"):
            yield f"{path}.{name}", name, getattr(material, name)
        yield f"{path}.specific_heat", "specific_heat", material.specific_heat
        share = material.hardness / material.elastic_modulus
        yield f"{path}.hardness", "hardness_share", share
    for owner, names in (
        ("pin", ("radius", "length", "crown_radius")),
        ("roughness", ("ra",)),
        ("wear", ("specific_wear_rate",)),
        ("motion", ("slide_roll_ratio",)),
    ):
        for name in names:
            yield f"{owner}.{name}", name, getattr(getattr(scene, owner), name, None)
    for name in ("friction", "bulk_temperature", "critical_temperature", "added_rise_fraction"):
        yield f"conditions.{name}", name, getattr(conditions, name, None)
