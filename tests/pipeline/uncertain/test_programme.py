"""Tests until a target is known well enough, on a rise that is known in closed form."""

import math

import numpy as np
import pytest

import pipeline
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.next_tests import candidates, programme
from tests.helpers.samples import CRITICAL, FRICTION, LOADS, RATE, critical_velocity, ensemble
from tribo import InputError

IDLE = {"normal_load": 200.0, "velocity": 0.5, "outcome": "mild"}  # which tells nothing


def test_a_programme_ends_where_its_goal_is_reached():
    posterior = pipeline.posterior(ensemble((CRITICAL,), tests=[IDLE]))
    planned = programme(posterior, 4.0, CRITICAL.path, ["25 degC"])
    *before, last = planned.tests
    assert planned.is_reached
    assert planned.others == ()
    assert last.spread <= 4.0 < min(test.spread for test in before)
    same = pipeline.plan_tests(posterior, len(planned.tests), CRITICAL.path, ["25 degC"])
    assert [test.spread for test in same] == [test.spread for test in planned.tests]
    assert last.narrows == pytest.approx(1 - last.spread / planned.before)


def test_where_tests_no_longer_help_what_does_is_named():
    """Without friction in the log all tests share one that they cannot tell from the oil."""
    posterior = pipeline.posterior(ensemble((CRITICAL, FRICTION), tests=[IDLE]))
    planned = programme(posterior, 0.5, CRITICAL.path, ["25 degC"])
    assert planned.is_stuck
    assert not planned.is_reached
    assert len(planned.tests) < 20
    best = planned.others[0]
    assert best.what.startswith("friction")
    assert best.spread < 0.8 * planned.tests[-1].spread
    with pytest.raises(InputError, match="until is 0; give a spread above 0"):
        programme(posterior, 0.0)


def test_what_is_sought_is_no_measurement_of_itself():
    posterior = pipeline.posterior(ensemble((CRITICAL, FRICTION)))
    for target in (CRITICAL.path, FRICTION.path):
        names = [one.what.split(",")[0] for one in candidates(posterior, target)]
        assert ("temperature.critical" in names) == (target != CRITICAL.path)
        assert ("friction" in names) == (target != FRICTION.path)


def test_what_is_known_of_a_boundary_today_is_the_spread_of_its_draws():
    """Also where tests leave inputs wide that they cannot tell apart, over which it is curved."""
    critical = Unknown(CRITICAL.path, "uniform", (343.15, 493.15), "K")
    rate = Unknown(RATE.path, "log-normal", (1.2e-15, 40.0), "m2 N-1")
    truth = np.array([[418.15, 1.2e-15, 0.1, 4.5e-6]])
    tests = [
        {"normal_load": load, "velocity": float(critical_velocity(truth, load)[0])}
        for load in LOADS.tolist()
    ]
    posterior = pipeline.posterior(ensemble((critical, rate), tests=tests))
    boundary, _ = log_boundary(posterior.ensemble, posterior.of_sweep(0).inputs, LOADS)
    known = math.sqrt(np.mean([posterior.draws.spread(column) ** 2 for column in boundary.T]))
    assert programme(posterior, 1.0).before == pytest.approx(known, rel=0.01)
