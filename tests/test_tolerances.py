"""Tests of small SI numbers can fail (tests/conftest.py)."""

import numpy as np
import pytest


@pytest.mark.parametrize("kind", [float, lambda x: np.array([x]), lambda x: {"rate": x}])
def test_numbers_far_below_one_are_told_apart(kind):
    assert kind(1e-15 * (1 + 1e-7)) == pytest.approx(kind(1e-15))
    assert kind(1e-15) != pytest.approx(kind(1.001e-15))
