"""Inputs that move the boundary, one at a time, as a tornado."""

from __future__ import annotations

import re
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pipeline.figures.style import (
    BLACK,
    BLUE,
    GREY,
    VERMILION,
    as_text,
    as_title,
    canvas,
    entry_label,
    in_house_style,
    legend_below,
)
from pipeline.run.vary import Variation, Variations

_LONGEST = 20  # letters of a value beside a bar
_LEAST = 0.01  # change on either side for which there is room where nothing moves

_TICKS = 6
_POWER = re.compile(r"(?<=\d)[eE]([+-]?\d+)")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SIGNS = {"um": "µm", "deg": "°", "^2": "²", "^3": "³"}


@in_house_style
def draw_variations(varied: Variations) -> Figure:
    """Draw how far each input moves the critical velocity: the most important one on top.

    Parameters
    ----------
    varied : Variations
        Result of `pipeline.vary`.

    Examples
    --------
    >>> import pipeline
    >>> base = Variation("", "", (2.17,), ("crosses",))
    >>> other = Variation("friction.coefficient", "0.12", (1.63,), ("crosses",))
    >>> variations = Variations("A scene", (400.0,), base, (other,), points=8, contacts=8)
    >>> figure = pipeline.draw_variations(variations)
    """
    keys = varied.by_key()
    figure, axes = canvas(None, (7.2, 1.7 + 0.62 * len(keys)))
    ends = {0: BLUE, len(varied.loads) - 1: VERMILION}  # the lowest and the highest load
    height = 0.8 / len(ends)
    for row, variations in enumerate(keys.values()):
        for place, (load, colour) in enumerate(ends.items()):
            height_of_bar = row + (place - (len(ends) - 1) / 2) * height
            _bar(axes, varied, variations, load, height_of_bar, 0.86 * height, colour)
    axes.axvline(0.0, color=BLACK, lw=1.0)
    axes.set_yticks(range(len(keys)), [_named(key, values) for key, values in keys.items()])
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
    axes.xaxis.set_major_formatter(lambda value, _: f"{100 * value:+.3g} %" if value else "0 %")
    axes.set_xlabel("change of the critical velocity")
    for load, colour in ends.items():
        critical_velocity = varied.base.critical_velocities[load]
        outcome = varied.base.outcomes[load]
        begins = f"from {critical_velocity:.3g} m/s" if np.isfinite(critical_velocity) else outcome
        axes.plot([], [], color=colour, lw=6, label=f"at {varied.loads[load]:g} N, {begins}")
    legend_below(figure, ncols=len(ends))
    axes.set_title(as_title(varied.title, 60), x=0.3)
    return figure


def _named(key: str, variations: list[Variation]) -> str:
    """Name of a row in words, with values that are too long to stand at a bar's end."""
    values = [
        as_text(variation.value) for variation in variations if len(variation.value) > _LONGEST
    ]
    return "\n".join([entry_label(key), *(textwrap.fill(value, 42) for value in values)])


def _shown(value: str) -> str:
    """Write a value as in print.

    Examples
    --------
    >>> _shown("1.44e-06 mm^3/(N m)"), _shown("3 um"), _shown("145 degC")
    ('1.44·10⁻⁶ mm³/(N m)', '3 µm', '145 °C')
    """
    for sign, printed in _SIGNS.items():
        value = value.replace(sign, printed)
    power = _POWER.search(value)
    if power:
        exponent = str(int(power[1])).translate(_RAISED)
        value = value.replace(power[0], f"·10{exponent}")
    return as_text(value)


def _bar(
    axes: Axes,
    varied: Variations,
    variations: list[Variation],
    load: int,
    position: float,
    height: float,
    colour: str,
) -> None:
    """One bar from the least to the greatest change at a load, its ends named by the values."""
    changes = np.array([varied.changes(variation)[load] for variation in variations])
    is_finite = np.isfinite(changes)
    if not is_finite.any():
        axes.text(
            0.0, position, " no transition", va="center", fontsize=7, color=GREY, style="italic"
        )
        return

    def beside(end: float, text: str, is_right: bool, **look: Any) -> None:
        offset, side = (4, "left") if is_right else (-4, "right")
        axes.annotate(
            text, (end, position), (offset, 0), textcoords="offset points", ha=side, va="center",
            color=GREY, **look,
        )  # fmt: skip

    low, high = min(0.0, np.nanmin(changes)), max(0.0, np.nanmax(changes))
    axes.barh(position, high - low, left=low, height=height, color=colour, alpha=0.85)
    for variation, change in zip(variations, changes, strict=True):
        if change in (low, high):
            words = f"{100 * change:+.1f} %"
            if len(variation.value) <= _LONGEST:
                words = _shown(variation.value)
            beside(change, words, change >= 0, fontsize=8)
    if not is_finite.all():
        text = "no transition at " + ", ".join(
            _shown(variation.value)
            for variation, is_known in zip(variations, is_finite, strict=True)
            if not is_known
        )
        is_right = high == 0.0  # where no bar is
        beside(high if is_right else low, text, is_right, fontsize=7, style="italic")
