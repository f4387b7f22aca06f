"""The figure of a study: processor time against the error of the boundary."""

from __future__ import annotations

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.tradeoff.trade import Trade


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the whole error of the boundary over processor time, of searches and uniform planes."""
    figure, axes = style.canvas((8.0, 5.6))
    axes.set(xscale="log", yscale="log")
    planes = "uniform plane, {} of the surface".format(
        "one patch" if trade.planes[-1].patches == 1 else f"{trade.planes[-1].patches} patches"
    )
    for choices, label, marker, colour in (
        (trade.searches, "search (--accuracy)", "D", VERMILION), (trade.planes, planes, "s", BLUE),
    ):  # fmt: skip
        known = [one for one in choices if np.isfinite(one.error)]
        if known:
            axes.plot(
                [one.seconds for one in known], [one.error for one in known], marker=marker,
                color=colour, lw=style.THIN, mec="white", label=label, gid=label,
                ms=style.BIG * rcParams["lines.markersize"],
            )  # fmt: skip
        labelled = known if choices is trade.searches else [*known[:1], *known[-1:]]
        for place, one in {(one.seconds, one.error): one for one in labelled}.items():
            words = f"{one.points} points" if one.accuracy is None else f"{100 * one.accuracy:g} %"
            up = 1 if one.accuracy is None else -1
            axes.annotate(
                words, place, (8 * up, 4 * up), textcoords="offset points",
                ha="left" if up > 0 else "right", va="bottom" if up > 0 else "top",
                fontweight="bold" if one is trade.advised else "normal", path_effects=style.HALO,
            )  # fmt: skip
    axes.margins(0.12)
    style.plain_numbers(axes)
    axes.set_xlabel("processor time [s]")
    axes.set_ylabel("error of the boundary velocity (95 %)")
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    style.write_title(axes, style.as_text(f"Speed against accuracy: {trade.title}"))
    style.legend_below(figure)
    return figure
