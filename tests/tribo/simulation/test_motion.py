"""Both bodies moving through the contact (tribo/simulation/motion.py)."""

import math
from dataclasses import replace

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL, small_scene
from tribo.analytic import hertz_line_half_width, rolling_sliding_rise

LOAD, RADIUS, LENGTH = 750.0, 2e-3, 3.4e-3
HALF_WIDTH = hertz_line_half_width(LOAD / LENGTH, RADIUS, tribo.contact_modulus(STEEL, STEEL))
RATIO = tribo.Motion(slide_roll_ratio=0.5)


def twin_disc(motion=RATIO, elements=300, **changes):
    """Scene of a smooth line contact, whose elements are rows, infinitely long for heat."""
    fidelity = tribo.Fidelity(pixels_per_element=1, increments=1, contact_tolerance=1e-6)
    scene = tribo.Scene(
        pin=tribo.Cylinder(RADIUS, LENGTH, replace(STEEL, hardness=math.inf)),
        disk=replace(STEEL, hardness=math.inf),
        pixels=tribo.Grid((elements, 1), (3 * HALF_WIDTH / elements, 456e-6)),
        loading=tribo.Ramp(150.0, 750.0),
        motion=motion,
        fidelity=fidelity,
    )
    return replace(scene, **changes)


def end(scene, velocity, load=LOAD):
    *_, state = tribo.simulate(scene, load, velocity)
    return state


@pytest.mark.parametrize(
    ("motion", "sliding", "pin", "disk"),
    [
        (tribo.Motion(slide_roll_ratio=-0.5), 1.0, 2.5, 1.5),
        (tribo.Motion(slide_roll_ratio=0.5), -1.0, -1.5, -2.5),
        (tribo.Motion(slide_roll_ratio=2.0), 1.25, 0.0, 1.25),
        (tribo.Motion(slide_roll_ratio=4.0), 2.0, -0.5, 1.5),
    ],
)
def test_the_velocities_have_the_sliding_velocity_as_difference(motion, sliding, pin, disk):
    velocities = motion.velocities(sliding)
    assert velocities == pytest.approx((pin, disk), abs=1e-15)
    assert (velocities.pin == 0) == (pin == 0)


@pytest.mark.parametrize("ratio", [0.1, -0.5])
def test_the_highest_rise_of_a_twin_disc_is_blok_s(ratio):
    scene = twin_disc(tribo.Motion(slide_roll_ratio=ratio))
    velocities = scene.velocities_at(40.0)
    width, load = 2 * HALF_WIDTH, LOAD / LENGTH
    expected = rolling_sliding_rise(1.0, load, width, velocities, STEEL.thermal_effusivity)
    assert end(scene, 40.0).heat.max_rise == pytest.approx(expected, rel=2e-4)


def test_a_slide_roll_ratio_of_2_is_a_pin_at_rest_bit_for_bit():
    scene = small_scene()
    for velocity in (1.25, -1.25):
        resting = end(scene, velocity)
        moving = end(replace(scene, motion=tribo.Motion(slide_roll_ratio=2.0)), velocity)
        assert np.array_equal(moving.heat.rise, resting.heat.rise)
        assert np.array_equal(moving.wear_depth, resting.wear_depth)


@pytest.mark.parametrize(("preset", "pattern"), [("standard", "local"), ("standard", "swept")])
def test_the_worn_volume_is_that_of_the_work_on_the_whole_track(preset, pattern):
    fidelity = replace(tribo.PRESETS[preset], increments=4)
    scene = replace(small_scene(pattern), motion=RATIO, fidelity=fidelity)
    scene = replace(scene, pixels=tribo.Grid((96, 64), (4e-6, 4e-6)))
    values = tribo.measures(scene, state := end(scene, 1.25))
    assert values["wear_volume"] == pytest.approx(1.2e-15 * 1.25 * 5.0 * LOAD / 2, rel=1e-10)
    # The wear is spread evenly over the pin's track, which is 33 windows long.
    share = 96 * 4e-6 / (2 * math.pi * RADIUS)
    assert state.wear_depth.mean() == pytest.approx(
        share * values["wear_volume"] / (96 * 4e-6 * LENGTH), rel=1e-10
    )
    assert (state.wear_depth == state.wear_depth[0]).all()


def test_a_cylinder_that_rolls_stays_round():
    scene = small_scene(roughness=False)
    unworn = tribo.measures(scene, end(replace(scene, wear=None), 1.25))
    rolling = tribo.measures(scene, end(replace(scene, motion=RATIO), 1.25))
    assert rolling["contact_width"] == unworn["contact_width"]
    assert rolling["max_pressure"] == pytest.approx(unworn["max_pressure"], rel=1e-5)
    assert tribo.measures(scene, end(scene, 1.25))["max_pressure"] < 0.8 * unworn["max_pressure"]


def test_a_ball_that_rolls_wears_a_groove_around_itself():
    """The implicit step solves for the depth worn by its own pressure, with any step size."""
    scene = tribo.Scene(
        pin=tribo.Ball(5e-3, STEEL),
        disk=STEEL,
        pixels=tribo.Grid((40, 48), (12e-6, 12e-6), periodic=(False, False)),
        loading=tribo.Ramp(150.0, 150.0),
        wear=tribo.Wear(1e-14, "local"),
        motion=tribo.Motion(slide_roll_ratio=0.5, pin_track_length=2e-3),
        fidelity=tribo.Fidelity(pixels_per_element=1, increments=20, contact_tolerance=1e-6),
    )
    coarse = end(scene, 1.0, 150.0)
    worn = coarse.wear_depth[0]
    assert worn[24] > 20 * worn[4]
    steps = replace(scene.fidelity, increments=80)
    fine = end(replace(scene, fidelity=steps), 1.0, 150.0)
    assert np.allclose(worn, fine.wear_depth[0], atol=0.05 * worn.max())
    profile = coarse.pressure.sum(axis=0)  # wear has flattened the ball along y
    unworn = end(replace(scene, wear=None), 1.0, 150.0).pressure.sum(axis=0)
    assert profile.max() < 0.8 * unworn.max()
