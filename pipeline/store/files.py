"""Files that are on the disk, names included, once they are written."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PARTIAL = ".partial"
"""Ending of the names of files that are being written."""
THREADS = 8
"""Threads that wait for the disk, which then writes several files in one go."""

_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def is_there(file: Path) -> bool:
    """True for a file, False if nothing has its name; raise an `OSError` if nobody can tell."""
    try:
        mode = file.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        if file.is_symlink():  # its disk may be away
            raise OSError(errno.ENOLINK, "it is a link that leads nowhere", str(file)) from None
        return False
    if not stat.S_ISREG(mode):  # a pipe has no end
        raise OSError(errno.EINVAL, "it is not a file", str(file))
    return True


def replace_file(file: Path, content: bytes) -> None:
    """Replace the content of a file at one stroke; return once that is on the disk."""
    make_folder(file.parent)
    if file.parent.is_symlink():  # a stranger's store; it may lead anywhere
        raise OSError(f"{file.parent} is a link to another folder; copy that in its place")
    partial = file.with_name(file.name + PARTIAL)
    try:
        partial.unlink(missing_ok=True)  # left by a killed process, or a link to a file of others
        with partial.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(file)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    sync(file.parent)


def replace_files(root: Path, contents: Mapping[str, bytes]) -> None:
    """Replace several files below a folder, side by side."""
    with ThreadPoolExecutor(THREADS) as threads:
        list(threads.map(replace_file, map(root.joinpath, contents), contents.values()))


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
