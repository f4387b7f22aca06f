"""`plot`: draw a figure of a sweep or of a study by its name."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pipeline.answers.results import dataset_of, sweep_of
from pipeline.condition_kinds import CONDITIONS, ConditionValues
from pipeline.figures import style
from pipeline.figures.diagram import diagram
from pipeline.figures.rows_figure import rows
from pipeline.figures.study_figures import draw_sensitivities, draw_trade
from pipeline.figures.tests_figure import draw_tests
from pipeline.kinds import Quantity
from pipeline.paths import FIGURES, writable_path
from pipeline.run.trade import Trade
from pipeline.store.schema import PLANE
from tribo import InputError

Kind = Literal["diagram", "rows", "tests"]


class PlotOptions(ConditionValues, total=False):
    """Options of the kinds of figures, and conditions."""

    log: bool
    load: Any
    velocity: Any


KINDS: dict[str, Callable[..., Figure]] = {
    "diagram": diagram,
    "rows": rows,
    "tests": draw_tests,
}
"""Function that draws each kind of figure of a sweep."""

_WIDTH = Quantity("8.5 cm", ends=("4 cm", "100 cm"))


@np.errstate(under="ignore")
def plot(
    ds: Any,
    kind: Kind | None = None,
    out: str | Path | None = None,
    width: float | str | None = None,
    plain: bool = False,
    dpi: float | None = None,
    without_tests: bool = False,
    **options: Unpack[PlotOptions],
) -> Figure | Path:
    """Draw a figure of a sweep, or of the result of a study.

    Parameters
    ----------
    ds : Dataset or path
        Dataset of `pipeline.open_sweep`, or path of a store; or a result of
        `pipeline.trade` or `pipeline.sensitivity`.
    kind : {"diagram", "rows", "tests"}, optional
        Name of the figure of a sweep; by default "diagram", or "rows" if each row of the sweep has
        its own load and velocity.
    out : path, optional
        File to write; its suffix, one of .pdf, .png and .svg, decides the format.
    width : float or str, optional
        Width of the figure, in m or as text such as ``"8.5 cm"``. Text keeps a
        readable size at small widths.
    plain : bool
        Draw no title and no caption.
    dpi : float, optional
        Resolution in dots per inch; by default 150.
    without_tests : bool, optional
        Leave out the tests of the scene.
    **options
        Of a diagram: ``log``, True for logarithmic axes; ``load`` and ``velocity`` of an operating
        point to mark, in SI or text with a unit, or lists of equal length for several. Of any
        figure of a sweep: conditions as in `pipeline.margin`, such as ``friction=0.12``.

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
    kinds, inputs = dict[str, Callable[..., Figure]](KINDS), tuple[Any, ...]()
    kind_options: dict[str, Any] = {**options}
    default_kind, scene = "", ""
    if isinstance(ds, Trade):
        default_kind = "trade"
        kinds, inputs = {default_kind: draw_trade}, (ds,)
    elif isinstance(ds, xr.Dataset) and "log_rise_change" in ds:  # of pipeline.sensitivity
        default_kind = "sensitivities"
        kinds, inputs = {default_kind: draw_sensitivities}, (ds,)
    else:
        names = [name for name in CONDITIONS if name in kind_options]
        inputs = dataset_of(ds, without_tests), {name: kind_options.pop(name) for name in names}
        sweep = sweep_of(inputs[0])
        table, scene = sweep.case_table, sweep.meaning_digest
        default_kind = "rows" if any(table.column(name) for name in PLANE) else "diagram"
    if kind and kind not in kinds:
        raise InputError(f"unknown kind {kind!r}; choose one of {', '.join(kinds)}")
    draw = kinds[kind or default_kind]
    allowed = [*inspect.signature(draw).parameters][len(inputs) :]
    if unknown := [name for name in kind_options if name not in allowed]:
        available = ", ".join(allowed) or "none"
        raise InputError(
            f"{kind or default_kind} has no option {unknown[0]!r}; available: {available}"
        )
    path = None if out is None else writable_path(out, FIGURES)
    width_in_si = None if width is None else _WIDTH.argument("width", width)
    with style.fitted(width_in_si, plain, dpi):
        figure = draw(*inputs, **kind_options)
        return figure if path is None else style.save_figure(figure, path, scene)
