"""The diagram of rows with places of their own: the distance of each from severe wear."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.margin_frame import judged, margin_frame, row_labels
from pipeline.analysis.results import Results
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, TINTS, VERMILION
from pipeline.sweep.about import judged_by

_MOST_TICKS = 24  # labels of rows that are written below a figure
_LOOKS: dict[str, tuple[str, dict[str, Any]]] = {
    "mild": ("mild wear", {"marker": "o", "mfc": "white", "mec": BLUE}),
    "severe": ("severe wear", {"marker": "s", "mfc": VERMILION, "mec": VERMILION}),
    NOT_DECIDED: ("not decided", {"marker": "D", "mfc": GREY, "mec": BLACK}),
    "not known": ("not known: not computed", {"marker": "x", "mec": BLACK}),
}


@style.house_style
def draw_rows(held: Results, ax: Axes | None = None) -> Figure:
    """Draw the margin of each row [K]."""
    rows = [*judged(held, None)]
    frame = margin_frame(held, rows)
    figure, axes = style.canvas(ax)
    ticks, label = _row_names(frame)
    x = pd.factorize(pd.Series(ticks))[0]  # surfaces of a row share its place
    _draw_margins(axes, x, frame)
    style.write_title(axes, style.title_of(held))
    axes.set_xlabel(style.as_text(label))
    names = [*dict.fromkeys(ticks)]
    every = math.ceil(len(names) / _MOST_TICKS)
    turned: dict[str, Any] = {"rotation": 35, "ha": "right"} if max(map(len, names)) > 5 else {}
    axes.set_xticks(range(0, len(names), every), names[::every], **turned)
    conditions = {row.field.conditions for row in rows}
    style.legend_below(figure, ax, caption=judged_by(conditions) if len(conditions) == 1 else "")
    return figure


def _row_names(frame: pd.DataFrame) -> tuple[list[str], str]:
    """Names of the rows, by their first own label or else their numbers; and of the label."""
    columns = row_labels(frame)
    own = [head for head in columns if head not in ("load [N]", "velocity [m/s]", "realization")]
    if own:
        cells = frame[own[0]]
        return [cell if isinstance(cell, str) else f"{cell:g}" for cell in cells], own[0]
    places = frame.groupby(["load [N]", "velocity [m/s]"], sort=False).ngroup()
    return [str(number + 1) for number in places], "row"


def _draw_margins(axes: Axes, x: Any, frame: pd.DataFrame) -> None:
    """Margins with their errors, and the line at which wear turns severe."""
    names = "distance [K]", "temperature error [K]"
    margins, errors = np.nan_to_num(frame[[*names]].to_numpy(float)).T
    axes.axhline(0.0, label="critical temperature", gid="boundary", **style.BOUNDARY)
    axes.errorbar(
        x, margins, errors, ls="none", ecolor=GREY, elinewidth=style.THIN, capsize=3,
        label="error of the margin",
    )  # fmt: skip
    for verdict, (label, look) in _LOOKS.items():
        if (where := (frame["verdict"] == verdict).to_numpy()).any():
            axes.plot(x[where], margins[where], ls="none", label=label, gid=label, **look)
    axes.margins(0.06)
    low, high = min(axes.get_ylim()[0], -1.0), max(axes.get_ylim()[1], 1.0)
    axes.axhspan(0.0, high, color=TINTS["mild"], zorder=0)
    axes.axhspan(low, 0.0, color=TINTS["severe"], zorder=0)
    axes.set_ylim(low, high)
    axes.set_ylabel("margin to severe wear [K]")
