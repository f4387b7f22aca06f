"""The lock of a store: one driver writes at a time, whatever path it used for the store.

It is a `flock`, which the kernel releases when its process dies. Its file names process and host,
for machines that share a disk and do not see each other's locks. An object store has no locks.
"""

from __future__ import annotations

import errno
import os
import re
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress

from pipeline.store.files import is_there, make_folder, open_file
from pipeline.store.place import LOCK, Bucket, Folder, StoreError, StorePlace, writes
from pipeline.sweep.stages import Progress, Report, silent

try:
    import fcntl
except ImportError:  # not a POSIX system: stores can be read, but not written
    fcntl = None  # type: ignore[assignment]

_CONTENT = re.compile(rb"(process \d+ on (\S+))\n")
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
_LONGEST = 1000  # bytes of the file that are read
_TRIES, _PAUSE = 10, 0.05  # [s]: who asks for the holder has the lock for a moment


Lock = Callable[[], bool]
"""Tells whether a lock that this process took is still in its place."""


@contextmanager
def held(place: StorePlace, progress: Report = silent) -> Iterator[Lock]:
    """Hold the lock of a store at once; raise a `StoreError` if another process does.

    Where there are no locks, say so, and hold nothing.
    """
    unlocked = Progress(f"{place} has no locks: let one run at a time write to it")
    if isinstance(place, Bucket):
        progress(unlocked)
        yield lambda: True
        return
    if fcntl is None:
        raise StoreError(
            "this system has no file locks, which irg run needs; run it on Linux or macOS, or "
            "within WSL on Windows (commands that only read a store work here)"
        )
    with ExitStack() as stack:
        with writes(place):
            descriptor = _open_lock(place)
            stack.callback(os.close, descriptor)
            if not _is_flocked(place, descriptor):
                progress(unlocked)
            name, host = _named(os.pread(descriptor, _LONGEST, 0))
            if host not in (None, socket.gethostname()):
                raise StoreError(
                    f"{place} is in use by {name}; if that has ended, delete {place}/{LOCK}"
                )
            os.ftruncate(descriptor, 0)
            stack.callback(_empty, descriptor)
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        yield lambda: _is_in_place(place, descriptor)


def _open_lock(folder: Folder) -> int:
    """Open the file of a lock, which may be new."""
    make_folder(folder.path)
    is_there(folder.path, LOCK)  # raises if it is something else
    return open_file(folder.path, LOCK, os.O_RDWR, make=True)


def _empty(descriptor: int) -> None:
    """Empty the file of a lock if its disk still can; the lock is released in any case."""
    with suppress(OSError):
        os.ftruncate(descriptor, 0)


def _is_flocked(folder: Folder, descriptor: int) -> bool:
    """Lock a file; False if its disk cannot."""
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
    name, _ = _named(os.pread(descriptor, _LONGEST, 0))
    raise StoreError(f"{folder} is in use by {name}; wait for it, or write to another store")


def _is_in_place(folder: Folder, descriptor: int) -> bool:
    """True if nobody has deleted or replaced the file of a lock."""
    try:
        return os.path.samestat(os.fstat(descriptor), (folder.path / LOCK).lstat())
    except OSError:  # also on a file server that no longer knows the folder
        return False


def holder_of(place: StorePlace) -> str | None:
    """Name the process that writes to a store; None if there is none."""
    if isinstance(place, Bucket) or fcntl is None:
        return None
    with suppress(OSError):
        name, host = _named(place.read(LOCK) or b"")
        if host not in (None, socket.gethostname()) or _is_locked(place):
            return name
    return None


def _is_locked(folder: Folder) -> bool:
    """True if a process of this host holds a lock."""
    descriptor = open_file(folder.path, LOCK, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def _named(content: bytes) -> tuple[str, str | None]:
    """Process that a lock names, and its host."""
    match = _CONTENT.fullmatch(content)
    if match is None:
        return "another process", None
    return match[1].decode(errors="replace"), match[2].decode(errors="replace")
