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
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.sweep.stages import Count, duration

if TYPE_CHECKING:
    import pandas as pd

    from pipeline.analysis.warned_points import Warned
    from pipeline.run.tally import Progress
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


def rounded(value: float, digits: int = 2) -> str:
    """A number in so many digits, without a power of ten where it has fewer before the point."""
    return f"{float(f'{value:.{digits}g}'):g}"


def counted(number: int, one: str, several: str) -> str:
    """Number of something, in words."""
    return f"{number} {one if number == 1 else several}"


def failed_points(points: Iterable[FailedPoint]) -> list[dict[str, Any]]:
    """Points for a JSON document, each with its surface only in a sweep over several."""
    return [point_fields(asdict(point)) for point in points]


def point_fields(point: dict[str, Any]) -> dict[str, Any]:
    """Fields of a point with its surface, sample or entries among them."""
    return point | dict(point.pop("variant"))


def tell(message: str) -> None:
    """Print a note: neither a result nor an error."""
    if not QUIET.is_set():
        complain(message)


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
def _line(tells_last: bool = False) -> Iterator[Callable[..., None]]:
    """Yield a function that shows a text, in place on a terminal, else every few seconds.

    On a terminal it stands beside a bar if there is a total; if quiet, nothing is shown.
    """
    bar: Any = None
    latest, printed, printed_at = "", "", -math.inf

    def show(text: str, done: int = 0, total: int = 0) -> None:
        nonlocal bar, latest, printed, printed_at
        latest = text
        if QUIET.is_set():
            return
        if sys.stderr.isatty():
            if bar is None:
                from tqdm import tqdm

                form = "{desc} |{bar:20}|" if total else "{desc}"
                bar = tqdm(total=total or None, bar_format=form, leave=bool(total))
            bar.n, bar.total = done, total or None
            bar.set_description_str(text, refresh=False)
            bar.update(0)
        elif text != printed and time.monotonic() - printed_at >= _BETWEEN_LINES:
            tell(text)
            printed, printed_at = text, time.monotonic()

    try:
        yield show
    finally:
        if bar is not None:
            bar.close()
        elif tells_last and latest != printed:
            tell(latest)


@contextmanager
def run_line() -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows a state of the run."""
    with _line(tells_last=True) as line:
        yield lambda progress: line(str(progress), progress.done, progress.total)


@contextmanager
def working(task: str) -> Iterator[Count]:
    """Say after two seconds that a task goes on; yield a function that takes done and total."""
    latest, began, is_over = [0, 0], time.monotonic(), threading.Event()

    def count(done: int, total: int) -> None:
        latest[:] = done, total

    def say() -> None:
        pause = _SOON
        with _line() as line:
            while not is_over.wait(pause):
                line(state_of_task(task, time.monotonic() - began, *latest))
                pause = _BETWEEN_LOOKS

    thread = threading.Thread(target=say, name="progress", daemon=True)
    thread.start()
    try:
        yield count
    finally:
        is_over.set()
        thread.join(_ENDING)


def state_of_task(task: str, elapsed: float, done: int, total: int) -> str:
    """State of a task, in words."""
    so_far = f"{duration(elapsed)} so far"
    if not done:
        return f"{task}, {so_far}"
    to_go = duration(elapsed * (total - done) / done)
    return f"{task}: {done} of {total} done, {so_far}, {to_go} to go"
