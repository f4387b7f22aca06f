"""Pressures within bounds that carry a load (tribo/contact/simplex.py)."""

import math

import numpy as np
import pytest

from tribo.contact.simplex import nearest, scaled_to_load, shifted_to_load


@pytest.mark.parametrize("hardness", [math.inf, 1.5])
@pytest.mark.parametrize("offset", [0.0, -1e3, 1e6])
@pytest.mark.parametrize("total", [1e-9, 3.0, 44.0])
def test_the_nearest_is_one_shift_away_and_clipped(total, offset, hardness):
    field = np.random.default_rng(0).normal(size=(5, 6)) + offset
    pressure = nearest(field, total, hardness)
    assert pressure.min() >= 0
    assert pressure.max() <= hardness
    assert pressure.sum() == pytest.approx(total, rel=1e-13)
    shift = pressure - field
    free = (pressure > 0) & (pressure < hardness)
    slack = 1e-12 * (1 + abs(offset))
    assert np.ptp(shift[free]) <= slack
    assert shift[pressure == 0].min(initial=math.inf) >= shift[free].max() - slack
    assert shift[pressure == hardness].max(initial=-math.inf) <= shift[free].min() + slack


@pytest.mark.parametrize("total", [1.0, 8.0, 14.9])
@pytest.mark.parametrize("guess", [[0.0, 1.0, 3.0, 9.0], [-5.0, 0.0, 0.0, 1.0], [0.0] * 4])
def test_guesses_are_brought_within_bounds_and_to_the_load(guess, total):
    for bring in (scaled_to_load, shifted_to_load):
        pressure = bring(np.array(guess), total, hardness=5.0)
        assert pressure.min() >= 0
        assert pressure.max() <= 5.0
        assert pressure.sum() == pytest.approx(total, rel=1e-13)


def test_what_carries_the_load_already_is_left_as_it_is():
    guess = np.array([0.0, 1.0, 3.0])
    for bring in (scaled_to_load, shifted_to_load, nearest):
        assert np.array_equal(bring(guess, 4.0, 5.0), guess)
