"""What xarray does to a dataset, by four ways to open it: the contract with its operations.

An operation keeps points, makes points from others, or breaks the dataset.
"""

import pickle

import numpy as np
import pytest
import xarray as xr

import pipeline
from tests.helpers import tiny
from tests.pipeline.conftest import commit_all
from tribo import InputError

SWEEP = tiny.sweep(fields=False)
WAYS = ("open_sweep", "open_zarr", "netCDF", "Zarr 2")


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    """Dataset of a store of 3 loads and 3 velocities, by each way to open it."""
    folder = tmp_path_factory.mktemp("xarray")
    store = folder / "tiny.zarr"
    with np.errstate(all="raise", under="ignore"):
        commit_all(store, SWEEP)
    pipeline.open_sweep(store).to_netcdf(folder / "a.nc")
    plain = xr.open_zarr(store, chunks=None)
    plain.drop_encoding().to_zarr(folder / "a.zarr", mode="w", zarr_format=2)
    return {
        "open_sweep": pipeline.open_sweep(store),
        "open_zarr": xr.open_zarr(store, chunks=None),
        "netCDF": xr.open_dataset(folder / "a.nc"),
        "Zarr 2": pipeline.open_sweep(folder / "a.zarr"),
    }


def crossings(ds):
    return np.round(pipeline.boundary(ds)["critical_velocity"].values, 4)


def joined(parts, dim="load"):
    return xr.concat(parts, dim, data_vars="all", coords="different", compat="equals", join="outer")


def halves(ds, dim="load"):
    return ds.isel({dim: slice(0, 1)}), ds.isel({dim: slice(1, None)})


def written(ds, folder, **options):
    ds.drop_encoding().to_zarr(folder / "written.zarr", consolidated=False, **options)
    return xr.open_zarr(folder / "written.zarr", consolidated=False)


def netcdf(ds, folder):
    ds.drop_encoding().to_netcdf(folder / "written.nc")
    return xr.open_dataset(folder / "written.nc")


def swapped(ds):
    other = ds.assign_coords(k=("load", np.arange(ds.sizes["load"])))
    return other.swap_dims(load="k").swap_dims(k="load").drop_vars("k")


KEEPS = {
    "copy": lambda ds: ds.copy(deep=True),
    "compute": lambda ds: ds.compute(),
    "persist": lambda ds: ds.persist(),
    "chunk": lambda ds: ds.chunk({"load": 1, "velocity": 2}),
    "unify_chunks": lambda ds: ds.chunk().unify_chunks(),
    "sel": lambda ds: ds.sel(load=ds["load"].values),
    "isel": lambda ds: ds.isel(velocity=slice(None, None, -1)),
    "loc": lambda ds: ds.loc[{"velocity": ds["velocity"].values}],
    "thin": lambda ds: ds.thin(1),
    "head": lambda ds: ds.head(load=3),
    "sortby": lambda ds: ds.sortby("velocity", ascending=False),
    "step": lambda ds: ds.sel(step=0),
    "step, dropped": lambda ds: ds.sel(step=0, drop=True),
    "last steps": lambda ds: ds.isel(step=slice(-2, None)),
    "squeeze": lambda ds: ds.squeeze(),
    "transpose": lambda ds: ds.transpose("step", "velocity", "load", ...),
    "reindex": lambda ds: ds.reindex(velocity=ds["velocity"].values[::-1]),
    "reindex_like": lambda ds: ds.reindex_like(ds),
    "align": lambda ds: xr.align(ds, ds)[0],
    "where": lambda ds: ds.where(ds["status"] == 1),
    "pickle": lambda ds: pickle.loads(pickle.dumps(ds)),
    "to_dict": lambda ds: xr.Dataset.from_dict(ds.to_dict()),
    "concat loads": lambda ds: joined(halves(ds)),
    "concat velocities": lambda ds: joined(halves(ds, "velocity"), "velocity"),
    "combine_by_coords": lambda ds: xr.combine_by_coords(halves(ds), combine_attrs="override"),
    "merge": lambda ds: xr.merge(
        [ds[["max_rise"]], ds.drop_vars("max_rise")],
        combine_attrs="override", compat="override", join="outer",
    ),
    "stack": lambda ds: ds.stack(p=("load", "velocity")).unstack("p"),
    "map_blocks": lambda ds: ds.chunk().map_blocks(lambda one: one, template=ds.chunk()),
    "map": lambda ds: ds.map(lambda one: one, keep_attrs=True),
    "groupby map": lambda ds: ds.groupby("load").map(lambda one: one),
    "astype": lambda ds: ds.astype("float32"),
    "astype object": lambda ds: ds.astype(object),
    "assign": lambda ds: ds.assign(mine=ds["max_rise"] * 2, other=1.0),
    "assign_coords": lambda ds: ds.assign_coords(load=ds["load"].astype("float32")),
    "assign_attrs": lambda ds: ds.assign_attrs(mine="x"),
    "rename": lambda ds: ds.rename(load="F").rename(F="load"),
    "expand_dims": lambda ds: ds.expand_dims("k").squeeze("k", drop=True),
    "reset_coords": lambda ds: ds.reset_coords("own_grid"),
    "set_coords": lambda ds: ds.set_coords("max_rise"),
    "drop_encoding": lambda ds: ds.drop_encoding(),
    "drop_indexes": lambda ds: ds.drop_indexes("load"),
    "set_xindex": lambda ds: ds.reset_index("load").set_xindex("load"),
    "swap_dims": swapped,
    "drop_vars": lambda ds: ds.drop_vars(["wear_volume", "max_pressure"]),
    "drop_duplicates": lambda ds: ds.drop_duplicates("load"),
    "fillna": lambda ds: ds.fillna(ds),
    "DataTree": lambda ds: xr.DataTree(ds).to_dataset(),
    "groupby mean": lambda ds: ds.groupby("velocity").mean(),
}  # fmt: skip
WRITES = {
    "to_zarr": written,
    "to_zarr 2": lambda ds, folder: written(ds, folder, zarr_format=2),
    "to_netcdf": netcdf,
}


@pytest.mark.parametrize("name", KEEPS)
def test_an_operation_that_keeps_points_keeps_the_answer(name, opened):
    right = crossings(opened["open_sweep"])
    for way in WAYS:
        with np.errstate(all="ignore"):
            done = KEEPS[name](opened[way])
        np.testing.assert_array_equal(crossings(done), right, err_msg=way)


@pytest.mark.parametrize("name", WRITES)
def test_a_copy_answers_as_its_store(name, opened, tmp_path):
    right = crossings(opened["open_sweep"])
    for way in WAYS:
        (folder := tmp_path / way).mkdir()
        np.testing.assert_array_equal(crossings(WRITES[name](opened[way], folder)), right)


BETWEEN = [1.0, 1.1, 1.3]
MAKES = {
    "interp velocity": lambda ds: ds.interp(velocity=BETWEEN),
    "interp load": lambda ds: ds.interp(load=[200.0, 400.0, 500.0]),
    "interp both": lambda ds: ds.interp(load=[200.0, 500.0], velocity=BETWEEN),
    "interp nearest": lambda ds: ds.interp(velocity=BETWEEN, method="nearest"),
    "coarsen": lambda ds: ds.coarsen(velocity=2, boundary="trim").mean(),
    "rolling": lambda ds: ds.rolling(velocity=2).mean(),
    "rolling load": lambda ds: ds.rolling(load=2).mean(),
}


BREAKS = {
    "no status": (lambda ds: ds.drop_vars("status"), "no status"),
    "no quantiles": (lambda ds: ds.drop_vars("rise_quantile"), "no rise_quantile"),
    "no load": (lambda ds: ds.drop_vars("load"), "no load"),
    "mean": (lambda ds: ds.mean("velocity"), "no velocity"),
    "no shares": (lambda ds: ds.drop_vars("cooler_share"), "no axis cooler_share"),
    "one share": (lambda ds: ds.isel(cooler_share=0), "no axis cooler_share"),
    "few shares": (lambda ds: ds.isel(cooler_share=slice(2)), "the stored quantiles allow"),
    "no end": (lambda ds: ds.isel(step=slice(-1)), "lacks step 0"),
    "twice": (lambda ds: ds.isel(load=[0, 0, 1]), "a load twice"),
    "new": (lambda ds: ds.expand_dims(k=2), "a dimension k"),
    "stacked": (lambda ds: ds.stack(p=("load", "velocity")), "a dimension p"),
    "none": (lambda ds: ds.isel(load=[]), "no load left"),
    "NaN": (lambda ds: ds.assign_coords(load=[np.nan, 1.0, 2.0]), "no finite number"),
    "unit": (lambda ds: ds.assign_coords(load=ds["load"].assign_attrs(units="kN")), "in kN"),
    "no scene": (lambda ds: ds.drop_attrs(), "no attribute scene"),
    "lost axis": (lambda ds: ds.assign(status=ds["status"].isel(load=0, drop=True)),
                  "status of the dataset has lost its axis load"),
    "lost share": (
        lambda ds: ds.assign(rise_quantile=ds["rise_quantile"].isel(cooler_share=0, drop=True)),
        "rise_quantile of the dataset has lost its axis cooler_share"),
    "text": (lambda ds: ds.assign(rise_quantile=ds["rise_quantile"].astype(str).astype(object)
                                  .where(False, "x")), "rise_quantile of the dataset is no number"),
    "broadcast": (lambda ds: ds.broadcast_like(ds), "status of the dataset has also"),
    "more": (lambda ds: ds.assign(rise_quantile=ds["rise_quantile"].expand_dims(k=2)),
             "rise_quantile of the dataset has also k"),
}  # fmt: skip


@pytest.mark.parametrize("name", BREAKS)
def test_what_breaks_a_dataset_is_named(name, opened):
    broken, said = BREAKS[name]
    for way in WAYS:
        with pytest.raises(InputError, match=said):
            pipeline.boundary(broken(opened[way]))


def test_a_load_that_is_selected_alone_is_answered(opened):
    whole = crossings(opened["open_sweep"])
    one = opened["open_sweep"].isel(load=1)
    np.testing.assert_array_equal(crossings(one), whole[[1]])
    assert pipeline.margin(one, float(one["load"]), 1.0).is_computed
