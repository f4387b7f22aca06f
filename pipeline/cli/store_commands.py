"""The commands on a store: status, verify, margin, boundary, plot and report."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections import Counter
from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.answers.answer_frames import (
    answer_frame,
    boundary_frame,
    comparison_frame,
    complete_frame,
    margin_frame,
)
from pipeline.answers.error import preset_error_text
from pipeline.answers.facts import HEAD, NOTES, fact_lines, other_lines, point_lines
from pipeline.answers.scene_wording import named_value, test_group_words
from pipeline.answers.value_text import code_text
from pipeline.answers.verdict_model import UNKNOWN
from pipeline.cli.inputs import (
    conditions_in,
    dataset_in,
    operating_points_in,
    path_beside,
    values_in,
)
from pipeline.cli.output import DONE, SOME_FAILED, Result, run_line, wrapped
from pipeline.frames import frame_of, records, without_columns
from pipeline.messages import pluralized
from pipeline.store.location import REMEDY, StoreError
from pipeline.store.status import summary_and_sweep
from tribo import InputError

_MAX_ROWS = 8  # rows of a printed table of operating points; --all, --json and files have all


def status(options: argparse.Namespace) -> Result:
    """Answer ``irg status``: count the points of a store."""
    state, sweep = summary_and_sweep(options.store)
    failed = [*state.failed, *(state.tests.failed if state.tests else ())]
    counts = f"{state.done} done, {len(state.failed)} failed, {state.pending} pending"
    text = [state.title, f"{state.total} points: {counts}"]
    if state.tests:
        name = test_group_words(sweep)
        text.append(f"{name}: {state.tests.done} of {state.tests.total} points done")
    if state.running:
        text.append(f"running: {state.running}")
    text += [preset_error_text(sweep), *(f"failed: {point}" for point in failed)]
    try:
        text += wrapped(pipeline.points_with_warnings(options.store).lines())
    except StoreError as error:  # points are counted nevertheless
        text.append(f"points with warnings could not be counted: {error}")
    progress = "done" if state.done == state.total else counts
    if state.running:
        progress = f"running now, {progress}"
    numbers = state.total, state.done, len(state.failed), state.pending
    headings = "name", "state", "points", "done", "failed", "pending", "preset", "title"
    frame = frame_of(headings, [(state.name, progress, *numbers, sweep.preset, state.title)])
    return Result(text=text, frames=[frame], code=SOME_FAILED if failed else DONE)


def verify(options: argparse.Namespace) -> Result:
    """Answer ``irg verify``: read all data of a store, and list damaged points."""
    with run_line(2.0) as progress:
        check = pipeline.verify_store(options.store, progress)
    text, rows, document = list[str](), list[tuple[object, ...]](), dict[str, object]()
    for kind, group in (("points", check), ("tests", check.tests)):
        if group is None:
            continue
        document[kind] = {"done": group.done, "damaged": len(group.damaged)}
        text.append(f"{kind}: {group.done} done and undamaged, {len(group.damaged)} damaged")
        text += [f"damaged: {damage}" for damage in (*group.damaged, *group.shared)]
        rows += [
            (point.load, point.velocity, point.location, point.message) for point in group.damaged
        ]
    frame = frame_of(("load [N]", "velocity [m/s]", "place", "message"), rows)
    document |= {"damaged": records([frame]), "shared": [*map(str, check.shared)]}
    if not check.is_clean:
        return Result(document, [*text, REMEDY], [frame], code=SOME_FAILED)
    warnings = wrapped(pipeline.points_with_warnings(options.store).lines())
    return Result(document, [*text, *warnings], [frame])


def margin(options: argparse.Namespace) -> Result:
    """Answer ``irg margin``: judge one operating point, or each row of a table."""
    points = operating_points_in(options)
    ds, conditions = dataset_in(options), conditions_in(options)
    margins = pipeline.margin(ds, points or options.load, options.velocity, **conditions)
    if options.load is not None and (margins["verdict"] == UNKNOWN).all():
        raise InputError(str(margins["reason"].values.flat[0]))
    text = _rows_text(margins, options.all) if options.load is None else _point_text(margins)
    text += pipeline.points_with_warnings(ds).lines()
    return Result(text=wrapped(text), frames=[complete_frame(margins)])


def _point_text(margins: xr.Dataset) -> list[str | pd.DataFrame]:
    """Lines on one point, for each of several conditions."""
    lines = list[str | pd.DataFrame]()
    for index in np.ndindex(*margins.sizes.values()):
        point = margins.isel(dict(zip(margins.sizes, index, strict=True)))
        if index:
            lines.append(f"{', '.join(named_value(point[dim]) for dim in margins.sizes)}:")
        lines += point_lines(point)
    return [*lines, *fact_lines(margins, *NOTES)]


def _rows_text(margins: xr.Dataset, prints_all: bool) -> list[str | pd.DataFrame]:
    """The rows with the least margins, and lines on all of them."""
    counts = Counter(code_text(margins["verdict"]).ravel().tolist())
    count_of_each = ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items()))
    total = pluralized(counts.total(), "operating point", "operating points")
    frame, hint = margin_frame(margins), list[str]()
    if not prints_all:
        if len(frame) > _MAX_ROWS:
            hint = [f"{len(frame) - _MAX_ROWS} more rows: use --all, or -o TABLE.csv"]
        numbers = answer_frame(margins, "temperature_margin")
        frame = frame.loc[numbers.sort_values("temperature margin [K]").index].head(_MAX_ROWS)
    return [f"{total}: {count_of_each}", *_table_text(margins, frame, hint)]


def _table_text(
    answer: xr.Dataset, table: pd.DataFrame, hint: Sequence[str] = (), omitted: Sequence[str] = ()
) -> list[str | pd.DataFrame]:
    """A table of an answer, with a hint on it, and the facts of the answer that are not omitted."""
    facts = other_lines(answer, (*HEAD, *omitted))
    return [*fact_lines(answer, *HEAD), "", table, "", *hint, *facts]


def boundary(options: argparse.Namespace) -> Result:
    """Answer ``irg boundary``: show critical velocities or loads, or compare tests and model."""
    ds, conditions = dataset_in(options), conditions_in(options)
    text: list[str | pd.DataFrame]
    if options.by == "test":
        results = pipeline.compare_tests(ds, **conditions)
        if not results.sizes["test"]:
            raise InputError("the scene has no tests; add [[tests]] to it")
        table = without_columns(comparison_frame(results))
        text = ["tests, each at its own conditions", table, *fact_lines(results, *NOTES)]
        frame = complete_frame(results)
    else:
        results = pipeline.boundary(ds, **conditions)
        text = boundary_text(results, options.by)
        names = [name for name in map(str, results) if results[name].dims[-1:] == (options.by,)]
        frame = complete_frame(results, *names)
    text += pipeline.points_with_warnings(ds).lines()
    return Result(text=wrapped(text), frames=[frame])


def boundary_text(
    boundary: xr.Dataset, by: str = "load", omitted: Sequence[str] = ()
) -> list[str | pd.DataFrame]:
    """The table of a boundary, its rows by load or by velocity, and its facts but those omitted."""
    table = without_columns(boundary_frame(boundary, by))
    return _table_text(boundary, table, omitted=omitted)


def plot(options: argparse.Namespace) -> Result:
    """Answer ``irg plot``: draw a figure of a store, and print its path."""
    figure_options = values_in(options, "load", "velocity", "log", "width", "plain", "dpi")
    ds = dataset_in(options)
    out = options.output or path_beside(options.store, f"_{options.kind or 'diagram'}.png")
    path = pipeline.plot(ds, options.kind, out, **figure_options, **conditions_in(options))
    warnings = wrapped(pipeline.points_with_warnings(ds).lines())
    return Result({"kind": options.kind, "file": str(path)}, [str(path), *warnings])


def report(options: argparse.Namespace) -> Result:
    """Answer ``irg report``: write a page on a store, and print its path."""
    report_options = values_in(options, "load", "velocity", "title", "author")
    report_options["points"] = operating_points_in(options)
    ds, conditions = dataset_in(options), conditions_in(options)
    out = options.output or path_beside(options.store, ".html")
    command = shlex.join(["irg", *sys.argv[1:]])
    path = pipeline.report(ds, out=out, command=command, **report_options, **conditions)
    warnings = wrapped(pipeline.points_with_warnings(ds).lines())
    return Result({"file": str(path)}, [str(path), *warnings])
