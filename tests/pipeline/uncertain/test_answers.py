"""Risk, sensitivity and inference, on a rise that is known in closed form."""

import dataclasses
import math

import numpy as np
import pytest

import pipeline
from pipeline.sweep.unknown import Fixed, Unknown, drawn
from pipeline.uncertain.answers import risk_lines
from pipeline.uncertain.inputs import prior
from pipeline.uncertain.sensitivity import indices
from tests.helpers.samples import (
    ALL,
    CRITICAL,
    EXPONENT,
    FRICTION,
    JOINT,
    LENGTH,
    LOADS,
    RATE,
    critical_velocity,
    dataset,
    ensemble,
    limit,
    rise,
)
from tribo import InputError

# Risk


@pytest.fixture(scope="module")
def samples():
    return ensemble()


@pytest.mark.parametrize(("load", "velocity"), [(400.0, 1.6), (300.0, 2.4)])
def test_the_probability_is_that_of_2000_direct_samples_within_its_error(load, velocity):
    risk = pipeline.risk(ensemble(noise=0.01), load, velocity)
    direct = drawn(ALL, 99, 2000)
    noise = np.exp(0.01 * np.random.default_rng(1).standard_normal(2000))
    severe = rise(direct, load, velocity) * noise > limit(direct)
    error = math.hypot(risk.error, math.sqrt(severe.mean() * (1 - severe.mean()) / 2000))
    assert abs(risk.probability - severe.mean()) < 2.5 * error
    assert risk.error < 0.02


def test_the_error_of_the_preset_widens_every_answer(samples):
    coarse = dataclasses.replace(samples, velocity_error=0.08)
    exact, rough = (pipeline.margin_intervals(one, 400.0, 2.0) for one in (samples, coarse))
    rise = 1.08**EXPONENT
    assert rough.decisive_temperature.middle == exact.decisive_temperature.middle
    widest = rough.decisive_temperature.high - 298.15
    assert widest == pytest.approx(rise * (exact.decisive_temperature.high - 298.15), rel=0.02)
    assert rough.critical_velocity.low == pytest.approx(
        exact.critical_velocity.low / 1.08, rel=0.02
    )
    assert rough.distance.low < exact.distance.low < exact.distance.high < rough.distance.high
    low, high = (pipeline.risk(samples, 400.0, 2.0 * by).probability for by in (1 / 1.08, 1.08))
    assert (rough.risk.lowest, rough.risk.highest) == pytest.approx((low, high), abs=0.01)
    assert rough.risk.error == exact.risk.error
    assert pipeline.risk(samples, 400.0, 0.8).verdict == "mild"
    assert pipeline.risk(samples, 750.0, 5.0).verdict == "severe"
    unknown = dataclasses.replace(samples, velocity_error=None)
    assert pipeline.risk(unknown, 400.0, 0.8).verdict == "not decided"
    assert pipeline.risk(unknown, 750.0, 5.0).verdict == "not decided"


def test_where_no_slope_is_known_the_rise_errs_by_as_much_as_the_velocity():
    few = dataclasses.replace(ensemble((CRITICAL, FRICTION), count=12), velocity_error=0.0)
    at = np.array([1.95, 2.05])
    few = dataclasses.replace(
        few,
        design=dataclasses.replace(few.design, velocities=(1.95, 2.05)),
        sample_velocities=np.geomspace(*at, 12),
        rises=few.rises * (np.geomspace(*at, 12) / few.sample_velocities)[:, None] ** EXPONENT,
    )
    rough = dataclasses.replace(few, velocity_error=0.08)
    exact, highest = (
        pipeline.margin_intervals(one, 400.0, 2.0).decisive_temperature.high - 298.15
        for one in (few, rough)
    )
    assert highest == pytest.approx(1.08 * exact, rel=0.005)  # not by 1.08**EXPONENT


def test_the_probability_counts_with_what_is_correlated(samples):
    """One input gains as the other loses, so that less than half is rarer still."""
    alone = pipeline.risk(samples, 400.0, 1.6)
    risk = pipeline.risk(ensemble(JOINT), 400.0, 1.6)
    direct = drawn(JOINT, 99, 2**14)
    severe = rise(direct, 400.0, 1.6) > limit(direct)
    assert risk.probability == pytest.approx(severe.mean(), abs=0.006)
    assert risk.probability < alone.probability - 0.02


def test_an_input_is_fixed_without_a_new_run_as_if_it_had_been_drawn_so():
    fixed = pipeline.Ensemble.of(
        dataset(ensemble()), {LENGTH.path: "5.5 um", CRITICAL.path: "150 degC"}
    )
    assert [one.path for one in fixed.unknown] == [RATE.path, FRICTION.path]
    assert [one.value for one in fixed.fixed] == pytest.approx([423.15, 5.5e-6])
    direct = drawn(ALL, 99, 2**14)
    direct[:, 0], direct[:, 3] = 423.15, 5.5e-6
    severe = rise(direct, 400.0, 2.0) > limit(direct)
    assert pipeline.risk(fixed, 400.0, 2.0).probability == pytest.approx(severe.mean(), abs=0.01)
    free = pipeline.risk(ensemble(), 400.0, 2.0).probability
    assert abs(free - severe.mean()) > 0.03


def test_an_input_of_the_samples_that_their_scene_fixed_takes_another_value():
    of_samples = ensemble()
    known = tuple(entry for entry in ALL if entry != RATE)
    fixed = (Fixed(RATE, 1.2e-15),)
    ds = dataset(dataclasses.replace(of_samples, unknown=known, fixed=fixed))
    at = {RATE.path: 2.4e-15}
    assert [one.value for one in pipeline.Ensemble.of(ds).fixed] == [1.2e-15]
    moved, drawn_so = pipeline.Ensemble.of(ds, at), pipeline.Ensemble.of(dataset(of_samples), at)
    assert [one.value for one in moved.fixed] == pytest.approx([2.4e-15])
    assert pipeline.risk(moved, 400.0, 2.0) == pipeline.risk(drawn_so, 400.0, 2.0)


def test_an_input_fixed_by_a_condition_is_not_unknown_any_more():
    judged = pipeline.Ensemble.of(dataset(ensemble()), friction=0.09)
    assert FRICTION.path not in [one.path for one in judged.unknown]
    assert [str(one) for one in judged.fixed] == ["friction.coefficient is fixed at 0.09"]


@pytest.mark.parametrize(
    ("at", "fault"),
    [
        ({LENGTH.path: "9 um"}, r"correlation_length is 9e-06 m, beyond the samples; give one fr"),
        ({LENGTH.path: "9 N"}, r'correlation_length: "9 N" cannot be converted'),
        ({"friction.coefficient": "much"}, r"friction is 'much'"),
    ],
)
def test_a_value_that_samples_do_not_reach_is_refused(at, fault):
    with pytest.raises(InputError, match=fault):
        pipeline.Ensemble.of(dataset(ensemble()), at)


def test_the_lines_of_the_plane_are_quantiles_of_the_boundary(samples):
    plane = pipeline.probabilities(samples, loads=LOADS)
    shares, lines = risk_lines(plane)
    direct = drawn(ALL, 99, 8192)
    for load, row in zip(LOADS[1:], lines[1:], strict=True):
        assert row == pytest.approx(np.quantile(critical_velocity(direct, load), shares), rel=0.02)


def test_draws_that_no_contact_allows_do_no_harm():
    wide = Unknown("friction.coefficient", "normal", (0.1, 0.05))  # 1 of 44 draws is negative
    wider = ensemble((CRITICAL, wide), 64)
    direct = drawn((CRITICAL, wide), 99, 8192)
    friction = np.maximum(direct[:, 1], 1e-9)
    severe = rise(direct, 400.0, 2.0, (CRITICAL, wide)) > (direct[:, 0] - 298.15) / friction
    risk = pipeline.risk(wider, 400.0, 2.0)
    assert risk.probability == pytest.approx(severe.mean(), abs=0.012)
    assert np.isfinite(pipeline.sensitivity(wider).first).all()


@pytest.mark.parametrize(
    ("load", "velocity", "message"),
    [(100.0, 2.0, "load is 100 N"), (400.0, 9.0, "velocity is 9 m/s")],
)
def test_a_place_outside_the_samples_is_refused(samples, load, velocity, message):
    with pytest.raises(InputError, match=message):
        pipeline.risk(samples, load, velocity)


# Sensitivity


def test_indices_of_ishigami_s_function():
    angles = tuple(Unknown(f"x.{k}", "uniform", (-math.pi, math.pi)) for k in range(3))

    def ishigami(x):
        return (np.sin(x[:, 0]) * (1 + 0.1 * x[:, 2] ** 4) + 7 * np.sin(x[:, 1]) ** 2)[:, None]

    (first, total), _ = indices(ishigami, angles, 2**13, seed=0)
    assert first[0] == pytest.approx([0.3139, 0.4424, 0.0], abs=0.01)
    assert total[0] == pytest.approx([0.5576, 0.4424, 0.2437], abs=0.01)


def test_indices_of_the_boundary_are_those_of_the_closed_form(samples):
    indices = pipeline.sensitivity(samples)
    direct = drawn(ALL, 99, 2**14)
    y = np.log(critical_velocity(direct, 400.0))
    assert indices.spread[1] == pytest.approx(y.std(), rel=0.05)
    alone = []
    for k in range(4):
        x = np.tile(np.median(direct, axis=0), (len(direct), 1))
        x[:, k] = direct[:, k]
        alone.append(np.var(np.log(critical_velocity(x, 400.0))))
    assert indices.first[1] == pytest.approx(np.array(alone) / y.var(), abs=0.02)
    assert (indices.first_interval[0] <= indices.first + 0.02).all()
    assert (indices.first_interval[1] >= indices.first - 0.02).all()
    assert (indices.first_interval[1] - indices.first_interval[0] < 0.15).all()
    assert max(indices.velocity_error) < 0.002


def test_correlated_inputs_have_first_indices_alone_which_count_what_they_share():
    indices = pipeline.sensitivity(ensemble(JOINT))
    assert np.isnan(indices.total).all()
    assert not indices.given_measured
    # To be linear and normal: the squared correlation of each input with the boundary.
    direct = drawn(JOINT, 99, 2**14)
    y = np.log(critical_velocity(direct, 400.0))
    x = np.log(direct)
    expected = [np.corrcoef(x[:, k], y)[0, 1] ** 2 for k in range(4)]
    assert indices.first[1] == pytest.approx(expected, abs=0.03)


# Tables


def test_conditions_of_a_row_judge_its_samples_as_options_would():
    ds, place = dataset(ensemble()), {"load": [400.0, 400.0], "velocity": [2.0, 2.0]}
    own = {"friction": [0.12, ""], "bulk_temperature": ["40 degC", ""]}
    warm, usual = pipeline.risk_table(pipeline.Ensemble.of(ds), place | own).to_dict("records")
    judged = pipeline.Ensemble.of(ds, friction=0.12, bulk_temperature="40 degC")
    assert warm["probability"] == pytest.approx(pipeline.risk(judged, 400.0, 2.0).probability)
    free = pipeline.risk(ensemble(), 400.0, 2.0).probability
    assert usual["probability"] == pytest.approx(free)
    assert warm["probability"] > free + 0.1
    (row,) = pipeline.risk_table(
        judged, {"load": [400.0], "velocity": [2.0], "friction": [0.09]}
    ).to_dict("records")
    both = pipeline.Ensemble.of(ds, friction=0.09, bulk_temperature="40 degC")
    assert row["probability"] == pytest.approx(pipeline.risk(both, 400.0, 2.0).probability)


def test_conditions_of_rows_that_samples_cannot_take_are_refused(samples):
    points = {"load": [400.0], "velocity": [2.0], "friction": [0.12]}
    with pytest.raises(InputError, match="columns for friction; tests weigh the conditions"):
        pipeline.risk_table(samples, points, prior(samples.unknown, 0))
    disk = dataclasses.replace(samples.conditions, disk_temperature=320.0)
    unlike = dataclasses.replace(samples, conditions=disk)
    (row,) = pipeline.risk_table(unlike, points).to_dict("records")
    assert row["verdict"] == "not known"
    assert "are not judged row by row at another friction" in row["note"]
