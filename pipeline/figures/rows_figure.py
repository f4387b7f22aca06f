"""Operating points row by row, such as a load cycle or a gear mesh, and the most critical row."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import pipeline
from pipeline.answers.answer_frames import row_labels
from pipeline.answers.answer_lines import conditions_lines
from pipeline.answers.results import sweep_of
from pipeline.answers.value_text import attribute_texts, format_limit, probability_text
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, TINTS, VERMILION
from pipeline.messages import split_notes
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


@style.house_style
def rows(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Figure:
    """Draw the temperature margin of each row of a sweep, with its label."""
    margins = pipeline.margin(ds, **conditions)
    if len(margins.sizes) != 1:
        raise InputError(f"rows under several conditions ({', '.join(map(str, margins.sizes))})")
    return draw_rows(margins, style.as_text(sweep_of(ds).title))


@style.house_style
def draw_rows(margins: xr.Dataset, title: str) -> Figure:
    """Draw operating points, an answer of `pipeline.margin` along one dimension, downwards.

    The temperature margin has its numerical error; at the right stands the probability of severe
    wear and the safety factor of friction. The most critical row is bold: that with the highest
    probability.
    """
    margin, error = (margins[name].values for name in ("temperature_margin", "temperature_error"))
    if np.isnan(margin).all():
        raise InputError(f"no row has a verdict: {margins['reason'].values[0]}")
    names = [style.as_text(label) for label in row_labels(margins, *map(str, margins.sizes))]
    letters_per_line = int(6 * style.width_or(_USUAL_WIDTH))
    labels = [textwrap.fill(name, letters_per_line) for name in names]
    lines_per_row = 1 + max(label.count("\n") for label in labels)
    positions = np.arange(len(names))
    height = 1.6 + 0.32 * min(len(names), _MAX_LABELS) * lines_per_row
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
                margin[is_verdict], positions[is_verdict], ls="none", ms=7, label=label, **look
            )
    critical_row = most_critical_row(margins)
    _label_rows(axes, margins, labels, critical_row)
    axes.axhspan(critical_row - 0.5, critical_row + 0.5, fc="none", ec=BLACK, lw=style.THIN, ls=":")
    axes.set(
        xlim=(low - padding, high + padding), ylim=(len(names) - 0.5, -0.5),
        xlabel="temperature margin: critical minus governing temperature [K]",
    )  # fmt: skip
    style.write_title(axes, title)
    lines = [
        f"most critical: {names[critical_row]}",
        "at the right: probability of severe wear, safety factor of friction",
    ]
    lines += conditions_lines(margins)
    lines += [f"model error: {text}" for text in attribute_texts(margins, "model_error")[:1]]
    lines += split_notes(attribute_texts(margins, "notes"))[:1]
    style.legend_below(figure, 3, caption="\n".join(lines))
    return figure


def _label_rows(axes: Axes, margins: xr.Dataset, labels: Sequence[str], critical_row: int) -> None:
    """Write labels at the left of rows, and at their right the probability and the safety factor.

    Those of the most critical row are bold. Of many rows, only some are labelled.
    """
    labelled_rows = np.union1d(
        np.arange(len(labels))[:: -(-len(labels) // _MAX_LABELS)], [critical_row]
    )
    ticks = axes.set_yticks(labelled_rows, [labels[row] for row in labelled_rows])
    temperature_margins, probabilities, factors = (
        margins[name].values.tolist()
        for name in ("temperature_margin", "probability", "friction_safety_factor")
    )
    for tick, row in zip(ticks, labelled_rows, strict=True):
        weight = "bold" if row == critical_row else "normal"
        tick.label1.set_fontweight(weight)
        factor = format_limit(factors[row])
        text = f"{probability_text(probabilities[row])}, {factor}" if factor else ""
        axes.annotate(
            "unknown" if np.isnan(temperature_margins[row]) else text, (1.0, row), (4, 0),
            xycoords=("axes fraction", "data"), va="center", textcoords="offset points",
            annotation_clip=False, fontsize="small", fontweight=weight,
        )  # fmt: skip


def most_critical_row(margins: xr.Dataset) -> int:
    """Index of the row with the highest probability; of equal rows, that with the least margin."""
    probability = np.nan_to_num(margins["probability"].values, nan=-1.0)
    return int(np.lexsort((-margins["temperature_margin"].values, probability))[-1])
