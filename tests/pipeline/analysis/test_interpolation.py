"""Crossings beside those of SciPy's monotone cubic (pipeline/analysis/interpolation.py)."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from pipeline.analysis.interpolation import crossing


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
