"""The figure of a study: speed against accuracy."""

from __future__ import annotations

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, VERMILION
from pipeline.tradeoff.trade import Trade
from tribo import PRESETS

_LEAST_ERROR = 1e-4  # smallest error drawn on the logarithmic axis


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the largest error of the critical velocity over processor time.

    Each mark is a fidelity, a set of numerical choices.
    """
    figure, axes = style.canvas((8.0, 5.6))
    choices = trade.choices[:-1]  # without the reference, whose error is 0
    axes.set(xscale="log", yscale="log")
    places = {one.name: (one.seconds, max(one.velocity_error, _LEAST_ERROR)) for one in choices}
    front = [places[one.name] for one in trade.front if one.name in places]
    axes.plot(
        *np.transpose(front), drawstyle="steps-post", color=BLUE, lw=style.THIN, gid="front",
        label="no other choice is both faster and more accurate",
    )  # fmt: skip
    for label, is_preset, marker, colour in (
        ("presets", True, "D", VERMILION), ("the scene's own", False, "s", BLACK),
    ):  # fmt: skip
        of_kind = [place for name, place in places.items() if (name in PRESETS) == is_preset]
        if of_kind:
            axes.plot(
                *np.transpose(of_kind), ls="none", marker=marker, mfc=colour, mec="white",
                ms=style.BIG * rcParams["lines.markersize"], label=label, gid=label,
            )  # fmt: skip
    for name, place in places.items():
        axes.annotate(
            name, place, (-8, -4), textcoords="offset points", ha="right", va="top",
            fontweight="bold", path_effects=style.HALO,
        )  # fmt: skip
    axes.margins(0.12)
    style.plain_numbers(axes)
    axes.set_xlabel("processor time of the points [s]")
    axes.set_ylabel("largest error of the boundary velocity")
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    style.write_title(axes, style.as_text(f"Speed against accuracy: {trade.title}"))
    style.legend_below(figure)
    return figure
