"""Write the page: text, style and scripts of this folder, filled with the data of a sweep."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any, NamedTuple, Unpack

import numpy as np
import xarray as xr

from pipeline.analysis.at import ConditionKeywords, asked_at
from pipeline.analysis.dataset import Layout
from pipeline.analysis.results import Results
from pipeline.analysis.tables import writable_path, write_text
from pipeline.figures.overlays import MILD, SEVERE
from pipeline.page.content import MOST_FIELDS, content
from pipeline.page.controls import Control, scene_choice
from pipeline.page.sections import sections
from pipeline.scene.along import OperatingPoints
from pipeline.store.place import PathLike
from pipeline.sweep.shown import shown
from tribo import InputError

_SUFFIXES = (".html", ".htm")
_SCRIPTS = (
    "scene", "numbers", "field", "plot", "conditions", "margin", "operating",
    "points", "diagram", "tables",
)  # fmt: skip
_OWN_SCRIPTS = {Layout.PLANE: ("state", "view", "page"), Layout.PLACES: ()}
"""Scripts for each kind of sweep, after the common scripts."""


@shown
@dataclass(frozen=True, slots=True)
class Page:
    """Path of the page that `pipeline.explore` wrote, and counts of the points on it."""

    path: Path  #: File of the page.
    points: int  #: Number of points of the sweep that are done.
    points_with_fields: int  #: Number of points whose fields the page contains.

    def as_dict(self) -> dict[str, Any]:
        """The fields by name as plain data: the path as text, and both counts of points."""
        return asdict(self) | {"path": str(self.path)}

    def __str__(self) -> str:
        fields = f", {self.points_with_fields} with fields" if self.points_with_fields else ""
        return f"{self.path}: {self.points} points{fields}"


@np.errstate(under="ignore")
def explore(
    ds: xr.Dataset | PathLike,
    out: str | Path,
    most_fields: int = MOST_FIELDS,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]] | None = None,
    **conditions: Unpack[ConditionKeywords],
) -> Page:
    """Write the results of a sweep as an interactive HTML page.

    The page is a single file that opens in any current browser, without a server. Printed on A4 or
    to PDF, it is a report. Its content depends on the sweep:

    - For a grid of loads and velocities the page shows the boundary, computed and with tests. The
      reader can change friction and temperatures. For each point the page also shows numbers,
      fields and the distribution of temperature over the contact.
    - For a scene that lists pairs of load and velocity the page shows the verdict on each pair, and
      its distance from severe wear.

    If entries have several values, the reader selects a scene.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or path or URL of the store.
    out : path
        File to write, with the suffix .html or .htm.
    most_fields : int, optional
        Largest number of points with fields on the page, if the sweep has stored fields. The points
        nearest to the transition are taken; the fields of a point take about 10 kB.
    points : path or mapping of str to sequence, optional
        Operating points whose margins are shown: a table with columns for load and velocity, as a
        file or as columns by heading, as for `pipeline.margin`.
    **conditions
        Conditions to judge by, as in `pipeline.at`, such as ``friction=0.12``.

    Returns
    -------
    Page
        Path of the file, and counts of the points on it.

    Raises
    ------
    InputError
        If the suffix is another one, `most_fields` is negative, the file cannot be written, or the
        operating points have faults.

    Examples
    --------
    >>> import pipeline
    >>> page = pipeline.explore("results/first_try.zarr", "results/first_try.html", most_fields=6)
    >>> page.points, page.points_with_fields
    (24, 6)
    """
    path = writable_path(out, _SUFFIXES)
    if most_fields < 0:
        raise InputError(f"most_fields is {most_fields}; it must be at least 0")
    if points is not None and not isinstance(points, OperatingPoints):
        points = OperatingPoints.read(points)
    held = asked_at(ds, conditions)
    parts = [held] if held.kind is Layout.PLACES else [*held.scenes]
    made = [_MAIN[held.kind](part, most_fields // len(parts)) for part in parts]
    bodies = [
        _filled(
            "scene.html",
            {
                "title": html.escape(part.sweep.title),
                "main": main.html,
                "data": _json_text(main.data),
                **sections(part, points),
            },
        )
        for part, main in zip(parts, made, strict=True)
    ]
    words = (", ".join(f"{key} {text}" for key, text in part.entries.items()) for part in parts)
    names = [*words] if len(parts) > 1 else []
    write_text(_page(held.sweep.title, names, bodies, _OWN_SCRIPTS[held.kind]), path)
    done = int(held.done.sum())
    return Page(path, done, sum(len(main.data["fields"]["points"]) for main in made))


def _page(title: str, names: Sequence[str], bodies: Sequence[str], scripts: Sequence[str]) -> str:
    """HTML of the page of all scenes, with their names and HTML (`bodies`).

    The page's security policy allows only its own style and `scripts`, which are named without
    suffix.
    """
    style = _text("page.css")
    sources = (_text(f"{name}.js") for name in (*_SCRIPTS, *scripts))
    script = "\n".join(['"use strict";', *sources])
    templates = "\n".join(f"<template>{body}</template>" for body in bodies)
    return _filled(
        "page.html",
        {
            "title": html.escape(title),
            "scenes": scene_choice(names) + templates,
            "style": style,
            "script": script,
            "style_hash": _hash(style),
            "script_hash": _hash(script),
        },
    )


class _Main(NamedTuple):
    """Main part of a page: its HTML, and the data for its scripts."""

    html: str
    data: dict[str, Any]


def _plane(scene: Results, most_fields: int) -> _Main:
    """Main part of the page for a grid of loads and velocities.

    Contact fields are shown for at most `most_fields` points.
    """
    held = content(scene, most_fields)
    values = {
        "operating": _text("operating.html"),
        "controls": "\n".join(Control(**control).html() for control in held["controls"]),
        "mild": MILD,
        "severe": SEVERE,
        "frictions": " and ".join(f"{end:.4g}" for end in held["friction_band"] or ()),
    }
    return _Main(_filled("plane.html", values), held)


def _places(_scene: Results, _most_fields: int) -> _Main:
    """Empty main part of the page, for a scene that lists pairs of load and velocity.

    The table of these pairs is in the page's section "Operating points".
    """
    return _Main("", {"fields": {"points": {}}})


_MAIN = {Layout.PLANE: _plane, Layout.PLACES: _places}


def _filled(name: str, parts: dict[str, str]) -> str:
    """Text of the file `name` in this folder, with its placeholders replaced by `parts`."""
    return Template(_text(name)).substitute(parts)


def _text(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text("utf-8")


def _json_text(held: dict[str, Any]) -> str:
    """Write data of the page as JSON in which no text can end the script element."""
    text = json.dumps(held, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", r"\u003c")


def _hash(text: str) -> str:
    """Hash of a script or a style, by which the page's content security policy allows it."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
