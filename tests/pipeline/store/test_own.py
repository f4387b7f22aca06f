"""What users add to a store stays, and is in nobody's way; what they copy of it is read.

What commands keep there is in nobody's way, either.
"""

import warnings

import numpy as np
import pytest
import xarray as xr
import zarr

import pipeline
import tribo
from pipeline.answers.results import cases_of
from pipeline.run.serial import run_serial
from pipeline.store.create import writing
from pipeline.store.schema import FIELDS
from pipeline.sweep.case_table import surfaces
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import bare_test, changed, rows
from tests.helpers.points import run_point
from tests.helpers.stores import commit, record
from tests.pipeline.conftest import commit_all
from tribo import InputError

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
    assert "points: 9 done and undamaged, 0 damaged" in irg("verify", copy)
    xr.testing.assert_identical(pipeline.boundary(copy).drop_attrs(), boundary.drop_attrs())
    with pipeline.open_sweep(copy) as ds:
        ds.load()
    assert pipeline.run_sweep(SWEEP, copy, workers=1).computed == 0
    with pytest.raises(pipeline.StoreError, match=r"doubled/.*, which is not of this"):
        commit(copy, tiny.full(loads=(700.0,)), ())
    other = changed(SWEEP, title="Another title")  # writes another root document
    assert pipeline.run_sweep(other, copy, workers=1).computed == 0
    with xr.open_zarr(copy, chunks=None) as ds:
        assert (ds.attrs["comment"], ds.attrs["title"]) == ("mine", "Another title")
        np.testing.assert_array_equal(ds["doubled"], 2 * before["max_rise"])
    group = zarr.open_group(copy, use_consolidated=False)
    assert group["max_rise"].attrs["note"] == "mine, too"


def test_attributes_of_users_stay_in_a_larger_store(copy):
    group = zarr.open_group(copy, use_consolidated=False)
    group.attrs["mine"], group["max_rise"].attrs["note"] = "x", 3
    commit(copy, tiny.full(loads=(700.0,)), ())
    with xr.open_zarr(copy, chunks=None) as ds:
        assert (ds.sizes["load"], ds.attrs["mine"], ds["max_rise"].attrs["note"]) == (4, "x", 3)
    assert pipeline.verify_store(copy).is_clean


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
PLANE = {"loads": (150.0, 600.0), "velocities": (0.5, 1.5)}
SWEEPS = {
    "plane": tiny.full(**PLANE),
    "surfaces": tiny.full(case_table=surfaces((1, 2)), **PLANE),
    "rows": tiny.full(case_table=rows("ramp", RAMPS, velocities=(1.5, 0.5)), loads=(150.0, 600.0)),
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


CUT = {
    "whole": lambda ds: ds,
    "lazy, of some loads": lambda ds: ds.sel(load=[150.0, 250.0]),
    "in memory": lambda ds: ds.isel(velocity=[0, 2]).load(),
}


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    """A store of a sweep with two tests."""
    path = tmp_path_factory.mktemp("tested") / "tested.zarr"
    commit_all(path, tiny.full(tests=(bare_test(250.0, 1.0), bare_test(600.0, 0.5))))
    return path


@pytest.mark.parametrize("cut", CUT.values(), ids=[*CUT])
def test_a_dataset_of_plain_xarray_is_answered_with_its_tests(cut, tested):
    plain, own = cut(xr.open_zarr(tested)), cut(pipeline.open_sweep(tested))
    xr.testing.assert_identical(pipeline.boundary(plain), pipeline.boundary(own))
    at = {"load": [200.0, 240.0], "velocity": 1.2}
    xr.testing.assert_identical(pipeline.margin(plain, **at), pipeline.margin(own, **at))
    assert "test_rise_quantile" not in plain.variables


def test_a_dataset_that_lost_its_sweep_and_its_store_says_so(made):
    with pytest.raises(InputError, match=r"no attribute sweep.*pipeline\.open_sweep"):
        cases_of(xr.open_zarr(made).drop_encoding())


@pytest.mark.parametrize("name", PLAIN)
def test_plain_xarray_works_on_whole_and_half_done_sweeps(opened, name):
    for ds in opened:
        assert ds.chunks is not None  # fails if chunks along an axis differ in length
        assert {values.dtype.kind for values in ds.data_vars.values()} <= {*"bif"}
        assert PLAIN[name](ds, "load" if "load" in ds.dims else "point").load().data_vars


def test_fields_at_steps_are_those_of_each_step_and_of_the_end(path, alone):
    place = {"load": 600.0, "velocity": 1.5}
    with writing(path, tiny.full(fields="steps")) as store:
        run_serial(store, [Point(**place), Point(250.0, 1.5)])
    assert pipeline.verify_store(path).is_clean
    with pipeline.open_sweep(path) as ds, pipeline.open_sweep(alone) as ends:
        steps, end = ds.sel(place), ends.sel(place)
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
    assert pipeline.plot(path, "fields", load="600 N", step=-2)
    for step, why in ((-9, "the point has the steps -4 to 0"), (1, "the point has the steps")):
        with pytest.raises(InputError, match=why):
            pipeline.plot(path, "fields", step=step)
    with pytest.raises(InputError, match="at the end of each point alone"):
        pipeline.plot(alone, "fields", step=-1)


def test_fields_lie_in_a_group_of_their_own(copy):
    fields = xr.open_zarr(copy, group="fields")
    rise = record(Point(600.0, 1.5)).data["rise"]
    np.testing.assert_array_equal(fields["rise"][-1], rise)
    assert (fields["load"][-1], fields["velocity"][-1]) == (600.0, 1.5)
