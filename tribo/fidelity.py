"""Every numerical choice, in one object: what trades speed for accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from tribo.errors import InputError, require_positive

__all__ = ["PRESETS", "Fidelity"]

Partition = Literal["local", "uniform", "direct"]
_PARTITIONS: tuple[Partition, ...] = ("local", "uniform", "direct")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """Numerical choices of a simulation.

    Parameters
    ----------
    pixels_per_element : int
        Pixels of the surface, along each axis, that are averaged to one element.
    increments : int
        Steps of the ramp up to its reference load.
    contact_tolerance : float
        Residual of the contact at which its solver stops; see `tribo.solve_contact`.
    partition : {"local", "uniform", "direct"}
        How friction heat is divided between the bodies; see `tribo.partition_heat`.
    heat_tolerance : float
        Relative residual of the heat partition at which its solver stops.
    temperature_interval : int
        A point's temperature is computed at its end, and on its way at every so many stations of
        the ramp; 0 for at the end only.

    Raises
    ------
    InputError
        If a value lies outside its range.
    """

    pixels_per_element: int = 2
    increments: int = 100
    contact_tolerance: float = 1e-3
    partition: Partition = "local"
    heat_tolerance: float = 1e-6
    temperature_interval: int = 0

    def __post_init__(self) -> None:
        for name, lowest in (
            ("pixels_per_element", 1),
            ("increments", 1),
            ("temperature_interval", 0),
        ):
            value = getattr(self, name)
            if value != int(value) or value < lowest:
                raise InputError(f"{name} is {value!r}; it must be an integer of at least {lowest}")
        require_positive(
            contact_tolerance=self.contact_tolerance, heat_tolerance=self.heat_tolerance
        )
        if self.partition not in _PARTITIONS:
            raise InputError(
                f"partition is {self.partition!r}; allowed are {', '.join(_PARTITIONS)}"
            )


PRESETS: dict[str, Fidelity] = {
    "draft": Fidelity(pixels_per_element=4, increments=20, heat_tolerance=1e-4),
    "standard": Fidelity(pixels_per_element=2, increments=100),
    "reference": Fidelity(
        pixels_per_element=1, increments=200, contact_tolerance=1e-5, heat_tolerance=1e-8
    ),
}
"""Fidelity by name, from fast to exact."""
