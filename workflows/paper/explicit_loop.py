"""The explicit wear loop of Bosman & de Rooij (Fig. 2), in public functions of `tribo`.

Each increment of the load wears the pin by the pressure that its shape had before this wear. Only
the nearest periodic image of each element deforms and heats the window (Fig. 3).
"""

from __future__ import annotations

import numpy as np

from tribo import Grid, InputError, Scene, Wear, contact_modulus
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.thermal import ConductingHalfSpace, partition_heat
from tribo.types import Array

EXPLICIT_LIMIT = 2.0
"""Value of `stiffness` from which on the loop is unstable."""


def explicit_loop(scene: Scene, normal_load: float, velocity: float) -> Array:
    """Pressure [Pa] that the loop computes after a ramp to a load [N], shape ``scene.grid.shape``.

    The `velocity` is that of sliding [m/s]. Contacts are solved to a residual of 1e-8, since the
    loop amplifies their errors where it is unstable.
    """
    grid, wear = scene.grid, _archard_wear(scene)
    solid = _solid(scene, grid)
    shape, impulse, pressure = scene.separation(scene.heights()), 0.0, None
    for step in scene.all_load_steps(normal_load):
        pressure = solve_contact(
            solid,
            shape,
            step.normal_load / scene.pin.windows(grid),
            scene.hardness,
            initial_pressure=pressure,
        ).pressure
        # Shorter than the increment's distance, since the load was lower before: the worn volume of
        # an increment is k∫F dS.
        distance = velocity * (step.impulse - impulse) / step.normal_load
        shape, impulse = shape + wear.depth(pressure, distance), step.impulse
    return np.zeros(grid.shape) if pressure is None else pressure


def highest_rise(scene: Scene, pressure: Array, velocity: float, time: float) -> float:
    """Highest temperature rise for friction 1 [K], after a pressure [Pa] has acted for a time [s].

    The pin is at rest, and the disk slides at `velocity` [m/s].
    """
    pin, disk = (
        ConductingHalfSpace(scene.grid, material, body_velocity, time, length="nearest-image")
        for material, body_velocity in ((scene.pin.material, 0.0), (scene.disk, velocity))
    )
    return float(partition_heat(pin, disk, velocity * pressure, pressure > 0).rise.max())


def stiffness(scene: Scene, grid: Grid, distance: float) -> float:
    """Stiffness of the wear equation on a grid: k·dS/λ_min for an increment's sliding distance dS.

    k is the specific wear rate. λ_min is the smallest compliance of the half-space to a wave of
    pressure [m/Pa]; for the pattern "swept", to a wave that is uniform along y. Exact wear lets the
    shape of this wave decay by exp(−k·dS/λ_min); the loop multiplies it by 1 − k·dS/λ_min.
    """
    wear, spectrum = _archard_wear(scene), _solid(scene, grid).spectrum
    compliances = spectrum[:, 0] if wear.pattern == "swept" else spectrum
    return wear.specific_wear_rate * distance / float(compliances[compliances > 0].min())


def _solid(scene: Scene, grid: Grid) -> ElasticHalfSpace:
    return ElasticHalfSpace(
        grid, contact_modulus(scene.pin.material, scene.disk), kernel="nearest-image"
    )


def _archard_wear(scene: Scene) -> Wear:
    """Wear of a scene; `InputError` unless it has a constant specific wear rate."""
    if not isinstance(scene.wear, Wear):
        raise InputError("the explicit loop needs a scene with [wear] of a constant rate")
    return scene.wear
