"""Output of the command: results on stdout; notes, errors and progress on stderr.

Progress stands on one line of a terminal, or else in lines now and then.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.sweep.stages import Progress, Report, duration

if TYPE_CHECKING:
    import pandas as pd

    from pipeline.analysis.warned_points import Warned
    from pipeline.store.progress import FailedPoint

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""
QUIET = threading.Event()
"""Set if the user asked for no progress and no notes."""
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_LONGEST = 2000  # characters of a line


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a command: a document, its text as sentences and frames, and the output of -o."""

    document: dict[str, Any]
    text: Iterable[str | pd.DataFrame]
    warned: Warned | None = None  # what its points warn of
    frames: Sequence[pd.DataFrame] = ()
    draw: Callable[[], Any] | None = None
    out: Path | None = None  # file of the figure where the user names none
    code: int = DONE


def show(options: argparse.Namespace, result: Result) -> None:
    """Print a result, as text or as one JSON document, and write its frames or its figure."""
    document, text = dict(result.document), [*result.text]
    if result.warned is not None:
        document["warnings"] = result.warned.as_dict()
        text += result.warned.lines()
    if (result.frames or result.draw) and (out := options.output or result.out):
        from pipeline.analysis.tables import TABLES, write_frames  # pandas takes its time

        if result.draw is None or out.suffix.lower() in TABLES:
            document["table"] = str(write_frames(result.frames, out))
            text.append(f"table: {out}")
        else:
            from pipeline.figures.style import save_figure  # Matplotlib takes its time

            document["figure"] = str(save_figure(result.draw(), out))
            text.append(str(out))
    if options.json:
        written = json.dumps(_jsonable(document), indent=2, ensure_ascii=False, allow_nan=False)
        print(_CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", written))
    elif text:
        show_text(text)


def show_text(text: Iterable[str | pd.DataFrame]) -> None:
    """Print text as a terminal can show it, at once, the frames in it as aligned columns."""
    lines = list[str]()
    for part in text:
        if isinstance(part, str):
            lines.append(part)
        else:
            from pipeline.analysis.tables import lines_of  # with pandas

            lines += lines_of(part)
    print("\n".join(map(_shown, "\n".join(lines).split("\n"))), flush=True)


def counted(number: int, one: str, several: str) -> str:
    """Number of something, in words."""
    return f"{number} {one if number == 1 else several}"


def failed_points(points: Iterable[FailedPoint]) -> list[dict[str, Any]]:
    """Points for a JSON document, each with its surface, sample or entries among its fields."""
    return [point | dict(point.pop("variant")) for point in map(asdict, points)]


def tell(*messages: str | Progress) -> None:
    """Print notes, or a stage that begins: neither results nor errors."""
    for message in messages if not QUIET.is_set() else ():
        complain(str(message))


def complain(message: str) -> None:
    """Print an error, beside a progress line if there is one."""
    lines = "\n".join(map(_shown, f"irg: {message}".split("\n")))
    if "tqdm" not in sys.modules:  # nor is there memory to import it where that is the error
        print(lines, file=sys.stderr)
        return
    from tqdm import tqdm

    tqdm.write(lines, file=sys.stderr)


def _shown(line: str) -> str:
    """A line for a terminal: without control characters, and not longer than allowed."""
    line = line if len(line) <= _LONGEST else f"{line[:_LONGEST]} …"
    return _CONTROLS.sub(lambda match: f"\\x{ord(match[0]):02x}", line)


def _jsonable(value: Any) -> Any:
    """A document with null in place of NaN, which JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _jsonable(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_jsonable(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


_BETWEEN_LINES = 10.0  # [s], where stderr is no terminal
_BETWEEN_LOOKS = 0.5  # [s], where it is one
_ENDING = 10.0  # [s] that it may take to say the last word
_SOON = 2.0  # [s], before which a command that just works says nothing


@contextmanager
def _terminal() -> Iterator[Report]:
    """Yield what shows progress in place, beside a bar if there is a total."""
    bar: Any = None
    with ExitStack() as stack:

        def show(progress: Progress) -> None:
            nonlocal bar
            if bar is None:
                from tqdm import tqdm

                total = progress.total or None
                form = "{desc} |{bar:20}|" if total else "{desc}"
                bar = stack.enter_context(tqdm(total=total, bar_format=form, leave=bool(total)))
            bar.n, bar.total = progress.done, progress.total or None
            bar.set_description_str(str(progress), refresh=False)
            bar.update(0)

        yield show


@contextmanager
def _log(tells_last: bool) -> Iterator[Report]:
    """Yield what shows progress every few seconds, and at last if so asked."""
    latest, printed, printed_at = "", "", -math.inf

    def show(progress: Progress) -> None:
        nonlocal latest, printed, printed_at
        latest = str(progress)
        if latest != printed and time.monotonic() - printed_at >= _BETWEEN_LINES:
            tell(latest)
            printed, printed_at = latest, time.monotonic()

    try:
        yield show
    finally:
        if tells_last and latest != printed:
            tell(latest)


def _line(tells_last: bool = False) -> AbstractContextManager[Report]:
    in_place = sys.stderr.isatty() and not QUIET.is_set()
    return _terminal() if in_place else _log(tells_last)


@contextmanager
def run_line() -> Iterator[Report]:
    """Yield what shows the progress of a run."""
    with _line(tells_last=True) as show:
        yield lambda progress: (tell if progress.words else show)(progress)


@contextmanager
def working(task: str) -> Iterator[Report]:
    """Say after two seconds that a task goes on; yield what takes its progress."""
    latest, began, is_over = Progress(), time.monotonic(), threading.Event()

    def note(progress: Progress) -> None:
        nonlocal latest
        latest = progress

    def say() -> None:
        pause = _SOON
        with _line() as show:
            while not is_over.wait(pause):
                show(Progress(_words_on(task, time.monotonic() - began, latest)))
                pause = _BETWEEN_LOOKS

    thread = threading.Thread(target=say, name="progress", daemon=True)
    thread.start()
    try:
        yield note
    finally:
        is_over.set()
        thread.join(_ENDING)


def _words_on(task: str, elapsed: float, progress: Progress) -> str:
    """State of a task, in words."""
    if not progress.done:
        return f"{task}, {duration(elapsed)} so far"
    to_go = elapsed * (progress.total - progress.done) / progress.done
    return f"{task}: {replace(progress, elapsed=elapsed, time_to_go=to_go)}"
