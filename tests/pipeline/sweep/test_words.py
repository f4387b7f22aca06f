"""What is said of points, inputs, surfaces and durations, in the words that users read."""

from dataclasses import replace

import pytest

from pipeline.sweep.accuracy import has_unknown_error, velocity_error
from pipeline.sweep.model import Point
from tests.helpers import synthetic
from tribo import PRESETS

PIXELS = {"pixels_per_element": 1, "history_coarsening": 1}
EXACT = PIXELS | {"contact_tolerance": 1e-3}


@pytest.mark.parametrize(
    ("preset", "changes", "error"),
    [
        ("draft", {"increments": 6}, 0.05),
        ("draft", {"increments": 3}, None),
        ("draft", {"contact_tolerance": 0.09, "heat_tolerance": 1e-3}, 0.05),
        ("draft", {"contact_tolerance": 0.26}, None),
        ("draft", {"heat_tolerance": 0.011}, None),
        ("draft", {"fewest_elements": 39}, None),
        ("draft", {"elements_per_summit": 0.7}, None),
        ("draft", {"hold_increments": 7}, None),
        ("draft", {"hold_increments": 0}, None),  # 0 means as many as the ramp's 4
        ("draft", {"hold_increments": 0, "increments": 8}, 0.05),
        ("draft", {"imprint": 26.0}, None),
        ("draft", {"imprint": 0.0}, None),  # no step is cut
        ("draft", {"imprint": 0.0, "increments": 25}, 0.05),
        ("draft", PIXELS | {"fewest_elements": 0, "averaging": "mean"}, None),
        ("draft", EXACT | {"fewest_elements": 0, "averaging": "mean"}, 0.05),
        ("draft", {"averaging": "mean"}, None),
        ("draft", {"partition": "uniform"}, None),
        ("draft", {"heat_model": "history", "history_coarsening": 1}, 0.05),
        ("standard", {"history_coarsening": 1, "increments": 100}, 0.015),  # of figures 5 and 8
        ("standard", {"elements_per_summit": 1.6}, 0.05),
        ("fine", {}, 0.005),
        ("fine", {"increments": 15}, 0.015),
        ("reference", {"increments": 50}, 0.005),
    ],
)
def test_choices_that_are_at_least_as_fine_as_a_preset_keep_its_promise(preset, changes, error):
    own = synthetic.scene(preset=None, fidelity=replace(PRESETS[preset], **changes))
    assert velocity_error(own) == error
    assert has_unknown_error(own) == (error is None)


def test_a_point_is_said_with_its_place_and_variant():
    point = Point(600.0, 1.5, (("pin.radius", 0.002), ("realization", 3)))
    assert str(point) == "600 N, 1.5 m/s, pin.radius 0.002, surface 3"
