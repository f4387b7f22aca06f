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
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pipeline.progress import Progress, Report

if TYPE_CHECKING:
    import pandas as pd

    from pipeline.answers.simulated_points import WarnedPoints

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""
QUIET = threading.Event()
"""Set by --quiet: no progress and no notes are printed."""
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_MAX_LINE_LENGTH = 2000  # most characters of a line
_WRAPPED_LENGTH = 100  # most characters of a line of wrapped text


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a command: data frames, a JSON document, and text to print."""

    document: dict[str, Any] | None = None  # for --json; None: the frames are the document
    text: Iterable[str | pd.DataFrame] = ()
    warned: WarnedPoints | None = None  # warnings of its points
    frames: Sequence[pd.DataFrame] = ()
    draw: Callable[[], Any] | None = None
    code: int = DONE


def show(options: argparse.Namespace, result: Result) -> None:
    """Print a result as text or as one JSON document, and write its table or figure to a file.

    With --json, and without a `Result.document`, sentences are printed as notes on stderr.
    """
    text = [*result.text, *wrapped(result.warned.lines() if result.warned else ())]
    out = getattr(options, "output", None)
    if out and (result.frames or result.draw):
        from pipeline.frames import TABLES, write_frames  # pandas is slow to import

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
        _WRAPPED_LENGTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
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
    line = line if len(line) <= _MAX_LINE_LENGTH else f"{line[:_MAX_LINE_LENGTH]} …"
    return _CONTROLS.sub(lambda match: f"\\x{ord(match[0]):02x}", line)


_LINE_INTERVAL = 10.0  # time between lines of progress if stderr is no terminal [s]
_REPORT_DELAY = 2.0  # time before a slow command reports that it is working [s]


@contextmanager
def run_line(quiet_time: float = 0.0) -> Iterator[Report]:
    """Context manager: yield a function that shows progress, as a bar on a terminal, else as lines.

    A message (`Progress.words`) is printed at once. Counts are not shown for the first `quiet_time`
    seconds.
    """
    shows_from = time.monotonic() + quiet_time
    has_bar = sys.stderr.isatty() and not QUIET.is_set()
    bar: Any = None
    latest, printed, printed_at = "", "", -math.inf
    with ExitStack() as stack:

        def show(progress: Progress) -> None:
            nonlocal bar, latest, printed, printed_at
            if progress.words:
                print_note(progress)
            elif not progress.total or time.monotonic() < shows_from:
                return
            elif has_bar:
                if bar is None:
                    from tqdm import tqdm

                    bar = stack.enter_context(tqdm(bar_format="{desc} |{bar:20}|"))
                bar.n, bar.total = progress.done, progress.total
                bar.set_description_str(str(progress))
            else:
                latest = str(progress)
                if time.monotonic() - printed_at >= _LINE_INTERVAL:
                    print_note(latest)
                    printed, printed_at = latest, time.monotonic()

        yield show
        if latest != printed:
            print_note(latest)


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
