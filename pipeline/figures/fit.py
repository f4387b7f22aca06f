"""Figures at the width of a journal's column: drawn anew in size, words kept readable."""

from __future__ import annotations

import re
import textwrap
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text

from pipeline.figures.style import SOFT_BREAK
from tribo import InputError

_INCH = 0.0254  # [m]
_NARROWEST, _WIDEST = 0.04, 1.0  # [m]
_SMALLEST_TEXT, _THINNEST = 0.66, 0.6  # shares of a figure's own sizes that stay readable
_LETTER = 0.55  # width of a letter, of the size of its font
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=(?:°C|%|N|K|m/s)(?!\w))")


def fitted(figure: Figure, width: float | None = None, with_title: bool = True) -> Figure:
    """Bring a figure to a width [m], with or without its titles, its words and legends inside.

    Words shrink less than the figure, down to two thirds, so it gets higher in proportion.
    """
    if not with_title:
        figure.suptitle("")
        for axes in figure.axes:
            axes.set_title("")
    if width is not None:
        _shrink(figure, width)
    _wrap_titles(figure)
    for axes in figure.axes:
        if legend := axes.get_legend():
            legend.set_in_layout(False)
    for legend in list(figure.legends):
        _narrow(figure, legend)
    _wrap_labels(figure)
    for axes in figure.axes:
        if legend := axes.get_legend():
            _stack(axes, legend)
    return figure


def _shrink(figure: Figure, width: float) -> None:
    if not _NARROWEST <= width <= _WIDEST:
        raise InputError(f"width is {100 * width:g} cm; it must be from 4 to 100 cm")
    usual_width, usual_height = figure.get_size_inches()
    scale = width / _INCH / usual_width
    text, line = max(scale, min(1.0, _SMALLEST_TEXT)), max(scale, min(1.0, _THINNEST))
    places = [axes.get_subplotspec() for axes in figure.axes]
    rows = max(place.get_gridspec().nrows for place in places if place)
    height = usual_height * (text if rows > 1 else (scale * text) ** 0.5)
    figure.set_size_inches(scale * usual_width, height)
    for artist in figure.findobj():
        _resize(artist, text, line)


def _resize(artist: Artist, text: float, line: float) -> None:
    """Change the size of words, lines and markers."""
    if isinstance(artist, Text):
        artist.set_fontsize(float(artist.get_fontsize()) * text)
    elif isinstance(artist, Line2D):
        artist.set_linewidth(artist.get_linewidth() * line)
        artist.set_markersize(artist.get_markersize() * line)
        artist.set_markeredgewidth(artist.get_markeredgewidth() * line)
    elif isinstance(artist, Collection):
        artist.set_linewidth([line * width for width in artist.get_linewidth()])  # type: ignore[union-attr]


def _wrap_titles(figure: Figure) -> None:
    """Break titles into lines that are as long as the figure is wide about their middle."""
    figure.draw_without_rendering()
    whole = figure.bbox.width
    rooms = dict.fromkeys([legend.get_title() for legend in figure.findobj(Legend)], whole)
    for axes in figure.axes:
        middle = axes.bbox.x0 + axes.bbox.width / 2
        rooms[axes.title] = 2 * min(middle, whole - middle)
    if title := getattr(figure, "_suptitle", None):
        rooms[title] = whole
    for title, room in rooms.items():
        letter = _LETTER * float(title.get_fontsize()) * figure.dpi / 72
        text = title.get_text().replace(SOFT_BREAK, " ")
        lines = _BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", text).splitlines()
        title.set_text("\n".join(textwrap.fill(line, int(0.92 * room / letter)) for line in lines))


def _wrap_labels(figure: Figure) -> None:
    """Put units on a line of their own where a label is longer than its axis is high."""
    figure.draw_without_rendering()
    for axes in figure.axes:
        label = axes.yaxis.label
        if label.get_window_extent().height > axes.bbox.height:
            label.set_text(label.get_text().replace(" [", "\n["))
    figure.draw_without_rendering()


def _narrow(figure: Figure, legend: Legend) -> None:
    """Give the legend below a figure fewer columns, until it is no wider than the figure.

    The figure gets higher by as much as the legend does.
    """
    figure.draw_without_rendering()
    usual_height = legend.get_window_extent().height
    for columns in range(legend._ncols - 1, 0, -1):  # type: ignore[attr-defined]
        if legend.get_window_extent().width <= 0.98 * figure.bbox.width:
            break
        legend = _rewritten(legend, figure, loc="outside lower center", ncols=columns)
        figure.draw_without_rendering()
    width, height = figure.get_size_inches()
    growth = (legend.get_window_extent().height - usual_height) / figure.dpi
    figure.set_size_inches(width, height + growth)


def _stack(axes: Axes, legend: Legend) -> None:
    """Write the legend of axes in one column above the data, if it is wider than they are."""
    if legend.get_window_extent().width <= axes.bbox.width:
        return
    legend = _rewritten(legend, axes, loc="upper left")
    height = sum(1.5 * float(text.get_fontsize()) for text in legend.get_texts())  # [pt]
    room = height * axes.figure.dpi / 72 / axes.bbox.height
    beside = (other for other in axes.figure.axes if other.bbox.bounds == axes.bbox.bounds)
    for other_axes in beside:
        bottom, top = other_axes.get_ylim()
        other_axes.set_ylim(bottom, bottom + (top - bottom) * (1 + max(0.0, room - 0.15)))


def _rewritten(legend: Legend, owner: Figure | Axes, **place: Any) -> Legend:
    """A legend of a figure or of axes at another place, with its words as they are."""
    texts, title = legend.get_texts(), legend.get_title()
    legend.remove()
    return owner.legend(
        handles=legend.legend_handles,
        labels=[text.get_text() for text in texts],
        title=title.get_text(),
        fontsize=texts[0].get_fontsize(),
        title_fontsize=title.get_fontsize(),
        frameon=False,
        **place,
    )
