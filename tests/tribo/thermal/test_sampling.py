"""The sampling error of one contact (tribo/thermal/quantiles.py) against other seeds."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import small_scene
from tribo import QUANTILES, simulate
from tribo.simulation import heat
from tribo.thermal import contact_quantiles, jackknife_error, rises_without_groups

HOTTEST_TENTH = QUANTILES.index(0.9)


def test_rises_without_a_group_are_those_of_the_rest():
    rng = np.random.default_rng(3)
    rise, contact = rng.random((40, 24)), rng.random((40, 24)) < 0.3
    groups = rng.integers(0, 8, (40, 24))
    quantiles = rises_without_groups(rise, contact, groups)
    for group in range(8):
        rest = contact & (groups != group)
        assert quantiles[group] == pytest.approx(contact_quantiles(rise, rest))


def test_the_error_of_many_independent_rises_is_that_of_their_quantile():
    rng = np.random.default_rng(5)
    rises, groups = (
        rng.exponential(100.0, (60, 40, 40)),
        np.arange(40) // 5 + np.zeros((40, 1), int),
    )
    everywhere = np.ones((40, 40), bool)
    errors = [jackknife_error(rises_without_groups(r, everywhere, groups)) for r in rises]
    spread = np.log([contact_quantiles(r, everywhere) for r in rises]).std(axis=0, ddof=1)
    for quantile in (QUANTILES.index(0.5), HOTTEST_TENTH):
        assert np.sqrt(np.mean(np.square(errors), axis=0))[quantile] == pytest.approx(
            spread[quantile], rel=0.3
        )


def errors_and_spread(scene, load, velocity, seeds):
    """Errors that each of several surfaces states, and the standard deviation between them."""
    errors, rises = [], []
    for seed in range(seeds):
        reseeded = replace(scene, roughness=replace(scene.roughness, seed=seed))
        *_, state = simulate(reseeded, load, velocity)
        sampled_heat = heat(reseeded, state, velocity, is_sampled=True)
        errors.append(sampled_heat.sampling["rise_realization_std"][HOTTEST_TENTH])
        rises.append(sampled_heat.rise_quantile[HOTTEST_TENTH])
    return float(np.sqrt(np.mean(np.square(errors)))), float(np.std(np.log(rises), ddof=1))


def test_a_realization_tells_how_others_differ_and_a_smooth_disk_has_no_error():
    error, spread = errors_and_spread(small_scene(), 400.0, 2.0, 24)
    assert spread / 2 < error < 2 * spread
    smooth = small_scene(roughness=False)
    *_, state = simulate(smooth, 400.0, 2.0)
    assert not heat(smooth, state, 2.0, is_sampled=True).sampling["rise_realization_std"].any()
