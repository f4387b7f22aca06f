"""One run at a time writes to a store, by whatever path it came, and none for the dead."""

import errno
import fcntl
import os

import pytest

import pipeline
from pipeline import StoreError, summary, verify_store
from pipeline.store import files
from pipeline.store.create import writing
from pipeline.store.place import LOCK
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.reported import Heard
from tests.helpers.stores import assert_is_as_computed, commit, contents, held_elsewhere, record

SWEEP, POINT, OTHER = tiny.full(), Point(250.0, 1.0), Point(600.0, 1.5)
HOST = os.uname().nodename
HERE = f"process {os.getpid()} on {HOST}"


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "data" / "tiny.zarr"
    commit(path, SWEEP, [POINT])
    return path


def refuse(path, holder=HERE):
    with pytest.raises(StoreError, match=f"in use by {holder}"):
        commit(path, SWEEP, ())


def test_a_store_is_locked_by_whatever_path(path):
    (path.parent.parent / "linked").symlink_to(path.parent)
    for alias in (path.parent.parent / "linked" / path.name, f"{os.path.relpath(path)}/"):
        with writing(alias, SWEEP):
            refuse(path)
            assert summary(path).running == HERE
    with writing(path, SWEEP):
        with pytest.raises(StoreError, match="in use"):
            pipeline.run_sweep(SWEEP, alias)
        assert verify_store(alias).is_clean
    assert summary(path).running is None


def test_a_process_that_was_killed_holds_nothing(path):
    with held_elsewhere(path) as holder:
        refuse(path, holder)
    commit(path, SWEEP, [POINT])
    assert_is_as_computed(path, [POINT])


@pytest.mark.parametrize("left", ["", f"process 7 on {HOST}\n", "\udcff"])
def test_what_a_killed_process_of_this_host_or_nobody_left_is_free(path, left):
    (path / LOCK).write_bytes(left.encode(errors="surrogateescape"))
    assert summary(path).running is None
    commit(path, SWEEP, ())
    assert (path / LOCK).read_bytes() == b""


def test_what_a_process_of_another_host_left_is_not_taken_until_somebody_deletes_it(path, irg):
    """A kernel lock may not reach this host, so nothing tells whether that process lives."""
    (path / LOCK).write_text("process 7 on node7\n")
    os.utime(path / LOCK, (0, 0))
    before = contents(path)
    with pytest.raises(StoreError) as refused:
        pipeline.run_sweep(SWEEP, path, workers=1)
    assert str(refused.value) == (
        f"{path} is in use by process 7 on node7; if that has ended, delete {path}/status/lock"
    )
    assert (path / LOCK).read_text() == "process 7 on node7\n"
    assert contents(path) == before
    assert "running: process 7 on node7" in irg("status", path)
    (path / LOCK).unlink()
    commit(path, SWEEP, [OTHER])
    assert_is_as_computed(path, [POINT, OTHER])


def test_a_lock_names_process_and_host_and_is_emptied_at_a_proper_end(path):
    with writing(path, SWEEP):
        assert (path / LOCK).read_text() == f"{HERE}\n"
    assert (path / LOCK).read_text() == ""
    with pytest.raises(RuntimeError, match="in between"), writing(path, SWEEP):
        raise RuntimeError("in between")
    assert (path / LOCK).read_text() == ""


@pytest.mark.parametrize("replaced", [False, True])
def test_a_run_whose_lock_is_deleted_stops_and_loses_nothing(path, replaced):
    with writing(path, SWEEP) as store:
        store.commit([record(OTHER)])
        (path / LOCK).unlink()
        if replaced:
            (path / LOCK).touch()
        with pytest.raises(StoreError, match=rf"its lock \({LOCK}\) was deleted or replaced"):
            store.commit([record(Point(150.0, 0.5))])
        commit(path, SWEEP, [Point(600.0, 0.5)])  # committed by another run
        with pytest.raises(StoreError, match="run the command again"):
            store.forget([POINT])
    assert_is_as_computed(path, [POINT, OTHER, Point(600.0, 0.5)])
    assert verify_store(path).is_clean


def test_a_commit_during_which_the_lock_is_deleted_is_not_told_as_done(path, monkeypatch):
    """Another driver may have started meanwhile, and read the statuses before."""
    replace = files.write_file

    def deleted(file, content):
        replace(file, content)
        if file.parent == path / "status":
            (path / LOCK).unlink(missing_ok=True)

    with writing(path, SWEEP) as store:
        monkeypatch.setattr(files, "write_file", deleted)
        with pytest.raises(StoreError, match="was deleted or replaced"):
            store.commit([record(OTHER)])
        assert OTHER in store.pending()


def test_a_disk_without_locks_is_written_and_told(path, monkeypatch):
    def refused(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refused)
    messages = Heard()
    with writing(path, SWEEP, messages.hear) as store:
        store.commit([record(OTHER)])
    assert messages == [f"{path} has no locks: let one run at a time write to it"]
    assert_is_as_computed(path, [POINT, OTHER])
    (path / LOCK).write_text("process 7 on node7\n")
    refuse(path, "process 7 on node7; if that has ended, delete")
