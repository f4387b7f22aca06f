"""What a test to plan is worth, on a rise that is known in closed form."""

import math
import shlex
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.cli import given
from pipeline.cli.parser import parse
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.answers import draws_of, log_boundary
from pipeline.uncertain.next_tests import Candidate, candidates, ranking_command
from tests.helpers.samples import LOADS, critical_velocity, ensemble
from tests.helpers.unknowns import CRITICAL, FRICTION, RATE


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
    boundary, _ = log_boundary(
        posterior.ensemble, draws_of(posterior.ensemble, posterior.draws).inputs, LOADS
    )
    known = math.sqrt(np.mean([posterior.draws.spread(column) ** 2 for column in boundary.T]))
    best = candidates(posterior)[0]
    assert best.before == pytest.approx(known, rel=0.01)
    assert best.narrows == pytest.approx(1 - best.spread / best.before)


def test_tests_are_ranked_for_a_store_as_it_was_judged_and_weighed(monkeypatch):
    monkeypatch.setattr(given, "criterion_in", lambda _: {"criterion": "l:hot", "own_laws": True})
    typed = [
        *("sensitivity", "my rig.zarr", "--given-measured", "--scatter=8%", "--friction=0.2"),
        *("--criterion=l:hot", "--own-laws", "--at", "pin.radius=2 mm"),
        *("--bulk-temperature", "pin=60 degC, disk=25 degC"),
    ]
    words = given.judged_words(parse(typed))
    command = ranking_command("my rig.zarr", words, "temperature.critical")
    options = parse(shlex.split(command)[1:])
    assert str(options.scene) == "my rig.zarr"
    bulks = {"pin": "60 degC", "disk": "25 degC"}
    expected = {"pin.radius": "2 mm", "friction.coefficient": 0.2, "temperature.bulk": bulks}
    assert dict(options.at) == expected
    assert (options.criterion, options.own_laws) == ("l:hot", True)
    assert (options.next, options.target, options.scatter) == (1, "temperature.critical", 0.08)


def test_a_search_costs_the_runs_of_a_bisection_and_a_plan_is_made_of_single_runs():
    posterior = pipeline.posterior(ensemble((CRITICAL, FRICTION, RATE)))
    ranked = candidates(posterior)
    searches = [one for one in ranked if one.what.startswith("the transition")]
    singles = [one for one in ranked if one.what.startswith("a test")]
    # ln(12) is halved until it is as narrow as the scatter of 4 to 8 %.
    assert {one.runs for one in searches} <= {6, 7}
    assert {one.runs for one in singles} == {1}
    told = [-math.log(one.spread / one.before) / one.runs for one in ranked]
    assert told == sorted(told, reverse=True)
    assert min(one.spread for one in searches) < min(one.spread for one in singles)
    plan = pipeline.plan_tests(posterior, 4)
    assert [one.runs for one in plan] == [1, 1, 1, 1]
    assert [one.spread for one in plan] == sorted((one.spread for one in plan), reverse=True)
    before = plan[0].before
    assert before > plan[0].in_turn > plan[-1].in_turn
    assert before > plan[0].staircase > plan[-1].staircase


def test_no_run_tells_of_what_varies_from_part_to_part():
    part = replace(CRITICAL, varies=True)
    posterior = pipeline.posterior(ensemble((part, FRICTION)))
    assert max(one.narrows for one in candidates(posterior, part.path)) < 0.01
    names = [one.what.split(",")[0] for one in candidates(posterior)]
    assert part.path not in names
    assert "friction" in names
    *_, last = pipeline.plan_tests(posterior, 8)
    known = pipeline.posterior(ensemble((replace(FRICTION, parameters=(0.1, 1e-6)), part)))
    *_, least = pipeline.plan_tests(known, 1)
    assert last.spread > 0.98 * least.before  # that of the parts alone


def test_a_plan_says_where_other_rules_do_as_well():
    one = Candidate("a test", 0.01, 0.05, in_turn=0.013, staircase=0.0124)
    assert one.comparison.endswith(
        "in turn leave 30 % more, by a staircase there they do about as well"
    )
    other = Candidate("a test", 0.01, 0.05, in_turn=0.0124, staircase=0.013)
    assert other.comparison.endswith(
        "in turn do about as well, by a staircase there they leave 30 % more"
    )
    late = Candidate("a test", 0.01, 0.05, in_turn=0.03, staircase=0.0079)
    assert late.comparison.endswith(
        "in turn leave 200 % more, by a staircase there they leave 21 % less"
    )
    assert not Candidate("a test", 0.01, 0.05).comparison
