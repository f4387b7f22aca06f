"""Simpler criteria of severe wear: from the smooth contact alone, without a simulation.

Each is a number that grows with load and velocity. As a criterion it says that wear turns severe
where the number exceeds a limit: for Blok's flash temperature the limit is the critical
temperature; the others have none of their own and take it from measured transitions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Self

import numpy as np

from tribo import InputError, Material, Motion, analytic, contact_modulus


@dataclass(frozen=True, slots=True)
class SmoothContact:
    """The smooth contact, as the simple criteria know it."""

    radius: float  # of the pin [m]
    length: float | None  # of a cylinder [m]; None for a ball or a crowned pin
    pin: Material
    disk: Material
    motion: Motion | None = None  # None if the pin is at rest
    crown_radius: float | None = None  # of a crowned pin, across sliding [m]

    @classmethod
    def stored(cls, attributes: Mapping[str, Any]) -> Self:
        """Take what the attributes of a stored sweep say."""
        scene = attributes["scene"]
        pin, motion = scene["pin"], scene.get("motion")
        return cls(
            pin["radius"],
            pin.get("length"),
            _of_plain(Material, pin["material"]),
            _of_plain(Material, scene["disk"]),
            _of_plain(Motion, motion) if motion else None,
            pin.get("crown_radius"),
        )

    def width(self, load: float) -> float:
        """Width of the elastic, unworn contact at a load [N] [m]."""
        return 2 * self._hertz(load).half_width

    def area(self, load: float, width: float | None = None) -> float:
        """Area of the contact [m²], of another width [m] if that is given."""
        across = self.width(load) if width is None else width
        if self.length is not None:
            return across * self.length
        return math.pi / 4 * across**2 * self._hertz(load).aspect

    def _hertz(self, load: float) -> analytic.HertzContact:
        shape = self.radius, self.length, self.crown_radius
        return analytic.hertz_contact(load, contact_modulus(self.pin, self.disk), *shape)

    def flash_rise(
        self, load: float, velocity: float, friction: float, width: float | None = None
    ) -> float:
        """Blok's flash temperature of the smooth line contact above the bulk [K].

        Its width is that of Hertz, or another [m]. An `InputError` unless it is a line contact, and
        bodies that both move are of the same material.
        """
        if self.length is None:
            raise InputError("Blok's flash temperature of a line contact needs a cylinder")
        if self.motion and self.pin != self.disk:
            raise InputError("Blok's flash temperature of two moving bodies needs identical ones")
        both = self.motion.velocities(velocity) if self.motion else (0.0, velocity)
        across = self.width(load) if width is None else width
        return analytic.rolling_sliding_rise(
            friction, load / self.length, across, (both[0], both[1]), self.disk.thermal_effusivity
        )


class Rival(NamedTuple):
    """A simple criterion: its value in SI of a contact, load [N], velocity [m/s] and friction."""

    label: str
    unit: str  # unit in which to show its value
    scale: float  # factor from its value in SI to that unit
    value: Callable[[SmoothContact, float, float, float], float]  # in SI


RIVALS: dict[str, Rival] = {
    "blok": Rival("Blok, smooth", "K", 1.0, SmoothContact.flash_rise),
    "power": Rival("friction power", "W", 1.0, lambda _, F, V, mu: mu * F * V),
    "power-density": Rival(
        "power per area", "W/mm²", 1e-6, lambda contact, F, V, mu: mu * F * V / contact.area(F)
    ),
    "pv": Rival("PV", "GPa m/s", 1e-9, lambda contact, F, V, _: F * V / contact.area(F)),
}
"""Simple criteria by the name that ``irg plot --rival`` takes."""


def load_speed_exponent(loads: list[float], velocities: list[float]) -> float:
    """Exponent n for which F·Vⁿ is most nearly constant along a line, least squares in ln F.

    Examples
    --------
    >>> f"{load_speed_exponent([750.0, 600.0, 400.0, 200.0], [1.25, 1.5, 2.25, 3.75]):.2f}"
    '1.19'
    """
    return -float(np.polyfit(np.log(velocities), np.log(loads), 1)[0])


def _of_plain(kind: type[Any], plain: Mapping[str, Any]) -> Any:
    """An object from what a store says of it, in which infinity is text."""
    names = {field.name for field in fields(kind)}
    values = {name: value for name, value in plain.items() if name in names}
    return kind(**{name: math.inf if value == "inf" else value for name, value in values.items()})
