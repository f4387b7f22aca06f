"""The lock of a store: one driver writes at a time, by whatever path it came.

On a disk of this machine it is a `flock` on a file of the store, which the kernel releases when its
process dies. Nothing else decides there; what the file says is for people. On disks that other
machines see, and in an object store, it is a heartbeat.
"""

from __future__ import annotations

import errno
import os
import re
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from pipeline.store.files import make_folder
from pipeline.store.heartbeat import (
    Heartbeat,
    beating,
    beats,
    in_use,
    name_of,
    repeated,
    this_process,
)
from pipeline.store.place import LOCK, Folder, Place, StoreError, writes

try:
    import fcntl
except ImportError:  # not a POSIX system: stores can be read, but not written
    fcntl = None  # type: ignore[assignment]

# A pipe in place of the file must not wait for a reader, nor a link lead to a file of others.
_AS_IT_IS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
_LOCAL = {"tmpfs", "ramfs", "overlay", "zfs", "bcachefs"}
"""File systems without a device of blocks of which no other machine writes the files."""

_TRIES, _PAUSE = 10, 0.05  # [s]: who asks for the holder has the lock for a moment


@dataclass(frozen=True, slots=True)
class FileLock:
    """A `flock` that this process holds: a file and its open descriptor."""

    file: Path
    descriptor: int

    def is_in_place(self) -> bool:
        """True if the file that was locked still lies at its path."""
        try:
            return os.path.samestat(os.fstat(self.descriptor), self.file.stat())
        except OSError:  # also on a file server that no longer knows the folder
            return False

    def touch(self) -> None:
        """Let machines that see this disk from elsewhere know that the lock is held."""
        os.utime(self.descriptor)


Lock = FileLock | Heartbeat
"""A lock that this process holds."""


@contextmanager
def held(place: Place) -> Iterator[Lock]:
    """Hold the lock of a store, at once or not at all.

    Raise a `StoreError` if another process holds it, or the place cannot be written to.
    """
    if fcntl is None:
        raise StoreError(
            "this system has no file locks, which irg run needs; run it on Linux or macOS, or "
            "within WSL on Windows (commands that only read a store work here)"
        )
    with ExitStack() as stack:
        with writes(place):
            lock: Lock | None = None
            if isinstance(place, Folder):
                _require_file(place.path / LOCK)
                if is_local(place.path):
                    lock = stack.enter_context(_flocked(place))
            lock = lock or stack.enter_context(beating(place))
        yield lock


def holder_of(place: Place) -> str | None:
    """Name the process that writes to a store; None if there is none."""
    if fcntl is None:
        return None
    try:
        if name := beats(place):
            return name
        if isinstance(place, Folder) and _is_locked(place.path / LOCK):
            return name_of(place.read(LOCK) or b"")
    except OSError:
        pass
    return None


def _require_file(file: Path) -> None:
    make_folder(file.parent)
    if os.path.lexists(file) and (file.is_symlink() or not file.is_file()):
        raise OSError(f"{file} is not a file; move it elsewhere")


@contextmanager
def _flocked(folder: Folder) -> Iterator[FileLock | None]:
    """Hold a `flock`; None if the disk has none."""
    file, store = folder.path / LOCK, str(folder)
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | _AS_IT_IS, 0o666)
    try:
        if not _has_locks(descriptor, store):
            yield None
            return
        # Another machine to which this disk is a server's goes by the heartbeat.
        if name := beats(folder):
            raise in_use(store, name)
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, this_process(), 0)
        lock = FileLock(file, descriptor)
        try:
            with repeated(lock.touch):
                yield lock
        finally:
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _has_locks(descriptor: int, store: str) -> bool:
    """Lock a file; False if its disk cannot."""
    for left in reversed(range(_TRIES)):
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if not left:
                raise in_use(store, name_of(os.pread(descriptor, 1000, 0))) from None
            time.sleep(_PAUSE)
        except OSError as error:
            if error.errno in _NO_LOCKS:
                return False
            raise
        else:
            return True
    return True


def _is_locked(file: Path) -> bool:
    try:
        with open(file, "rb", opener=lambda path, mode: os.open(path, mode | _AS_IT_IS)) as stream:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    return False


def is_local(folder: Path) -> bool:
    """True for a folder on a disk of this machine, where a `flock` reaches all who write to it.

    Elsewhere, as on NFS, FUSE or the folders of a virtual machine's host, locks may reach one
    machine alone, or nobody. Systems without ``/proc`` are taken for local.

    Examples
    --------
    >>> is_local(Path("/"))
    True
    """
    try:
        mounts, kinds = (
            Path("/proc/self/mounts").read_bytes(),
            Path("/proc/filesystems").read_text(),
        )
    except OSError:
        return True
    kind = filesystem_of(folder, mounts.decode(errors="surrogateescape"))
    return kind in _LOCAL | _of_blocks(kinds)


def filesystem_of(folder: Path, mounts: str) -> str:
    r"""Name of the file system of an absolute path, by the kernel's table of mounts.

    Examples
    --------
    >>> mounts = "/dev/sda / ext4 rw 0 0\nhost:/home /home/my\\040group nfs4 rw 0 0\n"
    >>> [filesystem_of(Path(name), mounts) for name in ("/home/my group/sweep.zarr", "/home/mine")]
    ['nfs4', 'ext4']
    """
    found, length = "", -1
    for line in mounts.splitlines():
        _, point, kind, *_ = line.split(" ")
        point = re.sub(r"\\([0-7]{3})", lambda code: chr(int(code[1], 8)), point)
        above = Path(point)
        if len(above.parts) >= length and folder.is_relative_to(above):  # the last one lies on top
            found, length = kind, len(above.parts)
    return found


def _of_blocks(kinds: str) -> set[str]:
    """File systems on devices of blocks, by the kernel's table."""
    rows = (line.partition("\t") for line in kinds.splitlines())
    return {kind for nodev, _, kind in rows if not nodev}
