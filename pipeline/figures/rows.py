"""Operating points row by row: a duty, a cam or a gear mesh, and the row that decides."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import pipeline
from pipeline.answers import words
from pipeline.answers.results import sweep_of
from pipeline.answers.verdict import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, TINTS, VERMILION
from tribo import InputError

MARKS: dict[int, tuple[str, dict[str, Any]]] = {
    MILD: ("mild", {"marker": "o", "mfc": "white", "mec": BLUE}),
    UNDECIDED: ("undecided", {"marker": "D", "mfc": TINTS["severe"], "mec": VERMILION}),
    SEVERE: ("severe", {"marker": "s", "mfc": VERMILION, "mec": VERMILION}),
    OUTSIDE: ("outside the model", {"marker": "X", "mfc": "white", "mec": GREY}),
}
"""Label and mark of a row by its verdict."""
_WIDTH = 8.0  # usual width [in]
_LETTERS = 6  # letters of a row's label, for each inch of width
_HIGHEST = 0.32  # height of a line of a label in a figure of few rows [in]
_MOST_NAMED = 40  # rows up to which each has its label


@style.house_style
def rows(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Figure:
    """Draw the temperature margin of each row of a sweep, with its label."""
    found = pipeline.margin(ds, **conditions)
    if len(found.sizes) != 1:
        raise InputError(f"rows under several conditions ({', '.join(map(str, found.sizes))})")
    return draw_rows(found, style.as_text(sweep_of(ds).title))


@style.house_style
def draw_rows(found: xr.Dataset, title: str) -> Figure:
    """Draw operating points, an answer of `pipeline.margin` along one dimension, downwards.

    The temperature margin has its numerical error; at the right stands the probability of severe
    wear. The most critical row is bold: that with the highest probability.
    """
    margin, error = (found[name].values for name in ("temperature_margin", "temperature_error"))
    if np.isnan(margin).all():
        raise InputError(f"no row has a verdict: {found['reason'].values[0]}")
    names = [style.as_text(one) for one in words.row_labels(found, *map(str, found.sizes))]
    labels = [textwrap.fill(one, int(_LETTERS * style.wanted_width(_WIDTH))) for one in names]
    lines_of_row = 1 + max(one.count("\n") for one in labels)
    places = np.arange(len(names))
    height = 1.6 + _HIGHEST * min(len(names), _MOST_NAMED) * lines_of_row
    figure, axes = style.canvas((_WIDTH, height))
    axes.axvline(0.0, color=BLACK, label="critical temperature")
    low, high = min(0.0, np.nanmin(margin - np.nan_to_num(error))), max(0.0, np.nanmax(margin))
    room = 0.08 * (high - low)
    axes.axvspan(low - room, 0.0, fc=TINTS["severe"], zorder=0)
    axes.errorbar(
        margin, places, xerr=np.nan_to_num(error), fmt="none", ecolor=GREY, elinewidth=1.2,
        label="numerical error",
    )  # fmt: skip
    for verdict, (label, look) in MARKS.items():
        here = found["verdict"].values == verdict
        if here.any():
            axes.plot(margin[here], places[here], ls="none", ms=7, label=label, **look)
    decides = deciding_row(found)
    axes.annotate(
        "probability of severe wear", (1.0, 1.0), (60, 5), xycoords="axes fraction", ha="right",
        textcoords="offset points", annotation_clip=False, fontsize="small",
    )  # fmt: skip
    ticks = places if len(names) <= _MOST_NAMED else places[:: -(-len(names) // _MOST_NAMED)]
    ticks = np.union1d(ticks, [decides])
    shown = axes.set_yticks(ticks, [labels[k] for k in ticks])
    for side in ticks:
        likely = found["probability"].values[side]
        text = "" if np.isnan(likely) else words.probability_text(likely)
        axes.annotate(
            "unknown" if np.isnan(margin[side]) else text, (1.0, side), (4, 0),
            xycoords=("axes fraction", "data"), va="center", textcoords="offset points",
            annotation_clip=False, fontsize="small",
            fontweight="bold" if side == decides else "normal",
        )  # fmt: skip
    for tick, place in zip(shown, ticks, strict=True):
        tick.label1.set_fontweight("bold" if place == decides else "normal")
    axes.axhspan(decides - 0.5, decides + 0.5, fc="none", ec=BLACK, lw=style.THIN, ls=":")
    axes.set(
        xlim=(low - room, high + room), ylim=(len(names) - 0.5, -0.5),
        xlabel="temperature margin: critical minus governing temperature [K]",
    )  # fmt: skip
    style.write_title(axes, title)
    lines = [f"most critical: {names[decides]}"]
    lines += words.conditions_lines(found)
    lines += [f"model error: {one}" for one in words.attribute_texts(found, "model_error")[:1]]
    style.legend_below(figure, 3, caption="\n".join(lines))
    return figure


def deciding_row(found: xr.Dataset) -> int:
    """Position of the row that is most likely severe; of equal ones that with the least margin."""
    likely = np.nan_to_num(found["probability"].values, nan=-1.0)
    return int(np.lexsort((-found["temperature_margin"].values, likely))[-1])
