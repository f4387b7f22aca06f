"""Figures of studies: inputs that move the boundary, speed against accuracy."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION
from pipeline.run.vary import Variations
from pipeline.scene.units import typeset
from pipeline.tradeoff.trade import Trade
from tribo import PRESETS

_LONGEST = 20  # letters of a value beside a bar
_TICKS = 6


@style.house_style
def draw_variations(varied: Variations) -> Figure:
    """Draw how far each input moves the critical velocity: the most important one on top."""
    keys = varied.keyed_changes()
    figure, axes = style.canvas(None, (7.2, 1.7 + 0.62 * len(keys)))
    ends = {0: BLUE, len(varied.loads) - 1: VERMILION}  # the lowest and the highest load
    height = 0.8 / len(ends)
    for row, variations in enumerate(keys.values()):
        for number, (load, colour) in enumerate(ends.items()):
            place = row + (number - (len(ends) - 1) / 2) * height
            moves = np.array([varied.changes(one)[load] for one in variations])
            low, high = np.nanmin([0.0, *moves]), np.nanmax([0.0, *moves])
            axes.barh(place, high - low, 0.86 * height, low, color=colour, alpha=0.85)
            for one, move in zip(variations, moves, strict=True):
                value = style.as_text(typeset(textwrap.shorten(one.value, _LONGEST)))
                if move in (low, high):
                    _write(axes, value, move, place, is_right=move >= 0)
                elif np.isnan(move):
                    _write(axes, f"no transition at {value}", 0.0, place, is_right=high == 0)
    axes.axvline(0.0, color=BLACK, lw=style.THIN)
    axes.set_yticks(range(len(keys)), [style.entry_label(key) for key in keys])
    axes.set_ylim(len(keys) - 0.5, -0.5)
    axes.margins(x=0.3)  # for the values beside the bars
    axes.grid(visible=False, axis="y")
    axes.xaxis.set_major_locator(MaxNLocator(_TICKS))
    axes.xaxis.set_major_formatter(lambda change, _: f"{100 * change:+.3g} %")
    axes.set_xlabel("change of the critical velocity")
    for load, colour in ends.items():
        critical = varied.base.critical_velocities[load]
        begins = f"from {critical:.3g} m/s" if critical > 0 else varied.base.outcomes[load]
        axes.plot([], [], color=colour, lw=6, label=f"at {varied.loads[load]:g} N, {begins}")
    style.legend_below(figure, ncols=len(ends))
    style.write_title(figure, style.as_text(varied.title))
    return figure


def _write(axes: Any, words: str, end: float, place: float, is_right: bool) -> None:
    """Write words beside the end of a bar."""
    offset, side = (4, "left") if is_right else (-4, "right")
    axes.annotate(
        words, (end, place), (offset, 0), textcoords="offset points", ha=side, va="center",
        color=GREY, fontsize="small",
    )  # fmt: skip


_LEAST_ERROR = 1e-4  # the smallest error that is told apart from none


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the error of the boundary velocity over the processor time of each choice."""
    figure, axes = style.canvas(None, (8.0, 5.6))
    choices = trade.choices[:-1]  # but for the reference, which has no error
    axes.set(xscale="log", yscale="log")
    places = {one.name: (one.seconds, max(one.velocity_error, _LEAST_ERROR)) for one in choices}
    front = [places[one.name] for one in trade.front if one.name in places]
    axes.plot(
        *np.transpose(front), drawstyle="steps-post", color=BLUE, lw=style.THIN, gid="front",
        label="no other choice is both faster and nearer",
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
