"""Summary of the disk's surface, and the oil film on it, before any simulation."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tribo.constants import LAY_RATIO
from tribo.errors import InputError
from tribo.material import Oil, contact_modulus
from tribo.numerics import Grid
from tribo.simulation.pins import OilEntry
from tribo.simulation.scene import Scene
from tribo.surface import MeasuredRoughness, SelfAffineRoughness, UnknownHeights
from tribo.surface.areal import areal_roughness
from tribo.types import Array

_MAX_PIXELS = 1_000_000  # of a random surface whose heights are computed only for its summary
_RQ_OF_RA = math.sqrt(math.pi / 2)  # Rq/Ra of normally distributed heights


@dataclass(frozen=True, slots=True)
class SurfaceSummary:
    """Roughness parameters of the disk's surface on its pixels."""

    measured: bool
    ra: float  # mean distance of the heights from their mean plane [m]
    rq: float  # root mean square distance [m]
    mean_height: float = 0.0  # [m]
    rise: tuple[float, float] = (0.0, 0.0)  # of the mean plane over the window, along x and y [m]
    radii: tuple[float, float] = (math.inf, math.inf)  # of a curvature along x and y [m]
    lay: float | None = None  # angle of grooves to sliding [°]; None without grooves
    slope: float | None = None  # root mean square along x; None if no heights are computed


def summarize_surface(scene: Scene) -> SurfaceSummary | None:
    """Roughness of the disk's surface; None if the surface is smooth or its heights are unknown.

    For a random surface of over 10⁶ pixels no heights are computed: Rq is estimated from Ra.
    """
    surface = scene.roughness
    if isinstance(surface, UnknownHeights):
        known: SurfaceSummary | None = surface.summary
        return known
    return _surface_summary(surface, scene.pixels)


@functools.lru_cache(maxsize=1)  # called again whenever a store grows
def _surface_summary(surface: Any, pixels: Grid) -> SurfaceSummary | None:
    if surface is None:
        return None
    lay, is_random = None, isinstance(surface, SelfAffineRoughness)
    if is_random:
        along_x, along_y = surface.correlation_length
        is_along, is_across = along_x >= LAY_RATIO * along_y, along_y >= LAY_RATIO * along_x
        lay = 0.0 if is_along else 90.0 if is_across else None
        if math.prod(pixels.shape) > _MAX_PIXELS:
            return SurfaceSummary(False, surface.ra, surface.ra * _RQ_OF_RA, lay=lay)
    is_scan = isinstance(surface, MeasuredRoughness)
    heights: Array = surface.array if is_scan else surface.heights(pixels)
    slopes = np.diff(heights, axis=0) / pixels.spacing[0]  # along sliding; none for a single row
    try:
        areal = areal_roughness(heights, pixels.spacing, with_lay=not is_random)
    except InputError:  # no height differs from its plane
        return SurfaceSummary(not is_random, 0.0, 0.0)
    return SurfaceSummary(
        measured=not is_random,
        ra=areal.sa,
        rq=areal.sq,
        mean_height=areal.mean,
        rise=tuple(np.multiply(areal.slopes, np.multiply(heights.shape, pixels.spacing)).tolist()),
        radii=areal.radii,
        lay=lay if areal.lay is None else abs(areal.lay),
        slope=float(slopes.std()) if len(slopes) else None,
    )


def find_lubrication(scene: Scene, oil: Oil | None) -> Lubrication | None:
    """Lubrication of a scene by an oil; None if oil or roughness are missing or not fully known."""
    if oil is None or oil.pressure_coefficient is None:
        return None
    summary = summarize_surface(scene)
    return Lubrication(scene, oil, summary.rq) if summary and summary.rq else None


@dataclass(frozen=True, slots=True)
class Lubrication:
    """Oil film between the smooth, unworn bodies of a scene, and its film parameter Λ.

    Examples
    --------
    >>> import tribo
    >>> steel = tribo.Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> ball, pixels = tribo.Ball(10e-3, steel), tribo.Grid((64, 64), (4e-6, 4e-6), (False, False))
    >>> scene = tribo.Scene(pin=ball, disk=steel, pixels=pixels, loading=tribo.Ramp(10.0, 10.0))
    >>> oil = tribo.Oil((32e-6, 5.4e-6), 866.0, 20e-9)
    >>> film = Lubrication(scene, oil, rms_height=0.3e-6)
    >>> f"{film.film_parameter(10.0, 0.065, 298.15):.3f}"
    '0.064'
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
        coefficient = self.oil.pressure_coefficient or math.nan
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
