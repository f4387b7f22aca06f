"""Files that are on the disk once they are written."""

import errno
import os

import pytest

from pipeline.store.files import replace_files


def test_a_file_that_cannot_be_written_leaves_the_old_one_and_no_other(tmp_path, monkeypatch):
    def failed(*_):
        raise OSError(errno.EIO, "Input/output error")

    replace_files(tmp_path, {"file": b"old"})
    monkeypatch.setattr(os, "fsync", failed)
    with pytest.raises(OSError, match="Input/output"):
        replace_files(tmp_path, {"file": b"new"})
    assert {entry.name: entry.read_bytes() for entry in tmp_path.iterdir()} == {"file": b"old"}


def test_the_name_of_a_new_file_is_on_the_disk_once_it_is_written(tmp_path, monkeypatch):
    seen, fsync = [], os.fsync

    def logged(descriptor):
        fsync(descriptor)
        seen.append((os.fstat(descriptor).st_ino, {one.name for one in tmp_path.iterdir()}))

    monkeypatch.setattr(os, "fsync", logged)
    replace_files(tmp_path, {"file": b"content"})
    assert seen[-1] == (tmp_path.stat().st_ino, {"file"})
    assert (tmp_path / "file").stat().st_ino in [number for number, _ in seen[:-1]]
