"""What users add to a store stays, and is in nobody's way; what they copy of it is read.

What commands keep there is in nobody's way, either.
"""

import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr

import pipeline
import tribo
from pipeline.store.create import writing
from pipeline.store.schema import FAILED
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points
from pipeline.sweep.variants import surfaces
from tests.helpers import tiny
from tests.helpers.entries import changed, rows
from tests.helpers.points import run_point
from tests.helpers.stores import commit, record

SWEEP = tiny.full()


@pytest.fixture(autouse=True)
def _quiet_zarr():
    """Ignore Zarr's warning about consolidated metadata."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Consolidated metadata")
        yield


def add_own(path):
    """Add a user's attributes and variable to a store, with xarray and Zarr."""
    group = zarr.open_group(path, mode="r+")
    group.attrs["comment"] = "mine"
    group["max_rise"].attrs["note"] = "mine, too"
    ds = xr.open_zarr(path, chunks=None)
    ds[["max_rise"]].rename(max_rise="doubled").map(lambda v: 2 * v).to_zarr(path, mode="a")


def test_attributes_and_variables_of_users_stay_through_reads_and_runs(copy, irg):
    with xr.open_zarr(copy, chunks=None) as ds:
        before, boundary = ds.load(), pipeline.boundary(copy)
    add_own(copy)
    assert "points: 9 done and intact, 0 damaged" in irg("verify", copy)
    xr.testing.assert_identical(pipeline.boundary(copy).drop_attrs(), boundary.drop_attrs())
    with pipeline.open_sweep(copy) as ds:
        ds.load()
    assert pipeline.run_sweep(SWEEP, copy, workers=1).computed == 0
    with pytest.raises(pipeline.StoreError, match="doubled, an array added by a user, would not"):
        commit(copy, tiny.full(loads=(700.0,)), ())
    other = changed(SWEEP, title="Another title")  # writes another root document
    assert pipeline.run_sweep(other, copy, workers=1).computed == 0
    with xr.open_zarr(copy, chunks=None) as ds:
        assert (ds.attrs["comment"], ds.attrs["title"]) == ("mine", "Another title")
        np.testing.assert_array_equal(ds["doubled"], 2 * before["max_rise"])
    group = zarr.open_group(copy, use_consolidated=False)
    assert group["max_rise"].attrs["note"] == "mine, too"


@pytest.mark.parametrize(
    "add",
    [
        lambda path: xr.Dataset({"mine": ("k", [1.0])}).to_zarr(path, mode="a"),
        lambda path: zarr.open_group(path, use_consolidated=False).attrs.update(mine=1),
    ],
)
def test_a_root_that_other_programs_have_rewritten_is_whole_after_a_run(copy, add):
    boundary = pipeline.boundary(copy)
    add(copy)
    xr.testing.assert_identical(pipeline.boundary(copy), boundary)
    assert pipeline.run_sweep(SWEEP, copy, workers=1).computed == 0
    with xr.open_zarr(copy, chunks=None) as ds:
        xr.testing.assert_identical(pipeline.boundary(ds), boundary)
        assert "mine" in {*ds, *ds.attrs}


@pytest.mark.parametrize("kind", ["zarr", "netcdf", "plain zarr", "not consolidated"])
def test_a_copy_by_xarray_is_read_as_the_store_is(copy, tmp_path, irg, kind):
    target = tmp_path / ("copy.nc" if kind == "netcdf" else "copy.zarr")
    ds = xr.open_zarr(copy, chunks=None) if kind == "plain zarr" else pipeline.open_sweep(copy)
    ds = ds.assign(mine=ds["max_rise"] * 0.1)
    if kind == "netcdf":
        ds.to_netcdf(target)
    else:
        ds.to_zarr(target, consolidated=kind != "not consolidated")
    said, expected = (irg("boundary", store).split("warning: at")[0] for store in (target, copy))
    assert said == expected
    found = pipeline.boundary(target)["critical_velocity"]
    np.testing.assert_array_equal(found, pipeline.boundary(copy)["critical_velocity"])
    assert "mine" in pipeline.open_sweep(target)
    assert irg("status", target).splitlines()[1] == "9 points: 9 done, 0 failed, 0 pending"
    assert "points: 9 done and read, 0 damaged" in irg("verify", target)
    (number,) = irg("status", target, "--json")
    assert (number["points"], number["done"], number["failed"]) == (9, 9, 0)


def test_points_without_results_in_a_copy_are_named(copy, tmp_path, irg):
    ds = xr.open_zarr(copy, chunks=None).load()
    ds["max_rise"][0, 1] = np.nan
    ds["status"][2, 2] = FAILED
    ds.drop_encoding().to_netcdf(tmp_path / "copy.nc")
    place = f"{ds['load'].values[0]:g} N, {ds['velocity'].values[1]:g} m/s"
    said = irg("verify", tmp_path / "copy.nc", code=1)
    assert f"damaged: {place}: the point is done, and has no results" in said
    assert "7 done and read, 1 damaged" in said
    assert "its reason is in the store alone" in irg("status", tmp_path / "copy.nc", code=1)


@pytest.mark.parametrize("dim", ["load", "velocity"])
def test_what_is_appended_to_an_axis_is_taken_off_by_a_run(copy, dim):
    boundary, sizes = pipeline.boundary(copy), dict(xr.open_zarr(copy).sizes)
    more = xr.open_zarr(copy, chunks=None).isel({dim: [0]}).drop_encoding().load()
    more = more.assign_coords({dim: 2 * more[dim] + 5000})
    kept = [name for name in more.variables if dim in more[name].dims]
    more[kept].drop_vars({*more[kept].coords} - {*kept}).to_zarr(copy, append_dim=dim)
    assert xr.open_zarr(copy).sizes[dim] == sizes[dim] + 1
    pipeline.run_sweep(SWEEP, copy, workers=1)
    assert dict(xr.open_zarr(copy).sizes) == sizes
    assert pipeline.verify_store(copy).is_clean
    xr.testing.assert_identical(pipeline.boundary(xr.open_zarr(copy)), boundary)


PLAIN = {
    "where": lambda ds, dim: ds.where(ds["status"] == 1),
    "reindex": lambda ds, dim: ds.reindex({dim: [*ds[dim].values, 1e3]}),
    "merge": lambda ds, dim: xr.merge(halves(ds, dim), join="outer", compat="no_conflicts"),
    "rolling": lambda ds, dim: ds.rolling({dim: 2}).mean(),
    "concat": lambda ds, dim: xr.concat(halves(ds, dim), dim),
    "sel": lambda ds, dim: ds.sel({dim: slice(*ds[dim].values[[0, 1]])}),
    "interp": lambda ds, dim: ds.compute().interp({dim: float(ds[dim][0]) + 0.5}),
    "map_blocks": lambda ds, dim: ds.chunk().map_blocks(lambda d: d * 1, template=ds.chunk()),
}


def halves(ds, dim):
    return [ds.isel({dim: [0]}), ds.isel({dim: slice(1, None)})]


RAMPS = {"slow": {"loading": tribo.Ramp(50.0, 750.0)}, "fast": {}}
SWEEPS = {
    "plane": SWEEP,
    "surfaces": tiny.full(variants=surfaces((1, 2)), loads=(150.0, 600.0)),
    "rows": tiny.full(variants=rows("ramp", RAMPS, velocities=(1.5, 0.5)), loads=(150.0, 600.0)),
}


@pytest.fixture(scope="module", params=["plane, 2", "surfaces, 1", "rows, 1"])
def made(request, tmp_path_factory):
    """A store of each kind, with all points done or every second one."""
    kind, _, part = request.param.partition(", ")
    path, sweep = tmp_path_factory.mktemp("made") / "store.zarr", SWEEPS[kind]
    with writing(path, sweep) as store:
        done = points(sweep)[:: int(part)]
        store.commit([run_point(sweep, point).record(with_fields=True) for point in done])
    return path


@pytest.fixture(scope="module")
def opened(made):
    return xr.open_zarr(made), pipeline.open_sweep(made)


def test_results_of_a_plain_dataset_are_those_of_its_store(made):
    both = pipeline.results(xr.open_zarr(made)), pipeline.results(made)
    rises = (one.columns["max_rise"][..., -1] for one in both)
    np.testing.assert_array_equal(*(own[np.isfinite(own)] for own in rises))
    assert both[0].missing == both[1].missing


@pytest.mark.parametrize("name", PLAIN)
def test_plain_xarray_works_on_whole_and_half_done_sweeps(opened, name):
    for ds in opened:
        assert ds.chunks is not None  # fails if chunks along an axis differ in length
        assert {values.dtype.kind for values in ds.data_vars.values()} <= {*"bif"}
        assert PLAIN[name](ds, "load" if "load" in ds.dims else "point").load().data_vars


def test_plain_xarray_writes_tables_and_files(opened, tmp_path):
    for number, ds in enumerate(opened):
        assert len(ds[["max_rise", "status"]].to_dataframe()) == ds["max_rise"].size
        for engine in ("scipy", "h5netcdf"):
            ds.to_netcdf(file := tmp_path / f"{engine}{number}.nc", engine=engine)
            with xr.open_dataset(file, engine=engine) as written:
                xr.testing.assert_equal(written.load(), ds.compute())
        ds.to_zarr(target := tmp_path / f"copy{number}.zarr", consolidated=False)
        xr.testing.assert_equal(xr.open_zarr(target, consolidated=False).load(), ds.compute())


def test_a_damaged_chunk_of_a_copy_is_one_line(copy, tmp_path, irg):
    pipeline.open_sweep(copy).to_zarr(tmp_path / "copy.zarr")
    for file in filter(Path.is_file, (tmp_path / "copy.zarr").rglob("c/*/*/*/*")):
        file.write_bytes(file.read_bytes()[:20])
    assert "cannot go on: Zstd decompression error" in irg(
        "boundary", tmp_path / "copy.zarr", code=2
    )


def test_fields_lie_in_a_group_of_their_own(copy):
    fields = xr.open_zarr(copy, group="fields")
    rise = record(Point(600.0, 1.5)).data["rise"]
    np.testing.assert_array_equal(fields["rise"][-1, -1], rise)
