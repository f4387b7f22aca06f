"""Files of a closed tree, which are on the disk, names included, once they are written.

A file is named by a root and a key, such as ``load/c.0``. The root may be a link. No name below it
is followed if it is one, and none leads out of it.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

PARTIAL = ".irg-partial"
"""Ending of the names of files that are being written; nobody else's files have it."""
THREADS = 8
"""Threads that wait for the disk, which then writes several files in one go."""

_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def is_there(root: Path, key: str) -> bool:
    """True for a file, False if nothing has its name; raise an `OSError` if nobody can tell.

    Also for a link, on the way or in its place.
    """
    file = root
    for name in _names(key):
        file /= name
        require_no_link(file)
    try:
        mode = file.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    if not stat.S_ISREG(mode):  # a pipe has no end
        raise OSError(errno.EINVAL, "it is not a file", str(file))
    return True


def require_no_link(path: Path | os.DirEntry[str]) -> None:
    """Raise an `OSError` for a link, which may lead anywhere."""
    if path.is_symlink():
        what = "it is a link, and a store has none: put what it leads to in its place"
        raise OSError(errno.ELOOP, what, os.fspath(path))


def _names(key: str) -> list[str]:
    """Names on the way to a key."""
    names = key.split("/")
    if not {"", ".", ".."}.isdisjoint(names):
        raise OSError(f"{key} names no file within a store")
    return names


@contextmanager
def _folder_of(root: Path, key: str, make: bool = False) -> Iterator[tuple[int, str]]:
    """Open the folder of a key, made if asked to; yield its descriptor and the key's last name."""
    *above, name = _names(key)
    with ExitStack() as stack:
        descriptor = os.open(root, os.O_RDONLY | os.O_DIRECTORY)
        stack.callback(os.close, descriptor)
        for folder in above:
            root /= folder
            if make:
                with suppress(FileExistsError):
                    os.mkdir(folder, dir_fd=descriptor)
                    sync(root.parent)
            descriptor = _open(root, os.O_RDONLY | os.O_DIRECTORY, descriptor)
            stack.callback(os.close, descriptor)
        yield descriptor, name


def _open(path: Path, flags: int, folder: int) -> int:
    """Open a path by its last name in an open folder; an `OSError` names it if it is a link."""
    try:
        return os.open(path.name, flags | os.O_NOFOLLOW, 0o666, dir_fd=folder)
    except OSError:
        require_no_link(path)
        raise


def open_file(root: Path, key: str, flags: int, make: bool = False) -> int:
    """Open a file, which is made with its folders if asked to; return its descriptor."""
    with _folder_of(root, key, make) as (folder, _):
        # A pipe in its place must not wait for a reader.
        return _open(root / key, flags | os.O_NONBLOCK | (os.O_CREAT if make else 0), folder)


def replace_file(root: Path, key: str, content: bytes) -> None:
    """Replace the content of a file at one stroke; return once that is on the disk."""
    make_folder(root)
    with _folder_of(root, key, make=True) as (folder, name):
        require_no_link(root / key)
        begun = root / (key + PARTIAL)
        remove_file(root, key + PARTIAL)  # left by a killed process
        try:
            descriptor = _open(begun, os.O_WRONLY | os.O_CREAT | os.O_EXCL, folder)
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(begun.name, name, src_dir_fd=folder, dst_dir_fd=folder)
        except BaseException:
            remove_file(root, key + PARTIAL)
            raise
    sync(begun.parent)


def replace_files(root: Path, contents: Mapping[str, bytes]) -> None:
    """Replace several files below a root, side by side."""
    with ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(partial(replace_file, root), contents, contents.values()))


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
    """Wait until the names in a folder are on the disk, as far as its file system can tell."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)
