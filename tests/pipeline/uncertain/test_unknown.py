"""Distributions of inputs that are not known exactly, and the samples drawn of them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.uncertain.unknown import Unknown, drawn
from tests.helpers.unknowns import distribution_of

NORMAL = Unknown("temperature.critical", "normal", (418.15, 8.0), "K")
FACTOR = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1")
EVEN = Unknown("disk.roughness.correlation_length", "uniform", (3e-6, 6e-6), "m")
LISTED = Unknown("disk.roughness.seed", "list", (3.0, 5.0, 8.0, 9.0))
ALL = (NORMAL, FACTOR, EVEN, LISTED)


@pytest.mark.parametrize("unknown", [NORMAL, FACTOR, EVEN], ids=lambda entry: entry.kind)
def test_the_share_below_a_value_is_the_one_it_was_drawn_by(unknown):
    shares = np.array([1e-4, 0.2, 0.5, 0.9])
    assert distribution_of(unknown).cdf(unknown.quantile(shares)) == pytest.approx(shares, rel=1e-9)


def test_each_of_a_list_is_drawn_as_often_and_another_seed_draws_others():
    values, counts = np.unique(drawn(ALL, seed=1, count=256)[:, 3], return_counts=True)
    assert values.tolist() == [3.0, 5.0, 8.0, 9.0]
    assert counts.tolist() == [64, 64, 64, 64]
    assert (drawn(ALL[:2], 1, 64) != drawn(ALL[:2], 2, 64)).all()


def test_samples_fill_the_space_more_evenly_than_chance():
    means = [drawn((EVEN,), seed, 128).mean() for seed in range(20)]
    by_chance = (3e-6 / 12**0.5) / 128**0.5
    assert np.std(means) < 0.1 * by_chance


CELSIUS = replace(NORMAL, written="°C")


def test_the_unit_in_which_it_was_written_makes_no_other_input():
    assert CELSIUS == NORMAL
    assert NORMAL.shown == "K"
