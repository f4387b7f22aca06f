"""Print results on stdout; notes, errors and progress on stderr.

Progress is one changing line on a terminal; elsewhere it is a line every ten seconds.
"""

from __future__ import annotations

import argparse
import itertools
import math
import re
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pipeline.paths import TABLES
from pipeline.progress import Progress, Report

if TYPE_CHECKING:
    import pandas as pd

    from pipeline.answers.simulated_points import WarnedPoints

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""
QUIET = threading.Event()
"""Set by --quiet: no progress and no notes are printed."""
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_REPORT_DELAY = 2.0  # time before a slow command reports that it is working [s]


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a command: data frames, a JSON document, and text to print."""

    document: dict[str, Any] | None = None  # for --json; None: the frames are the document
    text: Iterable[str | pd.DataFrame] = ()
    warned_points: WarnedPoints | None = None  # warnings of its points
    frames: Sequence[pd.DataFrame] = ()
    draw: Callable[[], Any] | None = None
    code: int = DONE


def print_result(options: argparse.Namespace, result: Result) -> None:
    """Print a result as text or as one JSON document, and write its table or figure to a file.

    With --json, and without a `Result.document`, sentences are printed as notes on stderr.
    """
    text = [*result.text, *wrapped(result.warned_points.lines() if result.warned_points else ())]
    out = getattr(options, "output", None)
    if out and (result.frames or result.draw):
        from pipeline.frames import write_frames  # pandas is slow to import

        if result.draw is None or out.suffix.lower() in TABLES:
            write_frames(result.frames, out)
        else:
            from pipeline.figures.style import save_figure  # Matplotlib is slow to import

            save_figure(result.draw(), out)
        text.append(f"written: {out}")
    if options.json:
        from pipeline.frames import json_of, records

        document = records(result.frames) if result.document is None else result.document
        print(_CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", json_of(document)))
        if result.document is None:
            print_note(*(line for line in text if isinstance(line, str) and line))
    elif text:
        print("\n".join(map(_printable, "\n".join(_lines(text)).split("\n"))), flush=True)


def _lines(text: Iterable[str | pd.DataFrame]) -> Iterator[str]:
    """Lines of text, and data frames as aligned columns."""
    for paragraph in text:
        if isinstance(paragraph, str):
            yield paragraph
        else:
            from pipeline.frames import lines_of  # pandas is slow to import

            yield from lines_of(paragraph)


def wrapped(text: Iterable[str | pd.DataFrame]) -> list[str | pd.DataFrame]:
    """Text with its lines wrapped at 100 characters, continued lines indented; frames stay."""
    wrap = textwrap.TextWrapper(
        100, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    ).wrap
    paragraphs = ((wrap(item) or [""]) if isinstance(item, str) else [item] for item in text)
    return [*itertools.chain(*paragraphs)]


def print_note(*messages: str | Progress) -> None:
    """Print notes, or the beginning of a stage, on stderr unless --quiet."""
    for message in messages if not QUIET.is_set() else ():
        print_error(str(message))


def print_error(message: str) -> None:
    """Print an error on stderr, on a line below a progress bar."""
    lines = "\n".join(map(_printable, f"irg: {message}".split("\n")))
    if "tqdm" not in sys.modules:  # no progress line; an import could fail for lack of memory
        print(lines, file=sys.stderr)
        return
    from tqdm import tqdm

    tqdm.write(lines, file=sys.stderr)


def _printable(line: str) -> str:
    """A line with control characters escaped, and cut at 2000 characters."""
    line = line if len(line) <= 2000 else f"{line[:2000]} …"
    return _CONTROLS.sub(lambda match: f"\\x{ord(match[0]):02x}", line)


@contextmanager
def run_line(quiet_time: float = 0.0) -> Iterator[Report]:
    """Context manager: yield a function that shows progress, as a bar on a terminal, else as lines.

    A message (`Progress.words`) is printed at once. Counts are not shown for the first `quiet_time`
    seconds.
    """
    progress_line = _ProgressLine(time.monotonic() + quiet_time)
    try:
        yield progress_line.update
        progress_line.print_latest()
    finally:
        progress_line.close()


class _ProgressLine:
    """Progress as a bar on a terminal, else as a line every ten seconds, from a time on."""

    def __init__(self, shows_from: float) -> None:
        self.shows_from = shows_from
        self.has_bar = sys.stderr.isatty() and not QUIET.is_set()
        self.bar: Any = None
        self.latest = self.printed = ""
        self.printed_at = -math.inf

    def update(self, progress: Progress) -> None:
        """Show progress."""
        if progress.words:
            print_note(progress)
        elif not progress.total or time.monotonic() < self.shows_from:
            return
        elif self.has_bar:
            if self.bar is None:
                from tqdm import tqdm

                self.bar = tqdm(bar_format="{desc} |{bar:20}|")
            self.bar.n, self.bar.total = progress.done, progress.total
            self.bar.set_description_str(str(progress))
        else:
            self.latest = str(progress)
            if time.monotonic() - self.printed_at >= 10.0:
                self.print_latest()
                self.printed_at = time.monotonic()

    def print_latest(self) -> None:
        """Print the latest line, unless it was printed."""
        if self.latest != self.printed:
            print_note(self.latest)
            self.printed = self.latest

    def close(self) -> None:
        """Close the bar, if there is one."""
        if self.bar is not None:
            self.bar.close()


@contextmanager
def working(task: str) -> Iterator[Report]:
    """Context manager: print that `task` is running if it takes long; yield a progress function."""
    timer = threading.Timer(_REPORT_DELAY, print_note, [f"{task} …"])
    timer.daemon = True
    timer.start()
    try:
        with run_line(_REPORT_DELAY) as report:
            yield report
    finally:
        timer.cancel()
