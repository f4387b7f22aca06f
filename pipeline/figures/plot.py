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
from pipeline.figures.diagram import diagram
from pipeline.figures.fields import fields
from pipeline.figures.ramp import ramp
from pipeline.figures.style import figure_path, save_figure
from tribo import InputError

_KINDS: dict[str, Callable[..., Figure]] = {"diagram": diagram, "ramp": ramp, "fields": fields}


def plot(
    ds: xr.Dataset | str | Path, kind: str, out: str | Path | None = None, **options: Any
) -> Figure | Path:
    """Draw a figure of a sweep.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep`, or folder or address of the store.
    kind : {"diagram", "ramp", "fields"}
        Name of the figure.
    out : path, optional
        File to write; its suffix, one of .pdf, .png and .svg, decides the format.
    **options
        Options of the function of that name: `diagram`, `ramp` or `fields`.

    Returns
    -------
    Figure or Path
        The figure, or the file it was written to if `out` is given.

    Raises
    ------
    InputError
        If the kind, an option or the suffix is unknown, or the file cannot be written.
    """
    draw = _KINDS.get(kind)
    if draw is None:
        raise InputError(f"kind is {kind!r}; allowed are {', '.join(_KINDS)}")
    allowed = list(inspect.signature(draw).parameters)[1:]
    for name in options:
        if name not in allowed:
            raise InputError(f"{kind} has no option {name!r}; it has {', '.join(allowed)}")
    path = None if out is None else figure_path(out)
    figure = draw(ds if isinstance(ds, xr.Dataset) else open_sweep(ds), **options)
    return figure if path is None else save_figure(figure, path)
