"""Readers beside the driver that makes a store longer."""

from dataclasses import replace

import pytest

from pipeline.store import read, verify
from pipeline.store.create import writing
from pipeline.store.place import LOCK, StoreError, place_of
from pipeline.store.progress import summary
from pipeline.store.root import read_root
from pipeline.store.verify import verify_store
from pipeline.store.write import Store
from pipeline.sweep.plan import run_point
from tests.helpers import tiny

FIRST = tiny.full(loads=(150.0,), velocities=(1.0,))
LONGER = replace(FIRST, loads=(150.0, 600.0), velocities=(1.0, 1.5))


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "out.zarr"
    with writing(path, FIRST) as store:
        store.commit([run_point(FIRST, 150.0, 1.0).record(with_fields=True)])
    return path


@pytest.fixture
def earlier(path):
    """Root that a reader has read before the store was made longer."""
    root = read_root(place_of(path))
    with writing(path, LONGER):
        pass
    return root


def test_a_store_that_is_made_longer_while_it_is_opened_is_not_called_damaged(
    path, earlier, monkeypatch
):
    roots = iter([earlier])
    monkeypatch.setattr(read, "read_root", lambda place: next(roots, None) or read_root(place))
    with read.open_store(path) as ds:
        assert ds["status"].values.tolist() in ([[1]], [[1, 0], [0, 0]])


def test_a_store_that_is_made_longer_meanwhile_is_verified_as_it_was(path, earlier, monkeypatch):
    monkeypatch.setattr(verify, "read_root", lambda place: earlier)
    found = verify_store(path)
    assert (found.done, found.is_clean) == (1, True)


def test_and_counted_as_it_was(path, earlier, monkeypatch):
    monkeypatch.setattr("pipeline.store.progress.read_root", lambda place: earlier)
    assert (summary(path).total, summary(path).done) == (1, 1)


def test_a_commit_during_which_the_lock_is_deleted_is_not_told_as_done(path, monkeypatch):
    """Since another driver may have come, and read the statuses before."""
    put = Store._put

    def deleted(self, name, *arguments):
        if name == "status":
            (path / LOCK).unlink(missing_ok=True)
        put(self, name, *arguments)

    with writing(path, LONGER) as store:
        monkeypatch.setattr(Store, "_put", deleted)
        with pytest.raises(StoreError, match="was deleted or replaced"):
            store.commit([run_point(LONGER, 600.0, 1.0).record(with_fields=True)])
