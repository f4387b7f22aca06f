"""Progress of a command: on one line of a terminal, or else in lines on stderr now and then."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from pipeline.cli.output import is_hushed, tell
from pipeline.sweep.stages import duration

if TYPE_CHECKING:
    from pipeline.run.tally import Progress

_BETWEEN_LINES = 10.0  # [s], where stderr is no terminal
_BETWEEN_LOOKS = 0.5  # [s], where it is one
_ENDING = 10.0  # [s] that it may take to say the last word
_SOON = 2.0  # [s], before which a command that just works says nothing


class ProgressLine:
    """The state of a run."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._latest: Progress | None = None
        self._told, self._told_at = "", -math.inf

    def __enter__(self) -> Callable[[Progress], None]:
        return self._show

    def _show(self, progress: Progress) -> None:
        if is_hushed():
            return
        self._latest = progress
        if sys.stderr.isatty():
            self._draw(progress)
        elif time.monotonic() - self._told_at >= _BETWEEN_LINES:
            self._tell(progress)

    def _tell(self, progress: Progress) -> None:
        line = f"{progress.done} of {progress.total} points done{_details(progress)}"
        if line != self._told:
            tell(line)
        self._told, self._told_at = line, time.monotonic()

    def _draw(self, progress: Progress) -> None:
        if self._bar is None:
            from tqdm import tqdm

            self._bar = tqdm(
                total=progress.total,
                mininterval=0.1,
                bar_format="{n_fmt} of {total_fmt} points done{postfix} |{bar:20}|",
                postfix="",
            )
        self._bar.total = progress.total
        self._bar.n = progress.done
        self._bar.set_postfix_str(_details(progress).removeprefix(", "), refresh=False)
        self._bar.update(0)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.refresh()
            self._bar.close()
        elif self._latest is not None:
            self._tell(self._latest)


def _details(progress: Progress) -> str:
    parts = [f"{progress.failed} failed", f"{duration(progress.elapsed)} so far"]
    if progress.time_to_go:
        parts.append(f"{duration(progress.time_to_go)} to go")
    if progress.jobs:
        parts.append(str(progress.jobs))
    return "".join(f", {part}" for part in parts)


@contextmanager
def working(what: str) -> Iterator[Callable[[int, int], None]]:
    """Say that a command still works, once that takes longer than two seconds.

    Parameters
    ----------
    what : str
        Work in progress, such as "reading points".

    Yields
    ------
    callable
        Called with how many are done and how many there are, where the command counts.
    """
    latest = 0, 0
    is_over = threading.Event()
    began = time.monotonic()

    def line() -> str:
        return _line(what, time.monotonic() - began, *latest)

    def count(done: int, total: int) -> None:
        nonlocal latest
        latest = done, total

    def tell_lines() -> None:
        if is_over.wait(_SOON):
            return
        tell(line())
        while not is_over.wait(_BETWEEN_LINES):
            tell(line())

    def draw() -> None:
        if is_over.wait(_SOON):
            return
        from tqdm import tqdm

        with tqdm(bar_format="{desc}", desc=line(), leave=False) as bar:
            while not is_over.wait(_BETWEEN_LOOKS):
                bar.set_description_str(line())

    if is_hushed():
        yield count
        return
    say = draw if sys.stderr.isatty() else tell_lines
    thread = threading.Thread(target=say, name="progress", daemon=True)
    thread.start()
    try:
        yield count
    finally:
        is_over.set()
        thread.join(_ENDING)


def _line(what: str, elapsed: float, done: int, total: int) -> str:
    """Say how far it is.

    Examples
    --------
    >>> _line("reading", 12.0, 0, 0), _line("reading", 12.0, 3, 9)
    ('reading, 12 s so far', 'reading: 3 of 9 done, 12 s so far, 24 s to go')
    """
    so_far = f"{duration(elapsed)} so far"
    if not done:
        return f"{what}, {so_far}"
    to_go = duration(elapsed * (total - done) / done)
    return f"{what}: {done} of {total} done, {so_far}, {to_go} to go"
