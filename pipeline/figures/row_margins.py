"""The diagram of rows with places of their own: the distance of each from severe wear."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from matplotlib.transforms import ScaledTranslation

from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.margin_frame import judged, margin_frame, row_labels
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, PURPLE, TINTS, VERMILION
from pipeline.sweep.about import judged_by
from pipeline.sweep.variants import PLACE

_MOST_TICKS = 24  # labels of rows that are written below a figure
_MANY = 60  # rows, from which marks are small and errors have no caps
_LOOKS: dict[str, tuple[str, dict[str, Any]]] = {
    "mild": ("mild wear", {"marker": "o", "mfc": "white", "mec": BLUE}),
    "severe": ("severe wear", {"marker": "s", "mfc": VERMILION, "mec": VERMILION}),
    NOT_DECIDED: ("not decided", {"marker": "D", "mfc": GREY, "mec": BLACK}),
}
_ROOM = 1.1  # factor between two marks of what lies beyond the places computed
_UNKNOWN: dict[str, Any] = {"marker": "x", "mec": BLACK}
_FACTORS: dict[str, dict[str, Any]] = {
    "velocity": {"color": PURPLE, "marker": ">", "ls": "none"},
    "load": {"color": GREEN, "marker": "^", "ls": "none"},
}
_ASIDES = {"velocity": -5.0, "load": 5.0}  # [pt] of the mark of either factor from its row


@style.house_style
def draw_rows(ds: xr.Dataset, ax: Axes | None = None) -> Figure:
    """Draw the margin of each row [K], and its factors where places about it were simulated."""
    rows = [*judged(ds, None)]
    frame = margin_frame(ds, rows)
    columns = row_labels(frame)
    x, ticks, label = _axis(frame, columns)
    has_factors = PLACE in ds.coords and ax is None
    figure, axes = style.canvas(ax)
    panels = [axes]
    if has_factors:
        axes.remove()
        panels = list(figure.subplots(2, 1, sharex=True, height_ratios=(3, 2)))
        _draw_factors(panels[1], x, frame)
    _draw_margins(panels[0], x, frame)
    style.write_title(panels[0], style.title_of(ds))
    panels[-1].set_xlabel(style.as_text(label))
    every = math.ceil(len(ticks) / _MOST_TICKS)
    shown: dict[str, Any] = {"ha": "right", "rotation": 35} if max(map(len, ticks)) > 5 else {}
    panels[-1].set_xticks(range(0, len(ticks), every), ticks[::every], **shown)
    conditions = {row.field.conditions for row in rows}
    handles = [handle for one in panels for handle in one.get_legend_handles_labels()[0]]
    title = (
        judged_by(conditions)
        if len(conditions) == 1
        else "severe wear: by the conditions of each row"
    )
    style.legend_below(figure, ax, handles=handles, title=title)
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


def _draw_factors(axes: Axes, x: np.ndarray[Any, Any], frame: pd.DataFrame) -> None:
    """Factors of velocity and load at which each row turns severe, hollow if they lie beyond."""
    factors = {name: frame[f"{name} factor"].to_numpy(float) for name in _FACTORS}
    known = np.concatenate([*factors.values(), [0.5, 2.0]])
    low, high = np.nanmin(known) / _ROOM**3, np.nanmax(known) * _ROOM**3
    margins = frame["distance [K]"].to_numpy(float)
    axes.axhline(1.0, color=BLACK, lw=style.THIN)
    for steps, (name, look) in enumerate(_FACTORS.items(), 1):
        aside = ScaledTranslation(_ASIDES[name] / 72, 0, axes.figure.dpi_scale_trans)
        look = look | {"transform": axes.transData + aside}
        axes.plot(x, factors[name], label=f"factor of {name}", gid=name, **look)
        where = np.isnan(factors[name]) & np.isfinite(margins)
        if where.any():
            ends = np.where(margins[where] < 0, low * _ROOM**steps, high / _ROOM**steps)
            look = look | {"mfc": "white", "gid": f"{name}, beyond"}
            axes.plot(x[where], ends, label=f"{name}: beyond what was computed", **look)
    axes.set(yscale="log", ylim=(low, high), ylabel="factor to severe wear")
    axes.yaxis.set_major_locator(FixedLocator([0.5, 0.7, 1.0, 1.4, 2.0]))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter("{x:g} ×")
