"""Panels of a thermal kernel, and its factors along an axis (quadrature.py and factors.py)."""

import itertools
import math

import numpy as np
import pytest
import scipy

from tribo.thermal.factors import Axis, factor, wavenumbers
from tribo.thermal.quadrature import REACH, diffusion_length, filon_weights, panels


@pytest.mark.parametrize("reach", [6.0, 0.3, -6.0, -0.3])
@pytest.mark.parametrize(("drift", "distance"), [(2.0, 0.01), (2.0, 50.0), (1e-3, 4.0)])
def test_a_source_gets_past_a_distance_when_its_front_or_its_rear_is_there(reach, drift, distance):
    s = diffusion_length(reach, drift, distance)
    assert s > 0
    assert drift * s**2 + reach * s == pytest.approx(distance, rel=1e-9)


def test_at_rest_the_front_gets_anywhere_and_the_rear_nowhere():
    assert diffusion_length(6.0, 0.0, 3.0) == 0.5
    assert diffusion_length(0.5, 0.0, 3.0) == 6.0
    assert diffusion_length(-6.0, 0.0, 3.0) == math.inf


def test_panels_double_at_rest_and_grow_by_half_where_the_weights_take_the_oscillation():
    assert list(panels(0.0, 1.0, 10.0, math.inf, 1.0)) == [(1, 2), (2, 4), (4, 8), (8, 10)]
    assert list(panels(7.0, 2.0, 4.0, 2.0, 1.0)) == [(2, 3), (3, 4)]
    assert list(panels(7.0, 2.0, 2.0, math.inf, 1.0)) == []


@pytest.mark.parametrize("drift", [0.03, 1.0, 40.0])
def test_within_a_panel_a_source_moves_by_a_reach_or_its_edges_meet_no_centre(drift):
    """Of elements of side 2, whose centres the edges pass at odd multiples of half of it."""
    side, start, end = 2.0, 0.05, 9.0
    found = list(panels(drift, start, end, math.inf, side))
    assert found[0][0] == start
    assert found[-1][1] == end
    assert all(one[1] == next_one[0] for one, next_one in itertools.pairwise(found))
    near = REACH / (2 * drift)  # change of s while an edge is within reach of a centre
    met = [math.sqrt((k + 0.5) * side / drift) for k in range(int(drift * end**2))]
    few = 0
    for low, high in found:
        assert high <= 2 * low * (1 + 1e-12)
        usual = 1 / (1 / low + 1 / near)
        if high - low > 1.0001 * usual:  # it is undisturbed, until the next edge comes
            few += 1
            assert all(not low - near < one < high + near * (1 - 1e-9) for one in met)
            ends = (end, 2 * low, *(one - near for one in met))
            assert min(abs(high - stop) for stop in ends) < 1e-9
        else:
            assert drift * (high**2 - low**2) <= REACH * high
            assert high - low == pytest.approx(usual) or high == end
    assert (few > 0) == (drift > 1)


@pytest.mark.parametrize("omega", [0.0, 1e-3, 1.7, 60.0])
@pytest.mark.parametrize("power", [0, 1, 5])
def test_weights_for_an_oscillation_are_exact_of_any_polynomial(omega, power):
    low, high = 0.5, 3.0
    nodes, weights = np.polynomial.legendre.leggauss(6)
    found = filon_weights(np.array([[omega]]), low, high, nodes, weights)
    z = (high + low) / 2 + (high - low) / 2 * nodes
    many, fine = np.polynomial.legendre.leggauss(200)
    at = (high + low) / 2 + (high - low) / 2 * many
    exact = (high - low) / 2 * (fine * at**power * np.exp(-1j * omega * at)).sum()
    assert found.shape == (6, 1, 1)
    assert z**power @ found[:, 0, 0] == pytest.approx(exact, abs=1e-10 * high ** (power + 1))


def edges(place, s, shift, step):
    """E of an element of a side `step`, a distance from its middle."""
    ends = ((place + half - shift) / s for half in (step / 2, -step / 2))
    first, second = map(scipy.special.erf, ends)
    return first - second


def summed(axis, s, shift):
    """Values of E in wrapped order, with 60 periods on either side, one by one."""
    order = np.arange(axis.length)
    order = np.where(order <= (axis.length - 1) // 2, order, order - axis.length)
    if not axis.periodic:
        return np.where(np.abs(order) < axis.n, edges(order * axis.step, s, shift, axis.step), 0.0)
    periods = axis.n * np.arange(-60, 61)[:, None]
    every = edges((order + periods) * axis.step, s, shift, axis.step)
    if axis.nearest_image:  # distances below a period, and half of two that are equally near
        weight = np.select([np.abs(order + periods) < axis.n, np.abs(order + periods) == axis.n],
                           [1.0, 0.5])  # fmt: skip
        every = weight * every
    return every.sum(axis=0)


AXES = {
    "free": Axis(6, 0.7, 12, periodic=False),
    "even": Axis(8, 0.7, 8, periodic=True),
    "odd": Axis(7, 0.7, 7, periodic=True),
    "single": Axis(1, 0.7, 1, periodic=True),
    "nearest": Axis(8, 0.7, 8, periodic=True, nearest_image=True),
}


@pytest.mark.parametrize(
    ("name", "drift"),
    [("nearest", 0.0), *itertools.product(["free", "even", "odd", "single"], [0.0, 0.4, 9.0])],
)
def test_a_factor_is_the_transform_of_all_periods_of_an_element(name, drift):
    axis = AXES[name]
    for low in (0.05, 0.3, 0.9, 1.5, 2.9):
        if drift and low >= axis.series_start(drift):
            continue  # there the weights of the nodes have the motion
        s = low * np.array([1.0, 1.3, 1.9])
        found = factor(axis, s, low, drift)
        exact = np.fft.rfft([summed(axis, one, drift * one**2) for one in s])
        modes = found.shape[1]
        assert np.isrealobj(found) == (drift == 0)
        assert found == pytest.approx(exact[:, :modes], abs=1e-12)
        # Modes that are left out have faded.
        assert exact[:, modes:] == pytest.approx(np.zeros_like(exact[:, modes:]), abs=1e-12)


def test_a_series_begins_where_it_needs_no_more_modes_than_there_are_elements():
    axis = Axis(64, 0.5, 64, periodic=True)
    start = axis.series_start(0.0)
    assert math.exp(-((math.pi / axis.step * start / 2) ** 2)) == pytest.approx(math.exp(-36))
    assert wavenumbers(axis, start * 1.001).shape[1] == 32
    assert Axis(64, 0.5, 127, periodic=False).series_start(0.0) == math.inf
    assert AXES["nearest"].series_start(0.0) == math.inf


def test_wavenumbers_are_those_of_the_modes_that_live_and_of_what_folds_onto_them():
    axis = Axis(8, 0.5, 8, periodic=True)
    one = 2 * math.pi / 4.0
    found = wavenumbers(axis, 1.0)  # 6 · 4 / π is 7.6: seven modes, of which 5 to 7 fold
    assert found.shape == (3, 5)
    assert found / one == pytest.approx(
        np.array([[-8, -7, -6, -5, -4], [0, 1, 2, 3, 4], [8, 9, 10, 11, 12]])
    )
    assert wavenumbers(axis, 4.0).tolist() == [[0.0, one]]
