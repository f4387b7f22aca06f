"""The store (pipeline/store/points.py, folder.py, layout.py and lock.py)."""

import dataclasses
import errno
import json
import multiprocessing
import os
import pickle
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr
from hypothesis import given, settings
from hypothesis import strategies as st
from pipeline.store.variables import COLUMNS, COORDINATES, FIELDS

import tribo
from pipeline.store import (
    DONE,
    PENDING,
    FailedPoint,
    Store,
    StoreError,
    StoreMismatchError,
    files,
    locked,
    prepare,
    remove_partial,
    summary,
)
from pipeline.store.identity import describe
from pipeline.sweep.criterion import Conditions
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny
from tests.pipeline.conftest import commit_all

SWEEP = tiny.sweep()
POINT = Point(250.0, 1.0)


class Killed(BaseException):
    """The process ends here, as far as the store can tell."""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "tiny.zarr"


@pytest.fixture
def copy(alone, tmp_path):
    return shutil.copytree(alone, tmp_path / "copy.zarr")


@pytest.fixture
def store(path):
    """A store with one point."""
    store = prepare(path, SWEEP)
    store.commit(run_point(SWEEP, *POINT))
    return store


def files_of(store, point):
    i = store.axes["load"].index(point.load)
    j = store.axes["velocity"].index(point.velocity)
    return sorted(store.path.glob(f"*/c.{i}.{j}*"))


# Layout


def test_there_is_a_column_for_each_measure_and_the_quantiles():
    measured = run_point(SWEEP, *POINT).columns
    assert set(COLUMNS) == set(measured)
    assert set(FIELDS) == set(run_point(SWEEP, *POINT).fields)


def test_the_store_opens_in_plain_xarray_without_a_warning(alone):
    command = f"""if True:
        import warnings; warnings.simplefilter("error")
        import xarray as xr
        ds = xr.open_zarr({str(alone)!r})
        assert ds["rise_quantile"].sel(load=600, velocity=1.5).dims == ("step", "quantile")
        assert ds["status"].attrs["flag_meanings"] == "pending done failed"
        masks, kinds = (ds["warning_flags"].attrs[name] for name in ("flag_masks", "flag_meanings"))
        assert dict(zip(masks, kinds.split()))[2] == "contact_at_edge"
        ds.load()
        for name, variable in ds.variables.items():
            assert "long_name" in variable.attrs, name
            without = "status", "message", "warning_flags", "checksum"
            assert "units" in variable.attrs or name in without, name
    """
    subprocess.run([sys.executable, "-c", command], check=True, cwd="/", timeout=60)


def test_axes_have_the_exact_loads_and_velocities(tmp_path):
    sweep = tiny.sweep(loads=(0.1 + 0.2, 100 / 3), velocities=(1 / 7, 1.1))
    prepare(tmp_path / "a.zarr", sweep)
    with xr.open_zarr(tmp_path / "a.zarr", chunks=None) as ds:
        assert tuple(ds["load"].values) == sweep.loads
        assert tuple(ds["velocity"].values) == sweep.velocities
        assert ds["quantile"].values.tolist() == list(tribo.QUANTILES)
        np.testing.assert_array_equal(ds["step"], [1, 2, 3])


def test_what_is_read_is_what_was_computed_bit_for_bit(alone):
    sweep = tiny.full()
    with xr.open_zarr(alone, chunks=None) as ds:
        for point in points(sweep):
            result = run_point(sweep, *point)
            stored = ds.sel(load=point.load, velocity=point.velocity)
            for name, values in result.columns.items():
                own = stored[name].values[: len(values)]
                assert own.tobytes() == values.tobytes()
                assert np.isnan(stored[name].values[len(values) :]).all()
            for name, field in result.fields.items():
                assert stored[name].values.tobytes() == field.tobytes()
            assert stored["message"].values.item() == "; ".join(map(str, result.warnings))
            flags = stored["warning_flags"].values.item()
            assert list(tribo.WarningKind(flags)) == [each.kind for each in result.warnings]


def test_no_two_points_share_a_file(alone):
    store = Store(alone)
    owned = [set(files_of(store, point)) for point in store.asked()]
    chunks = {file for file in alone.glob("*/c.*") if file.parent.name not in COORDINATES}
    assert sum(map(len, owned)) == len(set.union(*owned)) == len(chunks)


def test_chunks_are_compressed_with_a_checksum_and_named_with_dots(alone):
    for name in (*COLUMNS, *FIELDS, "status", "message", "checksum"):
        metadata = json.loads((alone / name / "zarr.json").read_text())
        assert metadata["codecs"][-1] == {
            "name": "zstd",
            "configuration": {"level": 1, "checksum": True},
        }
        assert metadata["chunk_key_encoding"]["configuration"] == {"separator": "."}


def test_attributes_say_what_was_computed(alone):
    attributes = summary_attributes(alone)
    assert attributes["scene"]["fidelity"]["increments"] == 6
    assert attributes["scene"]["pin"]["radius"] == 8e-3
    assert attributes["versions"]["numpy"] == np.__version__
    assert attributes["conditions"]["critical_temperature"] == 418.15
    assert attributes["measured"][1] == {"normal_load": 200.0, "velocity": 3.75, "friction": None}
    few_have = {"motion", "unequal_bulks"}
    every = {field.name for field in dataclasses.fields(tribo.Scene)}
    assert set(attributes["scene"]) == every - few_have


def summary_attributes(path):
    return json.loads((path / "zarr.json").read_text())["attributes"]


def test_an_infinite_hardness_and_a_measured_surface_are_described_in_strict_json():
    soft = dataclasses.replace(tiny.STEEL, hardness=float("inf"))
    heights = np.random.default_rng(0).normal(size=(32, 16))
    scene = tiny.sweep(disk=soft, roughness=tribo.MeasuredRoughness(heights))
    description = json.loads(json.dumps(describe(scene), allow_nan=False))
    assert description["disk"]["hardness"] == "inf"
    assert description["roughness"]["array"].startswith("sha256:")
    heights[3, 4] += 1e-9
    other = describe(tiny.sweep(disk=soft, roughness=tribo.MeasuredRoughness(heights)))
    assert other["roughness"] != description["roughness"]


# Committing points


def test_a_point_is_done_once_it_is_committed(path):
    store = prepare(path, SWEEP)
    assert set(store.status().values()) == {PENDING}
    store.commit(run_point(SWEEP, *POINT))
    assert store.is_done(POINT)
    assert store.is_intact(POINT)
    assert list(store.status().values()).count(DONE) == 1


@pytest.mark.parametrize("name", ["time", "rise_quantile", "checksum", "status"])
def test_a_point_cut_short_at_any_write_is_pending(path, monkeypatch, name):
    store = prepare(path, SWEEP)
    replace = os.replace

    def cut(source, target):
        if f"/{name}/c" in target:
            raise Killed
        replace(source, target)

    monkeypatch.setattr(os, "replace", cut)
    with pytest.raises(Killed):
        store.commit(run_point(SWEEP, *POINT))
    monkeypatch.undo()
    assert summary(path).done == 0
    assert Store(path).status()[POINT] == PENDING
    store.commit(run_point(SWEEP, *POINT))
    assert store.is_intact(POINT)


def test_everything_else_is_on_the_disk_before_the_status_is_written(path, monkeypatch):
    store = prepare(path, SWEEP)
    log, replace = [], os.replace

    def renamed(source, target):
        log.append(f"rename {Path(target).parent.name}")
        replace(source, target)

    def synced(file):
        there = Path(f"/proc/self/fd/{file}").readlink()
        log.append(f"sync folder {there.name}" if there.is_dir() else f"sync {there.parent.name}")

    monkeypatch.setattr(os, "replace", renamed)
    monkeypatch.setattr(os, "fsync", synced)
    store.commit(run_point(SWEEP, *POINT))
    for name in (*COLUMNS, "wall_time", "message", "checksum", "status"):
        order = [log.index(f"{what} {name}") for what in ("sync", "rename", "sync folder")]
        assert order == sorted(order)
        assert name == "status" or order[-1] < log.index("rename status")
    assert log[-2:] == ["rename status", "sync folder status"]


@pytest.mark.parametrize("name", [*COLUMNS, *FIELDS, "checksum"])
def test_a_flipped_bit_and_a_lost_file_are_noticed(copy, name):
    store = Store(copy)
    assert store.is_intact(POINT)
    (file,) = (file for file in files_of(store, POINT) if file.parent.name == name)
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    assert not store.is_intact(POINT)
    file.unlink()
    assert not store.is_intact(POINT)
    assert store.is_intact(Point(250.0, 0.5))


def test_a_failed_point_says_why_and_can_be_tried_again(store):
    point = Point(600.0, 1.5)
    store.fail(point, "it did not converge – é")
    assert summary(store.path).failed == (FailedPoint(600.0, 1.5, "it did not converge – é"),)
    store.forget(point)
    assert store.status()[point] == PENDING
    assert summary(store.path).failed == ()


def test_a_point_that_is_done_does_not_fail_afterwards(store):
    store.fail(POINT, "its worker died after the commit")
    assert store.is_done(POINT)


def test_a_full_disk_is_an_error_that_says_so(path, monkeypatch):
    store = prepare(path, SWEEP)

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(StoreError, match=r"250 N, 1 m/s .* No space left on device"):
        store.commit(run_point(SWEEP, *POINT))
    with pytest.raises(StoreError, match="No space left"):
        store.fail(POINT, "why")


def test_what_the_disk_takes_in_parts_is_written_whole(path, monkeypatch):
    store, write = prepare(path, SWEEP), os.write
    monkeypatch.setattr(os, "write", lambda file, content: write(file, content[:7]))
    store.commit(run_point(SWEEP, *POINT))
    assert store.is_intact(POINT)


def test_a_point_that_cannot_be_written_leaves_no_file_open(path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    store, result = prepare(path, SWEEP), run_point(SWEEP, *POINT)
    store.commit(run_point(SWEEP, 150.0, 0.5))
    before = sorted(Path("/proc/self/fd").iterdir())
    monkeypatch.setattr(os, "write", full)
    with pytest.raises(StoreError, match="No space left"):
        store.commit(result)
    assert sorted(Path("/proc/self/fd").iterdir()) == before
    assert not list(path.rglob("*.partial"))


def test_a_process_opens_a_store_once_and_again_after_it_has_grown(store):
    first = pickle.loads(pickle.dumps(store))
    assert pickle.loads(pickle.dumps(store)) is first
    grown = prepare(store.path, tiny.sweep(velocities=(2.0,)))
    assert pickle.loads(pickle.dumps(grown)) is not first
    assert len(pickle.dumps(store)) < 1000


def test_a_store_in_the_place_of_another_is_not_taken_for_it(tmp_path):
    """A worker may have written points to one that was there before."""
    path = tmp_path / "out.zarr"
    pickle.loads(pickle.dumps(prepare(path, tiny.full(loads=(150.0, 300.0, 900.0)))))
    shutil.rmtree(path)
    another = prepare(path, tiny.full(loads=(300.0, 600.0, 900.0)))
    assert pickle.loads(pickle.dumps(another)).axes == another.axes


def test_a_process_that_sees_another_store_under_the_path_says_so(tmp_path):
    path = tmp_path / "out.zarr"
    store = pickle.dumps(prepare(path, SWEEP))
    shutil.rmtree(path)
    prepare(path, tiny.full(loads=(150.0, 900.0)))
    with pytest.raises(StoreError, match="every worker must see the store under the same path"):
        pickle.loads(store)


# Resuming and growing


def test_a_store_prepared_again_is_left_as_it_is(store):
    before = {file: file.stat().st_mtime_ns for file in store.path.rglob("*") if file.is_file()}
    prepare(store.path, SWEEP)
    assert before == {
        file: file.stat().st_mtime_ns for file in store.path.rglob("*") if file.is_file()
    }


def test_what_decides_no_number_follows_the_scene_file(store):
    changed = tiny.sweep(title="Renamed", conditions=Conditions(0.2, 300.0, 420.0), measured=())
    prepare(store.path, changed)
    attributes = summary_attributes(store.path)
    assert attributes["title"] == "Renamed"
    assert attributes["conditions"]["friction"] == 0.2
    assert attributes["measured"] == []
    assert Store(store.path).is_intact(POINT)


def test_a_store_grows_by_loads_velocities_and_steps(store):
    grown = prepare(store.path, tiny.sweep(loads=(200.0, 250.0, 1500.0), velocities=(0.25, 1.0)))
    assert grown.axes["load"] == [150.0, 250.0, 600.0, 200.0, 1500.0]
    assert grown.axes["velocity"] == [0.5, 1.0, 1.5, 0.25]
    assert grown.axes["step"] == list(range(1, 13))
    assert grown.is_done(POINT)
    assert grown.is_intact(POINT)
    assert summary(store.path).total == 6
    for point in (Point(1500.0, 0.25), Point(200.0, 1.0)):
        result = run_point(SWEEP, *point)
        grown.commit(result)
        assert grown.is_intact(point)
        with xr.open_zarr(store.path, chunks=None) as ds:
            own = ds["rise_quantile"].sel(load=point.load, velocity=point.velocity).values
        assert own[: len(result.columns["time"])].tobytes() == (
            result.columns["rise_quantile"].tobytes()
        )


def test_chunks_without_a_number_are_written_too(store):
    """A missing chunk is thus always a lost one."""
    grown = prepare(store.path, tiny.sweep(loads=(150.0, 1500.0)))
    grown.commit(run_point(SWEEP, 150.0, 0.5))
    names = {file.name for file in files_of(grown, Point(150.0, 0.5)) if file.parent.name == "time"}
    assert names == {"c.0.0.0", "c.0.0.1", "c.0.0.2"}


def test_fields_may_be_asked_for_later(store):
    with_fields = tiny.sweep(store_fields=True)
    grown = prepare(store.path, with_fields)
    grown.commit(run_point(with_fields, 600.0, 1.0))
    assert grown.is_intact(POINT)
    assert grown.is_intact(Point(600.0, 1.0))
    with xr.open_zarr(store.path, chunks=None) as ds:
        assert np.isfinite(ds["pressure"].sel(load=600, velocity=1)).all()
        assert np.isnan(ds["pressure"].sel(load=250, velocity=1)).all()


@settings(max_examples=6, deadline=None)
@given(
    rounds=st.lists(
        st.tuples(
            st.lists(st.sampled_from([100.0, 250.0, 600.0, 900.0]), min_size=1, unique=True),
            st.lists(st.sampled_from([0.5, 1.0]), min_size=1, unique=True),
        ),
        min_size=1,
        max_size=3,
    )
)
def test_a_store_grown_in_any_order_holds_every_point_as_computed(tmp_path_factory, rounds):
    path = tmp_path_factory.mktemp("grown") / "tiny.zarr"
    for loads, velocities in rounds:
        sweep = tiny.sweep(loads=tuple(sorted(loads)), velocities=tuple(sorted(velocities)))
        store = commit_all(path, sweep, skip=done(path))
    every = {Point(*place) for loads, speeds in rounds for place in np.array(
        np.meshgrid(loads, speeds)).T.reshape(-1, 2).tolist()}  # fmt: skip
    assert {point for point, flag in store.status().items() if flag == DONE} == every
    with xr.open_zarr(path, chunks=None) as ds:
        for point in every:
            expected = run_point(SWEEP, *point).columns["max_pressure"]
            found = ds["max_pressure"].sel(load=point.load, velocity=point.velocity).values
            assert found[: len(expected)].tobytes() == expected.tobytes()
            assert np.isnan(found[len(expected) :]).all()


def done(path):
    if not path.exists():
        return ()
    return {point for point, flag in Store(path).status().items() if flag == DONE}


@pytest.mark.parametrize("survived", [0, 11, 24, 26])
def test_a_growth_cut_short_leaves_the_store_as_it_was(store, monkeypatch, survived):
    cut_after(monkeypatch, survived)
    with pytest.raises(Killed):
        prepare(store.path, tiny.sweep(loads=(150.0, 700.0, 1500.0), velocities=(0.5, 2.0)))
    monkeypatch.undo()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with xr.open_zarr(store.path, chunks=None) as ds:
            assert ds.sizes["load"] == ds.sizes["velocity"] == 3
            ds.load()
    assert Store(store.path).is_intact(POINT)
    grown = prepare(store.path, tiny.sweep(velocities=(0.25, 0.75, 1.0)))
    assert grown.axes["load"] == list(tiny.LOADS)
    assert grown.axes["velocity"] == [0.5, 1.0, 1.5, 0.25, 0.75]
    assert grown.is_intact(POINT)
    grown.commit(run_point(SWEEP, 600.0, 0.25))
    assert grown.is_intact(Point(600.0, 0.25))


@pytest.mark.parametrize("survived", [0, 1, 10, 20, 30])
def test_a_creation_cut_short_is_begun_again(path, monkeypatch, survived):
    cut_after(monkeypatch, survived)
    with pytest.raises(Killed):
        prepare(path, SWEEP)
    monkeypatch.undo()
    with pytest.raises(StoreError, match="was not created completely; run the sweep again"):
        summary(path)
    (path / f"zarr.json.{'0' * 32}.partial").touch()
    prepare(path, SWEEP).commit(run_point(SWEEP, *POINT))
    assert summary(path).done == 1


def test_a_point_is_committed_where_no_further_thread_can_be_started(path, monkeypatch):
    class Refusing:
        def submit(self, *_):
            raise RuntimeError("can't start new thread")

    store = prepare(path, SWEEP)
    monkeypatch.setattr(files, "_disk", Refusing)
    store.commit(run_point(SWEEP, *POINT))
    assert store.is_done(POINT)
    assert store.is_intact(POINT)


def test_only_what_this_program_was_writing_is_removed(path):
    store = prepare(path, SWEEP)
    store.commit(run_point(SWEEP, *POINT))
    ours = [path / f"zarr.json.{'0' * 32}.partial", path / "load" / f"c.0.{'a' * 32}.partial"]
    others = [path / "notes.partial", path / "load" / "c.0.partial"]
    for file in (*ours, *others):
        file.touch()
    remove_partial(path)
    assert [file.exists() for file in (*ours, *others)] == [False, False, True, True]
    assert store.is_intact(POINT)


def test_points_of_earlier_runs_are_counted_apart(store):
    assert (summary(store.path).done, summary(store.path).earlier) == (1, 0)
    prepare(store.path, dataclasses.replace(SWEEP, velocities=(0.5,)))
    found = summary(store.path)
    assert (found.total, found.done, found.pending, found.earlier) == (3, 0, 3, 1)


def test_a_store_is_made_where_a_link_leads(path):
    path.symlink_to(path.with_name("real.zarr"))
    prepare(path, SWEEP)
    assert summary(path.with_name("real.zarr")).total == 9


def cut_after(monkeypatch, renamed):
    """Let the process be killed after it has given this many files their names."""
    replace, left = os.replace, [renamed]

    def cut(source, target):
        if not left[0]:
            raise Killed
        left[0] -= 1
        replace(source, target)

    monkeypatch.setattr(os, "replace", cut)


# Refusals


def test_the_store_of_another_scene_is_refused_key_by_key(store):
    other = tiny.sweep(increments=7, pin=tribo.Cylinder(9e-3, 3.375e-3, tiny.STEEL), wear=None)
    with pytest.raises(StoreMismatchError) as refused:
        prepare(store.path, other)
    assert str(refused.value).splitlines()[1:] == [
        "  scene.pin.radius: 0.008 in the store, 0.009 in the scene",
        "  scene.wear: a Wear in the store, None in the scene",
        "  scene.fidelity.increments: 6 in the store, 7 in the scene",
    ]
    assert Store(store.path).is_intact(POINT)


def test_a_whole_number_is_the_same_as_its_float(path):
    prepare(path, tiny.sweep(loading=tribo.Ramp(150, 750)))
    prepare(path, tiny.sweep(loading=tribo.Ramp(150.0, 750.0)))


def foreign_group(path):
    zarr.create_group(path, attributes={"title": "something else"})


def foreign_files(path):
    path.mkdir()
    (path / "thesis.tex").write_text("years of work")


def newer(path):
    prepare(path, SWEEP)
    edit_root(path, lambda root: root["attributes"].update(format=99))


def damaged(path):
    prepare(path, SWEEP)
    root = path / "zarr.json"
    root.write_text(root.read_text()[:-100])


def edit_root(path, edit):
    root = json.loads((path / "zarr.json").read_text())
    edit(root)
    (path / "zarr.json").write_text(json.dumps(root))


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda path: path.write_text(""), "is a file, not a store; give a folder that"),
        (foreign_files, "is not a store: there is no zarr.json; give a folder"),
        (foreign_group, "is not the store of a sweep"),
        (newer, "has format 99, of a newer version of this program; this one reads .* up to 4"),
        (damaged, "is damaged"),
    ],
)
@pytest.mark.parametrize("use", [summary, lambda path: prepare(path, SWEEP)])
def test_what_is_no_store_is_refused_and_left_alone(path, make, complaint, use):
    make(path)
    before = sorted((file, file.stat().st_mtime_ns) for file in path.rglob("*"))
    with pytest.raises(StoreError, match=complaint):
        use(path)
    assert before == sorted((file, file.stat().st_mtime_ns) for file in path.rglob("*"))


def test_a_store_that_is_not_there_and_a_url_are_refused(path):
    with pytest.raises(StoreError, match="does not exist; give a store that irg run made"):
        summary(path)
    with pytest.raises(StoreError, match="a local folder or an s3:// address"):
        prepare("https://example.org/tiny.zarr", SWEEP)


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").touch()
    for below in ("tiny.zarr", "a/tiny.zarr"):
        with pytest.raises(StoreError, match=r"cannot be written: .*/file is a file, not a folder"):
            locked(tmp_path / "file" / below).__enter__()


# The lock

HOLDER = """if True:
    import sys, time
    from pipeline.store import locked
    with locked(sys.argv[1]):
        print("held", flush=True)
        time.sleep(60)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_a_process_forked_after_a_commit_commits_as_well(store):
    """Though it has none of the threads that wait for the disk."""
    second = run_point(SWEEP, 600.0, 1.0)
    child = multiprocessing.get_context("fork").Process(target=store.commit, args=(second,))
    child.start()
    child.join(60)
    ended = child.exitcode
    child.kill()
    assert ended == 0
    assert store.is_done(second.point)


@pytest.fixture
def holder(path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER, path],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert process.stdout.readline() == b"held\n"
    yield process
    process.kill()
    process.wait(60)
    process.stdout.close()


def test_one_driver_at_a_time_and_a_dead_one_does_not_count(path, holder):
    with pytest.raises(StoreError, match=f"in use by process {holder.pid} on .*; wait for it"):
        locked(path).__enter__()
    holder.kill()
    holder.wait(60)
    with locked(path), pytest.raises(StoreError, match=f"in use by process {os.getpid()} on"):
        locked(path).__enter__()
    assert list(path.parent.iterdir()) == []


def test_the_lock_of_another_machine_is_for_a_person_to_break(path):
    path.with_name("tiny.zarr.lock").write_text("process 7 on elsewhere\n")
    with pytest.raises(
        StoreError, match=r"process 7 on elsewhere \(if that has ended, delete .*\)"
    ):
        locked(path).__enter__()
