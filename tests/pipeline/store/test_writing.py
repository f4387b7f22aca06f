"""Points are written with their status last, by one run at a time, while others may read."""

import errno
import fcntl
import os

import pytest

import pipeline
import tribo
from pipeline import StoreError, open_sweep, summary, verify_store
from pipeline.store.create import writing
from pipeline.store.schema import COLUMNS, FIELDS
from pipeline.store.status import FailedPoint
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.kept import refusal
from tests.helpers.points import run_point
from tests.helpers.reported import Heard
from tests.helpers.stores import (
    assert_is_as_computed,
    commit,
    contents,
    fail,
    held_elsewhere,
    killed_after,
    lock_of,
    opened,
    record,
)

SWEEP, POINT, OTHER = tiny.full(), Point(250.0, 1.0), Point(600.0, 1.5)


def test_what_is_read_is_what_was_computed_bit_for_bit_and_its_warnings(tiny_store):
    assert_is_as_computed(tiny_store, points(SWEEP))
    with open_sweep(tiny_store) as ds:
        for point in points(SWEEP):
            result = run_point(SWEEP, point)
            stored = ds.sel(load=point.load, velocity=point.velocity)
            flags = stored["warning_flags"].item()
            assert set(tribo.WarningKind(flags)) == {warning.kind for warning in result.warnings}


@pytest.mark.parametrize("files", [8, 22])
def test_a_commit_killed_before_any_change_of_a_file_leaves_points_whole(path, monkeypatch, files):
    commit(path, SWEEP, [POINT])
    with writing(path, SWEEP) as store, killed_after(monkeypatch, files) as was_killed:
        store.commit([record(OTHER)])
    assert was_killed
    assert_is_as_computed(path, [POINT])
    assert verify_store(path).is_clean
    with open_sweep(path) as ds:
        ds.load()
    commit(path, SWEEP, [OTHER])
    assert_is_as_computed(path, [POINT, OTHER])


def test_a_failed_point_says_why_and_can_be_tried_again(path):
    fail(path, SWEEP, OTHER, "it did not converge – é")
    assert verify_store(path).is_clean  # though no point of the store is done
    assert summary(path).failed == (FailedPoint(600.0, 1.5, "it did not converge – é"),)
    with writing(path, SWEEP) as store:
        store.forget([OTHER])
        assert OTHER in store.pending()
    assert summary(path).failed == ()
    commit(path, SWEEP, [OTHER])
    assert_is_as_computed(path, [OTHER])


def test_any_message_is_stored_and_none_grows_the_store(path):
    messages = {150.0: "long " * 3_400_000, 250.0: "a\0b\n", 600.0: "not text: \udcff"}
    for load, message in messages.items():
        fail(path, SWEEP, Point(load, 1.0), message)
    assert verify_store(path).is_clean
    for failed in summary(path).failed:
        expected = messages[failed.load][:10].encode(errors="backslashreplace").decode()
        assert failed.message[:10] == expected[:10]
        assert len(failed.message) < 10_000
    assert len(summary(path).failed) == 3


# Readers


def test_a_point_that_is_not_done_is_not_a_number_whatever_is_on_the_disk(copy):
    with writing(copy, SWEEP) as store:
        store.forget([POINT])
    with open_sweep(copy) as ds:
        for name in (*COLUMNS, *FIELDS, "wall_time"):
            ends = ds[name].sel(load=250)
            assert ends.sel(velocity=1).isnull().all()
            assert ends.sel(velocity=0.5).notnull().any()


def test_opening_reads_no_field(copy):
    """Opening must not read fields, which may be larger than the memory."""
    for file in [file for name in FIELDS for file in (copy / "fields" / name).glob("c.*")]:
        file.write_bytes(b"")
    with open_sweep(copy) as ds:
        assert ds["pressure"].shape == (3, 3, 32, 16)
        assert ds["mean_rise"].load().notnull().any()


def test_a_lack_of_threads_is_no_damage(tiny_store, monkeypatch):
    """Otherwise a repair would delete sound data."""

    def none_left(*_, **__):
        raise RuntimeError("can't start new thread")

    store = opened(tiny_store)
    monkeypatch.setattr(type(store.arrays["mean_rise"]), "get_orthogonal_selection", none_left)
    with pytest.raises(RuntimeError, match="new thread"):
        store.read("mean_rise", ...)


# Locks: one run at a time writes to a store, whatever its path; killed runs hold no lock.

HOST = os.uname().nodename
THIS_PROCESS = f"process {os.getpid()} on {HOST}"


@pytest.fixture
def begun(tmp_path):
    begun = tmp_path / "data" / "tiny.zarr"
    commit(begun, SWEEP, [POINT])
    return begun


def refuse(begun, holder=THIS_PROCESS):
    with pytest.raises(StoreError, match=f"in use by {holder}"):
        commit(begun, SWEEP, ())


def test_a_store_is_locked_by_whatever_path(begun):
    (begun.parent.parent / "linked").symlink_to(begun.parent)
    for alias in (begun.parent.parent / "linked" / begun.name, f"{os.path.relpath(begun)}/"):
        with writing(alias, SWEEP):
            refuse(begun)
            assert summary(begun).running == THIS_PROCESS
    with writing(begun, SWEEP):
        with pytest.raises(StoreError, match="in use"):
            pipeline.run_sweep(SWEEP, alias)
        assert verify_store(alias).is_clean
    assert summary(begun).running is None


def test_a_process_that_was_killed_holds_nothing(begun):
    with held_elsewhere(begun) as holder:
        refuse(begun, holder)
    commit(begun, SWEEP, [POINT])
    assert_is_as_computed(begun, [POINT])


@pytest.mark.parametrize("left", ["", f"process 7 on {HOST}\n", "\udcff"])
def test_what_a_killed_process_of_this_host_or_nobody_left_is_free(begun, left):
    lock_of(begun).write_bytes(left.encode(errors="surrogateescape"))
    assert summary(begun).running is None
    commit(begun, SWEEP, ())
    assert not lock_of(begun).exists()


def test_what_a_process_of_another_host_left_is_not_taken_until_somebody_deletes_it(begun, irg):
    """Kernel locks may not reach this host, so it is unknown whether that process lives."""
    lock_of(begun).write_text("process 7 on node7\n")
    os.utime(lock_of(begun), (0, 0))
    before = contents(begun)
    with pytest.raises(StoreError):
        pipeline.run_sweep(SWEEP, begun, workers=1)
    assert lock_of(begun).read_text() == "process 7 on node7\n"
    assert contents(begun) == before
    assert "running: process 7 on node7" in irg("status", begun)
    (row,) = irg("status", begun, "--json")
    assert row["state"] == "running now, 1 done, 0 failed, 8 pending"
    lock_of(begun).unlink()
    commit(begun, SWEEP, [OTHER])
    assert_is_as_computed(begun, [POINT, OTHER])


@pytest.mark.parametrize("replaced", [False, True])
def test_a_run_whose_lock_is_deleted_stops_and_loses_nothing(begun, replaced):
    with writing(begun, SWEEP) as store:
        store.commit([record(OTHER)])
        lock_of(begun).unlink()
        if replaced:
            lock_of(begun).touch()
        assert refusal(store.commit, [record(Point(150.0, 0.5))]) == (
            f"{begun}: the lock file ({lock_of(begun)}) was deleted or replaced. The run stops, "
            "because another one may be writing; finished points are saved. Run the command again"
        )
        commit(begun, SWEEP, [Point(600.0, 0.5)])  # committed by another run
        with pytest.raises(StoreError, match="Run the command again"):
            store.forget([POINT])
    assert_is_as_computed(begun, [POINT, OTHER, Point(600.0, 0.5)])
    assert verify_store(begun).is_clean


def test_a_disk_without_locks_is_written_and_told(begun, monkeypatch):
    def refused(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refused)
    messages = Heard()
    with writing(begun, SWEEP, messages.hear) as store:
        store.commit([record(OTHER)])
    assert messages == [f"{begun} cannot be locked: make sure that only one run writes to it"]
    assert_is_as_computed(begun, [POINT, OTHER])
    lock_of(begun).write_text("process 7 on node7\n")
    refuse(begun, "process 7 on node7; if that has ended, delete")
