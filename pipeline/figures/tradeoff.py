"""Speed against accuracy as a figure."""

from __future__ import annotations

import itertools
import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from pipeline.figures.labels import Label, name_points
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, in_house_style
from pipeline.tradeoff.trade import Choice, Trade
from tribo import PRESETS

__all__ = ["draw_trade"]

_LEAST = 1e-4  # the smallest error that is told apart from none
_OUTLYING = 0.1  # relative error from which what is varied is not drawn
_NAMED = {"fontsize": 10, "fontweight": "bold", "color": BLACK}
_VARIED = {"fontsize": 7.5, "color": GREY}


@in_house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the error of the boundary velocity over the work of each choice.

    Parameters
    ----------
    trade : Trade
        Of `pipeline.tradeoff.trade.trade`.
    """
    figure = Figure(figsize=(8.0, 5.6))
    axes = figure.add_subplot()
    shown = [
        choice
        for choice in trade.choices[:-1]
        if choice.velocity_error < (_OUTLYING if choice.varied else math.inf)
    ]
    axes.set_xscale("log")
    axes.set_yscale("log")
    front = [choice for choice in trade.front if choice in shown]
    axes.plot(
        [_place(choice)[0] for choice in front],
        [_place(choice)[1] for choice in front],
        drawstyle="steps-post", color=BLUE, lw=1.2, zorder=2, gid="front",
        label="no other choice is both faster and nearer",
    )  # fmt: skip
    for label, chosen, look in _kinds(trade, shown):
        if chosen:
            x, y = zip(*map(_place, chosen), strict=True)
            axes.plot(x, y, ls="none", label=label, gid=label, **look)
    work = [choice.saving for choice in shown]
    axes.set_xlim(max(work) * 2.0, min(work) / 2.0)
    _limit_errors(axes, shown)

    axes.set_xlabel("times less work than the reference  (faster to the left)")
    axes.set_ylabel("largest error of the boundary velocity")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_title(f"Speed against accuracy: {trade.title}", pad=10)
    figure.legend(loc="outside lower center", ncols=4)
    steps = [(x, y) for (_, y), (x, _) in itertools.pairwise(map(_place, front))]
    corners = itertools.chain(*itertools.zip_longest(map(_place, front), steps, fillvalue=None))
    name_points(figure, axes, _labels(trade, shown), [corner for corner in corners if corner])
    return figure


def _place(choice: Choice) -> tuple[float, float]:
    return choice.saving, max(choice.velocity_error, _LEAST)


def _kinds(
    trade: Trade, shown: list[Choice]
) -> tuple[tuple[str, list[Choice], dict[str, Any]], ...]:
    """Name of each kind of choice, those of it, and how they look."""
    varied = [choice for choice in shown if choice.varied]
    presets = [choice for choice in shown if choice.name in PRESETS]
    own = [choice for choice in shown if choice not in varied and choice not in presets]
    return (
        (
            f"one choice of {trade.base} varied",
            varied,
            {"marker": "o", "mfc": "white", "mec": GREY, "ms": 4.5, "zorder": 4},
        ),
        ("presets", presets, {"marker": "D", "mfc": VERMILION, "mec": "white", "ms": 8.5}),
        ("the scene's own", own, {"marker": "s", "mfc": BLACK, "mec": "white", "ms": 7.5}),
    )


def _limit_errors(axes: Axes, shown: list[Choice]) -> None:
    errors = [_place(choice)[1] for choice in shown]
    axes.set_ylim(min(errors) / 1.8, max(errors) * 2.2)


def _labels(trade: Trade, shown: list[Choice]) -> list[Label]:
    """Names of the presets, then of the others from the top down."""
    labels = []
    for choice in sorted(shown, key=lambda choice: (bool(choice.varied), -choice.velocity_error)):
        look = _NAMED if choice.varied is None else _VARIED
        text = choice.name.removeprefix(f"{trade.base}, ") if choice.varied else choice.name
        text = text.replace("history_coarsening", "history grid").replace("_", " ")
        labels.append(Label(text, *_place(choice), look))
    return labels
