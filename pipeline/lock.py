"""A lock on a file, which ends with the process that holds it."""

from __future__ import annotations

import fcntl
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["HeldError", "hold", "holder"]


class HeldError(Exception):
    """The lock is held by someone else; the message says by whom."""


@contextmanager
def hold(file: Path) -> Iterator[None]:
    """Hold the lock, at once or not at all.

    The file says which process holds it. The kernel releases the lock of a process that dies, so
    a file that is left behind does no harm on the same machine. Where another machine left it,
    over a shared file system whose locks may not reach that far, only a person can tell.

    Raises
    ------
    HeldError
        If another process holds it.
    """
    host = socket.gethostname()
    descriptor = _lock(file)
    try:
        holder = os.read(descriptor, 1000).decode(errors="replace").strip()
        if holder and not holder.endswith(f" on {host}"):
            raise HeldError(f"{holder} (if that has ended, delete {file})")
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"process {os.getpid()} on {host}\n".encode(), 0)
        try:
            yield
        finally:
            file.unlink(missing_ok=True)
    finally:
        os.close(descriptor)


def holder(file: Path) -> str | None:
    """Tell who holds the lock, or on another machine may hold it; None if nobody does."""
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
