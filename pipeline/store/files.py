"""Files of a folder: each is replaced as a whole, synced to the disk, and not behind a link."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from pathlib import Path

PARTIAL = ".irg-partial"
"""Ending of files being written."""
_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def store_file(folder: Path, key: str, content: bytes) -> Path:
    """Create or replace the file `key` below a folder; return the folder to sync."""
    path = folder / key
    for above in _folders_above(folder, key):
        if above.is_symlink():
            problem = (
                "it is a symbolic link, which a store must not contain: replace it by the file "
                "itself"
            )
            raise OSError(errno.ELOOP, problem, os.fspath(above))
    make_folder(path.parent)
    write_file(path, content)
    return path.parent


def wrong_kind(folder: Path, key: str) -> OSError:
    """Error that a folder has the name of the file `key`, or a file the name of a folder above."""
    for above in _folders_above(folder, key):
        if not above.is_dir():
            problem = "it is a file, where a store has a folder: move it to another place"
            return NotADirectoryError(errno.ENOTDIR, problem, os.fspath(above))
    problem = "it is a folder, where a store has a file: move it to another place"
    return IsADirectoryError(errno.EISDIR, problem, os.fspath(folder / key))


def _folders_above(folder: Path, key: str) -> Iterator[Path]:
    return reversed((folder / key).parents[: key.count("/")])


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


def link_files(source: Path, target: Path, pattern: re.Pattern[str]) -> None:
    """Give the files of a folder whose names match a second name in the folder `target`.

    If the disk has no hard links, the files are copied. A store replaces its files and never
    changes them, so the two names are independent.
    """
    make_folder(target)
    for file in source.iterdir() if source.is_dir() else ():
        if pattern.fullmatch(file.name):
            try:
                (target / file.name).hardlink_to(file)
            except OSError:
                write_file(target / file.name, file.read_bytes())
    sync(target)


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
