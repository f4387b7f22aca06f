"""The random error by positions of the disk is a part of its own, which falls with realizations."""

from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.answers.error import POSITIONS, SURFACE, position_limit, rise_errors
from pipeline.answers.specimen import merge_realizations
from pipeline.run.search import Goal, Search

LOADS, VELOCITIES = np.array([200.0, 400.0]), np.array([1.0, 2.0, 4.0])
LIMIT = 0.012


def specimen_of(count=1, sampling=0.02, freedom=7.0, limit=LIMIT):
    """Rises as velocity^0.65 of `count` realizations, which differ by 2 % at most."""
    y = 0.65 * np.log(VELOCITIES) + np.log(LOADS)[:, None] + np.zeros((count, 1, 1))
    y += 0.01 * np.linspace(-1, 1, count)[:, None, None] if count > 1 else 0.0
    plane = np.full((2, 3), sampling)
    flags, unit = np.zeros((2, 3), int), np.ones((2, 3))
    specimen = merge_realizations(LOADS, VELOCITIES, y, plane, flags, unit, freedom=freedom)
    return replace(specimen, position_limit=limit)


def parts_of(specimen):
    return rise_errors(specimen, 0.011, specimen.field.at(LOADS, VELOCITIES[:2]))


@pytest.mark.parametrize(("sampling", "expected"), [(0.004, 0.4 * 2.3646 * 0.004), (0.02, LIMIT)])
def test_it_is_a_share_of_surface_sampling_up_to_a_limit(sampling, expected):
    assert parts_of(specimen_of(sampling=sampling))[POSITIONS] == pytest.approx(expected, rel=1e-3)


def test_it_is_known_where_surface_sampling_is_not():
    parts = parts_of(specimen_of(sampling=np.nan, freedom=0.0))
    assert np.isnan(parts[SURFACE]).all()
    assert parts[POSITIONS] == pytest.approx(LIMIT)


def test_four_realizations_halve_its_limit_and_contain_three_tenths_of_its_square():
    """Surface sampling by 7 degrees of the jackknife and 3 of the realizations has their part."""
    parts = parts_of(specimen_of(4, sampling=0.2))
    assert parts[POSITIONS] == pytest.approx(LIMIT / 2 * np.sqrt(7 / 10))


def test_realizations_alone_contain_it():
    parts = parts_of(specimen_of(4, sampling=np.nan, freedom=0.0))
    assert (parts[SURFACE] > 0).all()
    assert not parts[POSITIONS].any()


@pytest.mark.parametrize(("limit", "is_out"), [(0.0, False), (0.001, False), (0.02, True)])
def test_it_counts_in_a_goal_on_a_fixed_surface(limit, is_out):
    specimen = specimen_of(4, sampling=0.2, limit=limit)
    limit_of_rise = float(0.65 * np.log(1.5) + np.log(300.0))
    y = 0.65 * np.log(VELOCITIES) + np.log(LOADS)[:, None]
    tried = np.ones((4, 2, 3), bool)
    goal = Goal(0.014, 4, counts_surface=False)
    search = Search(specimen, limit_of_rise, 0.0055, y - limit_of_rise, tried, goal)
    assert search.is_out_of_reach({0, 1}) == is_out
    by_positions = np.nan_to_num(search.errors[POSITIONS])  # NaN without a crossing
    rest = goal.accuracy**2 - search.preset_error**2 - by_positions**2
    np.testing.assert_allclose(search.error_budget, np.sqrt(rest.clip(0.0)))


def test_only_a_pin_that_wears_by_the_disk_at_some_positions_has_it():
    assert position_limit(pipeline.load_scene("first_try")) == 0.013
    assert position_limit(pipeline.load_scene("whole_pin")) == 0.037
    for scene in ("first_try", "whole_pin"):
        local = pipeline.load_scene(scene, overrides={"wear.pattern": "local"})
        assert position_limit(local) == 0.0
    assert position_limit(pipeline.load_scene("ball_on_disk")) == 0.0
