"""The short implicit end of a step in which much has come into contact."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import small_scene
from tribo import Grid, Motion, Wear, simulate
from tribo.simulation import RampCache
from tribo.simulation.requested_state import end_implicitly

VELOCITY = 2.0


def worn_scene(specific_wear_rate=2e-14, **changes):
    """Scene of a smooth pin that wears so fast that rows of elements touch one by one."""
    choices = {"increments": 10} | changes
    return replace(
        small_scene(roughness=False, **choices),
        pixels=Grid((128, 2), (8e-6, 64e-6), (False, True)),
        wear=Wear(specific_wear_rate, "swept"),
    )


def last(scene, load):
    *_, state = simulate(scene, load, VELOCITY)
    return state


def is_repeated(scene, load):
    """True if the last step to a load is repeated with an implicit end."""
    *_, load_step = scene.load_steps(load)
    *_, before, after = simulate(scene, load, VELOCITY)
    return end_implicitly(scene, before, after, load_step, VELOCITY) is not after


def test_the_rise_under_heavy_wear_is_known_in_ten_steps():
    """Without a short last step the quantile is 3 % too high."""
    few, many = (last(worn_scene(increments=n), 600.0).heat for n in (10, 200))
    assert few.mean_rise == pytest.approx(many.mean_rise, rel=0.005)
    assert few.rise_quantile[-3] == pytest.approx(many.rise_quantile[-3], rel=0.01)
    assert is_repeated(worn_scene(), 600.0)
    assert not is_repeated(worn_scene(1e-16), 600.0)  # hardly any element is new in contact


def test_of_a_pin_that_rolls_ten_steps_know_the_rise_without_it():
    rolling = replace(worn_scene(), motion=Motion(slide_roll_ratio=1.0))
    rolling = replace(rolling, wear=Wear(2e-14 * rolling.windows_worn(VELOCITY), "swept"))
    few, many = (
        last(replace(rolling, fidelity=replace(rolling.fidelity, increments=n)), 300.0)
        for n in (10, 100)
    )
    assert not is_repeated(rolling, 300.0)
    assert few.heat.rise_quantile[-3] == pytest.approx(many.heat.rise_quantile[-3], rel=1e-3)


def test_higher_loads_do_not_pass_through_it():
    scene = worn_scene()
    *_, load_step = scene.load_steps(375.0)
    assert load_step.on_trunk  # the fifth of the ten load steps
    *passed, direct = simulate(scene, 600.0, VELOCITY)
    assert passed[load_step.index - 1].normal_load == 375.0
    assert not np.array_equal(last(scene, 375.0).pressure, passed[load_step.index - 1].pressure)
    ramp_cache = RampCache()
    list(simulate(scene, 375.0, VELOCITY, ramp_cache))
    *_, gone_on = simulate(scene, 600.0, VELOCITY, ramp_cache)
    assert np.array_equal(gone_on.heat.rise, direct.heat.rise)
