"""Locks on parts of a store, each for the moment in which points are put into a shared chunk.

They are bytes of one file beside the store, locked as POSIX has it: the kernel releases them when
their process dies, and a forked process does not have them. Whoever finds the file unused removes
it.
"""

from __future__ import annotations

import os
import threading
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # not a POSIX system: stores can be read, but not written
    fcntl = None  # type: ignore[assignment]

PATIENCE = 60.0
"""Time to wait for a part, which others hold for some milliseconds [s]."""

_ALL = (0, 0)  # a range of bytes that has no end
_SHORTEST, _LONGEST = 5e-4, 0.05  # pauses between attempts [s]
# Within a process there are no such locks; nor may the file be closed while another thread has one.
_one_in_a_process = threading.Lock()


class StuckError(Exception):
    """Another process has held the lock for longer than anybody should."""


@contextmanager
def hold_part(file: Path, part: tuple[int, ...] | None = None) -> Iterator[None]:
    """Hold the lock of a part, or of all parts.

    Parameters
    ----------
    file : Path
        File that is locked, and made if need be.
    part : tuple of int, optional
        Numbers of the part; all parts if not given.

    Raises
    ------
    StuckError
        If another process holds it for too long.
    OSError
        If there are no locks here, or the file cannot be made.
    """
    if fcntl is None:
        raise OSError("this system has no locks on files")
    end = time.monotonic() + PATIENCE
    alone = _one_in_a_process
    if not alone.acquire(timeout=PATIENCE):
        raise StuckError("another thread of this process")
    try:
        byte = _ALL if part is None else (1, zlib.crc32(repr(part).encode()))
        descriptor = _locked(file, byte, end)
        try:
            yield
        finally:
            _remove(file, descriptor)
            os.close(descriptor)
    finally:
        alone.release()


def has_locks(file: Path) -> bool:
    """Whether files can be locked at this place."""
    try:
        with hold_part(file):
            return True
    except StuckError:
        return True
    except OSError:
        return False


def remove_unused(file: Path) -> None:
    """Remove the file that a process left behind that was killed, unless somebody uses it."""
    if file.exists():
        with suppress(OSError, StuckError), hold_part(file, ()):
            pass


def _locked(file: Path, byte: tuple[int, int], end: float) -> int:
    """Open the file, and lock a range of it, given by its length and its start."""
    pause = _SHORTEST
    while time.monotonic() < end:
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, *byte)
            with suppress(FileNotFoundError):  # its last user has removed it meanwhile
                if os.path.samestat(os.fstat(descriptor), file.stat()):
                    return descriptor
        except (BlockingIOError, PermissionError):  # as POSIX leaves open which
            time.sleep(pause)
            pause = min(2 * pause, _LONGEST)
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)
    raise StuckError("another process")


def _remove(file: Path, descriptor: int) -> None:
    """Remove the file, unless another process has locked a part of it."""
    with suppress(OSError):
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB, *_ALL)
        file.unlink()


def _forget() -> None:
    global _one_in_a_process
    _one_in_a_process = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
