"""On a disk that other machines see, a store belongs to who renews its lock."""

import os
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from pipeline.store import lock
from pipeline.store.create import writing
from pipeline.store.place import LOCK, StoreError
from pipeline.store.progress import summary
from pipeline.store.verify import verify_store
from pipeline.sweep.model import Point
from tests.helpers import tiny
from tests.helpers.stores import HOLDER, assert_is_as_computed, commit, held_elsewhere, record

SWEEP, POINT, OTHER = tiny.full(), Point(250.0, 1.0), Point(600.0, 1.5)
HERE = f"process {os.getpid()} on {os.uname().nodename}"
ELSEWHERE = f"process 7 on elsewhere\nmachine {'0' * 32}\n"
ON_NFS = HOLDER.replace("import sys", "import sys, pipeline.store.lock as lock").replace(
    "    with", "    lock.is_local = lambda folder: False\n    with", 1
)


@pytest.fixture
def path(tmp_path, monkeypatch):
    """A store on a disk that passes for one of another machine."""
    monkeypatch.setattr(lock, "is_local", lambda folder: False)
    monkeypatch.setattr(lock, "SETTLE", 0.0)
    path = tmp_path / "tiny.zarr"
    commit(path, SWEEP, [POINT])
    return path


def left_behind(path, age, content=ELSEWHERE):
    """Lock of a process that was last heard of so many seconds ago."""
    (path / LOCK).write_text(content)
    moment = time.time() - age
    os.utime(path / LOCK, (moment, moment))


def refuse(path, holder):
    with pytest.raises(StoreError, match=f"in use by {holder}; wait for it.* last heard of"):
        commit(path, SWEEP, ())


def test_a_process_elsewhere_holds_a_store_until_it_is_silent_for_minutes(path):
    left_behind(path, 0.9 * lock.STALE)
    refuse(path, "process 7 on elsewhere")
    assert summary(path).running == "process 7 on elsewhere"
    left_behind(path, 1.1 * lock.STALE, "process 7 on else")  # also if it was cut short
    assert summary(path).running is None
    with writing(path, SWEEP) as store:
        store.commit([record(OTHER)])
        refuse(path, HERE)
        assert summary(path).running == HERE
    assert_is_as_computed(path, [POINT, OTHER])
    assert {file.name for file in (path / "status").iterdir()} == {"zarr.json", "c.0.0"}


def test_a_process_of_this_machine_that_was_killed_holds_nothing(path):
    with held_elsewhere(path, ON_NFS) as holder:
        refuse(path, holder)
    assert (path / LOCK).exists()
    assert summary(path).running is None
    commit(path, SWEEP, ())


def test_the_lock_of_a_long_run_stays_fresh(path, monkeypatch):
    monkeypatch.setattr(lock, "BEAT", 0.02)
    with writing(path, SWEEP):
        left_behind(path, 2 * lock.STALE, (path / LOCK).read_text())
        deadline = time.monotonic() + 10
        while time.time() - (path / LOCK).stat().st_mtime > lock.STALE:
            assert time.monotonic() < deadline
            time.sleep(0.01)


def test_a_run_that_slept_while_another_took_its_store_stops_and_loses_nothing(path):
    with writing(path, SWEEP) as store:
        left_behind(path, 2 * lock.STALE, (path / LOCK).read_text().replace("/", "0/", 1))
        with writing(path, SWEEP) as other:
            with pytest.raises(StoreError, match=r"its lock .* was deleted or replaced"):
                store.commit([record(Point(150.0, 0.5))])
            other.commit([record(OTHER)])
    assert_is_as_computed(path, [POINT, OTHER])
    assert verify_store(path).is_clean


def test_of_two_that_take_a_lock_at_once_one_gives_way(path, monkeypatch):
    left_behind(path, 2 * lock.STALE)
    monkeypatch.setattr(time, "sleep", lambda _: (path / LOCK).write_text(ELSEWHERE))
    with pytest.raises(StoreError, match="in use by process 7 on elsewhere"):
        commit(path, SWEEP, ())


def test_the_server_of_a_disk_heeds_the_heartbeat_of_its_clients(path, monkeypatch):
    monkeypatch.setattr(lock, "is_local", lambda folder: True)
    left_behind(path, 0.9 * lock.STALE)
    with pytest.raises(StoreError, match="in use by process 7 on elsewhere"):
        commit(path, SWEEP, ())
    left_behind(path, 1.1 * lock.STALE)
    commit(path, SWEEP, ())


MOUNTS = [("/", "ext4"), ("/home", "ext4"), ("/home", "nfs"), ("/mnt", "9p"), ("/tmp", "tmpfs")]


@pytest.mark.parametrize(
    ("folder", "is_local"),
    [
        ("/homes/a", True),
        ("/home/a", False),
        ("/mnt", False),
        ("/mnt2/mnt", True),
        ("/tmp/a", True),
    ],
)
def test_the_last_mount_above_a_folder_tells_whether_its_disk_is_here(
    monkeypatch, folder, is_local
):
    def partitions(all=False):  # as psutil calls it
        named = [SimpleNamespace(mountpoint=place, fstype=kind) for place, kind in MOUNTS]
        return named if all else named[:2]

    monkeypatch.setattr("psutil.disk_partitions", partitions)
    assert lock.is_local(Path(folder)) is is_local
