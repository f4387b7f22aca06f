"""What the commands ``irg surface`` and ``irg tests`` answer."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

import pipeline
from pipeline.analysis.tables import frame_of
from pipeline.cli.output import WRONG_USE, Result, counted, working
from pipeline.laboratory.logs import Log, Trace, read_log, read_trace
from pipeline.scene.document import as_toml
from pipeline.scene.doubts import doubts_of_row
from pipeline.scene.format import TEST, TRANSITION
from pipeline.scene.headings import numbered
from pipeline.scene.runs import run_faults
from pipeline.sweep.remarks import remarks
from tribo import InputError


def surface(options: argparse.Namespace) -> Result:
    """Print the roughness of a scan, and the table of a scene for random surfaces like it."""
    with working("fitting the spectrum"):
        scan = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.transpose
        )
    text = list(scan.lines())
    if scan.is_self_affine:
        text += ["", "random surfaces like it, in a scene:", "", scan.toml.rstrip()]
    else:
        text.append("no random surface is like it: use the scan itself, as disk.roughness.file")
    return Result(scan.as_dict(), text)


def tests(options: argparse.Namespace) -> Result:
    """Print what is understood of a log or a trace, and the lines of a scene for it."""
    path = Path(options.log)
    columns = dict(options.column)
    if strange := sorted(columns.keys() - TEST.keys.keys()):
        allowed = ", ".join(TEST.keys)
        raise InputError(f'--column: no test has "{strange[0]}"; give one of {allowed}')
    taken = {
        "where": dict(options.where), "given": dict(options.given), "sheet": options.sheet,
        "decimal": options.decimal,
    }  # fmt: skip
    entries = {"columns": columns, "words": dict(options.word), **taken}
    if (trace := read_trace(path, entries)) is not None:
        return _trace_result(path, trace)
    row_of, log = TEST, read_log(path, entries)
    places = log.sheet.places.keys()
    is_told = "outcome" in places or any("columns may be outcome" in one for one in log.faults)
    if not is_told and {"load", "velocity"} <= places:
        row_of, log = TRANSITION, read_log(path, entries, TRANSITION)
        if log.is_only_wear:
            log.faults.append(
                "no column says whether wear was mild or severe, and none that these are "
                'transitions; name the outcome by --column "outcome=HEADING", or call the load '
                '"load of transition [N]" if each row is one'
            )
            log.tests.clear()
    found, faults = log.tests, log.faults
    if row_of is TEST and not faults:  # else rows are left out, and places are not those of tests
        faults += [
            f"{path.name}, row {log.sheet.rows[place].number}, run: {problem}"
            for place, problem in run_faults(log.in_si)
        ]
    toml = list(_toml(log, taken, row_of is TEST)) if found else []
    document = {
        "file": str(path), "form": log.sheet.form,
        "columns": {name: log.sheet.heading(name).text for name in log.sheet.places},
        "unused": log.unused, "words": log.words, "tests": found, "faults": faults,
        "toml": "\n".join(toml), "doubts": [*_doubts(log)],
    }  # fmt: skip
    text = [f"{path}: {', '.join(log.sheet.form)}", "", *_understood(log), ""]
    if found:
        text.append(f"{_count_tests(found)}; to paste into a scene beside the log:")
        if row_of is TRANSITION:
            text.append(
                "(read as transitions, since no column has outcomes; if they are tests, name the "
                'column with --column "outcome=HEADING")'
            )
        text += ["", *toml, ""]
        text += remarks("warning", *_doubts(log))
    if log.twice:
        text.append(f"{numbered(log.twice)} the same as rows before, and not counted")
    if log.left_out:
        rows = counted(len(log.left_out), "row", "rows")
        text.append(f"{rows} without load and velocity left out")
    if faults:
        text += [f"{counted(len(faults), 'fault', 'faults')}:", *(f"  {one}" for one in faults)]
    return Result(document, text, code=WRONG_USE if faults else 0)


def _count_tests(found: Sequence[Mapping[str, Any]]) -> str:
    """Number of tests, of their runs and oils, and of each outcome."""
    outcomes = Counter(test.get("outcome", "of a transition") for test in found)
    counts = ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items()))
    number = counted(len(found), "test", "tests")
    if any("run" in test for test in found):
        runs = {test.get("run", k) for k, test in enumerate(found, -len(found))}
        number += f" of {counted(len(runs), 'run', 'runs')}"
    if len(oils := {test.get("oil") for test in found}) > 1:
        number += f", {len(oils)} oils"
    return f"{number}: {counts}"


def _doubts(log: Log) -> Iterable[str]:
    """Conditions of tests that are probably in another unit."""
    for row in log.in_si:
        for doubt in doubts_of_row(row):
            yield f"the test of {row['load']:g} N at {row['velocity']:g} m/s: {doubt}"


def _trace_result(path: Path, trace: Trace) -> Result:
    """What a trace of friction says."""
    toml = list(trace.toml())
    at = None if trace.row is None else float(trace.time[trace.row])
    document = {"file": str(path), "transition_time": at, "toml": "\n".join(toml)}
    head = f"{path}: a trace of friction, {len(trace.time)} rows"
    return Result(document, [head, *trace.lines(), "", *toml])


def _understood(log: Log) -> Iterable[str | pd.DataFrame]:
    """A row for each column, and a line for the entries that have none."""
    names = {place: name for name, place in log.sheet.places.items()}
    rows = []
    for place, heading in enumerate(log.sheet.headings):
        first = next((row.cells[place] for row in log.sheet.rows if row.cells[place]), "")
        name = names.get(place) or ("for the form" if place in log.sheet.made_of else None)
        unit = heading.unit if name else ""
        if name == "outcome":
            first = f"{first}, {log.words[first]}" if first in log.words else first
        rows.append((heading.text, name or "not used", f"{first} {unit}".strip()))
    yield frame_of(("column", "read as", "first cell"), rows)
    if without := [name for name in TEST.keys if name not in log.sheet.places]:
        needed = [f"{name} (needed)" if name in TEST.needed else name for name in without]
        yield f"without a column: {', '.join(needed)}"


def _toml(log: Log, taken: Mapping[str, Any], is_tests: bool) -> Iterable[str]:
    """Lines of a scene that name the log, and say what is not said by its own words."""
    yield "[[tested]]" if is_tests else "[[measured]]"
    said = {"file": log.path.name, "columns": log.renamed, "words": log.words, **taken}
    yield from (f"{name} = {as_toml(value)}" for name, value in said.items() if value)
