"""The lock of a store that several machines see: a file that its holder renews.

It is made by exclusive creation. A killed process leaves it behind; where nobody has renewed it for
some minutes, by the clock of the disk or the object store, the next process takes it.
"""

from __future__ import annotations

import os
import re
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pipeline.store.files import PARTIAL
from pipeline.store.place import LOCK, Place, StoreError

BEAT = 20.0
"""Time between two renewals [s]."""
STALE = 180.0
"""Time after the last renewal from when the lock is free [s]: NFS may show times a minute late."""
SETTLE = 2.0
"""Time [s] in which of two processes that take a lock at once the later one wins."""

_CONTENT = re.compile(r"(process (\d+) on \S+)\n(?:(\S+) [0-9a-f]{32}\n)?")


class Heartbeat:
    """A lock that this process holds as long as its content is in the file of the lock."""

    def __init__(self, place: Place) -> None:
        self._place = place
        self._content = this_process() + f"{_machine()} {uuid.uuid4().hex}\n".encode()

    def is_in_place(self) -> bool:
        """True if the lock is that of this process; raises an `OSError` if it cannot be read."""
        return self._place.read(LOCK) == self._content

    def take(self) -> None:
        """Create the lock, or take one that is free; raise a `StoreError` if there is another."""
        place = self._place
        if place.create(LOCK, self._content):
            return
        if not place.read(LOCK):  # let go of, or just being made
            time.sleep(SETTLE)
        there = place.read(LOCK) or b""
        if there and not _is_dead(there) and (age := _age(place)) < STALE:
            raise in_use(
                str(place),
                name_of(there),
                f"; it was last heard of {max(age, 0):.0f} s ago, and {STALE:.0f} s after the last "
                "sign of it the store is free",
            )
        with suppress(FileNotFoundError):  # another one that takes it was faster
            if (place.read(LOCK) or b"") == there:
                place.put({LOCK: self._content})
        time.sleep(SETTLE)
        if not self.is_in_place():
            raise in_use(str(place), name_of(place.read(LOCK) or b""))

    def renew(self) -> None:
        """Write the lock anew, unless another process has taken it."""
        if self.is_in_place():
            self._place.put({LOCK: self._content})

    def let_go(self) -> None:
        """Remove the lock, unless another process has taken it."""
        with suppress(OSError):  # then it is free after a while
            if self.is_in_place():
                self._place.remove(LOCK)


@contextmanager
def beating(place: Place) -> Iterator[Heartbeat]:
    """Hold the lock of a store by a heartbeat, at once or not at all."""
    heart = Heartbeat(place)
    heart.take()
    try:
        with repeated(heart.renew):
            yield heart
    finally:
        heart.let_go()


@contextmanager
def repeated(action: Callable[[], None]) -> Iterator[None]:
    """Call a function at every beat, in a thread of its own."""
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


def beats(place: Place) -> str | None:
    """Name of the process that holds a store by a heartbeat, by our clock; None if none does."""
    content = place.read(LOCK) or b""
    match = _CONTENT.fullmatch(content.decode(errors="replace"))
    is_of_heart = match and match[3]  # and not of a `flock`
    if not is_of_heart or _is_dead(content) or time.time() - place.written_at(LOCK) >= STALE:
        return None
    return name_of(content)


def in_use(store: str, holder: str, more: str = "") -> StoreError:
    """Error for a store that another process writes to."""
    return StoreError(
        f"{store} is in use by {holder}; wait for it, or write to another store{more}"
    )


def this_process() -> bytes:
    """Line that names this process to people."""
    return f"process {os.getpid()} on {socket.gethostname()}\n".encode()


def name_of(content: bytes) -> str:
    """Process that a lock names, if it names one in full."""
    match = _CONTENT.fullmatch(content.decode(errors="replace"))
    return match[1] if match else "another process"


def _age(place: Place) -> float:
    """Time since the lock was renewed [s], by the clock that its disk or object store has."""
    probe = f"{LOCK}.{uuid.uuid4().hex}{PARTIAL}"
    place.put({probe: b""})
    now = place.written_at(probe)
    place.remove(probe)
    return now - place.written_at(LOCK)


def _machine() -> str:
    """Boot and space of processes, within which the number of a process tells whether it lives."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot}/{Path('/proc/self/ns/pid').stat().st_ino}"
    except OSError:
        return "unknown"


def _is_dead(content: bytes) -> bool:
    """True for the lock of a process of this machine that has ended."""
    match = _CONTENT.fullmatch(content.decode(errors="replace"))
    if not match or match[3] != _machine() or match[3] == "unknown":
        return False
    try:
        os.kill(int(match[2]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:  # another user's
        pass
    return False
