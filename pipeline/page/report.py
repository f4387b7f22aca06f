"""`report`: the answers on a sweep as a page of HTML; it computes nothing itself."""

from __future__ import annotations

import base64
import hashlib
import io
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from importlib import metadata, resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from jinja2 import Environment
from matplotlib.figure import Figure

import pipeline
from pipeline.answers.answer_frames import (
    boundary_frame,
    has_counted_tests,
    margin_frame,
    tests_frame,
)
from pipeline.answers.answer_lines import (
    common_lines,
    conditions_lines,
    model_error_line,
    not_included_lines,
    point_warnings,
    reason_lines,
    row_warnings,
    temperature_error_line,
    test_lines,
)
from pipeline.answers.boundary_lines import error_lines, next_run_line, ruling_lines, shift_lines
from pipeline.answers.digits import error_of, rounded
from pipeline.answers.point_lines import headline, margin_facts, to_decide
from pipeline.answers.readable import attribute_texts, code_text, row_labels, verdict_text
from pipeline.answers.results import case_dims, dataset_of, refuse_cases, sweep_of
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.arguments import typed_arguments
from pipeline.figures import style
from pipeline.figures.diagram import diagram
from pipeline.figures.rows_figure import deciding_row, draw_rows
from pipeline.figures.tests_figure import draw_tests
from pipeline.frames import cells_of, without_columns, writable_path, write_text
from pipeline.messages import quoted, split_notes
from pipeline.page.input_tables import case_rows, input_rows
from pipeline.store.location import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from pipeline.sweep.codec import digest
from tribo import InputError

HEADLINES = {
    MILD: "Mild wear",
    SEVERE: "Severe wear (scuffing)",
    UNDECIDED: "Undecided",
    OUTSIDE: "Outside the model",
}
"""The verdict in the words of the headline."""
_MODEL = (
    "The model: a rough, elastic–plastic contact under boundary lubrication is worn by Archard's "
    "law while the load grows, and heated by friction. Wear is severe where the contact gets too "
    "hot for the lubricant. An oil film that carries load, and the wear after the transition, are "
    "not part of it."
)
_NUMERICAL_ERROR = (
    "It comes from the elements and load steps, from interpolation between simulated points, and "
    "from the few surfaces that are simulated; more computing makes it smaller"
)
_MODEL_ERROR = (
    "It comes from the physics that is left out and from the inputs; only tests make it smaller"
)
_PAPER = (
    "R. Bosman and M. B. de Rooij: On the transition from mild to severe wear of lubricated, "
    "concentrated contacts: The IRG (OECD) transition diagram."
)
_TABLE_BELOW = "The table below has the numbers."
_WITH_TESTS = "Critical velocity as computed; with tests: where severe wear is 5, 50, 95 % probable"
_WITHOUT_TESTS = "Critical velocity as computed, and where severe wear is 5 and 95 % probable"
_LIMIT_NODES = 401  # loads or velocities among which the highest mild one is found
_NARROW_WIDTH = 0.075  # width of figures on a telephone [m]

Conditions = Mapping[str, Any]


class Grid(NamedTuple):
    """A table of a page; the row number `bold` stands out."""

    caption: str
    heads: list[str]
    rows: list[list[str]]
    bold: int = -1


class Picture(NamedTuple):
    """A figure of a page, for usual and for narrow screens, as data URLs."""

    usual: str
    narrow: str
    alt: str
    caption: str


Section = tuple[str, list[str | Grid | Picture | list[str]]]
"""Heading of a section, and its parts; a list of strings is printed as a list."""


class Answer(NamedTuple):
    """Headline with its verdict, sentences below it, and the sections that belong to it."""

    verdict: str
    headline: str
    answer: list[str]
    sections: list[Section]


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

    The verdict on the operating point stands first, then the diagram, the boundary, tests,
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
    operating_points = {"load": points} if load is None else {"load": load, "velocity": velocity}
    is_plane, margins = {*PLANE} <= {*ds["status"].dims}, None
    if load is not None or points is not None or not is_plane:
        margins = pipeline.margin(ds, **operating_points, **conditions)
    if margins is None:
        answer = _boundary_answer(ds, conditions)
    elif not margins.sizes:
        answer = _point_answer(ds, conditions, margins)
    else:
        answer = _rows_answer(ds, conditions, margins)
    sweep = sweep_of(ds)
    version = metadata.version("irg-transition")
    date = f"{datetime.now(UTC):%d %B %Y}"
    text, css = (
        resources.files(__package__).joinpath(f"page.{kind}").read_text("utf-8")
        for kind in ("html", "css")
    )
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(text)
    page = template.render(
        answer._asdict(),
        title=title or sweep.title,
        about=[*([sweep.title] if title else []), ", ".join(filter(None, (date, author)))],
        author=author,
        version=version,
        command=command,
        style=css,
        digest=f"sha256-{base64.b64encode(hashlib.sha256(css.encode()).digest()).decode()}",
        sections=[*answer.sections, *_common(ds, conditions, version, answer.answer)],
    )
    page = page.encode(errors="replace").decode()  # shells may pass bytes that are no text
    return page if path is None else write_text(page, path)


def _boundary_answer(ds: xr.Dataset, conditions: Conditions) -> Answer:
    """The boundary of a plane, without an operating point."""
    boundary = pipeline.boundary(ds, **conditions)
    lines = [*not_included_lines(boundary)]
    if boundary["critical_velocity"].ndim == 1:  # a single case
        lines.insert(0, next_run_line(boundary))
    title = "Boundary between mild and severe wear"
    return Answer("", title, [*map(_as_sentence, lines)], _plane(ds, conditions))


def _point_answer(ds: xr.Dataset, conditions: Conditions, margin: xr.Dataset) -> Answer:
    """The verdict on one operating point."""
    verdict, reason = margin["verdict"].item(), margin["reason"].item()
    if verdict not in HEADLINES:
        raise InputError(reason)
    point = margin["load"].item(), margin["velocity"].item()
    facts, advice = dict(margin_facts(margin)), to_decide(margin)
    sentences = [_verdict(margin), *_mild_limits(ds, conditions, point)]
    sentences += not_included_lines(margin)
    if reason:
        sentences.append(f"The verdict is withheld: {reason}")
    if advice:
        sentences.append(f"To decide it, {advice}")
    sentences += _without_help(common_lines(margin))
    rows = [*map(list, facts.items())]
    table = Grid("The operating point in numbers", ["quantity", "value"], rows)
    warnings = [*map(_as_sentence, point_warnings(margin))]
    first, *other_sections = _plane(ds, conditions, [point])
    numbers: Section = ("Operating point", [table, warnings] if warnings else [table])
    sections: list[Section] = [first, numbers]
    title = f"{HEADLINES[verdict]} at {point[0]:.4g} N and {point[1]:.4g} m/s"
    lines = [*map(_as_sentence, sentences)]
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


def _rows_answer(ds: xr.Dataset, conditions: Conditions, margins: xr.Dataset) -> Answer:
    """The verdicts on a table of operating points, or on the rows of the sweep."""
    if len(margins.sizes) > 1:
        refuse_cases(ds)
        raise InputError(f"a report has rows along one dimension, not along {[*margins.sizes]}")
    (row,) = margins.sizes
    deciding, names = deciding_row(margins), row_labels(margins, str(row))
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
    picture = picture_of(lambda: draw_rows(margins, ""), caption, f"{caption} {_TABLE_BELOW}")
    grid = _frame_grid(
        margin_frame(margins), "Operating points; the deciding one is bold", deciding
    )
    notes = [
        *conditions_lines(margins), *reason_lines(margins),
        *row_warnings(margins), *common_lines(margins),
    ]  # fmt: skip
    notes = [*map(_as_sentence, _without_help(notes))]
    sections: list[Section] = [("Operating points", [picture, grid, notes])]
    if {*PLANE} <= {*ds["status"].dims}:
        points = xr.broadcast(margins["load"], margins["velocity"])
        coordinates = (values.values.ravel().tolist() for values in points)
        sections += _plane(ds, conditions, dict.fromkeys(zip(*coordinates, strict=True)))
    else:
        lines = temperature_error_line(margins), model_error_line(margins)
        sections.append(("Errors", [_errors(*lines)]))
    numbers = ", ".join(f"{number} {text}" for text, number in Counter(verdicts).items())
    sentences = [f"Operating points: {numbers}", *not_included_lines(margins)]
    if codes[deciding] in HEADLINES:
        sentences.insert(0, _verdict(margins.isel({row: deciding})))
    return Answer(verdict, title, [*map(_as_sentence, sentences)], sections)


def _verdict(margin: xr.Dataset) -> str:
    """Sentence on the probability at one operating point; the headline has its verdict."""
    verdict, _, rest = headline(margin).partition(": ")
    subject = "probability of severe wear "
    return (rest or verdict).replace(subject, f"the {subject}is ", 1)


def _plane(
    ds: xr.Dataset, conditions: Conditions, points: Iterable[OperatingPoint] = ()
) -> list[Section]:
    """Sections with the diagram, the boundary, tests compared with the computation, and errors."""
    boundary = pipeline.boundary(ds, **conditions)
    ends = [ds[axis].values[[0, -1]].tolist() for axis in PLANE]
    points_inside = [
        point
        for point in points
        if all(low <= value <= high for value, (low, high) in zip(point, ends, strict=True))
    ]
    caption = _as_sentence(conditions_lines(boundary)[0])
    if not case_dims(ds):
        caption += " Dots: simulated points."
    if missing := boundary.attrs["missing_points"]:
        caption += f" ×: {missing} points that are pending or failed."
    loads, velocities = ([point[axis] for point in points_inside] for axis in (0, 1))
    picture = picture_of(
        lambda: diagram(ds, conditions, load=loads, velocity=velocities), caption,
        f"Transition diagram over sliding velocity and normal load. {_TABLE_BELOW}",
    )  # fmt: skip
    title, needless = _WITH_TESTS, list[str]()
    if not has_counted_tests(boundary):
        title, needless = _WITHOUT_TESTS, ["50 % [m/s]"]
    crosses = bool(boundary["critical_velocity"].notnull().all())
    if crosses and len({*boundary["outcome_along_velocity"].values.ravel()}) == 1:
        needless.append("outcome")
    grid = _frame_grid(without_columns(boundary_frame(boundary), needless), title)
    sections: list[Section] = [("Transition diagram", [picture]), ("Boundary", [grid])]
    if boundary.attrs.get("tests") and not case_dims(ds):
        sections.append(("Tests and prediction", [*_tests(ds, conditions)]))
    if rulings := [*map(_as_sentence, ruling_lines(boundary))]:
        sections.insert(2, ("Tests that rule verdicts out", [rulings]))
    lines = _errors(*error_lines(boundary), *shift_lines(boundary))
    return [*sections, ("Errors", [lines])]


def _errors(*lines: str) -> list[str]:
    """Sentences on errors: the size of each, and its origin."""
    origins = {"numerical": f" {_NUMERICAL_ERROR}.", "model error": f" {_MODEL_ERROR}."}
    return [
        _as_sentence(line)
        + "".join(text for begin, text in origins.items() if line.startswith(begin))
        for line in lines
    ]


def _tests(ds: xr.Dataset, conditions: Conditions) -> Iterator[Picture | Grid | list[str]]:
    """Yield figure, table and notes that compare tests with the computation."""
    tests = pipeline.compare_tests(ds, **conditions)
    caption = "Computed rise ratio of each test, next to its outcome."
    yield picture_of(lambda: draw_tests(ds, conditions), caption, f"{caption} {_TABLE_BELOW}")
    table = tests_frame(tests)
    y = tests["log_rise_ratio"].values
    computed = ["" if math.isnan(value) else "severe" if value > 0 else "mild" for value in y]
    table.insert(2, "computed", computed)
    yield _frame_grid(table, "Tests, each at its own conditions, and what is computed for them")
    if lines := [*test_lines(tests)]:
        yield lines


def _common(
    ds: xr.Dataset, conditions: Conditions, version: str, stated: Sequence[str]
) -> Iterator[Section]:
    """Yield the last sections of each report: inputs, limits that are not yet `stated`, origin."""
    sweep = sweep_of(ds)
    inputs = Grid(
        "Inputs, and where each comes from", ["part", "values", "source"], [*input_rows(sweep)]
    )
    heads, rows = case_rows(sweep)
    cases = [Grid("Cases of the sweep", heads, rows)] if rows else []
    yield "Conditions and inputs", [inputs, *cases]
    single = {name: value for name, value in conditions.items() if not np.ndim(value)}
    notes = split_notes(attribute_texts(pipeline.points(ds, **single), "notes"))
    limits = _without_help([*notes, *pipeline.points_with_warnings(ds).lines()])
    uncovered = [line for line in map(_as_sentence, limits) if line not in stated]
    yield "What is not covered", [_MODEL, uncovered] if uncovered else [_MODEL]
    choices = [
        f"{name.replace('_', ' ')} {quoted(value)}"
        for name, value in asdict(sweep.scene.fidelity).items()
    ]
    origin = [
        *str(ds.attrs.get("history", "")).splitlines(),
        f"scene {sweep.name}, inputs {digest(sweep.scene)} (SHA-256)",
        f"preset {sweep.preset}: {', '.join(choices)}",
        f"The irg-transition developers: irg-transition (version {version}). BSD-3-Clause.",
        _PAPER,
    ]
    yield "How this was computed", [origin]


def _without_help(lines: Iterable[str]) -> list[str]:
    """Lines without references to `irg help`, which a reader of the report may not have."""
    return [re.sub(r" \(irg help [\w-]+\)", "", line) for line in lines]


def _as_sentence(line: str) -> str:
    """Line of an answer with a capital letter and a full stop."""
    sentence = f"{line[:1].upper()}{line[1:]}"
    return sentence if line.endswith(".") else f"{sentence}."


def _frame_grid(frame: pd.DataFrame, caption: str, bold: int = -1) -> Grid:
    """Table with the values of a data frame; the row number `bold` stands out."""
    frame = without_columns(frame.replace("", None))
    heads = [str(head).replace("_", " ") for head in frame]
    return Grid(caption, heads, cells_of(frame, "–", digits=3), bold)


def picture_of(draw: Callable[[], Figure], caption: str, alt: str) -> Picture:
    """Draw a figure twice, for usual and for narrow screens."""
    urls = []
    for width in (None, _NARROW_WIDTH):
        with style.fitted(width, plain=True):
            buffer = io.BytesIO()
            draw().savefig(buffer, format="svg", metadata={"Date": None})
        text = base64.b64encode(buffer.getvalue()).decode()
        urls.append(f"data:image/svg+xml;base64,{text}")
    return Picture(urls[0], urls[1], alt, caption)
