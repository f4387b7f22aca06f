"""`report`: the answers on a sweep as a page of HTML; it computes nothing itself."""

from __future__ import annotations

import base64
import hashlib
import io
import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from datetime import UTC, datetime
from functools import partial
from importlib import metadata, resources
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import xarray as xr
from jinja2 import Environment
from matplotlib.figure import Figure

import pipeline
from pipeline.answers.answer_frames import (
    boundary_frame,
    comparison_frame,
    margin_frame,
    row_labels,
)
from pipeline.answers.facts import ERRORS, NOTES, PARTS_OF_ERROR, fact_lines, facts
from pipeline.answers.headline import headline, limit_text, probability_line, to_decide
from pipeline.answers.results import case_dims, cases_of, dataset_of, refuse_cases, sweep_of
from pipeline.answers.sensitivity_answer import sensitivity_answer
from pipeline.answers.value_text import code_text, verdict_text
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.figures.diagram import diagram
from pipeline.figures.rows_figure import draw_rows, most_critical_row
from pipeline.figures.study_figures import draw_sensitivities
from pipeline.figures.style import fitted
from pipeline.frames import cells_of, without_columns, write_text
from pipeline.paths import writable_path
from pipeline.store.location import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from pipeline.sweep.codec import digest
from pipeline.sweep.notes import library_tables
from tribo import InputError

HEADLINES = {
    MILD: "Mild wear",
    SEVERE: "Severe wear (scuffing)",
    UNDECIDED: "Undecided",
    OUTSIDE: "Outside the model",
}
"""The verdict in the words of the headline."""
_CAUSES_OF_ERRORS = (
    "The numerical error comes from the elements and load steps, from interpolation between "
    "simulated points, from the positions of the disk at which a pin at rest wears, and from the "
    "small number of simulated surfaces; more computing makes it smaller. The model error comes "
    "from the physics that is left out, and from the inputs; only tests make it smaller."
)
_MODEL = (
    "The model: a rough, elastic–plastic contact under boundary lubrication is worn by Archard's "
    "law while the load grows, and heated by friction. Wear is severe where the contact gets too "
    "hot for the lubricant. An oil film that carries load, and the wear after the transition, are "
    "not part of it."
)
_PAPER = (
    "R. Bosman and M. B. de Rooij: On the transition from mild to severe wear of lubricated, "
    "concentrated contacts: The IRG (OECD) transition diagram."
)
_MAX_ROWS_ON_FIRST_PAGE = 10  # of a table below its figure
Conditions = Mapping[str, Any]
"""Conditions of an answer, by name."""


Section = tuple[str, list[Any]]
"""Heading of a section, and its parts: a string, a list of strings, or a mapping.

A table has `caption`, `headings` and `rows`; that with the index `bold` stands out. A figure has
`caption` and a data `url`. A `text` keeps its lines.
"""


class Page(NamedTuple):
    """The first page of a report: headline with its verdict, sentences, sections; its appendix."""

    verdict: str
    headline: str
    sentences: list[str]
    sections: list[Section]
    appendix: list[Section]


def report(
    ds: xr.Dataset | PathLike,
    load: float | str | None = None,
    velocity: float | str | None = None,
    out: str | Path | None = None,
    points: Any = None,
    title: str | None = None,
    author: str | None = None,
    command: str = "",
    without_tests: bool = False,
    **conditions: Any,
) -> str | Path:
    """Write a report on a sweep: one page of HTML without scripts, which needs no other file.

    Its first page, printed on A4, has the verdict on the operating point and its limits, the
    diagram or the rows, and what is not included. The appendix has the numbers, the boundary,
    tests, errors, inputs, and how all was computed.

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
    without_tests : bool, optional
        Leave out the tests of the scene.
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
    ds = dataset_of(ds, without_tests)
    if (load is None) != (velocity is None) or (points is not None and load is not None):
        raise InputError("give a load and a velocity, or a table of points, or neither")
    if load is None and points is None and _is_plane(ds):
        page = _boundary_page(ds, conditions)
    else:
        margins = pipeline.margin(ds, points if load is None else load, velocity, **conditions)
        write_page = _rows_page if margins.sizes else _point_page
        page = write_page(ds, conditions, margins)
    sweep, version = sweep_of(ds), metadata.version("irg-transition")
    date = f"{datetime.now(UTC):%d %B %Y}"
    css = resources.files(__package__).joinpath("page.css").read_text("utf-8")
    html = resources.files(__package__).joinpath("page.html").read_text("utf-8")
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(html)
    text = template.render(
        page._asdict(),
        title=title or sweep.title,
        about=[*([sweep.title] if title else ()), f"{date}, {author}" if author else date],
        author=author,
        version=version,
        command=command,
        style=css,
        digest=f"sha256-{base64.b64encode(hashlib.sha256(css.encode()).digest()).decode()}",
        sections=[*page.sections, _section_on_limits(ds)],
        appendix=[*page.appendix, *_inputs_sections(ds), *_closing_sections(ds, version)],
    )
    text = text.encode(errors="replace").decode()  # shells may pass bytes that are no text
    return text if path is None else write_text(text, path)


def _is_plane(ds: xr.Dataset) -> bool:
    """True if a sweep has a plane of loads and velocities."""
    return {*PLANE} <= {*ds["status"].dims}


def _boundary_page(ds: xr.Dataset, conditions: Conditions) -> Page:
    """The boundary of a plane, without an operating point."""
    boundary = pipeline.boundary(ds, **conditions)
    lines = fact_lines(boundary, "not included", *NOTES)
    title = "Boundary between mild and severe wear"
    sections, appendix = _plane_sections(ds, conditions)
    if boundary["mild_velocity"].size <= _MAX_ROWS_ON_FIRST_PAGE:
        sections.append(appendix.pop(0))
    return Page("", title, _sentences(lines), sections, appendix)


def _point_page(ds: xr.Dataset, conditions: Conditions, margin: xr.Dataset) -> Page:
    """The verdict on one operating point."""
    verdict = margin["verdict"].item()
    if verdict not in HEADLINES:
        raise InputError(margin["reason"].item())
    load, velocity = margin["load"].item(), margin["velocity"].item()
    limits = (limit_text(margin, axis) for axis in (*PLANE, "friction"))
    lines = [*filter(None, limits), *fact_lines(margin, "without a verdict")]
    if advice := to_decide(margin):
        lines.append(f"To decide it, {advice}")
    lines += [
        _probability_sentence(margin),
        *fact_lines(margin, "not included", "contact", *NOTES),
    ]
    rows = [[fact.name, fact.value] for fact in facts(margin) if not fact.is_sentence]
    headings = ["quantity", "value"]
    table = {"caption": "The operating point in numbers", "headings": headings, "rows": rows}
    sections, appendix = _plane_sections(ds, conditions, [(load, velocity)])
    title = f"{HEADLINES[verdict]} at {load:g} N and {velocity:g} m/s"
    appendix.insert(0, ("Operating point", [table]))
    return Page(verdict_text(margin), title, _sentences(lines), sections, appendix)


def _rows_page(ds: xr.Dataset, conditions: Conditions, margins: xr.Dataset) -> Page:
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
    counts = ", ".join(f"{count} {name}" for name, count in Counter(verdict_names).items())
    lines = [
        *fact_lines(margins, "mild load factor"),
        f"Operating points: {counts}",
        *fact_lines(margins, "not included", "contact", *NOTES),
    ]
    if verdict_code in HEADLINES:
        lines.insert(0, _probability_sentence(margins.isel({dimension: critical_row})))
    caption = "Temperature margin of each row: critical minus governing temperature."
    frame, table_caption = margin_frame(margins), "Operating points; the deciding one is bold"
    notes = _sentences(fact_lines(margins, "conditions", "without a verdict"))
    picture = _picture(lambda: draw_rows(margins, ""), caption)
    table = _table(frame, table_caption, critical_row)
    sections: list[Section] = [("Operating points", [picture])]
    appendix: list[Section] = [("Operating points in numbers", [table, notes])]
    if len(frame) <= _MAX_ROWS_ON_FIRST_PAGE:
        sections.append(appendix.pop())
    if _is_plane(ds):
        points = xr.broadcast(margins["load"], margins["velocity"])
        coordinates = (values.values.ravel().tolist() for values in points)
        plane = _plane_sections(ds, conditions, dict.fromkeys(zip(*coordinates, strict=True)))
        appendix += itertools.chain(*plane)
    else:
        appendix.append(_section_on_errors(margins))
    return Page(verdict, title, _sentences(lines), sections, appendix)


def _probability_sentence(margin: xr.Dataset) -> str:
    """Sentence on the probability at one operating point; the headline has its verdict."""
    return probability_line(margin) or headline(margin)


def _plane_sections(
    ds: xr.Dataset, conditions: Conditions, points: Iterable[OperatingPoint] = ()
) -> tuple[list[Section], list[Section]]:
    """Section with the diagram; sections with the boundary, tests and prediction, and errors."""
    boundary = pipeline.boundary(ds, **conditions)
    caption = " ".join(_sentences(fact_lines(boundary, "conditions")))
    if not case_dims(ds):
        caption += " Dots: simulated points."
    if missing := boundary.attrs["missing_points"]:
        caption += f" ×: {missing} points that are pending or failed."
    ends = [ds[axis].values[[0, -1]].tolist() for axis in PLANE]
    inside = [
        point
        for point in points
        if all(low <= value <= high for value, (low, high) in zip(point, ends, strict=True))
    ]
    loads, velocities = ([point[axis] for point in inside] for axis in (0, 1))
    table_caption = "Velocities up to which the verdict is mild, and from which it is severe"
    table = _table(boundary_frame(boundary), table_caption)
    sections, appendix = list[Section](), list[Section]([("Boundary", [table])])
    if min(boundary.sizes[axis] for axis in PLANE) > 1:
        draw = partial(diagram, ds, conditions, load=loads, velocity=velocities)
        sections.append(("Transition diagram", [_picture(draw, caption)]))
    if rulings := _sentences(fact_lines(boundary, "ruling")):
        appendix.append(("Tests that rule verdicts out", [rulings]))
    if boundary.attrs.get("tests") and not case_dims(ds):
        tests = pipeline.compare_tests(ds, **conditions)
        table_caption = "Tests, each at its own conditions, and what is computed for them"
        withheld = _sentences(fact_lines(tests, "verdicts withheld"))
        appendix.append(
            ("Tests and prediction", [_table(comparison_frame(tests), table_caption), withheld])
        )
    return sections, [*appendix, _section_on_errors(boundary)]


def _section_on_errors(answer: xr.Dataset) -> Section:
    return "Errors", [_sentences(fact_lines(answer, *ERRORS, PARTS_OF_ERROR)), _CAUSES_OF_ERRORS]


def _section_on_limits(ds: xr.Dataset) -> Section:
    """The last section of the first page: what the model leaves out, and points with warnings."""
    warnings = _sentences(pipeline.points_with_warnings(ds).lines())
    return "What is not included", [_MODEL, warnings]


def _inputs_sections(ds: xr.Dataset) -> list[Section]:
    """Section with bars of the sensitivities to uncertain inputs; empty without their points."""
    for case in cases_of(ds):
        points = sorted({(v.load, v.velocity) for v, _ in case.variants if v.of_case == case.name})
        if points and case.sweep.base.is_judged:
            load, velocity = points[len(points) // 2]
            answer = sensitivity_answer(case, load, velocity, case.sweep.base.uncertainty)
            answer = answer.dropna("input", subset=["velocity_change"])
            caption = "What the declared inputs, friction and temperatures change"
            picture = _picture(partial(draw_sensitivities, answer), caption)
            return [("Inputs and the limit", [picture])] if answer.sizes["input"] else []
    return []


def _closing_sections(ds: xr.Dataset, version: str) -> list[Section]:
    """The last sections of each report: inputs, and how all was computed."""
    sweep = sweep_of(ds)
    sources = [f"{text}, from {source}" for text, source in library_tables(sweep.sources)]
    origin = [
        *str(ds.attrs.get("history", "")).splitlines(),
        f"Scene {sweep.name}, inputs {digest(sweep.scene)} (SHA-256)",
        f"The irg-transition developers: irg-transition (version {version}). BSD-3-Clause.",
        _PAPER,
    ]
    return [
        ("Inputs", [{"text": ds.attrs.get("scene")}, sources]),
        ("How this was computed", [origin]),
    ]


def _table(frame: pd.DataFrame, caption: str, bold: int = -1) -> dict[str, Any]:
    """Table with the values of a data frame; the row with the index `bold` stands out."""
    frame = without_columns(frame.replace("", None))
    headings = [str(column).replace("_", " ") for column in frame]
    rows = cells_of(frame, "–", digits=3)
    return {"caption": caption, "headings": headings, "rows": rows, "bold": bold}


def _picture(draw: Callable[[], Figure], caption: str) -> dict[str, str]:
    """A figure without title and caption, which a table below it must repeat."""
    with fitted(plain=True):
        svg = io.BytesIO()
        draw().savefig(svg, format="svg", metadata={"Date": None})
    url = f"data:image/svg+xml;base64,{base64.b64encode(svg.getvalue()).decode()}"
    return {"url": url, "caption": caption}


def _sentences(lines: Iterable[str]) -> list[str]:
    """Lines of answers as sentences, without references to `irg help`."""
    lines = (re.sub(r" \(irg help [\w-]+\)", "", line) for line in lines)
    return [f"{line[:1].upper()}{line[1:].removesuffix('.')}." for line in lines]
