"""Figures of studies: inputs that move the boundary, speed against accuracy."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION
from pipeline.run.vary import Variation, Variations
from pipeline.scene.units import typeset
from pipeline.sweep.selection import Choice
from pipeline.tradeoff.trade import Trade
from tribo import PRESETS

_LONGEST = 20  # letters of a value beside a bar
_LEAST = 0.01  # change on either side for which there is room where nothing moves
_REMARK: dict[str, Any] = {"fontsize": "x-small", "style": "italic"}

_TICKS = 6
_POWER = re.compile(r"(?<=\d)[eE]([+-]?\d+)")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@style.house_style
def draw_variations(varied: Variations) -> Figure:
    """Draw how far each input moves the critical velocity: the most important one on top."""
    keys = varied.keyed_changes()
    figure, axes = style.canvas(None, (7.2, 1.7 + 0.62 * len(keys)))
    ends = {0: BLUE, len(varied.loads) - 1: VERMILION}  # the lowest and the highest load
    height = 0.8 / len(ends)
    longest = _LONGEST if any(len(values) > 1 for values in keys.values()) else 0
    for row, variations in enumerate(keys.values()):
        for place, (load, colour) in enumerate(ends.items()):
            height_of_bar = row + (place - (len(ends) - 1) / 2) * height
            moves = [(one.value, varied.changes(one)[load]) for one in variations]
            _bar(axes, moves, longest, height_of_bar, 0.86 * height, colour)
    axes.axvline(0.0, color=BLACK, lw=style.THIN)
    axes.set_yticks(
        range(len(keys)), [_named(key, values, longest) for key, values in keys.items()]
    )
    axes.set_ylim(len(keys) - 0.5, -0.5)
    moved = np.array([varied.changes(one)[list(ends)] for one in varied.others])
    moved = moved[np.isfinite(moved)]
    low, high = moved.min(initial=0.0), moved.max(initial=0.0)
    if low == high:
        low, high = -_LEAST, _LEAST
    room = 0.45 * (high - low)  # for the values beside the bars
    axes.set_xlim(low - room, high + room)
    axes.grid(visible=False, axis="y")
    axes.xaxis.set_major_locator(MaxNLocator(_TICKS))
    axes.xaxis.set_major_formatter(signed)
    axes.set_xlabel("change of the critical velocity")
    for load, colour in ends.items():
        critical_velocity = varied.base.critical_velocities[load]
        outcome = varied.base.outcomes[load]
        begins = f"from {critical_velocity:.3g} m/s" if np.isfinite(critical_velocity) else outcome
        axes.plot([], [], color=colour, lw=6, label=f"at {varied.loads[load]:g} N, {begins}")
    style.legend_below(figure, ncols=len(ends))
    style.write_title(figure, style.as_text(varied.title))
    return figure


def signed(change: float, _: object = None) -> str:
    """A relative change in percent, with its sign."""
    return f"{100 * change:+.3g} %".replace("-", "−") if change else "0 %"


def _named(key: str, variations: list[Variation], longest: int) -> str:
    """Name of a row in words, with values that are too long to stand at a bar's end."""
    values = [
        style.as_text(variation.value) for variation in variations if len(variation.value) > longest
    ]
    return "\n".join([style.entry_label(key), *(textwrap.fill(value, 42) for value in values)])


def printed(value: str) -> str:
    """A value as in print, with raised powers."""
    value = typeset(value)
    power = _POWER.search(value)
    if power:
        exponent = str(int(power[1])).translate(_RAISED)
        value = value.replace(power[0], f"·10{exponent}")
    return style.as_text(value)


def _bar(
    axes: Axes,
    moves: list[tuple[str, float]],
    longest: int,
    position: float,
    height: float,
    colour: str,
) -> None:
    """One bar from the least to the greatest change, its ends named by values or changes."""
    changes = np.array([change for _, change in moves])
    is_finite = np.isfinite(changes)
    if not is_finite.any():
        axes.text(0.0, position, " no transition", va="center", color=GREY, **_REMARK)
        return

    def mark_end(end: float, text: str, is_right: bool, **look: Any) -> None:
        offset, side = (4, "left") if is_right else (-4, "right")
        axes.annotate(
            text, (end, position), (offset, 0), textcoords="offset points", ha=side, va="center",
            color=GREY, **look,
        )  # fmt: skip

    low, high = min(0.0, np.nanmin(changes)), max(0.0, np.nanmax(changes))
    axes.barh(position, high - low, left=low, height=height, color=colour, alpha=0.85)
    for value, change in moves:
        if change in (low, high):
            words = printed(value) if len(value) <= longest else signed(change)
            mark_end(change, words, change >= 0, fontsize="small")
    if not is_finite.all():
        text = "no transition at " + ", ".join(
            printed(value) for value, change in moves if not np.isfinite(change)
        )
        is_right = high == 0.0  # where no bar is
        mark_end(high if is_right else low, text, is_right, **_REMARK)


_LEAST_ERROR = 1e-4  # the smallest error that is told apart from none


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the error of the boundary velocity over the processor time of each choice."""
    figure, axes = style.canvas()
    choices = trade.choices[:-1]  # but for the reference, which has no error
    axes.set(xscale="log", yscale="log")
    axes.plot(
        *_places([choice for choice in trade.front if choice in choices]),
        drawstyle="steps-post", color=BLUE, lw=style.THIN, gid="front",
        label="no other choice is both faster and nearer",
    )  # fmt: skip
    presets = [choice for choice in choices if choice.name in PRESETS]
    others = [choice for choice in choices if choice not in presets]
    for label, of_kind, marker, colour in (
        ("presets", presets, "D", VERMILION),
        ("the scene's own", others, "s", BLACK),
    ):
        if of_kind:
            axes.plot(
                *_places(of_kind), ls="none", marker=marker, ms=style.BIG, mfc=colour, mec="white",
                label=label, gid=label,
            )  # fmt: skip
    for choice in (*presets, *others):
        axes.annotate(
            choice.name, (choice.seconds, _error(choice)), (-8, -4), textcoords="offset points",
            ha="right", va="top", fontweight="bold", path_effects=style.HALO,
        )  # fmt: skip
    axes.margins(0.12)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.set_xlabel("processor time of the points [s]")
    axes.set_ylabel("largest error of the boundary velocity")
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    style.write_title(axes, style.as_text(f"Speed against accuracy: {trade.title}"))
    style.legend_below(figure)
    return figure


def _places(choices: Sequence[Choice]) -> tuple[list[float], list[float]]:
    """Times and errors of some choices."""
    return [choice.seconds for choice in choices], [_error(choice) for choice in choices]


def _error(choice: Choice) -> float:
    return max(choice.velocity_error, _LEAST_ERROR)
