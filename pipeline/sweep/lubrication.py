"""Regime of lubrication at a point: the film that a scene's oil would build.

The film is that between smooth bodies at the bulk temperature, with the pin's radius as it was
before any wear; the film parameter Λ is its thickness over the root mean square height of the
disk. A pin that has worn flat is closer to the disk's shape, and builds another film.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from pipeline.sweep.model import Sweep
from pipeline.sweep.surface import surface_facts
from tribo import Motion, Oil, analytic, contact_modulus, minimum_line_film, minimum_point_film
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class Lubrication:
    """Quantities that the film parameter of a scene depends on."""

    oil: Oil  # with a pressure-viscosity coefficient
    radius: float  # of the pin [m]
    length: float | None  # of a cylinder [m]; None for any other pin
    contact_modulus: float  # [Pa]
    rms_height: float  # of the disk [m]
    motion: Motion | None = None  # None if the pin is at rest
    crown_radius: float | None = None  # of a crowned roller, across the motion [m]

    @classmethod
    def of(cls, sweep: Sweep) -> Self | None:
        """Take what a scene says; None if it gives no oil, or not enough of it, or no roughness."""
        if sweep.about.oil is None or sweep.about.oil.pressure_coefficients is None:
            return None
        surface = surface_facts(sweep)
        if surface is None or surface.rq == 0:
            return None
        pin = sweep.scene.pin
        return cls(
            sweep.about.oil,
            pin.radius,
            pin.length,
            contact_modulus(pin.material, sweep.scene.disk),
            surface.rq,
            sweep.scene.motion,
            pin.crown_radius,
        )

    @classmethod
    def stored(cls, attributes: Mapping[str, Any]) -> Self | None:
        """Take what the attributes of a stored sweep say; None if they say nothing of it."""
        stored = attributes.get("lubrication")
        if not stored:
            return None
        oil: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in stored["oil"].items()
        }
        motion = stored.get("motion")
        parts = {"oil": Oil(**oil), "motion": Motion(**motion) if motion else None}
        return cls(**{**stored, **parts})

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, which `stored` reads."""
        return asdict(self)

    def film_thickness(self, load: float, velocity: float, temperature: float) -> float:
        """Minimum film thickness at a load [N], a sliding velocity [m/s] and a temperature [K] [m].

        Where the pin is at rest, the oil enters at half the sliding velocity.
        """
        both = self.motion.velocities(velocity) if self.motion else (0.0, velocity)
        viscosity = self.oil.viscosity(temperature)
        coefficient = self.oil.pressure_coefficient(temperature)
        oil = abs(sum(both)) / 2, viscosity, coefficient
        if self.length is None:
            solids = self.radius, self.contact_modulus, self.ellipticity
            return minimum_point_film(*oil, load, *solids)
        return minimum_line_film(*oil, load / self.length, self.radius, self.contact_modulus)

    @property
    def ellipticity(self) -> float:
        """Width of a point contact across the motion over that along it (Hertz)."""
        shape = self.radius, None, self.crown_radius
        return analytic.hertz_contact(1.0, self.contact_modulus, *shape).aspect  # at any load

    def film_parameter(self, load: ArrayLike, velocity: ArrayLike, temperature: float) -> Array:
        """Film parameter Λ of loads [N] and velocities [m/s], broadcast.

        The sign of a velocity makes no difference. NaN where either is, and without a load.

        Examples
        --------
        >>> oil = Oil((313.15, 373.15), (32e-6, 5e-6), 866.0, (20e-9, 20e-9))
        >>> white = Lubrication(oil, 2e-3, 3.4e-3, 115.385e9, 0.338e-6)
        >>> print(white.film_parameter([750.0, 200.0], [1.25, 3.75], 298.15).round(2))
        [0.35 0.89]
        """
        loads, velocities = np.broadcast_arrays(load, velocity)
        parameters = np.full(loads.shape, np.nan)
        for index in np.ndindex(loads.shape):
            load, velocity = float(loads[index]), float(velocities[index])
            if load > 0 and math.isfinite(velocity):
                film = self.film_thickness(load, velocity, temperature)
                parameters[index] = film / self.rms_height
        return parameters
