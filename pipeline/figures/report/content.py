"""Content of a report, as plain HTML."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import UTC, datetime
from importlib import resources
from typing import Any, TypeAlias

import pandas as pd
import xarray as xr
import yaml
from matplotlib.figure import Figure

from pipeline.analysis.boundary import boundary
from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.dataset import (
    asked,
    attributes_of,
    entry_dims,
    has_plane,
    is_emulated,
    variant_of,
)
from pipeline.analysis.difference import entries_of
from pipeline.analysis.frames import JUDGED, agreement, compared, frames_of
from pipeline.analysis.margins import LONG, in_counts, margin_table, notes_of
from pipeline.analysis.scenes import parts_of, scenes, words
from pipeline.analysis.tables import frame_of, html_of, short
from pipeline.analysis.transition import CROSSES, outcomes
from pipeline.analysis.warned_points import warned
from pipeline.figures.diagram import diagram
from pipeline.figures.style import criterion, fitted, heating, svg_of
from pipeline.scene.along import OperatingPoints
from pipeline.scene.reference import meanings
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.about import on_plane
from pipeline.sweep.own_laws import OwnLawError
from pipeline.sweep.selection import error_in_words
from tribo import InputError

Part: TypeAlias = str | pd.DataFrame | Figure
"""A paragraph, a table or a picture of a section."""

_MODEL = (
    "A rough, elastic-plastic contact under boundary lubrication is worn by Archard's law while "
    "the load grows, and heated by friction; after Bosman and de Rooij. A lubricating film that "
    "carries load, and the wear after the transition, are not part of it."
)


def content(ds: xr.Dataset, points: OperatingPoints | None, conditions: Mapping[str, Any]) -> str:
    """Body of a report as HTML: headings, paragraphs, tables and a picture."""
    attributes = attributes_of(ds)
    title = attributes.get("title") or attributes.get("name") or "Transition diagram"

    def drawn() -> list[Part]:
        return [fitted(diagram(ds, **conditions), 0.17, with_title=False)]

    answers: dict[str, Callable[[], Iterable[Part]]] = {
        "Question and answer": lambda: _question(ds, conditions),
        "Transition diagram": drawn,
        "Boundary in numbers": lambda: _numbers(ds, conditions),
    }
    if not (has_plane(ds) or is_emulated(ds)):
        answers = {
            "Question and answer": lambda: _question_of_rows(ds, conditions),
            "Margins by row": drawn,
        }
    sections = answers | {
        "Tests": lambda: _tests(ds, conditions),
        "Operating points": lambda: _operating_points(ds, points, conditions),
        "Warnings": lambda: _warnings(ds, conditions),
        "Inputs": lambda: _inputs(attributes),
        "Numerical choices and their error": lambda: _fidelity(attributes),
        "Model": lambda: [_MODEL],
        "Versions": lambda: _versions(attributes),
        "Citation": citation,
    }
    if is_emulated(ds):
        from pipeline.figures.report.samples import sections as of_samples  # with its libraries

        sections |= of_samples(ds, points, conditions)
    parts = [f"<h1>{html.escape(str(title))}</h1>"]
    for heading, write in sections.items():
        if body := [_html(part, heading) for part in _or_reason(write)]:
            parts += [f"<h2>{heading}</h2>", *body]
    return "\n".join(parts)


def _or_reason(write: Callable[[], Iterable[Part]]) -> list[Part]:
    """Parts of a section, and the reason for which the sweep has no more."""
    parts: list[Part] = []
    try:
        parts.extend(write())
    except OwnLawError:
        raise  # for a report without its answers is none
    except InputError as error:
        parts.append(f"Not in this report: {error}.")
    return parts


def _html(part: Part, heading: str) -> str:
    """A table, a paragraph or a figure of a section as HTML."""
    if isinstance(part, pd.DataFrame):
        return html_of(part)
    if isinstance(part, str):
        return f"<p>{html.escape(part)}</p>"
    return f'<figure role="img" aria-label="{heading}">{svg_of(part)}</figure>'


def _question(ds: xr.Dataset, changed: Mapping[str, Any]) -> Iterator[Part]:
    """Question that the sweep answers, its answer in a sentence, and the state of the sweep."""
    attributes = attributes_of(ds)
    loads, velocities = (attributes.get(name) or [] for name in ("loads", "velocities"))
    plane = on_plane(loads, velocities)[1] if loads and velocities else "the points computed"
    yield (
        "At which load and sliding velocity does wear of this lubricated contact turn from mild "
        f"to severe adhesive wear (scuffing)? Examined: {plane}."
    )
    total = int(asked(ds).sum())
    done, failed = (int((asked(ds) & (ds["status"] == code)).sum()) for code in (DONE, FAILED))
    if done < total:
        yield (
            f"The sweep is not finished: {done} of {total} points are done, {failed} failed. "
            "What follows rests on those that are done."
        )
    boundaries = boundary(ds, **changed)
    for judged in dict.fromkeys(conditions_of(scene, **changed) for scene in scenes(ds)):
        yield f"Wear is taken as severe with {criterion(judged)}, at {heating(judged)}."
    for values, part in parts_of(boundaries):
        entries = words(ds, dict(zip(entry_dims(ds), values, strict=True)))
        yield f"{entries}. {_answer(part)}" if entries else _answer(part)


def _question_of_rows(ds: xr.Dataset, changed: Mapping[str, Any]) -> Iterator[Part]:
    """Question that rows with places of their own answer, and the answer in a sentence."""
    table = margin_table(ds, **changed)
    yield (
        "Is wear of this lubricated contact mild, or is it severe adhesive wear (scuffing)? "
        f"Examined: {len(table)} places, each with a load, a velocity and entries of its own."
    )
    for judged in dict.fromkeys(conditions_of(scene, **changed) for scene in scenes(ds)):
        yield f"Wear is taken as severe with {criterion(judged)}, at {heating(judged)}."
    yield f"Answer: {in_counts(table)}."


def _answer(boundaries: xr.Dataset) -> str:
    """Velocities at which wear turns severe at the lowest and the highest load."""
    axis = variant_of(boundaries)
    velocities = boundaries["critical_velocity"]
    crosses = boundaries["outcome_at_load"] == CROSSES
    if axis:
        velocities, crosses = velocities.median(axis), crosses.all(axis)
    crossings = velocities.where(crosses, drop=True)
    if not crossings.size:
        codes = sorted(set(boundaries["outcome_at_load"].values.ravel().tolist()))
        words = " or ".join(outcomes("velocity")[code] for code in codes)
        return f"Answer: no transition is known among the points computed: {words}."
    places = [crossings[0], crossings[-1]] if crossings.size > 1 else [crossings[0]]
    text = " and ".join(
        f"from {float(place):.3g} m/s on at {float(place['load']):g} N" for place in places
    )
    median = f", the median of {boundaries.sizes[axis]} surfaces" if axis else ""
    return f"Answer: wear is severe {text}{median}."


def _numbers(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Iterator[Part]:
    """Tables of the boundary."""
    boundaries = boundary(ds, **conditions)
    yield from (short(frame, JUDGED.values()) for frame in frames_of(boundaries))
    if missing := sum(part.attrs["missing_points"] for _, part in parts_of(boundaries)):
        yield f"{missing} points are pending or failed and were left out."
    if "film_parameter_at_load" in boundaries:
        yield (
            "Film Λ is the minimum film over Rq at the bulk temperature: below 1 boundary "
            "lubrication, below 3 mixed, above it a full film, which the model does not have."
        )


def _operating_points(
    ds: xr.Dataset, points: OperatingPoints | None, conditions: Mapping[str, Any]
) -> Iterator[Part]:
    """Margins of operating points."""
    table = margin_table(ds, points, **conditions)
    if table.empty:
        return
    yield short(table, LONG)
    yield from (f"{note}." for note in notes_of(table))
    yield (
        "A factor is the critical velocity or load over that of the point: wear turns severe at so "
        "many times its velocity, or its load. Where there is none, the sweep has no transition."
    )


def _warnings(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Iterator[Part]:
    """Warnings by kind, with counts."""
    warnings = warned(ds, **conditions)
    if not warnings.points:
        yield "No computed point carries a warning."
        return
    yield frame_of(("kind", "points"), warnings.kinds.items())
    total = int((ds["status"] == DONE).sum())
    beside = (
        "" if warnings.at_boundary is None else f", {warnings.at_boundary} of them at the boundary"
    )
    yield f"{warnings.points} of {total} points carry a warning{beside}."
    yield f"For example {warnings.example}"


def _inputs(attributes: Mapping[str, Any]) -> Iterator[Part]:
    """Entries of the scene with their units, and the sources of those of the library."""
    if surface := attributes.get("surface"):
        yield f"Surface of the disk: {surface.replace('disk.roughness.file: ', '')}."
    rows = (
        (path, text, _meaning(path))
        for path, text in entries_of(attributes).items()
        if not path.startswith(("fidelity", "measured", "tested"))
    )
    yield frame_of(("entry", "value", "meaning"), rows)
    library = attributes.get("library") or []
    origin = "other values" if library else "all values"
    if library:
        yield frame_of(
            ("from the library", "value", "source"),
            ((entry["key"], entry["value"], entry["source"]) for entry in library),
        )
    yield f"Source: {origin} from the scene {attributes.get('name')}.toml."


def _tests(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Iterator[Part]:
    """Tests of the laboratory beside what is computed at their own conditions."""
    table = compared(ds, **conditions)
    if table is None:
        return
    yield agreement(table)
    yield short(table, ["note"])
    yield (
        "Each is computed at its own friction and bulk temperature. A transition agrees within two "
        "standard deviations of its velocity (5 % each if it gives none); a test agrees if its "
        "outcome is the computed one beyond the error of the temperature."
    )
    yield from (f"{note}." for note in notes_of(table))


def _meaning(path: str) -> str:
    """First sentence on an entry, of the reference of the scene."""
    for body in ("pin", "disk"):
        path = path.replace(f"{body}.material.", "materials.NAME.")
    return meanings().get(path, "").split(";")[0].split(". ")[0].rstrip(".").replace("`", "")


def _fidelity(attributes: Mapping[str, Any]) -> Iterator[Part]:
    """Numerical choices, and the error of the boundary that they bring."""
    words = error_in_words(attributes)
    yield f"{words[0].upper()}{words[1:]}."
    choices = entries_of({"scene": {"fidelity": (attributes.get("scene") or {}).get("fidelity")}})
    rows = ((path.removeprefix("fidelity."), text) for path, text in choices.items())
    yield frame_of(("choice", "value"), rows)


def _versions(attributes: Mapping[str, Any]) -> Iterator[Part]:
    """Programs that computed the store, and the identity of its scene."""
    yield from str(attributes.get("history") or "").splitlines()
    yield f"Scene {attributes.get('scene_hash')} (SHA-256 of its inputs)."
    yield f"This report was written at {datetime.now(UTC):%Y-%m-%d %H:%M} UTC."


_FILE = "CITATION.cff"


def citation() -> Iterator[str]:
    """References to the program and to the works that it builds on, a line each.

    Examples
    --------
    >>> next(citation())  # doctest: +ELLIPSIS
    'The irg-transition developers: irg-transition (version ...). BSD-3-Clause.'
    """
    package = resources.files("pipeline")
    file = package / _FILE  # in a wheel; in a checkout it is beside the package
    if not file.is_file():
        file = package / ".." / _FILE
    entry = yaml.safe_load(file.read_text(encoding="utf-8"))
    yield _line(entry)
    yield from map(_line, entry.get("references", []))


def _line(entry: Mapping[str, Any]) -> str:
    """One reference."""
    names = [author.get("name") or author.get("family-names") for author in entry["authors"]]
    people = " and ".join(", ".join(names).rsplit(", ", 1)) if len(names) > 1 else names[0]
    version = f" (version {entry['version']})" if "version" in entry else ""
    details = [f"{entry[key]}" for key in ("journal", "volume", "year", "doi", "url", "license")
               if key in entry]  # fmt: skip
    return ". ".join([f"{people}: {entry['title']}{version}", *details]) + "."
