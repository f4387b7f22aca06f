"""Progress of a command: on one line of a terminal, or else in lines on stderr now and then."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from pipeline.cli.output import QUIET, tell
from pipeline.sweep.stages import duration

if TYPE_CHECKING:
    from pipeline.run.tally import Progress

_BETWEEN_LINES = 10.0  # [s], where stderr is no terminal
_BETWEEN_LOOKS = 0.5  # [s], where it is one
_ENDING = 10.0  # [s] that it may take to say the last word
_SOON = 2.0  # [s], before which a command that just works says nothing


class _Line:
    """A line that changes: in place on a terminal, else printed anew every few seconds."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._printed, self._printed_at = "", -math.inf

    def show(self, text: str, done: int = 0, total: int = 0, is_last: bool = False) -> None:
        """Show a text, on a terminal beside a bar if it has a total."""
        if sys.stderr.isatty():
            self._draw(text, done, total)
        elif is_last or time.monotonic() - self._printed_at >= _BETWEEN_LINES:
            if text != self._printed:
                tell(text)
            self._printed, self._printed_at = text, time.monotonic()

    def _draw(self, text: str, done: int, total: int) -> None:
        if self._bar is None:
            from tqdm import tqdm

            form = "{desc} |{bar:20}|" if total else "{desc}"
            self._bar = tqdm(total=total or None, bar_format=form, leave=bool(total))
        self._bar.n, self._bar.total = done, total or None
        self._bar.set_description_str(text, refresh=False)
        self._bar.update(0)

    def close(self) -> None:
        """Leave a bar as it is, or clear the line without one."""
        if self._bar is not None:
            self._bar.close()


@contextmanager
def run_line() -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows a state of the run, and show the last one again at the end."""
    line = _Line()
    latest: list[Progress] = []

    def show(progress: Progress, is_last: bool = False) -> None:
        if not QUIET.is_set():
            latest[:] = [progress]
            line.show(str(progress), progress.done, progress.total, is_last)

    try:
        yield show
    finally:
        for progress in latest[:]:
            show(progress, is_last=True)
        line.close()


@contextmanager
def working(task: str) -> Iterator[Callable[[int, int], None]]:
    """Say that a command still works at a task, such as "reading points", after two seconds.

    Yields a function to call with the number that is done and the number there is, where the
    command counts.
    """
    if QUIET.is_set():
        yield lambda done, total: None
        return
    latest = [0, 0]
    is_over = threading.Event()
    began = time.monotonic()

    def count(done: int, total: int) -> None:
        latest[:] = done, total

    def say() -> None:
        if is_over.wait(_SOON):
            return None
        line = _Line()
        while True:
            line.show(_state_of_task(task, time.monotonic() - began, *latest))
            if is_over.wait(_BETWEEN_LOOKS):
                return line.close()

    thread = threading.Thread(target=say, name="progress", daemon=True)
    thread.start()
    try:
        yield count
    finally:
        is_over.set()
        thread.join(_ENDING)


def _state_of_task(task: str, elapsed: float, done: int, total: int) -> str:
    """State of a task, in words.

    Examples
    --------
    >>> _state_of_task("reading", 12.0, 0, 0)
    'reading, 12 s so far'
    >>> _state_of_task("reading", 12.0, 3, 9)
    'reading: 3 of 9 done, 12 s so far, 24 s to go'
    """
    so_far = f"{duration(elapsed)} so far"
    if not done:
        return f"{task}, {so_far}"
    to_go = duration(elapsed * (total - done) / done)
    return f"{task}: {done} of {total} done, {so_far}, {to_go} to go"
