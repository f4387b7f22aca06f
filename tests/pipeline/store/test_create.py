"""Creation and growth of stores, also of ones that were cut short, and refusals."""

import errno
import functools
import http.server
import os
import shutil
import stat
import subprocess
import sys
import threading
from contextlib import contextmanager

import fsspec
import numpy as np
import pytest
import xarray as xr
import zarr
from hypothesis import given, settings
from hypothesis import strategies as st

import pipeline
import tribo
from pipeline import Conditions, StoreError, StoreMismatchError, open_sweep, summary, verify_store
from pipeline.scene.stored_text import parse_sweep
from pipeline.store.create import writing
from pipeline.store.files import PARTIAL
from pipeline.store.lock import locked
from pipeline.store.place import place_of
from pipeline.store.take import take_points
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points
from pipeline.sweep.variants import surfaces
from tests.helpers import tiny
from tests.helpers.entries import changed, rows
from tests.helpers.points import run_point
from tests.helpers.scenes import STEEL
from tests.helpers.stores import (
    assert_is_as_computed,
    commit,
    contents,
    done_points,
    forge,
    killed_after,
    make,
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
        assert ds["cooler_share"].values.tolist() == list(tribo.QUANTILES)
    assert ds.attrs.keys() == {*("Conventions", "title", "source", "history", "license", "scene")}
    kept = parse_sweep(ds.attrs["scene"], {})
    assert kept == sweep
    assert zarr.open_group(path)["about"].attrs["history"] == [ds.attrs["history"]]
    assert f"numpy {np.__version__}" in ds.attrs["history"]


@pytest.mark.parametrize(("changes", "steps"), [({}, 13), ({"steps": "end"}, 1)])
def test_a_course_has_room_for_the_steps_of_twice_the_reference_load(path, changes, steps):
    make(path, tiny.full(**changes))
    with xr.open_zarr(path, chunks=None) as ds:
        assert ds["step"].values.tolist() == [*range(1 - steps, 1)]


def test_a_new_store_opens_in_plain_xarray_without_a_warning(alone):
    command = f"""if True:
        import warnings; warnings.simplefilter("error")
        import xarray as xr
        ds = xr.open_zarr({str(alone)!r})
        assert ds["rise_quantile"].sel(load=600, velocity=1.5).dims == ("step", "cooler_share")
        assert ds["status"].attrs["flag_meanings"] == "pending done failed"
        ds.load()
        for name, variable in ds.variables.items():
            assert "long_name" in variable.attrs, name
            without = "status", "asked", "warning_flags"
            assert "units" in variable.attrs or name in without, name
    """
    subprocess.run([sys.executable, "-c", command], check=True, cwd="/", timeout=60)


@pytest.mark.parametrize("files", [20, 39, 40])
def test_a_creation_cut_short_leaves_no_store_or_a_whole_one(path, monkeypatch, files):
    with killed_after(monkeypatch, files) as was_killed:
        commit(path, SWEEP, [POINT])
    assert was_killed
    if (path / "zarr.json").exists():
        assert (summary(path).done, summary(path).pending) in ((0, 0), (0, 9))  # asked for or not
        assert open_sweep(path).load()["mean_rise"].isnull().all()
    else:
        with pytest.raises(StoreError, match="there is no store at"):
            summary(path)
        with (
            locked(place_of(path)),
            pytest.raises(StoreError, match=f"being made by process {os.getpid()}"),
        ):
            summary(path)
    commit(path, SWEEP, [POINT])
    assert_is_as_computed(path, [POINT])
    assert not list(path.rglob(f"*{PARTIAL}"))


def test_a_folder_whose_names_cannot_be_synced_is_written_all_the_same(path, monkeypatch):
    sync = os.fsync

    def refused(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "Invalid argument")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", refused)
    commit(path, SWEEP, [POINT])
    assert_is_as_computed(path, [POINT])


# Growth


def test_conditions_and_titles_follow_the_scene_file(path):
    commit(path, SWEEP, [POINT])
    commit(
        path, tiny.full(title="Renamed", conditions=Conditions(0.2, 300.0, 420.0), measured=()), ()
    )
    kept = opened(path).sweep
    assert kept.title == "Renamed"
    assert kept.conditions.friction == 0.2
    assert kept._measured == ()
    assert_is_as_computed(path, [POINT])


def test_points_of_earlier_runs_are_counted_apart(path):
    commit(path, SWEEP, points(SWEEP)[:3])
    commit(path, changed(SWEEP, loads=(600.0,)), ())
    now = summary(path)
    assert (now.total, now.done, now.pending, now.earlier) == (3, 1, 2, 2)
    with xr.open_zarr(path, chunks=None) as ds:
        warned = ds["warning_flags"].where(ds["status"] == 1, 0) != 0
        assert warned.sel(load=slice(0, 500)).any()
        assert now.warned == warned.sum()


@pytest.mark.parametrize("killed", ["early", "early, root lost", "after the root", "never"])
def test_a_growth_killed_before_any_change_of_a_file_costs_no_point(path, monkeypatch, killed):
    commit(path, SWEEP, [POINT])
    if "lost" in killed:
        zarr.open_group(path, use_consolidated=False).attrs["mine"] = 1
    files = {"after the root": 0, "never": 10**6}.get(killed, 8)
    since = path / "zarr.json" if files == 0 else None
    with killed_after(monkeypatch, files, since) as was_killed:
        commit(path, LARGER, [ADDED])
    assert bool(was_killed) == (killed != "never")
    with open_sweep(path) as ds:
        assert ds.sizes["load"] == (3 if "early" in killed else 5)
        ds.load()
    assert_is_as_computed(path, [POINT] if was_killed else [POINT, ADDED])
    assert verify_store(path).is_clean
    other = Point(1500.0, 3.0)  # a selection other than the interrupted one
    commit(path, tiny.full(loads=(1500.0,), velocities=(3.0,)), [other])
    assert_is_as_computed(path, [POINT, other] if was_killed else [POINT, ADDED, other])
    assert verify_store(path).is_clean
    assert not list(path.rglob(f"*{PARTIAL}"))


# Points of another store


@settings(max_examples=5, deadline=None)
@given(
    rounds=st.lists(
        st.tuples(
            st.sets(st.sampled_from([100.0, 250.0, 900.0]), min_size=1),
            st.sets(st.sampled_from([0.25, 0.5]), min_size=1),
        ),
        min_size=2,
        max_size=3,
    )
)
def test_a_sweep_that_grows_anyhow_goes_on_with_each_point_as_computed(tmp_path_factory, rounds):
    folder, path, loads, velocities = tmp_path_factory.mktemp("grown"), None, set(), set()
    for number, (more_loads, more_velocities) in enumerate(rounds):
        loads |= more_loads
        velocities |= more_velocities
        sweep = tiny.full(loads=tuple(sorted(loads)), velocities=tuple(sorted(velocities)))
        before, path = path, path or folder / "first.zarr"
        fits = not before or begins(sweep, before)
        if not fits:
            with pytest.raises(StoreError, match=f"irg run SCENE -o NEW --from {before}"):
                commit(before, sweep, ())
            path = folder / f"{number}.zarr"
        with writing(path, sweep) as store:
            if not fits:
                assert take_points(store, opened(before)) == len(done_points(before))
            store.commit([record(point) for point in store.pending()])
    assert_is_as_computed(path, points(sweep))
    assert verify_store(path).is_clean


def begins(sweep, path):
    """True if the sweep's loads and velocities begin with those of the store."""
    held, plane = opened(path).axes, sweep
    axes = [(held["load"], plane.loads), (held["velocity"], plane.velocities)]
    return all(list(values[: len(old)]) == old for old, values in axes)


def test_points_are_taken_by_scene_and_place_and_only_if_they_are_sound(path, tmp_path):
    commit(path, SWEEP)
    other = tiny.full(
        variants=rows("pin", {"own": {}, "thick": {"pin.radius": 9e-3, "pin.length": 3e-3}})
    )
    with writing(tmp_path / "rows.zarr", other) as store:  # its first row is the scene of the store
        assert take_points(store, opened(path)) == 9
        assert {point.variant for point in store.pending()} == {(("pin", "thick"),)}
    assert verify_store(tmp_path / "rows.zarr").is_clean
    with writing(path, SWEEP) as store:
        values = store.read("mean_rise", store.index(POINT)) + 1.0
        store.write({store.index(POINT): {"mean_rise": values}}, {})
    before = contents(path)
    with writing(tmp_path / "sound.zarr", SWEEP) as store:
        assert take_points(store, opened(path)) == 8
        assert store.pending() == [POINT]
    assert contents(path) == before
    for unlike in ({"increments": 7}, {"steps": "end"}, {"roughness": None}):
        with writing(tmp_path / f"{', '.join(unlike)}.zarr", tiny.full(**unlike)) as store:
            assert take_points(store, opened(path)) == 0


def several(**changes):
    return tiny.sweep(loads=(150.0,), velocities=(0.5, 1.0), **changes)


def test_surfaces_are_added_to_those_that_are_there(path, monkeypatch):
    fewer, more = (several(variants=surfaces(seeds)) for seeds in ((4, 1), (7, 1, 4)))
    chosen = points(fewer)[1::2]
    with writing(path, fewer) as store:
        store.commit(run_point(fewer, point).record(with_fields=False) for point in chosen)
    before = open_sweep(path).load()
    with killed_after(monkeypatch, 8), writing(path, more):
        pass
    with open_sweep(path) as ds:
        (name,) = more.variants.axes
        after = ds.sel({name: before[name]}).load()
    for name in set(before.data_vars) - {"asked"}:
        np.testing.assert_array_equal(after[name].values, before[name].values)
    with writing(path, more) as store:
        assert len(store.pending()) == len(points(more)) - len(chosen)
    assert verify_store(path).is_clean


# Refusals


def test_the_store_of_another_scene_is_refused_key_by_key(alone):
    other = tiny.full(increments=7, pin=tribo.Cylinder(9e-3, 3.375e-3, STEEL), wear=None)
    before = contents(alone)
    with pytest.raises(StoreMismatchError) as refused:
        commit(alone, other, ())
    assert str(refused.value).splitlines()[1:] == [
        "  pin.radius: 8 mm in the store, 9 mm in the scene",
        "  wear.specific_wear_rate: 1.2e-06 mm³/(N m) in the store, none in the scene",
        "  wear.pattern: swept in the store, none in the scene",
        "  fidelity.increments: 6 in the store, 7 in the scene",
    ]
    assert contents(alone) == before


@pytest.mark.parametrize(
    ("made", "asked", "complaint"),
    [
        ({}, {"fields": True}, "sweep.fields: false in the store, true in the scene"),
        ({}, {"variants": surfaces((1,))}, "none in the store, realization in"),
        ({"variants": surfaces((1,))}, {}, "realization in the store, none in"),
    ],
    ids=["fields later", "surfaces later", "surfaces before"],
)
def test_a_sweep_that_does_not_fit_the_store_is_refused(path, made, asked, complaint):
    commit(path, several(**made), ())
    before = contents(path)
    with pytest.raises(StoreMismatchError, match=complaint):
        commit(path, several(**asked), ())
    assert contents(path) == before


def test_a_whole_number_is_the_same_as_its_float(path):
    commit(path, tiny.sweep(loading=tribo.Ramp(150, 750)), ())
    commit(path, tiny.sweep(loading=tribo.Ramp(150.0, 750.0)), ())


def a_file(path):
    path.write_text("years of work")


def a_folder(path):
    path.mkdir()
    (path / "thesis.tex").write_text("years of work")


def a_folder_named_like_a_variable(path):
    (path / "load").mkdir(parents=True)
    (path / "load" / "mine.csv").write_text("years of work")


def a_group_of_somebody_else(path):
    zarr.create_group(path, attributes={"title": "something else"})


def without_root(path):
    commit(path, SWEEP, [POINT])
    (path / "zarr.json").unlink()


def of_another_format(path):
    commit(path, SWEEP, [POINT])
    forge(path, path / "zarr.json", lambda texts, _: texts["store"].update(format=99))


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (a_file, "is no store"),
        (a_folder, "is no store: it is a folder with other files"),
        (a_folder_named_like_a_variable, "is no store"),
        (a_group_of_somebody_else, "zarr.json is that of another program"),
        (without_root, "has lost its zarr.json; restore it from a backup, or run the scene into"),
        (of_another_format, "of another version of this program: of format 99, and not"),
    ],
)
def test_nothing_is_written_over(path, make, complaint):
    make(path)
    before = contents(path.parent)
    for sweep in (SWEEP, tiny.sweep(increments=7)):
        with pytest.raises(StoreError, match=complaint):
            commit(path, sweep, ())
    if path.exists():
        with pytest.raises(StoreError, match=complaint):
            summary(path)
    assert contents(path.parent) == before


def test_the_names_of_new_folders_are_on_the_disk_too(tmp_path, monkeypatch):
    synced, fsync = [], os.fsync

    def logged(descriptor):
        synced.append(os.fstat(descriptor).st_ino)
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", logged)
    make(tmp_path / "new" / "tiny.zarr", SWEEP)
    assert {folder.stat().st_ino for folder in (tmp_path, tmp_path / "new")} <= set(synced)


def test_a_store_is_written_at_a_file_address_and_only_read_at_other_addresses(tmp_path):
    commit(f"file://{tmp_path}/tiny.zarr", SWEEP, [POINT])
    assert summary(tmp_path / "tiny.zarr").done == 1
    address = f"memory://{os.getpid()}/tiny.zarr"
    memory = fsspec.filesystem("memory")
    memory.put(str(tmp_path / "tiny.zarr"), f"/{os.getpid()}/tiny.zarr", recursive=True)
    assert summary(address).done == 1
    assert verify_store(address).is_clean
    with pytest.raises(StoreError, match="can only be read; write to a folder, or to an s3:// ad"):
        commit(address, LARGER, [ADDED])
    with open_sweep(address) as ds, xr.open_zarr(address, chunks=None) as plain:
        np.testing.assert_array_equal(ds["status"], plain["status"])


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves a folder without a word."""

    def log_message(self, *_):
        pass


class Unlisted(Quiet):
    """Serves files, and lists none."""

    def list_directory(self, _):
        self.send_error(404)


@contextmanager
def web(handler, folder):
    """Context manager: the address of a folder on a web server of this machine."""
    handler = functools.partial(handler, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_a_zip_file_of_a_store_and_a_web_address_are_read_as_the_store_is(copy, tmp_path):
    right = pipeline.boundary(copy)
    with web(Quiet, copy.parent) as address:
        places = (
            shutil.make_archive(tmp_path / "content", "zip", copy),
            shutil.make_archive(tmp_path / "inside", "zip", copy.parent, copy.name),
            f"{address}/{copy.name}",
        )
        for place in places:
            xr.testing.assert_identical(pipeline.boundary(place), right)
            assert verify_store(place) == verify_store(copy)
            with pytest.raises(StoreError, match="can only be read; write to a folder, or to an s"):
                commit(place, LARGER, [ADDED])


def test_a_web_server_that_lists_no_files_is_named_and_not_called_damage(copy):
    with web(Unlisted, copy.parent) as address:
        for ask in (pipeline.boundary, verify_store):
            with pytest.raises(StoreError, match="does not list its files; copy the store to a f"):
                ask(f"{address}/{copy.name}")


def test_a_name_that_is_too_long_is_a_store_error(tmp_path):
    with pytest.raises(StoreError, match="File name too long"):
        summary(tmp_path / ("a" * 265))


def test_a_store_without_its_fields_answers_and_a_lost_status_is_told(copy):
    right = pipeline.boundary(copy)["critical_velocity"].values
    shutil.rmtree(copy / "fields")
    np.testing.assert_array_equal(pipeline.boundary(copy)["critical_velocity"].values, right)
    shutil.rmtree(copy / "status")
    for ask in (pipeline.boundary, summary):
        with pytest.raises(StoreError, match="status cannot be read; irg verify names"):
            ask(copy)
