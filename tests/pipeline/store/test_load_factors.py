"""Stores of rows at shares of their loads: layout, growth, copies and damage."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.sweep.plan import points
from tests.helpers import tiny
from tests.helpers.entries import placed_rows
from tests.helpers.points import run_point
from tests.helpers.stores import commit_all, done_points

ROWS = (250.0, 1.0, {"place": "A"}), (600.0, 1.5, {"place": "B"}), (500.0, 0.5, {"place": "C"})


def sweep_of_rows(*load_factors, **changes):
    return tiny.full(case_table=placed_rows(*ROWS, load_factors=load_factors), **changes)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "rows.zarr"


def rises(path):
    """Highest rises by place and load."""
    ds = pipeline.end_of_point(path)
    return {
        (place, load): rise
        for place, loads, values in zip(
            ds["place"].values.tolist(),
            np.reshape(ds["load"].values, (len(ROWS), -1)).tolist(),
            np.reshape(ds["max_rise"].values, (len(ROWS), -1)).tolist(),
            strict=True,
        )
        for load, rise in zip(loads, values, strict=True)
    }


def test_plain_xarray_reads_the_rows_by_their_load_factors(path):
    commit_all(path, sweep_of_rows(0.5, 1.0))
    with xr.open_zarr(path, chunks=None) as ds:
        assert ds["status"].dims == ("case", "load_factor")
        assert ds["max_rise"].dims == ("case", "load_factor", "step")
        assert ds["load_factor"].values.tolist() == [0.5, 1.0]
        assert ds["load"].values.tolist() == [[125.0, 250.0], [300.0, 600.0], [250.0, 500.0]]
        assert ds["velocity"].values.tolist() == [1.0, 1.5, 0.5]
        end = ds.isel(step=-1)
        np.testing.assert_array_equal(end["normal_load"], ds["load"])
    with xr.open_zarr(path, group="fields", chunks=None) as fields:
        assert fields["pressure"].dims[:2] == ("case", "load_factor")
    assert pipeline.verify_store(path).is_clean


def test_a_row_at_a_factor_is_the_point_at_that_load_and_velocity(path):
    sweep = sweep_of_rows(0.5, 1.0)
    commit_all(path, sweep)
    assert len(points(sweep)) == 6
    for (place, load), rise in rises(path).items():
        velocity = next(row[1] for row in ROWS if row[2]["place"] == place)
        result = pipeline.run_point(tiny.full(), load, velocity)
        assert rise == result.state.heat.max_rise


def test_a_store_grows_by_load_factors_and_keeps_its_points(path, tmp_path):
    commit_all(path, sweep_of_rows())
    before = rises(path)
    larger = sweep_of_rows(0.5, 1.0, 1.2)
    outcome = pipeline.run_sweep(larger, path, workers=1)
    assert (outcome.total, outcome.done, outcome.computed) == (9, 9, 6)
    assert before.items() <= rises(path).items()
    assert not pipeline.run_sweep(sweep_of_rows(0.5, 1.0), path, workers=1).computed
    copied = tmp_path / "copied.zarr"
    outcome = pipeline.run_sweep(sweep_of_rows(0.5, 0.7, 1.0), copied, workers=1, source=path)
    assert outcome.computed == 3
    assert {key: rises(path)[key] for key in rises(copied) if key in rises(path)}.items() <= (
        rises(copied).items()
    )


def test_a_damaged_chunk_of_rows_is_found_and_computed_again(path):
    commit_all(path, sweep_of_rows(0.5, 1.0, fields=False))
    expected = rises(path)
    file = next(file for file in (path / "max_rise").rglob("*") if file.name[0] == "c")
    file.write_bytes(file.read_bytes()[:-9])
    assert len(pipeline.verify_store(path).damaged) == 6
    assert pipeline.run_sweep(sweep_of_rows(0.5, 1.0, fields=False), path, workers=1).computed == 6
    assert rises(path) == expected


def test_rows_and_random_surfaces_have_points_at_each_factor(path):
    table = placed_rows(*ROWS[:2], load_factors=(0.5, 1.0))
    sweep = tiny.sweep(case_table=table).with_realizations(2)
    commit_all(path, sweep)
    ds = pipeline.open_sweep(path)
    assert dict(ds["status"].sizes) == {"case": 2, "realization": 2, "load_factor": 2}
    assert len(done_points(path)) == 8 == len({*done_points(path)})
    assert {*done_points(path)} == {*points(sweep)}
    for point in points(sweep)[:2]:
        at = dict(point.case)
        stored = pipeline.end_of_point(ds).sel(at)
        factor = point.load / ROWS[at["case"]][0]
        expected = run_point(sweep, point).record(False).data["max_rise"][-1]
        assert stored["max_rise"].sel(load_factor=factor).item() == expected
