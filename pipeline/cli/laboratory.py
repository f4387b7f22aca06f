"""The command on a laboratory's log: what is understood of it, and the lines of a scene for it."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pipeline.cli.output import WRONG_USE, Result, counted
from pipeline.scene.format import TEST, TRANSITION
from pipeline.scene.logs import Log, entries_of_log, read_log
from pipeline.scene.trace import Trace, read_trace
from tribo import InputError


def tests(options: argparse.Namespace) -> Result:
    """Print what is understood of a log or a trace, and the lines of a scene for it."""
    path = Path(options.log)
    trace = read_trace(path)
    if trace is not None:
        return _of_trace(path, trace)
    entries = {
        "columns": dict(options.column),
        "words": dict(options.word),
        "decimal": options.decimal,
    }
    if strange := sorted(set(entries["columns"]) - TEST.keys.keys()):
        allowed = ", ".join(TEST.keys)
        raise InputError(f'--column: no test has "{strange[0]}"; give one of {allowed}')
    log = read_log(path, entries)
    row_of = TEST
    if not {"outcome"} & log.places.keys() and {"load", "velocity"} <= log.places.keys():
        row_of = TRANSITION
        log = read_log(path, entries, row_of)
    found, faults = entries_of_log(log, row_of)
    toml = list(_toml(log, options.decimal, row_of is TEST)) if found else []
    document = {
        "file": str(path), "form": log.form, "columns": _columns(log), "unused": log.unused,
        "words": log.words, "tests": found, "faults": faults, "toml": "\n".join(toml),
    }  # fmt: skip
    text = [f"{path}: {', '.join(log.form)}", "", *_understood(log), ""]
    if found:
        text.append(f"{_counts(found)}; to paste into a scene beside the log:")
        if row_of is TRANSITION:
            text.append(
                "(transitions, since no column is the outcome; of tests name it with "
                '--column "outcome=HEADING")'
            )
        text += ["", *toml, ""]
    if log.left_out:
        rows = counted(len(log.left_out), "row", "rows")
        text.append(f"{rows} without load and velocity left out")
    if faults:
        text += [f"{counted(len(faults), 'fault', 'faults')}:", *(f"  {one}" for one in faults)]
    return Result(document, text, code=WRONG_USE if faults else 0)


def _of_trace(path: Path, trace: Trace) -> Result:
    """What a trace of friction says."""
    toml = list(trace.toml())
    at = None if trace.row is None else float(trace.time[trace.row])
    document = {"file": str(path), "transition_time": at, "toml": "\n".join(toml)}
    head = f"{path}: a trace of friction, {len(trace.time)} rows"
    return Result(document, [head, *trace.lines(), "", *toml])


def _columns(log: Log) -> dict[str, str]:
    """Heading of each entry that was found."""
    return {name: log.heads[place] for name, place in log.places.items()}


def _understood(log: Log) -> Iterable[str]:
    """A line for each column, and one for the entries that have none."""
    names = {place: name for name, place in log.places.items()}
    rows = [("column", "read as", "first cell")]
    for place, head in enumerate(log.heads):
        first = next((row.cells[place] for row in log.rows if row.cells[place]), "")
        name = names.get(place)
        unit = log.heading(name).unit if name else ""
        if name == "outcome":
            first = f"{first}, {log.words[first]}" if first in log.words else first
        rows.append((head, name or "not used", f"{first} {unit}".strip()))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "   ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
    if without := [name for name in TEST.keys if name not in log.places]:
        needed = [f"{name} (needed)" if name in TEST.needed else name for name in without]
        yield f"without a column: {', '.join(needed)}"


def _counts(found: list[dict[str, Any]]) -> str:
    """Number of tests by outcome."""
    outcomes = Counter(test.get("outcome", "transition") for test in found)
    listed = ", ".join(f"{number} {name}" for name, number in sorted(outcomes.items()))
    return f"{counted(len(found), 'test', 'tests')}: {listed}"


def _toml(log: Log, decimal: str | None, is_tests: bool) -> Iterable[str]:
    """Lines of a scene that name the log, and say what is not said by its own words."""
    yield "[[tested]]" if is_tests else "[[measured]]"
    yield f"file = {_quoted(log.path.name)}"
    columns = {name: head for name, head in _columns(log).items() if log.heading(name).name != name}
    if columns:
        pairs = ", ".join(f"{name} = {_quoted(head)}" for name, head in columns.items())
        yield f"columns = {{ {pairs} }}"
    if log.words:
        pairs = ", ".join(f'{_quoted(word)} = "{it}"' for word, it in log.words.items())
        yield f"words = {{ {pairs} }}"
    if decimal:
        yield f'decimal = "{decimal}"'


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
