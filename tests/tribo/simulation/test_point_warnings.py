"""Warnings that a point carries (tribo/simulation/point_warnings.py)."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.kept import assert_as_kept
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


def touching(scene, elements):
    """State of a scene with contact at some elements, without a temperature."""
    state = start(scene)
    pressure = np.zeros_like(state.pressure)
    pressure[elements] = 1e9
    return replace(state, pressure=pressure, normal_load=100.0, time=1.0, index=5)


@pytest.mark.parametrize(
    ("elements", "edge"),
    [((-1, 5), "x edge"), ((5, 0), "y edge"), ((0, 0), "x edge and y edge"), ((-2, -2), None)],
)
def test_each_free_edge_is_looked_at(elements, edge):
    scene = replace(small_scene(periodic=(False, False)), pin=BALL)
    edges = [
        warning for warning in warnings(scene, touching(scene, elements)) if "edge" in warning.text
    ]
    assert len(edges) == bool(edge)
    assert not edge or f"reaches the {edge} of the window at 100 N" in edges[0].text


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


ELASTIC = replace(STEEL, hardness=np.inf)
SMALL, BALL_SCENE = small_scene(), replace(small_scene(periodic=(False, False)), pin=BALL)
FREE_BALL = replace(
    SMALL, pin=BALL, roughness=None, wear=Wear(3e-15),
    pixels=Grid((32, 32), (25e-6, 25e-6), (False, False)),
)  # fmt: skip
ROLLING_TURN = 2 * np.pi * SMALL.pin.radius / 0.5  # [s], rolling at half of 1 m/s of sliding


def correlated(length):
    return replace(SMALL, roughness=replace(SMALL.roughness, correlation_length=(length,) * 2))


def pin_of(radius):
    return replace(SMALL, pin=replace(SMALL.pin, radius=radius))


def rolling(slide_roll_ratio):
    return replace(SMALL, motion=Motion(slide_roll_ratio=slide_roll_ratio))


def wide(scene, **changes):
    """State of a scene with a contact of 35 rows, 0.28 mm wide."""
    return replace(touching(scene, np.s_[5:40]), **changes)


def worn(scene, depth):
    state = wide(scene)
    return replace(state, wear_depth=np.full_like(state.wear_depth, depth))


def slid(scene, seconds=1.0):
    return wide(scene, sliding_distance=seconds, time=seconds)


def reached(scene, steps):
    return wide(scene, index=steps)


def at(load, velocity):
    return lambda scene: last(scene, load, velocity)


def to_edge(state):
    """The state, if its contact also reached the edge of the window across sliding."""
    pressure = state.pressure.copy()
    pressure[0] = pressure.max()
    return replace(state, pressure=pressure)


COARSE, SHAPE, TURNS = (
    WarningKind.COARSE_PIXELS, WarningKind.BEYOND_SHAPE, WarningKind.FEW_TURNS,
)  # fmt: skip
STEPS, HEAT, SLOW = WarningKind.FEW_STEPS, WarningKind.PRESENT_HEAT, WarningKind.SLOW_RISE
ROWS = [  # kind, scene, function of the scene that makes a state, words of the warning or None
    (COARSE, BALL_SCENE, lambda s: touching(s, np.s_[10:21, 1:15]), "11 elements wide"),
    (COARSE, BALL_SCENE, lambda s: touching(s, np.s_[10:22, 2:14]), None),
    (COARSE, SMALL, lambda s: touching(s, np.s_[10:15]), "5 elements wide"),
    (COARSE, SMALL, lambda s: touching(s, np.s_[10:16]), None),
    (COARSE, small_scene(roughness=False, pixels_per_element=2),
     lambda s: touching(s, np.s_[4:7]), "use smaller elements"),
    (COARSE, correlated(15e-6), wide, "1.9 pixels along x and 1.9 pixels along y"),
    (COARSE, correlated(16e-6), wide, None),
    (SHAPE, pin_of(2e-3), wide, None),
    (SHAPE, pin_of(0.46e-3), wide, "0.28 mm wide"),  # 0.61 of the radius
    (SHAPE, pin_of(0.47e-3), wide, None),
    (SHAPE, SMALL, lambda s: worn(s, 0.091e-3), "worn 0.091 mm deep"),
    (SHAPE, SMALL, lambda s: worn(s, 0.089e-3), None),
    (TURNS, rolling(1.9999), slid, "only 0.002 revolutions"),
    (TURNS, replace(rolling(1.9999), wear=None), slid, None),
    (TURNS, rolling(2.0), slid, None),  # the pin is at rest at every velocity
    (TURNS, SMALL, slid, None),
    (TURNS, rolling(1.0), lambda s: slid(s, 9.9 * ROLLING_TURN), "only 9.9 revolutions"),
    (TURNS, rolling(1.0), lambda s: slid(s, 10.1 * ROLLING_TURN), None),
    (HEAT, scene_of(), at(600.0, 0.05), None),  # 0.9 % too warm
    (HEAT, scene_of(), at(600.0, 0.02), "by about 1.2 %"),
    (SLOW, FREE_BALL, at(10.0, 20.0), "--accuracy"),
    (SLOW, FREE_BALL, at(10.0, 1.0), None),
    (SLOW, replace(FREE_BALL, wear=None), at(10.0, 20.0), None),
    (SLOW, FREE_BALL, lambda s: to_edge(at(10.0, 20.0)(s)), None),
    (STEPS, SMALL, lambda s: reached(s, 1), "reached in a single step"),
    (STEPS, SMALL, lambda s: reached(s, 2), None),
    (STEPS, replace(SMALL, wear=None), lambda s: reached(s, 1), None),
    (STEPS, replace(SMALL, wear=Wear(0.0)), lambda s: reached(s, 1), None),
    (COARSE, replace(correlated(1e-6), pin=replace(SMALL.pin, material=ELASTIC), disk=ELASTIC),
     wide, "0.12 pixels along x"),  # no elements are smaller than pixels
    (SLOW, replace(FREE_BALL, motion=Motion(slide_roll_ratio=2.0)), at(10.0, 20.0), None),
]  # fmt: skip


def test_a_point_warns_where_it_should_and_nowhere_else_in_words_that_are_kept():
    texts = {}
    for number, (kind, scene, build_state, words) in enumerate(ROWS):
        assert_told(words, scene, state := build_state(scene), kind)
        lines = [warning.text for warning in warnings(scene, state)]
        texts[f"{number} {kind.label}"] = "\n".join(lines)
    assert_as_kept("point_warnings", texts)


def test_kinds_keep_the_bits_that_stores_have():
    assert {kind.label: kind.value for kind in WarningKind} == {
        "unusual value": 1,
        "contact at edge": 2,
        "few nodes": 4,
        "few steps": 8,
        "present heat": 16,
        "coarse pixels": 32,
        "beyond shape": 64,
        "few turns": 128,
        "slow rise": 256,
        "hot ends": 512,
    }
