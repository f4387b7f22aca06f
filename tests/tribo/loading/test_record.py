"""A measured load record as loading (tribo/loading/record.py)."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.scenes import last, small_scene
from tribo import PRESETS, MeasuredLoad

TIMES = np.linspace(0.0, 8.0, 81)


def smooth_record(noise=0.0):
    """Load record of the paper, 150 N/s to 750 N from 0.5 s on, with a rounded start."""
    loads = np.clip(150.0 * (TIMES - 0.5), 0.0, 750.0)
    loads = loads + noise * np.random.default_rng(0).standard_normal(TIMES.size)
    return MeasuredLoad(TIMES, loads, reference_load=740.0)


def test_a_jump_has_half_of_the_steps_and_the_rest_are_equal_in_time():
    record = MeasuredLoad(np.array([3.0, 5.0, 5.001, 7.001]), np.array([0.0, 0.0, 599.0, 600.0]))
    load_steps = list(record.load_steps(600.0, 16))
    times = [s.time for s in load_steps]
    assert times[:4] == pytest.approx([0.5, 1.0, 1.5, 2.0], rel=1e-3)
    assert times[-4:] == pytest.approx([2.5, 3.0, 3.5, 4.0], rel=4e-3)
    assert 2.0 < times[4] < times[10] < 2.0011
    assert [s.normal_load for s in load_steps[4:11]] == pytest.approx(
        [75.0, 150.0, 225.0, 300.0, 375.0, 450.0, 525.0], rel=0.02
    )
    assert [s.index for s in load_steps] == list(range(1, 17))
    assert load_steps[-1].normal_load == 600.0
    assert not any(s.on_trunk for s in load_steps)


def test_loading_ends_where_the_reference_load_is_first_reached():
    record = smooth_record()
    assert list(record.load_steps(740.0, 5))[-1].time == pytest.approx(0.5 + 740 / 150)
    # Without a reference it is the maximum, reached at 5.5 s.
    plateau = MeasuredLoad(TIMES, record.loads)
    assert list(plateau.load_steps(750.0, 5))[-1].time == pytest.approx(5.5)


def test_a_load_that_falls_is_followed_and_noise_below_zero_is_no_load():
    record = MeasuredLoad(np.arange(5.0), np.array([-2.0, 200.0, 100.0, -3.0, 300.0]))
    load_steps = list(record.load_steps(300.0, 1000))
    for moment, load in ((1.0, 200.0), (2.0, 100.0), (3.0, 0.0)):
        nearest = min(load_steps, key=lambda load_step: abs(load_step.time - moment))
        assert nearest.normal_load == pytest.approx(load, abs=1.0)
    assert min(s.normal_load for s in load_steps) == 0.0
    triangles = 200**2 / 202 + 100**2 / 103 + 300**2 / 303  # twice the triangles' areas above 0
    assert load_steps[-1].impulse == pytest.approx(150 + triangles / 2, rel=1e-12)


def test_the_times_of_steps_do_not_depend_on_the_size_of_the_loads():
    loads = np.array([10.0, 200.0, 100.0, 100.0, 600.0])
    times = [
        [load_step.time for load_step in record.load_steps(600.0 * size, 12)]
        for size in (1.0, 1e-4)
        for record in [MeasuredLoad(np.array([0.0, 1.0, 1.5, 6.0, 7.0]), size * loads)]
    ]
    assert times[1] == pytest.approx(times[0], rel=1e-9)


@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_linear_fit_finds_the_rate_and_the_onset(noise):
    record = smooth_record(noise)
    rate, onset = record.linear_fit()
    # 40 rows over 4 s: the slope's standard error is 2 N / (√40 · 1.17 s) = 0.27 N/s.
    assert rate == pytest.approx(150.0, abs=1e-9 + 4 * 0.27 * noise / 2)
    assert onset == pytest.approx(0.5, abs=1e-9 + 0.01 * noise)


def test_the_course_of_a_long_log_keeps_its_impulse_and_its_jumps():
    """An hour of noisy readings at 10 Hz: hardly any load for 59 min, and a jump at the end."""
    times = np.arange(0.0, 3600.05, 0.1)
    noise = np.random.default_rng(1).normal(0.0, 2.0, len(times))
    loads = np.interp(times, [0, 60, 61, 3599, 3600], [0.0, 300.0, 20.0, 20.0, 600.0]) + noise
    loads[-1] = 620.0
    record = MeasuredLoad(times, loads)
    since, shares = np.array(record.course).T
    assert len(since) <= 501
    assert (since[-1], shares[-1]) == (3600.0, 1.0)
    *_, last = record.load_steps(620.0, increments=10)
    assert np.trapezoid(620.0 * shares, since) == pytest.approx(last.impulse, rel=2e-3)
    late = np.linspace(3598.0, 3599.9, 39)
    np.testing.assert_allclose(
        620 * np.interp(late, since, shares), np.interp(late, times, loads), atol=25.0
    )


def test_a_record_that_begins_under_load_is_fitted_from_there():
    record = MeasuredLoad([1.0, 2.0, 3.0], [50.0, 75.0, 100.0])
    assert record.time_at(0.1) == 1.0
    assert record.linear_fit() == pytest.approx((25.0, -1.0))


@pytest.mark.parametrize("pattern", ["local", "swept"])
def test_a_record_that_begins_unloaded_ends_as_one_that_begins_with_the_load(pattern):
    loads, fidelity = np.array([0.0, 0.0, 300.0]), replace(PRESETS["fine"], fewest_elements=0)
    records = MeasuredLoad(np.array([0.0, 4.0, 6.0]), loads), MeasuredLoad([0.0, 2.0], loads[1:])
    scene = replace(small_scene(pattern), fidelity=fidelity)
    late, early = (last(replace(scene, loading=record), 300.0, 1.25) for record in records)
    assert late.wear_depth.sum() == pytest.approx(early.wear_depth.sum(), rel=1e-12)
    # The pause takes some of the steps: 0.4 % here.
    assert late.heat.max_rise == pytest.approx(early.heat.max_rise, rel=0.01)
