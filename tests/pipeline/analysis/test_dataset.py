"""The labelled view of a stored sweep (pipeline/analysis/dataset.py)."""

import pickle
import re
from dataclasses import asdict, replace

import numpy as np
import pint
import pytest
import xarray as xr

import tribo
from pipeline import (
    Conditions,
    boundary,
    end_of_point,
    margin,
    open_sweep,
    run_point,
    temperatures,
    warned,
)
from pipeline.store.schema import MADE, STEPPED
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.stores import commit
from tests.helpers.sweeps import deciding_rise
from tests.pipeline.conftest import commit_all
from tribo.thermal import rise_exceeded

CONDITIONS = Conditions(0.1, 298.15, 418.15)
DERIVED = ("max_temperature", "mean_temperature", "temperature_quantile", "failed_fraction")


@pytest.fixture(scope="module")
def ds(alone):
    with open_sweep(alone) as opened:
        yield opened


@pytest.mark.parametrize("load", tiny.LOADS[:2])
def test_every_variable_is_known_at_each_of_a_points_own_steps_and_before_at_none(ds, load):
    rows = ds.sel(load=load)
    assert ds["step"].values.tolist() == [-4, -3, -2, -1, 0]
    count = {150.0: 3, 250.0: 2}[load]  # 150 N is on a trunk of smaller increments
    assert (rows["steps"] == count).all()
    assert not rows["own_grid"][..., :-count].any()
    for name in STEPPED.keys() & rows.data_vars.keys() | MADE.keys():
        known = np.isfinite(rows[name].transpose("step", ...).values)
        assert known[-count:].all(), name
        assert not known[:-count].any(), name
    assert (rows["normal_load"].sel(step=0) == load).all()


def test_no_answer_reads_a_step_on_the_grid_of_the_history(tmp_path):
    track = tribo.Track.under(tiny.sweep().scene.pin, tiny.sweep().scene.disk, 0.34)
    kept = tribo.Corrections(track=track)
    coarser = {"history_coarsening": 2, "increments": 6}
    wide = tribo.Grid((96, 16), (4.3e-6, 15e-6))
    sweep = tiny.sweep(pixels=wide, fidelity=coarser)
    corrected = changed(sweep, conditions=replace(sweep.conditions, corrections=kept))
    for number, one in enumerate((sweep, corrected)):
        commit_all(tmp_path / f"{number}.zarr", one)
        ds = open_sweep(tmp_path / f"{number}.zarr").load()
        on_way = ~ds["own_grid"] & ds["max_rise"].notnull()
        assert on_way.isel(step=-2).all()
        other = ds.copy(deep=True)
        for name in STEPPED.keys() & ds.data_vars.keys():
            other[name] = ds[name].where(~on_way, 1e9)
        xr.testing.assert_identical(boundary(ds), boundary(other))
        told, expected = (asdict(margin(one, 500.0, 1.2)) for one in (other, ds))
        assert repr(told) == repr(expected)  # NaN among them


@pytest.mark.parametrize(
    "cut",
    [
        lambda ds: ds.sel(step=0),
        lambda ds: ds.sel(step=0, drop=True),
        lambda ds: ds.chunk(),
        lambda ds: ds.isel(velocity=slice(None, None, -1)),
    ],
)
def test_a_dataset_that_xarray_cut_or_chunked_answers_as_before(ds, cut):
    expected = boundary(ds)["critical_velocity"]
    found = boundary(cut(ds))["critical_velocity"].drop_vars("step", errors="ignore")
    xr.testing.assert_equal(found, expected)
    assert warned(cut(ds)) == warned(ds)


def test_a_dataset_goes_to_another_process_and_answers_there(ds):
    sent = pickle.loads(pickle.dumps(ds))
    assert repr(asdict(margin(sent, 300.0, 1.2))) == repr(asdict(margin(ds, 300.0, 1.2)))


def test_units_are_such_as_other_programs_read(ds):
    registry = pint.UnitRegistry()
    for name, variable in ds.variables.items():
        units = variable.attrs.get("units", "1")
        registry.parse_units("dimensionless" if units == "1" else units)
        assert not re.search(r"[a-z]\d", units), name  # "m3" is not read by pint


def test_temperatures_are_bulk_plus_friction_times_rise(ds):
    last = temperatures(end_of_point(ds).sel(load=600, velocity=1.5))
    np.testing.assert_allclose(
        last["max_temperature"],
        298.15 + 0.1 * run_point(tiny.sweep(), 600, 1.5).state.heat.max_rise,
    )
    np.testing.assert_allclose(last["temperature_quantile"][-1], last["max_temperature"])
    assert last["mean_temperature"] < last["max_temperature"]
    units = {name: "1" if "fraction" in name else "K" for name in DERIVED}
    assert {name: last[name].attrs["units"] for name in DERIVED} == units
    assert all("long_name" in last[name].attrs for name in DERIVED)


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    """Dataset with a hold of three steps, in which wear lets the contact cool."""
    path = tmp_path_factory.mktemp("held") / "held.zarr"
    loading = tribo.Ramp(rate=150.0, reference_load=750.0, hold=240.0)
    sweep = tiny.sweep(loading=loading, steps="course")
    with np.errstate(all="raise", under="ignore"):
        commit_all(path, sweep)
    return open_sweep(path)


def test_a_point_is_as_severe_as_it_is_at_any_time_of_its_hold(held):
    rise = deciding_rise(held, CONDITIONS).sel(load=600.0, velocity=1.0).item()
    point = held.sel(load=600.0, velocity=1.0)
    by_step = point["time"].copy(data=rise_exceeded(point["rise_quantile"].values, 0.1))
    assert rise == by_step.max("step") == by_step.sel(step=-3)
    assert rise > by_step.sel(step=0) + 10
    # Even if the contact is hotter at a lower load, only temperatures at full load count.
    earlier = held.load().copy(deep=True)
    earlier["rise_quantile"].loc[{"step": slice(None, -4)}] *= 10
    assert deciding_rise(earlier, CONDITIONS).sel(load=600.0, velocity=1.0) == rise


def test_the_failed_fraction_is_the_share_hotter_than_critical(copy):
    critical = 350.0
    commit(copy, tiny.full(conditions=Conditions(0.1, 298.15, critical)), ())
    with open_sweep(copy) as ds:
        end = end_of_point(ds).sel(load=600, velocity=1.5)
        fraction = temperatures(end)["failed_fraction"].item()
    state = run_point(tiny.sweep(), 600.0, 1.5).state
    contact = state.pressure > 0
    counted = np.mean(298.15 + 0.1 * state.heat.rise[contact] > critical)
    assert abs(fraction - counted) < 0.02  # between quantiles it is interpolated
    share = tribo.thermal.failed_share(state.heat.rise_quantile, (critical - 298.15) / 0.1)
    assert fraction == pytest.approx(share, abs=1e-12)


def test_a_store_without_a_point_opens(tmp_path):
    commit(tmp_path / "tiny.zarr", tiny.sweep(), ())
    with open_sweep(tmp_path / "tiny.zarr") as ds:
        assert np.isnan(temperatures(ds)["max_temperature"]).all()
