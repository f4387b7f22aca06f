"""The lock of a store: one process writes at a time, by whatever path it opened the store.

The lock is a `flock` of a file next to the store, which the kernel releases when the process dies.
The file names process and host, for machines that share a disk but not locks.
"""

from __future__ import annotations

import errno
import fcntl
import os
import re
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pipeline.paths import make_folder, open_regular
from pipeline.progress import Progress, Report, silent
from pipeline.store.location import LOCK, StoreError, io_errors, sibling

_CONTENT = re.compile(r"(process \d+ on (\S+))\n")
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
_TRIES, _PAUSE = 10, 0.05  # retries and pause [s], since `holder_of` takes the lock briefly


class Lock:
    """A lock that this process holds: the open lock file of a store."""

    def __init__(self, folder: Path) -> None:
        self.path = sibling(folder, LOCK)
        make_folder(self.path.parent)
        self.descriptor = open_regular(self.path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW)

    def is_in_place(self) -> bool:
        """True if the lock file has not been deleted or replaced."""
        try:
            return os.path.samestat(os.fstat(self.descriptor), self.path.lstat())
        except OSError:  # also from a file server that has lost the folder
            return False


@contextmanager
def locked(folder: Path, progress: Report = silent) -> Iterator[Lock]:
    """Context manager: hold the lock of a store in a folder; `StoreError` if another process does.

    If the disk has no locks, this is reported and the block runs without a lock.
    """
    with io_errors(folder, "written"):
        lock = Lock(folder)
    try:
        with io_errors(folder, "written"):
            if not _flock(folder, lock.descriptor):
                problem = f"{folder} cannot be locked: make sure that only one run writes to it"
                progress(Progress(problem))
            name, host = _read_holder(lock.descriptor)
            if host not in (None, socket.gethostname()):
                problem = f"in use by {name}; if that has ended, delete {lock.path}"
                raise StoreError(f"{folder} is {problem}")
            if not lock.is_in_place():
                raise StoreError(f"another run has just released {folder}; run the command again")
            os.ftruncate(lock.descriptor, 0)
            holder = f"process {os.getpid()} on {socket.gethostname()}\n"
            os.pwrite(lock.descriptor, holder.encode(), 0)
        try:
            yield lock
        finally:
            with suppress(OSError):  # the lock is released in any case
                if lock.is_in_place():
                    lock.path.unlink()
    finally:
        os.close(lock.descriptor)


def _flock(folder: Path, descriptor: int) -> bool:
    """Lock an open lock file; False if the disk has no locks, `StoreError` if others hold it."""
    for _ in range(_TRIES):
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(_PAUSE)
        except OSError as error:
            if error.errno in _NO_LOCKS:
                return False
            raise
        else:
            return True
    holder = _read_holder(descriptor)[0]
    raise StoreError(f"{folder} is in use by {holder}; wait, or write to another store")


def holder_of(location: Path) -> str | None:
    """Process and host that write to a store, in words; None if there is none."""
    with suppress(OSError):
        descriptor = os.open(sibling(location, LOCK), os.O_RDONLY | os.O_NONBLOCK)
        try:
            name, host = _read_holder(descriptor)
            if host not in (None, socket.gethostname()):
                return name
            fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return name
        finally:
            os.close(descriptor)
    return None


def _read_holder(descriptor: int) -> tuple[str, str | None]:
    """Read the names of process and host in an open lock file; the host is None if unknown."""
    match = _CONTENT.fullmatch(os.pread(descriptor, 1000, 0).decode(errors="replace"))
    return (match[1], match[2]) if match else ("another process", None)
