"""The commands ``irg surface`` and ``irg tests``."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

import pipeline
from pipeline.analysis.tables import frame_of
from pipeline.cli.given import table_choices_in
from pipeline.cli.output import WRONG_USE, Result, counted, working
from pipeline.laboratory.exports import Export
from pipeline.laboratory.instruments import RawScan
from pipeline.laboratory.logs import Log, log_of
from pipeline.laboratory.profile import data_sheet_toml, profile_statistics, profiles_in
from pipeline.laboratory.reading import OF_TRACE, Read, is_one_run, is_trace, read_table
from pipeline.laboratory.records import read_trace
from pipeline.laboratory.spoken import toml_of
from pipeline.laboratory.staged import staged_runs
from pipeline.laboratory.surfaces import read_raw
from pipeline.laboratory.trace import Trace
from pipeline.quantities import UNITS, shown_in
from pipeline.scene.choices import Choices
from pipeline.scene.document import as_toml
from pipeline.scene.doubts import doubts_of_row
from pipeline.scene.format_of_tests import StagedRunTable, Test
from pipeline.scene.sheet import Sheet
from pipeline.scene.units import in_si
from pipeline.sweep.remarks import remarks
from tribo import InputError

_USUAL_PIXEL = 0.95e-6  # [m], of the shipped scenes
_STAGE = (
    "start [s]", "duration [s]", "load [N]", "velocity [m/s]", "friction begin", "friction steady",
    "friction highest", "friction end", "temperature [degC]",
)  # fmt: skip
"""Columns of a table of stages."""


def surface(options: argparse.Namespace) -> Result:
    """Answer ``irg surface``: roughness of a scan, and entries of a scene for surfaces like it."""
    if (options.ra is None) != (options.rsm is None) or (options.ra is None) == (not options.scan):
        raise InputError('give a SCAN, or --ra and --rsm of a data sheet, like --ra "0.2 um"')
    if options.scan is None:
        return _data_sheet_result(options)
    raw = read_raw(options.scan)
    if raw.places is not None:
        if options.transpose:
            raise InputError(f"{options.scan} is no map, which --transpose is for; leave it out")
        return _profile_result(options, raw)
    for name in ("length_unit", "cutoff", "lay"):
        if getattr(options, name) is not None:
            option = f"--{name.replace('_', '-')}"
            raise InputError(f"{options.scan} is a map, and {option} is for profiles; leave it out")
    with working("fitting the spectrum"):
        scan = pipeline.surface_statistics(
            options.scan, options.height_unit, options.pixel_size, options.transpose
        )
    return Result(scan.as_dict(), [*scan.lines()])


def _profile_result(options: argparse.Namespace, raw: RawScan) -> Result:
    """Result of ``irg surface`` for profiles."""
    named = ("height_unit", options.height_unit), ("length_unit", options.length_unit)
    height, length = (unit and in_si(name, f"1 {unit}", "1 um") for name, unit in named)
    step = options.pixel_size[0] if options.pixel_size else None
    places, heights = profiles_in(options.scan, raw, (height, length), step)
    try:
        found = profile_statistics(str(options.scan), places, heights, options.cutoff, options.lay)
    except InputError as error:
        raise InputError(f"{options.scan}: {error}") from error
    return Result(found.as_dict(), [*found.lines()])


def _data_sheet_result(options: argparse.Namespace) -> Result:
    """Result of ``irg surface`` for Ra and RSm of a data sheet."""
    pixel = min(options.pixel_size) if options.pixel_size else _USUAL_PIXEL
    with working("seeking the correlation length"):
        toml, assumed = data_sheet_toml(options.ra, options.rsm, pixel)
    document = {"ra": options.ra, "rsm": options.rsm, "assumed": assumed, "toml": toml}
    return Result(document, [*assumed, "", *toml.splitlines()])


def tests(options: argparse.Namespace) -> Result:
    """Answer ``irg tests``: how a log or a trace was read, and its tests as lines of a scene file.

    A trace is a record of friction over time.
    """
    path = Path(options.log)
    choices = Choices(**table_choices_in(options))
    read = read_table(path, choices, options.form, OF_TRACE)
    if is_one_run(read.sheet) or (is_trace(read.sheet) and "outcome" not in read.sheet.places):
        return _trace_result(path, read, options)
    for name in ("output", "outcome", "scuffed_at"):
        if getattr(options, name):
            option = "-o" if name == "output" else f"--{name.replace('_', '-')}"
            raise InputError(
                f"{path} is no record of friction over time, which {option} needs; leave it out"
            )
    log = log_of(read_table(path, choices, options.form), dict(options.word))
    return _log_result(path, log, options)


def _log_result(path: Path, log: Log, options: argparse.Namespace) -> Result:
    """Result of ``irg tests`` for a log file: columns, tests, faults, lines for a scene file."""
    found, faults = log.tests, log.sheet.faults
    if log.row_class is Test and not faults:  # faulty rows have no test
        first = dict[str, str]()
        for row, test in zip(log.sheet.rows, log.in_si, strict=True):
            run, oil = test["run"], str(test["oil"])
            if run is not None and first.setdefault(str(run), oil) != oil:
                problem = f"{run} has two oils; give each oil its own run"
                faults.append(f"{path.name}, row {row.number}, run: {problem}")
    runs = staged_runs(log) if found and not faults else []
    toml = [*_log_toml(log, path, options)] if found and not (faults or runs) else []
    toml += [line for run in runs for line in ("[[tested]]", *_entries(run), "")][:-1]
    doubts = [*_unit_doubts(log.in_si)] if log.row_class is not StagedRunTable else []
    document = {
        "file": str(path), **_describe(log.sheet, log.export), "words": log.words, "tests": found,
        "faults": faults, "toml": "\n".join(toml), "doubts": doubts,
    }  # fmt: skip
    text: list[str | pd.DataFrame] = [*_file_lines(path, log.sheet, log.export)]
    text += [*_column_frames(log.sheet, log.words), ""]
    if toml:
        counted_runs = counted(len(runs), "run", "runs") + " by stages, each with its past"
        of_log = f"{_count_tests(found)}; to paste into a scene beside the log:"
        text += [f"{counted_runs}; to paste into a scene:" if runs else of_log, "", *toml, ""]
        text += remarks("warning", *doubts)
    if faults:
        text += [f"{counted(len(faults), 'fault', 'faults')}:", *(f"  {one}" for one in faults)]
    return Result(document, text, code=WRONG_USE if faults else 0)


def _trace_result(path: Path, read: Read, options: argparse.Namespace) -> Result:
    """Result of ``irg tests`` for a trace: stages, largest rises, figure, lines of a scene file."""
    trace = read_trace(read)
    stages, rises = [*_stage_rows(trace)], trace.rises
    is_told = options.outcome or options.scuffed_at
    toml = [*toml_of(trace, read.missing, options.scuffed_at)] if is_told else []
    times = [float(trace.time[one.row]) for one in rises]
    document = {
        "file": str(path), **_describe(read.sheet, read.export),
        "stages": [dict(zip(_STAGE, row, strict=True)) for row in stages],
        "rises": [
            {"time [s]": time, "from": one.low, "to": one.high}
            for time, one in zip(times, rises, strict=True)
        ],
        "toml": "\n".join(toml),
    }  # fmt: skip
    text: list[str | pd.DataFrame] = [*_file_lines(path, read.sheet, read.export)]
    text += [f"a trace of friction, {len(trace.time)} rows in motion", ""]
    shown = [[number, *map(_shown, row)] for number, row in enumerate(stages, 1)]
    text += [frame_of(("stage", *_STAGE), shown), "", *_rise_lines(trace)]
    if toml:
        text += ["", *toml]
    else:
        time = f"{(times or trace.time)[0 if times else -1]:.4g} s"
        text += [
            "say what happened, by the picture (-o trace.png) and the worn surface:",
            "  --outcome mild",
            f'  --scuffed-at "{time}"',
        ]
    draw = None
    if options.output:
        from pipeline.laboratory.picture import draw_trace  # Matplotlib is slow to import

        draw = partial(draw_trace, trace, path.name)
    return Result(document, text, draw=draw)


def _stage_rows(trace: Trace) -> Iterator[tuple[Any, ...]]:
    """Yield the values of each stage, in the order of `_STAGE`; both ends of a ramp as a list."""
    for stage in trace.stages:
        time = trace.time[stage.rows]
        levels = [[*one] if isinstance(one, tuple) else one for one in (stage.load, stage.velocity)]
        warm = trace.temperature_of(stage.rows)
        yield (
            float(time[0]), trace.duration_of(stage), *levels, *trace.friction_of(stage),
            None if warm is None else shown_in(warm, "°C"),
        )  # fmt: skip


def _shown(value: Any) -> str | None:
    """Value of a stage with four digits; both ends of a ramp as "500 to 600"."""
    if isinstance(value, list):
        return " to ".join(f"{one:.4g}" for one in value)
    return None if value is None else f"{value:.4g}"


def _rise_lines(trace: Trace) -> Iterator[str]:
    """Yield a line on each of the largest lasting rises of friction, with its time and place."""
    for one in trace.rises:
        time = float(trace.time[one.row])
        place = [
            f"{command.values[one.row]:.4g} {UNITS[name]}"
            for name, command in trace.commands.items()
        ]
        number = trace.stage_at(time)
        is_within = one.row in range(*trace.stages[number].rows.indices(len(trace.time)))
        where = f"in stage {number + 1}" if is_within else "beside the stages"
        yield (
            f"friction rises from {one.low:.3g} to {one.high:.3g} at {time:.4g} s, {where}"
            f"{', at ' * bool(place)}{' and '.join(place)}"
        )
    if not trace.rises:
        yield "no rise of friction by a tenth or more"


def _file_lines(path: Path, sheet: Sheet, export: Export) -> Iterator[str]:
    """Yield lines on a file: its format, rows left out, and how to copy a scene for its rig."""
    form = [f"form of {export.title}"] if export.title else []
    yield f"{path}: {', '.join([*form, *sheet.form])}"
    if sheet.counted:
        yield sheet.counted
    if export.scene:
        yield f"a scene of such a rig: irg new rig.toml --from {export.scene}"
    yield ""


def _describe(sheet: Sheet, export: Export) -> dict[str, Any]:
    """How a file was read, as plain data: format, columns, rows left out, scene for its rig."""
    return {
        "form": [export.title, *sheet.form] if export.title else sheet.form,
        "columns": {name: sheet.headings[k].text for name, k in sheet.places.items()},
        "unused": sheet.unused, "left_out": sheet.left_out, "scene": export.scene or None,
    }  # fmt: skip


def _count_tests(found: Sequence[Mapping[str, Any]]) -> str:
    """Count the tests `found`, and their runs, oils and outcomes, in words."""
    kinds = Counter(test["outcome"] for test in found if "outcome" in test)
    counts = ", ".join(f"{count} {name}" for name, count in sorted(kinds.items()))
    number = counted(len(found), "test", "tests")
    if any("run" in test for test in found):
        runs = {test.get("run", k) for k, test in enumerate(found, -len(found))}
        number += f" of {counted(len(runs), 'run', 'runs')}"
    if len(oils := {test.get("oil") for test in found}) > 1:
        number += f", {len(oils)} oils, of which a scene takes one (--where)"
    return f"{number}: {counts}".removesuffix(": ")


def _unit_doubts(in_si: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Yield warnings on tests whose values (SI, by name) are probably in another unit."""
    for row in in_si:
        for doubt in doubts_of_row(row):
            yield f"the test of {row['load']:g} N at {row['velocity']:g} m/s: {doubt}"


def _column_frames(sheet: Sheet, words: Mapping[str, str]) -> Iterator[pd.DataFrame]:
    """Yield a table with a row for each column of the file: heading, quantity, first cell."""
    names = {place: name for name, place in sheet.places.items()}
    rows = []
    for place, heading in enumerate(sheet.headings):
        first = next((row.cells[place] for row in sheet.rows if row.cells[place]), "")
        name = names.get(place) or ("for another" if place in sheet.sources else None)
        unit = heading.unit if name else ""
        first = f"{first}, {words[first]}" if name == "outcome" and first in words else first
        rows.append((heading.text, name or "not used", f"{first} {unit}".strip()))
    yield frame_of(("column", "read as", "first cell"), rows)


def _log_toml(log: Log, path: Path, options: argparse.Namespace) -> Iterator[str]:
    """Yield lines for a scene file that name a log file, with the options needed to read it."""
    yield f"[[{log.key}]]"
    choices = table_choices_in(options)
    choices["columns"] = log.renamed | choices["columns"]
    told = {name: value for name, value in choices.items() if value}
    file = {"path": path.name, **told} if told else path.name
    entries = {"file": file, "words": log.words, "form": options.form}
    yield from _entries({name: value for name, value in entries.items() if value})


def _entries(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table in a scene file."""
    return (f"{name} = {as_toml(value)}" for name, value in table.items())
