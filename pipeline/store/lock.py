"""Locks: on a file, released by the kernel when its process dies; elsewhere by hand if it died.

Elsewhere is an object store, or a file system without locks; a process that has died there is
recognized on its own machine alone.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import socket
import stat
import tempfile
import uuid
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.store.remote import Remote

try:
    import fcntl
except ImportError:  # not a POSIX system: stores can be read, but not written
    fcntl = None  # type: ignore[assignment]

_SAID = re.compile(r"process (\d+) on (\S+)\n")
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)


class HeldError(Exception):
    """The lock is held by someone else; the message says by whom."""


class LockWarning(UserWarning):
    """A lock that is weaker than usual."""


@contextmanager
def hold(file: Path | Remote) -> Iterator[None]:
    """Hold the lock, at once or not at all.

    The file says which process holds it. The kernel releases the lock of a process that dies, so
    a file that is left behind does no harm on the same machine. Where another machine left it,
    over a shared file system whose locks may not reach that far or in an object store, only a
    person can tell. A file that does not say in full who holds it was cut short, and counts as
    left behind.

    Raises
    ------
    HeldError
        If another process holds it.
    OSError
        If it cannot be created, or the system has no locks on files.
    """
    if fcntl is None:
        raise OSError(
            "this system has no locks on files, which runs need; run on Linux or macOS, or within "
            "WSL on Windows: irg check, point, boundary, margin and plot work here, too"
        )
    if isinstance(file, Remote):
        with _hold_file(_stand_in(file)):  # against others on this machine
            _create(file)
            try:
                yield
            finally:
                file.unlink(missing_ok=True)
    else:
        file = Path(os.path.realpath(file))
        file.parent.mkdir(parents=True, exist_ok=True)
        with _hold_file(file):
            yield


def holder(file: Path | Remote) -> str | None:
    """Tell who holds the lock, or on another machine may hold it; None if nobody does."""
    if fcntl is None:  # who writes is elsewhere, and not to be seen from here
        return None
    if isinstance(file, Remote):
        try:
            said = _complete(file.read_bytes())
        except OSError:
            return None
        return holder(_stand_in(file)) if said is None or _is_here(said) else said
    try:
        descriptor = os.open(os.path.realpath(file), os.O_RDONLY | os.O_NONBLOCK)
    except OSError:
        return None
    try:
        said = _complete(os.read(descriptor, 1000)) if _is_file(descriptor) else None
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return said or "another process"
    except OSError:  # no locks here
        return said if said and _lives(said) else None
    finally:
        os.close(descriptor)
    return None if said is None or _is_here(said) else said


def _create(lock: Remote) -> None:
    """Create the object that serves as the lock, unless another machine has."""
    try:
        lock.write_bytes(_self(), exclusive=True)
    except FileExistsError:
        _refuse_if_elsewhere(_complete(lock.read_bytes()), lock)
        lock.write_bytes(_self())  # left behind by a process of this machine


def _stand_in(lock: Remote) -> Path:
    """A file that stands for a lock in an object store on this machine."""
    digest = hashlib.sha256(lock.url.encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"irg-{os.getuid()}-{digest}.lock"


def _self() -> bytes:
    return f"process {os.getpid()} on {socket.gethostname()}\n".encode()


def _complete(content: bytes) -> str | None:
    """Who holds a lock, if its content says so in full."""
    said = content.decode(errors="replace")
    return said.strip() if _SAID.fullmatch(said) else None


def _is_here(said: str) -> bool:
    return said.endswith(f" on {socket.gethostname()}")


def _lives(said: str) -> bool:
    """Whether the holder of a lock may still hold it."""
    if not _is_here(said):
        return True
    try:
        os.kill(int(said.split()[1]), 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _refuse_if_elsewhere(said: str | None, lock: Path | Remote) -> None:
    if said and not _is_here(said):
        raise HeldError(f"{said} (if that has ended, delete {lock})")


@contextmanager
def _hold_file(file: Path) -> Iterator[None]:
    descriptor = _lock(file)
    try:
        if descriptor is None:
            _claim(file)
            warnings.warn(
                f"the file system of {file} has no locks, and the mere presence of {file.name} "
                "serves as one: a process that dies leaves it behind, and other machines do not go "
                "on until it is deleted",
                LockWarning,
                stacklevel=2,
            )
        else:
            _refuse_if_elsewhere(_complete(os.read(descriptor, 1000)), file)
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, _self(), 0)
        try:
            yield
        finally:
            file.unlink(missing_ok=True)
    finally:
        if descriptor is not None:
            os.close(descriptor)


def _lock(file: Path) -> int | None:
    """Open and lock a file; None where there are no locks."""
    while True:
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_NONBLOCK, 0o644)
        try:
            if not _is_file(descriptor):
                raise OSError(f"{file} is not a file; delete it")
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if file.exists() and os.path.samestat(os.fstat(descriptor), file.stat()):
                return descriptor
        except BlockingIOError:
            said = _complete(os.read(descriptor, 1000))
            os.close(descriptor)
            raise HeldError(said or "another process") from None
        except BaseException as error:
            os.close(descriptor)
            if isinstance(error, OSError) and error.errno in _NO_LOCKS:
                return None
            raise
        os.close(descriptor)  # removed by its last holder after we had opened it


def _claim(file: Path) -> None:
    """Name this process in a file as its holder, where there are no locks."""
    said = _complete(file.read_bytes())
    if said and _lives(said):
        raise HeldError(said if _is_here(said) else f"{said} (if that has ended, delete {file})")
    own = file.with_name(f"{file.name}.{uuid.uuid4().hex}")
    file.rename(own)  # which only one can do
    try:
        if _complete(own.read_bytes()) == said:  # and not that of somebody who was faster
            own.write_bytes(_self())
        os.link(own, file)
        if _complete(file.read_bytes()) != _complete(_self()):
            raise HeldError("another process")
    except FileExistsError:
        raise HeldError("another process") from None
    finally:
        own.unlink()


def _is_file(descriptor: int) -> bool:
    return stat.S_ISREG(os.fstat(descriptor).st_mode)
