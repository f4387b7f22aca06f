"""The lock of a store: one process writes at a time, whatever path it used for the store.

It is a `flock`, which the kernel releases when the process dies. The lock file names process and
host, for machines that share a disk and do not see each other's locks. An object store has none.
"""

from __future__ import annotations

import errno
import fcntl
import os
import re
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from pipeline.store.files import open_file
from pipeline.store.place import LOCK, Bucket, Folder, StoreError, StorePlace, io_errors
from pipeline.sweep.stages import Progress, Report, silent

_CONTENT = re.compile(r"(process \d+ on (\S+))\n")
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
_TRIES, _PAUSE = 10, 0.05  # tries and pause [s], since `holder_of` takes the lock for a moment


Lock = Callable[[], bool]
"""Function that returns True if a lock which this process took is still in its place."""


@contextmanager
def locked(place: StorePlace, progress: Report = silent) -> Iterator[Lock]:
    """Context manager: hold the lock of a store; `StoreError` if another process has it.

    Yields a function that returns True if the lock is still there. If the disk or object store has
    no locks, a note is reported, and the block runs without a lock.
    """
    unlocked = Progress(f"{place} has no locks: let one run at a time write to it")
    if not isinstance(place, Folder):
        if isinstance(place, Bucket):
            progress(unlocked)
        yield lambda: True
        return
    with io_errors(place, "written"):
        descriptor = open_file(place.path, LOCK)
    try:
        with io_errors(place, "written"):
            if not _flock(place, descriptor):
                progress(unlocked)
            name, host = _read_holder(descriptor)
            if host not in (None, socket.gethostname()):
                raise StoreError(
                    f"{place} is in use by {name}; if that has ended, delete {place}/{LOCK}"
                )
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        try:
            yield lambda: _is_in_place(place, descriptor)
        finally:
            with suppress(OSError):  # the lock is released in any case
                os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _flock(folder: Folder, descriptor: int) -> bool:
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
    raise StoreError(f"{folder} is in use by {holder}; wait for it, or write to another store")


def _is_in_place(folder: Folder, descriptor: int) -> bool:
    """True if the open lock file, `descriptor`, is still in its folder, not deleted or replaced."""
    try:
        return os.path.samestat(os.fstat(descriptor), (folder.path / LOCK).lstat())
    except OSError:  # also on a file server that no longer knows the folder
        return False


def holder_of(place: StorePlace) -> str | None:
    """Process and host that write to a store, in words; None if no process does.

    It is also None if that is not known, as on an object store.
    """
    if not isinstance(place, Folder):
        return None
    with suppress(OSError):
        descriptor = os.open(place.path / LOCK, os.O_RDONLY | os.O_NONBLOCK)
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
