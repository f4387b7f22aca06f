"""The rig with which the paper measures the critical temperature of an oil, and its steel."""

from __future__ import annotations

from tribo import Ball, Fidelity, Grid, InputError, Material, Ramp, Scene, contact_modulus, simulate
from tribo.analytic import hertz_point_radius

AISI_316 = Material(
    elastic_modulus=210e9,
    poisson_ratio=0.3,
    thermal_conductivity=17.0,
    density=7780.0,
    specific_heat=460.0,
    hardness=1.1e9,
)
"""Austenitic stainless steel (Bosman & de Rooij, Table 3)."""


def critical_temperature_rig(normal_load: float = 10.0, duration: float = 60.0) -> Scene:
    """Ball-on-disk rig with which Bosman & de Rooij measured the critical temperature of an oil.

    A polished ball of radius 10 mm on a disk, both of AISI 316 and taken as smooth, slides for a
    duration [s]; the contact has its steady temperature after milliseconds. The surfaces do not
    wear, which leaves them as hot as can be.

    Examples
    --------
    >>> import tribo
    >>> scene = critical_temperature_rig()
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> f"{0.1 * state.heat.max_rise:.1f} K at friction 0.1"
    '7.5 K at friction 0.1'
    """
    radius = 10e-3
    modulus = contact_modulus(AISI_316, AISI_316)
    side = 3 * hertz_point_radius(normal_load, radius, modulus) / 64
    return Scene(
        pin=Ball(radius, AISI_316),
        disk=AISI_316,
        pixels=Grid((64, 64), (side, side), periodic=(False, False)),
        loading=Ramp(normal_load, normal_load, hold=duration),
        fidelity=Fidelity(pixels_per_element=1, increments=1, contact_tolerance=1e-6),
    )


def rig_heating(friction: float = 0.1, velocity: float = 0.065, normal_load: float = 10.0) -> float:
    """Highest friction heating in the rig of `critical_temperature_rig` above its bulk [K].

    The critical temperature that such a rig shows, at the bulk temperature where friction jumps,
    is too low by this; Bosman & de Rooij state at most 15 °C.

    Examples
    --------
    >>> f"{rig_heating():.1f} K"
    '7.5 K'
    """
    *_, state = simulate(critical_temperature_rig(normal_load), normal_load, velocity)
    if state.heat is None:
        raise InputError("nothing is in contact")
    return friction * state.heat.max_rise
