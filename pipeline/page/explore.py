"""The page, from its parts: text, style and scripts of this folder, and the data of a sweep."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import Kind, dataset_of, require_kind, stored_sweep, sweep_kind
from pipeline.analysis.scenes import entries_in_words, scenes
from pipeline.analysis.tables import frame_of, html_of, short, writable_path, write_text
from pipeline.page.content import MOST_FIELDS, content, content_of_samples
from pipeline.page.controls import Control, scene_choice, surface_choice
from pipeline.quantities import display
from pipeline.sweep.shown import shown
from tribo import InputError

_SUFFIXES = (".html", ".htm")
_SCRIPTS = (
    "scene", "numbers", "field", "plot", "conditions", "margin", "operating",
    "points", "course", "diagram", "tables",
)  # fmt: skip


@shown
@dataclass(frozen=True, slots=True)
class Page:
    """A page that was written."""

    path: Path  #: The file.
    size: int  #: Size of the page [byte].
    points: int  #: Points of the sweep that are done.
    points_with_fields: int  #: Points whose fields the page holds.
    stored_fields: int  #: Points whose fields the sweep has.

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        return asdict(self) | {"path": str(self.path)}

    def __str__(self) -> str:
        size = display(self.size, *(("MB", ".1f") if self.size >= 1e6 else ("kB", ".0f")))
        fields = ""
        if self.stored_fields and not self.points_with_fields:
            fields = ", without their fields"
        elif self.stored_fields:
            left_out = self.points_with_fields < self.stored_fields
            nearest = ", those nearest to the transition" if left_out else ""
            fields = f", fields of {self.points_with_fields} of {self.stored_fields}{nearest}"
        return f"{self.path}: {self.points} points{fields}, {size}"


@np.errstate(under="ignore")
def explore(
    ds: xr.Dataset | str | Path,
    out: str | Path,
    most_fields: int = MOST_FIELDS,
) -> Page:
    """Write a page on which friction, temperatures and failing share can be changed.

    The page is one file that opens from the disk in any present browser, without a server. On it
    the boundary, its band over several surfaces and the tables follow the conditions, and each
    point shows its numbers, its fields and how its temperature is distributed over the contact.
    For samples it shows the probability of severe wear at any place. If entries have several
    values, the reader chooses among them.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or folder or address of the store.
    out : path
        File to write; it ends in .html.
    most_fields : int, optional
        Number of points whose fields the page may hold, if the sweep has stored any: those nearest
        to the transition. Each takes about 10 kB; 0 leaves them out.

    Returns
    -------
    Page
        The file, its size, and what it holds.

    Raises
    ------
    InputError
        If the suffix is not .html, the number is negative, or the file cannot be written.

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
    ds = dataset_of(ds)
    parts = [*scenes(ds)]
    if sweep_kind(ds) is Kind.SAMPLES:
        held = [content_of_samples(part) for part in parts]
        scripts, bodies = ["samples"], [_samples_scene(one) for one in held]
    else:
        require_kind(ds, Kind.PLANE)
        held = [content(part, most_fields // len(parts)) for part in parts]
        scripts, bodies = ["state", "page"], [_plane_scene(one) for one in held]
    names = [entries_in_words(part) for part in parts]
    write_text(_page(stored_sweep(ds).about.title, names, bodies, scripts), path)
    done = sum(one["done"] for one in held)
    fields = [one["fields"] for one in held if "fields" in one]
    counts = (sum(len(one["points"]) for one in fields), sum(one["stored"] for one in fields))
    return Page(path, path.stat().st_size, done, *counts)


def _page(title: str, names: Sequence[str], bodies: Sequence[str], scripts: Sequence[str]) -> str:
    """The page of all scenes, with its own style and scripts, which alone may run on it."""
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


def _plane_scene(held: dict[str, Any]) -> str:
    """A scene of loads and velocities."""
    surfaces = len(held["surfaces"] or [None])
    several = f", {surfaces} surfaces" if held["surfaces"] else ""
    sizes = f"{len(held['loads'])} loads, {len(held['velocities'])} velocities{several}"
    tests, agreement = held.pop("tests"), held.pop("agreement")
    band = held["friction_band"]
    own = {
        "tests": tests,
        "without_tests": "" if tests else "hidden",
        "agreement": html.escape(agreement),
        "controls": "\n".join(Control(**control).html() for control in held["controls"]),
        "surfaces": surface_choice(held["surfaces"]),
        "mild": held["regions"][0],
        "severe": held["regions"][1],
        "band": f"10 to 90 % of {surfaces}",
        "frictions": f"transition at friction {' and '.join(f'{end:.4g}' for end in band or ())}",
        "caveats": _items(held["caveats"]),
    }
    return _filled("plane.html", _scene_values(held, sizes) | own)


def _samples_scene(held: dict[str, Any]) -> str:
    """A scene of samples."""
    table, scale = held.pop("table"), held.pop("scale")
    own = {
        "basis": _items(held["basis"]),
        "evidence": html.escape(held["evidence"]),
        "table": html_of(short(table, ["notes"])),
        "scale": scale,
    }
    sizes = f"{len(table)} loads, {held['samples']} samples"
    return _filled("samples.html", _scene_values(held, sizes) | own)


def _scene_values(held: dict[str, Any], sizes: str) -> dict[str, str]:
    """Title, form of the operating point, record and data of a scene."""
    entries = html_of(frame_of(("entry", "value"), held["record"].items()))
    return {
        "operating": _text("operating.html"),
        "title": html.escape(str(held["title"])),
        "record": f'<details id="record" class="record"><summary>The scene as it was stored: '
        f"{sizes}, {held['done']} points done</summary>{entries}</details>",
        "data": _json_text({name: value for name, value in held.items() if name != "record"}),
    }


def _items(lines: Iterable[str]) -> str:
    return "".join(f"<li>{html.escape(line)}</li>" for line in lines)


def _filled(name: str, parts: dict[str, str]) -> str:
    """A file of this folder, with parts in the places of their names."""
    return Template(_text(name)).substitute(parts)


def _text(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text("utf-8")


def _json_text(held: dict[str, Any]) -> str:
    """Data as JSON that no text in it can end the script element of."""
    text = json.dumps(held, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", r"\u003c")


def _hash(text: str) -> str:
    """Digest by which the page's policy allows a script or a style."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
