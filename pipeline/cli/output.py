"""Output of the command: results on stdout, notes and errors on stderr."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import TABLES, Table, is_table, table_of, writable_path, write_tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.store.progress import FailedPoint
    from pipeline.store.verify import Damage
    from pipeline.sweep.warned import Warned

_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_LONGEST = 2000  # characters of a line
_QUIET = threading.Event()


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


def show(
    options: argparse.Namespace,
    document: dict[str, Any],
    text: Iterable[str],
    *,
    warned: Warned | None = None,
    out: Path | None = None,
    tables: Sequence[Table] = (),
    rows: Iterable[Mapping[str, Any]] = (),
    draw: Callable[[], Figure] | None = None,
) -> None:
    """Show a result, as text or as one JSON document, and write it to a file.

    Parameters
    ----------
    options : Namespace
        Options of the command.
    document : dict
        Result as plain values.
    text : iterable of str
        Result in lines.
    warned : Warned, optional
        Warnings that its points carry.
    out : Path, optional
        File of a figure or of a table.
    tables : sequence of Table
        Result as tables, whose rows are written below each other.
    rows : iterable of mapping
        Result as rows of a table by heading, in place of tables.
    draw : callable, optional
        Draws the result.
    """
    lines = list(text)
    if warned is not None:
        document = document | {"warnings": warned.as_dict()}
        lines += warned.lines()
    if out is not None and (draw is None or is_table(out)):
        write_tables(tables or [table_of(list(rows))], out)
        document = document | {"table": str(out)}
        lines.append(f"table: {out}")
    elif out is not None and draw is not None:
        document = document | {"figure": str(pipeline.save_figure(draw(), out))}
        lines.append(str(out))
    if options.json:
        written = json.dumps(_without_nan(document), indent=2, ensure_ascii=False, allow_nan=False)
        print(_CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", written))
    else:
        show_text(lines)


def show_text(text: Iterable[str]) -> None:
    """Print text as a terminal can show it, at once."""
    print("\n".join(_shown(line) for part in text for line in part.split("\n")), flush=True)


@contextmanager
def hushed(is_quiet: bool) -> Iterator[None]:
    """Show no progress and no notes meanwhile, if the user asked for that."""
    if is_quiet:
        _QUIET.set()
    try:
        yield
    finally:
        _QUIET.clear()


def is_hushed() -> bool:
    """True if the user asked for no progress and no notes."""
    return _QUIET.is_set()


def table_path(options: argparse.Namespace) -> Path | None:
    """Give the path of the table that the user asked for, if any, before the work."""
    return None if options.output is None else writable_path(options.output, TABLES)


def output_path(options: argparse.Namespace) -> Path | None:
    """Give the path of the figure or table that the user asked for, if any, before the work."""
    if options.output is None or is_table(options.output):
        return table_path(options)
    return pipeline.figure_path(options.output)


def tell(message: str) -> None:
    """Print a note: neither a result nor an error."""
    if not is_hushed():
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
