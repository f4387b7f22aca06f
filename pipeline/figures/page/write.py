"""The page, from its parts: text, style and scripts of this folder, and the data of a sweep."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import xarray as xr

from pipeline.analysis.dataset import open_sweep
from pipeline.analysis.tables import Column, Table, writable_path
from pipeline.figures.page.content import MOST_FIELDS, content
from pipeline.figures.page.controls import Control, surface_choice
from tribo import InputError

_ENTRY = Column("entry", "entry"), Column("value", "value")
_SUFFIXES = (".html", ".htm")
_SCRIPTS = (
    "interpolation", "criterion", "transition", "model", "plot", "state", "conditions",
    "verdict", "points", "diagram", "tables", "margin", "detail", "page",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Page:
    """A page that was written.

    Attributes
    ----------
    path : Path
        The file.
    size : int
        Size of the page [byte].
    points : int
        Number of points of the sweep that are done.
    points_with_fields : int
        Number of those whose fields the page holds.
    stored_fields : int
        Number of those whose fields the sweep holds.

    Examples
    --------
    >>> import pipeline
    >>> page = pipeline.explore("results/first_try.zarr", "results/page.html", most_fields=6)
    >>> page.points, page.stored_fields, page.size < 1e6
    (24, 24, True)
    """

    path: Path
    size: int
    points: int
    points_with_fields: int
    stored_fields: int

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        return asdict(self) | {"path": str(self.path)}

    def __str__(self) -> str:
        size = f"{self.size / 1e6:.1f} MB" if self.size >= 1e6 else f"{self.size / 1e3:.0f} kB"
        fields = ""
        if self.stored_fields and not self.points_with_fields:
            fields = ", without their fields"
        elif self.stored_fields:
            left_out = self.points_with_fields < self.stored_fields
            nearest = ", those nearest to the transition" if left_out else ""
            fields = f", fields of {self.points_with_fields} of {self.stored_fields}{nearest}"
        return f"{self.path}: {self.points} points{fields}, {size}"


def explore(ds: xr.Dataset | str | Path, out: str | Path, most_fields: int = MOST_FIELDS) -> Page:
    """Write a page on which friction, temperatures and failing share can be changed.

    The page is one file that opens from the disk in any present browser, without a server. On it
    the boundary, its band over several surfaces and the tables follow the conditions, and each
    point shows its numbers, its fields and how its temperature is distributed over the contact.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep`, or folder or address of the store.
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
    held = content(ds if isinstance(ds, xr.Dataset) else open_sweep(ds), most_fields)
    written = _page(held).encode()
    try:
        path.write_bytes(written)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror or error}") from error
    return Page(
        path, len(written), held["done"], len(held["fields"]["points"]), held["fields"]["stored"]
    )


def _page(held: dict[str, Any]) -> str:
    """Fill the page in: its own style and scripts, which alone may run on it, and the data."""
    folder = resources.files(__package__)
    style = folder.joinpath("page.css").read_text("utf-8")
    script = "\n".join(folder.joinpath(f"{name}.js").read_text("utf-8") for name in _SCRIPTS)
    several = f", {len(held['surfaces'])} surfaces" if held["surfaces"] else ""
    parts = {
        "title": html.escape(str(held["title"] or held["name"])),
        "controls": "\n".join(Control(**control).html() for control in held["controls"]),
        "surfaces": surface_choice(held["surfaces"]),
        "sizes": f"{len(held['loads'])} loads, {len(held['velocities'])} velocities{several}, "
        f"{held['done']} points done",
        "record": Table(_ENTRY, tuple(held["record"].items())).html(),
        "style": style,
        "script": script,
        "style-hash": _hash(style),
        "script-hash": _hash(script),
        "data": _as_json({name: value for name, value in held.items() if name != "record"}),
    }
    page = folder.joinpath("page.html").read_text("utf-8")
    pieces = page.split("@@")  # text and names in turn
    return "".join(parts[piece] if place % 2 else piece for place, piece in enumerate(pieces))


def _as_json(held: dict[str, Any]) -> str:
    r"""Data as JSON that no text in it can end the script element of.

    Examples
    --------
    >>> print(_as_json({"title": "</script>"}))
    {"title":"\u003c/script>"}
    """
    text = json.dumps(held, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", r"\u003c")


def _hash(text: str) -> str:
    """Digest by which the page's policy allows a script or a style."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
