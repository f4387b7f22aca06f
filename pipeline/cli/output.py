"""What the command shows: results on stdout, progress and messages on stderr."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

import pipeline

if TYPE_CHECKING:
    from pipeline.run.sweep import Progress
    from pipeline.store.progress import FailedPoint
    from pipeline.store.verify import Damage

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""


class ProgressLine:
    """The state of a run on one line of stderr, from the first report on."""

    def __init__(self) -> None:
        self._bar: Any = None

    def __enter__(self) -> Callable[[Progress], None]:
        return self._show

    def _show(self, progress: Progress) -> None:
        if self._bar is None:
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
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 120 else f"{minutes / 60:.1f} h"


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
        print(json.dumps(_without_nan(document), indent=2, ensure_ascii=False, allow_nan=False))
    else:
        print("\n".join(text))


def tell(message: str) -> None:
    """Print a message that is not a result."""
    tqdm.write(f"irg: {message}", file=sys.stderr)  # beside a progress line, if there is one


def _without_nan(value: Any) -> Any:
    """The same with null where a number is missing, which JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _without_nan(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
