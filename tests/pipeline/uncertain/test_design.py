"""The value of an input that makes severe wear unlikely, on a rise known in closed form."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.analysis.model_error import ModelError
from pipeline.scene.along import Place
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.unknown import Fixed, Unknown, drawn
from pipeline.uncertain import answer_design, design
from pipeline.uncertain.answers import run_probability
from pipeline.uncertain.design import Chances, Direct, Goal
from pipeline.uncertain.direct import log_rise
from pipeline.uncertain.ensemble import Excess
from pipeline.uncertain.inputs import BULK, prior
from tests.helpers.samples import EXPONENT, ensemble, rise
from tests.helpers.unknowns import CRITICAL, FRICTION, LENGTH, RATE
from tribo import InputError

WIDE = Unknown(CRITICAL.path, "uniform", (383.15, 473.15), "K")
UNKNOWN = (WIDE, RATE, FRICTION, LENGTH)
HERE = Place(400.0, 1.6)
CERTAIN = {"scatter": ModelError(usual=0.0)}
"""Runs that do not scatter."""


@pytest.fixture(scope="module")
def samples():
    return ensemble(UNKNOWN)


def hottest(place, share):
    """Temperature of the contact that a share of direct draws stays below [K]."""
    direct = drawn(UNKNOWN, 99, 2**15)
    return 298.15 + np.quantile(direct[:, 2] * rise(direct, *place, UNKNOWN), share)


@pytest.mark.parametrize("risk", [0.3, 0.01])
def test_the_limit_is_where_direct_draws_have_the_risk(samples, risk):
    limit = pipeline.design(samples, Goal((HERE,), risk), WIDE.path, **CERTAIN)
    assert limit.side == "at least"
    assert limit.value == pytest.approx(hottest(HERE, 1 - risk), abs=1.5)
    assert limit.interval[0] < limit.value < limit.interval[1]
    assert limit.safe == (limit.value, limit.values[-1])
    assert limit.as_dict()["limit"]["unit"] == "K"


def test_tests_that_contradict_the_model_leave_a_design_undecided(samples):
    draws = replace(prior(UNKNOWN, 5), faults=("the tests scatter by 40 %",))
    limit = pipeline.design(samples, Goal((HERE,), 0.3), WIDE.path, draws, **CERTAIN)
    told = limit.as_dict()
    assert (told["side"], told["limit"], told["safe"]) == ("not decided", None, None)
    said = answer_design._word_limit(limit)
    assert said.startswith("temperature.critical is not decided for a risk of 30 % at 400 N")
    assert said.endswith("the tests contradict the model")
    free = pipeline.design(samples, Goal((HERE,), 0.3), WIDE.path, prior(UNKNOWN, 5), **CERTAIN)
    assert free.value is not None


@pytest.mark.parametrize(("usual", "between"), [(0.1, 0.0), (0.1, 0.08), (0.0, 0.08)])
def test_a_run_scatters_about_the_model_and_so_does_its_friction(samples, usual, between):
    goal, scatter = Goal((HERE,), 0.1), ModelError(usual=usual)
    run = {"scatter": scatter, "friction_scatter": between}
    limit = pipeline.design(samples, goal, WIDE.path, **run)
    chance, direct = np.random.default_rng(5), drawn(UNKNOWN, 99, 2**17)
    off = usual * chance.standard_t(4, len(direct))
    friction = direct[:, 2] * np.exp(between * chance.standard_normal(len(direct)))
    run_rises = (
        friction
        * rise(direct, HERE.load, HERE.velocity, UNKNOWN)
        * (rise(direct[:1], HERE.load, 2.0, UNKNOWN) / rise(direct[:1], HERE.load, 1.0, UNKNOWN))
        ** (off / np.log(2.0))
    )
    assert limit.value == pytest.approx(298.15 + np.quantile(run_rises, 0.9), abs=2.0)
    usually = pipeline.design(samples, goal, WIDE.path)
    if between == 0.0:
        assert limit.value == usually.value


@pytest.mark.parametrize(("usual", "error"), [(0.1, 0.05), (0.1, 0.1), (0.03, 0.1), (0.01, 0.05)])
def test_the_error_of_a_draw_and_the_scatter_of_a_run_add_up(usual, error):
    values, slope = np.linspace(-0.6, 0.6, 25), np.full(25, 0.6)
    z = np.linspace(-8.0, 8.0, 4001)
    weights = np.exp(-0.5 * z**2) / np.exp(-0.5 * z**2).sum()
    scatter = ModelError(usual=usual)
    expected = [weights @ scatter.below((one + error * z) / 0.6) for one in values]
    errors = np.full(25, error)
    found, _ = run_probability(Excess(values, errors, errors), scatter, slope)
    np.testing.assert_allclose(found, expected, atol=6e-4)


def simulated_rise(entries, load, velocity, judged):
    row = np.zeros(len(UNKNOWN))
    for number in (1, 3):  # what the rise at friction 1 depends on
        text, one = entries[UNKNOWN[number].path], UNKNOWN[number]
        row[number] = float(text.split()[0]) / one.shown.express(1.0)
    return np.log(rise(row[None], load, velocity, UNKNOWN)[0])


def true_risk(critical, usual):
    """Probability of a severe run, by many draws of the rise as it is."""
    direct = drawn(UNKNOWN, 99, 2**15)
    excess = np.log(direct[:, 2] * rise(direct, *HERE, UNKNOWN) / (critical - 298.15))
    return float(np.mean(ModelError(usual=usual).below(excess / EXPONENT)))


def test_direct_simulations_correct_samples_that_tell_too_little(samples, monkeypatch):
    monkeypatch.setattr(design, "log_rise", simulated_rise)
    low, goal = replace(samples, rises=0.96 * samples.rises, keeper=None), Goal((HERE,), 0.01)
    chances = Chances(low, goal, **CERTAIN)
    limit = chances.limit(WIDE.path)
    found = chances.simulated(limit, dict)
    assert found.shift == pytest.approx(-np.log(0.96), abs=3e-3)
    assert found.probability > 0.015
    assert not found.confirms(0.01)
    corrected = replace(chances, shift=found.shift)
    limit = corrected.limit(WIDE.path)
    assert limit.value == pytest.approx(hottest(HERE, 0.99), abs=1.5)
    again = corrected.simulated(limit, dict, seed=1)
    assert again.shift == pytest.approx(found.shift, abs=3e-3)
    assert again.probability == pytest.approx(0.01, abs=4 * again.error)
    safer = replace(corrected, spare=again.spare).limit(WIDE.path)
    assert safer.value > limit.value
    assert corrected.simulated(safer, dict, seed=2).confirms(0.01)


def test_direct_simulations_are_judged_as_the_samples_are(monkeypatch):
    columns = {
        "rise_quantile": np.linspace(100.0, 1000.0, len(tribo.QUANTILES))[None],
        "max_rise": np.array([1000.0]),
        "mean_rise": np.array([500.0]),
        "normal_load": np.array([600.0]),
    }
    result = SimpleNamespace(columns=columns)
    monkeypatch.setattr("pipeline.uncertain.direct.run_point", lambda *_: result)
    scene, seen = pipeline.load_scene("first_try"), []
    highest = replace(scene.conditions, criterion="highest")
    assert log_rise(scene, 600.0, 1.5, highest) == pytest.approx(np.log(1000.0))

    def simulated(entries, load, velocity, judged):
        seen.append(judged)
        return simulated_rise(entries, load, velocity, judged)

    monkeypatch.setattr(design, "log_rise", simulated)
    few = ensemble(UNKNOWN, count=16)
    mean = replace(few.conditions, criterion="mean", failing_share=0.3)
    chances = Chances(replace(few, conditions=mean, keeper=None), Goal((HERE,), 0.1), **CERTAIN)
    chances.simulated(chances.limit(WIDE.path), dict)
    assert {(one.criterion, one.failing_share) for one in seen} == {("mean", 0.3)}


@pytest.mark.parametrize("usual", [0.0, 0.1])
def test_the_stated_error_of_90_simulations_holds(samples, monkeypatch, usual):
    monkeypatch.setattr(design, "log_rise", simulated_rise)
    low = replace(samples, rises=0.98 * samples.rises, keeper=None)
    chances = Chances(low, Goal((HERE,), 0.02), scatter=ModelError(usual=usual))
    limit = chances.limit(WIDE.path)
    truth = true_risk(limit.value, usual or 1e-6)
    found = [chances.simulated(limit, dict, seed) for seed in range(8)]
    assert all(one.simulated <= design.SIMULATED for one in found)
    off = np.array([(one.probability - truth) / one.error for one in found])
    # The mean square of 8 scores lies below 2.7 with 99.5 %.
    assert np.mean(off**2) < 2.7
    if usual:
        assert max(one.error for one in found) < 0.0012


def test_only_a_probability_that_keeps_the_risk_by_its_error_confirms_it():
    found = Direct(0.0144, 0.0023, 2048, 90, 0.0)
    assert not found.confirms(0.01)
    assert not replace(found, probability=0.0099).confirms(0.01)
    assert replace(found, probability=0.01 - 1.645 * 0.0023).confirms(0.01)


def test_the_error_of_the_preset_moves_the_limit(samples):
    goal, rough = Goal((HERE,), 0.05), replace(samples, velocity_error=0.08)
    exact, safer = (pipeline.design(one, goal, WIDE.path).value for one in (samples, rough))
    # Its rises may err by 0.6 of that.
    assert (safer - 298.15) / (exact - 298.15) == pytest.approx(1.048, abs=1e-3)


@pytest.mark.parametrize(
    ("path", "side"), [("load", "at most"), ("velocity", "at most"), (FRICTION.path, "at most"),
                       (BULK, "at most"), (CRITICAL.path, "at least")],
)  # fmt: skip
def test_place_and_conditions_are_sought_like_inputs_and_need_no_range(path, side):
    known = ensemble((RATE, LENGTH))  # neither friction nor a temperature is unknown
    limit = pipeline.design(known, Goal((HERE,), 0.1), path, **CERTAIN)
    assert limit.side == side
    assert limit.probabilities[0 if side == "at least" else -1] > 0.9
    values = {"load": HERE.load, "velocity": HERE.velocity, FRICTION.path: 0.1, BULK: 298.15}
    values |= {CRITICAL.path: 418.15, path: limit.value}
    direct = drawn((RATE, LENGTH), 99, 2**15)
    rises = rise(direct, values["load"], values["velocity"], (RATE, LENGTH))
    hot = values[BULK] + values[FRICTION.path] * rises
    assert np.mean(hot > values[CRITICAL.path]) == pytest.approx(0.1, abs=0.03)
    is_place = path in ("load", "velocity")
    assert limit.binding == (HERE._replace(**{path: limit.value}) if is_place else HERE)


def test_the_critical_temperature_is_sought_where_none_is_known():
    known = replace(ensemble((RATE, LENGTH)), conditions=Conditions(0.1, 298.15, None))
    limit = pipeline.design(known, Goal((HERE,), 0.1), CRITICAL.path, **CERTAIN)
    direct = drawn((RATE, LENGTH), 99, 2**15)
    hot = 298.15 + 0.1 * rise(direct, *HERE, (RATE, LENGTH))
    assert limit.value == pytest.approx(np.quantile(hot, 0.9), abs=1.0)


def test_a_load_is_sought_at_values_of_the_velocity(samples):
    nowhere = Goal((Place(math.nan, math.nan),), 0.05)
    slow, fast = (
        pipeline.design(samples, nowhere, "load", at={"velocity": velocity}, **CERTAIN)
        for velocity in (1.5, 1.6)
    )
    # Rises are powers of both.
    assert slow.value / fast.value == pytest.approx((1.6 / 1.5) ** (EXPONENT / 0.58), rel=0.02)
    assert fast.binding == Place(fast.value, 1.6)


def test_of_several_points_the_worst_one_binds_and_a_margin_asks_for_that_much_more(samples):
    duty = (Place(200.0, 1.0), HERE)
    limit = pipeline.design(samples, Goal(duty, 0.3), WIDE.path, **CERTAIN)
    assert limit.binding == HERE
    assert limit.value == pytest.approx(hottest(HERE, 0.7), abs=1.5)
    with_margin = pipeline.design(samples, Goal(duty, 0.3, margin=20.0), WIDE.path, **CERTAIN)
    assert with_margin.value - limit.value == pytest.approx(20.0, abs=0.2)


def test_an_input_that_is_not_enough_says_what_it_reaches(samples):
    none = pipeline.design(samples, Goal((Place(750.0, 5.0),), 0.01), LENGTH.path, **CERTAIN)
    assert (none.side, none.value, none.safe) == ("none", None, None)
    assert none.best[0] == 3e-6  # where the rise is least
    assert none.best[1] == min(none.probabilities)


def test_a_second_entry_moves_the_limit_of_the_first(samples):
    low, high = (
        pipeline.design(
            samples, Goal((HERE,), 0.05), WIDE.path, at={LENGTH.path: length}, **CERTAIN
        ).value
        for length in (3e-6, 6e-6)
    )
    # The rise is 6 % higher.
    assert (high - 298.15) / (low - 298.15) == pytest.approx(1.03 / 0.97, rel=0.01)


def test_an_entry_that_no_design_can_move_is_refused(samples):
    goal = Goal((HERE,), 0.05)
    with pytest.raises(InputError, match=r"specific_wear_rate is log-normal, .* needs a range"):
        pipeline.design(samples, goal, RATE.path)
    fixed = replace(samples, unknown=(WIDE, RATE, FRICTION), fixed=(Fixed(LENGTH, 4e-6),))
    with pytest.raises(InputError, match=r"correlation_length is fixed at 4e-06 m; leave that out"):
        pipeline.design(fixed, goal, LENGTH.path, **CERTAIN)


def test_an_input_that_raises_the_risk_has_a_highest_value(samples):
    direct = drawn(UNKNOWN, 99, 2**15)
    direct[:, 3] = 4.6e-6  # between two of the values that are tried
    warm = 298.15 + np.quantile(direct[:, 2] * rise(direct, *HERE, UNKNOWN), 0.7)
    limit = pipeline.design(
        samples, Goal((HERE,), 0.3), LENGTH.path, at={WIDE.path: warm}, **CERTAIN
    )
    assert limit.side == "at most"
    assert limit.value == pytest.approx(4.6e-6, abs=0.05e-6)
    assert limit.safe == (3e-6, limit.value)
    assert limit.best[0] == 3e-6


def test_draws_are_simulated_also_where_the_number_of_samples_was_given_by_set(monkeypatch):
    settings = {"sweep.samples": 8, "unknown": {CRITICAL.path: {"mean": "140 degC", "sd": "9 K"}}}
    stored = pipeline.load_scene("uncertain", overrides=settings)
    assert any("sweep.samples" in word for word in stored.about.arguments)
    monkeypatch.setattr(answer_design, "scene_sweep", lambda _: stored)
    monkeypatch.setattr(answer_design, "taken_at", lambda _: ())
    alone = answer_design.read_scene(None)({CRITICAL.path: "150 degC"})
    assert alone.conditions.critical_temperature == pytest.approx(423.15)
    assert not alone.variants.unknown


def test_draws_are_simulated_at_the_values_of_entries_that_the_samples_were_taken_at(monkeypatch):
    settings = {"sweep.samples": 8, "unknown": {CRITICAL.path: {"mean": "140 degC", "sd": "9 K"}}}
    over = {"sweep.over": {"wear.pattern": ["swept", "local"]}}
    stored = pipeline.load_scene("uncertain", overrides=settings | over)
    monkeypatch.setattr(answer_design, "scene_sweep", lambda _: stored)
    monkeypatch.setattr(answer_design, "taken_at", lambda _: (("wear.pattern", "local"),))
    alone = answer_design.read_scene(None)({CRITICAL.path: "150 degC"})
    assert alone.scene.wear.pattern == "local"
