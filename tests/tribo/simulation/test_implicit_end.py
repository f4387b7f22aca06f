"""The short implicit end of a step in which much has come into contact."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import small_scene
from tribo import PRESETS, Grid, MeasuredLoad, Motion, SelfAffineRoughness, Wear, simulate
from tribo.simulation import implicit_end, start

VELOCITY, LOADS = 2.0, (300.0, 500.0, 600.0)
# The shipped scene on fewer pixels, whose contact grows at a rim of single summits.
ROUGH = replace(
    small_scene(),
    pixels=Grid((480, 240), (0.816e-6, 0.95e-6)),
    roughness=SelfAffineRoughness(0.27e-6, 0.8, (4e-6, 4e-6), seed=0),
)


def worn_scene(specific_wear_rate=2e-14, **changes):
    """A smooth pin that wears so fast that rows of elements come into contact one by one."""
    choices = {"wear_scheme": "sdirk2", "increments": 10} | changes
    return replace(
        small_scene(roughness=False, **choices),
        pixels=Grid((128, 2), (8e-6, 64e-6), (False, True)),
        wear=Wear(specific_wear_rate, "swept"),
    )


def last(scene, load):
    *_, state = simulate(scene, load, VELOCITY)
    return state


@functools.cache
def in_many_steps(load):
    return last(worn_scene(increments=400), load).heat


def test_the_rise_under_heavy_wear_is_known_in_ten_steps():
    for load in LOADS:
        few, many = last(worn_scene(), load).heat, in_many_steps(load)
        assert few.mean_rise == pytest.approx(many.mean_rise, rel=0.02), load
        assert few.rise_quantile[-3] == pytest.approx(many.rise_quantile[-3], rel=0.02), load


def test_without_the_short_end_it_would_be_off_by_several_percent(monkeypatch):
    exact = [in_many_steps(load).rise_quantile[-3] for load in LOADS]
    monkeypatch.setattr(implicit_end, "_NEW", 1.0)
    rises = [last(worn_scene(), load).heat.rise_quantile[-3] for load in LOADS]
    assert np.max(np.abs(np.divide(rises, exact) - 1)) > 0.05


def test_a_pin_at_rest_is_one_whether_its_scene_has_a_motion_or_not():
    at_rest = replace(worn_scene(), motion=Motion(slide_roll_ratio=2.0))
    state, expected = (last(scene, 300.0) for scene in (at_rest, worn_scene()))
    assert state.history is not None
    assert np.array_equal(state.heat.rise, expected.heat.rise)


def test_of_a_pin_that_rolls_ten_steps_know_the_rise_without_it():
    rolling = replace(worn_scene(), motion=Motion(slide_roll_ratio=1.0))
    rolling = replace(rolling, wear=Wear(2e-14 * rolling.windows_worn(VELOCITY), "swept"))
    few, many = (
        last(replace(rolling, fidelity=replace(rolling.fidelity, increments=n)), 300.0)
        for n in (10, 100)
    )
    assert few.history is None
    assert few.heat.rise_quantile[-3] == pytest.approx(many.heat.rise_quantile[-3], rel=1e-3)


@pytest.mark.parametrize("heat_model", ["elapsed", "history"])
def test_higher_loads_pass_through_it_only_with_the_heat_of_all_steps(heat_model):
    scene = worn_scene(heat_model=heat_model)
    passed = last(scene, 375.0)  # the fifth of the ten stations
    assert passed.on_trunk
    assert (passed.history is None) == (heat_model == "history")
    if passed.history:
        assert not np.array_equal(passed.pressure, passed.history.pressure)
    *_, alone = simulate(scene, 600.0, VELOCITY)
    *_, gone_on = simulate(scene, 600.0, VELOCITY, trunk=passed)
    assert np.array_equal(gone_on.heat.rise, alone.heat.rise)


@pytest.mark.parametrize("pattern", ["swept", "local"])
def test_the_worn_volume_stays_that_of_the_load_on_its_way(pattern):
    # A record that rises unevenly: between stations its mean load is not that of both ends.
    record = MeasuredLoad(np.array([0.0, 1.0, 1.1, 4.0]), np.array([0.0, 600.0, 300.0, 750.0]))
    scene = replace(worn_scene(), loading=record, wear=Wear(1e-14, pattern))
    state = last(scene, 750.0)
    assert state.history is not None
    *_, station = scene.stations(750.0)
    worn = state.wear_depth.mean() * scene.nominal_area
    assert worn == pytest.approx(1e-14 * VELOCITY * station.impulse, rel=1e-10)


@pytest.mark.parametrize(
    "scene",
    [
        worn_scene(wear_scheme="implicit"),
        worn_scene(specific_wear_rate=0.0, increments=100),
        small_scene(wear_scheme="sdirk2", increments=100),
        replace(ROUGH, fidelity=PRESETS["draft"]),
    ],
    ids=["implicit", "no wear", "rough", "rough, few steps"],
)
def test_it_is_not_taken_where_it_is_not_needed(scene, monkeypatch):
    def refused(*_, **__):
        raise AssertionError("a short end")

    monkeypatch.setattr(implicit_end, "advance", refused)
    assert last(scene, 750.0).normal_load == 750.0
    with pytest.raises(AssertionError, match="a short end"):
        last(worn_scene(), 300.0)


def touching(scene, pressure):
    """A state that touches with some pressures, of 100 elements along x in their first row."""
    field = np.zeros(scene.grid.shape)
    field[: len(pressure), 0] = pressure
    return replace(start(scene), pressure=field)


ALL = np.ones(100)


@pytest.mark.parametrize(
    ("before", "after", "taken"),
    [
        (np.r_[ALL[:98]], ALL, True),  # 2 % of the load, at the mean pressure
        (np.r_[ALL[:99], 0.0], np.r_[ALL[:99], 0.98], False),  # 0.98 %
        (np.r_[ALL[:90]], np.r_[ALL[:90], 0.7 * ALL[:10]], False),  # 7 %, as at a rough rim
        (np.r_[ALL[:90]], np.r_[ALL[:90], 0.8 * ALL[:10]], True),
        (ALL, ALL, False),
        (0 * ALL, ALL, True),
    ],
)
@pytest.mark.parametrize("pattern", ["swept", "local"])
def test_it_is_taken_where_more_than_a_hundredth_of_the_load_is_new(before, after, taken, pattern):
    scene = replace(worn_scene(), wear=Wear(2e-14, pattern))
    states = (touching(scene, rows) for rows in (before, after))
    assert implicit_end._comes_into_contact(scene, *states, VELOCITY) == taken
