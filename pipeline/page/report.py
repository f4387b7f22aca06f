"""`report`: the answers on a sweep as a page of HTML; it computes nothing itself."""

from __future__ import annotations

import base64
import hashlib
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib import metadata, resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jinja2 import Environment

import pipeline
from pipeline.answers.answer_frames import margin_frame
from pipeline.answers.answer_lines import (
    common_lines,
    conditions_lines,
    headline,
    margin_facts,
    model_error_line,
    next_run_line,
    not_included_lines,
    point_warnings,
    reason_lines,
    row_warnings,
    temperature_error_line,
    to_decide,
)
from pipeline.answers.readable import code_text, error_of, format_value, row_labels, verdict_text
from pipeline.answers.results import dataset_of, refuse_cases, sweep_of
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.arguments import typed_arguments
from pipeline.figures.rows_figure import draw_rows, most_critical_row
from pipeline.frames import write_text
from pipeline.page import elements
from pipeline.page.sections import Conditions, common_sections, error_sentences, plane_sections
from pipeline.paths import writable_path
from pipeline.store.location import PathLike
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


@typed_arguments
def report(
    ds: xr.Dataset | PathLike,
    load: float | str | None = None,
    velocity: float | str | None = None,
    out: str | Path | None = None,
    points: Any = None,
    title: str | None = None,
    author: str | None = None,
    command: str = "",
    **conditions: Any,
) -> str | Path:
    """Write a report on a sweep: one page of HTML without scripts, which needs no other file.

    It begins with the verdict on the operating point, followed by the diagram, the boundary, tests,
    errors, inputs, limits, and how all was computed.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path or URL of the store.
    load, velocity : float or str, optional
        An operating point, in SI or as text with a unit.
    out : path, optional
        File to write, .html.
    points : path or mapping, optional
        Table of operating points in place of one, as in `pipeline.margin`.
    title, author : str, optional
        Title of the report, by default that of the scene; name of its author.
    command : str, optional
        Command that wrote the report, to be stated in it.
    **conditions
        Conditions as in `pipeline.margin`, such as ``friction=0.12``.

    Returns
    -------
    str or Path
        The page as HTML, or the path of the file if `out` is given.

    Raises
    ------
    InputError
        If an operating point is outside the sweep, or the file cannot be written.

    Examples
    --------
    >>> import pipeline
    >>> page = pipeline.report("results/first_try.zarr", "400 N", "1.4 m/s", author="A. Smith")
    >>> "Mild wear at 400 N and 1.4 m/s" in page
    True
    """
    path = None if out is None else writable_path(out, (".html",))
    ds = dataset_of(ds)
    if (load is None) != (velocity is None) or (points is not None and load is not None):
        raise InputError("give a load and a velocity, or a table of points, or neither")
    answer = _answer(ds, points if load is None else load, velocity, conditions)
    sweep, version = sweep_of(ds), metadata.version("irg-transition")
    subtitle = [sweep.title] if title else []
    date = f"{datetime.now(UTC):%d %B %Y}"
    subtitle.append(f"{date}, {author}" if author else date)
    folder = resources.files(__package__)
    css = folder.joinpath("page.css").read_text("utf-8")
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        folder.joinpath("page.html").read_text("utf-8")
    )
    page = template.render(
        answer._asdict(),
        title=title or sweep.title,
        about=subtitle,
        author=author,
        version=version,
        command=command,
        style=css,
        digest=f"sha256-{base64.b64encode(hashlib.sha256(css.encode()).digest()).decode()}",
        sections=[*answer.sections, *common_sections(ds, conditions, version, answer.sentences)],
    )
    page = page.encode(errors="replace").decode()  # shells may pass bytes that are no text
    return page if path is None else write_text(page, path)


class _Answer(NamedTuple):
    """Headline with its verdict, sentences below it, and the sections that belong to it."""

    verdict: str
    headline: str
    sentences: list[str]
    sections: list[elements.Section]


def _answer(ds: xr.Dataset, load: Any, velocity: Any, conditions: Conditions) -> _Answer:
    """Answer on one or several operating points, or on the rows or the plane of a sweep."""
    if load is None and {*PLANE} <= {*ds["status"].dims}:
        return _boundary_answer(ds, conditions)
    margins = pipeline.margin(ds, load, velocity, **conditions)
    return (
        _rows_answer(ds, conditions, margins)
        if margins.sizes
        else _point_answer(ds, conditions, margins)
    )


def _boundary_answer(ds: xr.Dataset, conditions: Conditions) -> _Answer:
    """The boundary of a plane, without an operating point."""
    boundary = pipeline.boundary(ds, **conditions)
    lines = [*not_included_lines(boundary)]
    if boundary["critical_velocity"].ndim == 1:  # a single case
        lines.insert(0, next_run_line(boundary))
    title = "Boundary between mild and severe wear"
    return _Answer("", title, [*map(elements.as_sentence, lines)], plane_sections(ds, conditions))


def _point_answer(ds: xr.Dataset, conditions: Conditions, margin: xr.Dataset) -> _Answer:
    """The verdict on one operating point."""
    verdict, reason = margin["verdict"].item(), margin["reason"].item()
    if verdict not in HEADLINES:
        raise InputError(reason)
    point = margin["load"].item(), margin["velocity"].item()
    sentences = [_probability_sentence(margin), *_mild_limits(ds, conditions, point)]
    sentences += not_included_lines(margin)
    if reason:
        sentences.append(f"The verdict is withheld: {reason}")
    if advice := to_decide(margin):
        sentences.append(f"To decide it, {advice}")
    sentences += elements.without_help(common_lines(margin))
    facts = [*map(list, margin_facts(margin))]
    table = elements.Table("The operating point in numbers", ["quantity", "value"], facts)
    warnings = [*map(elements.as_sentence, point_warnings(margin))]
    point_section: elements.Section = (
        "Operating point",
        [table, warnings] if warnings else [table],
    )
    diagram_section, *other_sections = plane_sections(ds, conditions, [point])
    title = f"{HEADLINES[verdict]} at {point[0]:.4g} N and {point[1]:.4g} m/s"
    lines = [*map(elements.as_sentence, sentences)]
    sections = [diagram_section, point_section, *other_sections]
    return _Answer(verdict_text(margin), title, lines, sections)


def _mild_limits(ds: xr.Dataset, conditions: Conditions, point: OperatingPoint) -> Iterator[str]:
    """Yield sentences on the highest velocity and load at an operating point that are mild."""
    load, velocity = point
    for axis, unit, at_point in (
        ("velocity", "m/s", f"at {load:.4g} N"),
        ("load", "N", f"at {velocity:.4g} m/s"),
    ):
        simulated = ds[axis].values[ds[axis].values > 0]
        if len(simulated) < 2:
            continue
        line = np.linspace(simulated[0], simulated[-1], 401)
        line_points: dict[str, Any] = {"load": load, "velocity": velocity, axis: line}
        margins = pipeline.margin(ds, **line_points, **conditions)
        is_mild = margins["verdict"].values == MILD
        if not is_mild[0]:
            yield f"{at_point}, wear is not mild at any simulated {axis}"
        elif is_mild.all():
            yield (
                f"{at_point}, wear is mild up to {line[-1]:.4g} {unit}, the highest simulated "
                f"{axis}"
            )
        else:
            last_mild = int(is_mild.argmin()) - 1
            error = error_of(margins, axis).values[last_mild]
            highest = format_value(line[last_mild], error, upwards=False)
            yield f"{at_point}, wear is mild up to {highest} {unit}"


def _rows_answer(ds: xr.Dataset, conditions: Conditions, margins: xr.Dataset) -> _Answer:
    """The verdicts on a table of operating points, or on the rows of the sweep."""
    if len(margins.sizes) > 1:
        refuse_cases(ds)
        raise InputError(f"a report has rows along one dimension, not along {[*margins.sizes]}")
    (dimension,) = margins.sizes
    critical_row, names = most_critical_row(margins), row_labels(margins, str(dimension))
    codes = margins["verdict"].values.tolist()
    verdict_names = code_text(margins["verdict"]).tolist()
    verdict, verdict_code = verdict_names[critical_row], codes[critical_row]
    critical_point = f"the most critical operating point: {names[critical_row]}"
    title = f"{HEADLINES.get(verdict_code, 'Unknown')} at {critical_point}"
    verdict_count = sum(code in (MILD, UNDECIDED, SEVERE) for code in codes)
    if verdict_code == MILD and verdict_count < len(codes):  # the others may be severe
        verdict = ""
        title = (
            f"{verdict_count} of {len(codes)} operating points have a verdict; mild at "
            f"{critical_point}"
        )
    caption = "Temperature margin of each row: critical minus governing temperature."
    figure = elements.figure_of(lambda: draw_rows(margins, ""), caption, caption)
    table = elements.table_of(
        margin_frame(margins), "Operating points; the deciding one is bold", critical_row
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
    counts = ", ".join(f"{count} {name}" for name, count in Counter(verdict_names).items())
    sentences = [f"Operating points: {counts}", *not_included_lines(margins)]
    if verdict_code in HEADLINES:
        sentences.insert(0, _probability_sentence(margins.isel({dimension: critical_row})))
    return _Answer(verdict, title, [*map(elements.as_sentence, sentences)], sections)


def _probability_sentence(margin: xr.Dataset) -> str:
    """Sentence on the probability at one operating point; the headline has its verdict."""
    verdict, _, rest = headline(margin).partition(": ")
    subject = "probability of severe wear "
    return (rest or verdict).replace(subject, f"the {subject}is ", 1)
