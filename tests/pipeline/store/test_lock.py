"""Locks (pipeline/store/lock.py): one run at a time, by whatever path, and none for the dead."""

import errno
import fcntl
import os
import subprocess
import sys

import pytest
from pipeline.store.folder import user

from pipeline.store import StoreError, locked
from pipeline.store.lock import LockWarning, _lives, _self


@pytest.fixture
def path(tmp_path):
    (tmp_path / "data").mkdir()
    return tmp_path / "data" / "tiny.zarr"


def aliases(path):
    """Other paths to a store."""
    (path.parent.parent / "linked").symlink_to(path.parent)
    link = path.parent.parent / "alias.zarr"
    link.symlink_to(path)
    yield link
    yield path.parent.parent / "linked" / path.name
    yield path.parent / ".." / path.parent.name / path.name
    yield os.path.relpath(path)
    yield f"{path}/"


def test_a_store_is_locked_by_whatever_path(path):
    for alias in aliases(path):
        with locked(path), pytest.raises(StoreError, match=f"in use by process {os.getpid()}"):
            locked(alias).__enter__()
        with locked(alias), pytest.raises(StoreError, match="in use"):
            locked(path).__enter__()
        with locked(alias):
            assert user(path) == user(alias) == f"process {os.getpid()} on {os.uname().nodename}"
    assert [entry.name for entry in path.parent.iterdir()] == []


@pytest.mark.parametrize("left", ["", "process 7 on else", "process 7 on elsewh\0", "\n", "\udcff"])
def test_a_lock_file_that_was_cut_is_free(path, left):
    path.with_name("tiny.zarr.lock").write_bytes(left.encode(errors="surrogateescape"))
    assert user(path) is None
    with locked(path):
        pass


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_what_is_no_file_is_no_lock(path, make):
    make(path.with_name("tiny.zarr.lock"))
    assert user(path) is None
    with pytest.raises(StoreError, match="cannot be written"):
        locked(path).__enter__()


@pytest.fixture
def _without_flock(monkeypatch):
    def refused(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refused)


@pytest.mark.usefixtures("_without_flock")
def test_without_locks_of_the_file_system_it_runs_and_says_so(path):
    lock = locked(path)
    with pytest.warns(LockWarning, match="has no locks"):
        lock.__enter__()
    assert user(path) == f"process {os.getpid()} on {os.uname().nodename}"
    with pytest.raises(StoreError, match=f"in use by process {os.getpid()}"):
        locked(path).__enter__()
    lock.__exit__(None, None, None)
    assert list(path.parent.iterdir()) == []


@pytest.mark.usefixtures("_without_flock")
def test_without_locks_a_dead_process_does_not_count_and_another_machine_does(path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait(60)
    file = path.with_name("tiny.zarr.lock")
    file.write_text(f"process {dead.pid} on {os.uname().nodename}\n")
    assert user(path) is None
    with pytest.warns(LockWarning), locked(path):
        pass
    file.write_text("process 7 on elsewhere\n")
    with pytest.raises(StoreError, match=r"process 7 on elsewhere .* delete"):
        locked(path).__enter__()


def test_a_holder_lives_where_nothing_says_that_it_does_not(monkeypatch):
    own = _self().decode().strip()
    assert _lives(own)
    assert _lives("process 1 on another machine")

    def kill(number, _):
        assert number == os.getpid()
        raise error(errno.EPERM, "of somebody")

    monkeypatch.setattr(os, "kill", kill)
    error = PermissionError
    assert _lives(own)
    error = ProcessLookupError
    assert not _lives(own)
