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
from pipeline.answers.units import named_value
from pipeline.answers.verdict import UNKNOWN
from pipeline.cli.given import conditions_in, dataset_in, operating_points_in
from pipeline.cli.output import Result, pluralized, working, wrapped
from pipeline.frames import some_rows, without_columns
from pipeline.store.schema import PLANE
from tribo import InputError

_MOST_ROWS = 8  # rows of a table printed; --all, --json and files have all


def margin(options: argparse.Namespace) -> Result:
    """Answer ``irg margin``: judge one operating point, or each row of a table."""
    points, ds, conditions = (
        operating_points_in(options),
        dataset_in(options),
        conditions_in(options),
    )
    is_one, place = False, dict[str, Any](load=points)
    if points is not None and options.points is None:
        is_one = True
        place = dict(zip(PLANE, points.places[0], strict=True))
    with working("evaluating operating points"):
        found = pipeline.margin(ds, **place, **conditions)
    if is_one and (found["verdict"] == UNKNOWN).all():
        raise InputError(str(found["reason"].values.flat[0]))
    text = _margin_text(found, is_one, options.all)
    return Result(
        text=wrapped(text), warned=pipeline.points_with_warnings(ds), frames=[whole_frame(found)]
    )


def _margin_text(found: xr.Dataset, is_one: bool, has_all: bool) -> list[str | pd.DataFrame]:
    lines = list[str | pd.DataFrame]()
    if is_one:
        for here in _each(found):
            own = [named_value(here[dim]) for dim in found.sizes]
            lines += [f"{', '.join(own)}:"] * bool(own)
            lines += words.margin_lines(here)
        return [*lines, *words.common_lines(found)]
    verdicts, counts = np.unique(words.code_text(found["verdict"]).astype(str), return_counts=True)
    said = ", ".join(f"{n} {verdict}" for verdict, n in zip(verdicts, counts, strict=True))
    lines += [f"{pluralized(int(counts.sum()), 'operating point', 'operating points')}: {said}"]
    lines += [*words.conditions_lines(found), *words.not_included_lines(found)]
    frame = margin_frame(found)
    worst = frame if has_all else frame.sort_values("temperature margin [K]").head(_MOST_ROWS)
    lines += ["", worst, ""]
    lines += [f"{len(frame) - len(worst)} more rows: use --all, or -o TABLE.csv"] * (
        len(worst) < len(frame)
    )
    lines += [*words.reason_lines(found), *words.row_warnings(found)]
    lines += [f"model error: {one}" for one in words.attribute_texts(found, "model_error")[:1]]
    return [*lines, *words.common_lines(found)]


def _each(found: xr.Dataset) -> list[xr.Dataset]:
    """The answer at each place."""
    sizes = found.sizes
    return [found.isel(dict(zip(sizes, k, strict=True))) for k in np.ndindex(*sizes.values())]


def boundary(options: argparse.Namespace) -> Result:
    """Answer ``irg boundary``: show critical velocities or loads, or compare tests and model."""
    ds = dataset_in(options)
    if options.by == "test":
        return _tests(ds, options)
    with working("computing the boundary"):
        found = pipeline.boundary(ds, **conditions_in(options))
    parts = [name for name in map(str, found) if found[name].dims[-1:] == (options.by,)]
    shown = without_columns(boundary_frame(found, options.by))
    few = shown if options.all else some_rows(shown, _MOST_ROWS)
    left = len(shown) - len(few)
    rests = [f"{left} more rows: use --all, or -o TABLE.csv"] * bool(left)
    rule = words.conditions_lines(found)
    text = [*wrapped(rule), "", few, "", *wrapped([*rests, *words.boundary_lines(found)])]
    return Result(
        text=text, warned=pipeline.points_with_warnings(ds), frames=[whole_frame(found, *parts)]
    )


def _tests(ds: xr.Dataset, options: argparse.Namespace) -> Result:
    """The tests of a scene, each at its own conditions, beside what is computed there."""
    found = pipeline.compare_tests(ds, **conditions_in(options))
    if not found.sizes["test"]:
        raise InputError("the scene has no tests; add [[tests]] to it")
    table = answer_frame(found)
    lines: list[Any] = ["tests, each at its own conditions", without_columns(table)]
    return Result(
        text=wrapped([*lines, *words.common_lines(found)]),
        warned=pipeline.points_with_warnings(ds),
        frames=[whole_frame(found)],
    )
