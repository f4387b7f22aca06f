"""`plot`: draw a figure of a sweep or of a study by its name."""

from __future__ import annotations

import inspect
import pkgutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np
from matplotlib.figure import Figure

from pipeline.answers.condition_values import CONDITION_NAMES, ConditionValues
from pipeline.answers.results import dataset_of, sweep_of
from pipeline.arguments import in_si, typed_arguments
from pipeline.figures import style
from pipeline.figures.diagram import diagram
from pipeline.figures.fields_figure import fields
from pipeline.figures.ramp_figure import ramp
from pipeline.figures.rows_figure import rows
from pipeline.figures.tests_figure import draw_tests
from pipeline.paths import FIGURES, writable_path
from pipeline.store.schema import PLANE
from tribo import InputError

Kind = Literal["diagram", "rows", "ramp", "fields", "tests"]


class PlotOptions(ConditionValues, total=False):
    """Options of the kinds of figures, and conditions."""

    realization: int
    log: bool
    load: Any
    velocity: Any
    step: int


KINDS: dict[str, Callable[..., Figure]] = {
    "diagram": diagram,
    "rows": rows,
    "ramp": ramp,
    "fields": fields,
    "tests": draw_tests,
}
"""Function that draws each kind of figure of a sweep."""


@typed_arguments
@np.errstate(under="ignore")
def plot(
    ds: Any,
    kind: Kind | None = None,
    out: str | Path | None = None,
    width: float | str | None = None,
    plain: bool = False,
    title: str | None = None,
    dpi: float | None = None,
    **options: Unpack[PlotOptions],
) -> Figure | Path:
    """Draw a figure of a sweep, or of the result of a study.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep`, or path or URL of a store; or a result of
        `pipeline.trade` or `pipeline.surface_statistics`.
    kind : {"diagram", "rows", "ramp", "fields", "tests"}, optional
        Name of the figure of a sweep; by default "diagram", or "rows" if each row of the sweep has
        its own load and velocity.
    out : path, optional
        File to write; its suffix, one of .pdf, .png and .svg, decides the format.
    width : float or str, optional
        Width of the figure, in m or as text such as ``"8.5 cm"``. The figure's text shrinks less
        than the figure.
    plain : bool
        Draw no title and no caption.
    title : str, optional
        Title of the figure, by default that of the scene.
    dpi : float, optional
        Resolution in dots per inch; by default 150.
    **options
        Options of the kind:

        - all but tests and rows: ``realization``, seed of the surface to draw. By default the
          first; a diagram shows the specimen of all.
        - diagram: ``log``, True for logarithmic axes; ``load`` and ``velocity`` of an operating
          point to mark, or lists of equal length for several.
        - ramp, fields: ``load`` in N, or text with a unit; a ramp takes several. The nearest load
          of the sweep is drawn, by default the highest.
        - ramp, fields: ``velocity`` in m/s, or text with a unit; a ramp takes several. By default
          the velocity nearest to the boundary at that load.
        - fields: ``step``, counted back from the end of the point, which is 0.

        For a sweep, also conditions as in `pipeline.margin`, such as ``friction=0.12``.

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
    drawn_by = getattr(ds, "drawn_by", None)  # of the result of a study
    inputs: tuple[Any, ...]
    kinds: dict[str, Callable[..., Figure]]
    kind_options: dict[str, Any] = {**options}
    if drawn_by:
        default_kind = drawn_by.rpartition("draw_")[2]
        kinds, inputs = {default_kind: pkgutil.resolve_name(drawn_by)}, (ds,)
    else:
        conditions = {
            name: kind_options.pop(name) for name in CONDITION_NAMES if name in kind_options
        }
        kinds, inputs = KINDS, (dataset_of(ds), conditions)
        table = sweep_of(inputs[0]).case_table
        is_listed = any(table.column(name) for name in PLANE)
        default_kind = "rows" if is_listed else "diagram"
    if kind and kind not in kinds:
        raise InputError(f"unknown kind {kind!r}; choose one of {', '.join(kinds)}")
    drawn_kind = kind or default_kind
    allowed = [*inspect.signature(kinds[drawn_kind]).parameters][len(inputs) :]
    for name in kind_options:
        if name not in allowed:
            available = ", ".join(allowed) or "none"
            raise InputError(f"{drawn_kind} has no option {name!r}; available: {available}")
    path = None if out is None else writable_path(out, FIGURES)
    width_in_si = None if width is None else in_si("width", width, "1 m")
    with style.fitted(width_in_si, plain, title, dpi):
        figure = kinds[drawn_kind](*inputs, **kind_options)
        return figure if path is None else style.save_figure(figure, path)
