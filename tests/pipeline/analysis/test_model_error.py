"""The model's own error (pipeline/analysis/model_error.py), and what a verdict makes of it."""

import math

import numpy as np
import pytest
from scipy import integrate, stats

import pipeline
from pipeline.analysis.field import point_field
from pipeline.analysis.laboratory import (
    NOT_KNOWN,
    compared,
    model_error,
)
from pipeline.analysis.model_error import ModelError
from pipeline.sweep.measurement import Measurement
from tests.helpers import synthetic

EXPONENT = synthetic.VELOCITY_EXPONENT


def density(x, degrees, scale):
    """Density of Student's t distribution, by its formula."""
    factor = math.gamma((degrees + 1) / 2) / math.gamma(degrees / 2)
    factor /= math.sqrt(degrees * math.pi) * scale
    return factor * (1 + (x / scale) ** 2 / degrees) ** (-(degrees + 1) / 2)


def chance_below(x, degrees, scale):
    return integrate.quad(density, -math.inf, x, (degrees, scale), epsabs=1e-12, limit=200)[0]


def swept_with(*tests):
    """Sweep of a power law with tests (load, velocity, outcome); None is a measured transition."""
    made = [Measurement(load, velocity, outcome=outcome) for load, velocity, outcome in tests]
    return synthetic.sweep(
        measured=tuple(one for one in made if not one.outcome),
        tested=tuple(one for one in made if one.outcome),
    )


def scatter_of(ds):
    return model_error(pipeline.results(ds), point_field(pipeline.results(ds)))


def counted(ds):
    """ln(measured/computed) of the transitions and wrong outcomes that count."""
    found = scatter_of(ds)
    return [*found.residuals, *found.wrong]


CRITICAL = float(synthetic.critical_velocity(600.0, synthetic.limit()))


@pytest.mark.parametrize("residuals", [(), (0.2,), (0.01, -0.02, 0.3, 0.0, -0.1)])
def test_the_error_of_the_next_run_is_students_t_of_few_tests_and_ten_percent(residuals):
    degrees = 4 + len(residuals)
    scale = math.sqrt((4 * 0.10**2 + sum(r * r for r in residuals)) / degrees)
    places = np.array([-0.4, -0.1, 0.0, 0.05, 0.3])
    expected = [chance_below(x, degrees, scale) for x in places]
    np.testing.assert_allclose(ModelError(residuals).below(places), expected, atol=1e-9)


@pytest.mark.parametrize("ratio", [0.5, 0.8, 0.97, 1.2, 2.0])
def test_a_probability_is_that_of_a_run_beyond_the_transition(ratio):
    ds, velocity = swept_with(), ratio * CRITICAL
    found = pipeline.margin(ds, 600.0, velocity)
    error = math.log1p(found.temperature_error / (found.decisive_temperature - 298.15))
    assert error > 0.003
    ends = {"lowest": -error, "probability": 0.0, "highest": error}
    for name, shift in ends.items():
        critical = CRITICAL * math.exp(-shift / EXPONENT)
        expected = 1 - chance_below(math.log(critical / velocity), 4, 0.10)
        assert getattr(found, name) == pytest.approx(expected, abs=1e-6)


def test_without_tests_and_with_them_the_answer_says_what_its_own_error_rests_on():
    untested = pipeline.margin(swept_with(), 600.0, 1.0)
    assert untested.model_error == "± 10 % in velocity, assumed; no test confirms or contradicts it"
    one = swept_with((600.0, 1.3 * CRITICAL, None))
    scale = math.sqrt((4 * 0.01 + math.log(1.3) ** 2) / 5)
    said = pipeline.margin(one, 600.0, 1.0).model_error
    assert said == f"± {100 * scale:.2g} % in velocity, from 1 test and a prior of 10 %"
    right = swept_with((600.0, 0.8 * CRITICAL, "mild"))
    said = pipeline.margin(right, 600.0, 1.0).model_error
    assert said == "± 10 % in velocity, assumed; no test contradicts it"
    wrong = swept_with((600.0, 0.6 * CRITICAL, "severe"))
    scale = math.sqrt((4 * 0.01 + math.log(0.6) ** 2) / 5)
    said = pipeline.margin(wrong, 600.0, 1.0).model_error
    assert said == f"−{100 * scale:.2g} to +10 % in velocity, from 1 test and a prior of 10 %"
    own = synthetic.sweep(measured=(), model_scatter=0.03)
    assert scatter_of(own).scales == pytest.approx((0.03, 0.03))
    none = pipeline.margin(synthetic.sweep(measured=(), model_scatter=0.0), 600.0, 1.0)
    assert (none.model_error, none.probability) == ("none, as the scene says", 0.0)


def test_a_wrong_outcome_counts_with_its_distance_and_a_right_one_does_not():
    right = (600.0, 0.7 * CRITICAL, "mild"), (600.0, 1.4 * CRITICAL, "severe")
    wrong = (600.0, 0.8 * CRITICAL, "severe"), (600.0, 1.1 * CRITICAL, "mild")
    assert counted(swept_with(*right)) == []
    expected = [math.log(0.8), math.log(1.1)]
    assert counted(swept_with(*right, *wrong)) == pytest.approx(expected)
    scales = scatter_of(swept_with(*right, *wrong)).scales
    assert scales == pytest.approx((math.sqrt((0.04 + math.log(0.8) ** 2) / 5), 0.1))


def test_a_transition_counts_at_its_own_conditions():
    warm = Measurement(600.0, 1.2, 0.12, bulk_temperature=310.0)
    ds = pipeline.at(synthetic.sweep(measured=(warm,)), friction=0.05)
    critical = synthetic.critical_velocity(600.0, synthetic.limit(0.12, 310.0))
    assert scatter_of(ds).residuals == pytest.approx([math.log(1.2 / critical)])


def beyond(load, velocity, **at):
    """ln(measured/computed) of a test whose computed velocity is outside the sweep."""
    limit = synthetic.limit(critical=at["critical_temperature"])
    return math.log(velocity / float(synthetic.critical_velocity(load, limit)))


MILD, SEVERE = (
    {"critical_temperature": 1200.0},
    {"critical_temperature": 310.0},
)  # mild or severe at every velocity


@pytest.mark.parametrize(
    ("everywhere", "velocity", "outcome", "is_wrong"),
    [
        (MILD, 5.0, "severe", False),
        (MILD, 5.0, "mild", False),  # the test agrees
        (MILD, 0.1, "severe", True),
        (MILD, 5.0, None, False),
        (MILD, 0.1, None, True),
        (SEVERE, 0.1, "mild", False),
        (SEVERE, 0.1, "severe", False),  # the test agrees
        (SEVERE, 5.0, "mild", True),
        (SEVERE, 0.1, None, False),
        (SEVERE, 5.0, None, True),
    ],
)
def test_a_test_that_velocities_beyond_the_computed_ones_may_make_right_does_not_count(
    everywhere, velocity, outcome, is_wrong
):
    ds = pipeline.at(swept_with((600.0, velocity, outcome)), **everywhere)
    expected = [beyond(600.0, velocity, **everywhere)] if is_wrong else []
    assert counted(ds) == pytest.approx(expected)
    assert scatter_of(ds).residuals == ()  # a transition out of range must not narrow the error
    told = "yes" if outcome == ("mild" if everywhere is MILD else "severe") else NOT_KNOWN
    assert compared(pipeline.results(ds))["agrees"].to_list() == ["no" if is_wrong else told]


@pytest.mark.parametrize("velocity", [0.6, 1.0, 1.2, 1.6, 2.2, 2.6, 3.5])
def test_of_a_band_of_severe_wear_the_runs_within_it_are_counted(velocity):
    ds = synthetic.sweep(rise=synthetic.falling, measured=(), preset="reference")
    found = pipeline.margin(ds, 400.0, velocity)
    runs = velocity * np.exp(0.10 * stats.t(4).ppf((np.arange(20000) + 0.5) / 20000))
    share = np.mean(synthetic.falling(400.0, runs, 0.9) > synthetic.limit())
    assert found.probability == pytest.approx(share, abs=4e-3)
    assert found.lowest <= found.probability <= found.highest
    assert found.critical_velocity == pytest.approx(1.1, rel=2e-3)
    assert found.velocity_outcome == "severe from 1.1 to 2.4 m/s"


@pytest.mark.parametrize(
    ("tests", "residual"),
    [
        ([(2.3, None, None)], math.log(2.3 / 1.1)),  # not with 2.4 m/s, where wear turns mild
        ([(2.3, "mild", None)], math.log(2.3 / 2.4)),
        ([(1.05, "severe", "a"), (2.0, "severe", "a")], math.log(1.05 / 1.1)),
        ([(2.7, "mild", "a"), (3.5, "severe", "a")], math.log(3.5 / 2.4)),
    ],
)
def test_a_transition_is_measured_against_a_turn_to_severe_wear(tests, residual):
    tested = tuple(
        Measurement(400.0, velocity, None, outcome=outcome, run=run)
        for velocity, outcome, run in tests
    )
    ds = synthetic.sweep(rise=synthetic.falling, measured=(), tested=tested, preset="reference")
    assert counted(ds) == pytest.approx([residual], abs=5e-3)


def test_a_test_beside_a_place_is_named_with_its_conditions():
    own = {"friction": 0.14, "bulk_temperature": 330.0}
    tests = Measurement(600.0, 1.5, outcome="mild"), Measurement(600.0, 1.5, outcome="mild", **own)
    ds = synthetic.sweep(measured=(), tested=tests)
    said = "mild, 600 N, 1.5 m/s"
    usual = " at friction 0.1 and bulk 25 °C"
    other = " at friction 0.14 and bulk 56.9 °C"
    assert pipeline.margin(ds, 600.0, 1.5).tested == (said + usual, said + other)
    cool = pipeline.at(ds, critical_temperature=320.0)  # below the bulk temperature of one test
    assert pipeline.margin(cool, 600.0, 1.5).tested == (said + usual,)


def test_a_transition_is_compared_with_a_turn_within_the_sweep_rather_than_with_one_beyond():
    def dipping(load, velocity, quantile=1.0):
        return synthetic.rise(load, velocity, quantile) * np.where(velocity < 3.0, 1.0, 0.6)

    ds = synthetic.sweep(rise=dipping, measured=(Measurement(400.0, 5.0),), tested=())
    turns = pipeline.boundary(ds).sel(load=400.0)["turns_at_load"].dropna("turn").values
    assert len(turns) == 2  # severe between them, and again beyond the sweep
    scale = math.sqrt((4 * 0.1**2 + math.log(5.0 / turns[0]) ** 2) / 5)
    said = pipeline.margin(ds, 400.0, 1.0).model_error
    assert said == f"± {100 * scale:.2g} % in velocity, from 1 test and a prior of 10 %"
