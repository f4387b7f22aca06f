"""Files of a closed tree, which are on the disk, names included, once they are written.

A file is named by a root and a key, such as ``load/c.0``. The root may be a link. Below it, nothing
is written or locked by way of a link, and no name leads out of it.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

PARTIAL = ".irg-partial"
"""Ending of the names of files that are being written; nobody else's files have it."""
THREADS = 8
"""Threads that wait for the disk, which then writes several files in one go."""

_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder
_FOLDER = os.O_RDONLY | os.O_DIRECTORY


@contextmanager
def _folder_of(root: Path, key: str, make: bool = False) -> Iterator[tuple[int, str]]:
    """Open the folder of a key, made if asked to; yield its descriptor and the key's last name."""
    *above, name = names = key.split("/")
    if not {"", ".", ".."}.isdisjoint(names):
        raise OSError(f"{key} names no file within a store")
    with ExitStack() as stack:
        descriptor = os.open(root, _FOLDER)
        stack.callback(os.close, descriptor)
        for folder in above:
            root /= folder
            if make:
                with suppress(FileExistsError):
                    os.mkdir(folder, dir_fd=descriptor)
                    sync(root.parent)
            descriptor = _open(root, _FOLDER, descriptor)
            stack.callback(os.close, descriptor)
        yield descriptor, name


def _open(path: Path, flags: int, folder: int) -> int:
    """Open a path by its last name in an open folder; an `OSError` has the path."""
    try:
        return os.open(path.name, flags | os.O_NOFOLLOW, 0o666, dir_fd=folder)
    except OSError as error:
        _require_no_link(path)
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def _require_no_link(path: Path) -> None:
    """Raise an `OSError` for a link, which may lead anywhere."""
    if path.is_symlink():
        what = "it is a link, and a store has none: put what it leads to in its place"
        raise OSError(errno.ELOOP, what, os.fspath(path))


def open_file(root: Path, key: str, flags: int) -> int:
    """Open a file, with its folders made if it may be new; return its descriptor."""
    with _folder_of(root, key, bool(flags & os.O_CREAT)) as (folder, _):
        descriptor = _open(root / key, flags | os.O_NONBLOCK, folder)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):  # a pipe has no end
        os.close(descriptor)
        raise OSError(errno.EINVAL, "it is not a file", os.fspath(root / key))
    return descriptor


def replace_files(root: Path, contents: Mapping[str, bytes]) -> None:
    """Replace files, each at one stroke; return once all are on the disk, names included."""
    make_folder(root)
    folders: dict[str, list[str]] = {}
    for key in contents:
        folders.setdefault(key.rpartition("/")[0], []).append(key)

    def replace(keys: Sequence[str]) -> None:
        with _folder_of(root, keys[0], make=True) as (folder, _):
            for key in keys:
                write_file(folder, root / key, contents[key])
            _sync(folder)

    with ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(replace, folders.values()))


def write_file(folder: int, path: Path, content: bytes) -> None:
    """Write a file of an open folder beside its place, wait until it is on the disk, rename it."""
    begun = path.with_name(path.name + PARTIAL)
    try:
        descriptor = _open(begun, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, folder)
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(begun.name, path.name, src_dir_fd=folder, dst_dir_fd=folder)
    except BaseException:
        with suppress(FileNotFoundError):
            os.unlink(begun.name, dir_fd=folder)
        raise


def remove_file(root: Path, key: str) -> None:
    """Remove a file, if it is there."""
    with suppress(FileNotFoundError), _folder_of(root, key) as (folder, name):
        os.unlink(name, dir_fd=folder)


def make_folder(folder: Path) -> None:
    """Make a folder and those above it; return once their names are on the disk."""
    if not folder.is_dir():
        make_folder(folder.parent)
        folder.mkdir(exist_ok=True)
        sync(folder.parent)


def sync(folder: Path) -> None:
    """Wait until the names in a folder are on the disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        _sync(descriptor)
    finally:
        os.close(descriptor)


def _sync(folder: int) -> None:
    """Wait until the names in an open folder are on the disk, as far as its system can tell."""
    try:
        os.fsync(folder)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise


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
