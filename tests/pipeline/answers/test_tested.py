"""How tests change verdicts: mild and severe results, steps, pending tests, and dominance."""

import math

import numpy as np
import pytest

import pipeline
from pipeline.answers.answer_frames import boundary_frame, comparison_frame
from pipeline.answers.facts import fact_lines
from pipeline.answers.field import LineOutcome as Along
from pipeline.answers.posterior import Outcome, Prior, update
from pipeline.answers.verdict_limits import Side
from pipeline.store.schema import DONE, FAILED, PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import asked, named
from tests.helpers.entries import bare_test
from tests.pipeline.test_film import filmed
from tribo import InputError

LIMIT = synthetic.limit()
LOAD = 400.0
CRITICAL = float(synthetic.critical_velocity(LOAD, LIMIT))


def at(y, outcome="transition", **options):
    """Test at which y = ln(rise/limit) is a given number."""
    velocity = synthetic.critical_velocity(LOAD, math.exp(y) * LIMIT)
    return bare_test(LOAD, float(velocity), outcome=outcome, **options)


def swept(*tests, **options):
    plane = (200.0, 300.0, 450.0, 600.0, 750.0), (0.5, 1.0, 2.0, 3.0, 4.0)
    return synthetic.sweep(*plane, tests=tests, **options)


def chances(ds, *ys):
    """Probabilities at a load without tests, so that no test is near the points."""
    loads = np.full(len(ys), 500.0)
    limits = np.exp(ys) * LIMIT
    velocities = synthetic.critical_velocity(500.0, limits)
    return pipeline.margin(ds, loads, velocities)["probability"].values


def rows(*ends):
    """Rows of one specimen, each at a y with an outcome."""
    return [at(y, outcome, number="a") for y, outcome in ends]


OUTSIDE = bare_test(1200.0, float(synthetic.critical_velocity(1200.0, 0.9 * LIMIT)))
STEPPED = bare_test(LOAD, CRITICAL, velocity_step=CRITICAL / 5)
SPECIMENS = {  # tests, and their combined result
    "mild rows count by the highest": (rows((-0.3, "mild"), (-0.1, "mild")), Outcome(mild=-0.1)),
    "severe by the lowest": (rows((0.2, "severe"), (0.1, "severe")), Outcome(severe=0.1)),
    "both are an interval": (rows((-0.2, "mild"), (0.1, "severe")), Outcome(0.1, -0.2)),
    "inverted ones are a transition": (rows((0.2, "mild"), (0.0, "severe")), Outcome(0.0, 0.2)),
    "a transition has no width": ([at(-0.1)], Outcome(-0.1, -0.1)),
    "a step": ([STEPPED], Outcome(0.0, synthetic.VELOCITY_EXPONENT * math.log(0.8))),
    "one outside the plane": ([OUTSIDE], Outcome(math.log(0.9), math.log(0.9))),
}


@pytest.mark.parametrize("name", SPECIMENS)
def test_rows_of_one_specimen_are_one_result(name):
    tests, result = SPECIMENS[name]
    ys = np.array([-0.25, -0.05, 0.1, 0.2])
    expected = update((result,), Prior()).probability(ys)
    assert chances(swept(*tests), *ys) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    ("state", "outcome", "closed"),
    [
        (PENDING, "severe", {"mild"}),
        (PENDING, "mild", {"severe"}),
        (FAILED, "transition", {"mild", "severe"}),
    ],
)
def test_while_a_test_has_no_result_no_verdict_is_given_that_it_may_forbid(state, outcome, closed):
    ds = swept(at(0.0, outcome))
    ds = synthetic.with_tests(ds, status=state)
    margins = [asked(ds, 500.0, v) for v in (0.5, 4.0)]
    for margin, usual in zip(margins, ("mild", "severe"), strict=True):
        assert margin.verdict == ("undecided" if usual in closed else usual)
        if usual in closed:
            assert margin.reason.startswith("test 1 (")
            assert "irg run" in margin.reason
    untested = ds.assign_attrs(without_tests="yes")
    assert [asked(untested, 500.0, v).verdict for v in (0.5, 4.0)] == ["mild", "severe"]
    assert chances(ds, -0.1, 0.1) == pytest.approx(chances(untested, -0.1, 0.1))


def test_a_dataset_without_the_points_of_its_tests_says_so():
    ds = swept(at(0.0))
    lost = ds.drop_vars([name for name in ds.coords if str(name).startswith("test")])
    margin = asked(lost, 500.0, 0.5)
    assert margin.verdict == "undecided"
    assert "has not been simulated yet" in margin.reason


HELD_CASE = synthetic.scene().base.with_hold(30.0)
EASIER = {
    "load": (0.9, 1.0, {}),
    "velocity": (1.0, 0.9, {}),
    "friction": (1.0, 1.0, {"friction": 0.09}),
    "bulk": (1.0, 1.0, {"bulk_temperature": 290.0}),
}


@pytest.mark.parametrize("quantity", EASIER)
def test_no_mild_verdict_stands_against_a_severe_test_that_was_no_harder(quantity):
    """Many mild tests make easy points mild, except those that are harder than a severe test."""
    load, velocity, conditions = EASIER[quantity]
    mild = [at(-0.2, "mild", number=f"m{k}") for k in range(40)]
    severe = bare_test(300.0 * load, 0.9 * velocity, outcome="severe", **conditions)
    ds = swept(*mild, severe)
    margin = asked(ds, 300.0, 0.9)
    assert margin.probability_high <= 0.05
    assert (margin.verdict, "rules it out" in margin.reason) == ("undecided", True)
    assert asked(ds, 200.0, 0.6).verdict == "mild"
    held_test = bare_test(
        300.0 * load, 0.9 * velocity, outcome="severe", case=HELD_CASE, **conditions
    )
    assert asked(swept(*mild, held_test), 300.0, 0.9).verdict == "mild"  # its loading differs


def test_a_transition_allows_mild_wear_at_its_point_and_none_at_any_harder_one():
    mild = [at(-0.2, "mild", number=f"m{k}") for k in range(40)]
    ds = swept(*mild, bare_test(300.0, 0.9))
    assert asked(ds, 300.0, 0.9).verdict == "mild"
    harder = asked(ds, 300.0, 0.901)
    assert (harder.verdict, harder.flags) == ("undecided", {"ruled_out"})
    assert harder.reason.endswith(" rules it out")


def test_each_test_has_the_probability_that_the_tests_without_it_give_its_outcome():
    tests = (at(0.0, number="a"), at(0.12, number="b"), at(-0.1, "mild", number="c"))
    results = pipeline.compare_tests(swept(*tests))
    others = (Outcome(0.0, 0.0), Outcome(0.12, 0.12), Outcome(mild=-0.1))
    severe = [
        float(update((*others[:k], *others[k + 1 :]), Prior()).probability(np.array([y]))[0])
        for k, y in enumerate((0.0, 0.12, -0.1))
    ]
    # A transition is as far from the others on either side: the probability has two tails.
    expected = [2 * min(p, 1 - p) for p in severe[:2]] + [1 - severe[2]]
    assert results["loo_probability"].values == pytest.approx(expected, rel=1e-3)
    bracket = at(-2.0, "mild", number="d"), at(2.0, "severe", number="d")
    (*_, widest) = pipeline.compare_tests(swept(*tests, *bracket))["loo_probability"].values
    assert 0.99 < widest <= 1  # its two tails overlap
    levels = [update(others, Prior()).level(share) for share in (0.05, 0.5, 0.95)]
    assert results.attrs["levels"] == pytest.approx(levels, abs=1e-6)


def test_no_severe_verdict_stands_against_a_mild_test_that_was_no_easier():
    severe = [at(0.2, "severe", number=f"m{k}") for k in range(40)]
    mild = bare_test(700.0, 3.8, outcome="mild")
    ds = swept(*severe, mild)
    assert asked(ds, 700.0, 3.8).verdict == "undecided"
    assert asked(ds, 750.0, 4.0).verdict == "severe"


def velocities_of_verdict(ds, load, verdict):
    """Velocities at a load, every 0.1 m/s and beside two tests, that have a verdict in margins."""
    velocities = np.union1d(np.linspace(0.5, 4.0, 36), [0.74, 0.76, 3.79, 3.81])
    margins = pipeline.margin(ds, np.full(velocities.shape, load), velocities)
    return velocities[[name == verdict for name in named(margins["verdict"])]]


def test_the_boundary_is_limited_by_the_tests_that_rule_verdicts_out_in_margins():
    mild = [at(-0.2, "mild", number=f"m{k}") for k in range(40)]
    severe = bare_test(300.0, 0.75, outcome="severe", number="weak")
    ds = swept(*mild, severe)
    answer, free = pipeline.boundary(ds), pipeline.boundary(swept(*mild))
    assert (free["ruled_out_by"] == "").all()
    for load in (450.0, 600.0):
        at_load, named_text = answer.sel(load=load), answer["ruled_out_by"].sel(load=load).item()
        assert at_load["mild_velocity"] < 0.75 < free["mild_velocity"].sel(load=load)
        assert at_load["mild_velocity"].item() == pytest.approx(0.75, rel=1e-5)
        assert velocities_of_verdict(ds, load, "mild").max() == pytest.approx(0.74)
        assert named_text == "test weak (severe, 300 N, 0.75 m/s) rules out mild wear from 0.75 m/s"
    assert answer["ruled_out_by"].sel(load=200.0).item() == ""  # the test was at a higher load
    assert fact_lines(answer, "ruling").count(f"at 300 to 750 N, {named_text}") == 1


def test_a_mild_test_limits_the_velocity_from_which_the_boundary_is_severe():
    severe = [at(0.2, "severe", number=f"m{k}") for k in range(40)]
    equal = [bare_test(700.0, 3.8, outcome="mild", number=number) for number in ("strong", "later")]
    ds = swept(*severe, *equal)
    answer = pipeline.boundary(ds).sel(load=600.0)
    assert answer["severe_velocity"].item() == pytest.approx(3.8, rel=1e-5)
    assert velocities_of_verdict(ds, 600.0, "severe").min() == pytest.approx(3.81)
    expected = "test strong (mild, 700 N, 3.8 m/s) rules out severe wear up to 3.8 m/s"
    assert expected in answer["ruled_out_by"].item()


def test_a_verdict_that_is_withheld_everywhere_has_no_velocity_on_the_boundary():
    ds = synthetic.with_tests(swept(at(0.0, "severe")), status=PENDING)
    answer = pipeline.boundary(ds)
    assert np.isnan(answer["mild_velocity"]).all()
    assert (answer["mild_velocity_side"] == Side.BELOW).all()
    assert np.isfinite(answer["severe_velocity"]).any()
    (line,) = fact_lines(answer, "verdicts withheld")
    assert line.startswith("verdicts withheld: test 1 (severe, ")


def test_only_an_answer_whose_tests_count_has_a_column_with_tests():
    heading = "50 % [m/s]"
    assert heading in boundary_frame(pipeline.boundary(swept(at(-0.1))))
    for ds in (swept(), filmed(inlet=1e9)):  # without tests, and with films too thick at all tests
        columns = [*boundary_frame(pipeline.boundary(ds))]
        assert (heading in columns, "computed [m/s]" in columns) == (False, True)


def test_friction_moves_the_point_alone():
    ds, y = swept(at(-0.1), at(0.0)), np.array([-0.1, 0.0, 0.1])
    results = tuple(Outcome(y, y) for y in (-0.1, 0.0))
    assert chances(ds, *y) == pytest.approx(update(results, Prior()).probability(y), abs=1e-6)
    hotter = asked(ds, 500.0, 1.0, friction=0.1 * math.exp(0.1)).probability
    assert hotter > asked(ds, 500.0, 1.0).probability


def test_tests_of_the_scene_count_only_at_its_critical_temperature():
    """Another oil has no tests, and its answers are those of the prior, whatever the tests."""
    ds, omitted = swept(at(-0.1), at(0.0)), "the tests are left out: they hold for the critical"
    for kelvin in (363.15, 438.15, 573.15):
        margin = pipeline.margin(ds, 400.0, 2.2, critical_temperature=kelvin)
        y = math.log(synthetic.rise(400.0, 2.2, 0.9) / synthetic.limit(critical=kelvin))
        (expected,) = update((), Prior()).probability(np.array([y]))
        assert margin["probability"].item() == pytest.approx(expected, abs=1e-6)
        assert margin.attrs["tests"] == 0
        assert margin.attrs["notes"].startswith(f"{omitted} temperature of the scene, 145 °C")
        assert omitted in pipeline.boundary(ds, critical_temperature=kelvin).attrs["notes"]
        with pytest.raises(InputError, match="no tests to compare: the tests are left out"):
            pipeline.compare_tests(ds, critical_temperature=kelvin)
    both = pipeline.margin(ds, 400.0, 2.2, critical_temperature=["145 °C", "146 °C"])
    assert both.attrs["notes"].count(omitted) == 1
    scene = pipeline.margin(ds, 400.0, 2.2, critical_temperature="145 °C")
    assert scene.equals(pipeline.margin(ds, 400.0, 2.2))
    assert scene.attrs == pipeline.margin(ds, 400.0, 2.2).attrs


def test_tests_that_give_the_critical_temperature_are_left_out_under_another_one():
    mild = at(-0.3, "mild")
    ds = swept(
        at(0.0), mild, conditions=synthetic.CONDITIONS | {"critical_temperature": None},
        critical_from_tests=True,
    )  # fmt: skip
    assert pipeline.margin(ds, 400.0, 2.0).attrs["tests"] == 2
    given = pipeline.margin(ds, 400.0, 2.0, critical_temperature="145 °C")
    assert given.attrs["tests"] == 0
    assert (
        "the tests are left out: the scene infers its critical temperature from them, and another "
        "one is given"
    ) in given.attrs["notes"]


@pytest.mark.parametrize(
    "conditions", [{"critical_area_fraction": 0.2}, {"added_rise_fraction": 0.1}]
)
def test_an_area_fraction_and_an_added_rise_apply_to_tests_and_points_alike(conditions):
    """A transition at the point itself remains where it was, so severe wear stays 50 % probable."""
    ds = swept(*[bare_test(LOAD, 2.0, number=f"t{k}") for k in range(30)], model_bias=1.0)
    assert asked(ds, LOAD, 2.0).probability == pytest.approx(0.5, abs=0.03)
    assert asked(ds, LOAD, 2.0, **conditions).probability == pytest.approx(0.5, abs=0.03)


def test_bulk_temperature_and_friction_of_a_point_leave_those_of_its_tests():
    ds = swept(at(-0.1), at(0.0))
    for conditions in ({"friction": 0.12}, {"bulk_temperature": 320.0}):
        comparison = pipeline.compare_tests(ds, **conditions)
        assert comparison["log_rise_ratio"].values == pytest.approx([-0.1, 0.0], abs=1e-9)
        assert pipeline.boundary(ds, **conditions).attrs["tests"] == 2


def test_a_test_that_the_others_make_unlikely_is_named():
    tests = [at(y) for y in (0.0, 0.02, -0.02, 0.01, -0.01)]
    slip = at(-1.0, "severe", number="slip")
    (outlier,) = pipeline.boundary(swept(*tests, slip)).attrs["outliers"].split(" | ")
    assert outlier.startswith("outlier: test slip (severe, 400 N, ")
    assert outlier.endswith(" m/s), predicted from the other tests with less than 1 %")
    assert pipeline.boundary(swept(*tests)).attrs["outliers"] == ""


def test_the_boundary_of_a_scene_without_a_crossing_is_mild_with_tests_or_without():
    ds = swept(at(0.0))
    assert (pipeline.boundary(ds, friction=0.0)["outcome_along_velocity"] == Along.MILD).all()
    assert asked(ds, 400.0, 2.0, friction=0.0).probability == pytest.approx(0.0, abs=1e-12)


def test_a_table_has_the_rise_of_each_test_and_both_of_a_step_in_percent_of_the_allowable():
    step = bare_test(600.0, 3.0, velocity_step=0.5)
    ds = synthetic.sweep(tests=(bare_test(600.0, 3.0), step, bare_test(400.0, 2.0)))
    done = synthetic.with_tests(ds, status=(DONE, DONE, DONE, PENDING))
    percents = [
        f"{100 * 0.1 * float(synthetic.rise(600.0, velocity, 0.9)) / 120:.0f}"
        for velocity in (3.0, 2.5)
    ]
    table = comparison_frame(pipeline.compare_tests(done))
    rises = table["computed over allowable rise [%]"]
    assert [*rises.dropna()] == [percents[0], f"{percents[1]} to {percents[0]}"]
    assert rises.isna().to_list() == [False, False, True]


def test_a_test_is_compared_at_the_friction_that_it_measured():
    tests = [bare_test(600.0, 4.0, 0.12), bare_test(600.0, 3.0), bare_test(500.0, 2.0, 0.11)]
    comparison = pipeline.compare_tests(synthetic.sweep(tests=tests))
    temperatures = comparison["governing_temperature"].values
    for test, temperature in zip(tests, temperatures, strict=True):
        rise = float(synthetic.rise(test.normal_load, test.velocity, 0.9))
        assert temperature == pytest.approx(298.15 + (test.friction or 0.1) * rise, rel=2e-3)
