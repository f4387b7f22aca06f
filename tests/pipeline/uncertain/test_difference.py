"""Two oils on one steel, on a rise that is known in closed form."""

import dataclasses
import math

import numpy as np
import pytest

import pipeline
from pipeline.uncertain.posterior import contrasts
from tests.helpers.samples import CRITICAL, EXPONENT, LENGTH, LOADS, critical_velocity, ensemble

WIDE = dataclasses.replace(CRITICAL, parameters=(418.15, 20.0))
LONG = dataclasses.replace(LENGTH, parameters=(1e-6, 9e-6))


def of_an_oil(kelvins):
    truth = np.array([[kelvins, 1.2e-15, 0.1, 6e-6]])
    tests = [
        {"normal_load": load, "velocity": float(critical_velocity(truth, load)[0]), "friction": 0.1}
        for load in LOADS.tolist()
    ]
    return ensemble((WIDE, LONG), 16, tests=tests)


def test_two_oils_differ_by_less_than_either_is_known():
    oils = of_an_oil(413.15), of_an_oil(425.15)
    kelvins, velocity = contrasts(pipeline.posterior(oils, 0.02))
    alone = [next(pipeline.posterior(oil, 0.02).summary())["posterior"]["sd"] for oil in oils]
    assert kelvins.mean == pytest.approx(12.0, abs=1.5)
    assert kelvins.sd < 0.75 * math.hypot(*alone)
    assert kelvins.probability > 0.99
    expected = math.log((425.15 - 298.15) / (413.15 - 298.15)) / EXPONENT
    assert velocity.mean == pytest.approx(expected, abs=0.02)
    assert list(contrasts(pipeline.posterior(oils[0]))) == []
