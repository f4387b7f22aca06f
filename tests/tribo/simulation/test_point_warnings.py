"""Warnings that a point carries (tribo/simulation/point_warnings.py)."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import STEEL, last, small_scene
from tribo import Ball, Grid, Motion, WarningKind, Wear, warnings
from tribo.simulation import start

BALL = Ball(8e-3, STEEL)


def texts(scene, state, kind):
    """Texts of the warnings of one kind on a state."""
    return [warning.text for warning in warnings(scene, state) if warning.kind == kind]


def assert_told(words, scene, state, kind):
    """Assert that a state has one warning of a kind, with these words; none if they are empty."""
    messages = texts(scene, state, kind)
    assert len(messages) == bool(words)
    assert not words or words in messages[0]


def touching(scene, places):
    """State of a scene with contact at some elements, without a temperature."""
    state = start(scene)
    pressure = np.zeros_like(state.pressure)
    pressure[places] = 1e9
    return replace(state, pressure=pressure, normal_load=100.0, time=1.0, index=5)


@pytest.mark.parametrize(
    ("place", "named"),
    [((-1, 5), "x edge"), ((5, 0), "y edge"), ((0, 0), "x edge and y edge"), ((-2, -2), None)],
)
def test_each_free_edge_is_looked_at(place, named):
    scene = replace(small_scene(periodic=(False, False)), pin=BALL)
    edges = [
        warning for warning in warnings(scene, touching(scene, place)) if "edge" in warning.text
    ]
    assert len(edges) == bool(named)
    assert not named or f"reaches the {named} of the window at 100 N" in edges[0].text


def scene_of(**choices):
    return replace(small_scene(**choices), pixels=Grid((96, 64), (4e-6, 4e-6)))


ALL_FREE = Grid((96, 64), (4e-6, 4e-6), periodic=(False, False))
ENOUGH = {
    "elements of 2 × 2 pixels": (scene_of(pixels_per_element=2), 400),
    "elements of 2 × 2 pixels by the rule": (
        scene_of(pixels_per_element=2, fewest_elements=1), 100,
    ),
    "pixels": (scene_of(), 200),
    "rows that nothing divides": (small_scene(roughness=False, pixels_per_element=2), 20),
    "pixels of a ball that the roughness passes": (
        replace(small_scene(), pin=BALL, pixels=ALL_FREE), 1000,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ENOUGH)
def test_from_so_many_elements_in_contact_on_there_are_enough(name):
    scene, count = ENOUGH[name]
    for nodes, words in ((count - 1, f"only {count - 1} elements"), (count, None)):
        state = touching(scene, np.unravel_index(np.arange(nodes), scene.grid.shape))
        assert_told(words, scene, state, WarningKind.FEW_NODES)


@pytest.mark.parametrize(
    ("pin", "places", "words"),
    [
        (BALL, np.s_[10:21, 1:15], "11 elements wide"),
        (BALL, np.s_[10:22, 2:14], None),
        (None, np.s_[10:15], "5 elements wide"),
        (None, np.s_[10:16], None),
    ],
)
def test_a_contact_of_few_elements_across_warns_in_every_fidelity(pin, places, words):
    scene = small_scene(periodic=(False, not pin))
    scene = replace(scene, pin=pin or scene.pin)
    assert_told(words, scene, touching(scene, places), WarningKind.COARSE_PIXELS)
    coarser = replace(scene, fidelity=replace(scene.fidelity, pixels_per_element=2))
    small = texts(coarser, touching(coarser, np.s_[4:7, 3:6]), WarningKind.COARSE_PIXELS)
    assert "use smaller elements" in small[0]


@pytest.mark.parametrize(
    ("length", "words"), [(15e-6, "1.9 pixels along x and 1.9 pixels along y"), (16e-6, None)]
)
def test_a_roughness_that_the_pixels_do_not_resolve_warns(length, words):
    scene = small_scene()
    scene = replace(scene, roughness=replace(scene.roughness, correlation_length=(length, length)))
    assert_told(words, scene, touching(scene, np.s_[5:40]), WarningKind.COARSE_PIXELS)


@pytest.mark.parametrize(
    ("radius", "depth", "words"),
    [
        (2e-3, 0.0, None),
        (0.46e-3, 0.0, "0.28 mm wide"),  # 35 rows of 8 µm are 0.61 of the radius
        (0.47e-3, 0.0, None),
        (2e-3, 0.091e-3, "worn 0.091 mm deep"),
        (2e-3, 0.089e-3, None),
    ],
)
def test_a_contact_beyond_the_pin_s_shape_warns(radius, depth, words):
    scene = small_scene()
    scene = replace(scene, pin=replace(scene.pin, radius=radius))
    state = touching(scene, np.s_[5:40])
    state = replace(state, wear_depth=np.full_like(state.wear_depth, depth))
    assert_told(words, scene, state, WarningKind.BEYOND_SHAPE)


@pytest.mark.parametrize(
    ("motion", "velocity", "words"),
    [
        (Motion(slide_roll_ratio=1.9999), 1.0, "turns 0.00"),
        (Motion(slide_roll_ratio=1.0), 1.0, None),
        (Motion(slide_roll_ratio=2.0), 1.0, None),  # the pin is at rest at every velocity
        (None, 1.0, None),
    ],
)
def test_a_pin_that_hardly_turns_warns(motion, velocity, words):
    scene = replace(small_scene(), motion=motion)
    state = replace(touching(scene, np.s_[5:40]), sliding_distance=velocity, time=1.0)
    assert_told(words, scene, state, WarningKind.FEW_TURNS)
    assert not texts(replace(scene, wear=None), state, WarningKind.FEW_TURNS)


@pytest.mark.parametrize(
    ("changes", "velocity", "words"),
    [
        ({}, 0.05, None),  # 0.9 % too warm
        ({}, 0.02, "by about 1.2 %"),
        ({}, 1.0, None),  # 0.3 % too warm
        ({"heat_model": "history"}, 0.02, None),
    ],
)
def test_the_present_heat_warns_where_a_contact_has_grown_slowly(changes, velocity, words):
    scene = replace(small_scene(**changes), pixels=Grid((96, 64), (4e-6, 4e-6)))
    assert_told(words, scene, last(scene, 600.0, velocity), WarningKind.PRESENT_HEAT)


def test_a_ball_worn_at_speed_whose_rise_hardly_grows_with_the_velocity_warns():
    grid = Grid((32, 32), (25e-6, 25e-6), (False, False))
    worn = replace(small_scene(), pin=BALL, roughness=None, pixels=grid, wear=Wear(3e-15))
    assert_told("--accuracy", worn, last(worn, 10.0, 20.0), WarningKind.SLOW_RISE)
    assert_told(None, worn, last(worn, 10.0, 1.0), WarningKind.SLOW_RISE)
    unworn = replace(worn, wear=None)
    assert_told(None, unworn, last(unworn, 10.0, 20.0), WarningKind.SLOW_RISE)


@pytest.mark.parametrize(("turns", "words"), [(9.9, "turns 9.9 times"), (10.1, None)])
def test_from_ten_turns_on_a_pin_wears_evenly(turns, words):
    scene = replace(small_scene(), motion=Motion(slide_roll_ratio=1.0))
    time = turns * 2 * np.pi * scene.pin.radius / 0.5  # the pin rolls at half the sliding velocity
    state = replace(touching(scene, np.s_[5:40]), sliding_distance=time, time=time)
    assert_told(words, scene, state, WarningKind.FEW_TURNS)


def test_kinds_keep_the_bits_that_stores_have():
    assert {kind.label: kind.value for kind in WarningKind} == {
        "unstable wear": 1,
        "contact at edge": 2,
        "few nodes": 4,
        "few steps": 8,
        "present heat": 16,
        "coarse pixels": 32,
        "beyond shape": 64,
        "few turns": 128,
        "slow rise": 256,
        "molten": 512,
    }


@pytest.mark.parametrize(
    ("as_published", "steps", "words"),
    [
        (True, 1, "reached in a single step"),
        (True, 2, "reached in 2 steps"),
        (True, 3, None),
        (False, 1, "reached in a single step"),
        (False, 2, None),
    ],
)
def test_wear_in_few_steps_warns(as_published, steps, words):
    scene = small_scene(as_published=as_published)
    state = replace(touching(scene, np.s_[5:40]), index=steps)
    assert_told(words, scene, state, WarningKind.FEW_STEPS)
    for unworn in (replace(scene, wear=None), replace(scene, wear=Wear(0.0))):
        assert not texts(unworn, state, WarningKind.FEW_STEPS)


@pytest.mark.parametrize("imprint", [0.0, 0.1])
def test_explicit_wear_is_unstable_whatever_imprint_a_step_may_leave(imprint):
    scene = small_scene("local", as_published=True, increments=30, imprint=imprint)
    state = last(scene, 400.0, 1.25)
    assert_told("the explicit wear scheme is unstable", scene, state, WarningKind.UNSTABLE_WEAR)
