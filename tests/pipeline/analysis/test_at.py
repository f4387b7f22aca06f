"""A sweep at other conditions, which the dataset carries (pipeline/analysis/at.py)."""

import json

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline.analysis.at import COLDEST_OIL, HOTTEST_OIL, oil_temperature
from tests.helpers import synthetic
from tests.pipeline.conftest import commit_all

HOT = {"friction": 0.12, "bulk_temperature": "60 degC"}
FEW = {"sweep.loads": ["400 N"], "sweep.velocities": ["1 m/s", "4 m/s"]}


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep()


def test_every_answer_is_at_the_conditions_that_the_dataset_carries(sweep):
    hot = pipeline.at(sweep, **HOT, critical_temperature="150 degC", share="5%")
    limit = synthetic.limit(0.12, 333.15, 423.15)
    critical = synthetic.critical_velocity(synthetic.LOADS, limit, 0.05)
    crossings = pipeline.boundary(hot)["critical_velocity"]
    inside = (critical > synthetic.VELOCITIES[0]) & (critical < synthetic.VELOCITIES[-1])
    np.testing.assert_allclose(crossings[inside], critical[inside], rtol=1e-9)
    found = pipeline.margin(hot, 600.0, 1.1)
    expected = 333.15 + 0.12 * synthetic.rise(600.0, 1.1, 0.95)
    assert found.deciding_temperature == pytest.approx(expected)
    last = pipeline.temperatures(pipeline.end_of_point(hot)).sel(load=600.0, velocity=1.0)
    assert last["max_temperature"] == pytest.approx(333.15 + 0.12 * synthetic.rise(600.0, 1.0))
    assert pipeline.results(sweep).conditions == synthetic.conditions()  # unchanged by `at`


def test_an_oil_works_at_the_coldest_and_hottest_that_are_allowed():
    for kelvin in (COLDEST_OIL, HOTTEST_OIL):
        assert oil_temperature("bulk_temperature", kelvin) == kelvin


def test_conditions_are_added_to_those_given_before_and_replace_them(sweep):
    twice = pipeline.at(pipeline.at(sweep, friction=0.2), bulk_temperature="60 degC", friction=0.12)
    xr.testing.assert_identical(twice, pipeline.at(sweep, **HOT))
    mean = pipeline.at(sweep, criterion="mean")
    assert pipeline.results(pipeline.at(mean, friction=0.12)).conditions.criterion.name == "mean"
    assert pipeline.results(pipeline.at(mean, share=0.2)).conditions.criterion.name == "share"


def test_several_values_are_rows_and_each_is_as_alone(sweep):
    rows = pipeline.at(
        sweep, friction=(0.09, 0.103), **{"temperature.bulk": ["25 degC", "60 degC"]}
    )
    crossings = pipeline.boundary(rows)["critical_velocity"]
    assert crossings.dims == ("friction_coefficient", "temperature_bulk", "load")
    table = pipeline.margin(rows, {"load": [600.0], "velocity": [1.2]})
    with pytest.raises(tribo.InputError, match="the sweep has 4 scenes"):
        pipeline.margin(rows, 600.0, 1.2)
    for row in table.to_dict("records"):
        friction, bulk = row["friction_coefficient"], row["temperature_bulk [°C]"] + 273.15
        alone = pipeline.at(sweep, friction, bulk_temperature=bulk)
        here = {"friction_coefficient": friction, "temperature_bulk": bulk}
        np.testing.assert_array_equal(
            crossings.sel(here), pipeline.boundary(alone)["critical_velocity"]
        )
        found = pipeline.margin(alone, 600.0, 1.2)
        assert (row["verdict"], row["distance [K]"]) == (found.verdict, found.distance)
        one = pipeline.margin(rows.sel(here), 600.0, 1.2)
        assert one.distance == found.distance
    assert len(table.drop_duplicates()) == 4


def test_what_acts_later_and_is_not_taken_is_refused_with_what_to_run(irg, tmp_path):
    store = tmp_path / "s.zarr"
    sweep = pipeline.load_scene("first_try", overrides={"fidelity.preset": "standard", **FEW})
    commit_all(store, sweep)
    said = irg("boundary", store, "--at", "pin.radius=1 mm", code=2)
    assert "; run the scene with pin.radius = 1 mm into another store" in said
    said = irg("boundary", store, "--at", "disk.track_length=100 mm", code=2)
    assert "or into the same one if it acts after the simulation" in said
    few = [f"--set={path}={json.dumps(value)}" for path, value in FEW.items()]
    again = ("run", "first_try", *few, "--set=disk.track_length=100 mm", "-o", store, "--workers=1")
    assert irg(*again, "--json")["computed"] == 0
    assert "the disk, 0.1 m" in irg("boundary", store)


def test_a_part_without_the_end_of_points_is_judged_at_other_conditions():
    ds = synthetic.sweep()
    hotter = pipeline.temperatures(pipeline.at(ds, friction=0.12))
    part = pipeline.temperatures(pipeline.at(ds.sel(step=[-3, -1]), friction=0.12))
    assert part["max_temperature"].equals(hotter["max_temperature"].sel(step=[-3, -1]))
