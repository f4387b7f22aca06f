"""The smooth line contact, from which simpler criteria of severe wear take their numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tribo import Cylinder, Material, analytic, contact_modulus


@dataclass(frozen=True, slots=True)
class SmoothContact:
    """A smooth cylinder at rest on a sliding flat."""

    pin: Cylinder
    disk: Material

    def width(self, load: float) -> float:
        """Width of the elastic, unworn contact [m] at a load [N]."""
        pin, modulus = self.pin, contact_modulus(self.pin.material, self.disk)
        return 2 * analytic.hertz_contact(load, modulus, pin.radius, pin.length).half_width

    def flash_rise(
        self, load: float, velocity: float, friction: float, width: float | None = None
    ) -> float:
        """Blok's flash temperature above bulk [K]; the contact `width` [m] is Hertz's if None."""
        across = self.width(load) if width is None else width
        line_load, effusivity = load / self.pin.length, self.disk.thermal_effusivity
        return analytic.rolling_sliding_rise(
            friction, line_load, across, (0.0, velocity), effusivity
        )


def load_speed_exponent(loads: list[float], velocities: list[float]) -> float:
    """Exponent n for which F·Vⁿ is most nearly constant over points, by least squares in ln F.

    Examples
    --------
    >>> f"{load_speed_exponent([750.0, 600.0, 400.0, 200.0], [1.25, 1.5, 2.25, 3.75]):.2f}"
    '1.19'
    """
    return -float(np.polyfit(np.log(velocities), np.log(loads), 1)[0])
