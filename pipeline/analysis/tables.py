"""Tables as files: CSV for other programs, Markdown for a report."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tribo import InputError

TABLES = (".csv", ".md")
"""Endings of the files that a table may be written to."""


def writable_path(out: str | Path, suffixes: Sequence[str]) -> Path:
    """Give the path of a file to be written, before the work that it is to hold.

    Raises
    ------
    InputError
        If its suffix is none of those that are known, or it cannot be written.
    """
    path = Path(out)
    if path.suffix.lower() not in suffixes:
        known = suffixes[0] if len(suffixes) == 1 else f"one of {', '.join(suffixes)}"
        raise InputError(f"cannot write {out}: the suffix must be {known}")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {out}: there is no folder {path.parent}")
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise InputError(f"cannot write {out}: it is a folder, or in one that is not to be written")
    return path


def is_table(out: str | Path | None) -> bool:
    """Whether a file is to hold a table, by its suffix."""
    return out is not None and Path(out).suffix.lower() in TABLES


def write_table(rows: Iterable[Mapping[str, Any]], out: Path) -> Path:
    """Write rows to a file, their keys as its header; nothing where a number is missing.

    Parameters
    ----------
    rows : iterable of mapping
        Values by column; a column that a row lacks stays empty there.
    out : Path
        File to write, .csv or .md.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> out = Path(tempfile.mkdtemp()) / "table.md"
    >>> print(write_table([{"load [N]": 400.0, "velocity [m/s]": 2.2}], out).read_text(), end="")
    | load [N] | velocity [m/s] |
    |---|---|
    | 400 | 2.2 |
    """
    rows = list(rows)
    heads = list(dict.fromkeys(key for row in rows for key in row))
    cells = [[_written(row.get(head)) for head in heads] for row in rows]
    if out.suffix.lower() == ".md":
        lines = [heads, ["---"] * len(heads), *cells]
        text = "".join(
            f"|{'|'.join(line)}|\n" if line[0] == "---" else f"| {' | '.join(line)} |\n"
            for line in lines
        )
    else:
        file = io.StringIO()
        csv.writer(file, lineterminator="\n").writerows([heads, *cells])
        text = file.getvalue()
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror or error}") from error
    return out


def _written(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
