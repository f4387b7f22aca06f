"""Risk, sensitivity and inference, on a rise that is known in closed form."""

import math

import numpy as np
import pytest

import pipeline
from pipeline.uncertain.sensitivity import indices
from pipeline.uncertain.unknown import Unknown, drawn
from tests.helpers.samples import (
    critical_velocity,
    dataset,
    ensemble,
    limit,
    margin,
    rise,
)
from tests.helpers.unknowns import ALL, CRITICAL, FRICTION, JOINT, LENGTH, RATE

# Risk


@pytest.fixture(scope="module")
def samples():
    return ensemble()


def test_the_probability_counts_with_what_is_correlated(samples):
    """Correlated inputs compensate each other, so that a probability below half falls further."""
    alone, both = (margin(one, 400.0, 1.6).probability for one in (samples, ensemble(JOINT)))
    direct = drawn(JOINT, 99, 2**14)
    severe = rise(direct, 400.0, 1.6) > limit(direct)
    assert both == pytest.approx(severe.mean(), abs=0.006)
    assert both < alone - 0.02


def test_an_input_is_fixed_without_a_new_run_as_if_it_had_been_drawn_so():
    at = {LENGTH.path: "5.5 um", CRITICAL.path: "150 degC"}
    fixed = pipeline.Ensemble.of(pipeline.at(dataset(ensemble()), **at))
    assert [one.path for one in fixed.unknown] == [RATE.path, FRICTION.path]
    assert sorted(one.value for one in fixed.fixed) == pytest.approx([5.5e-6, 423.15])
    direct = drawn(ALL, 99, 2**14)
    direct[:, 0], direct[:, 3] = 423.15, 5.5e-6
    severe = rise(direct, 400.0, 2.0) > limit(direct)
    assert margin(fixed, 400.0, 2.0).probability == pytest.approx(severe.mean(), abs=0.01)
    free = margin(ensemble(), 400.0, 2.0).probability
    assert abs(free - severe.mean()) > 0.03


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
    # If the model is linear and normal, indices are squared correlations with the boundary.
    direct = drawn(JOINT, 99, 2**14)
    y = np.log(critical_velocity(direct, 400.0))
    x = np.log(direct)
    expected = [np.corrcoef(x[:, k], y)[0, 1] ** 2 for k in range(4)]
    assert indices.first[1] == pytest.approx(expected, abs=0.03)


# Tables

HERE = {"load": [400.0], "velocity": [2.0]}


def of_samples():
    return dataset(ensemble(), model_scatter=0.0, measured=(), tested=())


def test_conditions_of_a_row_judge_its_samples_as_options_would():
    ds, own = of_samples(), {"friction": [0.105], "bulk_temperature": ["30 degC"]}
    (warm,) = pipeline.margin(ds, HERE | own).to_dict("records")
    (usual,) = pipeline.margin(ds, HERE).to_dict("records")
    judged = pipeline.at(ds, friction=0.105, bulk_temperature="30 degC")
    there = pipeline.margin(judged, 400.0, 2.0).probability
    assert warm["probability"] == pytest.approx(there)
    free = pipeline.margin(ds, 400.0, 2.0).probability
    assert usual["probability"] == pytest.approx(free)
    assert warm["probability"] > free + 0.1
    (row,) = pipeline.margin(judged, HERE | {"friction": [0.09]}).to_dict("records")
    both = pipeline.at(ds, friction=0.09, bulk_temperature="30 degC")
    assert row["probability"] == pytest.approx(pipeline.margin(both, 400.0, 2.0).probability)
