"""Figures at the width of a journal's column: drawn anew in size, words kept readable."""

from __future__ import annotations

import textwrap

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text

from tribo import InputError

_INCH = 0.0254  # [m]
_NARROWEST, _WIDEST = 0.04, 1.0  # [m]
_SMALLEST_TEXT, _THINNEST = 0.66, 0.6  # shares of a figure's own sizes that stay readable
_LETTER = 0.55  # width of a letter, of the size of its font


def fitted(figure: Figure, width: float | None = None, with_title: bool = True) -> Figure:
    """Bring a figure to a width, with or without its titles; it is changed itself.

    Words shrink less than the figure, down to two thirds, so it gets higher in proportion.

    Parameters
    ----------
    figure : Figure
        Figure to change.
    width : float, optional
        Width [m]; its own if not given.
    with_title : bool
        Keep the titles of the figure and of its axes.

    Raises
    ------
    InputError
        If the width is less than 4 cm, or more than 1 m.
    """
    if not with_title:
        figure.suptitle("")
        for axes in figure.axes:
            axes.set_title("")
    if width is None:
        _narrow_legends(figure)
        return figure
    if not _NARROWEST <= width <= _WIDEST:
        raise InputError(f"width is {100 * width:g} cm; it must be from 4 to 100 cm")
    own_width, own_height = figure.get_size_inches()
    scale = width / _INCH / own_width
    text, line = max(scale, min(1.0, _SMALLEST_TEXT)), max(scale, min(1.0, _THINNEST))
    places = [axes.get_subplotspec() for axes in figure.axes]
    rows = max(place.get_gridspec().nrows for place in places if place)
    figure.set_size_inches(
        scale * own_width, own_height * (text if rows > 1 else (scale * text) ** 0.5)
    )
    for artist in figure.findobj():
        _resize(artist, text, line)
    _wrap_titles(figure)
    for axes in figure.axes:
        if legend := axes.get_legend():
            legend.set_in_layout(False)
    _narrow_legends(figure)
    _wrap_labels(figure)
    for axes in figure.axes:
        if legend := axes.get_legend():
            _stack(axes, legend)
    return figure


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
    """Break titles into lines that are as long as the figure is wide."""
    titles = [axes.title for axes in figure.axes]
    titles += [legend.get_title() for legend in figure.findobj(Legend)]
    titles += [figure._suptitle] if getattr(figure, "_suptitle", None) else []  # type: ignore[attr-defined]
    room = 72 * figure.get_size_inches()[0]  # [pt]
    for title in titles:
        letters = int(0.92 * room / (_LETTER * float(title.get_fontsize())))
        lines = title.get_text().splitlines()
        title.set_text("\n".join(textwrap.fill(line, letters) for line in lines))


def _wrap_labels(figure: Figure) -> None:
    """Put units on a line of their own where a label is longer than its axis is high."""
    figure.draw_without_rendering()
    for axes in figure.axes:
        label = axes.yaxis.label
        if label.get_window_extent().height > axes.bbox.height:
            label.set_text(label.get_text().replace(" [", "\n["))
    figure.draw_without_rendering()


def _stack(axes: Axes, legend: Legend) -> None:
    """Write the legend of axes in one column above the data, if it is wider than they are."""
    if legend.get_window_extent().width <= axes.bbox.width:
        return
    rows, size = len(legend.get_texts()), float(legend.get_texts()[0].get_fontsize())
    labels = [text.get_text() for text in legend.get_texts()]
    handles = legend.legend_handles
    legend.remove()
    axes.legend(handles=handles, labels=labels, loc="upper left", fontsize=size, frameon=False)
    room = rows * 1.5 * size * axes.figure.dpi / 72 / axes.bbox.height
    for other_axes in (
        other for other in axes.figure.axes if other.bbox.bounds == axes.bbox.bounds
    ):
        bottom, top = other_axes.get_ylim()
        other_axes.set_ylim(bottom, bottom + (top - bottom) * (1 + max(0.0, room - 0.15)))


def _narrow_legends(figure: Figure) -> None:
    for legend in list(figure.legends):
        _narrow(figure, legend)


def _narrow(figure: Figure, legend: Legend) -> None:
    """Give the legend below a figure fewer columns, until it is no wider than the figure.

    The figure gets higher by as much as the legend does.
    """
    columns = legend._ncols  # type: ignore[attr-defined]
    words = {
        "labels": [text.get_text() for text in legend.get_texts()],
        "title": legend.get_title().get_text(),
        "fontsize": legend.get_texts()[0].get_fontsize() if legend.get_texts() else None,
        "title_fontsize": legend.get_title().get_fontsize(),
    }
    handles = legend.legend_handles
    figure.draw_without_rendering()
    legend_height = legend.get_window_extent().height
    while columns > 1 and legend.get_window_extent().width > 0.98 * figure.bbox.width:
        columns -= 1
        legend.remove()
        legend = figure.legend(
            handles=handles, loc="outside lower center", ncols=columns, frameon=False, **words
        )
        figure.draw_without_rendering()
    width, height = figure.get_size_inches()
    figure.set_size_inches(
        width, height + (legend.get_window_extent().height - legend_height) / figure.dpi
    )
