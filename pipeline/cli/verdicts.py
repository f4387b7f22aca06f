"""The commands ``irg boundary`` and ``irg margin``."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Sequence
from dataclasses import astuple

import pandas as pd

import pipeline
from pipeline.analysis import words
from pipeline.analysis.boundary import ERRORS, JUDGED, boundary_frame
from pipeline.analysis.caveats import caveats_of
from pipeline.analysis.condition_words import judged_by
from pipeline.analysis.dataset import Layout, require_kind
from pipeline.analysis.judge import judge_of
from pipeline.analysis.margin_frame import LONG, Asked, asked_of, counts_in_words, margin_frame
from pipeline.analysis.results import Results
from pipeline.analysis.scenes import words as entries_in_words
from pipeline.analysis.tables import frame_of, lines_of, notes_of, short, some_rows
from pipeline.analysis.tested import test_parts, tests_frame
from pipeline.analysis.warned_points import MELTS, MOLTEN
from pipeline.cli.given import dataset_in, operating_points_in, values_in
from pipeline.cli.output import Result, counted, working, wrapped
from pipeline.words import remarks
from tribo import InputError

_MOST_ROWS = 8  # rows of a table printed; --all, --json and files have all
_MOST_LINES = 14  # lines of the answer on a table of operating points


def margin(options: argparse.Namespace) -> Result:
    """Answer ``irg margin``: judge one operating point, or each row of a table."""
    is_one = bool(values_in(options, "load", "velocity"))
    points = operating_points_in(options)
    data = pipeline.results(dataset_in(options))
    with working("judging operating points"):
        found = [*asked_of(data, points)]
    table, caveats = margin_frame(data, found, points), caveats_of(data)
    lines = place_lines(data, found) if is_one else []
    if not is_one:
        count = counted(len(table), "operating point", "operating points")
        known = [one.margin for one in found if one.margin]
        lines += [f"{count}: {counts_in_words(table, points)}"]
        lines += words.condition_lines(one.conditions for one in known)
        rests = notes_of(table, caveats)
        rests += [words.model_error_line(one.model_error for one in known)] if known else []
        if points and not options.all:
            lines, caveats = _few_lines(lines, table, [*rests, *caveats])
        else:
            lines += ["", short(words.in_words(table), LONG), "", *rests]
    frames = [table.join(_details(found))]
    lines += words.case_lines(data)
    lines += words.missing_lines(data.missing)
    return Result(text=wrapped([*lines, *caveats]), warned=pipeline.warned(data), frames=frames)


def _details(found: Sequence[Asked]) -> pd.DataFrame:
    """Numbers behind each verdict that a terminal has no room for; for --json and files."""
    rows = [
        (one.margin.lowest, one.margin.highest, *astuple(one.margin.error), one.margin.model_error)
        if one.margin
        else (None,) * 7
        for one in found
    ]
    return frame_of(_DETAILS, rows)


_DETAILS = (
    "lowest probability", "highest probability", "error by interpolation [K]",
    "error by the preset [K]", "error by warned points [K]", "error by the surface [K]",
    "model error",
)  # fmt: skip


def _few_lines(
    lines: Sequence[str | pd.DataFrame], table: pd.DataFrame, rests: Sequence[str]
) -> tuple[list[str | pd.DataFrame], list[str]]:
    """Lines with at most 8 rows of a table, the worst first, and as many `rests` as fit in 14."""
    above, below = wrapped(lines), [one for one in wrapped(rests) if isinstance(one, str)]
    order = table["distance [K]"].astype(float).sort_values().index
    worst = short(words.in_words(table), LONG).loc[order]
    room = _MOST_LINES - len(above)
    few, most = worst.head(_MOST_ROWS), len(worst)
    while len(lines_of(few)) + (len(few) < most or bool(below)) > room and len(few) > 1:
        few = few.head(len(few) - 1)
    room -= len(lines_of(few))
    hidden = [f"{most - len(few)} more rows"] * (len(few) < most)
    if hidden or len(below) > room:
        kept = [*itertools.takewhile(lambda line: not line.startswith(" "), below[: room - 1])]
        left = sum(not line.startswith(" ") for line in below[len(kept) :])
        hidden += [counted(left, "further note", "further notes")] * bool(left)
        below = [*kept, f"{' and '.join(hidden)}: --all; -o TABLE.csv has all rows"]
    return [*above, few], below


def place_lines(data: Results, found: Sequence[Asked]) -> list[str | pd.DataFrame]:
    """Lines with the verdict on one operating point, for each scene of a sweep.

    `found` has the verdict for each scene. Raises an `InputError` if there is only one scene, and
    no verdict on it.
    """
    lines = list[str | pd.DataFrame]()
    if len(found) == 1:
        found[0].known()
    sizes = {"velocity": len(data.velocities), "load": len(data.loads)}
    axes = [axis for axis, size in sizes.items() if size > 1]
    for one in found:
        labels = one.source.labels.items()
        own = {name: value for name, value in labels if name in data.front}
        lines += [f"{row}:" for row in [entries_in_words(data.rows, own)] if row]
        lines += words.margin_lines(one.margin, axes) if one.margin else [one.reason]
    is_molten = any(one.margin and one.margin.deciding_temperature > MELTS for one in found)
    return [*lines, *remarks("warning", MOLTEN * is_molten)]


def boundary(options: argparse.Namespace) -> Result:
    """Answer ``irg boundary``: show critical velocities or loads, or compare tests and model."""
    data = pipeline.results(dataset_in(options))
    require_kind(data.kind, Layout.PLANE)
    if options.by == "test":
        return _tests(data)
    with working("finding the boundary"):
        crossings = pipeline.boundary(data)
    table = boundary_frame(crossings, options.by)
    alone = ["friction"] if "friction" in crossings.attrs else []
    shown = short(table, [*alone, *JUDGED.values(), ERRORS["surface_error"], "notes"])
    few = shown if options.all else some_rows(shown, _MOST_ROWS)
    left_out = len(shown) - len(few)
    rests = [f"{left_out} more rows: --all, or -o TABLE.csv"] * bool(left_out)
    rests += words.boundary_lines(crossings)
    rule = judged_by((one.conditions for one in data.scenes), data.told_tests)
    text = [*wrapped([rule]), "", few, "", *wrapped([*rests, *caveats_of(data)])]
    return Result(text=text, warned=pipeline.warned(data), frames=[table])


def _tests(data: Results) -> Result:
    """The tests of the first scene, each at its own conditions, beside what is computed there."""
    evidence = judge_of(next(data.scenes)).evidence
    if not evidence.rows:
        raise InputError("the scene has no tests; give [[measured]] or [[tested]] in the scene")
    table = tests_frame(evidence)
    lines = [*test_parts(evidence)]
    return Result(text=wrapped(lines), warned=pipeline.warned(data), frames=[table])
