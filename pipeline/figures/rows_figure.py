"""Operating points row by row, such as a load cycle or a gear mesh, and the most critical row."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import pipeline
from pipeline.answers.answer_frames import row_labels
from pipeline.answers.facts import fact_lines
from pipeline.answers.results import cases_of, sweep_of
from pipeline.answers.value_text import variable_texts
from pipeline.answers.verdict_limits import Side
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
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
_USUAL_WIDTH = 8.0  # [in]
_MAX_LABELS = 40  # most rows that are all labelled
_COLUMN_WIDTH = 6.2  # of a column of numbers, over the size of the font
_SIGNS = {"less than": "<", "more than": ">", "below": "<", "above": ">"}
"""Shorter words for narrow columns."""


@style.house_style
def rows(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Figure:
    """Draw the temperature margin of each row of a sweep, with its label."""
    if not cases_of(ds)[0].is_row:
        raise InputError(
            "the sweep has no rows, each with its own load; irg plot draws its diagram"
        )
    margins = pipeline.margin(ds, **conditions)
    if len(margins.sizes) != 1:
        names = ", ".join(map(str, margins.sizes))
        raise InputError(f"cannot draw rows under several conditions ({names}); select one")
    return draw_rows(margins, style.as_text(sweep_of(ds).title))


@style.house_style
def draw_rows(margins: xr.Dataset, title: str) -> Figure:
    """Draw operating points, an answer of `pipeline.margin` along one dimension, downwards.

    The temperature margin has its numerical error; two columns at the right have the probability of
    severe wear and the safety factor of friction. Rows with load factors have bars up to the mild
    ones. The most critical row is bold.
    """
    margin, error = (margins[name].values for name in ("temperature_margin", "temperature_error"))
    if np.isnan(margin).all():
        raise InputError(f"no row has a verdict: {margins['reason'].values[0]}")
    names = [style.as_text(label) for label in row_labels(margins, *map(str, margins.sizes))]
    letters_per_line = int(6 * style.width_or(_USUAL_WIDTH))
    labels = [textwrap.fill(name, letters_per_line) for name in names]
    lines_per_row = 1 + max(label.count("\n") for label in labels)
    positions = np.arange(len(names))
    height = 2.2 + 0.32 * min(len(names), _MAX_LABELS) * lines_per_row
    figure, axes = style.canvas((_USUAL_WIDTH, height))
    axes.axvline(0.0, color=BLACK, label="critical temperature")
    low, high = min(0.0, np.nanmin(margin - np.nan_to_num(error))), max(0.0, np.nanmax(margin))
    padding = 0.08 * (high - low)
    axes.axvspan(low - padding, 0.0, fc=TINTS["severe"], zorder=0)
    axes.errorbar(
        margin, positions, xerr=np.nan_to_num(error), fmt="none", ecolor=GREY, elinewidth=1.2,
        label="numerical error",
    )  # fmt: skip
    for verdict, (label, look) in MARKS.items():
        is_verdict = margins["verdict"].values == verdict
        if is_verdict.any():
            axes.plot(
                margin[is_verdict], positions[is_verdict], ls="none", label=label, clip_on=False,
                ms=1.5 * rcParams["lines.markersize"], **look,
            )  # fmt: skip
    critical_row = most_critical_row(margins)
    axes.set(
        xlim=(low - padding, high + padding), ylim=(len(names) - 0.5, -0.5),
        xlabel="temperature margin: critical minus governing temperature [K]",
    )  # fmt: skip
    panels, lines = [axes], [f"most critical: {names[critical_row]}"]
    if "mild_load_factor" in margins:
        axes.set_xlabel("critical minus\ngoverning\ntemperature [K]")
        panels.append(_draw_load_factors(axes, margins))
    _label_rows(axes, margins, labels, critical_row, panels[-1])
    for panel in panels:
        panel.axhspan(
            critical_row - 0.5, critical_row + 0.5, fc="none", ec=BLACK, lw=style.THIN, ls=":"
        )
    style.write_title(figure, title)  # above the headings of the columns
    lines += fact_lines(margins, "mild load factor", "conditions", "model error")
    lines += fact_lines(margins, "note")[:1]
    style.legend_below(figure, 3, caption="\n".join(lines))
    return figure


def _draw_load_factors(axes: Axes, margins: xr.Dataset) -> Axes:
    """Draw the mild load factor of each row at the right of `axes`; return the axes of the bars.

    A bar ends at the largest load factor if the row is mild there; below the smallest is none.
    """
    factors, sides = margins["mild_load_factor"], margins["mild_load_factor_side"].values
    high = factors.attrs["valid_range"][1]
    grid = axes.figure.add_gridspec(1, 2, width_ratios=(5, 3))
    axes.set_subplotspec(grid[0])
    panel: Axes = axes.figure.add_subplot(grid[1], sharey=axes)
    ends = np.where(sides == Side.ABOVE, high, np.nan_to_num(factors.values))
    positions = np.arange(len(ends))
    panel.barh(positions, ends, height=0.5, color=BLUE, label="mild load factor")
    texts = variable_texts(margins, "mild_load_factor").values
    for position, text, side in zip(positions, texts, sides, strict=True):
        is_above = side == Side.ABOVE
        panel.annotate(
            _with_signs(text), (high if is_above else ends[position], position),
            (-4 if is_above else 4, 0), textcoords="offset points", fontsize="small", va="center",
            ha="right" if is_above else "left", color="white" if is_above else BLACK,
        )  # fmt: skip
    panel.axvline(1.0, color=BLACK, lw=style.THIN, ls="--", zorder=0)
    panel.tick_params(labelleft=False)
    panel.set(xlim=(0.0, 1.05 * high), xlabel="load over load\nof the row")
    return panel


def _label_rows(
    axes: Axes, margins: xr.Dataset, labels: Sequence[str], critical_row: int, last_panel: Axes
) -> None:
    """Write labels at the left of rows, and the columns of numbers beside `last_panel`.

    Those of the most critical row are bold. Of many rows, only some are labelled.
    """
    labelled_rows = np.union1d(
        np.arange(len(labels))[:: -(-len(labels) // _MAX_LABELS)], [critical_row]
    )
    ticks = axes.set_yticks(labelled_rows, [labels[row] for row in labelled_rows])
    probabilities, factors = (
        variable_texts(margins, name).values.tolist()
        for name in ("probability", "friction_safety_factor")
    )
    is_unknown = margins["temperature_margin"].isnull().values
    columns = {
        "probability\nof severe\nwear": np.where(
            is_unknown, "unknown", [*map(_with_signs, probabilities)]
        ),
        "safety\nfactor of\nfriction": factors,
    }
    for tick, row in zip(ticks, labelled_rows, strict=True):
        tick.label1.set_fontweight("bold" if row == critical_row else "normal")
    for column, (heading, texts) in enumerate(columns.items()):
        offset = 4 + column * _COLUMN_WIDTH * rcParams["font.size"]
        look: dict[str, Any] = {
            "textcoords": "offset points", "annotation_clip": False, "fontsize": "small",
        }  # fmt: skip
        last_panel.annotate(
            heading, (1.0, 1.0), (offset, 3), xycoords="axes fraction", va="bottom", **look
        )
        for row in labelled_rows:
            last_panel.annotate(
                texts[row], (1.0, row), (offset, 0), xycoords=("axes fraction", "data"),
                va="center", fontweight="bold" if row == critical_row else "normal", **look,
            )  # fmt: skip


def _with_signs(text: str) -> str:
    """Text with signs in place of words, such as "< 1 %" for "less than 1 %"."""
    for words, sign in _SIGNS.items():
        text = text.replace(words, sign)
    return text


def most_critical_row(margins: xr.Dataset) -> int:
    """Index of the row that governs by its load factor, else of that with the highest probability.

    Of equal rows it is that with the least temperature margin.
    """
    if "governs" in margins and margins["governs"].any():
        return int(np.argmax(margins["governs"].values))
    probability = np.nan_to_num(margins["probability"].values, nan=-1.0)
    return int(np.lexsort((-margins["temperature_margin"].values, probability))[-1])
