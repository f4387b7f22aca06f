"""Figures of a sweep by name: the transition diagram, the ramp, the fields of a point.

Each is a function that takes the dataset of `pipeline.open_sweep` and gives a matplotlib figure,
without touching pyplot's state.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from pipeline.analysis.dataset import open_sweep
from pipeline.analysis.tables import writable_path
from pipeline.figures.animation import SUFFIXES, animation, save_animation
from pipeline.figures.diagram import diagram
from pipeline.figures.fields import fields
from pipeline.figures.fit import fitted
from pipeline.figures.ramp import ramp
from pipeline.figures.style import figure_path, save_figure
from pipeline.figures.temperatures import histogram, temperature
from pipeline.scene.units import to_si
from tribo import InputError

_COLUMN = 0.12  # [m], below which panels lie below each other
_DPI = (20, 2400)
_KINDS: dict[str, Callable[..., Figure | list[Figure]]] = {
    "diagram": diagram,
    "ramp": ramp,
    "fields": fields,
    "temperature": temperature,
    "histogram": histogram,
    "animation": animation,
}


def plot(
    ds: xr.Dataset | str | Path,
    kind: str,
    out: str | Path | None = None,
    width: float | str | None = None,
    dpi: float | None = None,
    with_title: bool = True,
    **options: Any,
) -> Figure | list[Figure] | Path:
    """Draw a figure of a sweep.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep`, or folder or address of the store.
    kind : {"diagram", "ramp", "fields", "temperature", "histogram", "animation"}
        Name of the figure; the animation shows the fields while the load grows.
    out : path, optional
        File to write; its suffix, one of .pdf, .png and .svg, decides the format. That of an
        animation is .gif.
    width : float or str, optional
        Width of the figure [m], or as text, such as "8.5 cm"; words stay readable. Its own if not
        given.
    dpi : float, optional
        Dots per inch of a .png, 150 if not given, or of a .gif, 100 if not given.
    with_title : bool
        Whether the figure has its titles.
    **options
        Options of the function of that name.

    Returns
    -------
    Figure, list of Figure or Path
        The figure, or those of an animation; the file they were written to if `out` is given.

    Raises
    ------
    InputError
        If the kind, an option or the suffix is unknown, or the file cannot be written.

    Examples
    --------
    >>> import pipeline
    >>> figure = pipeline.plot("results/first_try.zarr", "diagram", friction=0.12)
    >>> pipeline.plot("results/first_try.zarr", "ramp", "ramp.svg", load="600 N").name
    'ramp.svg'
    """
    draw = _KINDS.get(kind)
    if draw is None:
        raise InputError(f"kind is {kind!r}; allowed are {', '.join(_KINDS)}")
    allowed = options_of(kind)
    for name in options:
        if name not in allowed:
            raise InputError(f"{kind} has no option {name!r}; it has {', '.join(allowed)}")
    path = None
    if out is not None:
        path = writable_path(out, SUFFIXES) if kind == "animation" else figure_path(out)
    if dpi is not None and not _DPI[0] <= dpi <= _DPI[1]:
        raise InputError(f"dpi is {dpi:g}; it must be from {_DPI[0]} to {_DPI[1]}")
    metres = to_si(width, "1 m") if isinstance(width, str) else width
    if "stacked" in allowed and metres is not None and metres < _COLUMN:
        options = {"stacked": True} | options
    drawn = draw(ds if isinstance(ds, xr.Dataset) else open_sweep(ds), **options)
    for figure in drawn if isinstance(drawn, list) else [drawn]:
        fitted(figure, metres, with_title)
    if path is None:
        return drawn
    if isinstance(drawn, list):
        return save_animation(drawn, path, dpi)
    return save_figure(drawn, path, dpi)


def options_of(kind: str) -> list[str]:
    """Names of the options that a kind of figure has.

    Examples
    --------
    >>> options_of("temperature")[:2]
    ['load', 'friction']
    """
    return list(inspect.signature(_KINDS[kind]).parameters)[1:]
