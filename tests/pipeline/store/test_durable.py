"""Files that are on the disk once they are written, by the tests that Zarr ships for stores."""

import errno
import os

import pytest
from zarr.core.buffer import cpu
from zarr.testing.store import StoreTests

from pipeline.store.durable import Durable
from pipeline.store.files import replace_file


class TestDurable(StoreTests[Durable, cpu.Buffer]):
    store_cls = Durable
    buffer_cls = cpu.Buffer

    @pytest.fixture
    def store_kwargs(self, tmp_path):
        return {"root": str(tmp_path)}

    async def set(self, store, key, value):
        file = store.root / key
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(value.to_bytes())

    async def get(self, store, key):
        return self.buffer_cls.from_bytes((store.root / key).read_bytes())

    def test_store_repr(self, store):
        assert store.root.as_posix() in repr(store)

    def test_store_supports_writes(self, store):
        assert store.supports_writes

    def test_store_supports_listing(self, store):
        assert store.supports_listing


def test_a_file_that_cannot_be_written_leaves_the_old_one_and_no_other(tmp_path, monkeypatch):
    def failed(*_):
        raise OSError(errno.EIO, "Input/output error")

    replace_file(tmp_path, "file", b"old")
    monkeypatch.setattr(os, "fsync", failed)
    with pytest.raises(OSError, match="Input/output"):
        replace_file(tmp_path, "file", b"new")
    assert {entry.name: entry.read_bytes() for entry in tmp_path.iterdir()} == {"file": b"old"}


def test_the_name_of_a_new_file_is_on_the_disk_once_it_is_written(tmp_path, monkeypatch):
    seen, fsync = [], os.fsync

    def logged(descriptor):
        fsync(descriptor)
        seen.append((os.fstat(descriptor).st_ino, {one.name for one in tmp_path.iterdir()}))

    monkeypatch.setattr(os, "fsync", logged)
    replace_file(tmp_path, "file", b"content")
    assert seen[-1] == (tmp_path.stat().st_ino, {"file"})
    assert (tmp_path / "file").stat().st_ino in [number for number, _ in seen[:-1]]
