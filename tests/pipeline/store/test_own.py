"""What users add to a store stays, and is in nobody's way; what they copy of it is read."""

import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr
from numcodecs.zstd import Zstd

import pipeline
from pipeline.sweep.model import Point
from tests.helpers import tiny
from tests.helpers.stores import commit, plain_values, record

SWEEP = tiny.full()
ZEROS = Zstd(level=1, checksum=True).encode(np.zeros(2**28, np.uint8))


@pytest.fixture(autouse=True)
def _quiet_zarr():
    """Zarr warns of consolidated metadata whenever it writes some."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Consolidated metadata")
        yield


def add_own(path):
    """Add attributes and a variable to a store, as xarray and Zarr do."""
    group = zarr.open_group(path, mode="r+")
    group.attrs["comment"] = "mine"
    group["max_rise"].attrs["note"] = "mine, too"
    ds = xr.open_zarr(path, chunks=None)
    ds[["max_rise"]].rename(max_rise="doubled").map(lambda v: 2 * v).to_zarr(path, mode="a")


def test_attributes_and_variables_of_users_stay_through_reads_and_runs(copy, irg):
    with xr.open_zarr(copy, chunks=None) as ds:
        before, boundary = ds.load(), pipeline.boundary(copy)
    add_own(copy)
    assert "9 points are done and intact, 0 are damaged" in irg("verify", copy)
    xr.testing.assert_identical(pipeline.boundary(copy).drop_attrs(), boundary.drop_attrs())
    with pipeline.open_sweep(copy) as ds:
        ds.load()
    assert pipeline.run_sweep(SWEEP, copy, workers=1).computed == 0
    with pytest.raises(pipeline.StoreError, match="doubled, which is not of the store, would not"):
        commit(copy, tiny.full(loads=(700.0,)), ())
    changed = SWEEP.changed(title="Another title")  # another root
    assert pipeline.run_sweep(changed, copy, workers=1).computed == 0
    with xr.open_zarr(copy, chunks=None) as ds:
        assert (ds.attrs["comment"], ds.attrs["title"]) == ("mine", "Another title")
        np.testing.assert_array_equal(ds["doubled"], 2 * before["max_rise"])
    group = zarr.open_group(copy, use_consolidated=False)
    assert group["max_rise"].attrs["note"] == "mine, too"


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


@pytest.mark.parametrize("change", [lambda chunk: chunk[:20], lambda _: ZEROS])
def test_a_damaged_copy_is_one_line_and_fills_no_memory(copy, tmp_path, irg, change):
    target = tmp_path / "copy.zarr"
    pipeline.open_sweep(copy).to_zarr(target)
    for file in filter(Path.is_file, target.rglob("c/*/*/*/*")):
        file.write_bytes(change(file.read_bytes()))
    assert "a chunk" in irg("boundary", target, code=2)


def test_a_store_that_lost_its_facts_is_no_copy(copy):
    content = (copy / "zarr.json").read_text()
    (copy / "zarr.json").write_text(content.replace('"about": {', '"abouu": {', 1))
    with pytest.raises(pipeline.StoreError, match="damaged"):
        pipeline.open_sweep(copy)


PLAIN = {
    "where": lambda ds: ds.where(ds["status"] == 1),
    "where, drop": lambda ds: ds.where((ds["status"] == 1).compute(), drop=True),
    "reindex": lambda ds: ds.reindex(load=[*ds["load"].values, 1e3]),
    "merge": lambda ds: xr.merge(
        [ds.isel(load=[0]), ds.isel(load=[1, 2])], join="outer", compat="no_conflicts"
    ),
    "fillna": lambda ds: ds.fillna(0),
    "max": lambda ds: ds.max(),
    "coarsen": lambda ds: ds.coarsen(load=2, boundary="trim").mean(),
    "rolling": lambda ds: ds.rolling(load=2).mean(),
    "quantile": lambda ds: ds.compute().fillna(0).quantile(0.5, "load"),
    "diff": lambda ds: ds.diff("load"),
    "concat": lambda ds: xr.concat([ds.isel(load=[0]), ds.isel(load=[1, 2])], "load"),
    "sel": lambda ds: ds.sel(load=slice(200, 700)).sel(velocity=1.1, method="nearest"),
    "interp": lambda ds: ds.compute().interp(load=400.0),
    "chunks": lambda ds: ds.chunk(),
    "map_blocks": lambda ds: ds.chunk().map_blocks(lambda d: d * 1, template=ds.chunk()),
}


@pytest.mark.parametrize("name", PLAIN)
@pytest.mark.parametrize("done", [4, 9])
def test_plain_xarray_works_on_whole_and_half_done_sweeps(path, name, done):
    commit(path, SWEEP, [Point(load, v) for load in tiny.LOADS for v in tiny.VELOCITIES][:done])
    for ds in (xr.open_zarr(path), pipeline.open_sweep(path)):
        assert ds.chunks is not None  # one length of chunks along each axis
        assert PLAIN[name](ds).load().data_vars
    numbers = {values.dtype.kind for values in plain_values(path).values()}
    assert numbers <= {*"bif", "T"}
    assert {array.dtype.kind for array in xr.open_zarr(path).data_vars.values()} <= {*"bif"}


def test_plain_xarray_writes_tables_and_files(copy, tmp_path):
    ds = xr.open_zarr(copy)
    assert len(ds[["max_rise", "status"]].to_dataframe()) == ds["max_rise"].size
    for engine in ("scipy", "h5netcdf"):
        ds.to_netcdf(tmp_path / f"{engine}.nc", engine=engine)
    ds.to_zarr(tmp_path / "copy.zarr", consolidated=False)
    fields = xr.open_zarr(copy, group="fields")
    rise = record(Point(600.0, 1.5)).data["rise"]
    np.testing.assert_array_equal(fields["rise"][-1, -1], rise)
    shutil.rmtree(tmp_path / "copy.zarr")
