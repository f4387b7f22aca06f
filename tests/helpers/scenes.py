"""Small scenes of the paper's system for tests."""

from tribo import (
    Cylinder,
    Fidelity,
    Grid,
    Material,
    Ramp,
    Scene,
    SelfAffineRoughness,
    Wear,
    simulate,
)

STEEL = Material(
    elastic_modulus=210e9,
    poisson_ratio=0.3,
    hardness=6.6e9,
    thermal_conductivity=45.0,
    density=7800.0,
    specific_heat=470.0,
)


def small_scene(pattern="swept", roughness=True, wear=True, periodic=(False, True), **fidelity):
    """48 × 16 elements under the paper's pin, its ramp in 10 increments."""
    choices = {"pixels_per_element": 1, "increments": 10, "contact_tolerance": 1e-6} | fidelity
    return Scene(
        pin=Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
        disk=STEEL,
        pixels=Grid((48, 16), (8e-6, 8e-6), periodic),
        loading=Ramp(rate=150.0, reference_load=750.0),
        roughness=SelfAffineRoughness(0.27e-6, 0.8, (16e-6, 16e-6), seed=0) if roughness else None,
        wear=Wear(1.2e-15, pattern) if wear else None,
        fidelity=Fidelity(**choices),
    )


def last(scene, load, velocity):
    """State at the end of a point."""
    *_, state = simulate(scene, load, velocity)
    return state
