"""The lock of a store: one driver writes at a time, by whatever path it came.

In a folder it is a `flock` on a file of the store, which the kernel releases when its process dies;
the file says who holds it. In an object store it is the exclusive creation of an object, which a
killed process leaves behind.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import socket
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from pipeline.store.files import make_folder
from pipeline.store.place import LOCK, Bucket, Folder, Place, StoreError, writes

try:
    import fcntl
except ImportError:  # not a POSIX system: stores can be read, but not written
    fcntl = None  # type: ignore[assignment]

_HOLDER = re.compile(r"process (\d+) on (\S+)\n")
# A pipe in place of the file must not wait for a reader, nor a link lead to a file of others.
_AS_IT_IS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)


@dataclass(frozen=True, slots=True)
class Lock:
    """A lock that this process holds: a file and its open descriptor."""

    file: Path
    descriptor: int

    def is_in_place(self) -> bool:
        """True if the file that was locked still lies at its path."""
        try:
            return os.path.samestat(os.fstat(self.descriptor), self.file.stat())
        except OSError:  # also on a file server that no longer knows the folder
            return False


@contextmanager
def held(place: Place) -> Iterator[Lock]:
    """Hold the lock of a store, at once or not at all.

    Raise a `StoreError` if another process holds it, the disk has no locks, or the place cannot be
    written to.
    """
    if fcntl is None:
        raise StoreError(
            "this system has no file locks, which irg run needs; run it on Linux or macOS, or "
            "within WSL on Windows (commands that only read a store work here)"
        )
    with ExitStack() as stack:
        with writes(place):
            lock = stack.enter_context(_locked(_file(place), str(place)))
            if isinstance(place, Bucket):
                stack.enter_context(_created(place))
        yield lock


def holder_of(place: Place) -> str | None:
    """Name the process that writes to a store; None if there is none.

    A process of another machine counts as long as its name stands in the lock.
    """
    if fcntl is None:
        return None
    try:
        name = _complete(place.read(LOCK) or b"")
    except OSError:
        return None
    if name and (_may_write(name) if isinstance(place, Bucket) else not _is_here(name)):
        return name
    return (name or "another process") if _is_locked(_file(place)) else None


@contextmanager
def _locked(file: Path, store: str) -> Iterator[Lock]:
    make_folder(file.parent)
    if os.path.lexists(file) and (file.is_symlink() or not file.is_file()):
        raise OSError(f"{file} is not a file; delete it")
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | _AS_IT_IS, 0o644)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = _complete(os.read(descriptor, 1000))
            raise _in_use(store, holder or "another process") from None
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise
            raise StoreError(
                f"{store}: the disk has no locks on files, without which two runs could write at "
                "the same time and lose points; give a folder on another disk"
            ) from None
        name = _complete(os.read(descriptor, 1000))
        if name and not _is_here(name):
            # The kernel's locks may not reach from machine to machine.
            raise _in_use(store, f"{name} (if that has ended, delete {file})")
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, _this_process(), 0)
        try:
            yield Lock(file, descriptor)
        finally:
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


@contextmanager
def _created(bucket: Bucket) -> Iterator[None]:
    """Hold the lock of an object store, of which this process holds the stand-in."""
    if not bucket.create(LOCK, _this_process()):
        holder = (bucket.read(LOCK) or b"").decode(errors="replace").strip()
        if holder and _may_write(holder):
            raise _in_use(str(bucket), f"{holder} (if that has ended, delete {bucket}/{LOCK})")
        bucket.put({LOCK: _this_process()})  # left behind by a process of this machine
    try:
        yield
    finally:
        bucket.remove(LOCK)


def _is_locked(file: Path) -> bool:
    try:
        with open(file, "rb", opener=lambda path, mode: os.open(path, mode | _AS_IT_IS)) as stream:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    return False


def _in_use(store: str, holder: str) -> StoreError:
    return StoreError(f"{store} is in use by {holder}; wait for it, or write to another store")


def _file(place: Place) -> Path:
    """File that is locked: one of the store, or on this machine one that stands for a bucket's."""
    if isinstance(place, Folder):
        return place.path / LOCK
    digest = hashlib.sha256(place.address.encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"irg-{os.getuid()}-{digest}.lock"


def _this_process() -> bytes:
    return f"process {os.getpid()} on {socket.gethostname()}\n".encode()


def _complete(content: bytes) -> str | None:
    """Holder that a lock names, if it names one in full."""
    text = content.decode(errors="replace")
    return text.strip() if _HOLDER.fullmatch(text) else None


def _is_here(holder: str) -> bool:
    return holder.endswith(f" on {socket.gethostname()}")


def _may_write(holder: str) -> bool:
    """True for a process elsewhere, and for another one here that lives, perhaps another user's."""
    number = _HOLDER.fullmatch(f"{holder}\n")
    if not number or not _is_here(holder):
        return True
    try:
        os.kill(int(number[1]), 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return int(number[1]) != os.getpid()
