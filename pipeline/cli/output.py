"""Output of the command: results on stdout, notes and errors on stderr."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from pipeline.store.progress import FailedPoint
    from pipeline.store.verify import Damage
    from pipeline.sweep.warned import Warned

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""
QUIET = threading.Event()
"""Set if the user asked for no progress and no notes."""
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_LONGEST = 2000  # characters of a line
_TABLES = (".csv", ".md")


@dataclass(frozen=True, slots=True)
class Result:
    """Result of a command: a document, the same as sentences and frames, and what -o writes."""

    document: dict[str, Any]
    text: Iterable[str | pd.DataFrame]
    warned: Warned | None = None  # of its points
    frames: Sequence[pd.DataFrame] = ()
    draw: Callable[[], Figure] | None = None
    out: Path | None = None  # file of the figure where the user names none
    code: int = DONE


def show(options: argparse.Namespace, result: Result) -> None:
    """Print a result, as text or as one JSON document, and write its frames or its figure."""
    document, lines = dict(result.document), [*lines_in(result.text)]
    if result.warned is not None:
        document["warnings"] = result.warned.as_dict()
        lines += result.warned.lines()
    out = result.out
    if result.frames or result.draw:
        out = options.output or out
    if out is not None and (result.draw is None or out.suffix.lower() in _TABLES):
        from pipeline.analysis.tables import write_frames  # pandas takes its time

        document["table"] = str(write_frames(result.frames, out))
        lines.append(f"table: {out}")
    elif out is not None and result.draw is not None:
        from pipeline.figures.style import save_figure  # Matplotlib takes its time

        document["figure"] = str(save_figure(result.draw(), out))
        lines.append(str(out))
    if options.json:
        written = json.dumps(_without_nan(document), indent=2, ensure_ascii=False, allow_nan=False)
        print(_CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", written))
    elif lines:
        show_text(lines)


def lines_in(text: Iterable[str | pd.DataFrame]) -> Iterator[str]:
    """Lines of text, the frames in it as aligned columns."""
    for part in text:
        if isinstance(part, str):
            yield part
        else:
            from pipeline.analysis.tables import lines_of  # with pandas

            yield from lines_of(part)


def show_text(text: Iterable[str]) -> None:
    """Print text as a terminal can show it, at once."""
    print("\n".join(_shown(line) for part in text for line in part.split("\n")), flush=True)


def counted(number: int, one: str, several: str) -> str:
    """Number of something, in words.

    Examples
    --------
    >>> counted(1, "load", "loads"), counted(4, "load", "loads")
    ('1 load', '4 loads')
    """
    return f"{number} {one if number == 1 else several}"


def failed_points(points: Iterable[FailedPoint | Damage]) -> list[dict[str, Any]]:
    """Points for a JSON document, each with its surface only in a sweep over several."""
    return [with_variant(asdict(point)) for point in points]


def with_variant(point: dict[str, Any]) -> dict[str, Any]:
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
    """A line as a terminal can show it: without control characters, and of some length at most."""
    line = line if len(line) <= _LONGEST else f"{line[:_LONGEST]} …"
    return _CONTROLS.sub(lambda match: f"\\x{ord(match[0]):02x}", line)


def _without_nan(value: Any) -> Any:
    """A document with null in place of NaN, which JSON cannot hold."""
    if isinstance(value, dict):
        return {key: _without_nan(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
