"""Speed against accuracy as a figure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.ticker import NullFormatter
from matplotlib.transforms import Bbox

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, Picture, as_title, in_house_style
from pipeline.tradeoff.table import Choice, Trade
from tribo import PRESETS

_LEAST = 1e-4  # the smallest error that is told apart from none
_OUTLYING = 0.1  # relative error from which what is varied is not drawn
_NAMED: dict[str, Any] = {"fontsize": 10, "fontweight": "bold", "color": BLACK}
_VARIED: dict[str, Any] = {"fontsize": 7.5, "color": GREY}
_SIDES = ((1, 1), (1, -1), (1, 0), (-1, 0), (-1, 1), (-1, -1))  # of a point, right and up
_LEAD = {"arrowstyle": "-", "lw": 0.5, "color": GREY, "shrinkA": 1, "shrinkB": 4}


@in_house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the error of the boundary velocity over the work of each choice.

    Parameters
    ----------
    trade : Trade
        Result of `pipeline.trade`.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> figure = pipeline.draw_trade(pipeline.trade(scene))  # doctest: +SKIP
    >>> figure.savefig("trade.png")  # doctest: +SKIP
    """
    figure = Picture(figsize=(8.0, 5.6))
    axes = figure.add_subplot()
    choices = [
        choice
        for choice in trade.choices[:-1]
        if choice.velocity_error < (_OUTLYING if choice.varied else math.inf)
    ]
    axes.set(xscale="log", yscale="log")
    front = [choice for choice in trade.front if choice in choices]
    axes.plot(
        [_place(choice)[0] for choice in front],
        [_place(choice)[1] for choice in front],
        drawstyle="steps-post", color=BLUE, lw=1.2, zorder=2, gid="front",
        label="no other choice is both faster and nearer",
    )  # fmt: skip
    for label, of_kind, look in _kinds(trade, choices):
        if of_kind:
            x, y = zip(*map(_place, of_kind), strict=True)
            axes.plot(x, y, ls="none", label=label, gid=label, **look)
    work = [choice.saving for choice in choices]
    axes.set_xlim(max(work) * 2.0, min(work) / 2.0)
    errors = [_place(choice)[1] for choice in choices]
    axes.set_ylim(min(errors) / 1.8, max(errors) * 2.2)

    axes.set_xlabel("times less work than the reference  (faster to the left)")
    axes.set_ylabel("largest error of the boundary velocity")
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_title(as_title(f"Speed against accuracy: {trade.title}"), pad=10)
    figure.legend(loc="outside lower center", ncols=4)
    figure.draw_without_rendering()  # names go by the final scales
    _name(figure, axes, trade, choices, front)
    return figure


def _place(choice: Choice) -> tuple[float, float]:
    return choice.saving, max(choice.velocity_error, _LEAST)


def _kinds(
    trade: Trade, choices: list[Choice]
) -> tuple[tuple[str, list[Choice], dict[str, Any]], ...]:
    """Name of each kind of choice, those of it, and how they look."""
    varied = [choice for choice in choices if choice.varied]
    presets = [choice for choice in choices if choice.name in PRESETS]
    others = [choice for choice in choices if choice not in varied and choice not in presets]
    return (
        (
            f"one choice of {trade.base} varied",
            varied,
            {"marker": "o", "mfc": "white", "mec": GREY, "ms": 4.5, "zorder": 4},
        ),
        ("presets", presets, {"marker": "D", "mfc": VERMILION, "mec": "white", "ms": 8.5}),
        ("the scene's own", others, {"marker": "s", "mfc": BLACK, "mec": "white", "ms": 7.5}),
    )


def _name(
    figure: Figure, axes: Axes, trade: Trade, choices: Sequence[Choice], front: Sequence[Choice]
) -> None:
    """Write names beside the points, where they cover neither another name nor a point.

    The presets choose first, and in a crowd have a name farther off, then the choices on the
    front, to whose lower left nothing can lie, then the others from the top down. Of these, one
    that finds no room has no name.
    """
    per_point = figure.dpi / 72
    points = axes.transData.transform([_place(choice) for choice in choices])
    taken = [
        Bbox.from_extents(*(point - 5 * per_point), *(point + 5 * per_point)) for point in points
    ]
    window = axes.get_window_extent()
    for choice in sorted(
        choices, key=lambda one: (one.varied is not None, one not in front, -one.velocity_error)
    ):
        sides = _SIDES[::-1] if choice in front else _SIDES
        distances = (1,) if choice.varied else (1, 3, 5, 7, 9)
        name = choice.name.removeprefix(f"{trade.base}, " if choice.varied else "")
        for far, (right, up) in itertools.product(distances, sides):
            note = axes.annotate(
                name.replace("history_coarsening", "history grid").replace("_", " "),
                _place(choice),
                xytext=(7 * right * far, 6 * up * far),
                textcoords="offset points",
                ha="left" if right > 0 else "right",
                va="center_baseline",
                arrowprops=_LEAD if far > 1 else None,
                path_effects=[withStroke(linewidth=2.5, foreground="white")],
                zorder=5,
                **(_VARIED if choice.varied else _NAMED),
            )
            note.get_window_extent()  # puts it in its place
            box = Text.get_window_extent(note)  # without the line that leads to it
            inside = window.contains(box.x0, box.y0) and window.contains(box.x1, box.y1)
            if inside and not box.count_overlaps(taken):
                taken.append(box)
                break
            note.remove()
