"""What the command shows: results on stdout, progress and messages on stderr."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import pipeline

if TYPE_CHECKING:
    from pipeline.run.sweep import Progress
    from pipeline.store.progress import FailedPoint
    from pipeline.store.verify import Damage

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""

_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_LONGEST = 2000  # characters of a line
_YEAR = 365.25 * 24 * 3600  # [s]


class ProgressLine:
    """The state of a run on one line of stderr, from the first report on."""

    def __init__(self) -> None:
        self._bar: Any = None

    def __enter__(self) -> Callable[[Progress], None]:
        return self._show

    def _show(self, progress: Progress) -> None:
        if self._bar is None:
            from tqdm import tqdm

            self._bar = tqdm(
                total=progress.total,
                mininterval=0.1 if sys.stderr.isatty() else 10.0,
                bar_format="{n_fmt} of {total_fmt} points done{postfix} |{bar:20}|",
                postfix="",
            )
        self._bar.total = progress.total
        self._bar.n = progress.done
        parts = [f"{progress.failed} failed", f"{duration(progress.elapsed)} so far"]
        if progress.time_to_go is not None:
            parts.append(f"{duration(progress.time_to_go)} to go")
        self._bar.set_postfix_str(", ".join(parts), refresh=False)
        self._bar.update(0)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.refresh()
            self._bar.close()


def duration(seconds: float) -> str:
    """Write a duration in the unit that suits it."""
    if not seconds < 100 * _YEAR:
        return "more than 100 years"
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"


def counted(number: int, one: str, several: str) -> str:
    """Write how many there are of something.

    Examples
    --------
    >>> counted(1, "load", "loads"), counted(4, "load", "loads")
    ('1 load', '4 loads')
    """
    return f"{number} {one if number == 1 else several}"


def micrometres(length: float) -> str:
    """Write a length [m] in micrometres."""
    return pipeline.display(length, "µm", 4)


def failed_points(points: Iterable[FailedPoint | Damage]) -> list[dict[str, Any]]:
    """Points for a JSON document, each with its surface only in a sweep over several."""
    return [
        {name: value for name, value in asdict(point).items() if value is not None}
        for point in points
    ]


def show(options: argparse.Namespace, document: dict[str, Any], text: Iterable[str]) -> None:
    """Print a result as text, or as one JSON document if the user asked for that."""
    if options.json:
        written = json.dumps(_without_nan(document), indent=2, ensure_ascii=False, allow_nan=False)
        print(_CONTROLS.sub(lambda found: f"\\u{ord(found[0]):04x}", written))
    else:
        print("\n".join(_shown(line) for part in text for line in part.split("\n")))


def tell(message: str) -> None:
    """Print a message that is not a result."""
    from tqdm import tqdm

    lines = "\n".join(map(_shown, f"irg: {message}".split("\n")))
    tqdm.write(lines, file=sys.stderr)  # beside a progress line, if there is one


def _shown(line: str) -> str:
    """A line as a terminal can show it: without control characters, and of some length at most."""
    line = line if len(line) <= _LONGEST else f"{line[:_LONGEST]} …"
    return _CONTROLS.sub(lambda found: f"\\x{ord(found[0]):02x}", line)


def _without_nan(value: Any) -> Any:
    """The same with null where a number is missing, which JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _without_nan(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
