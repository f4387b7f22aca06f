"""Interpolation close to power laws, and crossings (pipeline/analysis/curve.py)."""

import itertools

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

import pipeline
from pipeline.analysis.curve import Curve
from tests.helpers import synthetic
from tests.helpers.answers import crossings


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.integers(2, 12))
def test_a_crossing_is_where_the_logarithms_of_scipy_reach_the_limit(seed, size):
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.05, 2.0, size))
    y = np.exp(np.cumsum(rng.uniform(0.01, 2.0, size)))
    limit = rng.uniform(y[0], y[-1])
    (root,) = crossings(Curve(x, y), limit)
    scipys = PchipInterpolator(np.log(x), np.log(y))
    slope = scipys(np.log(root), nu=1)
    assert abs(scipys(np.log(root)) - np.log(limit)) <= 1e-14 * (10 + np.log(limit) + slope)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.integers(3, 12))
def test_between_crossings_a_curve_stays_on_one_side_of_the_limit(seed, size):
    rng = np.random.default_rng(seed)
    x, y = np.cumsum(rng.uniform(0.05, 2.0, size)), np.exp(rng.uniform(-1.0, 1.0, size))
    places = crossings(Curve(x, y), 1.0)
    ends = [x[0], *places, x[-1]]
    sides = [y[0] > 1]
    for low, high in itertools.pairwise(ends):
        within = Curve(x, y)(np.linspace(low, high, 12)[1:-1]) > 1
        assert within.all() or not within.any()
        sides.append(bool(within[0]))
    assert len(places) == np.count_nonzero(np.diff(sides[1:]))
    np.testing.assert_allclose(Curve(x, y)(np.array(places)), 1.0, rtol=1e-12)


def test_a_point_on_the_limit_is_the_boundary():
    x, y = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0])
    assert [crossings(Curve(x, y), limit) for limit in y] == [(place,) for place in x]


@settings(max_examples=40, deadline=None)
@given(
    steps=st.lists(
        st.tuples(st.floats(0.05, 2.0), st.just(0.0) | st.floats(1e-3, 300.0)),
        min_size=2,
        max_size=12,
    ),
    start=st.tuples(st.sampled_from([0.0, 0.25]), st.sampled_from([0.0, 40.0])),
    part=st.floats(0.05, 1.0),
)
def test_interpolation_passes_through_the_points_and_the_crossing(steps, start, part):
    x, y = np.cumsum([start, *steps], axis=0).T
    np.testing.assert_allclose(Curve(x, y)(x), y, rtol=1e-12, atol=1e-9)
    limit = y[0] + part * (y[-1] - y[0])
    if y[0] < limit <= y[-1]:
        roots, fine = np.array(crossings(Curve(x, y), limit)), np.linspace(x[0], x[-1], 200)
        assert len(roots) == 1
        np.testing.assert_allclose(Curve(x, y)(roots), limit, rtol=1e-9, atol=1e-9)
        assert (np.diff(Curve(x, y)(fine)) >= -1e-9).all()  # the curve rises as its points do


def test_a_line_between_loads_goes_on_beyond_a_row_s_points_only_where_it_cannot_cross():
    ds, (before, last) = synthetic.sweep().isel(load=[-2, -1]), synthetic.LOADS[-2:]
    velocity, loads = ds["velocity"], (0.9 * before + 0.1 * last, 0.1 * before + 0.9 * last)
    whole = [pipeline.margin(ds, load, 1.25).critical_velocity for load in loads]
    for end, expected in ((1.25, whole), (1.0, [np.nan] * 2), (1.5, [np.nan] * 2)):
        done = xr.where(ds["load"] == last, velocity <= end, velocity >= end)
        part = ds.assign(status=ds["status"].where(done, 0).astype(np.int8))
        found = [pipeline.margin(part, load, end).critical_velocity for load in loads]
        assert found == pytest.approx(expected, rel=1e-3, nan_ok=True)
