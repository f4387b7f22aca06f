"""The diagram of rows with places of their own: the distance of each from severe wear."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.margin_frame import judged, margin_frame, row_labels
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, TINTS, VERMILION
from pipeline.sweep.about import judged_by

_MOST_TICKS = 24  # labels of rows that are written below a figure
_MANY = 60  # rows, from which marks are small and errors have no caps
_LOOKS: dict[str, tuple[str, dict[str, Any]]] = {
    "mild": ("mild wear", {"marker": "o", "mfc": "white", "mec": BLUE}),
    "severe": ("severe wear", {"marker": "s", "mfc": VERMILION, "mec": VERMILION}),
    NOT_DECIDED: ("not decided", {"marker": "D", "mfc": GREY, "mec": BLACK}),
}
_UNKNOWN: dict[str, Any] = {"marker": "x", "mec": BLACK}


@style.house_style
def draw_rows(ds: xr.Dataset, ax: Axes | None = None) -> Figure:
    """Draw the margin of each row [K]."""
    rows = [*judged(ds, None)]
    frame = margin_frame(ds, rows)
    columns = row_labels(frame)
    x, ticks, label = _axis(frame, columns)
    figure, axes = style.canvas(ax)
    _draw_margins(axes, x, frame)
    style.write_title(axes, style.title_of(ds))
    axes.set_xlabel(style.as_text(label))
    every = math.ceil(len(ticks) / _MOST_TICKS)
    shown: dict[str, Any] = {"ha": "right", "rotation": 35} if max(map(len, ticks)) > 5 else {}
    axes.set_xticks(range(0, len(ticks), every), ticks[::every], **shown)
    conditions = {row.field.conditions for row in rows}
    title = (
        judged_by(conditions)
        if len(conditions) == 1
        else "severe wear: by the conditions of each row"
    )
    style.legend_below(figure, ax, title=title)
    return figure


def _axis(frame: pd.DataFrame, columns: list[str]) -> tuple[np.ndarray[Any, Any], list[str], str]:
    """Places of the rows along the axis, its ticks where these are words, and its label."""
    own = [c for c in columns if "." not in c and c not in ("load [N]", "velocity [m/s]")]
    column = own[0] if own else None
    places = frame[columns].drop(columns="realization", errors="ignore")
    x = places.groupby(list(places), sort=False, dropna=False).ngroup().to_numpy()
    firsts = np.unique(x, return_index=True)[1]
    if column is None:
        return x, [str(number + 1) for number in range(len(firsts))], "row"
    cells = frame[column].iloc[firsts]
    return x, [cell if isinstance(cell, str) else f"{cell:g}" for cell in cells], column


def _draw_margins(axes: Axes, x: np.ndarray[Any, Any], frame: pd.DataFrame) -> None:
    """Margins with their errors, and the line at which wear turns severe."""
    margins, errors = (
        frame[name].to_numpy(float) for name in ("distance [K]", "temperature error [K]")
    )
    size = 6.0 if len(frame) <= _MANY else 3.0
    axes.axhline(0.0, label="critical temperature", gid="boundary", **style.BOUNDARY)
    if (np.diff(x) > 0).all():
        axes.plot(x, margins, color=GREY, lw=style.THIN)
    axes.errorbar(
        x, margins, np.nan_to_num(errors), ls="none", ecolor=GREY, elinewidth=style.THIN,
        capsize=3 if len(frame) <= _MANY else 0, label="error of the margin",
    )  # fmt: skip
    for verdict, (label, look) in _LOOKS.items():
        if (where := (frame["verdict"] == verdict).to_numpy()).any():
            axes.plot(
                x[where], margins[where], ls="none", ms=size, label=label, gid=label, **look,
            )  # fmt: skip
    if (unknown := np.isnan(margins)).any():
        label = "not known: not computed"
        axes.plot(
            x[unknown], 0 * x[unknown], ls="none", ms=size, label=label, gid=label, **_UNKNOWN
        )
    axes.margins(0.06)
    low, high = min(axes.get_ylim()[0], -1.0), max(axes.get_ylim()[1], 1.0)
    axes.axhspan(0.0, high, color=TINTS["mild"], zorder=0)
    axes.axhspan(low, 0.0, color=TINTS["severe"], zorder=0)
    axes.set_ylim(low, high)
    axes.set_ylabel("margin to severe wear [K]")
