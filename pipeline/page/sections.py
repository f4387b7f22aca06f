"""Sections of a page: the answer first, then operating points, tests, inputs and origin."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime

import numpy as np
import pandas as pd

from pipeline.analysis.boundary import boundary
from pipeline.analysis.caveats import caveats_of
from pipeline.analysis.dataset import Layout
from pipeline.analysis.film import OUTSIDE_WORDS, is_outside
from pipeline.analysis.judge import judge_of
from pipeline.analysis.margin_frame import LONG, counts_in_words, margin
from pipeline.analysis.results import Results
from pipeline.analysis.rises import rises_of
from pipeline.analysis.tables import frame_of, html_of, notes_of, short
from pipeline.analysis.tested import test_parts
from pipeline.analysis.until import Until, changes_frame
from pipeline.analysis.warned_points import warned
from pipeline.analysis.words import boundary_lines, condition_lines, in_words, next_run_line
from pipeline.scene.along import OperatingPoints
from pipeline.scene.reference import all_keys
from pipeline.scene.written import scene_entries
from pipeline.store.versions import package_versions
from pipeline.sweep.condition_words import judged_by
from pipeline.sweep.laws import LawError
from pipeline.sweep.model import digest
from pipeline.sweep.surface import surface_words
from pipeline.sweep.variants import dimension_of
from tribo import InputError

_MODEL = (
    "model: a rough, elastic-plastic contact under boundary lubrication is worn by Archard's law "
    "while the load grows, and heated by friction. A film that carries load, and the wear after "
    "the transition, are not part of it"
)
_CLOSED = "Inputs", "Origin"  # sections that are closed at first on a screen


def sections(data: Results, points: OperatingPoints | None) -> dict[str, str]:
    """HTML of each section of the page on one scene, by name of the section.

    `points` are operating points whose margins are shown, or None.
    """
    has_places = points is not None or data.kind is Layout.PLACES
    caveats = *_film_lines(data), *caveats_of(data)
    return {
        "answer": _section("Answer", _answer(data)),
        "caveats": "".join(f"<li>{_plain(line)}</li>" for line in caveats),
        "duties": _section("Operating points", _margins(data, points)) if has_places else "",
        "tests": _section("Tests", _tests(data)),
        "inputs": _section("Inputs", _inputs(data)),
        "origin": _section("Origin", _origin(data)),
    }


def _film_lines(data: Results) -> Iterator[str]:
    """Yield a line if a film carries too much at a point of the plane, with the lowest velocity."""
    if data.kind is not Layout.PLANE or data.conditions.critical_temperature is None:
        return
    rises = rises_of(data)
    places = [axis.ravel() for axis in np.meshgrid(rises.loads, rises.velocities, indexing="ij")]
    outside = is_outside(rises, *places)
    if outside.any():
        first = places[1][outside].min()
        yield f"{OUTSIDE_WORDS}, from {first:.3g} m/s on, at the scene's own temperatures"


def _section(heading: str, parts: Iterable[str | pd.DataFrame]) -> str:
    """HTML of a section with its heading and `parts`; empty without parts.

    If a part raises an `InputError`, the section ends with the reason.
    """
    body = list[str]()
    try:
        body.extend(map(_html, parts))
    except LawError:
        raise  # without the code of the user's law there is no answer at all
    except InputError as error:
        body.append(_html(f"not known: {error}"))
    is_open = "" if heading in _CLOSED else " open"
    summary = f"<summary><h2>{heading}</h2></summary>"
    return f"<details{is_open}>{summary}{''.join(body)}</details>" if body else ""


def _html(part: str | pd.DataFrame) -> str:
    """A sentence or a table as HTML."""
    if isinstance(part, pd.DataFrame):
        return f'<div class="table wide">{html_of(part)}</div>'
    return f"<p>{_plain(part[:1].upper() + part[1:].rstrip('.'))}.</p>"


def _plain(line: str) -> str:
    """A sentence as HTML, without the command that prints a page: a reader may not have it."""
    return html.escape(re.sub(r" \(irg help [\w-]+\)", "", line))


def _answer(data: Results) -> Iterator[str]:
    """Yield sentences on the criterion of severe wear and a further run, then warnings."""
    if data.conditions.critical_temperature is None:
        yield "not known: the scene has no critical temperature"
        return
    yield judged_by((one.conditions for one in data.scenes), data.told_tests)
    if data.kind is Layout.PLACES:
        yield counts_in_words(margin(data))
    else:
        yield next_run_line(found := boundary(data))
        yield from boundary_lines(found)
    yield from warned(data).lines()


def _margins(data: Results, points: OperatingPoints | None) -> Iterator[str | pd.DataFrame]:
    """Yield the table of margins of operating points, and notes on its rows."""
    table = margin(data, points)
    yield from condition_lines(table["conditions"].dropna())
    yield f"in total {counts_in_words(table, points)}"
    yield short(in_words(table), LONG)
    yield from notes_of(table, caveats_of(data))
    yield from filter(None, (points.counted, *points.remarks)) if points else ()
    if table["velocity factor"].notna().any():
        yield "factor: the velocity or load at which wear turns severe, divided by that of the row"
    if data.kind is Layout.PLANE:
        yield from _until_mild(data, table)


def _until_mild(data: Results, table: pd.DataFrame) -> Iterator[str | pd.DataFrame]:
    """Yield what would make the operating point that is most likely severe mild, if one is not."""
    likely = table["probability"].where(table["verdict"].isin(["severe", "not decided"]))
    if likely.isna().all():
        return
    load, velocity = table.loc[likely.idxmax(), ["load [N]", "velocity [m/s]"]]
    if changes := Until(judge_of(data), load, velocity, "mild").judged_changes():
        yield f"{load:.4g} N, {velocity:.4g} m/s would be mild if one of these changed"
        yield changes_frame(changes).drop(columns="basis")


def _tests(data: Results) -> Iterator[str | pd.DataFrame]:
    """Yield the tests at their own conditions; nothing if there are none, or without a plane."""
    if data.kind is Layout.PLANE and data.sweep.tests:
        yield from test_parts(judge_of(data).evidence)


def _inputs(data: Results) -> Iterator[str | pd.DataFrame]:
    """Yield tables of the scene's entries and library values, and the numerical choices."""
    sweep = data.sweep
    entries, meanings = scene_entries(sweep), {key: one.meaning for key, one in all_keys()}
    if surface := surface_words(sweep):
        yield f"surface of the disk: {surface.replace('disk.roughness.file: ', '')}"
    spreads = {one.path: one.text for one in sweep.inputs}
    rows = [
        (path, text, spreads.get(path, ""), _first_sentence(meanings.get(_key_of(path), "")))
        for path, text in entries.items()
        if not path.startswith(("fidelity", "measured", "tested", "uncertainty"))
        and dimension_of(path) not in data.rows.coords
    ]
    heads = ("entry", "value", "standard uncertainty", "meaning")
    kept = [0, 1, *[2] * bool(spreads), 3]
    yield frame_of([heads[k] for k in kept], ([row[k] for k in kept] for row in rows))
    if library := sweep.sources:
        yield frame_of(("from the library", "value", "source"), library)
    prefix = "fidelity."
    choices = (
        f"{path.removeprefix(prefix)} {text}"
        for path, text in entries.items()
        if path.startswith(prefix)
    )
    yield f"numerical choices: {', '.join(choices)}"


def _key_of(path: str) -> str:
    """Path of an entry as written in the reference, where NAME stands for a material's name."""
    return re.sub(r"^materials\.[^.]+|^(pin|disk)\.material(?=\.)", "materials.NAME", path)


def _first_sentence(meaning: str) -> str:
    return meaning.split(";")[0].split(". ")[0].rstrip(".").replace("`", "")


def _origin(data: Results) -> Iterator[str]:
    """Yield sentences on the model, program and scene used, and how to cite them."""
    sweep = data.sweep
    yield _MODEL
    yield from str(data.rest.attrs.get("history", "")).splitlines()
    yield f"scene {sweep.name}, {digest(sweep.scene)} (SHA-256 of its inputs)"
    yield f"written at {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    yield from citation()


def citation() -> Iterator[str]:
    """Yield references to the program, and to Bosman & de Rooij's paper, on which it is based."""
    version = package_versions()["irg-transition"]
    yield f"The irg-transition developers: irg-transition (version {version}). BSD-3-Clause."
    yield (
        "R. Bosman and M. B. de Rooij: On the transition from mild to severe wear of lubricated, "
        "concentrated contacts: The IRG (OECD) transition diagram."
    )
