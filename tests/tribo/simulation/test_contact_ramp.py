"""The layers of a point: contact and wear, heat, conditions (tribo/simulation/contact_ramp.py)."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import small_scene
from tribo import Ball, Motion, Ramp, Wear, simulate
from tribo.numerics import Grid
from tribo.simulation import contacts, heated, inseparable


def ball():
    scene = small_scene("swept")
    pixels = Grid(scene.pixels.shape, scene.pixels.spacing, periodic=(False, False))
    return replace(scene, pin=Ball(8e-3, scene.disk), pixels=pixels)


FAMILY = {
    "local": small_scene("local"),
    "coarse history": small_scene("swept", history_coarsening=2),
    "narrow summits": small_scene("swept", pixels_per_element=4, elements_per_summit=2.0),
    "cut steps": small_scene("local", imprint=0.5),
    "held": replace(small_scene("swept"), loading=Ramp(150.0, 750.0, hold=2.0)),
    "ball": ball(),
    "twin disc": replace(small_scene("swept"), motion=Motion(slide_roll_ratio=0.5)),
    "unequal bulks": replace(small_scene("swept"), unequal_bulks=True),
}


@pytest.mark.parametrize("name", FAMILY)
def test_one_wear_number_has_one_contact_and_heat_on_it_is_that_of_the_simulation(name):
    scene = replace(FAMILY[name], wear=Wear(2e-14, FAMILY[name].wear.pattern))
    other = replace(scene, wear=Wear(1e-14, scene.wear.pattern))
    assert inseparable(scene, (0.5, 1.0)) is None
    shared = [heated(other, state, 1.0) for state in contacts(scene, 300.0, 0.5)]
    direct = list(simulate(other, 300.0, 1.0))
    assert len(shared) == len(direct)
    for one, two in zip(shared, direct, strict=True):
        assert np.array_equal(one.pressure, two.pressure)
        assert np.array_equal(one.wear_depth, two.wear_depth)
        assert one.sliding_distance == pytest.approx(two.sliding_distance)
        assert (one.heat is None) == (two.heat is None)
        if two.heat:
            assert np.array_equal(one.heat.rise_quantile, two.heat.rise_quantile)
            assert np.array_equal(one.heat.rise, two.heat.rise)
            assert one.heat.pin_heat_share == two.heat.pin_heat_share
    assert shared[-1].heat


def test_heat_of_all_steps_belongs_to_one_velocity():
    scene = small_scene("swept", heat_model="history")
    assert "history" in inseparable(scene, (0.5, 1.0))
    assert inseparable(replace(scene, friction_heat=False), (0.5, 1.0)) is None


def test_a_pin_that_stands_still_at_one_velocity_wears_otherwise_there():
    scene = replace(small_scene("swept"), motion=Motion(entrainment_velocity=1.0))
    assert inseparable(scene, (0.5, 1.0)) is None
    assert "stands still" in inseparable(scene, (0.5, 1.0, 2.0))
    assert inseparable(replace(scene, wear=None), (0.5, 1.0, 2.0)) is None
