"""Chunks that several points share (pipeline/store/points.py and parts.py)."""

import errno
import math
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import xarray as xr
from pipeline.store.variables import COLUMNS, FIELDS, RECORDS

from pipeline.analysis.dataset import open_sweep
from pipeline.run import work
from pipeline.run.sweep import run_sweep
from pipeline.store import (
    BY_POINT,
    DONE,
    PENDING,
    Store,
    StoreError,
    compact_store,
    has_parts,
    lay_out,
    locked,
    parts,
    prepare,
    summary,
    verify_store,
)
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny
from tests.pipeline.conftest import chunks_by_point, commit_all

SWEEP = tiny.full()
POINTS = points(SWEEP)
POINT = Point(250.0, 1.0)


@pytest.fixture(scope="module")
def results():
    with np.errstate(all="raise", under="ignore"):
        return {point: run_point(SWEEP, *point) for point in POINTS}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "tiny.zarr"


@pytest.fixture
def copy(shared, tmp_path):
    return shutil.copytree(shared, tmp_path / "copy.zarr")


def content(path):
    """What was computed, whenever that was."""
    with xr.open_zarr(path, chunks=None) as ds:
        return ds.drop_vars(["wall_time", "finished_at"]).load()


def assert_same(path, other):
    mine, theirs = content(path), content(other)
    mine.attrs = theirs.attrs = {}
    xr.testing.assert_identical(mine, theirs)


def files_of(path, name):
    return [file for file in (path / name).glob("c*") if file.is_file()]


# Layout


@pytest.mark.parametrize(
    ("loads", "velocities"), [(12, 30), (1, 2000), (4, 100), (5, 90), (9, 60), (40, 20), (100, 4)]
)
def test_a_large_sweep_has_at_most_two_files_a_point(path, loads, velocities):
    store = prepare(
        path,
        tiny.sweep(
            loads=tuple(np.linspace(100.0, 750.0, loads).tolist()),
            velocities=tuple(np.linspace(0.5, 4.0, velocities).tolist()),
        ),
    )
    files = sum(math.prod(store.array(name).counts(0)) for name in store.names)
    assert files <= 2 * loads * velocities


def test_points_of_several_surfaces_do_not_share_chunks(path):
    store = prepare(path, tiny.sweep(realizations=(1, 2)))
    assert store.array("time").chunks[:3] == (1, 3, 6)


def test_fields_stay_in_files_of_each_point_and_the_rest_does_not(shared):
    assert all(len(files_of(shared, name)) == len(POINTS) for name in FIELDS)
    assert all(
        len(files_of(shared, name)) == 1 for name in (*COLUMNS, *RECORDS) if name != "status"
    )
    assert {file.name for file in files_of(shared, "status")} == {"c.0.0"}


def test_what_is_read_is_what_was_computed_bit_for_bit(shared, results):
    with xr.open_zarr(shared, chunks=None) as ds:
        for point, result in results.items():
            stored = ds.sel(load=point.load, velocity=point.velocity)
            for name, values in (result.columns | result.fields).items():
                own = stored[name].values
                assert own[: len(values)].tobytes() == values.tobytes()
                assert np.isnan(own[len(values) :]).all()
            assert stored["message"].values.item() == "; ".join(map(str, result.warnings))


@pytest.mark.parametrize("groups", [(9,), (1, 3, 5), (4, 4, 1)])
def test_what_is_stored_does_not_depend_on_what_was_committed_together(
    path, shared, results, groups
):
    store, left = prepare(path, SWEEP), [*results.values()][::-1]
    for count in groups:
        store.commit(*left[:count])
        left = left[count:]
    assert_same(path, shared)
    assert verify_store(path).done == 9


def test_a_store_of_one_point_a_chunk_goes_on_as_it_is(path, shared):
    with chunks_by_point():
        commit_all(path, SWEEP, skip=POINTS[4:])
    assert run_sweep(SWEEP, path, workers=1).computed == 5
    assert len(files_of(path, "time")) == 9
    assert_same(path, shared)


def test_a_compact_store_is_split_as_it_was(copy, shared):
    compact_store(copy)
    with locked(copy):
        lay_out(copy, BY_POINT)
    assert Store(copy).array("time").chunks == Store(shared).array("time").chunks
    assert_same(copy, shared)


# Committing


@pytest.mark.parametrize("name", ["time", "rise_quantile", "message", "checksum", "status"])
def test_points_cut_short_are_pending_and_others_are_as_they_were(
    path, monkeypatch, results, name, shared
):
    store = prepare(path, SWEEP)
    store.commit(*(results[point] for point in POINTS[:4]))
    replace = os.replace

    def cut(source, target):
        if f"/{name}/c" in target:
            raise KeyboardInterrupt
        replace(source, target)

    monkeypatch.setattr(os, "replace", cut)
    with pytest.raises(KeyboardInterrupt):
        store.commit(*(results[point] for point in POINTS[4:7]))
    monkeypatch.undo()
    assert [Store(path).flag(point) for point in POINTS] == [DONE] * 4 + [PENDING] * 5
    assert verify_store(path).is_clean
    store.commit(*results.values())
    assert_same(path, shared)


@pytest.mark.parametrize("name", ["normal_load", "residual", "rise_quantile"])
def test_a_point_cut_short_leaves_those_whole_that_have_no_later_steps(
    path, monkeypatch, results, name
):
    """In a store that was given more steps since they were done."""
    done, cut_short = Point(150.0, 0.5), Point(250.0, 0.5)
    prepare(path, tiny.full(loads=tiny.LOADS[:2])).commit(results[done])
    grown = prepare(path, SWEEP)
    assert grown.array("time").counts(0) == (2, 1, 2)
    replace = os.replace

    def cut(source, target):
        if target.endswith(f"/{name}/c.0.0.1" + ".0" * (name == "rise_quantile")):
            raise KeyboardInterrupt
        replace(source, target)

    monkeypatch.setattr(os, "replace", cut)
    with pytest.raises(KeyboardInterrupt):
        grown.commit(results[cut_short])
    monkeypatch.undo()
    assert len(files_of(path, "time")) == 2
    assert len(files_of(path, name)) == 1
    assert verify_store(path).is_clean
    with open_sweep(path) as ds:
        found = ds["rise_quantile"].sel(load=150, velocity=0.5).values
    own = results[done].columns["rise_quantile"]
    assert found[: len(own)].tobytes() == own.tobytes()
    Store(path).commit(*results.values())
    assert verify_store(path).done == 9
    assert verify_store(path).is_clean


def test_later_steps_that_are_lost_are_named_at_every_point_that_has_them(path, results):
    store = prepare(path, tiny.full(loads=tiny.LOADS[:2]))
    store.commit(*(results[point] for point in POINTS if point.load < 600))
    prepare(path, SWEEP).commit(*(results[point] for point in POINTS if point.load == 600))
    for file in (path / "residual").glob("c.*.1"):
        file.unlink()
    found = verify_store(path).damaged
    assert {damage.point for damage in found} == {point for point in POINTS if point.load == 600}
    assert {damage.reason for damage in found} == {"residual is missing"}
    with pytest.raises(StoreError, match="irg verify"), open_sweep(path) as ds:
        ds["residual"].load()


def test_a_point_that_is_done_is_not_written_again(copy, results):
    before = {file: file.read_bytes() for file in copy.rglob("c.*")}
    Store(copy).commit(results[POINT])
    Store(copy).fail(POINT, "its worker died after the commit")
    assert before == {file: file.read_bytes() for file in copy.rglob("c.*")}


def test_failed_points_and_their_reasons_outlast_what_is_written_beside_them(path, results):
    store = prepare(path, SWEEP)
    store.fail(POINT, "it did not converge – é")
    store.commit(*(results[point] for point in POINTS if point != POINT))
    store.forget(POINTS[0])
    (failed,) = summary(path).failed
    assert (failed.load, failed.velocity, failed.message) == (250.0, 1.0, "it did not converge – é")
    assert verify_store(path).is_clean


def test_a_store_seen_before_it_grew_writes_beside_what_came_since(path, results):
    """As a worker that was given up, and lives."""
    first = tiny.full(loads=tiny.LOADS[:2], velocities=tiny.VELOCITIES[:2])
    zombie = prepare(path, first)
    zombie.commit(results[Point(150.0, 0.5)])
    grown = prepare(path, SWEEP)
    late = Point(250.0, 1.0)
    grown.commit(*(result for point, result in results.items() if point != late))
    zombie.commit(results[late])
    assert verify_store(path).done == 9
    assert verify_store(path).is_clean


def test_threads_of_a_process_write_one_after_the_other(path, results, shared):
    store = prepare(path, SWEEP)
    threads = [threading.Thread(target=store.commit, args=(result,)) for result in results.values()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert_same(path, shared)


def test_points_of_a_task_are_committed_together_and_long_ones_at_once(path, monkeypatch):
    committed, commit = [], Store.commit

    def counted(self, *results):
        committed.append(len(results))
        commit(self, *results)

    monkeypatch.setattr(Store, "commit", counted)
    monkeypatch.setattr(work, "_KEPT", 600.0)
    parcel = work.pickle.dumps((SWEEP, prepare(path, SWEEP)))
    work.compute_points(parcel, POINTS[:3], None, 1e9)
    assert sum(committed) == 3
    assert committed[0] == 3
    committed.clear()
    monkeypatch.setattr(work, "_KEPT", 0.0)
    work.compute_points(parcel, POINTS[3:6], None, 1e9)
    assert committed[:3] == [1, 1, 1]


def test_what_is_finished_does_not_wait_for_a_long_point(path, monkeypatch):
    store, seen = prepare(path, SWEEP), []

    def endless(sweep, *at, trunk=None):
        end = time.monotonic() + 60.0
        while Point(*at) == POINTS[2] and not seen and time.monotonic() < end:
            time.sleep(0.01)
            seen.extend([True] * store.is_done(POINTS[1]))
        return run_point(sweep, *at, trunk=trunk)

    monkeypatch.setattr(work, "run_point", endless)
    work.compute_points(work.pickle.dumps((SWEEP, store)), POINTS[:3], None, 1e9)
    assert seen


def test_what_cannot_be_committed_meanwhile_is_an_error(path, monkeypatch):
    def full(*_):
        raise StoreError("no room")

    def slow(sweep, *at, trunk=None):
        time.sleep(0.05)
        return run_point(sweep, *at, trunk=trunk)

    store = prepare(path, SWEEP)
    monkeypatch.setattr(work, "run_point", slow)
    monkeypatch.setattr(work, "_KEPT", 0.02)
    monkeypatch.setattr(Store, "commit", full)
    with pytest.raises(StoreError, match="no room"):
        work.compute_points(work.pickle.dumps((SWEEP, store)), POINTS[:3], None, 1e9)


def test_what_is_finished_is_committed_when_a_task_breaks_off(path, monkeypatch):
    def interrupted(sweep, *at, trunk=None):
        if Point(*at) == POINTS[2]:
            raise KeyboardInterrupt
        return run_point(sweep, *at, trunk=trunk)

    store = prepare(path, SWEEP)
    monkeypatch.setattr(work, "run_point", interrupted)
    with pytest.raises(KeyboardInterrupt):
        work.compute_points(work.pickle.dumps((SWEEP, store)), POINTS[:3], None, 1e9)
    assert [store.flag(point) for point in POINTS[:3]] == [DONE, DONE, PENDING]


# Damage


def flip(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


@pytest.mark.parametrize("harm", [flip, os.unlink])
@pytest.mark.parametrize("name", ["time", "rise_quantile", "message", "wall_time", "checksum"])
def test_damage_of_a_chunk_is_named_at_every_point_and_repaired(copy, shared, name, harm):
    for file in files_of(copy, name):
        harm(file)
    found = verify_store(copy)
    assert {damage.point for damage in found.damaged} == {*POINTS}
    assert all(name in damage.reason for damage in found.damaged)
    if harm is flip and name != "checksum":  # which is not opened
        with pytest.raises(StoreError, match=r"irg verify"), open_sweep(copy) as ds:
            ds[name].load()
    verify_store(copy, repair=True)
    assert verify_store(copy).is_clean
    assert summary(copy).pending == 9
    assert run_sweep(SWEEP, copy, workers=1).computed == 9
    assert_same(copy, shared)


def test_a_run_computes_again_all_that_shares_a_damaged_chunk(copy, shared):
    """Also what the scene does not ask for now."""
    flip(*files_of(copy, "time"))
    few = tiny.full(loads=(150.0,), velocities=(0.5, 1.0))
    assert run_sweep(few, copy, workers=1).computed == 2
    assert verify_store(copy).is_clean
    assert run_sweep(SWEEP, copy, workers=1).computed == 7
    assert_same(copy, shared)


@pytest.mark.parametrize("harm", [flip, os.unlink])
@pytest.mark.parametrize("name", ["time", "message", "checksum"])
def test_damage_beside_a_point_is_not_written_over(copy, results, name, harm):
    store = Store(copy)
    store.forget(POINT)
    harm(*files_of(copy, name))
    before = {file: file.read_bytes() for file in copy.rglob("c.*")}
    with pytest.raises(StoreError, match=f"{name} cannot be read; irg verify"):
        store.commit(results[POINT])
    assert before == {file: file.read_bytes() for file in copy.rglob("c.*")}
    assert len(verify_store(copy).damaged) >= 8


def test_data_of_one_point_that_are_not_its_own_cost_no_other(copy, shared):
    array = Store(copy).array("time")
    (file,) = files_of(copy, "time")
    values = array.decoded(file.read_bytes()).copy()
    values[1, 1, 0] *= 2
    file.write_bytes(array.encoded(values))
    (damage,) = verify_store(copy, repair=True).damaged
    assert str(damage) == "250 N, 1 m/s: the data are not those that were computed"
    assert summary(copy).pending == 1
    assert run_sweep(SWEEP, copy, workers=1).computed == 1
    assert_same(copy, shared)


@pytest.mark.parametrize("harm", [flip, os.unlink])
def test_reasons_of_failures_that_were_lost_are_given_up_together(path, results, harm):
    store = prepare(path, SWEEP)
    for point in POINTS[:2]:
        store.fail(point, "it did not converge")
    harm(*files_of(path, "message"))
    store.forget(POINTS[0])
    assert [store.flag(point) for point in POINTS[:2]] == [PENDING, PENDING]
    store.commit(*results.values())
    assert verify_store(path).is_clean


@pytest.mark.parametrize("harm", [flip, os.unlink])
def test_a_lost_status_is_found_again_for_what_is_intact(copy, shared, harm):
    harm(*files_of(copy, "status"))
    assert summary(copy).done == 0
    assert len(verify_store(copy).found) == 9
    assert run_sweep(SWEEP, copy, workers=1).computed == 0
    assert_same(copy, shared)


@pytest.mark.parametrize("harm", [flip, os.unlink])
def test_a_status_lost_in_the_middle_of_a_run_costs_no_neighbour(path, results, harm):
    store = prepare(path, SWEEP)
    store.commit(*(results[point] for point in POINTS[:5]))
    harm(*files_of(path, "status"))
    store.commit(results[POINTS[5]])
    assert [store.flag(point) for point in POINTS] == [DONE] * 6 + [PENDING] * 3
    assert verify_store(path).is_clean


# Locks


def held(path, place=(0, 0)):
    """A process that has stopped in the middle of a commit."""
    command = f"""if True:
        import os, signal
        from pipeline.store.folder import part_held
        from pathlib import Path
        with part_held(Path({str(path)!r}), {place!r}):
            print("held", flush=True)
            os.kill(os.getpid(), signal.SIGSTOP)
        print("released", flush=True)
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(
        [sys.executable, "-c", command], stdout=subprocess.PIPE, env=environment
    )
    assert process.stdout.readline() == b"held\n"
    return process


@pytest.fixture
def stopped(path):
    prepare(path, SWEEP)
    process = held(path)
    yield process
    process.kill()
    process.wait(60)
    process.stdout.close()


def test_a_stopped_process_does_not_hang_others_for_ever(path, stopped, results, monkeypatch):
    monkeypatch.setattr(parts, "PATIENCE", 0.2)
    store = Store(path)
    with pytest.raises(StoreError, match=r"another process has been writing .* end it if it is st"):
        store.commit(results[POINT])
    with pytest.raises(StoreError, match="another process has been writing"):
        compact_store(path)
    os.kill(stopped.pid, signal.SIGCONT)
    assert stopped.stdout.readline() == b"released\n"
    store.commit(results[POINT])
    assert store.is_done(POINT)


def test_the_lock_of_a_process_that_was_killed_does_not_count(path, stopped, results, monkeypatch):
    monkeypatch.setattr(parts, "PATIENCE", 30.0)
    stopped.kill()
    stopped.wait(60)
    assert path.with_name("tiny.zarr.lock.parts").exists()
    with locked(path):
        pass
    assert [file.name for file in path.parent.iterdir()] == ["tiny.zarr"]
    Store(path).commit(results[POINT])
    assert [file.name for file in path.parent.iterdir()] == ["tiny.zarr"]


def test_other_parts_can_be_written_meanwhile(path, stopped, monkeypatch):
    monkeypatch.setattr(parts, "PATIENCE", 30.0)
    wider = tiny.full(velocities=tuple(np.linspace(0.5, 1.5, 12).tolist()))
    store = prepare(path, wider)
    far = next(at for at in points(wider) if store.place("status", store.index(at)) != (0, 0))
    store.commit(run_point(wider, *far))
    assert store.is_done(far)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_a_process_forked_in_the_middle_of_a_commit_does_not_have_its_lock(tmp_path, monkeypatch):
    monkeypatch.setattr(parts, "PATIENCE", 30.0)
    file = tmp_path / "lock"
    with parts.hold_part(file, (1, 2)):
        child = multiprocessing.get_context("fork").Process(target=time.sleep, args=(60,))
        child.start()
    try:
        with parts.hold_part(file, (1, 2)):
            assert child.is_alive()
    finally:
        child.kill()
        child.join(60)


def no_locks(*_):
    raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))


def test_where_there_are_no_locks_points_share_no_chunks(path, copy, results, monkeypatch, shared):
    """Nor in a store that was copied there."""
    Store(copy).forget(POINT)
    monkeypatch.setattr(parts.fcntl, "lockf", no_locks)
    assert not has_parts(path)
    store = prepare(path, SWEEP)
    assert not store.is_shared
    store.commit(results[POINT])
    assert store.is_intact(POINT)
    with pytest.raises(StoreError, match="No locks available"):
        Store(copy).commit(results[POINT])
    assert run_sweep(SWEEP, copy, workers=1).computed == 1
    with locked(copy):
        lay_out(copy, BY_POINT)
    assert not Store(copy).is_shared
    assert_same(copy, shared)
