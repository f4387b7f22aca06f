"""What truths learn of measurements, beside closed forms of normal inputs."""

import math

import numpy as np
import pytest
from scipy.special import ndtri

from pipeline.uncertain.learning import Knowledge, Observable

COUNT = 2**12
SPREAD, ERROR = 3.0, 2.0  # of an input, and of its measurement
DRAWS = SPREAD * ndtri((np.arange(COUNT) + 0.5) / COUNT)
TRUTHS = SPREAD * ndtri((np.arange(400) + 0.5) / 400)
BOTH = np.concatenate([TRUTHS, DRAWS])
DEVIATION = np.full(len(BOTH), ERROR)


def known(truths=TRUTHS, draws=DRAWS):
    weights = np.full(len(draws), 1 / len(draws))
    return Knowledge.of(truths[:, None], draws[:, None], weights)


def chance():
    return np.random.default_rng(1)


def test_a_number_leaves_the_spread_of_two_normal_ones_and_two_numbers_that_of_three():
    after = known()
    for count in (1, 2):
        after = after.after(Observable("", BOTH, DEVIATION), chance())
        left = (SPREAD**-2 + count * ERROR**-2) ** -0.5
        assert after.spread(DRAWS[None]) == pytest.approx(left, rel=0.01)


def test_the_side_of_the_middle_leaves_what_a_half_normal_distribution_does():
    """Var(x) less (E(x | side))², which is s⁴/(s² + e²) · 2/π."""
    test = Observable("", BOTH, DEVIATION, 0.0, 0.0)
    left = math.sqrt(SPREAD**2 - 2 / math.pi * SPREAD**4 / (SPREAD**2 + ERROR**2))
    assert known().expected([test], DRAWS[None]) == pytest.approx([left], rel=1e-3)
    assert known().after(test, chance()).spread(DRAWS[None]) == pytest.approx(left, rel=1e-3)


def test_a_search_is_a_number_between_its_ends_and_a_side_beyond_them():
    found = {}
    for end in (1e-3, 2.0, 50.0):
        search = Observable("", BOTH, DEVIATION, -end, end)
        found[end] = known().after(search, chance()).spread(DRAWS[None])
    number = known().after(Observable("", BOTH, DEVIATION), chance()).spread(DRAWS[None])
    side = known().after(Observable("", BOTH, DEVIATION, 0.0, 0.0), chance()).spread(DRAWS[None])
    assert found[50.0] == pytest.approx(number, rel=1e-9)
    assert found[1e-3] == pytest.approx(side, rel=1e-3)
    assert number < found[2.0] < side


def test_spreads_are_root_mean_squares_over_targets():
    both = np.stack([DRAWS, 2 * DRAWS])
    once = known().spread(DRAWS[None])
    assert once == pytest.approx(SPREAD, rel=2e-3)
    assert known().spread(both) == pytest.approx(once * math.sqrt(2.5))


def test_a_value_of_a_list_leaves_the_spread_within_its_parts():
    value = np.arange(COUNT) % 2
    target = DRAWS + 10.0 * value
    assert known().spread_given(value, target[None]) == pytest.approx(SPREAD, rel=2e-3)
    assert known().spread(target[None]) == pytest.approx(math.hypot(SPREAD, 5.0), rel=2e-3)


def test_no_truth_weighs_itself():
    """Else a sharp measurement would leave nothing unknown."""
    truths = DRAWS[::16]
    values = np.concatenate([truths, DRAWS])
    sharp = Observable("", values, np.full(len(values), 1e-6))
    weights = known(truths).after(sharp, chance()).weights
    assert (weights[np.arange(len(truths)), 16 * np.arange(len(truths))] == 0).all()
    assert weights.sum(axis=1) == pytest.approx(1.0)
