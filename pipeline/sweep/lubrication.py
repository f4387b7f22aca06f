"""The film of an oil between smooth bodies before any wear, which enters no simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribo import Oil, Scene, contact_modulus
from tribo.simulation.pins import OilEntry
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class Lubrication:
    """Oil film between the smooth, unworn bodies of a scene, and its film parameter Λ.

    Examples
    --------
    >>> import tribo
    >>> steel = tribo.Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> ball, pixels = tribo.Ball(10e-3, steel), tribo.Grid((64, 64), (4e-6, 4e-6), (False, False))
    >>> scene = tribo.Scene(pin=ball, disk=steel, pixels=pixels, loading=tribo.Ramp(10.0, 10.0))
    >>> oil = tribo.Oil((313.15, 373.15), (32e-6, 5.4e-6), 866.0, (20e-9, 15e-9))
    >>> film = Lubrication(scene, oil, rms_height=0.3e-6)
    >>> f"{film.film_parameter(10.0, 0.065, 298.15):.3f}"
    '0.067'
    """

    scene: Scene
    oil: Oil  # with a pressure-viscosity coefficient
    rms_height: float  # of the disk [m]

    def film_thickness(self, load: float, velocity: float, temperature: float) -> float:
        """Minimum film thickness [m] at a load [N], a sliding velocity [m/s], a temperature [K].

        If the pin is at rest, the oil enters at half the sliding velocity.
        """
        entrainment = abs(sum(self.scene.velocities_at(velocity))) / 2
        viscosity = self.oil.viscosity(temperature)
        coefficient = self.oil.pressure_coefficient(temperature)
        modulus = contact_modulus(self.scene.pin.material, self.scene.disk)
        oil = OilEntry(entrainment, viscosity, coefficient)
        return self.scene.pin.film_thickness(oil, load, modulus)

    def film_parameter(self, load: ArrayLike, velocity: ArrayLike, temperature: float) -> Array:
        """Film parameter Λ at loads [N] and velocities [m/s], which broadcast.

        It is NaN if the load is not above 0, or the velocity is not finite. `temperature` is the
        oil's at the inlet [K].
        """
        loads, velocities = np.broadcast_arrays(load, velocity)
        parameters = np.full(loads.shape, np.nan)
        for index in np.ndindex(loads.shape):
            load, velocity = float(loads[index]), float(velocities[index])
            if load > 0 and math.isfinite(velocity):
                film = self.film_thickness(load, velocity, temperature)
                parameters[index] = film / self.rms_height
        return parameters
