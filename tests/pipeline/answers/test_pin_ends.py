"""The temperature at the hottest end of a pin that is computed with its ends."""

import re

import numpy as np
import pytest

import pipeline
from pipeline.answers.facts import fact_lines
from tests.helpers.stores import commit_all

SHARP = {
    "pin": {
        "shape": "cylinder", "radius": "2 mm", "length": "3.4 mm", "material": "steel",
        "ends": "free",
    },
    "disk.roughness.correlation_length": "30 um",
    "window": {"pixels": [48, 48], "pixel_size": ["6 um", "10 um"]},
    "wear.specific_wear_rate": "1e-9 mm^3/(N m)",
    "fidelity": {"pixels_per_element": 1, "increments": 4, "contact_tolerance": 0.03},
    "sweep.loads": ["400 N", "560 N"], "sweep.velocities": ["1 m/s", "1.5 m/s"],
    "sweep.fields": True,
}  # fmt: skip
POINT = {"load": 560.0, "velocity": 1.5}
AT = "--load", "560 N", "--velocity", "1.5 m/s"


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("ends") / "sharp.zarr"
    commit_all(
        path, pipeline.load_scene("first_try", overrides={"without": ["tests", "oil"], **SHARP})
    )
    return path


def end_over_pin(ds, share):
    """Rise that a share of the contact exceeds at the hotter end over that of the whole pin."""
    rise, touches = ds["rise"].values.astype(float), ds["pressure"].values > 0
    y = ds["y"].values
    at_ends = y < -1.3e-3, y > 1.3e-3
    pin, *ends = (
        np.quantile(rise[:, part][touches[:, part]], 1 - share) for part in (y < 1, *at_ends)
    )
    return max(ends) / pin


@pytest.mark.parametrize("share", [0.1, 0.25])
def test_the_end_is_as_hot_as_the_fields_of_the_point_say(store, share):
    ds = pipeline.open_sweep(store)
    ratio = end_over_pin(ds.sel(POINT), share)
    answer = pipeline.margin(store, **POINT, critical_area_fraction=share)
    bulk, pin = 298.15, answer["governing_temperature"].item()
    assert ratio > 1.04
    meaning = answer["end_temperature"].attrs["long_name"]
    assert meaning == "governing temperature of the hottest end of the pin alone"
    assert answer["end_temperature"].item() == pytest.approx(bulk + ratio * (pin - bulk), abs=0.05)


def test_a_margin_warns_of_an_end_that_is_severe_where_the_whole_pin_is_mild(store, irg):
    answer = pipeline.margin(store, **POINT)
    pin, end = (answer[f"{name}_temperature"].item() for name in ("governing", "end"))
    at = "margin", store, *AT, "--critical-temperature"
    between, above = (
        " ".join(irg(*at, f"{critical} K").split()) for critical in ((pin + end) / 2, 1.2 * end)
    )
    hotter = f"{end - 273.15:.4g} °C, {end - pin:.2g} K above the whole pin"
    assert f"hottest end of the pin: {hotter}" in between
    assert f"hottest end of the pin: {end - 273.15:.4g} °C" in above
    assert (
        "the hottest end of the pin is above the critical temperature, but the verdict on "
        "the whole pin is mild; relieve the ends, or let them wear"
    ) in between
    assert "the hottest end of the pin is above" not in above


def test_an_end_that_is_cooler_than_the_pin_is_told(store):
    answer = pipeline.margin(store, **POINT)
    end = answer["governing_temperature"] - 3.0
    facts_of_end = fact_lines(answer.assign(end_temperature=end), "hottest end of the pin")
    assert facts_of_end == [
        f"hottest end of the pin: {end.item() - 273.15:.4g} °C, 3 K below the whole pin"
    ]


def test_a_boundary_states_the_temperature_of_the_hottest_end(store, irg):
    first = pipeline.margin(store, "560 N", "1.2 m/s")
    critical = first["governing_temperature"].item()
    boundary = pipeline.boundary(store, critical_temperature=critical)
    at_560 = boundary.sel(load=560.0)
    assert at_560["critical_velocity"].item() == pytest.approx(1.2, rel=1e-3)
    assert at_560["end_temperature"].item() == pytest.approx(
        first["end_temperature"].item(), abs=0.1
    )
    output = " ".join(irg("boundary", store, "--critical-temperature", f"{critical} K").split())
    (text,) = re.findall(r"hottest end of the pin: (.*?) °C where the whole pin is at the", output)
    coolest, *_, hottest = map(float, text.split(" to "))
    assert coolest - 0.5 <= at_560["end_temperature"].item() - 273.15 <= hottest + 0.5


def test_only_a_pin_with_free_ends_has_their_temperature(tiny_store):
    assert "end_rise_ratio" not in pipeline.open_sweep(tiny_store)
    assert "end_temperature" not in pipeline.boundary(tiny_store)
