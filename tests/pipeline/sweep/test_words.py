"""What is said of points, inputs, surfaces and durations, in the words that users read."""

from dataclasses import replace

import pytest

import tribo
from pipeline.answers.discretization_error import has_unknown_error, preset_bound, velocity_error
from pipeline.sweep.sweep import Point
from tests.helpers import synthetic
from tribo import PRESETS


@pytest.mark.parametrize(
    ("preset", "changes", "error"),
    [
        ("standard", {}, 0.011),
        ("fine", {}, 0.0055),
        ("standard", {"increments": 9}, None),
        ("standard", {"contact_tolerance": 1e-3}, None),
        ("standard", {"pixels_per_element": 1}, None),
        ("standard", {"partition": "uniform"}, None),
        ("standard", {"fewest_elements": 0}, None),
        # How heat acts is no numerical choice.
        ("standard", {"heat_model": "history"}, 0.011),
    ],
)
def test_only_a_preset_has_a_known_error(preset, changes, error):
    own = synthetic.scene(preset=None, fidelity=replace(PRESETS[preset], **changes))
    assert velocity_error(own) == error
    assert has_unknown_error(own) == (error is None)


@pytest.mark.parametrize(
    ("share", "error"),
    [
        (0.05, 0.011),
        (0.2, 0.011),
        (0.01, 0.05),
        (0.0, 0.05),
        (0.3, 0.03),
    ],
)
def test_a_preset_promises_less_where_the_highest_or_most_of_the_contact_decides(share, error):
    assert preset_bound("standard", share) == error
    assert preset_bound("fine", share) == 0.0055
    assert preset_bound("own", share) is None


def test_a_preset_whose_elements_do_not_tile_the_window_keeps_its_error():
    odd = tribo.Grid((33, 17), (13e-6, 15e-6))
    fidelity = replace(PRESETS["standard"], pixels_per_element=1)
    assert velocity_error(synthetic.scene(preset=None, pixels=odd, fidelity=fidelity)) == 0.011


def test_a_point_is_said_with_its_place_and_variant():
    point = Point(600.0, 1.5, (("pin.radius", 0.002), ("realization", 3)))
    assert str(point) == "600 N, 1.5 m/s, pin.radius 0.002, surface 3"
