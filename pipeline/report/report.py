"""Report of a sweep for readers without the tool: one HTML file, which a browser prints."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from pipeline import extras
from pipeline.analysis import dataset
from pipeline.analysis.boundary import boundary
from pipeline.analysis.frames import boundary_parts
from pipeline.analysis.laboratory import compared, test_parts
from pipeline.analysis.margin_frame import LONG, counts_in_words, margin
from pipeline.analysis.scenes import caveats_of, parts_of, scenes, value_text
from pipeline.analysis.tables import (
    frame_of,
    html_of,
    notes_of,
    short,
    writable_path,
    write_text,
)
from pipeline.analysis.transition import CROSSES, outcomes, severe_ranges
from pipeline.analysis.warned_points import warned
from pipeline.figures.diagram import diagram
from pipeline.figures.style import fit_to_width, svg_of
from pipeline.scene.along import OperatingPoints
from pipeline.scene.reference import all_keys
from pipeline.scene.written import scene_entries
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE, FAILED
from pipeline.store.versions import package_versions
from pipeline.sweep.about import judged_by, plane_rows
from pipeline.sweep.digest import digest
from pipeline.sweep.laws import LawError
from pipeline.sweep.model import Sweep
from pipeline.sweep.surface import surface_words
from tribo import InputError

Part: TypeAlias = str | pd.DataFrame | Figure
"""A paragraph, a table or a picture of a section."""
Sections: TypeAlias = dict[str, Iterable[Part]]
"""Parts of each section by its heading, computed when they are read."""

_QUESTION = (
    "At which load and sliding velocity does wear of this lubricated contact turn from mild to "
    "severe adhesive wear (scuffing)"
)
_MOST_VALUES = 12  # values of an entry that are listed
_LISTED = 6  # loads, likewise
_TURNING = {CROSSES: "severe from some velocity on"}
_MODEL = (
    "A rough, elastic-plastic contact under boundary lubrication is worn by Archard's law while "
    "the load grows, and heated by friction; after Bosman and de Rooij. A lubricating film that "
    "carries load, and the wear after the transition, are not part of it."
)


@np.errstate(under="ignore")
def report(
    ds: xr.Dataset | PathLike,
    out: str | Path,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]] | None = None,
) -> Path:
    """Write a report of a sweep, for people without the tool: one file of HTML.

    It holds the question and its answer, the diagram, the boundary in numbers, the margins of
    operating points, warnings, inputs with their units and sources, numerical choices and their
    error, versions, and how to cite.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or the path of a store.
    out : str or path
        File to write, .html; a browser prints it on A4 or to PDF.
    points : path or mapping of str to sequence, optional
        Operating points whose margins to tell; see `pipeline.margin`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the suffix is another one, the file cannot be written, or the operating points or
        conditions are faulty.

    Examples
    --------
    >>> import pipeline
    >>> points = {"load": ["500 N"], "velocity": ["1.6 m/s"]}
    >>> pipeline.report("results/first_try.zarr", "results/report.html", points).name
    'report.html'
    """
    path = writable_path(out, (".html",))
    if points is not None and not isinstance(points, OperatingPoints):
        points = OperatingPoints.read(points)
    ds = dataset.dataset_of(ds)
    title = dataset.stored_sweep(ds).about.title
    template = resources.files(__package__).joinpath("report.html").read_text("utf-8")
    parts = {"title": html.escape(title), "body": body_of(ds, points)}
    return write_text(Template(template).substitute(parts), path)


def body_of(ds: xr.Dataset, points: OperatingPoints | None) -> str:
    """Headings, paragraphs, tables and a picture, as HTML."""
    sweep = dataset.stored_sweep(ds)
    if dataset.sweep_kind(ds) is dataset.Kind.SAMPLES:
        answers = sections_of_samples(ds, points)
    else:
        answers = _sections_of_points(ds, points)
    sections: Sections = answers | {
        "Warnings": _warnings(ds),
        "Inputs": _inputs(ds, sweep),
        "Numerical choices": _fidelity(sweep),
        "Model": [_MODEL],
        "Versions": _versions(ds, sweep),
        "Citation": citation(),
    }
    parts = [f"<h1>{html.escape(sweep.about.title)}</h1>"]
    parts += [f"<p>{html.escape(one)}</p>" for one in caveats_of(ds)]
    for heading, section in sections.items():
        if body := [_html(part, heading) for part in _or_reason(section)]:
            parts += [f"<h2>{heading}</h2>", *body]
    return "\n".join(parts)


def _sections_of_points(ds: xr.Dataset, points: OperatingPoints | None) -> Sections:
    """Answers of a plane by its boundary, or of rows by their margins."""
    given = _operating_points(ds, points)
    if dataset.sweep_kind(ds) is dataset.Kind.PLACES:
        return {
            "Question and answer": _question_of_rows(ds),
            "Margins by row": _drawn(ds),
            "Operating points": given,
        }
    return {
        "Question and answer": _question(ds),
        "Transition diagram": _drawn(ds),
        "Boundary in numbers": _numbers(ds),
        "Tests": _tests(ds),
        "Operating points": given if points else [],
    }


def _drawn(ds: xr.Dataset) -> Iterator[Part]:
    yield fit_to_width(diagram(ds), 0.17, with_title=False)


def _or_reason(section: Iterable[Part]) -> list[Part]:
    """Parts of a section, and the reason for which the sweep has no more."""
    parts: list[Part] = []
    try:
        parts.extend(section)
    except LawError:
        raise  # for a report without its answers is none
    except InputError as error:
        parts.append(f"Not in this report: {error}")
    return parts


def _html(part: Part, heading: str) -> str:
    """A table, a sentence or a figure of a section as HTML."""
    if isinstance(part, pd.DataFrame):
        return html_of(part)
    if isinstance(part, str):
        return f"<p>{html.escape(part[:1].upper() + part[1:].rstrip('.'))}.</p>"
    return f'<figure role="img" aria-label="{heading}">{svg_of(part)}</figure>'


def _question(ds: xr.Dataset) -> Iterator[Part]:
    """Question that the sweep answers, its answer in a sentence, and the state of the sweep."""
    plane = dataset.stored_sweep(ds).plane
    yield f"{_QUESTION}? Examined: {plane_rows(plane.loads, plane.velocities)[1]}"
    total = int(dataset.asked(ds).sum())
    done, failed = (
        int((dataset.asked(ds) & (ds["status"] == code)).sum()) for code in (DONE, FAILED)
    )
    if done < total:
        yield (
            f"The sweep is not finished: {done} of {total} points are done, {failed} failed. "
            "What follows rests on those that are done."
        )
    boundaries = boundary(ds)
    yield judged_by(dataset.read_conditions(scene) for scene in scenes(ds))
    for entries, part in parts_of(boundaries):
        yield f"Answer{entries and ' for '}{entries}: {_answer(part)}"


def _question_of_rows(ds: xr.Dataset) -> Iterator[Part]:
    """Question that rows answer, each at its own place, and the answer in a sentence."""
    table = margin(ds)
    yield (
        "Is wear of this lubricated contact mild, or is it severe adhesive wear (scuffing)? "
        f"Examined: {len(table)} places, each with its own load, velocity and entries."
    )
    yield judged_by(dataset.read_conditions(scene) for scene in scenes(ds))
    yield f"Answer: {counts_in_words(table)}"


def _answer(boundaries: xr.Dataset) -> str:
    """Where wear is severe at the lowest and the highest load with a turn, and at all others."""
    is_band = "realization" in boundaries.dims
    turns, begins = boundaries["turns_at_load"], boundaries["begins_severe_at_load"]
    if is_band:
        turns = boundaries["critical_velocity_quantile"].sel(quantile=[0.5])
    turns = turns.dropna("load", how="all")
    loads = turns["load"].values.tolist()

    def describe(load: float) -> str:
        begins_severe = not is_band and begins.sel(load=load).item()
        words = severe_ranges(turns.sel(load=load).values, begins_severe, "velocity")
        return f"{words} at {load:g} N"

    said = [*map(describe, dict.fromkeys((*loads[:1], *loads[-1:])))]
    if is_band and said:
        said[-1] += f", on half of {boundaries.sizes['realization']} surfaces"
    others = dict[str, list[float]]()
    for load in boundaries["load"].values.tolist():
        codes = np.unique(boundaries["outcome_at_load"].sel(load=load)).tolist()
        words = " or ".join({**outcomes("velocity"), **_TURNING}[code] for code in codes)
        if load not in loads:
            others.setdefault(words, []).append(load)
    said += [f"{words} at {_loads_in_words(at)}" for words, at in others.items()]
    return f"wear is {'; '.join(said)}"


def _loads_in_words(loads: Sequence[float]) -> str:
    if len(loads) > _LISTED:
        return f"{len(loads)} loads from {loads[0]:g} to {loads[-1]:g} N"
    return f"{', '.join(f'{load:g}' for load in loads)} N"


def _numbers(ds: xr.Dataset) -> Iterator[Part]:
    yield from boundary_parts(boundary(ds))


def _operating_points(ds: xr.Dataset, points: OperatingPoints | None) -> Iterator[Part]:
    """Margins of operating points."""
    table = margin(ds, points)
    yield short(table, LONG)
    yield from notes_of(table, caveats_of(ds))
    yield from filter(None, (points.counted, *points.remarks)) if points else ()
    yield (
        "A factor is the critical velocity or load over that of the point: at 1.5, wear turns "
        "severe at 1.5 times its velocity or load. Without one, the sweep has no transition there"
    )


def _warnings(ds: xr.Dataset) -> Iterator[Part]:
    """Warnings by kind, with counts."""
    yield from [*warned(ds).lines()] or ["No computed point carries a warning"]


def _inputs(ds: xr.Dataset, sweep: Sweep) -> Iterator[Part]:
    """Entries of the scene with their units, and the sources of those of the library."""
    several = {str(name): values for name, values in ds.coords.items() if "." in str(name)}
    entries = scene_entries(sweep) | {path: _each(values) for path, values in several.items()}
    if surface := surface_words(sweep):
        yield f"Surface of the disk: {surface.replace('disk.roughness.file: ', '')}."
    rows = (
        (path, text, _meaning(path))
        for path, text in entries.items()
        if not path.startswith(("fidelity", "measured", "tested"))
    )
    yield frame_of(("entry", "value", "meaning"), rows)
    library = sweep.about.sources
    origin = "other values" if library else "all values"
    if library:
        yield frame_of(("from the library", "value", "source"), library)
    yield f"Source: {origin} from the scene {sweep.about.name}.toml."


def _each(values: xr.DataArray) -> str:
    """Values that an entry has in turn, in words; of many the number and the ends."""
    each = [*dict.fromkeys(np.ravel(values).tolist())]
    is_long = len(each) > _MOST_VALUES
    texts = [value_text(values, one) for one in ((min(each), max(each)) if is_long else each)]
    if is_long:
        return f"{len(each)} values, from {' to '.join(texts)}"
    return f"in turn {', '.join(texts)}" if len(texts) > 1 else texts[0]


def _tests(ds: xr.Dataset) -> Iterator[Part]:
    """Tests of the laboratory beside what is computed at their own conditions."""
    if (table := compared(ds)) is not None:
        yield from test_parts(table)


def _meaning(path: str) -> str:
    """First sentence on an entry, of the reference of the scene."""
    for body in ("pin", "disk"):
        path = path.replace(f"{body}.material.", "materials.NAME.")
    meanings = {key: entry.meaning for key, entry in all_keys()}
    return meanings.get(path, "").split(";")[0].split(". ")[0].rstrip(".").replace("`", "")


def _fidelity(sweep: Sweep) -> Iterator[Part]:
    """Numerical choices."""
    entries, prefix = scene_entries(sweep), "fidelity."
    rows = (
        (path.removeprefix(prefix), text)
        for path, text in entries.items()
        if path.startswith(prefix) and path != "fidelity.preset"
    )
    yield frame_of(("choice", "value"), rows)


def _versions(ds: xr.Dataset, sweep: Sweep) -> Iterator[Part]:
    """Programs that computed the store, and the identity of its scene."""
    yield from str(ds.attrs.get("history", "")).splitlines()
    yield f"Scene {digest(sweep.scene)} (SHA-256 of its inputs)."
    yield f"This report was written at {datetime.now(UTC):%Y-%m-%d %H:%M} UTC."


def citation() -> Iterator[str]:
    """References to the program and to the work that it builds on, a line each."""
    version = package_versions()["tribo"]
    yield f"The irg-transition developers: irg-transition (version {version}). BSD-3-Clause."
    yield (
        "R. Bosman and M. B. de Rooij: On the transition from mild to severe wear of lubricated, "
        "concentrated contacts: The IRG (OECD) transition diagram."
    )


def sections_of_samples(ds: xr.Dataset, points: OperatingPoints | None) -> Sections:
    """Answers of a sweep of samples, as probabilities."""
    samples = extras.module("uncertain", "fields")
    field = samples.single_field(ds)
    ensemble, weighed = field.ensemble, field.posterior
    lines = boundary(ds)
    basis = f", given {weighed.evidence}" if weighed else ", before any test"
    return {
        "Question and answer": _question_of_samples(field, lines, basis),
        f"Not known exactly{basis}": samples.basis_of(ensemble, weighed),
        "Transition diagram": _drawn(ds),
        "Boundary in numbers": boundary_parts(lines),
        "Operating points": _operating_points(ds, points) if points else (),
    }


def _question_of_samples(field: Any, lines: xr.Dataset, basis: str) -> Iterator[Part]:
    """Question that samples answer, and the answer in a sentence."""
    count = len(field.ensemble.inputs)
    yield (
        f"{_QUESTION}, with inputs that are not known exactly? {count} samples of them were "
        "simulated"
    )
    if field.misfit:
        yield field.misfit
    answers = (
        _answer_at(lines.sel(load=load), field.ends["velocity"])
        for load in dict.fromkeys(lines["load"].values[[0, -1]].tolist())
    )
    yield f"Answer{basis}: the next run is, likelier than not, {'; '.join(answers)}"


def _answer_at(line: xr.Dataset, ends: tuple[float, float]) -> str:
    """Where the next run of samples is likelier severe than mild, at one load."""
    at = f"at {line['load'].item():g} N"
    low, middle, high = line["critical_velocity_quantile"].values.tolist()
    if middle == 0:
        return f"severe throughout {at}"
    words = f"severe from {middle:.3g} m/s on" if middle < math.inf else "mild throughout"
    beyond = {0.0: f"below {ends[0]:.3g}", math.inf: f"beyond {ends[1]:.3g}"}
    low, high = (f"{beyond.get(v, f'{v:.3g}')} m/s" for v in (low, high))
    return f"{words} {at} (turns severe at {low} to {high} with 90 % probability)"
