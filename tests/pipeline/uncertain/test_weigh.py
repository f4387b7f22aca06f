"""Tests of a rig weigh the unknown inputs, on a rise that is known in closed form."""

import dataclasses
import functools
import math

import numpy as np
import pytest
from scipy.special import ndtr

import pipeline
from pipeline.page.content import content_of_samples
from pipeline.uncertain import weigh
from pipeline.uncertain.inputs import prior
from pipeline.uncertain.unknown import Unknown, correlations
from tests.helpers import samples
from tests.helpers.samples import EXPONENT, LOADS, critical_velocity, dataset, rise
from tests.helpers.unknowns import CRITICAL, FRICTION, JOINT, LENGTH, RATE
from tribo import Corrections, Friction

# For a closed form half as many samples suffice, in half the time.
ensemble = functools.partial(samples.ensemble, count=32)


def transitions(truth, scatter=0.05, seed=0, friction=True, loads=LOADS, off=None):
    """Measured transitions of a rig with hidden true inputs; number `off` is 40 % too high."""
    factors = np.exp(scatter * np.random.default_rng(seed).standard_normal(len(loads)))
    if off is not None:
        factors[off] *= 1.4
    return [
        {
            "normal_load": float(load),
            "velocity": float(critical_velocity(truth[None], load)[0] * factor),
            "friction": float(truth[2]) if friction else None,
        }
        for load, factor in zip(loads, factors, strict=True)
    ]


def alone(limit, load):
    """Critical velocity if the limit of the rise is the only input."""
    return (limit / rise(np.zeros((1, 0)), load, 1.0, ())[0]) ** (1 / EXPONENT)


def test_without_data_what_is_assumed_comes_back():
    posterior = pipeline.posterior(ensemble(JOINT))
    for row in posterior.summary():
        assert row["posterior"] == row["prior"]
    assert not list(posterior.hidden())
    ends = 3.0 ** np.array([-1.645, 0.0, 1.645])
    assert posterior.inferred_scatter == pytest.approx(0.05 * ends, rel=1e-3)
    # Values of a uniform input are correlated a little less than their normal scores.
    assert posterior.correlations == pytest.approx(correlations(JOINT), abs=0.02)


def test_what_is_learnt_of_an_input_tells_of_those_correlated_with_it():
    truth = np.array([418.15, 1.2e-15, 0.1, 4.5e-6])
    near = dataclasses.replace(FRICTION, correlated=((CRITICAL.path, 0.9),))
    sharp = ensemble((CRITICAL, RATE, near, LENGTH), tests=transitions(truth))
    # The friction was measured on another machine, so it counts at the transitions only.
    elsewhere = dataclasses.replace(sharp, same_rig=False)
    _, _, friction, *_ = pipeline.posterior(elsewhere).summary()
    assert friction["posterior"]["sd"] < 0.75 * friction["prior"]["sd"]


# The friction of the rig


def idle_tests(frictions, error=0.0):
    """Tests with measured frictions, whose outcome carries no information."""
    place = {"normal_load": 200.0, "velocity": 0.5, "outcome": "mild"}
    error = {"friction_scatter": error} if error else {}
    return [place | {"friction": float(friction)} | error for friction in frictions]


@pytest.mark.parametrize(("spread", "error"), [(0.0, 0.0), (0.08, 0.003)])
def test_the_friction_of_a_rig_is_learnt_with_its_scatter_between_tests(spread, error):
    scores = np.array([-1.3, -0.6, -0.2, 0.3, 0.7, 1.2])
    measured = 0.104 * np.exp(math.hypot(spread, error / 0.1) * scores)
    tests = idle_tests(measured, error)
    friction, scatter = pipeline.posterior(ensemble((FRICTION,), tests=tests)).summary()
    grid, log_tau = np.meshgrid(np.linspace(0.08, 0.12, 801), np.linspace(-8, 0, 401))
    density = np.exp(-0.5 * ((grid - 0.1) / 0.005) ** 2)
    density *= np.exp(-0.5 * ((log_tau - math.log(0.02)) / math.log(3.0)) ** 2)
    for one in measured:
        variance = np.exp(2 * log_tau) + max(error / one, 0.005) ** 2  # rounding in logs
        density *= np.exp(-0.5 * np.log(one / grid) ** 2 / variance) / np.sqrt(variance)
    mean = np.average(grid, weights=density)
    sd = math.sqrt(np.average((grid - mean) ** 2, weights=density))
    assert friction["posterior"]["mean"] == pytest.approx(mean, abs=0.15 * sd)
    assert friction["posterior"]["sd"] == pytest.approx(sd, rel=0.12)
    middle = np.average(np.exp(log_tau), weights=density)
    assert scatter["posterior"]["mean"] == pytest.approx(middle, rel=0.15)


def test_the_friction_of_another_machine_tells_nothing_of_the_scene_s():
    tests = idle_tests([0.104, 0.105, 0.103])
    elsewhere = dataclasses.replace(ensemble((FRICTION,), tests=tests), same_rig=False)
    friction, rig, _ = pipeline.posterior(elsewhere).summary()
    assert rig["path"] == "friction.rig"
    assert friction["posterior"]["sd"] == pytest.approx(friction["prior"]["sd"], rel=0.1)
    assert rig["posterior"]["sd"] < 0.5 * friction["posterior"]["sd"]


@pytest.mark.parametrize(
    ("scatters", "share"),
    [
        ({"velocity_scatter": 0.04}, EXPONENT * 0.02),
        (
            {"velocity_scatter": 0.04, "friction_scatter": 0.002},
            math.hypot(EXPONENT * 0.02, 0.02),
        ),
    ],
)
def test_a_transition_counts_as_much_as_its_own_scatter_allows(scatters, share):
    # In a linear model the precisions (1/variance) of prior and measurement add up.
    limit_there = rise(np.zeros((1, 0)), 400.0, 2.0, ())[0] * 0.1
    critical = Unknown(CRITICAL.path, "normal", (298.15 + limit_there, 8.0), "K")
    entry = {"normal_load": 400.0, "velocity": 2.0, "friction": 0.1} | scatters
    posterior = pipeline.posterior(ensemble((critical, LENGTH), tests=[entry]), 0.01)
    (marginal, _) = posterior.summary()
    of_length = 0.02 * 3 / math.sqrt(12)  # part due to the uniform correlation length
    expected = (8.0**-2 + (limit_there * math.hypot(share, of_length)) ** -2) ** -0.5
    assert marginal["posterior"]["sd"] == pytest.approx(expected, rel=0.04)


def test_tests_that_stayed_mild_or_turned_severe_bracket_as_their_likelihood_says():
    # With one unknown input Bayes' rule is a one-dimensional integral.
    tests = [
        {"normal_load": 400.0, "velocity": 2.0, "friction": 0.1, "outcome": "mild"},
        {"normal_load": 400.0, "velocity": 2.4, "friction": 0.1, "outcome": "severe"},
        {"normal_load": 400.0, "velocity": 1.5, "friction": 0.1, "outcome": "severe",
         "bulk_temperature": 343.15},
    ]  # fmt: skip
    for test in tests:
        test["velocity_scatter"] = 0.05 * test["velocity"]
    posterior = pipeline.posterior(ensemble((CRITICAL,), tests=tests))
    kelvins = np.linspace(378.0, 460.0, 4001)
    density = np.exp(-0.5 * ((kelvins - 418.15) / 8.0) ** 2)
    for test in tests:
        limit = (kelvins - test.get("bulk_temperature", 298.15)) / 0.1
        z = np.log(test["velocity"] / alone(limit, 400.0)) / 0.05
        density *= ndtr(z if test["outcome"] == "severe" else -z)
    mean = np.average(kelvins, weights=density)
    spread = math.sqrt(np.average((kelvins - mean) ** 2, weights=density))
    (critical,) = posterior.summary()
    assert critical["posterior"]["mean"] == pytest.approx(mean, abs=0.1)
    assert critical["posterior"]["sd"] == pytest.approx(spread, rel=0.03)


def stage(load, outcome, velocity=2.0, **more):
    place = {"normal_load": load, "velocity": velocity, "friction": 0.1, "outcome": outcome}
    return place | {"velocity_scatter": 0.1 * velocity} | more


def test_stages_of_a_run_are_of_one_specimen_and_tails_of_it_at_its_ends():
    # Wear turns severe between stages of run 1, after the last of run 2, in the first of run 3.
    tests = [
        *(stage(load, "mild", run="1") for load in (200.0, 300.0, 350.0)),
        stage(430.0, "severe", run="1"),
        *(stage(load, "mild", run="2") for load in (200.0, 300.0, 375.0)),
        stage(450.0, "severe", run="3", bulk_temperature=310.0),
    ]
    posterior = pipeline.posterior(ensemble((CRITICAL,), tests=tests))
    kelvins = np.linspace(360.0, 480.0, 4001)

    def z(test):
        limit = (kelvins - test.get("bulk_temperature", 298.15)) / 0.1
        return np.log(test["velocity"] / alone(limit, test["normal_load"])) / 0.1

    density = np.exp(-0.5 * ((kelvins - 418.15) / 8.0) ** 2)
    density *= ndtr(z(tests[3])) - ndtr(z(tests[2]))
    density *= ndtr(-z(tests[6])) * ndtr(z(tests[7]))
    mean = np.average(kelvins, weights=density)
    spread = math.sqrt(np.average((kelvins - mean) ** 2, weights=density))
    (critical,) = posterior.summary()
    assert critical["posterior"]["mean"] == pytest.approx(mean, abs=0.1)
    assert critical["posterior"]["sd"] == pytest.approx(spread, rel=0.03)
    assert [one.outcome for one in posterior.judged] == [
        "severe, mild up to 350 N",
        "mild",
        "severe",
    ]
    assert posterior.evidence == "3 runs"
    assert [len(one.tests) for one in posterior.judged] == [2, 1, 1]  # numbers of decisive tests


def test_many_tests_are_weighed_in_steps_to_the_same_distribution(monkeypatch):
    monkeypatch.setattr(weigh, "_ENOUGH", 1000)
    truth = np.array([420.0, 1.2e-15, 0.1, 4.5e-6])
    measured = [dict(entry, velocity_scatter=0.004) for entry in transitions(truth, 0.002)]
    sharp = pipeline.posterior(ensemble((CRITICAL, LENGTH), tests=measured))
    # The draws are new ones near the tests, not weighted draws of the prior.
    assert np.ptp(sharp.draws.inputs[:, 0]) < 0.8 * np.ptp(sharp.prior.inputs[:, 0])
    assert 0.4 < sharp.draws.effective / len(sharp.draws.weights) < 1
    many = prior(sharp.unknown, 5, 2**15)
    likelihood = np.zeros(len(many.inputs))
    for entry in measured:
        limit = (many.inputs[:, 0] - 298.15) / entry["friction"]
        there = rise(many.inputs[:, 1:], entry["normal_load"], 1.0, (LENGTH,))
        z = (
            np.log(entry["velocity"] / (limit / there) ** (1 / EXPONENT))
            * entry["velocity"]
            / 0.004
        )
        likelihood -= 0.5 * z**2
    weights = np.exp(likelihood - likelihood.max())
    mean = np.average(many.inputs[:, 0], weights=weights)
    spread = math.sqrt(np.average((many.inputs[:, 0] - mean) ** 2, weights=weights))
    critical, _ = sharp.summary()
    assert critical["posterior"]["mean"] == pytest.approx(mean, abs=0.15 * spread)
    assert critical["posterior"]["sd"] == pytest.approx(spread, rel=0.1)


EIGHT = (200.0, 250.0, 300.0, 400.0, 500.0, 600.0, 700.0, 750.0)


def test_the_scatter_is_that_of_the_tests_not_that_which_is_said():
    truth = np.array([418.15, 1.2e-15, 0.1, 4.5e-6])
    logged = transitions(truth, 0.15, seed=1, loads=EIGHT)
    low, middle, high = pipeline.posterior(ensemble(tests=logged)).inferred_scatter
    assert 0.05 < low < middle < high
    assert middle == pytest.approx(0.14, rel=0.3)


def test_a_test_that_all_others_contradict_is_named():
    truth = np.array([418.15, 1.2e-15, 0.1, 4.5e-6])
    for off in (None, 2):
        measured = transitions(truth, 0.03, seed=1, loads=EIGHT, off=off)
        posterior = pipeline.posterior(ensemble(tests=measured))
        named = [number for number, one in enumerate(posterior.judged) if one.contradicts]
        assert (named, posterior.fits) == ([] if off is None else [off], True)


WIDE = Unknown(CRITICAL.path, "uniform", (383.15, 473.15), "K")


def test_friction_that_falls_with_velocity_is_a_fault_of_the_model_and_not_of_a_test():
    measured = transitions(np.array([418.15, 1.2e-15, 0.1, 4.5e-6]), 0.03, seed=1, loads=EIGHT)
    falling = [
        dict(entry, velocity=entry["velocity"] ** 1.4)  # the effect of µ ~ V to the power -0.2
        for entry in measured
    ]
    wrong = pipeline.posterior(ensemble((WIDE, RATE, FRICTION), tests=falling))
    assert not wrong.fits
    assert wrong.draws.faults[0].startswith("the tests scatter by")
    assert min(judged.probability for judged in wrong.judged) < 0.2
    assert not any(judged.contradicts for judged in wrong.judged)
    assert wrong.as_dict()["fits"] is False
    place = 750.0, 5.5  # far on the severe side
    ds = dataset(wrong.ensemble, preset="reference")
    assert pipeline.margin(ds, *place).verdict == "severe"
    weighed = pipeline.at(ds, given_measured=True)
    told = pipeline.margin(weighed, *place)
    assert (told.verdict, told.probability > 0.95) == ("not decided", True)
    assert told.misfit == pipeline.posterior(pipeline.Ensemble.of(ds)).draws.misfit != ""
    table = {"load [N]": [750.0], "velocity [m/s]": [5.5]}
    assert pipeline.margin(weighed, table)["verdict"][0] == "not decided"
    crossings = pipeline.boundary(weighed)
    assert crossings[["mild_below", "severe_above"]].to_array().isnull().all()
    assert crossings.attrs["misfit"] == told.misfit
    assert "misfit" not in pipeline.boundary(ds).attrs
    assert content_of_samples(pipeline.results(weighed))["misfit"] == [("wear", told.misfit)]


def test_friction_by_velocity_is_known_however_it_bends():
    """Samples are of the heat alone; the friction table, with a jump by 2, is applied to it."""
    bent = Friction(by_velocity=((1.0, 1.6), (1.6, 0.7), (3.0, 1.2), (4.0, 0.5)))
    plain = ensemble((CRITICAL,))
    conditions = dataclasses.replace(plain.conditions, corrections=Corrections(friction=bent))
    factor = conditions.friction_factor(plain.sample_velocities)
    corrected = dataclasses.replace(
        plain, conditions=conditions, rises=plain.rises * factor[:, None]
    )
    velocities = np.geomspace(1.0, 5.0, 40)
    draws = np.full((1, 1), CRITICAL.parameters[0])
    own, table = (one.excess(draws, 400.0, velocities).values[0] for one in (plain, corrected))
    expected = own + np.log(conditions.friction_factor(velocities))
    assert table == pytest.approx(expected, abs=0.01)
    fine = np.geomspace(*plain.velocities, 2000)
    rising = plain.excess(draws, 400.0, fine).values[0] + np.log(conditions.friction_factor(fine))
    first = fine[np.argmax(rising > 0)]
    (test,) = pipeline.posterior(
        dataclasses.replace(corrected, tests=({"normal_load": 400.0, "velocity": first},)), 0.001
    ).judged
    assert test.critical_velocity[1] == pytest.approx(first, rel=0.01)


# Inputs that vary from part to part


def test_what_varies_from_part_to_part_is_scatter_and_is_not_learnt():
    part = dataclasses.replace(FRICTION, varies=True)
    tests = [
        {"normal_load": 400.0, "velocity": velocity, "velocity_scatter": 0.05 * velocity}
        for velocity in (2.2, 2.35, 2.5)
    ]
    critical, friction = pipeline.posterior(ensemble((CRITICAL, part), tests=tests)).summary()
    kelvins = np.linspace(370.0, 470.0, 4001)
    density = np.exp(-0.5 * ((kelvins - 418.15) / 8.0) ** 2)
    for test in tests:
        z = np.log(test["velocity"] / alone((kelvins - 298.15) / 0.1, 400.0))
        density *= np.exp(-0.5 * z**2 / (0.05**2 + (0.05 / EXPONENT) ** 2))
    mean = np.average(kelvins, weights=density)
    spread = math.sqrt(np.average((kelvins - mean) ** 2, weights=density))
    assert critical["posterior"]["mean"] == pytest.approx(mean, abs=0.3)
    assert critical["posterior"]["sd"] == pytest.approx(spread, rel=0.04)
    assert friction["posterior"]["mean"] == pytest.approx(0.1, abs=0.0003)
    assert friction["posterior"]["sd"] == pytest.approx(0.005, rel=0.06)
