"""Small scenes of the paper's system for tests."""

from dataclasses import replace

import tribo

STEEL = tribo.Material(
    elastic_modulus=210e9,
    poisson_ratio=0.3,
    hardness=6.6e9,
    thermal_conductivity=45.0,
    density=7800.0,
    specific_heat=470.0,
)

SCENE = """
title = "A small sweep"

[materials.steel]
elastic_modulus = "210 GPa"
poisson_ratio = 0.3
hardness = "6.6 GPa"
thermal_conductivity = "45 W/(m K)"
density = "7800 kg/m^3"
specific_heat = "470 J/(kg K)"

[pin]
shape = "cylinder"
radius = "2 mm"
length = "3.4 mm"
material = "steel"

[disk]
material = "steel"

[disk.roughness]
ra = "0.27 um"
hurst_exponent = 0.8
correlation_length = "16 um"
seed = 0

[window]
pixels = [48, 16]
pixel_size = ["8 um", "8 um"]

[loading]
rate = "150 N/s"
reference_load = "750 N"

[wear]
specific_wear_rate = "1.2e-6 mm^3/(N m)"
pattern = "swept"

[friction]
coefficient = 0.1

[temperature]
bulk = "25 degC"
critical = "145 degC"
critical_area_fraction = 0.1

[fidelity]
pixels_per_element = 1
increments = 10

[sweep]
loads = ["200 N", "400 N", "600 N"]
velocities = ["1 m/s", "2 m/s", "4 m/s"]
fields = true
"""

MEASURED = """
[[tests]]
load = "400 N"
velocity = "2 m/s"
outcome = "transition"
"""


def small_scene(pattern="swept", roughness=True, wear=True, periodic=(False, True), **fidelity):
    """Scene with 48 × 16 elements under the paper's pin, with a ramp in 10 increments."""
    choices = {"pixels_per_element": 1, "increments": 10, "contact_tolerance": 1e-6} | fidelity
    pixels = tribo.Grid((48, 16), (8e-6, 8e-6), periodic)
    length = 3.4e-3 if periodic[1] else pixels.size[1]
    return tribo.Scene(
        pin=tribo.Cylinder(radius=2e-3, length=length, material=STEEL),
        disk=STEEL,
        pixels=pixels,
        loading=tribo.Ramp(rate=150.0, reference_load=750.0),
        roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (16e-6, 16e-6), seed=0)
        if roughness
        else None,
        wear=tribo.Wear(1.2e-15, pattern) if wear else None,
        fidelity=tribo.Fidelity(**choices),
    )


def with_hardness(scene, hardness):
    """The scene with another hardness [Pa] of the steel of both bodies."""
    steel = replace(STEEL, hardness=hardness)
    return replace(scene, pin=replace(scene.pin, material=steel), disk=steel)


def last(scene, load, velocity):
    """Last state of a simulated point."""
    *_, state = tribo.simulate(scene, load, velocity)
    return state
