"""Sensitivities to inputs, and what uncertain inputs make of answers, on a small scene."""

import functools
import json
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.answers.headline import to_decide
from pipeline.answers.input_errors import input_name
from pipeline.answers.sensitivity_answer import sensitivity_lines
from pipeline.figures.style import texts_of
from pipeline.run.boundary_variants import missing_variants
from pipeline.scene.variants import variants_of
from pipeline.store.store import opened
from tests.helpers.kept import assert_as_kept, variables

SMALL = {
    "without": ["tests"],
    "window.pixels": [96, 48],
    "window.pixel_size": ["5 um", "5 um"],
    "disk.roughness.correlation_length": "12 um",
    "sweep.loads": ["200 N", "400 N", "750 N"],
    "sweep.velocities": {"from": "1 m/s", "to": "4 m/s", "count": 3},
}
OPTIONS = [
    *(f"--set={key}={json.dumps(value)}" for key, value in SMALL.items() if "veloc" not in key),
    '--set=sweep.velocities={ from = "1 m/s", to = "4 m/s", count = 3 }',
]
"""The same as options of a command."""
CONDUCTIVITY = "materials.steel.thermal_conductivity"
WEAR = "wear.specific_wear_rate"
AT = "400 N", "2 m/s"
NAMED = (
    "pin.crown_radius", "oil.kinematic_viscosity", "loading.stages", "motion.slide_roll_ratio",
    "temperature.bulk", "disk.roughness.rsm", "disk.roughness.height_unit", "materials.a.density",
)  # fmt: skip


def load(**uncertainty):
    entries = {"uncertainty": uncertainty} if uncertainty else {}
    return pipeline.load_scene("first_try", overrides=SMALL | entries)


@pytest.fixture(scope="module")
def study_store(tmp_path_factory):
    return tmp_path_factory.mktemp("sensitivity") / "inputs.zarr"


@pytest.fixture(scope="module")
def study(study_store):
    return pipeline.sensitivity(load(), *AT, study_store, workers=1)


def sensitivity_to(study, path):
    return study["sensitivity"].sel(input=path).item()


def test_conductivity_and_heat_capacity_scale_the_rise_as_the_dimensions_demand(study):
    # At a given contact, the rise is g(v ρ c/k)/k; the contact does not depend on k, ρ and c.
    density = sensitivity_to(study, "materials.steel.density")
    assert sensitivity_to(study, CONDUCTIVITY) + density == pytest.approx(-1, abs=0.001)
    assert density == pytest.approx(
        sensitivity_to(study, "materials.steel.specific_heat"), abs=1e-9
    )


def test_wear_and_loading_rate_act_by_their_ratio(study):
    # The contact depends on the wear rate times the sliding distance, which is v F/rate. A longer
    # ramp heats the same contact for longer, which is the rest of some 0.002.
    rate = sensitivity_to(study, "loading.rate")
    assert rate == pytest.approx(-sensitivity_to(study, WEAR), abs=0.003)
    assert rate > 0.01


def test_friction_and_temperatures_act_in_closed_form(study):
    assert sensitivity_to(study, "friction.coefficient") == 1
    assert sensitivity_to(study, "temperature.bulk") == pytest.approx(1 / 120)
    assert sensitivity_to(study, "temperature.critical") == pytest.approx(-1 / 120)


def log_rise(scene, load=400.0, velocity=2.0):
    *_, end = tribo.simulate(scene, load, velocity)
    return math.log(np.interp(0.9, tribo.QUANTILES, end.heat.rise_quantile))


def slope(log_rise_of_factor):
    """Central difference of ln(rise) over ln(factor)."""
    return (log_rise_of_factor(1.1) - log_rise_of_factor(1 / 1.1)) / (2 * math.log(1.1))


def test_radius_has_the_sensitivity_of_simulations_by_tribo(study):
    scene = load().scene

    def log_rise_of(factor):
        return log_rise(replace(scene, pin=replace(scene.pin, radius=2e-3 * factor)))

    # Here the quantile is interpolated linearly between those of the state.
    expected = slope(log_rise_of)
    assert sensitivity_to(study, "pin.radius") == pytest.approx(expected, abs=0.005)


def test_a_hotter_input_lowers_the_critical_velocity(study):
    moving = study.sel(input=study["input"] != "oil.kinematic_viscosity")
    assert (np.sign(moving["log_rise_change"]) == -np.sign(moving["velocity_change"])).all()
    assert (np.diff(abs(study["log_rise_change"])) <= 0).all()


def test_a_change_of_the_allowable_rise_moves_the_critical_velocity_by_its_exponent(study):
    exponent = slope(lambda factor: log_rise(load().scene, velocity=2.0 * factor))
    assert study["velocity_exponent"].item() == pytest.approx(exponent, abs=0.005)
    for path, change in (
        ("friction.coefficient", math.log(1.1)),
        ("temperature.bulk", 10 / 120),
        ("temperature.critical", -10 / 120),
    ):
        row = study.sel(input=path)
        assert row["log_rise_change"].item() == pytest.approx(change)
        expected = math.exp(-change / exponent) - 1
        assert row["velocity_change"].item() == pytest.approx(expected, rel=0.01)


@pytest.mark.usefixtures("study")
def test_the_command_takes_the_points_of_a_store(study_store, irg):
    before = pipeline.summary(study_store)
    at = "--load", AT[0], "--velocity", AT[1]
    irg("sensitivity", "first_try", *OPTIONS, *at, "--store", study_store, "--workers", "1")
    assert pipeline.summary(study_store) == before


def test_declared_inputs_are_sorted_by_what_their_deviations_do(study, study_store):
    declared = {CONDUCTIVITY: "1 %", "temperature.bulk": "5 K"}
    ds = pipeline.sensitivity(load(**declared), *AT, study_store, workers=1)
    deviations = ds["log_rise_deviation"]
    expected = 0.01 * abs(sensitivity_to(study, CONDUCTIVITY))
    assert deviations.sel(input=CONDUCTIVITY).item() == pytest.approx(expected)
    assert deviations.sel(input="temperature.bulk").item() == pytest.approx(5 / 120)
    assert np.isnan(deviations.sel(input="pin.radius").item())


def test_a_bar_is_of_the_declared_deviation_under_a_label_of_two_lines_if_narrow(study):
    ds = study.copy(deep=True)
    ds["uncertainty"].loc[{"input": CONDUCTIVITY}] = 0.2
    (axes,) = pipeline.plot(ds, width="85 mm").axes
    labels = [label.get_text() for label in axes.get_yticklabels()]
    higher = axes.containers[0][labels.index("thermal conductivity\n45 W/(m K) ± 20 %")]
    exponent = ds["velocity_exponent"].item()
    changed = math.exp(-0.2 * sensitivity_to(ds, CONDUCTIVITY) / exponent)
    assert higher.get_width() == pytest.approx(100 * (changed - 1))
    (axes,) = pipeline.plot(study).axes
    assert "thermal conductivity, 45 W/(m K)" in [t.get_text() for t in axes.get_yticklabels()]


def test_without_a_critical_velocity_one_is_to_be_given(tmp_path):
    mild = pipeline.load_scene("first_try", overrides=SMALL | {"temperature.critical": "900 degC"})
    words = "^there is no critical velocity at 400 N in the sweep; give --velocity$"
    with pytest.raises(tribo.InputError, match=words):
        pipeline.sensitivity(mild, out=tmp_path / "mild.zarr", workers=1)


def test_the_scale_of_a_scan_is_an_input_that_scales_its_heights():
    scale = "disk.roughness.height_unit"
    scene = pipeline.load_scene("scan", overrides={"uncertainty": {scale: "5 %"}})
    heights = {
        variant.factor: variant.case.scene.roughness.array
        for variant in variants_of(scene, [(400.0, 2.0, ())], {scale})
        if variant.entry == scale
    }
    assert len(heights) == 2
    for factor, array in heights.items():
        np.testing.assert_allclose(array, factor * scene.scene.roughness.array, rtol=1e-9)


def test_sensitivities_read_as_they_are_kept(study):
    figure = "\n".join(texts_of(pipeline.plot(study)))
    choices = "\n".join(f"{row.input.item()}: {row.item() or 'none'}" for row in study["choice"])
    texts = {"variables": variables(study), "choices": choices, "film": study.attrs["film"]}
    declared = study.assign(uncertainty=0.2 * study["uncertainty"].fillna(1.0))
    texts |= {"figure": figure, "declared": "\n".join(texts_of(pipeline.plot(declared)))}
    texts["names"] = "\n".join(f"{path}: {input_name(path)}" for path in NAMED)
    assert_as_kept("sensitivities", texts)


def test_a_film_is_outside_the_model_from_the_stated_viscosity_on(study, tmp_path):
    factor = float(study.attrs["film"].partition("from ")[2].split()[0])
    verdicts = []
    for k, share in enumerate((0.9, 1.1)):
        sweep = pipeline.load_scene("first_try", overrides=SMALL | {
            "oil.kinematic_viscosity": [f"{x * factor * share} mm^2/s" for x in (32, 5)],
            "sweep.loads": ["400 N"], "sweep.velocities": ["2 m/s"],
        })  # fmt: skip
        pipeline.run_sweep(sweep, tmp_path / f"{k}.zarr", workers=1)
        answer = pipeline.margin(tmp_path / f"{k}.zarr", *AT)
        verdicts.append(answer["verdict"].attrs["flag_meanings"].split()[answer["verdict"].item()])
    assert verdicts[0] != "outside_model" == verdicts[1]


def test_a_second_point_continues_the_store_and_the_first_is_not_simulated_again(tmp_path):
    out, counts = tmp_path / "inputs.zarr", []
    sweep = load().changed("wear", None).changed("disk.roughness", None)
    for point in (AT, ("200 N", "3 m/s"), AT):
        ds = pipeline.sensitivity(sweep, *point, out, workers=1)
        counts.append(pipeline.summary(out).tests.done)
    assert counts == [19, 38, 38]  # 8 inputs on both sides, and three velocities
    assert (ds["load"].item(), ds["velocity"].item()) == (400, 2)
    assert ds.attrs["film"] == ""  # of a smooth contact its inlet is not known


def test_an_input_that_the_scene_refuses_on_one_side_is_taken_on_the_other(tmp_path):
    short = {"pin.length": "0.25 mm", "sweep.loads": ["20 N", "40 N"]}  # of a window of 0.24 mm
    sweep = pipeline.load_scene("first_try", overrides=SMALL | short)
    ds = pipeline.sensitivity(sweep, "30 N", "2 m/s", tmp_path / "inputs.zarr", workers=1)
    row = ds.sel(input="pin.length")
    assert (row["sides"].item(), np.isnan(row["curvature"].item())) == ("+", True)
    scene = sweep.scene
    longer = replace(scene, pin=replace(scene.pin, length=0.25e-3 * 1.1))
    expected = (log_rise(longer, 30.0) - log_rise(scene, 30.0)) / math.log(1.1)
    assert row["sensitivity"].item() == pytest.approx(expected, abs=0.01)
    assert "pin length: by +10 % alone, as −10 % has no result" in [*sensitivity_lines(ds)]


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    sweep = pipeline.load_scene("gear_mesh", overrides={"window.pixels": [160, 48]})
    sweep = sweep.changed("window.pixel_size", ["6 um", "6 um"])
    return sweep, tmp_path_factory.mktemp("rows") / "inputs.zarr"


def test_rows_are_studied_at_the_row_that_governs_or_at_the_one_named(mesh):
    sweep, out = mesh
    ds = pipeline.sensitivity(sweep, out=out, workers=1)
    ratios = pipeline.margin(out)["log_rise_ratio"]
    governing = ratios.isel(case=int(np.argmax(ratios.values)))
    assert ds["load"].item() == governing["load"].item()
    assert ds["velocity"].item() == governing["velocity"].item()
    radius = sweep.case((("case", governing["case"].item()),)).scene.pin.radius
    assert ds["value"].sel(input="pin.radius").item() == radius
    named = pipeline.sensitivity(sweep, 2976, 5.5916, out, workers=1)
    assert named["value"].sel(input="motion.slide_roll_ratio").item() == 1.4976
    words = r"^no row of the sweep has 300 N and 2 m/s; give one of 2976 N, 1.2565 m/s; 4464 N, "
    with pytest.raises(tribo.InputError, match=words):
        pipeline.sensitivity(sweep, 300, 2, out)


def test_without_a_point_it_is_the_critical_velocity_of_the_middle_load(tmp_path):
    out = tmp_path / "inputs.zarr"
    ds = pipeline.sensitivity(load(), out=out, workers=1)
    assert ds["load"].item() == 400
    critical = pipeline.boundary(out)["critical_velocity"].sel(load=400).item()
    assert ds["velocity"].item() == pytest.approx(critical, rel=1e-6)


@pytest.fixture(scope="module")
def uncertain(tmp_path_factory):
    out = tmp_path_factory.mktemp("uncertain") / "scene.zarr"
    sweep = load(**{CONDUCTIVITY: "15 %", WEAR: "30 %"})
    pipeline.run_sweep(sweep, out, workers=1)
    return out


def test_three_loads_are_simulated_once_for_each_declared_input(uncertain):
    assert pipeline.summary(uncertain).tests.done == 3 * (2 * 2 + 3)  # and velocity
    sweep = load(**{CONDUCTIVITY: "5 %", WEAR: "30 %"})
    pipeline.run_sweep(sweep, uncertain, workers=1)
    assert pipeline.summary(uncertain).tests.done == 21  # nothing new
    assert pipeline.verify_store(uncertain).is_clean


def test_a_further_input_adds_its_points_alone(uncertain):
    sweep = load(**{CONDUCTIVITY: "15 %", WEAR: "30 %", "pin.radius": "0.1 mm"})
    assert pipeline.run_sweep(sweep, uncertain, workers=1).done == 9
    assert pipeline.summary(uncertain).tests.done == 21 + 6


def test_a_store_with_further_loads_has_points_at_the_highest_as_check_counts(tmp_path):
    out, loads = tmp_path / "grown.zarr", ["200 N", "400 N", "750 N"]
    for highest in (2, 3):
        entries = {"uncertainty": {WEAR: "30 %"}, "sweep.loads": loads[:highest]}
        sweep = pipeline.load_scene("first_try", overrides=SMALL | entries)
        assert missing_variants(sweep, out) == (10, 5)[highest - 2]
        pipeline.run_sweep(sweep, out, workers=1)
        assert missing_variants(sweep, out) == 0
    assert [load_of_point for load_of_point, _ in points_of_variants(out)] == [200, 400, 750]
    assert pipeline.run_sweep(sweep, out, workers=1).computed == 0
    assert pipeline.summary(out).tests.done == 15


def test_points_of_uncertain_inputs_are_copied_from_another_store(uncertain, tmp_path):
    sweep, out = load(**{CONDUCTIVITY: "15 %", WEAR: "30 %"}), tmp_path / "copy.zarr"
    pipeline.run_sweep(sweep, out, workers=1, source=uncertain)
    times, copied_times = (
        opened(path).groups[1].read("wall_time", ...).tolist() for path in (uncertain, out)
    )
    assert len(copied_times) == 21
    assert {*copied_times} <= {*times}


def test_large_uncertainties_are_warned_of():
    (warning,) = load(
        **{CONDUCTIVITY: "30 %", WEAR: "20 %", "friction.coefficient": "60 %"}
    ).all_warnings
    assert warning.path == f"uncertainty.{CONDUCTIVITY}"
    assert "30 % is more than 20 %" in warning.words


def test_a_dry_run_counts_the_points_of_uncertain_inputs_that_a_store_lacks(uncertain, irg):
    inputs = f'--set=uncertainty={{ "{CONDUCTIVITY}" = "15 %" }}'
    text = irg("run", "first_try", *OPTIONS, inputs, "-n", "-o", uncertain)
    assert "0 of them missing" in text


def answer(out, **entries):
    sweep = pipeline.load_scene("first_try", overrides=SMALL | entries)
    pipeline.run_sweep(sweep, out, workers=1)
    return pipeline.margin(out, *AT)


def require_equal(one, other):
    for name in ("probability_low", "probability", "probability_high"):
        assert one[name].item() == pytest.approx(other[name].item(), abs=1e-6)


def test_uncertain_inputs_are_a_part_of_the_bias(uncertain):
    # Friction acts on y as the bias does: the same verdict as with a bias of √(0.15² + 0.2²).
    friction = {"friction.coefficient": "20 %"}
    own = answer(uncertain, uncertainty=friction, **{"model.bias": "15 %"})
    same = answer(uncertain, **{"model.bias": 0.25})
    require_equal(own, same)
    assert own.attrs["uncertain_inputs"] == (
        "± 20 % of the rise (one standard deviation), most by friction (± 20 %)"
    )
    assert "uncertain inputs" not in own.attrs["not_included"]
    assert "uncertain inputs" in same.attrs["not_included"]


@pytest.mark.parametrize(("deviation", "bias"), [("10 %", 0.15), ("20 %", math.hypot(0.09, 0.2))])
def test_without_a_stated_bias_its_part_by_inputs_gives_way_to_the_declared_ones(
    uncertain, deviation, bias
):
    own = answer(uncertain, uncertainty={"friction.coefficient": deviation})
    require_equal(own, answer(uncertain, **{"model.bias": bias}))


def test_inputs_with_one_uncertainty_add_before_they_are_squared(uncertain):
    # A rise by 20 K of both temperatures leaves the allowable rise unchanged.
    both = answer(uncertain, uncertainty={"temperature.bulk, temperature.critical": "20 K"})
    require_equal(both, answer(uncertain, **{"model.bias": 0.15}))


def test_what_decides_may_be_a_measured_input(uncertain):
    friction = {"friction.coefficient": "20 %", WEAR: "10 %"}
    known = answer(uncertain, uncertainty={WEAR: "10 %"}, **{"model.bias": "5 %"})
    velocity = 0.97 * known["mild_velocity"].item()
    assert pipeline.margin(uncertain, 400, velocity)["verdict"].item() == 0
    answer(uncertain, uncertainty=friction, **{"model.bias": "5 %"})
    point = pipeline.margin(uncertain, 400, velocity)
    assert point["verdict"].item() == 1
    assert to_decide(point) == "measure the friction"


def test_a_case_has_one_uncertainty_the_largest_of_its_three_loads(uncertain):
    answer(uncertain, uncertainty={CONDUCTIVITY: "15 %"})
    scene, steel, points = load().scene, load().scene.disk, points_of_variants(uncertain)

    def log_rise_of(factor, point):
        other = replace(steel, thermal_conductivity=factor * steel.thermal_conductivity)
        changed = replace(scene, pin=replace(scene.pin, material=other), disk=other)
        return log_rise(changed, *point)

    parts = [15 * abs(slope(functools.partial(log_rise_of, point=point))) for point in points]
    assert len(parts) == 3
    texts = {
        pipeline.margin(uncertain, *point).attrs["uncertain_inputs"].split(" %")[0]
        for point in points
    }
    assert texts == {f"± {max(parts):.2g}"}


def points_of_variants(store):
    ds = pipeline.open_sweep(store)
    pairs = zip(ds["test_load"].values, ds["test_velocity"].values, strict=True)
    counts = Counter((load, round(float(velocity), 9)) for load, velocity in pairs)
    return [point for point, count in counts.items() if count > 1]  # velocity varies alone


def test_a_load_without_a_critical_velocity_is_studied_at_the_end_that_is_nearest_to_it(tmp_path):
    stores = []
    for critical, velocity in (("900 degC", 4.0), ("30 degC", 1.0)):
        entries = {"temperature.critical": critical, "uncertainty": {CONDUCTIVITY: "15 %"}}
        sweep = pipeline.load_scene("first_try", overrides=SMALL | entries)
        out = tmp_path / f"{velocity:g}.zarr"
        pipeline.run_sweep(sweep, out, workers=1, source=next(iter(stores), None))
        stores.append(out)
        assert sorted(points_of_variants(out)) == [(load, velocity) for load in (200, 400, 750)]


TEST = {"load": "400 N", "velocity": "2.3 m/s", "outcome": "transition"}


def test_tests_narrow_uncertain_inputs_unless_these_are_their_own(uncertain, tmp_path):
    friction = {"friction.coefficient": "30 %"}

    def width(**test):
        sweep = load(**friction)
        sweep = pipeline.load_scene(
            "first_try", overrides=SMALL | {"uncertainty": friction, "tests": [TEST | test] * 4}
        )
        pipeline.run_sweep(sweep, tmp_path / f"{len(test)}.zarr", workers=1, source=uncertain)
        ds = pipeline.margin(tmp_path / f"{len(test)}.zarr", *AT)
        low, high = ds.attrs["model_error"].replace("−", "-").split(" %")[0].split(" to ")
        return float(high) - float(low), ds.attrs["uncertain_inputs"]

    (narrow, words), (wide, own_words) = width(), width(inputs="own")
    assert words.endswith("narrowed by the tests, as they have the same inputs")
    assert "narrowed" not in own_words
    # A specimen scatters by √(5.5² + 30²) %: four of them fix the bias no better than to 15 %.
    assert narrow < 25 < 45 < wide


def test_the_appendix_of_a_report_has_the_bars_of_inputs(uncertain, tmp_path, undrawn):
    answer(uncertain, uncertainty={CONDUCTIVITY: "15 %"})
    page = pipeline.report(uncertain, *AT, out=tmp_path / "report.html").read_text("utf-8")
    appendix = page.partition("Operating point")[2]
    assert "Inputs and the limit" in appendix
