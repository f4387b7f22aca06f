"""`plot`: draw a figure of a sweep or of a study by its name."""

from __future__ import annotations

import inspect
import pkgutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np
from matplotlib.figure import Figure

from pipeline.analysis.at import CONDITIONS, ConditionKeywords, asked_at
from pipeline.analysis.tables import FIGURES, writable_path
from pipeline.figures import style
from pipeline.figures.diagram import diagram
from pipeline.figures.fields import fields
from pipeline.figures.ramp import ramp, temperature
from pipeline.figures.tested import draw_tests
from pipeline.units import in_si
from tribo import InputError

Kind = Literal["diagram", "ramp", "fields", "temperature", "tests"]


class PlotOptions(ConditionKeywords, total=False):
    """Options of figures of a sweep, and conditions to judge by."""

    load: float | str | Sequence[float | str]
    velocity: float | str | Sequence[float | str]
    realization: int
    show: str
    log: bool


KINDS: dict[str, Callable[..., Figure]] = {
    "diagram": diagram,
    "ramp": ramp,
    "fields": fields,
    "temperature": temperature,
    "tests": draw_tests,
}
"""Function that draws each kind of figure of a sweep; the first is the default."""


@np.errstate(under="ignore")
def plot(
    ds: Any,
    kind: Kind | None = None,
    out: str | Path | None = None,
    width: float | str | None = None,
    plain: bool = False,
    **options: Unpack[PlotOptions],
) -> Figure | Path:
    """Draw a figure of a sweep, or of the result of a study.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or path or URL of a store; or a result
        of `pipeline.trade`.
    kind : {"diagram", "ramp", "fields", "temperature", "tests"}, optional
        Name of the figure of a sweep; "diagram" by default.
    out : path, optional
        File to write; its suffix, one of .pdf, .png and .svg, decides the format.
    width : float or str, optional
        Width of the figure, in m or as text such as ``"8.5 cm"``. The figure's text shrinks less
        than the figure.
    plain : bool
        Draw no title and no caption.
    **options
        Options of the kind:

        - all but tests: ``realization``, seed of the surface to draw. By default the first; a
          diagram shows the specimen of all.
        - diagram: ``log``, True for logarithmic axes, without velocity 0.
        - ramp, fields, temperature: ``load`` in N, or text with a unit; a ramp takes several. The
          nearest load of the sweep is drawn, by default the highest.
        - ramp, fields: ``velocity`` in m/s, or text with a unit; a ramp takes several. By default
          the velocity nearest to the transition at that load.
        - ramp: ``show``, name of a variable at each step to draw instead of contact and wear.

        Of a sweep also conditions to judge by, as in `pipeline.at`, such as ``friction=0.12``.

    Returns
    -------
    Figure or Path
        The figure, or the path of the file if `out` is given.

    Raises
    ------
    InputError
        If the kind, an option or the suffix is unknown, or the file cannot be written.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.plot("results/first_try.zarr", "diagram", "diagram.svg", friction=0.12).name
    'diagram.svg'
    """
    study = getattr(ds, "drawn_by", None)
    only = study.rpartition("draw_")[2] if study else ""
    kinds = {only: pkgutil.resolve_name(study)} if study else KINDS
    named: str = kind or next(iter(kinds))
    if named not in kinds:
        raise InputError(f"kind is {named!r}; give one of {', '.join(kinds)}")
    asked: dict[str, Any] = {**options}
    judged = {} if study else {name: asked.pop(name) for name in CONDITIONS & asked.keys()}
    _, *allowed = inspect.signature(kinds[named]).parameters  # the first is what is drawn
    for name in asked:
        if name not in allowed:
            others = ", ".join(allowed) or "none"
            raise InputError(f"{named} has no option {name!r}; it has {others}")
    path = None if out is None else writable_path(out, FIGURES)
    metres = None if width is None else in_si("width", width, "1 m")
    with style.fitted(metres, plain):
        drawn: Figure = kinds[named](ds if study else asked_at(ds, judged), **asked)
    return drawn if path is None else style.save_figure(drawn, path)
