"""What a test to plan is worth, on a rise that is known in closed form."""

import math
import shlex

import numpy as np
import pytest

import pipeline
from pipeline.cli.parser import parse
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.next_tests import candidates, ranking_command
from tests.helpers.samples import CRITICAL, FRICTION, LOADS, RATE, critical_velocity, ensemble


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
    boundary, _ = log_boundary(posterior.ensemble, posterior.sweep_draws.inputs, LOADS)
    known = math.sqrt(np.mean([posterior.draws.spread(column) ** 2 for column in boundary.T]))
    best = candidates(posterior)[0]
    assert best.before == pytest.approx(known, rel=0.01)
    assert best.narrows == pytest.approx(1 - best.spread / best.before)


def test_tests_are_ranked_for_a_store_as_they_were_weighed():
    store = "my rig.zarr"
    at = {"pin.radius": "2 mm"}
    options = parse(shlex.split(ranking_command(store, 0.08, at, "temperature.critical"))[1:])
    assert str(options.scene) == store
    assert options.at == [*at.items()]
    assert (options.next, options.target, options.scatter) == (1, "temperature.critical", 0.08)
