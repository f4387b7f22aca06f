"""Measures that are kept of a state (tribo/simulation/step_measures.py)."""

import numpy as np

from tests.helpers.scenes import small_scene
from tribo import measures, simulate


def test_measures_without_temperature_are_nan():
    scene = small_scene()
    first = next(iter(simulate(scene, 300.0, 1.25)))
    assert first.heat is None
    assert np.isnan(measures(scene, first)["max_rise"])
