"""`report`: the answers on a sweep as one page of HTML, on which nothing is computed."""

from __future__ import annotations

import base64
import hashlib
import io
import math
import re
import tomllib
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
from pipeline.answers import words
from pipeline.answers.frames import answer_frame, boundary_frame, margin_frame
from pipeline.answers.results import case_dims, dataset_of, refuse_cases, sweep_of
from pipeline.answers.verdict import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.figures import style
from pipeline.figures.diagram import diagram
from pipeline.figures.rows import deciding_row, draw_rows
from pipeline.figures.tests import draw_tests
from pipeline.frames import cells_of, without_columns, writable_path, write_text
from pipeline.scene.entries import flat
from pipeline.store.place import PathLike
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from pipeline.sweep.case_table import dimension_of
from pipeline.sweep.codec import digest
from pipeline.sweep.notes import library_tables
from pipeline.words import quoted, split_notes
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
_NUMERICAL = (
    "It comes from the elements and load steps, from interpolation between simulated points, and "
    "from the few surfaces that are simulated; more computing makes it smaller"
)
_OF_MODEL = (
    "It comes from the physics that is left out and from the inputs; only tests make it smaller"
)
_PAPER = (
    "R. Bosman and M. B. de Rooij: On the transition from mild to severe wear of lubricated, "
    "concentrated contacts: The IRG (OECD) transition diagram."
)
_NO_INPUTS = ("fidelity", "tests", "sweep", "title", "note", "extends", "without")
_Y = "log_rise_ratio"
_DRAWN = (_Y, f"{_Y}_mild", f"{_Y}_severe", "loo_probability")  # which the figure of tests shows
_BELOW = "The table below has the numbers."
_AS_COMPUTED = "Critical velocity as computed"
_NARROW = 0.075  # width of figures on a telephone [m]

Conditions = Mapping[str, Any]


class Grid(NamedTuple):
    """A table of a page; the row number `bold` stands out."""

    caption: str
    heads: list[str]
    rows: list[list[str]]
    bold: int = -1


class Picture(NamedTuple):
    """A figure of a page, for usual and for narrow screens, as addresses that hold all data."""

    usual: str
    narrow: str
    alt: str
    caption: str


Section = tuple[str, list[str | Grid | Picture | list[str]]]
"""Heading of a section, and its parts; several strings are a list."""


class Answer(NamedTuple):
    """Headline with its verdict, sentences below it, and the sections that belong to it."""

    verdict: str
    headline: str
    answer: list[str]
    sections: list[Section]


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
        Title of the report, by default that of the scene; who has written it.
    command : str, optional
        Command that wrote the report, to be stated in it.
    **conditions
        Conditions to judge by, as in `pipeline.margin`, such as ``friction=0.12``.

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
    asked = {"load": points} if load is None else {"load": load, "velocity": velocity}
    is_plane, found = {*PLANE} <= {*ds["status"].dims}, None
    if load is not None or points is not None or not is_plane:
        found = pipeline.margin(ds, **asked, **conditions)
    if found is None:
        answer = _of_boundary(ds, conditions)
    elif not found.sizes:
        answer = _of_point(ds, conditions, found)
    else:
        answer = _of_rows(ds, conditions, found)
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
        about=[*[sweep.title] * bool(title), ", ".join(filter(None, (date, author)))],
        author=author,
        version=version,
        command=command,
        style=css,
        digest=f"sha256-{base64.b64encode(hashlib.sha256(css.encode()).digest()).decode()}",
        sections=[*answer.sections, *_common(ds, conditions, version, answer.answer)],
    )
    page = page.encode(errors="replace").decode()  # a shell may give bytes that are no text
    return page if path is None else write_text(page, path)


def _of_boundary(ds: xr.Dataset, conditions: Conditions) -> Answer:
    """The boundary of a plane, without an operating point."""
    found = pipeline.boundary(ds, **conditions)
    is_one = found["critical_velocity"].ndim == 1
    said = [words.next_run_line(found)] * is_one + [*words.not_included_lines(found)]
    headline = "Boundary between mild and severe wear"
    return Answer("", headline, [*map(_as_sentence, said)], _plane(ds, conditions))


def _of_point(ds: xr.Dataset, conditions: Conditions, here: xr.Dataset) -> Answer:
    """The verdict on one operating point."""
    verdict, reason = here["verdict"].item(), here["reason"].item()
    if verdict not in HEADLINES:
        raise InputError(reason)
    place = here["load"].item(), here["velocity"].item()
    facts, decider = dict(words.margin_facts(here)), words.to_decide(here)
    said = [_verdict(here), *words.not_included_lines(here)]
    if "critical velocity" in facts:
        said.append(f"critical velocity at {place[0]:.4g} N: {facts['critical velocity']}")
    said += [f"The verdict is withheld: {reason}"] * bool(reason)
    said += [f"To decide it, {decider}"] * bool(decider)
    said += _without_help(words.common_lines(here))
    rows = [*map(list, facts.items())]
    table = Grid("The operating point in numbers", ["quantity", "value"], rows)
    warned = [*words.margin_warnings(here)]
    first, *others = _plane(ds, conditions, [place])
    sections: list[Section] = [first, ("Operating point", [table, *[warned] * bool(warned)])]
    headline = f"{HEADLINES[verdict]} at {place[0]:.4g} N and {place[1]:.4g} m/s"
    lines = [*map(_as_sentence, said)]
    return Answer(words.verdict_text(here), headline, lines, [*sections, *others])


def _of_rows(ds: xr.Dataset, conditions: Conditions, found: xr.Dataset) -> Answer:
    """The verdicts on a table of operating points, or on the rows of the sweep."""
    if len(found.sizes) > 1:
        refuse_cases(ds)
        raise InputError(f"a report has rows along one dimension, not along {[*found.sizes]}")
    (row,) = found.sizes
    decides, names = deciding_row(found), words.row_labels(found, str(row))
    codes, verdicts = found["verdict"].values.tolist(), words.code_text(found["verdict"]).tolist()
    verdict, critical = verdicts[decides], f"the most critical operating point: {names[decides]}"
    headline = f"{HEADLINES.get(codes[decides], 'Unknown')} at {critical}"
    judged = sum(one in (MILD, UNDECIDED, SEVERE) for one in codes)
    if codes[decides] == MILD and judged < len(codes):  # the others may be severe
        headline = f"{judged} of {len(codes)} operating points have a verdict; mild at {critical}"
        verdict = ""
    caption = "Temperature margin of each row: critical minus governing temperature."
    picture = picture_of(lambda: draw_rows(found, ""), caption, f"{caption} {_BELOW}")
    grid = _table_of(margin_frame(found), "Operating points; the deciding one is bold", decides)
    notes = [
        *words.conditions_lines(found), *words.not_included_lines(found),
        *words.reason_lines(found), *words.row_warnings(found), *words.common_lines(found),
    ]  # fmt: skip
    notes = [*map(_as_sentence, _without_help(notes))]
    sections: list[Section] = [("Operating points", [picture, grid, notes])]
    if {*PLANE} <= {*ds["status"].dims}:
        places = xr.broadcast(found["load"], found["velocity"])
        each = (one.values.ravel().tolist() for one in places)
        sections += _plane(ds, conditions, dict.fromkeys(zip(*each, strict=True)))
    else:
        sections.append(("Errors", [_errors(words.model_error_line(found))]))
    numbers = ", ".join(f"{number} {one}" for one, number in Counter(verdicts).items())
    said = [f"Operating points: {numbers}", *words.not_included_lines(found)]
    if codes[decides] in HEADLINES:
        said.insert(0, _verdict(found.isel({row: decides})))
    return Answer(verdict, headline, [*map(_as_sentence, said)], sections)


def _verdict(here: xr.Dataset) -> str:
    """The sentence on one operating point, whose verdict the headline has."""
    verdict, _, rest = words.headline(here).partition(": ")
    begins = "probability of severe wear "
    return (rest or verdict).replace(begins, f"the {begins}is ", 1)


def _plane(
    ds: xr.Dataset, conditions: Conditions, places: Iterable[OperatingPoint] = ()
) -> list[Section]:
    """Sections with the diagram, the boundary, tests beside what is computed, and errors."""
    found = pipeline.boundary(ds, **conditions)
    ends = [ds[axis].values[[0, -1]].tolist() for axis in PLANE]
    within = [
        place
        for place in places
        if all(low <= at <= high for at, (low, high) in zip(place, ends, strict=True))
    ]
    caption = _as_sentence(words.conditions_lines(found)[0])
    caption += " Dots: simulated points." * (not case_dims(ds))
    if missing := found.attrs["missing_points"]:
        caption += f" ×: {missing} points that are pending or failed."
    loads, velocities = ([place[axis] for place in within] for axis in (0, 1))
    picture = picture_of(
        lambda: diagram(ds, conditions, load=loads, velocity=velocities), caption,
        f"Transition diagram over sliding velocity and normal load. {_BELOW}",
    )  # fmt: skip
    title, needless = f"{_AS_COMPUTED}; with tests: where severe wear is 5, 50, 95 % probable", []
    if not found.attrs.get("tests", 1):  # a coordinate where cases differ in it
        title = f"{_AS_COMPUTED}, and where severe wear is 5 and 95 % probable"
        needless.append("with tests, 50 % [m/s]")
    crosses = bool(found["critical_velocity"].notnull().all())
    is_plain = crosses and len({*found["outcome_along_velocity"].values.ravel()}) == 1
    needless += ["outcome"] * is_plain
    grid = _table_of(without_columns(boundary_frame(found), needless), title)
    sections: list[Section] = [("Transition diagram", [picture]), ("Boundary", [grid])]
    if found.attrs.get("tests") and not case_dims(ds):
        sections.append(("Tests and prediction", [*_tests(ds, conditions)]))
    lines = _errors(*words.error_lines(found), *words.shift_lines(found))
    return [*sections, ("Errors", [lines])]


def _errors(*lines: str) -> list[str]:
    """Sentences on errors: how large each is, and where it comes from."""
    origins = {"numerical": f" {_NUMERICAL}.", "model error": f" {_OF_MODEL}."}
    return [
        _as_sentence(line)
        + "".join(text for begin, text in origins.items() if line.startswith(begin))
        for line in lines
    ]


def _tests(ds: xr.Dataset, conditions: Conditions) -> Iterator[Picture | Grid | list[str]]:
    """Yield tests beside what is computed for them."""
    found = pipeline.compare_tests(ds, **conditions)
    caption = "Computed rise ratio of each test, next to its outcome."
    yield picture_of(lambda: draw_tests(ds, conditions), caption, f"{caption} {_BELOW}")
    table = answer_frame(found, *(name for name in map(str, found) if name not in _DRAWN))
    y = found["log_rise_ratio"].values
    computed = ["" if math.isnan(one) else "severe" if one > 0 else "mild" for one in y]
    table.insert(2, "computed", computed)
    yield _table_of(table, "Tests, each at its own conditions, and what is computed for them")
    if lines := [*words.test_lines(found)]:
        yield lines


def _common(
    ds: xr.Dataset, conditions: Conditions, version: str, said: Sequence[str]
) -> Iterator[Section]:
    """Yield the sections that each report ends with: inputs, limits beyond those `said`, origin."""
    sweep = sweep_of(ds)
    rows = dict[str, list[str]]()
    for path, value in flat(tomllib.loads(ds.attrs.get("scene", ""))):
        if not (path.startswith(_NO_INPUTS) or dimension_of(path) in ds.coords):
            is_material = path.startswith("materials")
            table = path.rpartition(".")[0] if is_material else path.partition(".")[0]
            name = path.removeprefix(f"{table}.").replace("_", " ").replace(".", " ")
            rows.setdefault(table, []).append(f"{name} {_text_of(value)}")
    cells = [[table, "; ".join(texts), "scene"] for table, texts in rows.items()]
    cells += [[*text.split(": ", 1), source] for text, source in library_tables(sweep.sources)]
    inputs = Grid("Inputs, and where each comes from", ["part", "values", "source"], cells)
    yield "Conditions and inputs", [inputs]
    single = {name: value for name, value in conditions.items() if not np.ndim(value)}
    notes = split_notes(words.attribute_texts(pipeline.points(ds, **single), "notes"))
    limits = _without_help([*notes, *pipeline.points_with_warnings(ds).lines()])
    others = [line for line in map(_as_sentence, limits) if line not in said]
    yield "What is not covered", [_MODEL, *[others] * bool(others)]
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


def _text_of(value: Any) -> str:
    return ", ".join(map(_text_of, value)) if isinstance(value, list) else str(value)


def _without_help(lines: Iterable[str]) -> list[str]:
    """Lines without references to pages of help, which a reader of the report may not have."""
    return [re.sub(r" \(irg help [\w-]+\)", "", line) for line in lines]


def _as_sentence(line: str) -> str:
    """Line of an answer with a capital letter and a full stop."""
    return f"{line[:1].upper()}{line[1:]}" + "." * (not line.endswith("."))


def _table_of(frame: pd.DataFrame, caption: str, bold: int = -1) -> Grid:
    """Table with the values of a data frame; the row number `bold` stands out."""
    frame = without_columns(frame.replace("", None))
    heads = [str(head).replace("_", " ") for head in frame]
    return Grid(caption, heads, cells_of(frame, "–", digits=3), bold)


def picture_of(draw: Callable[[], Figure], caption: str, alt: str) -> Picture:
    """Draw a figure twice, for usual and for narrow screens."""
    drawn = []
    for width in (None, _NARROW):
        with style.fitted(width, plain=True):
            written = io.BytesIO()
            draw().savefig(written, format="svg", metadata={"Date": None})
        text = base64.b64encode(written.getvalue()).decode()
        drawn.append(f"data:image/svg+xml;base64,{text}")
    return Picture(drawn[0], drawn[1], alt, caption)
