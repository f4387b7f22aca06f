"""Stores with large chunks (pipeline/store/compact.py)."""

import errno
import os
import shutil
from contextlib import nullcontext

import numpy as np
import pytest
import xarray as xr
from pipeline.store.files import Files
from pipeline.store.variables import COLUMNS, KEPT_COMPACT

from pipeline.analysis.dataset import open_sweep
from pipeline.cli import main
from pipeline.run import cluster, sweep
from pipeline.run.sweep import run_sweep
from pipeline.store import (
    BY_POINT,
    COMPACT,
    Store,
    StoreError,
    compact_store,
    lay_out,
    locked,
    prepare,
    summary,
    verify_store,
)
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny
from tests.helpers.here import Here
from tests.pipeline.conftest import commit_all

SWEEP = tiny.full()
POINT = Point(250.0, 1.0)
CHANGED = ("revision", "root_hash", KEPT_COMPACT)


@pytest.fixture
def copy(alone, tmp_path):
    return shutil.copytree(alone, tmp_path / "copy.zarr")


def loaded(path):
    with xr.open_zarr(path, chunks=None) as ds:
        ds.attrs = {k: v for k, v in ds.attrs.items() if k not in CHANGED}
        return ds.load()


def test_a_compact_store_holds_the_same_in_fewer_files(copy, alone):
    compact_store(copy)
    xr.testing.assert_identical(loaded(copy), loaded(alone))
    files = [file for name in COLUMNS for file in (copy / name).rglob("*") if file.is_file()]
    assert len(files) == 2 * len(COLUMNS)  # a chunk, and what describes it
    store = Store(copy)
    assert store.is_compact
    assert all(store.is_intact(point) for point in points(SWEEP))
    assert verify_store(copy).done == 9
    assert summary(copy).done == 9
    compact_store(copy)
    xr.testing.assert_identical(loaded(copy), loaded(alone))


def test_a_compact_store_is_not_split_for_nothing(copy, monkeypatch):
    monkeypatch.setattr(cluster, "LocalCluster", None)
    compact_store(copy)
    assert run_sweep(SWEEP, copy).computed == 0
    assert Store(copy).is_compact


def test_a_compact_store_resumes_grows_and_is_compact_again(copy, alone):
    Store(copy).forget(POINT)
    compact_store(copy)
    assert run_sweep(SWEEP, copy, workers=1).computed == 1
    assert Store(copy).is_compact
    wider = tiny.full(loads=(150.0, 900.0), velocities=(0.75, 1.0), realizations=())
    assert run_sweep(wider, copy, workers=1).computed == 3
    assert Store(copy).is_compact
    assert verify_store(copy).done == 12
    with xr.open_zarr(copy, chunks=None) as ds, xr.open_zarr(alone, chunks=None) as before:
        own = ds.sel(load=before["load"], velocity=before["velocity"], step=before["step"])
        changed = ["wall_time", "finished_at"]
        xr.testing.assert_equal(own.drop_vars(changed).load(), before.drop_vars(changed).load())
        expected = run_point(wider, 900.0, 0.75).columns["wear_volume"]
        assert ds["wear_volume"].sel(load=900, velocity=0.75).values.tobytes() == expected.tobytes()


@pytest.mark.parametrize("ending", [KeyboardInterrupt, StoreError])
def test_a_compact_store_is_compact_again_after_a_run_that_broke_off(copy, monkeypatch, ending):
    def compute(*_):
        assert not Store(copy).is_compact
        raise ending

    monkeypatch.setattr(sweep, "connected", lambda *_: nullcontext(Here()))
    monkeypatch.setattr(sweep, "compute", compute)
    Store(copy).forget(POINT)
    compact_store(copy)
    with pytest.raises(ending):
        run_sweep(SWEEP, copy)
    assert Store(copy).is_compact
    assert summary(copy).pending == 1


def test_a_compact_store_whose_run_was_killed_is_compact_after_the_next(copy, monkeypatch):
    monkeypatch.setattr(cluster, "LocalCluster", None)
    compact_store(copy)
    relaid(copy, compact=False)
    assert run_sweep(SWEEP, copy).computed == 0
    assert Store(copy).is_compact
    assert verify_store(copy).is_clean


def test_a_store_that_cannot_be_made_compact_again_says_so_and_is_whole(copy, monkeypatch):
    compact_store(copy)
    relaid(copy, compact=False)
    monkeypatch.setattr(Files, "put_many", failing)
    told = []
    run_sweep(SWEEP, copy, tell=told.append)
    assert "not made compact again this time" in told[-1]
    assert "No space left" in told[-1]
    monkeypatch.undo()
    assert verify_store(copy).is_clean


def failing(*_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_failed_and_pending_points_stay_what_they_are(tmp_path):
    path = tmp_path / "tiny.zarr"
    sweep = tiny.sweep(loads=(150.0, 250.0), velocities=(0.5, 1.0), realizations=(1, 2))
    failed, pending = Point(250.0, 0.5, 2), Point(250.0, 1.0, 1)
    store = commit_all(path, sweep, skip=(failed, pending))
    store.fail(failed, "it did not converge – é")
    before = summary(path)
    compact_store(path)
    assert summary(path) == before
    assert (before.done, before.pending, before.failed[0].realization) == (6, 1, 2)
    with open_sweep(path) as ds:
        for point in points(sweep):
            own = ds["time"].sel({n: v for n, v in point._asdict().items() if n in ds.dims}).values
            assert np.isfinite(own).any() == (point not in (failed, pending))


def test_damage_of_a_large_chunk_is_named_and_repaired(copy, alone):
    compact_store(copy)
    for name in ("status", "wear_volume"):
        (chunk,) = (file for file in (copy / name / "c").rglob("*") if file.is_file())
        content = bytearray(chunk.read_bytes())
        content[len(content) // 2] ^= 1
        chunk.write_bytes(content)
    assert len(verify_store(copy, repair=True).damaged) == 9
    assert verify_store(copy).is_clean
    assert run_sweep(SWEEP, copy, workers=1).computed == 9
    changed = ["wall_time", "finished_at"]
    xr.testing.assert_identical(*(loaded(path).drop_vars(changed) for path in (copy, alone)))


def test_the_command_compacts(copy, tmp_path, capsys):
    assert main(["compact", str(copy)]) == 0
    assert Store(copy).is_compact
    with locked(copy), pytest.raises(StoreError, match="in use"):
        compact_store(copy)
    assert main(["compact", str(tmp_path)]) == 2
    assert "is not a store" in capsys.readouterr().err
    prepare(tmp_path / "empty.zarr", SWEEP)
    assert main(["compact", str(tmp_path / "empty.zarr")]) == 0
    assert summary(tmp_path / "empty.zarr").pending == 9


# Readers meanwhile


def relaid(path, compact):
    with locked(path):
        lay_out(path, COMPACT if compact else BY_POINT)


def grown(path, _):
    prepare(path, tiny.full(loads=(150.0, 1500.0), velocities=(0.5, 2.0)))


@pytest.mark.parametrize("change", [relaid, grown])
@pytest.mark.parametrize("compact", [True, False])
def test_what_was_opened_before_a_change_of_layout_reads_the_same_after_it(copy, change, compact):
    relaid(copy, not compact)
    with open_sweep(copy) as expected:
        expected.load()
    with open_sweep(copy) as ds:
        change(copy, compact)
        for name in expected.variables:
            xr.testing.assert_equal(ds[name].load(), expected[name])


@pytest.mark.parametrize("read", [summary, verify_store, lambda path: open_sweep(path).load()])
@pytest.mark.parametrize("compact", [True, False])
@pytest.mark.parametrize("calls", [0, 1])
def test_a_change_of_layout_while_a_store_is_read_changes_nothing(
    copy, monkeypatch, read, compact, calls
):
    relaid(copy, not compact)
    expected, left, contents = read(copy), [calls], Files.contents

    def interrupted(self, keys):
        left[0] -= 1
        if left[0] == -1:
            relaid(copy, compact)
        return contents(self, keys)

    monkeypatch.setattr(Files, "contents", interrupted)
    found = read(copy)
    assert found.equals(expected) if isinstance(found, xr.Dataset) else found == expected
    assert left[0] < 0
