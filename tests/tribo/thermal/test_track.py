import math

import numpy as np
import pytest
import scipy

from tribo.thermal import track_warming

DIFFUSIVITY, CAPACITY = 1.2275e-5, 3.666e6
STEADY = np.array([1e-9, 1e9]), np.array([100.0, 100.0])


def strip(age, width, load):
    """Rise in the middle of a strip heated at once, by Kelvin's point source over its width."""

    def point(y):
        return math.exp(-(y**2) / (4 * DIFFUSIVITY * age)) / (4 * math.pi * DIFFUSIVITY * age)

    # a line of points along the track, and the insulated surface doubles each
    total = scipy.integrate.quad(point, -width / 2, width / 2, epsabs=0)[0]
    return 2 * load / width * total / CAPACITY


@pytest.mark.parametrize("width", [1e-4, 3.4e-3, 1.0])
def test_one_pass_leaves_what_kelvin_s_sources_leave(width):
    warming = track_warming(0.3, 0.2, STEADY, width, DIFFUSIVITY, CAPACITY)
    assert warming == pytest.approx(strip(0.2, width, 100.0), rel=1e-9)


def test_many_passes_of_a_load_that_comes_and_goes_are_summed_as_few():
    """The load is on for 10 s of every 20 s, for an hour, on a disc of ten turns a second."""
    times = np.sort(np.concatenate([np.arange(0, 3600, 10.0), np.arange(0, 3600, 10.0) + 1e-3]))
    loads = times, np.where(np.floor((times + 9.999) / 10) % 2 > 0, 100.0, 0.0)
    age = np.arange(1, 36001) * 0.1
    left = np.interp(3600.0 - age, *loads) * scipy.special.erf(
        3.4e-3 / (4 * np.sqrt(DIFFUSIVITY * age))
    )
    one_by_one = (left / (3.4e-3 * CAPACITY * np.sqrt(np.pi * DIFFUSIVITY * age))).sum()
    warming = track_warming(3600.0, 0.1, loads, 3.4e-3, DIFFUSIVITY, CAPACITY)
    assert warming == pytest.approx(one_by_one, rel=1e-3)


@pytest.mark.parametrize("count", [402, 450, 3000])
def test_passes_beyond_those_summed_one_by_one_are_all_counted_once(count):
    ages = 0.1 * np.arange(1, count + 1)
    separate_warmings = [
        track_warming(1.5 * age, age, STEADY, 3.4e-3, DIFFUSIVITY, CAPACITY) for age in ages
    ]
    warming = track_warming(0.1 * (count + 0.7), 0.1, STEADY, 3.4e-3, DIFFUSIVITY, CAPACITY)
    assert warming == pytest.approx(sum(separate_warmings), rel=1e-6)
