"""Sensitivities to inputs, and what uncertain inputs make of answers, on a small scene."""

import math
from dataclasses import replace

import numpy as np
import pytest

import pipeline
import tribo

SMALL = {
    "without": ["tests"],
    "window.pixels": [96, 48],
    "window.pixel_size": ["5 um", "5 um"],
    "disk.roughness.correlation_length": "12 um",
    "sweep.loads": ["200 N", "400 N", "750 N"],
    "sweep.velocities": {"from": "1 m/s", "to": "4 m/s", "count": 3},
}
CONDUCTIVITY = "materials.steel.thermal_conductivity"
WEAR = "wear.specific_wear_rate"
AT = "400 N", "2 m/s"


def load(**uncertainty):
    entries = {"uncertainty": uncertainty} if uncertainty else {}
    return pipeline.load_scene("first_try", overrides=SMALL | entries)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    out = tmp_path_factory.mktemp("sensitivity") / "inputs.zarr"
    return pipeline.sensitivity(load(), out, *AT, workers=1)


def sensitivity_to(study, path):
    return study.dataset["sensitivity"].sel(input=path).item()


def test_conductivity_and_heat_capacity_scale_the_rise_as_the_dimensions_demand(study):
    # At a given contact, the rise is g(v ρ c/k)/k; the contact does not depend on k, ρ and c.
    density = sensitivity_to(study, "materials.steel.density")
    assert sensitivity_to(study, CONDUCTIVITY) + density == pytest.approx(-1, abs=0.005)
    assert density == pytest.approx(
        sensitivity_to(study, "materials.steel.specific_heat"), abs=1e-9
    )


def test_wear_and_loading_rate_act_by_their_ratio(study):
    # The contact depends on the wear rate times the sliding distance, which is v F/rate.
    rate = sensitivity_to(study, "loading.rate")
    assert rate == pytest.approx(-sensitivity_to(study, WEAR), abs=0.005)
    assert rate > 0.01


def test_friction_and_temperatures_act_in_closed_form(study):
    assert sensitivity_to(study, "friction.coefficient") == 1
    assert sensitivity_to(study, "temperature.bulk") == pytest.approx(1 / 120)
    assert sensitivity_to(study, "temperature.critical") == pytest.approx(-1 / 120)


def test_radius_has_the_sensitivity_of_simulations_by_tribo(study):
    scene = load().scene

    def log_rise(radius):
        pin = replace(scene.pin, radius=radius)
        *_, end = tribo.simulate(replace(scene, pin=pin), 400.0, 2.0)
        return math.log(np.interp(0.9, tribo.QUANTILES, end.heat.rise_quantile))

    expected = (log_rise(2e-3 * 1.1) - log_rise(2e-3 / 1.1)) / (2 * math.log(1.1))
    # Here the quantile is interpolated linearly between those of the state.
    assert sensitivity_to(study, "pin.radius") == pytest.approx(expected, abs=0.005)


def test_a_hotter_input_lowers_the_critical_velocity_in_table_and_figure(study, tmp_path):
    ds = study.dataset
    assert (np.sign(ds["log_rise_change"]) == -np.sign(ds["velocity_change"])).all()
    assert (np.diff(abs(ds["log_rise_change"])) <= 0).all()
    assert study.table["entry"].tolist() == ds["input"].values.tolist()
    assert pipeline.plot(study, out=tmp_path / "inputs.svg").exists()


def test_without_a_critical_velocity_one_is_to_be_given(tmp_path):
    mild = pipeline.load_scene("first_try", overrides=SMALL | {"temperature.critical": "900 degC"})
    with pytest.raises(tribo.InputError, match=r"no critical velocity at 400 N .* give --veloc"):
        pipeline.sensitivity(mild, tmp_path / "mild.zarr", workers=1)


@pytest.fixture(scope="module")
def uncertain(tmp_path_factory):
    out = tmp_path_factory.mktemp("uncertain") / "scene.zarr"
    sweep = load(**{CONDUCTIVITY: "15 %", WEAR: "30 %"})
    pipeline.run_sweep(sweep, out, workers=1)
    return out


def test_three_loads_are_simulated_once_for_each_declared_input(uncertain):
    assert pipeline.summary(uncertain).tests.done == 3 * 2 * 3  # and velocity
    sweep = load(**{CONDUCTIVITY: "5 %", WEAR: "30 %"})
    pipeline.run_sweep(sweep, uncertain, workers=1)
    assert pipeline.summary(uncertain).tests.done == 18  # nothing new
    assert pipeline.verify_store(uncertain).is_clean


def test_a_further_input_adds_its_points_alone(uncertain):
    sweep = load(**{CONDUCTIVITY: "15 %", WEAR: "30 %", "pin.radius": "0.1 mm"})
    assert pipeline.run_sweep(sweep, uncertain, workers=1).done == 9
    assert pipeline.summary(uncertain).tests.done == 18 + 6


def probability(out, **entries):
    sweep = pipeline.load_scene("first_try", overrides=SMALL | entries)
    pipeline.run_sweep(sweep, out, workers=1)
    return pipeline.margin(out, *AT)


def test_uncertain_inputs_are_a_part_of_the_bias(uncertain):
    # Friction acts on y as the bias does: the same verdict as with a bias of √(0.15² + 0.2²).
    own = probability(uncertain, uncertainty={"friction.coefficient": "20 %"})
    same = probability(uncertain, **{"model.bias": 0.25})
    for name in ("probability_low", "probability", "probability_high"):
        assert own[name].item() == pytest.approx(same[name].item(), abs=2e-3)
    assert "uncertain inputs ± 20 %" in own.attrs["model_error"]
    assert "uncertain inputs" not in own.attrs["not_included"]
    assert "uncertain inputs" in same.attrs["not_included"]


def test_inputs_with_one_uncertainty_add_before_they_are_squared(uncertain):
    # A rise by 5 K of both temperatures leaves the allowable rise unchanged.
    both = probability(uncertain, uncertainty={"temperature.bulk, temperature.critical": "5 K"})
    none = probability(uncertain, **{"model.bias": 0.15})
    assert both["probability"].item() == pytest.approx(none["probability"].item(), abs=2e-3)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("pin.radios", "5 %", 'is no input of the scene .did you mean "pin.radius"'),
        ("pin.radius", "5 K", "cannot be converted"),
        ("pin.radius", "0 %", "is not above 0"),
        ("temperature.bulk", "5 %", "is not a number with a unit"),
        ("pin.radius, temperature.bulk", "5 K", "cannot be converted"),
    ],
)
def test_what_is_no_deviation_of_an_input_is_refused(key, value, words):
    with pytest.raises(pipeline.SceneFileError, match=words):
        load(**{key: value})
