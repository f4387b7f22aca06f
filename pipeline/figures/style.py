"""The look that the figures share, and the words in which they state their conditions."""

from __future__ import annotations

import functools
import io
import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
import xarray as xr
from matplotlib import rc_context, rc_params_from_file, rcParams, rcParamsDefault
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, NullLocator
from scipy.optimize import isotonic_regression

from pipeline.analysis.dataset import stored_sweep
from pipeline.analysis.tables import FIGURES, writable_path, write_bytes
from pipeline.sweep.about import condition_rows
from pipeline.sweep.conditions import Conditions
from tribo import InputError

BLACK, GREY = "#1A1A1A", "#777777"
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9",
)  # fmt: skip
"""Okabe and Ito's palette, told apart with any colour vision."""
TINTS = {"mild": "#EAF2F8", "severe": "#FCEEE4", "band": "#BBBBBB"}
THIN, THICK = 0.9, 2.2  # [pt], lines finer or heavier than those of the style sheet
BIG, FAINT = 8.5, 0.35  # [pt] of marks that stand out, and opacity of what is there to compare
BOUNDARY: dict[str, Any] = {"color": BLACK, "lw": THICK}
BAND: dict[str, Any] = {"fc": TINTS["band"], "ec": "none", "alpha": 0.6}
RISK_COLOURS = "RdYlBu_r"
PALE = -0.15, 1.15  # ends of the colours of risks, so that words on them can be read
HALO = [withStroke(linewidth=2.5, foreground="white")]
"""Effect of words over lines and marks, which a box would hide."""

_HOUSE_STYLE = rc_params_from_file(
    Path(__file__).with_name("house.mplstyle"), use_default_template=False
)

REGION = "region"
"""Mark (gid) of the names of regions."""

_NARROW = 40  # characters of a line below the axes of a caller

P = ParamSpec("P")
R = TypeVar("R")


class Picture(Figure):
    """A figure that shows itself in a notebook, whatever the backend of matplotlib is."""

    def _repr_png_(self) -> bytes:
        """Show the figure as a picture in a notebook, once: no backend knows of it."""
        written = io.BytesIO()
        self.savefig(written, format="png")
        return written.getvalue()


def svg_of(figure: Figure) -> str:
    """A figure as an element of HTML, drawn with vectors, whose letters need no font."""
    written = io.StringIO()
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "irg"}):
        figure.savefig(written, format="svg", metadata={"Date": None})
    text = written.getvalue()
    return text[text.index("<svg") :]


def canvas(ax: Axes | None = None, size: tuple[float, float] | None = None) -> tuple[Figure, Axes]:
    """A figure and axes to draw on: those of the caller, or new ones of a size [in]."""
    if ax is None:
        figure = Picture(figsize=size)
        return figure, figure.add_subplot()
    present = ax.get_figure(root=True)
    if present is None:
        raise InputError("ax: these axes belong to no figure; give axes of a figure")
    return present, ax


_APART = 1.25  # heights of a letter between two names


def label_ends(axes: Axes, fontsize: float = 9.0) -> None:
    """Write the names of the curves at their right ends, beside the axes, in place of a legend."""
    found: Any = zip(*axes.get_legend_handles_labels(), strict=True)
    curves = [(getattr(handle, "lines", [handle])[0], name) for handle, name in found]
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()  # places the axes
    ends = [np.asarray(curve.get_ydata(), float) for curve, _ in curves]
    heights = np.array([end[np.isfinite(end)][-1] for end in ends])
    points = axes.transData.transform(np.column_stack([0 * heights, heights]))[:, 1]
    points *= 72 / figure.dpi
    order = np.argsort(points, kind="stable")
    # Names in their order, apart by `_APART`, each as near to its end as the others let it.
    steps = _APART * fontsize * np.arange(len(order))
    told = isotonic_regression(points[order] - steps).x + steps
    for (curve, name), height, shift in zip(
        [curves[k] for k in order], heights[order], told - points[order], strict=True
    ):
        axes.annotate(
            name, (1.0, height), (6, shift), xycoords=("axes fraction", "data"),
            textcoords="offset points", va="center", fontsize=fontsize, color=curve.get_color(),
            annotation_clip=False,
        )  # fmt: skip


def legend_below(figure: Figure, ax: Axes | None = None, ncols: int = 3, **options: Any) -> None:
    """Write the legend below the figure, or below the caller's axes if the figure has others."""
    if ax is None:
        legend = figure.legend(loc="outside lower center", ncols=ncols, **options)
        legend.get_title().set_multialignment("center")
    else:
        title = textwrap.fill(options.pop("title"), _NARROW)
        narrow = {"fontsize": "small", "title_fontsize": "small", "title": title}
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), **options | narrow)


def house_style(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw in the house style, except for matplotlib settings that the caller has changed."""

    @functools.wraps(draw)
    def styled(*args: P.args, **kwargs: P.kwargs) -> R:
        unset = (name for name in _HOUSE_STYLE if rcParams[name] == rcParamsDefault[name])
        with rc_context({name: _HOUSE_STYLE[name] for name in unset}):
            return draw(*args, **kwargs)

    return styled


def figure_path(out: str | Path) -> Path:
    """Path of a figure to be written, examined before it is drawn."""
    return writable_path(out, FIGURES)


@house_style
def save_figure(figure: Figure, out: Path) -> Path:
    """Write a figure to a path of `figure_path`."""
    written = io.BytesIO()
    figure.savefig(written, format=out.suffix[1:])
    return write_bytes(written.getvalue(), out)


def heating(conditions: Conditions) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk 25 °C"."""
    return " ".join(next(condition_rows(conditions)))


def plain_numbers(axes: Axes, names: str = "xy") -> None:
    """Write plain numbers beside logarithmic axes of some names, and enough of them."""
    for axis in (getattr(axes, f"{name}axis") for name in names):
        low, high = axis.get_view_interval()
        subs = range(1, 10) if high < 10 * low else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=tuple(map(float, subs))))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


def write_title(owner: Axes | Figure, words: str) -> None:
    """Write a title over axes or a figure, in lines of its width."""
    write = owner.set_title if isinstance(owner, Axes) else owner.suptitle
    write(words, wrap=True)


def title_of(ds: xr.Dataset) -> str:
    """Title of a sweep."""
    return as_text(stored_sweep(ds).about.title)


def entry_label(path: str) -> str:
    """Entry of a scene in words, in short lines, the table above the name."""
    *tables, name = (part.replace("_", " ") for part in path.split("."))
    words = f"{' '.join(tables)}: {name}" if tables else name
    return textwrap.fill(as_text(words), 22)


def as_text(words: str) -> str:
    """Escape words for a figure: shortened, without control characters and formulas."""
    printable = "".join(character for character in words[:1000] if character.isprintable())
    return textwrap.shorten(printable, 240, placeholder=" …").replace("$", r"\$")


_INCH = 0.0254  # [m]
_NARROWEST, _WIDEST = 0.04, 1.0  # [m]
_SMALLEST_TEXT, _THINNEST = 0.66, 0.6  # shares of a figure's own sizes that stay readable
_SMALLEST_NAME = 0.5  # the same of a region's name, which has no more room than its region
_MOST_ROOM = 0.75  # share of axes that a legend above their data may take
_LETTER = 0.55  # width of a letter, of the size of its font
_WORDS = 0.72  # share of a figure's width that words of a legend have beside their signs
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=(?:°C|%|N|K|m/s)(?!\w))")


def fit_to_width(figure: Figure, width: float | None = None, with_title: bool = True) -> Figure:
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
    figure.stale = True
    inside = [(axes, legend) for axes in figure.axes if (legend := axes.get_legend())]
    for _, legend in inside:
        legend.set_in_layout(False)
    for legend in list(figure.legends):
        _narrow(figure, legend)
    _wrap_labels(figure)
    for axes, legend in inside:
        _stack(axes, legend)
    for legend in figure.findobj(Legend):
        legend.get_title().set_multialignment("center")
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
    name = max(scale, min(1.0, _SMALLEST_NAME))
    for artist in figure.findobj():
        _resize(artist, name if artist.get_gid() == REGION else text, line)


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


def _place(figure: Figure) -> None:
    """Place the parts of a figure, which takes a tenth of a second, unless they are in place."""
    if figure.stale:
        figure.draw_without_rendering()


def _wrap_titles(figure: Figure) -> None:
    """Break titles of legends into lines that fit the width of the figure."""
    for legend in figure.findobj(Legend):
        _wrap(legend.get_title(), 0.92 * figure.bbox.width, figure.dpi)


def _wrap(text: Text, width: float, dpi: float) -> None:
    """Break words into lines of a width [pixels], but no number from its unit."""
    letters = int(width / (_LETTER * float(text.get_fontsize()) * dpi / 72))
    words = _BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", text.get_text())
    text.set_text("\n".join(textwrap.fill(line, letters) for line in words.splitlines()))


def _wrap_labels(figure: Figure) -> None:
    """Put units on a line of their own where a label is longer than its axis is high."""
    _place(figure)
    for axes in figure.axes:
        label = axes.yaxis.label
        if label.get_window_extent().height > axes.bbox.height:
            label.set_text(label.get_text().replace(" [", "\n["))
            figure.stale = True  # which matplotlib does not note of a label
    _place(figure)


def _narrow(figure: Figure, legend: Legend) -> None:
    """Give the legend below a figure fewer columns until it fits, and the figure its height."""
    _place(figure)
    usual_height = legend.get_window_extent().height
    for columns in range(legend._ncols - 1, 0, -1):  # type: ignore[attr-defined]
        if legend.get_window_extent().width <= 0.98 * figure.bbox.width:
            break
        legend = _rewritten(legend, figure, loc="outside lower center", ncols=columns)
        _place(figure)
    if legend.get_window_extent().width > figure.bbox.width:
        for text in legend.get_texts():
            _wrap(text, _WORDS * figure.bbox.width, figure.dpi)
        figure.stale = True  # which matplotlib does not note of a legend
        _place(figure)
    width, height = figure.get_size_inches()
    if growth := (legend.get_window_extent().height - usual_height) / figure.dpi:
        figure.set_size_inches(width, height + growth)


def _stack(axes: Axes, legend: Legend) -> None:
    """Write the legend of axes in one column above the data, if it is wider than they are."""
    if legend.get_window_extent().width <= axes.bbox.width:
        return
    legend = _rewritten(legend, axes, loc="upper left")
    room = min(legend.get_window_extent().height / axes.bbox.height, _MOST_ROOM)
    beside = (other for other in axes.figure.axes if other.bbox.bounds == axes.bbox.bounds)
    for other_axes in beside:
        bottom, top = other_axes.get_ylim()
        other_axes.set_ylim(bottom, bottom + (top - bottom) / (1 - room))


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
