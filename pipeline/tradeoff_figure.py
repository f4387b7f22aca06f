"""Speed against accuracy as a figure."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, NullFormatter

from pipeline.style import BLACK, BLUE, GREY, VERMILION, in_house_style
from pipeline.tradeoff import Choice, Trade

__all__ = ["draw_trade"]

_LEAST = 1e-4  # the smallest error that is told apart from none
_OUTLYING = 0.1  # relative error from which what is varied is not drawn
_CROWDED = 0.032  # of the axes: how near the labels of two choices may come


@in_house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the error of the boundary velocity over the work of each choice.

    Parameters
    ----------
    trade : Trade
        Of `pipeline.tradeoff.trade`.
    """
    figure = Figure(figsize=(8.0, 5.6))
    axes = figure.add_subplot()
    shown = [
        choice
        for choice in trade.choices[:-1]
        if choice.varied is None or choice.velocity_error < _OUTLYING
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
    looks: tuple[tuple[bool, dict[str, Any], str], ...] = (
        (False, {"marker": "o", "mfc": "white", "mec": GREY, "ms": 4.5}, _varied_label(trade)),
        (True, {"marker": "D", "mfc": VERMILION, "mec": "white", "ms": 8.5}, "presets"),
    )
    for is_preset, look, label in looks:
        places = [_place(choice) for choice in shown if (choice.varied is None) == is_preset]
        if places:
            x, y = zip(*places, strict=True)
            axes.plot(x, y, ls="none", zorder=3 + is_preset, label=label, gid=label, **look)
    work = [choice.saving for choice in shown]
    axes.set_xlim(max(work) * 2.0, min(work) / 2.0)
    _limit_errors(axes, shown)
    _labels(figure, axes, trade, shown)

    axes.set_xlabel("times less work than the reference  (faster to the left)")
    axes.set_ylabel("largest error of the boundary velocity")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_title(f"Speed against accuracy: {trade.title}", pad=10)
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _place(choice: Choice) -> tuple[float, float]:
    return choice.saving, max(choice.velocity_error, _LEAST)


def _varied_label(trade: Trade) -> str:
    return f"one choice of {trade.base} varied" if trade.base else "varied"


def _limit_errors(axes: Axes, shown: list[Choice]) -> None:
    errors = [_place(choice)[1] for choice in shown]
    axes.set_ylim(min(errors) / 1.8, max(errors) * 2.2)


def _labels(figure: Figure, axes: Axes, trade: Trade, shown: list[Choice]) -> None:
    """Name the presets, and each varied choice that has room for its name."""
    figure.draw_without_rendering()
    taken: list[tuple[float, float, float]] = []
    to_axes = axes.transData + axes.transAxes.inverted()
    for choice in sorted(shown, key=lambda choice: choice.varied is not None):
        x, y = to_axes.transform(_place(choice))
        preset = choice.varied is None
        text = choice.name if preset else choice.name.removeprefix(f"{trade.base}, ")
        text = text.replace("history_coarsening", "history grid").replace("_", " ")
        width = (0.0155 if preset else 0.0115) * len(text)
        left = x + 0.015 + width > 1.0
        extent = (x - width, x) if left else (x, x + width)
        if not preset and any(
            abs(y - other_y) < _CROWDED and extent[0] - 0.01 < b and a < extent[1] + 0.01
            for a, b, other_y in taken
        ):
            continue
        taken.append((*extent, y))
        axes.annotate(
            text,
            _place(choice),
            xytext=(-6 if left else 6, 6),
            textcoords="offset points",
            ha="right" if left else "left",
            va="bottom",
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
            fontsize=10 if preset else 7.5,
            fontweight="bold" if preset else "normal",
            color=BLACK if preset else GREY,
            zorder=5,
        )
