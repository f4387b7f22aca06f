"""`report`: the answers on a sweep as a page of HTML; it computes nothing itself."""

from __future__ import annotations

import base64
import hashlib
from datetime import UTC, datetime
from importlib import metadata, resources
from pathlib import Path
from typing import Any

import xarray as xr
from jinja2 import Environment

import pipeline
from pipeline.answers.results import dataset_of, sweep_of
from pipeline.arguments import typed_arguments
from pipeline.frames import writable_path, write_text
from pipeline.page.report_answers import boundary_answer, point_answer, rows_answer
from pipeline.page.sections import common_sections
from pipeline.store.location import PathLike
from pipeline.store.schema import PLANE
from tribo import InputError


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
        answer = boundary_answer(ds, conditions)
    elif not margins.sizes:
        answer = point_answer(ds, conditions, margins)
    else:
        answer = rows_answer(ds, conditions, margins)
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
        sections=[*answer.sections, *common_sections(ds, conditions, version, answer.sentences)],
    )
    page = page.encode(errors="replace").decode()  # shells may pass bytes that are no text
    return page if path is None else write_text(page, path)
