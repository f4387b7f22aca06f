"""Signals that end a command as Ctrl-C does: SIGTERM, which Slurm and Docker send, and SIGHUP."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

SIGNALS: tuple[int, ...] = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def handle(handler: Callable[[int, FrameType | None], None]) -> dict[int, Any]:
    """Set a handler for SIGINT, SIGTERM and SIGHUP, and return the former handlers by signal.

    Signals that this process ignores, as under ``nohup``, are left out. Outside the main thread
    nothing is set.
    """
    if threading.current_thread() is not threading.main_thread():
        return {}
    former_handlers = dict[int, Any]()
    for number in SIGNALS:
        if (former := signal.getsignal(number)) not in (signal.SIG_IGN, None):
            former_handlers[number] = former
            signal.signal(number, handler)
    return former_handlers


@contextmanager
def keyboard_interrupts() -> Iterator[None]:
    """Context manager: SIGINT, SIGTERM and SIGHUP raise `KeyboardInterrupt`.

    Once SIGTERM or SIGHUP has come, the same signal is ignored until the end of the block. If a
    signal causes another error, such as that of an interrupted import, this error is replaced by
    `KeyboardInterrupt`.
    """
    received: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.append(number)
        if number != signal.SIGINT:  # systemd and terminals send two, one after the other
            signal.signal(number, signal.SIG_IGN)
        raise KeyboardInterrupt

    former_handlers = handle(interrupt)
    try:
        yield
    except Exception as error:
        if received:  # such as the error of a module whose import was interrupted
            raise KeyboardInterrupt from error
        raise
    finally:
        for number, handler in former_handlers.items():
            signal.signal(number, handler)
