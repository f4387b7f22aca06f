"""Margins where inputs are not known exactly, on a rise that is known in closed form."""

import dataclasses
import math

import numpy as np
import pytest

import pipeline
from pipeline.analysis.rise_error import preset_error
from pipeline.uncertain.unknown import drawn
from tests.helpers.samples import (
    EXPONENT,
    critical_velocity,
    dataset,
    ensemble,
    limit,
    margin,
    rise,
)
from tests.helpers.unknowns import ALL, CRITICAL
from tests.pipeline.analysis.test_model_error import density

ENDS = (0.05, 0.95)
DIRECT = drawn(ALL, 99, 8192)


def test_medians_and_intervals_are_those_of_the_closed_form():
    found = margin(ensemble(), 400.0, 2.0)
    hot = 298.15 + DIRECT[:, 2] * rise(DIRECT, 400.0, 2.0)
    left = DIRECT[:, 0] - hot
    at_load = critical_velocity(DIRECT, 400.0)
    at_velocity = (limit(DIRECT) / rise(DIRECT, 1.0, 2.0)) ** (1 / 0.58)
    # From 8192 draws the ends of intervals are known to 2 % of a standard deviation of 5 to 10 K.
    # The standard deviation of a difference is 13 K; its error may be twice as large.
    for name, direct, error in (
        ("decisive_temperature", hot, {"abs": 0.4}),
        ("distance", left, {"abs": 0.8}),
        ("critical_velocity", at_load, {"rel": 0.01}),
        ("critical_load", at_velocity, {"rel": 0.015}),
    ):
        assert found.intervals[name] == pytest.approx(np.quantile(direct, ENDS), **error)
        assert getattr(found, name) == pytest.approx(np.median(direct), **error)
    assert found.probability == pytest.approx(np.mean(hot > DIRECT[:, 0]), abs=0.01)
    assert found.members >= 1024


@pytest.mark.parametrize("place", [(400.0, 1.3), (400.0, 2.0), (750.0, 1.4)])
def test_the_probability_is_that_of_the_next_run_over_inputs_and_the_models_own_error(place):
    load, velocity = place
    off = np.log(critical_velocity(DIRECT, load) / velocity)
    error = np.linspace(-3.0, 3.0, 6001)
    weights = density(error, 4, 0.10) * (error[1] - error[0])
    ranked = np.searchsorted(np.sort(off), error) / len(off)
    expected = float(weights @ ranked)
    found = margin(ensemble(), load, velocity, scatter=0.10)
    assert found.probability == pytest.approx(expected, abs=0.006)
    assert found.probability != pytest.approx(np.mean(off < 0), abs=0.006)


def test_the_band_of_a_boundary_has_the_velocities_of_these_probabilities():
    ds = dataset(ensemble(), model_scatter=0.0, measured=(), tested=(), preset="reference")
    crossings = pipeline.boundary(ds)
    lines = crossings["critical_velocity_quantile"]
    assert lines["quantile"].values.tolist() == [0.05, 0.5, 0.95]
    for load in (400.0, 750.0):
        direct = np.quantile(critical_velocity(DIRECT, load), lines["quantile"])
        assert lines.sel(load=load).values == pytest.approx(direct, rel=0.02)
        low, high = crossings["mild_below"].sel(load=load), crossings["severe_above"].sel(load=load)
        assert pipeline.margin(ds, load, 0.98 * low.item()).verdict == "mild"
        assert pipeline.margin(ds, load, 1.02 * high.item()).verdict == "severe"
        for velocity in (1.02 * low.item(), 0.98 * high.item()):
            assert pipeline.margin(ds, load, velocity).verdict == "not decided"


def test_the_error_of_the_preset_moves_every_rise():
    exact, rough = (
        margin(dataclasses.replace(ensemble(), velocity_error=error), 400.0, 2.0)
        for error in (0.0, 0.08)
    )
    assert rough.decisive_temperature == exact.decisive_temperature
    assert (exact.error.total, exact.lowest) == (0.0, exact.probability)
    rise_error = rough.error.preset / (rough.decisive_temperature - 298.15)
    assert rise_error == pytest.approx(preset_error(0.08), rel=1e-9)
    off = np.log(critical_velocity(DIRECT, 400.0) / 2.0)
    for end, sign in (("lowest", -1), ("highest", 1)):
        expected = np.mean(off < sign * math.log1p(rise_error) / EXPONENT)
        assert getattr(rough, end) == pytest.approx(expected, abs=0.015)
    unknown = dataclasses.replace(ensemble(), velocity_error=None)
    for place in ((400.0, 0.8), (750.0, 5.0)):
        assert margin(unknown, *place).verdict == "not decided"
    assert margin(ensemble(), 400.0, 0.8).verdict == "mild"
    assert margin(ensemble(), 750.0, 5.0).verdict == "severe"


def test_what_samples_scatter_by_widens_the_interval():
    noise, few = 0.1, (CRITICAL, ALL[1])
    found = margin(ensemble(few, noise=noise), 400.0, 2.0)
    direct = drawn(few, 99, 8192)
    off = np.exp(noise * np.random.default_rng(3).standard_normal(8192))
    hot = off * 0.1 * rise(direct, 400.0, 2.0, few)

    def width(temperatures):
        return np.ptp(np.log(np.array(temperatures) - 298.15))

    expected = np.ptp(np.quantile(np.log(hot), ENDS))
    here = width(found.intervals["decisive_temperature"])
    assert here == pytest.approx(expected, rel=0.25)  # 64 samples give a standard deviation to 9 %
    alone = margin(ensemble(few), 400.0, 2.0)
    assert here > 1.5 * width(alone.intervals["decisive_temperature"])
