"""Margins of operating points, on a rise that is known in closed form."""

import itertools
import re

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.answers.answer_frames import margin_frame
from pipeline.answers.facts import fact_lines, facts, other_lines
from pipeline.answers.headline import headline, probability_line, to_decide
from pipeline.answers.value_text import error_of
from pipeline.store.schema import FAILED, PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import asked, named
from tests.helpers.entries import bare_test
from tribo import WarningKind

LIMIT = synthetic.limit()


def test_after_six_reasons_the_number_of_further_points_is_printed():
    loads, velocities = np.repeat(np.arange(1000.0, 1800.0, 100.0), 2), np.tile([1.0, 2.0], 8)
    answer = pipeline.margin(synthetic.sweep(), loads, velocities)
    *reasons, last = fact_lines(answer, "without a verdict")
    assert sum("is outside the sweep" in " ".join(line.split()) for line in reasons) == 6
    assert last == "without a verdict: 4 further points; see the column reason of -o TABLE.csv"


def test_a_critical_value_has_the_digits_of_its_error():
    answer = pipeline.margin(synthetic.sweep(), 400.0, 1.4)
    rise = answer["governing_temperature"] - answer["bulk_temperature"]
    relative = (answer["temperature_error"] / rise).item()
    for name, exponent in (("critical_friction", 1.0), ("critical_velocity", 0.65)):
        error = error_of(answer, name) / answer[name]
        assert error.item() == pytest.approx(relative / exponent)


def without_model_error(**options):
    return synthetic.sweep(model_bias=0.0, model_scatter=0.001, tests=(), **options)


@pytest.mark.parametrize("bulk", [298.15, 310.0])
def test_a_power_law_is_found_between_the_points_of_a_sweep(bulk):
    points = np.array([320.0, 480.0, 600.0]), np.array([2.1, 2.25, 0.6])
    conditions = {"friction": 0.2, "bulk_temperature": bulk, "critical_area_fraction": 0.05}
    margin = pipeline.margin(synthetic.sweep(), *points, **conditions)
    warm = bulk + 0.2 * synthetic.rise(*points, 0.95)
    np.testing.assert_allclose(margin["governing_temperature"], warm, rtol=1e-12)
    np.testing.assert_allclose(margin["temperature_margin"], 418.15 - warm, atol=1e-9)
    assert ((margin["probability"] > 0.5) == (warm > 418.15)).all()
    # The smallest stated error between two of four velocities, which may be curved or rough.
    error = margin["temperature_error_interpolation"]
    assert ((error > 0) & (error < 0.006 * (warm - bulk))).all()


def wavy(load, velocity, quantile=1.0):
    return synthetic.rise(load, velocity, quantile) * (1 + 0.02 * np.sin(3 * velocity + load / 90))


def test_the_error_of_interpolating_covers_most_places_of_a_bent_rise():
    ds = synthetic.sweep(rise=wavy)
    rng = np.random.default_rng(5)
    points = rng.uniform(210, 740, 40), rng.uniform(0.6, 3.9, 40)
    margin = pipeline.margin(ds, *points)
    missed = abs(margin["governing_temperature"] - 298.15 - 0.1 * wavy(*points, 0.9))
    assert (margin["temperature_error_interpolation"] < 3.0).all()
    assert (missed <= margin["temperature_error_interpolation"]).mean() > 0.85


@pytest.mark.parametrize("bend", [-0.2, -0.1, 0.1, 0.2])
def test_at_a_single_velocity_the_error_between_two_loads_covers_a_bent_rise(bend):
    def bent(load, velocity, quantile=1.0):
        return synthetic.rise(load, velocity, quantile) * np.exp(bend * np.log(load / 400.0) ** 2)

    loads = np.linspace(205.0, 745.0, 60)
    ds = synthetic.sweep((200.0, 300.0, 450.0, 750.0), (1.5,), bent, tests=())
    answer = pipeline.margin(ds, loads, 1.5)
    missed = abs(0.1 * bent(loads, 1.5, 0.9) + 298.15 - answer["governing_temperature"])
    assert (missed <= answer["temperature_error_interpolation"]).mean() > 0.95
    assert {*named(answer["verdict"])} == {"mild", "undecided"}


@pytest.mark.parametrize(("load", "velocity"), [(400.0, 2.25), (425.0, 2.1)])
@pytest.mark.parametrize(("side", "verdict"), [(1, "mild"), (-1, "severe")])
def test_a_verdict_within_the_numerical_error_is_not_decided(load, velocity, side, verdict):
    ds = without_model_error(rise=wavy)
    margin = asked(ds, load, velocity)
    for share, expected in ((0.7, "undecided"), (2.5, verdict)):
        critical = margin.governing_temperature + side * share * margin.temperature_error
        judged = asked(ds, load, velocity, critical_temperature=critical)
        assert judged.verdict == expected


def test_a_warned_point_beside_a_place_adds_its_error_and_one_without_a_size_undecides():
    ds = synthetic.sweep()
    clean = asked(ds, 425.0, 2.0)
    for kind, share in ((WarningKind.FEW_STEPS, 0.1), (WarningKind.CONTACT_AT_EDGE, None)):
        flags = xr.where((ds["load"] == 400) & (ds["velocity"] == 2.0), int(kind), 0)
        warned = ds.assign(warning_flags=flags)
        nearby, far = asked(warned, 425.0, 2.0), asked(warned, 425.0, 3.1)
        rise = nearby.governing_temperature - 298.15
        size = rise * (np.nan if share is None else share)
        # Between points, the allowance is weighted like the point that has the warning.
        assert np.isnan(size) or 0.1 * size < nearby.temperature_error_warnings < size
        assert np.isnan(nearby.temperature_error_warnings) == np.isnan(size)
        assert far.temperature_error_warnings == 0.0
    assert (clean.temperature_error_warnings, nearby.verdict) == (0.0, "undecided")


@pytest.mark.parametrize(
    ("status", "also"), [(PENDING, ()), (FAILED, ((400.0, 1.75), (450.0, 2.0)))]
)
def test_a_place_of_the_grid_that_is_not_done_has_the_error_of_interpolation(status, also):
    missing = dict.fromkeys(((400.0, 2.0), *also), status)
    partial, complete = synthetic.sweep(rise=wavy, status=missing), synthetic.sweep(rise=wavy)
    masked = complete.where((complete["load"] != 400.0) | (complete["velocity"] != 2.0))
    true = asked(complete, 400.0, 2.0)
    assert true.origin == "simulated"
    assert true.temperature_error_interpolation == 0.0
    for ds in (partial, masked.assign(status=partial["status"])):
        margin = asked(ds, 400.0, 2.0)
        off = abs(margin.governing_temperature - true.governing_temperature)
        assert margin.origin == "interpolated"
        assert 0 < off <= margin.temperature_error_interpolation


def near_the_boundary(rise=synthetic.rise):
    """Sweep that is done only near its boundary, and the complete sweep."""
    points = itertools.product(synthetic.LOADS, synthetic.VELOCITIES)
    critical = {load: synthetic.critical_velocity(load, LIMIT) for load in synthetic.LOADS}
    far = {point: PENDING for point in points if abs(np.log(point[1] / critical[point[0]])) > 0.3}
    return synthetic.sweep(rise=rise, status=far), synthetic.sweep(rise=rise)


def test_a_sweep_about_its_boundary_alone_is_continued_as_a_power_of_the_velocity():
    ds, _ = near_the_boundary()
    far, nearer = asked(ds, 425.0, 1.0), asked(ds, 425.0, 1.3)
    rise = 0.1 * synthetic.rise(425.0, 1.0, 0.9)
    assert far.governing_temperature == pytest.approx(298.15 + rise, rel=1e-9)
    errors = nearer.temperature_error_interpolation, far.temperature_error_interpolation
    assert 0 < errors[0] < errors[1] < 0.2 * rise
    assert far.verdict == "mild"


def test_between_two_loads_of_which_one_ends_earlier_a_point_is_extrapolated():
    missing = {(450.0, v): PENDING for v in synthetic.VELOCITIES.tolist() if v > 2.0}
    ds = synthetic.sweep(status=missing)
    assert asked(ds, 425.0, 3.5).origin == "extrapolated"
    assert asked(ds, 425.0, 1.6).origin == "interpolated"
    assert asked(ds, 400.0, 3.5).origin == "simulated"


def test_what_is_continued_tells_its_error():
    missed = []
    for seed in range(2):
        at = np.array([*itertools.product(synthetic.LOADS, (0.5, 0.75, 3.0, 4.0))]).T
        sweeps = near_the_boundary(synthetic.uneven(seed))
        beyond, true = (pipeline.margin(ds, *at) for ds in sweeps)
        error = beyond["temperature_error_interpolation"]
        off = (beyond["governing_temperature"] - true["governing_temperature"]) / error
        missed += off.values[named(beyond["origin"]) == "extrapolated"].tolist()
    assert len(missed) >= 20
    assert 0.2 < np.sqrt(np.mean(np.square(missed))) < 2.0  # true errors over stated ones


def test_a_fidelity_of_its_own_has_no_known_error_and_decides_nothing():
    margin = asked(synthetic.sweep(preset=None), 400.0, 0.5)
    assert np.isnan(margin.temperature_error)
    assert margin.verdict == "undecided"
    assert (margin.probability_low, margin.probability_high) == (0.0, 1.0)


def test_safety_factors_are_the_mild_limits_over_the_values_of_the_point():
    """A power law turns the factor on friction into those on velocity and load.

    Without a model error, the mild limit is below the computed boundary by the numerical error.
    """
    rng = np.random.default_rng(3)
    points = rng.uniform(320, 480, 20), rng.uniform(1.6, 2.6, 20)
    margin = pipeline.margin(without_model_error(), *points, friction=0.12)
    factors = synthetic.limit(0.12) / synthetic.rise(*points, 0.9)
    ratio = margin["friction_safety_factor"] / factors
    assert (ratio < 1).all()
    assert ratio.values == pytest.approx(1.0, abs=0.012)
    for axis, exponent in (
        ("velocity", synthetic.VELOCITY_EXPONENT),
        ("load", synthetic.LOAD_EXPONENT),
    ):
        ratio = (margin[f"{axis}_safety_factor"] / factors ** (1 / exponent)).dropna("place")
        assert len(ratio) > 5
        assert (ratio < 1).all()
        assert ratio.values == pytest.approx(1.0, abs=0.02)
    outside = pipeline.margin(synthetic.sweep(), 9000.0, 2.0)
    assert np.isnan([outside[f"{name}_safety_factor"] for name in ("friction", "velocity")]).all()


def test_a_table_states_on_which_side_of_the_sweep_a_safety_factor_lies():
    frame = margin_frame(pipeline.margin(synthetic.sweep(tests=()), [200.0, 700.0], [0.5, 3.0]))
    assert frame["load safety factor"].tolist() == ["above 3.75", "below 0.286"]  # 750, 200 N
    assert frame["velocity safety factor"][1] == "0.263"
    assert (frame["verdict"] == ["mild", "severe"]).all()


def test_columns_of_a_user_come_first_and_conditions_last_among_them():
    columns = {"friction": [0.1], "load [N]": [300.0], "velocity [m/s]": [1.0], "site": ["a"]}
    frame = margin_frame(pipeline.margin(synthetic.sweep(tests=()), columns))
    assert [*frame][:2] == ["site", "friction"]


def test_a_column_of_a_user_stays_as_typed_whatever_its_name():
    columns = {"load [N]": [300.0], "velocity [m/s]": [1.0], "height_error": ["a text"]}
    frame = margin_frame(pipeline.margin(synthetic.sweep(tests=()), columns))
    assert frame["height error"].tolist() == ["a text"]


def advice(ds, load, velocity, **conditions):
    return to_decide(pipeline.margin(ds, load, velocity, **conditions))


def test_a_test_is_advised_only_where_no_computing_decides():
    """A small model error leaves the verdict to the numerical one, a large one to tests."""
    sure, unsure = without_model_error(rise=wavy), synthetic.sweep(rise=wavy, tests=())
    margin = asked(sure, 425.0, 2.23)

    def at(error_count):
        critical = margin.governing_temperature + error_count * margin.temperature_error
        return {"critical_temperature": critical}

    middle = asked(sure, 425.0, 2.23, **at(0.05))
    assert middle.probability_low <= 0.05 < middle.probability < 0.95 <= middle.probability_high
    assert advice(sure, 425.0, 2.23, **at(0.05)).endswith(" and run a test at this point")
    assert "test" not in advice(sure, 425.0, 2.23, **at(1.1))
    for error_count in (0.05, 1.5):  # the numerical error reaches no verdict
        assert advice(unsure, 425.0, 2.23, **at(error_count)) == "run a test at this point"
    assert advice(sure, 425.0, 0.6) == advice(sure, 425.0, 4.0) == ""


@pytest.mark.parametrize(
    ("preset", "error_count", "remedy"),
    [
        ("fine", 1.3, "simulate more points nearby"),
        ("standard", 1.1, "use a finer preset"),
    ],
)
def test_the_computing_that_is_advised_decides(preset, error_count, remedy):
    """Points at the place itself remove the interpolation; the preset halves its own part."""
    ds = without_model_error(rise=wavy, preset=preset)
    margin = asked(ds, 425.0, 2.23)
    critical = margin.governing_temperature + error_count * margin.temperature_error
    side = {"critical_temperature": critical}
    assert asked(ds, 425.0, 2.23, **side).verdict == "undecided"
    assert advice(ds, 425.0, 2.23, **side) == remedy
    better = {
        "simulate more points nearby": {
            "loads": (375.0, 400.0, 425.0, 450.0), "velocities": (1.9, 2.0, 2.1, 2.23, 2.3, 2.4)
        },
        "use a finer preset": {"preset": "fine"},
    }  # fmt: skip
    assert asked(without_model_error(rise=wavy, **better[remedy]), 425.0, 2.23, **side).verdict == (
        "mild"
    )


def test_custom_settings_are_advised_a_preset_and_a_ruled_out_verdict_nothing():
    custom = synthetic.sweep(preset=None, tests=())
    assert advice(custom, 400.0, 0.5) == "use a preset, whose error is known"
    tests = tuple(bare_test(400.0, 1.2, outcome="mild", number=f"m{k}") for k in range(40))
    ruled_out = synthetic.sweep(tests=(*tests, bare_test(300.0, 0.9, outcome="severe")))
    reason = pipeline.margin(ruled_out, 300.0, 0.95)["reason"]
    assert reason.item()
    assert reason.attrs["long_name"] == "why the verdict is withheld or unknown"
    assert advice(ruled_out, 300.0, 0.95) == ""


def facts_of(ds, *point, **conditions):
    return {fact.name: fact.value for fact in facts(pipeline.margin(ds, *point, **conditions))}


def test_conditions_are_stated_unless_they_vary():
    ds = synthetic.sweep(tests=())
    for frictions, words in (([0.09], "friction 0.09, "), ([0.09, 0.1], "given for each point")):
        assert pipeline.margin(ds, 400.0, 1.5, friction=frictions).conditions.startswith(words)


def test_a_critical_value_is_stated_or_why_there_is_none():
    values = facts_of(synthetic.sweep(velocities=(1.0, 1.5, 2.0)), 200.0, 1.9)
    assert values["critical velocity"] == "none, mild over the whole sweep"
    load = re.fullmatch(r"(\d+) N", values["critical load"])[1]
    assert float(load) == pytest.approx(synthetic.critical_load(1.9, LIMIT), rel=0.01)


@pytest.mark.parametrize(
    ("point", "ending"),
    [
        ((400.0, 2.0), "simulated at this point"),
        ((425.0, 2.1), "interpolated between simulated points"),
        ((425.0, 1.0), "extrapolated beyond the simulated points by a power law in velocity"),
    ],
)
def test_a_temperature_states_its_origin(point, ending):
    ds, _ = near_the_boundary()
    assert facts_of(ds, *point)["governing temperature"].endswith(f"°C, {ending}")


def test_the_headline_states_the_verdict_the_mild_limits_and_their_factors():
    """Numbers are those of the closed form: without a model error, less the numerical error."""
    ds = without_model_error()
    at_limit = float(synthetic.critical_velocity(300.0, synthetic.limit()))
    text = headline(pipeline.margin(ds, 300.0, 1.8))
    found = re.search(r"up to (\d+) N .*, and mild up to ([\d.]+) m/s at this load", text)
    load, velocity = map(float, found.groups())
    assert 0.975 * at_limit < velocity < at_limit
    assert 0.97 < load / float(synthetic.critical_load(1.8, synthetic.limit())) < 1
    assert text.startswith("Mild at 300 N and 1.8 m/s; mild up to ")
    low = headline(pipeline.margin(ds, 300.0, 0.5))
    assert (
        "mild up to the highest simulated load, 750 N, at this velocity (factor at least 2.50)"
        in low
    )
    undecided = pipeline.margin(ds, 300.0, at_limit)
    assert headline(undecided).startswith(f"Undecided at 300 N and {at_limit:g} m/s; mild up to")
    assert headline(undecided).endswith(f"; to decide it, {to_decide(undecided)}")
    severe = headline(pipeline.margin(ds, 300.0, 4.0))
    assert severe.startswith(
        "Severe at 300 N and 4 m/s; not mild even at the lowest simulated load, 200 N, at this "
    )


def test_the_range_of_the_probability_is_stated_and_the_side_of_the_critical_temperature():
    ds = without_model_error(rise=wavy)
    answer = asked(ds, 425.0, 2.23)
    limit = {"critical_temperature": answer.governing_temperature + 0.05}
    undecided = probability_line(pipeline.margin(ds, 425.0, 2.23, **limit))
    assert re.search(r"^probability of severe wear \S+ % \(.+ to .+\), ", undecided)
    assert undecided.endswith(" K below the critical temperature")
    mild = probability_line(pipeline.margin(ds, 425.0, 0.6))
    assert mild.startswith("probability of severe wear less than 1 %, ")
    severe = probability_line(pipeline.margin(ds, 425.0, 4.0))
    assert severe.endswith(" K above the critical temperature")
    assert "-" not in severe
    custom = synthetic.sweep(preset=None)
    assert ", numerical error unknown, " in probability_line(pipeline.margin(custom, 400.0, 0.5))
    points = pipeline.margin(custom, [400.0, 500.0], [0.5, 0.6])
    assert fact_lines(points, "numerical error (95 %)") == [
        "numerical error (95 %): unknown at 2 of 2, because a part is unknown: "
        "discretization (preset)"
    ]


def test_an_unknown_error_states_which_part_is_unknown_and_those_that_are_known():
    assert facts_of(synthetic.sweep(), 425.0, 2.0)["numerical error (95 %)"].startswith("± ")
    ds = synthetic.sweep()
    flags = xr.where(
        (ds["load"] == 400) & (ds["velocity"] == 2.0), int(WarningKind.CONTACT_AT_EDGE), 0
    )
    values = facts_of(ds.assign(warning_flags=flags), 425.0, 2.1)
    assert values["numerical error (95 %)"] == (
        "unknown, because a part is unknown: allowance for warnings"
    )
    assert re.match(
        r"interpolation between points [\d.]+ K", values["parts of the numerical error"]
    )


def test_only_an_answer_beside_a_contact_at_the_edge_of_its_window_warns_of_it():
    ds = synthetic.sweep()
    flags = xr.where(
        (ds["load"] == 400) & (ds["velocity"] == 2.0), int(WarningKind.CONTACT_AT_EDGE), 0
    )
    words = "the contact reaches the edge of the window nearby; increase window.pixels"
    for dataset, velocity, count in (
        (ds.assign(warning_flags=flags), 2.1, 1),
        (ds.assign(warning_flags=flags), 3.1, 0),
        (ds, 2.1, 0),
    ):
        for loads, start in ((425.0, "warning: "), ([425.0, 426.0], "warning: at some points, ")):
            lines = fact_lines(pipeline.margin(dataset, loads, velocity), "contact")
            assert lines == [start + words] * count


def test_a_verdict_that_a_test_rules_out_states_the_reason_and_no_advice():
    tests = tuple(bare_test(400.0, 1.2, outcome="mild", number=f"m{k}") for k in range(40))
    ds = synthetic.sweep(tests=(*tests, bare_test(300.0, 0.9, outcome="severe", number="weak")))
    values = facts_of(ds, 300.0, 0.95)
    assert values["without a verdict"] == "test weak (severe, 300 N, 0.9 m/s) rules it out"
    assert "to decide" not in headline(pipeline.margin(ds, 300.0, 0.95))


def test_an_answer_states_how_many_points_were_not_used():
    ds = synthetic.sweep(status={(400.0, 2.0): PENDING, (450.0, 2.0): FAILED})
    line = "points that are pending or failed, and not used: 2"
    assert line in other_lines(pipeline.boundary(ds), ())
    assert line not in other_lines(pipeline.boundary(synthetic.sweep()), ())


def test_a_velocity_of_0_in_a_sweep_changes_no_answer_from_the_lowest_moving_one_on():
    tests = bare_test(600.0, 1.5), bare_test(400.0, 1.2, outcome="severe")
    moving, rest = (
        synthetic.sweep(velocities=v, tests=tests, preset="standard")
        for v in ((1.0, 1.6, 2.5), (0.0, 1.0, 1.6, 2.5))
    )
    at = np.repeat([200.0, 310.0, 600.0], 3), np.tile([1.0, 1.3, 2.5], 3)
    xr.testing.assert_identical(*(pipeline.margin(ds, *at) for ds in (moving, rest)))
    both = [pipeline.boundary(ds).drop_attrs() for ds in (moving, rest)]
    xr.testing.assert_identical(*both)
