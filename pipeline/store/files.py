"""Files of a closed tree, which are on the disk, names included, once they are written.

A file is named by a root and a key, such as ``load/c.0``. The root may be a link. Below it, nothing
is written or locked by way of a link.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PARTIAL = ".irg-partial"
"""Ending of the names of files that are being written; nobody else's files have it."""
THREADS = 8
"""Threads that wait for the disk, which then writes several files in one go."""

_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def _file_of(root: Path, key: str) -> Path:
    """Path of a file, with its folder made; raise an `OSError` if a link leads there."""
    path = root / key
    for folder in reversed(path.parents[: key.count("/")]):
        _require_no_link(folder)
    make_folder(path.parent)
    return path


def _require_no_link(path: Path) -> None:
    if path.is_symlink():
        what = "it is a link, and a store has none: put what it leads to in its place"
        raise OSError(errno.ELOOP, what, os.fspath(path))


def open_file(root: Path, key: str) -> int:
    """Open a file to read and write, made if need be; return its descriptor."""
    path = _file_of(root, key)
    _require_no_link(path)
    require_file(path)  # a pipe has no end
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)


def replace_files(root: Path, contents: Mapping[str, bytes]) -> None:
    """Replace files, each at one stroke; return once all are on the disk, names included."""
    make_folder(root)
    paths = [_file_of(root, key) for key in contents]
    with ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(write_file, paths, contents.values()))
        list(threads.map(sync, {path.parent for path in paths}))


def write_file(path: Path, content: bytes) -> None:
    """Write a file beside its place, wait until it is on the disk, and rename it."""
    begun = path.with_name(path.name + PARTIAL)
    _require_no_link(begun)
    try:
        with begun.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        begun.replace(path)
    except BaseException:
        begun.unlink(missing_ok=True)
        raise


def remove_file(root: Path, key: str) -> None:
    """Remove a file, if it is there."""
    _file_of(root, key).unlink(missing_ok=True)


def make_folder(folder: Path) -> None:
    """Make a folder and those above it; return once their names are on the disk."""
    if not folder.is_dir():
        make_folder(folder.parent)
        folder.mkdir(exist_ok=True)
        sync(folder.parent)


def sync(folder: Path) -> None:
    """Wait until the names in a folder are on the disk, as far as its system can tell."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)


def require_file(path: Path) -> None:
    """Raise an `OSError` for what is there and is no file, or a link to what is not there now.

    A pipe would keep a reader waiting, and data on a disk that is not mounted are not missing.
    """
    try:
        kind = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        if path.is_symlink():
            raise
        return
    if not stat.S_ISREG(kind):
        raise OSError(errno.EINVAL, "it is not a file", str(path))
