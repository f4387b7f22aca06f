"""Files: each is replaced as a whole and synced to the disk."""

from __future__ import annotations

import errno
import os
from pathlib import Path

PARTIAL = ".irg-partial"
"""Ending of files being written."""
_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def store_file(folder: Path, key: str, content: bytes) -> Path:
    """Create or replace the file `key` below a folder; return the folder to sync."""
    path = folder / key
    make_folder(path.parent)
    write_file(path, content)
    return path.parent


def write_file(path: Path, content: bytes) -> None:
    """Write a file under a temporary name, sync it to the disk, and rename it."""
    partial_file = path.with_name(path.name + PARTIAL)
    partial_file.unlink(missing_ok=True)  # left by a kill, or a link to another file
    try:
        with partial_file.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial_file.replace(path)
    except BaseException:
        partial_file.unlink(missing_ok=True)
        raise


def make_folder(folder: Path) -> None:
    """Make a folder and the folders above it; return once they are on the disk."""
    if not folder.is_dir():
        make_folder(folder.parent)
        folder.mkdir(exist_ok=True)
        sync(folder.parent)


def sync(folder: Path) -> None:
    """Wait until the names of a folder's files are on the disk, if the file system allows it."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)
