"""Two oils on one rig, on a rise that is known in closed form."""

import dataclasses
import math

import numpy as np
import pytest

import pipeline
from pipeline.sweep.measurement import Measurement, own_tests
from pipeline.uncertain.answer_posterior import _describe_contrast
from pipeline.uncertain.posterior import contrasts
from tests.helpers.samples import EXPONENT, LOADS, critical_velocity, ensemble
from tests.helpers.unknowns import CRITICAL, LENGTH

WIDE = dataclasses.replace(CRITICAL, parameters=(418.15, 20.0))
LONG = dataclasses.replace(LENGTH, parameters=(1e-6, 9e-6))


def of_oil(oil, kelvins):
    truth = np.array([[kelvins, 1.2e-15, 0.1, 6e-6]])
    velocities = [float(critical_velocity(truth, load)[0]) for load in LOADS.tolist()]
    return [
        {"normal_load": load, "velocity": velocity, "friction": 0.1, "oil": oil}
        for load, velocity in zip(LOADS.tolist(), velocities, strict=True)
    ]


def test_two_oils_differ_by_less_than_either_is_known():
    both = ensemble((WIDE, LONG), 16, tests=of_oil("A", 413.15) + of_oil("B", 425.15))
    posterior = pipeline.posterior(both, 0.02)
    kelvins, velocity = contrasts(posterior)
    first, _, second = (row["posterior"]["sd"] for row in posterior.summary())
    assert kelvins.oils == ("A", "B")
    assert kelvins.mean == pytest.approx(12.0, abs=1.5)
    assert kelvins.sd < 0.75 * math.hypot(first, second)
    assert kelvins.probability > 0.99
    expected = math.log((425.15 - 298.15) / (413.15 - 298.15)) / EXPONENT
    assert velocity.mean == pytest.approx(expected, abs=0.02)
    assert "B withstands more than A with a probability of 1" in _describe_contrast(kelvins)
    assert posterior.unknown[-1].path == f"{CRITICAL.path} of B"
    assert len(pipeline.plot(posterior).axes) >= 4


def test_the_scene_s_oil_is_that_of_tests_without_one_else_the_first_by_name():
    plain, a, b = (Measurement(400.0, 2.0, oil=oil) for oil in (None, "A", "B"))
    assert own_tests((a, plain, b)) == (plain,)
    assert own_tests((b, a, b)) == (a,)
    assert own_tests(()) == ()
