"""Margins where inputs are not known exactly, on a rise that is known in closed form."""

import dataclasses

import numpy as np
import pytest

import pipeline
from pipeline.sweep.unknown import drawn
from tests.helpers.samples import ALL, CRITICAL, critical_velocity, ensemble, limit, rise
from tribo import InputError

SHARES = (0.05, 0.5, 0.95)
DIRECT = drawn(ALL, 99, 8192)


def values(interval):
    return [interval.low, interval.middle, interval.high]


def test_intervals_are_those_of_the_closed_form():
    intervals = pipeline.margin_intervals(ensemble(), "400 N", "2 m/s")
    hot = 298.15 + DIRECT[:, 2] * rise(DIRECT, 400.0, 2.0)
    # The ends from 8192 draws are known to 2 % of a standard deviation, of 5 to 10 K.
    assert values(intervals.decisive_temperature) == pytest.approx(
        np.quantile(hot, SHARES), abs=0.4
    )
    # Those of a difference of two, whose standard deviation is 13 K, to twice the error of 0.4 K.
    left = np.quantile(DIRECT[:, 0] - hot, SHARES)
    assert values(intervals.distance) == pytest.approx(left, abs=0.8)
    at_load = np.quantile(critical_velocity(DIRECT, 400.0), SHARES)
    assert values(intervals.critical_velocity) == pytest.approx(at_load, rel=0.01)
    at_velocity = np.quantile((limit(DIRECT) / rise(DIRECT, 1.0, 2.0)) ** (1 / 0.58), SHARES)
    assert values(intervals.critical_load) == pytest.approx(at_velocity, rel=0.015)
    assert intervals.risk.probability == pytest.approx(np.mean(hot > DIRECT[:, 0]), abs=0.01)


def test_what_samples_scatter_by_widens_the_interval():
    noise = 0.1
    intervals = pipeline.margin_intervals(ensemble((CRITICAL, ALL[1]), noise=noise), 400.0, 2.0)
    direct = drawn((CRITICAL, ALL[1]), 99, 8192)
    off = np.exp(noise * np.random.default_rng(3).standard_normal(8192))
    hot = off * 0.1 * rise(direct, 400.0, 2.0, (CRITICAL, ALL[1]))
    expected = np.ptp(np.quantile(np.log(hot), SHARES))
    width = np.ptp(np.log(np.array(values(intervals.decisive_temperature)) - 298.15))
    assert width == pytest.approx(expected, rel=0.25)  # 64 samples tell a scatter to 9 %
    alone = pipeline.margin_intervals(ensemble((CRITICAL, ALL[1])), 400.0, 2.0)
    assert width > 1.5 * np.ptp(np.log(np.array(values(alone.decisive_temperature)) - 298.15))


def test_a_boundary_beyond_the_sweep_is_said_to_lie_there():
    intervals = pipeline.margin_intervals(ensemble(), 200.0, 2.0)
    assert intervals.critical_load.low > 200.0
    assert intervals.load_range[1] == 750.0
    slow = pipeline.margin_intervals(ensemble(), 750.0, 0.6)
    assert slow.critical_load.low == slow.critical_load.high == np.inf
    fast = pipeline.margin_intervals(ensemble(), 750.0, 5.9)
    assert fast.critical_load.low == 0.0


def test_a_single_load_has_no_critical_load():
    samples = ensemble()
    single = dataclasses.replace(
        samples,
        loads=samples.loads[:1],
        rises=samples.rises[:, :1],
        widths=samples.widths[:, :1],
    )
    assert pipeline.margin_intervals(single, 200.0, 2.0).critical_load is None
    with pytest.raises(InputError, match="load is 400 N; the samples have 200 N alone"):
        pipeline.margin_intervals(single, 400.0, 2.0)
