"""A rolling and sliding wheel, as it was computed by others.

The example ``ertz_temperature`` of CONTACT (github.com/eve70a/CONTACT), after Ertz and Knothe, Wear
253 (2002) 498: 100 kN, 30 m/s of rolling and 1 m/s of sliding, friction 0.3. CONTACT prints 166.8
and, with the wheel at 150 °C and the rail at 0 °C, 241.8 °C, since it counts an element's heat on
itself twice; its own sum with the element once is 150.0. Exact values are 150.33 and 225.3 °C.
"""

import math

import pytest

import tribo

SHEAR_MODULUS, POISSON_RATIO, FRICTION = 82e9, 0.28, 0.3
STEEL = tribo.Material(
    elastic_modulus=2 * SHEAR_MODULUS * (1 + POISSON_RATIO),
    poisson_ratio=POISSON_RATIO,
    hardness=math.inf,
    thermal_conductivity=50.0,
    density=7850.0,
    specific_heat=450.0,
)


@pytest.fixture(scope="module")
def contact():
    """The scene, and the contact at the end of its loading."""
    scene = tribo.Scene(
        pin=tribo.Crowned(radius=0.49261, crown_radius=1.18624, material=STEEL),
        disk=STEEL,
        pixels=tribo.Grid((96, 144), (14e-3 / 96, 28e-3 / 144), periodic=(False, False)),
        loading=tribo.Ramp(rate=100e3, reference_load=100e3),
        motion=tribo.Motion(slide_roll_ratio=1 / 30),
        fidelity=tribo.Fidelity(pixels_per_element=1, increments=2),
    )
    *_, state = tribo.simulate(scene, normal_load=100e3, velocity=1.0)
    assert state.pressure.max() == pytest.approx(770.6e6, rel=1e-3)
    return scene, state


def test_the_flash_temperature_is_the_exact_one(contact):
    _, state = contact
    # 0.05 % from the finest grids, 0.05 % from the staircase of the contact's edge
    assert FRICTION * state.heat.max_rise == pytest.approx(150.33, rel=1e-3)


def test_a_hot_wheel_on_a_cold_rail_has_the_temperature_of_both(contact):
    scene, state = contact
    wheel, rail = 150.0, 0.0
    bodies = (
        tribo.thermal.ConductingHalfSpace(scene.grid, STEEL, velocity, state.time)
        for velocity in scene.velocities_at(1.0)
    )
    flux = FRICTION * 1.0 * state.pressure
    split = tribo.thermal.partition_heat(*bodies, flux, flux > 0, bulk_difference=rail - wheel)
    # the jump of bulk temperatures at the leading edge is resolved by one element
    assert wheel + split.rise.max() == pytest.approx(225.3, rel=4e-3)
