"""The lock of a store: one driver writes at a time, whatever path it used for the store.

On a disk of this machine it is a `flock`, which the kernel releases when its process dies. On disks
that other machines see, and in an object store, it is a heartbeat: a file that its holder renews.
A killed process leaves that behind; the next one takes it after some minutes without a renewal.
"""

from __future__ import annotations

import errno
import os
import re
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import psutil

from pipeline.store.files import PARTIAL, make_folder
from pipeline.store.place import LOCK, Folder, StoreError, StorePlace, writes

try:
    import fcntl
except ImportError:  # not a POSIX system: stores can be read, but not written
    fcntl = None  # type: ignore[assignment]

BEAT = 20.0
"""Time between two renewals [s]."""
STALE = 180.0
"""Time after the last renewal from when the lock is free [s]: NFS may show times a minute late."""
SETTLE = 2.0
"""Time [s] in which of two processes that take a lock at once the later one wins."""

_CONTENT = re.compile(r"(process (\d+) on \S+)\n(?:(\S+) [0-9a-f]{32}\n)?")
# A pipe in place of the file must not wait for a reader, nor a link lead to a file of others.
_AS_IT_IS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0)
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
_LOCAL = {"tmpfs", "ramfs", "overlay", "zfs", "bcachefs"}
"""File systems without a block device, whose files no other machine writes."""
_TRIES, _PAUSE = 10, 0.05  # [s]: who asks for the holder has the lock for a moment


Lock = Callable[[], bool]
"""Tells whether a lock that this process took is still in its place."""


@contextmanager
def held(place: StorePlace) -> Iterator[Lock]:
    """Hold the lock of a store at once; raise a `StoreError` if another process does."""
    if fcntl is None:
        raise StoreError(
            "this system has no file locks, which irg run needs; run it on Linux or macOS, or "
            "within WSL on Windows (commands that only read a store work here)"
        )
    with ExitStack() as stack:
        with writes(place):
            lock: Lock | None = None
            if isinstance(place, Folder):
                file = place.path / LOCK
                make_folder(file.parent)
                if os.path.lexists(file) and (file.is_symlink() or not file.is_file()):
                    raise OSError(f"{file} is not a file; move it elsewhere")
                if is_local(place.path):
                    lock = stack.enter_context(_flocked(place, file))
            lock = lock or stack.enter_context(_beating(place))
        yield lock


@contextmanager
def _flocked(folder: Folder, file: Path) -> Iterator[Lock | None]:
    """Hold a `flock`; None if the disk has none."""
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | _AS_IT_IS, 0o666)

    def is_in_place() -> bool:
        try:
            return os.path.samestat(os.fstat(descriptor), file.stat())
        except OSError:  # also on a file server that no longer knows the folder
            return False

    try:
        if not _is_flocked(folder, descriptor):
            yield None
            return
        # Another machine to which this disk is a server's goes by the heartbeat.
        if content := _beats(folder):
            raise _use_error(folder, content)
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, _this_process(), 0)
        try:
            with _repeated(lambda: os.utime(descriptor)):
                yield is_in_place
        finally:
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


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
    raise _use_error(folder, os.pread(descriptor, 1000, 0))


@contextmanager
def _beating(place: StorePlace) -> Iterator[Lock]:
    """Hold the lock of a store by a heartbeat, at once or not at all."""
    content = _this_process() + f"{_machine()} {uuid.uuid4().hex}\n".encode()

    def is_ours() -> bool:
        return place.read(LOCK) == content

    def renew() -> None:
        if is_ours():  # and no other process has taken it
            place.put({LOCK: content})

    _take(place, content)
    try:
        with _repeated(renew):
            yield is_ours
    finally:
        with suppress(OSError):  # then it is free after a while
            if is_ours():
                place.remove(LOCK)


def _take(place: StorePlace, content: bytes) -> None:
    """Create a lock, or take a free one; raise a `StoreError` if it is held."""
    if place.create(LOCK, content):
        return
    if not place.read(LOCK):  # let go of, or just being made
        time.sleep(SETTLE)
    there = place.read(LOCK) or b""
    if there and not _is_dead(there) and (age := _age(place)) < STALE:
        raise _use_error(
            place,
            there,
            f"; it was last heard of {max(age, 0):.0f} s ago, and {STALE:.0f} s after the last "
            "sign of it the store is free",
        )
    with suppress(FileNotFoundError):  # another one that takes it was faster
        if (place.read(LOCK) or b"") == there:
            place.put({LOCK: content})
    time.sleep(SETTLE)
    if (there := place.read(LOCK) or b"") != content:
        raise _use_error(place, there)


@contextmanager
def _repeated(action: Callable[[], None]) -> Iterator[None]:
    """Call a function at every beat, in a separate thread."""
    is_over = threading.Event()

    def repeat() -> None:
        while not is_over.wait(BEAT):
            with suppress(OSError):  # the next time may go well
                action()

    thread = threading.Thread(target=repeat, name="heartbeat", daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def holder_of(place: StorePlace) -> str | None:
    """Name the process that writes to a store; None if there is none."""
    if fcntl is None:
        return None
    with suppress(OSError):
        if content := _beats(place):
            return _named(content)[0]
        if isinstance(place, Folder) and _is_locked(place.path / LOCK):
            return _named(place.read(LOCK))[0]
    return None


def _is_locked(file: Path) -> bool:
    try:
        with open(file, "rb", opener=lambda path, mode: os.open(path, mode | _AS_IT_IS)) as stream:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    return False


def _beats(place: StorePlace) -> bytes | None:
    """Content of the lock of a process that holds a store by a heartbeat, by our clock, if any."""
    content = place.read(LOCK) or b""
    is_of_heart = _named(content)[2]  # and not of a `flock`
    if not is_of_heart or _is_dead(content) or time.time() - place.written_at(LOCK) >= STALE:
        return None
    return content


def _use_error(place: StorePlace, content: bytes | None, more: str = "") -> StoreError:
    """Error for a store that another process writes to, from the content of its lock."""
    return StoreError(
        f"{place} is in use by {_named(content)[0]}; wait for it, or write to another store{more}"
    )


def _this_process() -> bytes:
    """Line that names this process to people."""
    return f"process {os.getpid()} on {socket.gethostname()}\n".encode()


def _named(content: bytes | None) -> tuple[str, str | None, str | None]:
    """Process that a lock names in full, its number, and of a heartbeat its machine."""
    match = _CONTENT.fullmatch((content or b"").decode(errors="replace"))
    return (match[1], match[2], match[3]) if match else ("another process", None, None)


def _machine() -> str:
    """Boot and space of processes, within which the number of a process tells whether it lives."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot}/{Path('/proc/self/ns/pid').stat().st_ino}"
    except OSError:
        return "unknown"


def _is_dead(content: bytes) -> bool:
    """True for the lock of a process of this machine that has ended."""
    _, number, machine = _named(content)
    if number is None or machine != _machine() or machine == "unknown":
        return False
    return not psutil.pid_exists(int(number))


def _age(place: StorePlace) -> float:
    """Time since the lock was renewed [s], by the clock that its disk or object store has."""
    probe = f"{LOCK}.{uuid.uuid4().hex}{PARTIAL}"
    place.put({probe: b""})
    now = place.written_at(probe)
    place.remove(probe)
    return now - place.written_at(LOCK)


def is_local(folder: Path) -> bool:
    """True for a folder on a disk of this machine, where a `flock` reaches all who write to it."""
    mounts = psutil.disk_partitions(all=True)
    above = [mount for mount in mounts if folder.is_relative_to(mount.mountpoint)]
    if not above:
        return True
    # Of those at the same place the last one lies on top.
    here = max(reversed(above), key=lambda mount: len(Path(mount.mountpoint).parts)).fstype
    return here in _LOCAL or here in {disk.fstype for disk in psutil.disk_partitions()}
