"""A lock on a file, which ends with the process that holds it; or at an address, with a person."""

from __future__ import annotations

import fcntl
import hashlib
import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.store.remote import Remote

__all__ = ["HeldError", "hold", "holder"]


class HeldError(Exception):
    """The lock is held by someone else; the message says by whom."""


@contextmanager
def hold(file: Path | Remote) -> Iterator[None]:
    """Hold the lock, at once or not at all.

    The file says which process holds it. The kernel releases the lock of a process that dies, so
    a file that is left behind does no harm on the same machine. Where another machine left it,
    over a shared file system whose locks may not reach that far or in an object store, only a
    person can tell.

    Raises
    ------
    HeldError
        If another process holds it.
    """
    if isinstance(file, Remote):
        with _hold_file(_stand_in(file)):  # against others on this machine
            _create(file)
            try:
                yield
            finally:
                file.unlink(missing_ok=True)
    else:
        file.parent.mkdir(parents=True, exist_ok=True)
        with _hold_file(file):
            yield


def _create(lock: Remote) -> None:
    """Make the object that is the lock, unless another machine has."""
    try:
        lock.write_bytes(_self().encode(), exclusive=True)
    except FileExistsError:
        _refuse_if_elsewhere(lock.read_bytes().decode(errors="replace").strip(), lock)
        lock.write_bytes(_self().encode())  # left behind by a process of this machine


def _stand_in(lock: Remote) -> Path:
    """A file that stands for a lock in an object store on this machine."""
    digest = hashlib.sha256(lock.url.encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"irg-{os.getuid()}-{digest}.lock"


def _self() -> str:
    return f"process {os.getpid()} on {socket.gethostname()}\n"


def _refuse_if_elsewhere(said: str, lock: Path | Remote) -> None:
    if said and not said.endswith(f" on {socket.gethostname()}"):
        raise HeldError(f"{said} (if that has ended, delete {lock})")


@contextmanager
def _hold_file(file: Path) -> Iterator[None]:
    descriptor = _lock(file)
    try:
        _refuse_if_elsewhere(os.read(descriptor, 1000).decode(errors="replace").strip(), file)
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, _self().encode(), 0)
        try:
            yield
        finally:
            file.unlink(missing_ok=True)
    finally:
        os.close(descriptor)


def holder(file: Path | Remote) -> str | None:
    """Tell who holds the lock, or on another machine may hold it; None if nobody does."""
    if isinstance(file, Remote):
        try:
            said = file.read_bytes().decode(errors="replace").strip()
        except OSError:
            return None
        return holder(_stand_in(file)) if said.endswith(f" on {socket.gethostname()}") else said
    try:
        descriptor = os.open(file, os.O_RDONLY)
    except OSError:
        return None
    try:
        said = os.read(descriptor, 1000).decode(errors="replace").strip()
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return said or "another process"
    finally:
        os.close(descriptor)
    return None if not said or said.endswith(f" on {socket.gethostname()}") else said


def _lock(file: Path) -> int:
    while True:
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if file.exists() and os.path.samestat(os.fstat(descriptor), file.stat()):
                return descriptor
        except BlockingIOError:
            holder = os.read(descriptor, 1000).decode(errors="replace").strip()
            os.close(descriptor)
            raise HeldError(holder or "another process") from None
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # removed by its last holder after we had opened it
