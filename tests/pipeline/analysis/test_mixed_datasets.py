"""Points of several scenes in one dataset are refused; points of one scene are answered."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import Conditions
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.helpers.stores import commit
from tests.pipeline.conftest import commit_all
from tribo import InputError

PINS = {"a": {"pin.radius": 8e-3}, "b": {"pin.radius": 6e-3}}


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Folder with stores: two parts of a scene, one with other friction, and one of two pins."""
    folder = tmp_path_factory.mktemp("mixed")
    sweeps = {
        "low": tiny.sweep(loads=(150.0, 250.0)),
        "high": tiny.sweep(loads=(600.0,)),
        "rubbing": tiny.sweep(loads=(600.0,), conditions=Conditions(0.2, 298.15, 418.15)),
        "pins": tiny.sweep(variants=rows("pin", PINS)),
    }
    for name, sweep in sweeps.items():
        commit_all(folder / f"{name}.zarr", sweep)
    return folder


@pytest.fixture
def parts(stores):
    return lambda *names: [pipeline.open_sweep(stores / f"{name}.zarr") for name in names]


def joined(parts, dim="load", **options):
    usual = {"data_vars": "all", "coords": "different", "compat": "equals", "join": "outer"}
    return xr.concat(parts, dim, **usual | options)


def crossings(ds):
    return pipeline.boundary(ds)["critical_velocity"].values


def test_parts_of_one_scene_answer_as_its_own_store(parts, tmp_path):
    commit(tmp_path / "whole.zarr", tiny.full())
    whole = crossings(pipeline.open_sweep(tmp_path / "whole.zarr"))
    np.testing.assert_array_equal(crossings(joined(parts("low", "high"))), whole)


def test_points_of_another_scene_are_refused_with_their_loads(parts):
    both = joined(parts("low", "rubbing"))
    asks = (
        crossings,
        pipeline.temperatures,
        pipeline.end_of_point,
        lambda ds: pipeline.margin(ds, 200.0, 1.0),
        lambda ds: pipeline.at(ds, friction=0.15),
    )
    for ask in asks:
        with pytest.raises(InputError, match="points at load 600 N are of another scene"):
            ask(both)
    assert crossings(both.sel(load=[150.0, 250.0])).shape == (2,)


def test_rows_of_a_table_are_told_apart(parts):
    (pins,) = parts("pins")
    one, other = pins.isel(pin=0, load=[0, 1]), pins.isel(pin=1, load=[2])
    with pytest.raises(InputError, match="points at load 600 N are of another scene"):
        crossings(joined([one, other], coords="minimal", compat="override"))
    for lost in (joined([one, other]), joined([x.drop_vars("pin") for x in (one, other)])):
        with pytest.raises(InputError, match="has lost its coordinate pin"):
            crossings(lost)
    swapped = pins.assign_coords(pin=("pin", ["b", "a"]))
    with pytest.raises(InputError, match="mixes scenes"):
        crossings(swapped)
