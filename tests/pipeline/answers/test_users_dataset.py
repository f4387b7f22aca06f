"""Answers to datasets that a user has changed with xarray."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.store.schema import COLUMNS
from tests.helpers import tiny
from tests.helpers.entries import bare_test
from tests.helpers.stores import commit_all
from tribo import InputError

RISES = "rise_quantile", "mean_rise", "max_rise"
LOAD, VELOCITY = 300.0, 1.0
NOTE = (
    "the rises of the dataset were changed, but not those of the tests, which are a group of "
    "their own; without_tests=True leaves the tests out"
)


@pytest.fixture
def ds(tiny_store):
    with pipeline.open_sweep(tiny_store) as dataset:
        yield dataset


def rise_of(ds, **conditions):
    """Governing rise at the point, above the bulk temperature [K]."""
    answer = pipeline.margin(ds, LOAD, VELOCITY, **conditions)
    return (answer["governing_temperature"] - answer["bulk_temperature"]).item()


def with_rises(ds, change):
    return ds.assign({name: change(ds[name]) for name in RISES})


def file_of(ds, folder):
    ds.to_netcdf(folder / "dataset.nc")
    return xr.open_dataset(folder / "dataset.nc")


def store_of(ds, folder):
    ds.to_zarr(folder / "dataset.zarr", consolidated=False)
    return xr.open_zarr(folder / "dataset.zarr", consolidated=False)


def halves(ds):
    return ds.isel(velocity=slice(0, 1)), ds.isel(velocity=slice(1, None))


UNCHANGED = {
    "isel": lambda ds, _: ds.isel(load=slice(0, None)),
    "sel": lambda ds, _: ds.sel(velocity=ds["velocity"].values, step=[0]),
    "quantile": lambda ds, _: ds.sel(area_fraction_below=[0.9]),
    "transpose": lambda ds, _: ds.transpose("velocity", "load", ...),
    "stack": lambda ds, _: ds.stack(point=("load", "velocity")).unstack("point"),
    "chunk": lambda ds, _: ds.chunk(velocity=1),
    "concat": lambda ds, _: xr.concat(halves(ds), "velocity"),
    "merge": lambda ds, _: xr.merge(
        [ds[["rise_quantile"]], ds.drop_vars("rise_quantile")], compat="override"
    ),
    "combine": lambda ds, _: xr.combine_by_coords(halves(ds), combine_attrs="override"),
    "drop_vars": lambda ds, _: ds.drop_vars("wear_volume"),
    "set_coords": lambda ds, _: ds.set_coords([*ds.data_vars]),
    "drop_encoding": lambda ds, _: ds.drop_encoding(),
    "unit of a number": lambda ds, _: ds.assign(
        status=ds["status"].assign_attrs(units="1"), rise_quantile=ds["rise_quantile"].drop_attrs()
    ),
    "sortby": lambda ds, _: ds.sortby("velocity", ascending=False).sortby("velocity"),
    "netCDF": file_of,
    "Zarr": store_of,
}  # fmt: skip


@pytest.mark.parametrize("operation", UNCHANGED)
def test_a_dataset_with_the_same_values_has_the_same_answer(ds, tmp_path, operation):
    same = UNCHANGED[operation](ds, tmp_path)
    assert rise_of(same) == pytest.approx(rise_of(ds), rel=1e-12)
    assert NOTE not in pipeline.margin(same, LOAD, VELOCITY).attrs["notes"]


def test_multiplied_filled_and_capped_rises_are_used_as_they_are(ds):
    rise = rise_of(ds)
    assert rise_of(with_rises(ds, lambda x: 1.1 * x)) == pytest.approx(1.1 * rise, rel=1e-6)
    cap = 5 * rise  # [K] at friction 1, where the rise is ten times as large
    assert rise_of(with_rises(ds, lambda x: x.clip(max=cap))) == pytest.approx(cap / 10, rel=1e-6)
    assert rise_of(with_rises(ds, lambda x: x.fillna(0.0))) == pytest.approx(rise, rel=1e-12)


def test_answers_to_changed_rises_say_that_tests_did_not_change(tmp_path):
    commit_all(
        tmp_path / "tested.zarr",
        tiny.sweep(tests=(bare_test(250.0, 1.0, outcome="mild"),)),
        shares_ramps=False,
    )
    with pipeline.open_sweep(tmp_path / "tested.zarr") as ds:
        warmer = with_rises(ds, lambda x: 1.1 * x)
        for answer in (pipeline.margin(warmer, LOAD, VELOCITY), pipeline.boundary(warmer)):
            assert NOTE in answer.attrs["notes"]
        assert NOTE not in pipeline.margin(ds, LOAD, VELOCITY).attrs["notes"]
        free = pipeline.margin(warmer, LOAD, VELOCITY, without_tests=True)
        assert free.attrs["tests"] == 0
        assert NOTE not in free.attrs["notes"]
        assert pipeline.boundary(warmer, without_tests=True).attrs["tests"] == 0


REFUSED = {
    "where": (lambda ds: ds.where(ds["velocity"] < 9), "its status is not an integer"),
    "fillna": (lambda ds: ds.fillna(0.0), "change single variables by assign, and give other loads "
               "and velocities to pipeline.margin"),
    "multiply": (lambda ds: ds * 1.1, "its status is not an integer"),
    "round": (lambda ds: ds.round(1), "all of its variables are computed"),
    "shift": (lambda ds: ds.shift(velocity=1), "its status is not an integer"),
    "interp": (lambda ds: ds.interp(velocity=[0.7, 1.1]), "its status is not an integer"),
    "interp quadratic": (lambda ds: ds.interp(velocity=[0.6, 1.4], method="quadratic"),
                         "its status is not an integer"),
    "interp at stored loads": (
        lambda ds: ds.isel(load=[0, 2]).interp(load=ds["load"].values),
        "its status is not an integer"),
    "coarsen": (lambda ds: ds.coarsen(load=2, boundary="trim").mean(keep_attrs=True),
                "its status is not an integer"),
    "shift filled": (lambda ds: ds.shift(velocity=1, fill_value=1), "the values stored at load"),
    "roll velocity": (lambda ds: ds.roll(velocity=1), "in proportion to the velocity"),
    "roll loaded": (lambda ds: ds.load().roll(velocity=-1), "in proportion to the velocity"),
    "roll load": (lambda ds: ds.roll(load=1), "the values stored at load"),
    "roll step": (lambda ds: ds.roll(step=1), "the values stored at load"),
    "roll quantile": (lambda ds: ds.roll(area_fraction_below=1),
                      "rise_quantile falls along area_fraction_below"),
    "reindex": (lambda ds: ds.reindex(velocity=[0.5, 9.0]), "its status is not an integer"),
    "reindex nearest": (lambda ds: ds.reindex(velocity=[0.6, 1.6], method="nearest"),
                        "velocity 0.6 is not in its sweep"),
    "reindex load": (
        lambda ds: ds.isel(load=[0, 2]).reindex(load=ds["load"].values, method="nearest"),
        "the values stored at load 250 N belong to 150 N"),
    "reindex velocity": (
        lambda ds: ds.isel(velocity=[0, 2]).reindex(velocity=ds["velocity"], method="nearest"),
        "the values stored at velocity 1 m/s belong to 1.5 m/s"),
    "sortby": (lambda ds: ds.sortby("velocity", ascending=False), "sort it"),
    "rename": (lambda ds: ds.rename(velocity="speed"), '"velocity" is missing or'),
    "rename variable": (lambda ds: ds.rename(rise_quantile="q"), "lacks rise_quantile"),
    "drop_vars": (lambda ds: ds.drop_vars("status"), "has no status"),
    "stack": (lambda ds: ds.stack(p=("load", "velocity")), "call ds.unstack() first"),
    "swap_dims": (lambda ds: ds.assign_coords(v=2 * ds["velocity"]).swap_dims(velocity="v"),
                  'velocity is no dimension of the dataset; call ds.swap_dims(v="velocity") first'),
    "drop_attrs": (lambda ds: ds.drop_attrs(), "has no attribute sweep"),
    "one quantile": (lambda ds: ds.sel(area_fraction_below=0.9),
                     "area_fraction_below is a single value; select a list instead: "
                     "ds.sel(area_fraction_below=[0.9])"),
    "end without columns": (lambda ds: ds.drop_vars(COLUMNS, errors="ignore").sel(step=0),
                            "; keep all of its variables"),
    "other places": (lambda ds: ds.assign_coords(load=ds["load"].values[::-1]), "sort it"),
}  # fmt: skip


@pytest.mark.parametrize("operation", REFUSED)
def test_a_dataset_without_meaning_is_refused_in_a_line(ds, operation):
    change, text = REFUSED[operation]
    changed = change(ds)
    for answer in (lambda: rise_of(changed), lambda: pipeline.boundary(changed)):
        with pytest.raises(InputError) as error:
            answer()
        assert text in str(error.value)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("fraction", [0.1, 0.12, 0.034, 0.0, 0.5])
def test_left_out_quantiles_are_refused_where_they_would_change_the_rise(ds, fraction):
    condition, quantiles = {"critical_area_fraction": fraction}, ds["area_fraction_below"].values
    rise, share = rise_of(ds, **condition), 1 - fraction
    refused = 0
    for start in range(4):
        thinned = ds.isel(area_fraction_below=slice(start, None, 4))
        kept = thinned["area_fraction_below"].values
        nearest = {0.9}  # of the scene, for the warnings of points
        nearest.add(quantiles[quantiles <= share + 1e-9].max())
        nearest.add(quantiles[quantiles >= share - 1e-9].min())
        if nearest <= {*kept}:
            assert rise_of(thinned, **condition) == pytest.approx(rise, rel=1e-12)
        else:
            refused += 1
            with pytest.raises(InputError, match="the dataset lacks area_fraction_below"):
                rise_of(thinned, **condition)
    assert refused >= 3


def test_a_file_of_plain_xarray_is_refused_since_it_lacks_the_tests(tiny_store, tmp_path):
    plain = xr.open_zarr(tiny_store, chunks=None)
    assert np.isfinite(rise_of(plain))
    for write in (file_of, store_of):
        with pytest.raises(InputError, match=r"scene and tests; use one from pipeline\.open"):
            rise_of(write(plain.drop_vars("message", errors="ignore").drop_encoding(), tmp_path))
