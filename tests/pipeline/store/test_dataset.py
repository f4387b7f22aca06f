"""The dataset: its page, plain xarray, and variables that users add to its store."""

import ast
import re
import shutil

import dask
import numpy as np
import pytest
import xarray as xr
import zarr

import pipeline
import tribo
from pipeline.answers.results import cases_of
from pipeline.run.serial import run_serial
from pipeline.shipped import WORKFLOWS
from pipeline.store.create import writing
from pipeline.store.schema import FIELDS
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import PointRecord, points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import bare_test, changed, rows
from tests.helpers.points import run_point
from tests.helpers.stores import commit, commit_all, record
from tribo import InputError

SWEEP = tiny.full()


def add_own(path):
    """Add a user's attributes and variable to a store, with xarray and Zarr."""
    group = zarr.open_group(path, mode="r+")
    group.attrs["comment"] = "mine"
    group["max_rise"].attrs["note"] = "mine, too"
    ds = xr.open_zarr(path, chunks=None)
    ds[["max_rise"]].rename(max_rise="doubled").map(lambda v: 2 * v).to_zarr(path, mode="a")


@pytest.mark.filterwarnings("ignore:Consolidated metadata")
def test_an_attribute_that_users_add_to_an_array_stays_through_runs_and_growths(copy):
    zarr.open_group(copy, mode="r+")["max_rise"].attrs["note"] = "mine"
    for sweep in (changed(SWEEP, title="Another title"), tiny.full(loads=(700.0,))):
        commit(copy, sweep, ())
        for group in (xr.open_zarr(copy, chunks=None), zarr.open_group(copy, mode="r")):
            assert group["max_rise"].attrs["note"] == "mine"
        assert pipeline.verify_store(copy).is_clean


@pytest.mark.filterwarnings("ignore:Consolidated metadata")
def test_what_users_add_stays_through_reads_and_runs(copy, irg):
    with xr.open_zarr(copy, chunks=None) as ds:
        before, boundary = ds.load(), pipeline.boundary(copy)
    add_own(copy)
    notes = copy / "load" / "figures" / "notes.txt", copy / "status" / "c.0.partial"
    notes[0].parent.mkdir()
    for file in notes:
        file.write_text("mine as well")
    assert "points: 9 done and undamaged, 0 damaged" in irg("verify", copy)
    xr.testing.assert_identical(pipeline.boundary(copy).drop_attrs(), boundary.drop_attrs())
    with pipeline.open_sweep(copy) as ds:
        ds.load()
    assert pipeline.run_sweep(SWEEP, copy, workers=1).computed == 0
    with pytest.raises(pipeline.StoreError, match=r", which is not of this program, would be lost"):
        commit(copy, tiny.full(loads=(700.0,)), ())
    other = changed(SWEEP, title="Another title")  # writes another root document
    assert pipeline.run_sweep(other, copy, workers=1).computed == 0
    with xr.open_zarr(copy, chunks=None) as ds:
        assert (ds.attrs["comment"], ds.attrs["title"]) == ("mine", "Another title")
        np.testing.assert_array_equal(ds["doubled"], 2 * before["max_rise"])
    assert {file.read_text() for file in notes} == {"mine as well"}


PLAIN = {
    "concat": lambda ds: xr.concat([ds.isel(load=[0]), ds.isel(load=slice(1, None))], "load"),
    "interp": lambda ds: ds.compute().interp(load=200.5),
    "mean": lambda ds: ds.mean("load"),
    "map_blocks": lambda ds: (chunked := ds.chunk()).map_blocks(lambda d: d * 1, template=chunked),
}


@pytest.fixture(scope="module")
def rows_store(tmp_path_factory):
    """A store of two rows with every second point done."""
    path = tmp_path_factory.mktemp("made") / "store.zarr"
    ramps = {"slow": {"loading": tribo.Ramp(50.0, 750.0)}, "fast": {}}
    table = rows("ramp", ramps, velocity=(1.5, 0.5))
    sweep = tiny.full(case_table=table, loads=(150.0, 600.0))
    with writing(path, sweep) as store:
        done = points(sweep)[::2]
        store.commit([run_point(sweep, point).record(with_fields=True) for point in done])
    return path


def test_a_dataset_of_plain_xarray_is_answered_with_its_tests(path):
    commit_all(path, tiny.full(tests=(bare_test(250.0, 1.0), bare_test(600.0, 0.5))))
    plain, opened = (
        read(path).sel(load=[150.0, 250.0]) for read in (xr.open_zarr, pipeline.open_sweep)
    )
    xr.testing.assert_identical(pipeline.boundary(plain), pipeline.boundary(opened))
    at = {"load": [200.0, 240.0], "velocity": 1.2}
    xr.testing.assert_identical(pipeline.margin(plain, **at), pipeline.margin(opened, **at))
    assert "test_rise_quantile" not in plain.variables


def test_a_dataset_that_lost_its_sweep_and_its_store_says_so(rows_store):
    with pytest.raises(InputError, match=r"no attribute sweep.*pipeline\.open_sweep"):
        cases_of(xr.open_zarr(rows_store).drop_encoding())


def test_plain_xarray_works_on_a_half_done_sweep_of_rows(rows_store):
    for ds in (xr.open_zarr(rows_store), pipeline.open_sweep(rows_store)):
        assert ds.chunks is not None  # fails if chunks along an axis differ in length
        assert {values.dtype.kind for values in ds.data_vars.values()} <= {*"bif"}
        for work in PLAIN.values():
            assert work(ds).load().data_vars


def test_plain_xarray_selects_the_field_of_a_point_and_one_not_computed_has_no_file(path):
    point = Point(600.0, 1.5)
    commit(path, SWEEP, [point])
    plane = xr.open_zarr(path, chunks=None)
    fields = xr.open_zarr(path, group="fields", chunks=None)
    for name in FIELDS:
        field = fields[name].sel(load=590.0, velocity=1.6, method="nearest")
        assert field.dims == ("x", "y")
        np.testing.assert_array_equal(field, record(point).data[name])
        np.testing.assert_array_equal(
            fields[name].sel(load=600.0, velocity=1.5), record(point).data[name]
        )
        assert fields[name].notnull().any(("x", "y")).sum() == 1
        assert [file.name for file in (path / "fields" / name).glob("c.*")] == ["c.2.2.0.0"]
    nearest = plane.sel(load=590.0, velocity=1.6, method="nearest")
    assert {"time", "normal_load", "sliding_distance"} < {*plane.coords}
    assert nearest["sliding_distance"].values.tolist() == [
        1.5 * time for time in nearest["time"].values
    ]
    assert plane["time"].notnull().sum() == len(record(point).data["time"])


def test_a_tree_and_open_sweep_join_fields_with_the_plane(path):
    commit(path, SWEEP, [Point(600.0, 1.5), Point(150.0, 0.5)])
    tree = xr.open_datatree(path, engine="zarr", chunks=None)
    ds, fields = pipeline.open_sweep(path), xr.open_zarr(path, group="fields", chunks=None)
    for joined in (ds, xr.merge([tree.to_dataset(), fields])):
        worn = joined["wear_depth"].max(("x", "y"))
        np.testing.assert_allclose(worn, joined["wear_depth_max"].sel(step=0), rtol=1e-6)
        assert worn.notnull().sum() == 2
    inherited = tree.sel(load=600.0, velocity=1.5)["fields/pressure"]
    np.testing.assert_array_equal(inherited, ds["pressure"].sel(load=600.0, velocity=1.5))
    assert "x" not in tree.to_dataset().coords


def test_each_operation_of_xarray_works_on_fields_with_and_without_chunks(rows_store):
    work = {
        **PLAIN,
        "step": lambda ds: ds.max(("x", "y")),
        "where": lambda ds: ds.where(ds["x"] > 0),
    }
    for chunks in (None, {}):
        fields = xr.open_zarr(rows_store, group="fields", chunks=chunks)
        assert (fields.chunk() if chunks is None else fields).chunks
        assert fields.coords["ramp"].values.tolist() == ["slow", "fast"]
        # Its threads restore each other's filters of warnings: a maximum over NaN warns at times.
        with dask.config.set(scheduler="synchronous"):
            for name, operation in work.items():
                assert operation(fields).compute().data_vars.keys() == {*FIELDS}, name


def test_a_name_is_that_of_a_store_in_results_and_a_path_is_not(tiny_store, tmp_path, monkeypatch):
    (tmp_path / "results").mkdir()
    (tmp_path / "results/tiny.zarr").symlink_to(tiny_store)
    monkeypatch.chdir(tmp_path)
    assert pipeline.open_sweep("tiny").identical(pipeline.open_sweep(tiny_store))
    for path in ("other/tiny", "tiny.zarr"):
        with pytest.raises(tribo.TriboError, match=path):
            pipeline.open_sweep(path)


def test_means_over_realizations_keep_the_times_of_steps(path):
    sweep = tiny.full(loads=(150.0, 600.0), velocities=(0.5,), case_table=surface_table((1, 2)))
    commit_all(path, sweep)
    for ds in (xr.open_zarr(path, chunks=None), pipeline.open_sweep(path)):
        mean = ds["max_rise"].mean("realization").sel(load=600.0, velocity=0.5)
        alone = run_point(sweep, Point(600.0, 0.5, (("realization", 2),))).columns
        for name in ("time", "normal_load", "sliding_distance"):
            assert mean[name].values.tobytes() == alone[name].tobytes()
        assert mean.notnull().all()


def test_a_point_that_fails_leaves_the_times_that_it_shares_with_other_realizations(path):
    sweep = tiny.full(loads=(150.0,), velocities=(0.5,), case_table=surface_table((1, 2)))
    first, second = points(sweep)
    result = run_point(sweep, first)
    with writing(path, sweep) as store:
        store.commit([result.record(with_fields=True)])
        store.commit([PointRecord(second, None, "no convergence"), result.record(with_fields=True)])
    assert pipeline.verify_store(path).is_clean
    ds = pipeline.open_sweep(path)
    assert ds["time"].squeeze().values.tobytes() == result.columns["time"].tobytes()
    with writing(path, sweep) as store:
        store.forget([first])
    assert pipeline.open_sweep(path)["time"].isnull().all()


def test_fields_at_steps_are_those_of_each_step_and_of_the_end(path, tiny_store):
    point = {"load": 600.0, "velocity": 1.5}
    with writing(path, tiny.full(fields="steps")) as store:
        run_serial(store, [Point(**point), Point(250.0, 1.5)])
    assert pipeline.verify_store(path).is_clean
    with pipeline.open_sweep(path) as ds, pipeline.open_sweep(tiny_store) as ends:
        steps, end = ds.sel(point), ends.sel(point)
        assert steps["pressure"].dims == ("step", "x", "y")
        touched = (steps["pressure"] > 0).mean(("x", "y"))
        np.testing.assert_allclose(touched, steps["contact_fraction"])
        on_way = steps.isel(step=steps["normal_load"].values.tolist().index(250.0))
        for name in FIELDS:
            np.testing.assert_array_equal(steps[name].sel(step=0), end[name])
            np.testing.assert_array_equal(
                on_way[name], ds[name].sel(load=250, velocity=1.5, step=0)
            )
            assert ds[name].sel(load=250, velocity=1.5).isnull().all(("x", "y")).sum() == 3


def test_a_dataset_in_memory_answers_without_its_store(copy):
    ds = pipeline.open_sweep(copy).load()
    expected = pipeline.margin(ds, 300.0, 1.0)
    shutil.rmtree(copy)
    assert pipeline.margin(ds, 300.0, 1.0).identical(expected)


# The page of the dataset


def test_the_lines_of_the_page_run_and_find_numbers(folder_with_results, monkeypatch):
    monkeypatch.chdir(folder_with_results)
    text, names = (WORKFLOWS / "DATASET.md").read_text(encoding="utf-8"), {}
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    for line in ast.parse("".join(blocks)).body:
        if not isinstance(line, ast.Expr):
            exec(ast.unparse(line), names)
            continue
        result = eval(ast.unparse(line), names)
        values = result[0].get_ydata() if "plot" in ast.unparse(line) else result
        assert np.isfinite(values).any(), ast.unparse(line)


def test_the_progress_of_several_points_never_goes_back():
    reports = []
    with writing(None, tiny.full()) as store:
        run_serial(store, points(tiny.full())[:3], report=reports.append)
    counts = [progress.done for progress in reports]
    assert counts == sorted(counts)
    assert {progress.total for progress in reports} == {counts[-1]}
