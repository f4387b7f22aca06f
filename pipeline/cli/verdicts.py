"""The commands ``irg boundary`` and ``irg margin``, which print answers and compute nothing."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.answers import words
from pipeline.answers.frames import answer_frame, boundary_frame, margin_frame, whole_frame
from pipeline.answers.scene_words import named_value
from pipeline.answers.verdict import UNKNOWN
from pipeline.cli.given import conditions_in, dataset_in, operating_points_in
from pipeline.cli.output import Result, pluralized, working, wrapped
from pipeline.frames import some_rows, without_columns
from tribo import InputError

_MOST_ROWS = 8  # rows of a table printed; --all, --json and files have all


def margin(options: argparse.Namespace) -> Result:
    """Answer ``irg margin``: judge one operating point, or each row of a table."""
    points = operating_points_in(options)
    ds, conditions = dataset_in(options), conditions_in(options)
    with working("evaluating operating points"):
        found = pipeline.margin(ds, points or options.load, options.velocity, **conditions)
    if options.load is None:
        text = _rows_text(found, options.all)
    elif (found["verdict"] == UNKNOWN).all():
        raise InputError(str(found["reason"].values.flat[0]))
    else:
        text = _point_text(found)
    warned = pipeline.points_with_warnings(ds)
    return Result(text=wrapped(text), warned=warned, frames=[whole_frame(found)])


def _point_text(found: xr.Dataset) -> list[str | pd.DataFrame]:
    """Lines on one point, under each of several conditions."""
    lines, sizes = list[str | pd.DataFrame](), found.sizes
    for place in np.ndindex(*sizes.values()):
        here = found.isel(dict(zip(sizes, place, strict=True)))
        own = [named_value(here[dim]) for dim in sizes]
        lines += [f"{', '.join(own)}:"] * bool(own)
        lines += words.margin_lines(here)
    return [*lines, *words.common_lines(found)]


def _rows_text(found: xr.Dataset, has_all: bool) -> list[str | pd.DataFrame]:
    """The rows with the least margins, and lines on all of them."""
    verdicts, counts = np.unique(words.code_text(found["verdict"]).astype(str), return_counts=True)
    said = ", ".join(f"{n} {verdict}" for verdict, n in zip(verdicts, counts, strict=True))
    count = pluralized(int(counts.sum()), "operating point", "operating points")
    frame = margin_frame(found)
    worst = frame if has_all else frame.sort_values("temperature margin [K]").head(_MOST_ROWS)
    more = len(frame) - len(worst)
    return [
        f"{count}: {said}",
        *words.conditions_lines(found),
        *words.not_included_lines(found),
        "",
        worst,
        "",
        *[f"{more} more rows: use --all, or -o TABLE.csv"] * bool(more),
        *words.reason_lines(found),
        *words.row_warnings(found),
        words.model_error_line(found),
        *words.common_lines(found),
    ]


def boundary(options: argparse.Namespace) -> Result:
    """Answer ``irg boundary``: show critical velocities or loads, or compare tests and model."""
    ds, conditions = dataset_in(options), conditions_in(options)
    warned = pipeline.points_with_warnings(ds)
    if options.by == "test":
        found = pipeline.compare_tests(ds, **conditions)
        if not found.sizes["test"]:
            raise InputError("the scene has no tests; add [[tests]] to it")
        table = without_columns(answer_frame(found))
        text: list[Any] = ["tests, each at its own conditions", table, *words.common_lines(found)]
        return Result(text=wrapped(text), warned=warned, frames=[whole_frame(found)])
    with working("computing the boundary"):
        found = pipeline.boundary(ds, **conditions)
    shown = without_columns(boundary_frame(found, options.by))
    few = shown if options.all else some_rows(shown, _MOST_ROWS)
    more = [f"{len(shown) - len(few)} more rows: use --all, or -o TABLE.csv"]
    text = [
        *words.conditions_lines(found), "", few, "", *more * (len(few) < len(shown)),
        *words.boundary_lines(found),
    ]  # fmt: skip
    parts = [name for name in map(str, found) if found[name].dims[-1:] == (options.by,)]
    return Result(text=wrapped(text), warned=warned, frames=[whole_frame(found, *parts)])
