"""The monotone cubic beside SciPy's (pipeline/analysis/interpolation.py)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from pipeline.analysis.interpolation import crossing, interpolated


@given(seed=st.integers(0, 2**32 - 1), size=st.integers(2, 12), rising=st.booleans())
def test_values_are_those_of_scipy(seed, size, rising):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.05, 2.0, size)) - 3.0  # from below zero, on straight scales
    steps = (
        rng.exponential(size=size) * (rng.random(size) > 0.3) if rising else rng.normal(size=size)
    )
    y = np.cumsum(steps)
    at = np.concatenate([x, rng.uniform(x[0], x[-1], 50)])
    expected = PchipInterpolator(x, y)(at)
    assert interpolated(x, y, at) == pytest.approx(expected, rel=1e-12, abs=1e-13 * (1 + np.ptp(y)))


@given(seed=st.integers(0, 2**32 - 1), size=st.integers(2, 12))
def test_a_crossing_is_where_the_logarithms_of_scipy_reach_the_limit(seed, size):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.05, 2.0, size))
    y = np.exp(np.cumsum(rng.uniform(0.01, 2.0, size)))
    limit = rng.uniform(y[0], y[-1])
    found = crossing(x, y, limit)
    scipys = PchipInterpolator(np.log(x), np.log(y))
    slope = scipys(np.log(found), nu=1)
    assert abs(scipys(np.log(found)) - np.log(limit)) <= 1e-14 * (10 + np.log(limit) + slope)
