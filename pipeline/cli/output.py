"""Print results on stdout; notes, errors and progress on stderr."""

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

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""
QUIET = threading.Event()
"""Set by --quiet: no progress and no notes are printed."""
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_CLEAR_LINE = "\r\x1b[K"  # of a terminal


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a command: data frames, a JSON document, and text to print."""

    document: dict[str, Any] | None = None  # for --json; None: the frames are the document
    text: Iterable[str | pd.DataFrame] = ()
    frames: Sequence[pd.DataFrame] = ()
    draw: Callable[[], Any] | None = None
    code: int = DONE


def print_result(options: argparse.Namespace, result: Result) -> None:
    """Print a result as text or as one JSON document, and write its table or figure to a file.

    With --json, and without a `Result.document`, sentences are printed as notes on stderr.
    """
    text = [*result.text]
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
    """Print an error on stderr, in place of a line of progress."""
    lines = "\n".join(map(_printable, f"irg: {message}".split("\n")))
    print(f"{_CLEAR_LINE if sys.stderr.isatty() else ''}{lines}", file=sys.stderr)


def _printable(line: str) -> str:
    """A line with control characters escaped, and cut at 2000 characters."""
    line = line if len(line) <= 2000 else f"{line[:2000]} …"
    return _CONTROLS.sub(lambda match: f"\\x{ord(match[0]):02x}", line)


@contextmanager
def run_line(quiet_time: float = 0.0) -> Iterator[Report]:
    """Context manager: yield a function that shows progress on stderr.

    A message (`Progress.words`) is printed at once. Counts are a changing line on a terminal,
    elsewhere a line every ten seconds. They are not shown for the first `quiet_time` seconds.
    """
    shown_from, printed_at, line = time.monotonic() + quiet_time, -math.inf, ""
    has_terminal = sys.stderr.isatty() and not QUIET.is_set()

    def show(progress: Progress) -> None:
        nonlocal printed_at, line
        if progress.words:
            print_note(progress)
        elif progress.total and time.monotonic() >= shown_from:
            line = str(progress)
            if has_terminal:
                print(f"{_CLEAR_LINE}{line}", end="", file=sys.stderr, flush=True)
            elif time.monotonic() - printed_at >= 10.0:
                print_note(line)
                printed_at, line = time.monotonic(), ""

    try:
        yield show
        if line and not has_terminal:
            print_note(line)
    finally:
        if line and has_terminal:
            print(file=sys.stderr)
