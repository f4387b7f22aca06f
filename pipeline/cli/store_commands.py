"""The commands on a store: status, verify, margin, boundary, plot and report."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import Any, cast

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
from pipeline.answers.answer_lines import (
    boundary_lines,
    common_lines,
    conditions_lines,
    margin_lines,
    model_error_line,
    not_included_lines,
    reason_lines,
    row_warnings,
)
from pipeline.answers.error import preset_error_text
from pipeline.answers.readable import code_text
from pipeline.answers.results import sweep_of
from pipeline.answers.scene_wording import named_value
from pipeline.answers.verdict_model import UNKNOWN
from pipeline.cli.inputs import (
    conditions_in,
    dataset_in,
    operating_points_in,
    path_beside,
    values_in,
)
from pipeline.cli.output import DONE, SOME_FAILED, Result, working, wrapped
from pipeline.frames import frame_of, records, some_rows, without_columns
from pipeline.messages import pluralized, quoted
from pipeline.shipped import typed_name
from pipeline.store.location import REMEDY, StoreError
from pipeline.store.resume import mismatches
from pipeline.store.root import GOAL_PREFIX
from pipeline.store.schema import PLANE
from pipeline.store.status import summary_and_sweep
from tribo import InputError, TriboError
from tribo.types import Mask

_MAX_ROWS = 8  # rows of a printed table, and those of tests; --all, --json and files have all


def status(options: argparse.Namespace) -> Result:
    """Answer ``irg status``: count the points of a store."""
    state, sweep = summary_and_sweep(options.store)
    failed = [*state.failed, *(state.tests.failed if state.tests else ())]
    counts = f"{state.done} done, {len(state.failed)} failed, {state.pending} pending"
    text = [state.title, f"{state.total} points: {counts}"]
    if state.tests:
        text.append(f"tests: {state.tests.done} of {state.tests.total} points done")
    if state.running:
        text.append(f"running: {state.running}")
    text += [preset_error_text(sweep), *(f"failed: {point}" for point in failed)]
    warned_points = None
    try:
        warned_points = pipeline.points_with_warnings(options.store)
    except StoreError as error:  # points are counted nevertheless
        text.append(f"points with warnings could not be counted: {error}")
    progress = "done" if state.done == state.total else counts
    if state.running:
        progress = f"running now, {progress}"
    numbers = state.total, state.done, len(state.failed), state.pending
    headings = "name", "state", "points", "done", "failed", "pending", "preset", "title"
    frame = frame_of(headings, [(state.name, progress, *numbers, sweep.preset, state.title)])
    return Result(
        text=text, warned_points=warned_points, frames=[frame], code=SOME_FAILED if failed else DONE
    )


def verify(options: argparse.Namespace) -> Result:
    """Answer ``irg verify``: read all data of a store, and list damaged points."""
    with working("reading points") as progress:
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
    if check.is_clean:
        return Result(document, text, pipeline.points_with_warnings(options.store), [frame])
    return Result(document, [*text, REMEDY], frames=[frame], code=SOME_FAILED)


def margin(options: argparse.Namespace) -> Result:
    """Answer ``irg margin``: judge one operating point, or each row of a table."""
    points = operating_points_in(options)
    ds, conditions = dataset_in(options), conditions_in(options)
    with working("evaluating operating points"):
        margins = pipeline.margin(ds, points or options.load, options.velocity, **conditions)
    if options.load is None:
        text = _rows_text(margins, options.all)
    elif (margins["verdict"] == UNKNOWN).all():
        reason = str(margins["reason"].values.flat[0])
        command = _extending_command(ds, options)
        raise InputError(f"{reason}: {command}" if command else reason)
    else:
        text = _point_text(margins)
    warned_points = pipeline.points_with_warnings(ds)
    return Result(text=wrapped(text), warned_points=warned_points, frames=[complete_frame(margins)])


def _extending_command(ds: xr.Dataset, options: argparse.Namespace) -> str:
    """Command that simulates a point outside a sweep; empty if none would do so."""
    from pipeline.scene.contact_estimate import require_admissible_load  # other answers do without

    sweep, settings = sweep_of(ds), dict[str, Any]()
    if not {*PLANE} <= {*ds["status"].dims}:
        return ""
    for path, unit, value, simulated in (
        ("sweep.loads", "N", options.load, sweep.loads),
        ("sweep.velocities", "m/s", options.velocity, sweep.velocities),
    ):
        if not simulated[0] <= value <= simulated[-1]:
            settings[path] = [f"{value:.10g} {unit}"]
    name = typed_name(sweep.name)
    try:
        scene = pipeline.load_scene(name)
        extended = pipeline.load_scene(name, cast(Any, sweep.preset), settings)
        require_admissible_load(extended, options.load, "--load")
    except TriboError:  # the scene is elsewhere, or does not allow these values
        return ""
    if not settings or any(mismatches(sweep, extended)):
        return ""
    is_usual = Path(options.store).absolute() == Path("results", f"{sweep.name}.zarr").absolute()
    history = str(ds.attrs.get("history", "")).splitlines()
    goals = [line.removeprefix(GOAL_PREFIX) for line in history if line.startswith(GOAL_PREFIX)]
    arguments = list[str]() if is_usual else ["-o", str(options.store)]
    if goals:
        arguments += ["--accuracy", goals[-1]]
    elif sweep.preset and sweep.preset != scene.preset:
        arguments += ["--preset", sweep.preset]
    for path, values in settings.items():
        arguments += ["--set", f"{path}={quoted(values)}"]
    return shlex.join(["irg", "run", name, *arguments])


def _point_text(margins: xr.Dataset) -> list[str | pd.DataFrame]:
    """Lines on one point, for each of several conditions."""
    lines = list[str | pd.DataFrame]()
    for index in np.ndindex(*margins.sizes.values()):
        point = margins.isel(dict(zip(margins.sizes, index, strict=True)))
        if index:
            lines.append(f"{', '.join(named_value(point[dim]) for dim in margins.sizes)}:")
        lines += margin_lines(point)
    return [*lines, *common_lines(margins)]


def _rows_text(margins: xr.Dataset, prints_all: bool) -> list[str | pd.DataFrame]:
    """The rows with the least margins, and lines on all of them."""
    verdicts, counts = np.unique(code_text(margins["verdict"]).astype(str), return_counts=True)
    count_of_each = ", ".join(
        f"{count} {verdict}" for verdict, count in zip(verdicts, counts, strict=True)
    )
    total = pluralized(int(counts.sum()), "operating point", "operating points")
    frame = margin_frame(margins)
    numbers = answer_frame(margins, "temperature_margin")
    order = numbers.sort_values("temperature margin [K]").index
    printed = frame if prints_all else frame.loc[order].head(_MAX_ROWS)
    omitted = len(frame) - len(printed)
    hint = [f"{omitted} more rows: use --all, or -o TABLE.csv"] if omitted else []
    return [
        f"{total}: {count_of_each}",
        *conditions_lines(margins),
        *not_included_lines(margins),
        "",
        printed,
        "",
        *hint,
        *reason_lines(margins),
        *row_warnings(margins),
        model_error_line(margins),
        *common_lines(margins),
    ]


def boundary(options: argparse.Namespace) -> Result:
    """Answer ``irg boundary``: show critical velocities or loads, or compare tests and model."""
    ds, conditions = dataset_in(options), conditions_in(options)
    warned_points = pipeline.points_with_warnings(ds)
    if options.by == "test":
        results = pipeline.compare_tests(ds, **conditions)
        if not results.sizes["test"]:
            raise InputError("the scene has no tests; add [[tests]] to it")
        table = without_columns(comparison_frame(results))
        text: list[Any] = ["tests, each at its own conditions", table, *common_lines(results)]
        return Result(
            text=wrapped(text), warned_points=warned_points, frames=[complete_frame(results)]
        )
    with working("computing the boundary"):
        results = pipeline.boundary(ds, **conditions)
    rows = without_columns(boundary_frame(results, options.by))
    printed = rows if options.all else some_rows(rows, _MAX_ROWS, _are_tested(ds, rows, options.by))
    omitted = len(rows) - len(printed)
    hint = [f"{omitted} more rows: use --all, or -o TABLE.csv"] if omitted else []
    text = [*conditions_lines(results), "", printed, "", *hint, *boundary_lines(results)]
    names = [name for name in map(str, results) if results[name].dims[-1:] == (options.by,)]
    return Result(
        text=wrapped(text), warned_points=warned_points, frames=[complete_frame(results, *names)]
    )


def _are_tested(ds: xr.Dataset, rows: pd.DataFrame, by: str) -> Mask:
    """Mask of the rows of a boundary that are at the load, or at the velocity, of a test."""
    tests = () if ds.attrs.get("without_tests") else sweep_of(ds).tests
    if by == "load":
        return np.isin(rows["load [N]"], [test.normal_load for test in tests])
    return np.isin(rows["velocity [m/s]"], [test.velocity for test in tests])


def plot(options: argparse.Namespace) -> Result:
    """Answer ``irg plot``: draw a figure of a store, and print its path."""
    names = "load", "velocity", "realization", "log", "step", "width", "plain", "title", "dpi"
    figure_options = values_in(options, *names)
    ds = dataset_in(options)
    out = options.output or path_beside(options.store, f"_{options.kind or 'diagram'}.png")
    path = pipeline.plot(ds, options.kind, out, **figure_options, **conditions_in(options))
    document = {"kind": options.kind, "file": str(path)}
    return Result(document, [str(path)], pipeline.points_with_warnings(ds))


def report(options: argparse.Namespace) -> Result:
    """Answer ``irg report``: write a page on a store, and print its path."""
    report_options = values_in(options, "load", "velocity", "title", "author")
    report_options["points"] = operating_points_in(options)
    ds, conditions = dataset_in(options), conditions_in(options)
    out = options.output or path_beside(options.store, ".html")
    command = shlex.join(["irg", *sys.argv[1:]])
    with working("writing the report"):
        path = pipeline.report(ds, out=out, command=command, **report_options, **conditions)
    return Result({"file": str(path)}, [str(path)], pipeline.points_with_warnings(ds))
