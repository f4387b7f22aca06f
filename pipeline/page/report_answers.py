"""The answer at the head of a report: its verdict, sentences, and sections."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

import pipeline
from pipeline.answers.answer_frames import margin_frame
from pipeline.answers.answer_lines import (
    common_lines,
    conditions_lines,
    model_error_line,
    not_included_lines,
    point_warnings,
    reason_lines,
    row_warnings,
    temperature_error_line,
)
from pipeline.answers.boundary_lines import next_run_line
from pipeline.answers.digits import error_of, rounded
from pipeline.answers.point_lines import headline, margin_facts, to_decide
from pipeline.answers.readable import code_text, row_labels, verdict_text
from pipeline.answers.results import refuse_cases
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.figures.rows_figure import draw_rows, most_critical_row
from pipeline.page import elements
from pipeline.page.sections import Conditions, error_sentences, plane_sections
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from tribo import InputError

HEADLINES = {
    MILD: "Mild wear",
    SEVERE: "Severe wear (scuffing)",
    UNDECIDED: "Undecided",
    OUTSIDE: "Outside the model",
}
"""The verdict in the words of the headline."""
_LIMIT_NODES = 401  # loads or velocities among which the highest mild one is found


class Answer(NamedTuple):
    """Headline with its verdict, sentences below it, and the sections that belong to it."""

    verdict: str
    headline: str
    sentences: list[str]
    sections: list[elements.Section]


def boundary_answer(ds: xr.Dataset, conditions: Conditions) -> Answer:
    """The boundary of a plane, without an operating point."""
    boundary = pipeline.boundary(ds, **conditions)
    lines = [*not_included_lines(boundary)]
    if boundary["critical_velocity"].ndim == 1:  # a single case
        lines.insert(0, next_run_line(boundary))
    title = "Boundary between mild and severe wear"
    return Answer("", title, [*map(elements.as_sentence, lines)], plane_sections(ds, conditions))


def point_answer(ds: xr.Dataset, conditions: Conditions, margin: xr.Dataset) -> Answer:
    """The verdict on one operating point."""
    verdict, reason = margin["verdict"].item(), margin["reason"].item()
    if verdict not in HEADLINES:
        raise InputError(reason)
    point = margin["load"].item(), margin["velocity"].item()
    facts, advice = dict(margin_facts(margin)), to_decide(margin)
    sentences = [_probability_sentence(margin), *_mild_limits(ds, conditions, point)]
    sentences += not_included_lines(margin)
    if reason:
        sentences.append(f"The verdict is withheld: {reason}")
    if advice:
        sentences.append(f"To decide it, {advice}")
    sentences += elements.without_help(common_lines(margin))
    rows = [*map(list, facts.items())]
    table = elements.Table("The operating point in numbers", ["quantity", "value"], rows)
    warnings = [*map(elements.as_sentence, point_warnings(margin))]
    first, *other_sections = plane_sections(ds, conditions, [point])
    numbers: elements.Section = ("Operating point", [table, warnings] if warnings else [table])
    sections: list[elements.Section] = [first, numbers]
    title = f"{HEADLINES[verdict]} at {point[0]:.4g} N and {point[1]:.4g} m/s"
    lines = [*map(elements.as_sentence, sentences)]
    return Answer(verdict_text(margin), title, lines, [*sections, *other_sections])


def _mild_limits(ds: xr.Dataset, conditions: Conditions, point: OperatingPoint) -> Iterator[str]:
    """Yield sentences on the highest velocity and load at an operating point that are mild."""
    for axis, fixed in (("velocity", point[0]), ("load", point[1])):
        values = ds[axis].values[ds[axis].values > 0]
        if len(values) < 2:
            continue
        grid = np.linspace(values[0], values[-1], _LIMIT_NODES)
        line = (fixed, grid) if axis == "velocity" else (grid, fixed)
        margins = pipeline.margin(ds, *line, **conditions)
        is_mild = margins["verdict"].values == MILD
        unit, fixed_unit = ("m/s", "N") if axis == "velocity" else ("N", "m/s")
        if not is_mild[0]:
            yield f"at {fixed:.4g} {fixed_unit}, wear is not mild at any simulated {axis}"
        elif is_mild.all():
            end = f"{grid[-1]:.4g} {unit}, the highest simulated {axis}"
            yield f"at {fixed:.4g} {fixed_unit}, wear is mild up to {end}"
        else:
            k = int(is_mild.argmin()) - 1
            error = error_of(margins, axis).values[k]
            highest = rounded(grid[k], error, upwards=False)
            yield f"at {fixed:.4g} {fixed_unit}, wear is mild up to {highest} {unit}"


def rows_answer(ds: xr.Dataset, conditions: Conditions, margins: xr.Dataset) -> Answer:
    """The verdicts on a table of operating points, or on the rows of the sweep."""
    if len(margins.sizes) > 1:
        refuse_cases(ds)
        raise InputError(f"a report has rows along one dimension, not along {[*margins.sizes]}")
    (row,) = margins.sizes
    deciding, names = most_critical_row(margins), row_labels(margins, str(row))
    codes = margins["verdict"].values.tolist()
    verdicts = code_text(margins["verdict"]).tolist()
    verdict, critical = verdicts[deciding], f"the most critical operating point: {names[deciding]}"
    title = f"{HEADLINES.get(codes[deciding], 'Unknown')} at {critical}"
    verdict_count = sum(code in (MILD, UNDECIDED, SEVERE) for code in codes)
    if codes[deciding] == MILD and verdict_count < len(codes):  # the others may be severe
        title = (
            f"{verdict_count} of {len(codes)} operating points have a verdict; mild at {critical}"
        )
        verdict = ""
    caption = "Temperature margin of each row: critical minus governing temperature."
    figure = elements.figure_of(lambda: draw_rows(margins, ""), caption, caption)
    table = elements.table_of(
        margin_frame(margins), "Operating points; the deciding one is bold", deciding
    )
    notes = [
        *conditions_lines(margins), *reason_lines(margins),
        *row_warnings(margins), *common_lines(margins),
    ]  # fmt: skip
    notes = [*map(elements.as_sentence, elements.without_help(notes))]
    sections: list[elements.Section] = [("Operating points", [figure, table, notes])]
    if {*PLANE} <= {*ds["status"].dims}:
        points = xr.broadcast(margins["load"], margins["velocity"])
        coordinates = (values.values.ravel().tolist() for values in points)
        sections += plane_sections(ds, conditions, dict.fromkeys(zip(*coordinates, strict=True)))
    else:
        lines = temperature_error_line(margins), model_error_line(margins)
        sections.append(("Errors", [error_sentences(*lines)]))
    numbers = ", ".join(f"{number} {text}" for text, number in Counter(verdicts).items())
    sentences = [f"Operating points: {numbers}", *not_included_lines(margins)]
    if codes[deciding] in HEADLINES:
        sentences.insert(0, _probability_sentence(margins.isel({row: deciding})))
    return Answer(verdict, title, [*map(elements.as_sentence, sentences)], sections)


def _probability_sentence(margin: xr.Dataset) -> str:
    """Sentence on the probability at one operating point; the headline has its verdict."""
    verdict, _, rest = headline(margin).partition(": ")
    subject = "probability of severe wear "
    return (rest or verdict).replace(subject, f"the {subject}is ", 1)
