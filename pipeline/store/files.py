"""Files of a store, which are on the disk, names included, once they are written.

A file is named by a root and a key, such as ``load/c.0``. The root may be a link. Below it, nothing
is written or locked through a link.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from pipeline.paths import open_regular

PARTIAL = ".irg-partial"
"""Ending of the names of files that are being written; nobody else's files have it."""
THREADS = 8
"""Threads that wait for the disk, which then writes several files in one go."""

_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def _path_of(root: Path, key: str) -> Path:
    """Path of the file `key` in the store `root`; `OSError` if a folder of the path is a link."""
    path = root / key
    for folder in reversed(path.parents[: key.count("/")]):
        _require_no_link(folder)
    return path


def _require_no_link(path: Path) -> None:
    if path.is_symlink():
        what = "it is a link, and a store has none: put what it leads to in its place"
        raise OSError(errno.ELOOP, what, os.fspath(path))


def open_file(root: Path, key: str) -> int:
    """Open or create the file `key` of a store; return its file descriptor.

    `OSError` for a link, a file with a second name, and what is no regular file.
    """
    path = _path_of(root, key)
    _require_no_link(path)
    make_folder(path.parent)
    descriptor = open_regular(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW)
    if os.fstat(descriptor).st_nlink > 1:
        os.close(descriptor)
        what = "it is a hard link, so it has another name: delete it if no run uses the store"
        raise OSError(errno.EMLINK, what, os.fspath(path))
    return descriptor


def replace_files(root: Path, contents: Mapping[str, bytes]) -> None:
    """Create or replace files (`contents` by key), each atomically; return once on the disk."""
    paths = [_path_of(root, key) for key in contents]
    folders = {path.parent for path in paths}
    for folder in folders:
        make_folder(folder)
    with ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(write_file, paths, contents.values()))
        list(threads.map(sync, folders))


def write_file(path: Path, content: bytes) -> None:
    """Write a file under a temporary name, wait until it is on the disk, and rename it."""
    begun = path.with_name(path.name + PARTIAL)
    _require_no_link(begun)
    begun.unlink(missing_ok=True)  # left by a kill, or a hard link to somebody's file
    try:
        with begun.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        begun.replace(path)
    except BaseException:
        begun.unlink(missing_ok=True)
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
