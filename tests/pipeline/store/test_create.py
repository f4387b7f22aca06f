"""Creation and growth of stores, interrupted or not, and refusals."""

import errno
import os
import stat
import warnings

import numpy as np
import pytest
import xarray as xr
import zarr

import tribo
from pipeline import StoreError, StoreMismatchError, open_sweep, summary, verify_store
from pipeline.paths import PARTIAL
from pipeline.store.create import writing
from pipeline.store.location import location_of
from pipeline.store.lock import locked
from pipeline.store.points import copy_points
from pipeline.sweep.case_table import surface_table
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.entries import rows
from tests.helpers.kept import assert_as_kept, refusal, relative
from tests.helpers.points import run_point
from tests.helpers.scenes import STEEL
from tests.helpers.stores import (
    assert_is_as_computed,
    commit,
    contents,
    killed_after,
    opened,
    record,
)

SWEEP, POINT = tiny.full(), Point(250.0, 1.0)
LARGER = tiny.full(loads=(150.0, 700.0, 1500.0), velocities=(0.5, 2.0))
ADDED = Point(1500.0, 2.0)


# Creation


def test_axes_are_exact_and_attributes_say_what_was_computed(path):
    sweep = tiny.sweep(loads=(0.1 + 0.2, 100 / 3), velocities=(1 / 7, 1.1))
    commit(path, sweep, ())
    with xr.open_zarr(path, chunks=None) as ds:
        assert tuple(ds["load"].values) == sweep.loads
        assert tuple(ds["velocity"].values) == sweep.velocities
        assert ds["area_fraction_below"].values.tolist() == list(tribo.QUANTILES)
    texts = "Conventions", "title", "source", "history", "license", "scene", "stored_steps"
    assert ds.attrs.keys() == {*texts, "sweep_digest"}
    assert opened(path).sweep == sweep
    assert zarr.open_group(path, use_consolidated=False)["about"].attrs["history"] == [
        ds.attrs["history"]
    ]
    assert f"numpy {np.__version__}" in ds.attrs["history"]


def test_a_new_store_opens_in_plain_xarray_without_a_warning(tiny_store):
    with warnings.catch_warnings(action="error"):
        ds = xr.open_zarr(tiny_store).load()
    quantiles = ds["rise_quantile"].sel(load=600, velocity=1.5)
    assert quantiles.dims == ("step", "area_fraction_below")
    assert ds["status"].attrs["flag_meanings"] == "not_needed done failed pending"
    for name, variable in ds.variables.items():
        assert "long_name" in variable.attrs, name
        assert "units" in variable.attrs or name in ("status", "warning_flags"), name


@pytest.mark.parametrize("files", [1, 20])
def test_a_creation_cut_short_leaves_no_store(path, monkeypatch, files):
    with killed_after(monkeypatch, files) as was_killed:
        commit(path, SWEEP, [POINT])
    assert was_killed
    assert not path.exists()
    assert refusal(summary, path) == f"a run ended while it created {path}; run its scene again"
    with (
        locked(location_of(path)),
        pytest.raises(StoreError, match=f"being created by process {os.getpid()}"),
    ):
        summary(path)
    commit(path, SWEEP, [POINT])
    assert_is_as_computed(path, [POINT])
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    assert not list(path.rglob(f"*{PARTIAL}"))


def test_the_names_of_new_folders_are_on_the_disk_too_if_it_can_sync_them(path, monkeypatch):
    synced, fsync = [], os.fsync

    def logged(descriptor):
        fsync(descriptor)
        synced.append(os.fstat(descriptor).st_ino)
        if path.exists() and stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(os, "fsync", logged)
    commit(path / "new.zarr", SWEEP, [POINT])
    assert {folder.stat().st_ino for folder in (path.parent, path)} <= set(synced)
    assert_is_as_computed(path / "new.zarr", [POINT])


# Growth


@pytest.mark.parametrize("files", [1, 30])
def test_a_growth_killed_before_any_change_of_a_file_costs_no_point(path, monkeypatch, files):
    commit(path, SWEEP, [POINT])
    with killed_after(monkeypatch, files) as was_killed:
        commit(path, LARGER, [ADDED])
    assert was_killed
    with open_sweep(path) as ds:
        assert ds.load().sizes["load"] == 3
    assert_is_as_computed(path, [POINT])
    assert verify_store(path).is_clean
    other = Point(1500.0, 3.0)  # a selection other than the interrupted one
    commit(path, tiny.full(loads=(1500.0,), velocities=(3.0,)), [other])
    assert_is_as_computed(path, [POINT, other])
    assert verify_store(path).is_clean
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_points_with_fields_are_taken_over_by_a_larger_store_and_by_a_new_one(path, tmp_path):
    commit(path, SWEEP)
    commit(path, tiny.full(loads=(200.0,)), ())  # between two loads: all indices above it change
    with writing(tmp_path / "new.zarr", SWEEP) as store:
        assert copy_points(store, opened(path)) == 9
    for store_path in (path, tmp_path / "new.zarr"):
        assert_is_as_computed(store_path, points(SWEEP))
        assert verify_store(store_path).is_clean


def test_a_dataset_that_was_opened_before_its_store_was_replaced_shows_no_number_of_others(path):
    def opened_plainly():
        datasets = [xr.open_zarr(path, group=group) for group in (None, "about", "fields")]
        return [ds.drop_vars("wall_time", errors="ignore") for ds in datasets]

    first = tiny.full(loads=(150.0, 600.0), velocities=(0.5, 1.5))
    commit(path, first)
    opened_before = [opened_plainly()]
    # Indices of points change, and change back.
    for load, velocity in ((200.0, 0.5), (100.0, 0.5), (900.0, 0.5), (600.0, 1.0)):
        stale_ds = open_sweep(path)
        commit(path, tiny.full(loads=(load,), velocities=(velocity,)))
        reopened = [ds.load() for ds in opened_plainly()]
        for name in stale_ds.data_vars.keys() - {"status"}:
            assert refusal(stale_ds[name].compute) == (
                f"{path} was enlarged or repaired since it was opened; open it again"
            )
        for datasets in opened_before:
            for old in (variable for ds in datasets for variable in ds.data_vars.values()):
                with pytest.raises((RuntimeError, ValueError), match=r"checksum|decompression"):
                    old.compute()
        for point in points(first):
            rise = reopened[2]["rise"].sel(load=point.load, velocity=point.velocity)
            np.testing.assert_array_equal(rise, record(point).data["rise"])
        opened_before.append(opened_plainly())
    assert verify_store(path).is_clean


@pytest.mark.parametrize("seeds", [(1, 7), None])
def test_surfaces_are_added_to_those_that_are_there_and_the_first_keeps_the_fields(
    path, monkeypatch, seeds
):
    axes = {"loads": (150.0,), "velocities": (0.5,)}
    sweep = tiny.full(**axes, **{"case_table": surface_table(seeds)} if seeds else {})
    with writing(path, sweep) as store:
        fields = [(point, store.sweep.fields_of(point.case) is True) for point in points(sweep)]
        store.commit(
            run_point(sweep, point).record(with_fields=has_fields) for point, has_fields in fields
        )
    before = open_sweep(path).load()
    more = tiny.full(**axes, case_table=surface_table((1, 7, 8)))
    with killed_after(monkeypatch, 8), writing(path, more):
        pass
    assert open_sweep(path).load().drop_attrs().equals(before.drop_attrs())
    with writing(path, more) as store:
        assert len(store.pending()) == 3 - len(fields)
        assert not any(store.sweep.fields_of(point.case) for point in store.pending())
        rest = [run_point(more, point).record(with_fields=False) for point in store.pending()]
        store.commit(rest)
    ds = open_sweep(path)
    expected = run_point(more, Point(150.0, 0.5, (("realization", 1),))).fields["rise"]
    fields = xr.open_zarr(path, group="fields", chunks=None)
    assert fields["rise"].dims == ("load", "velocity", "x", "y")
    assert fields["rise"].coords["field_realization"].item() == 1
    assert [file.name for file in path.glob("fields/rise/c.*")] == ["c.0.0.0.0"]
    np.testing.assert_array_equal(fields["rise"].squeeze(), expected.astype(np.float32))
    with pytest.raises(KeyError):  # it would show realization 7 beside the fields of 1
        ds.sel(realization=7)["rise"]
    tree = xr.open_datatree(path, engine="zarr", chunks=None)
    for of_one_surface in (fields, tree["fields/rise"]):
        with pytest.raises(KeyError, match="not a valid dimension"):
            of_one_surface.sel(realization=7)
    assert verify_store(path).is_clean


def test_points_are_taken_by_scene_and_place_and_only_if_they_are_sound(path, tmp_path):
    commit(path, SWEEP)
    other = tiny.full(
        case_table=rows("pin", {"own": {}, "thick": {"pin.radius": 9e-3, "pin.length": 3e-3}})
    )
    with writing(tmp_path / "rows.zarr", other) as store:  # its first row is the scene of the store
        assert copy_points(store, opened(path)) == 9
        assert {point.case for point in store.pending()} == {(("pin", "thick"),)}
    assert verify_store(tmp_path / "rows.zarr").is_clean
    with writing(path, SWEEP) as store:
        store.arrays["mean_rise"][store.index(POINT)] = np.nan
    before = contents(path)
    with writing(tmp_path / "sound.zarr", SWEEP) as store:
        assert copy_points(store, opened(path)) == 8
        assert store.pending() == [POINT]
    assert contents(path) == before
    for unlike in ({"increments": 7}, {"steps": "end"}, {"roughness": None}):
        with writing(tmp_path / f"{', '.join(unlike)}.zarr", tiny.full(**unlike)) as store:
            assert copy_points(store, opened(path)) == 0


def several(**changes):
    return tiny.sweep(**{"loads": (150.0,), "velocities": (0.5, 1.0)} | changes)


# Refusals


def test_the_store_of_another_scene_is_refused_key_by_key(tiny_store):
    other = tiny.full(increments=7, pin=tribo.Cylinder(9e-3, 3.375e-3, STEEL), wear=None)
    before = contents(tiny_store)
    with pytest.raises(StoreMismatchError) as refused:
        commit(tiny_store, other, ())
    assert str(refused.value).splitlines() == [
        f"{tiny_store} belongs to another scene: use the values of the store, or write to another "
        "store",
        "  pin.radius: 0.008 in the store, 0.009 in the scene",
        "  wear: Wear in the store, none in the scene",
        "  fidelity.increments: 6 in the store, 7 in the scene",
    ]
    assert contents(tiny_store) == before


def test_the_store_of_a_goal_says_how_to_extend_it(path):
    with writing(path, several(), accuracy=0.025):
        pass
    message = refusal(commit, path, several(increments=7), ())
    assert message.splitlines()[-1] == "  to extend the store: irg run SCENE --accuracy 2.5%"


MISFITS = {
    "fields later": ({}, {"fields": True}),
    "other steps": ({}, {"steps": "end"}),
    "other surfaces": ({}, {"case_table": surface_table((9,))}),
    "fewer surfaces": ({"case_table": surface_table((0, 1))}, {}),
    "equal within rounding": ({}, {"loads": (150.0, 150.0 * (1 + 1e-12))}),
}  # what the store has, and what the sweep has


def test_sweeps_that_do_not_fit_a_store_are_refused_in_words_that_are_kept(tmp_path):
    texts = {}
    for number, (kind, (stored, requested)) in enumerate(MISFITS.items()):
        path = tmp_path / f"{number}.zarr"
        commit(path, several(**stored), ())
        before = contents(path)
        texts[kind] = relative(refusal(commit, path, several(**requested), ()), tmp_path)
        assert contents(path) == before
    assert_as_kept("refusals_of_misfits", texts)


def laid(name):
    """Function that writes a file of a user at a name below the path."""

    def lay(path):
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).write_text("years of work")

    return lay


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (laid(""), "is not a store"),
        (laid("thesis.tex"), "is not a store: it is a folder with other files"),
        (laid("load/mine.csv"), "is not a store"),
    ],
)
def test_nothing_is_written_over(path, make, complaint):
    make(path)
    before = contents(path.parent)
    for sweep in (SWEEP, tiny.sweep(increments=7)):
        with pytest.raises(StoreError, match=complaint):
            commit(path, sweep, ())
    assert contents(path.parent) == before
