"""The look that the figures share, and the words in which they state their conditions."""

from __future__ import annotations

import functools
import io
import itertools
import math
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from matplotlib import rc_context, rc_params_from_file, rcParams, rcParamsDefault
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullLocator

from pipeline.analysis.results import Results
from pipeline.analysis.tables import write_bytes
from pipeline.sweep.condition_words import condition_rows
from pipeline.sweep.conditions import Conditions
from tribo import InputError

BLACK, GREY = "#1A1A1A", "#777777"
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9",
)  # fmt: skip
"""Okabe and Ito's palette, told apart with any colour vision."""
TINTS = {"mild": "#EAF2F8", "severe": "#FCEEE4", "band": "#BBBBBB"}
THIN, THICK = 0.9, 2.2  # [pt], lines finer or heavier than those of the style sheet
BIG, FAINT = 1.9, 0.35  # size of marks that stand out, of the usual one; opacity of the others
BOUNDARY: dict[str, Any] = {"color": BLACK, "lw": THICK}
BAND: dict[str, Any] = {"fc": TINTS["band"], "ec": "none", "alpha": 0.6}
RISK_COLOURS = "RdYlBu_r"
PALE = -0.15, 1.15  # ends of the colours of risks, so that words on them can be read
HALO = [withStroke(linewidth=2.5, foreground="white")]
"""Effect of words over lines and marks, which a box would hide."""

_HOUSE = rc_params_from_file(Path(__file__).with_name("house.mplstyle"), use_default_template=False)
_SIZES = [name for name, value in _HOUSE.items() if name.endswith(("size", "width"))
          and isinstance(value, float)]  # fmt: skip
_USUAL = 8.0  # [in], width for which the sizes of the house are meant
_SMALLEST = 0.66  # share of these sizes that stays readable
_INCH = 0.0254  # [m]
_NARROWEST, _WIDEST = 0.04, 1.0  # [m]
_LETTER = 0.55  # width of a letter, of the size of its font
_CAPTION = 2  # lines of a caption in a figure of the usual width
_MOST_LEGEND = 0.2  # share of a figure's height that its legend takes before the figure grows

P = ParamSpec("P")
R = TypeVar("R")


_WIDTH = ContextVar[float | None]("width", default=None)
"""Width of the figures that are drawn [in]; their own if None."""
_PLAIN = ContextVar("plain", default=False)
"""Figures have no titles and no captions."""


@contextmanager
def fitted(width: float | None = None, plain: bool = False) -> Iterator[None]:
    """Draw figures of a width [m]; if plain, without titles and captions.

    Words and marks shrink less than a figure, down to two thirds, so it gets higher in proportion.
    """
    if width is not None and not _NARROWEST <= width <= _WIDEST:
        raise InputError(f"width is {100 * width:g} cm; it must be from 4 to 100 cm")
    tokens = _WIDTH.set(width and width / _INCH), _PLAIN.set(plain)
    try:
        yield
    finally:
        _WIDTH.reset(tokens[0])
        _PLAIN.reset(tokens[1])


def wanted_width(usual: float) -> float:
    """Width that figures are drawn at [in]; the usual one if none is wanted."""
    return _WIDTH.get() or usual


class Picture(Figure):
    """A figure of the wanted width, which shows itself in a notebook with any backend."""

    def __init__(self, figsize: tuple[float, float] | None = None) -> None:
        width, height = figsize or rcParams["figure.figsize"]
        wanted = wanted_width(width)
        super().__init__(figsize=(wanted, height * (wanted / width) ** 0.5))

    def _repr_png_(self) -> bytes:
        """Show the figure as a picture in a notebook, once: no backend knows of it."""
        written = io.BytesIO()
        self.savefig(written, format="png")
        return written.getvalue()


def svg_of(figure: Figure) -> str:
    """The figure as an SVG element of HTML; its letters are drawn as paths and need no font."""
    written = io.StringIO()
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "irg"}):
        figure.savefig(written, format="svg", metadata={"Date": None})
    text = written.getvalue()
    return text[text.index("<svg") :]


def canvas(size: tuple[float, float] | None = None) -> tuple[Figure, Axes]:
    """A figure of a size [in], and its axes."""
    figure = Picture(size)
    return figure, figure.add_subplot()


def house_style(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw in the house style, except for matplotlib settings that the caller has changed."""

    @functools.wraps(draw)
    def styled(*args: P.args, **kwargs: P.kwargs) -> R:
        share = min(max(wanted_width(_USUAL) / _USUAL, _SMALLEST), 1.0)
        look = dict(_HOUSE) | {name: share * _HOUSE[name] for name in _SIZES}
        unset = [name for name in look if rcParams[name] == rcParamsDefault[name]]
        with rc_context({name: look[name] for name in unset}):
            return draw(*args, **kwargs)

    return styled


def legend_below(figure: Figure, ncols: int = 3, caption: str = "", **options: Any) -> None:
    """Write the legend, in as many columns as fit, and the caption below a figure, which grows."""
    width = 72 * figure.get_window_extent().width / figure.dpi  # [pt]
    letters = int(width / (_LETTER * rcParams["legend.title_fontsize"]))
    most = math.ceil(_CAPTION * max(1.0, 72 * _USUAL / width))
    lines = [line for part in caption.splitlines() for line in textwrap.wrap(part, letters)]
    title = "\n".join(lines[:most]) + " …" * (len(lines) > most)
    title = "" if _PLAIN.get() else title
    named = [axes.get_legend_handles_labels()[0] for axes in figure.axes]
    options = {"handles": [*itertools.chain(*named)]} | options  # of none, too, without a warning
    legend = fitting_legend(figure, ncols, title=title, loc="outside lower center", **options)
    legend.get_title().set_multialignment("center")
    breadth, height = figure.get_size_inches()
    growth = legend.get_window_extent().height / figure.dpi - _MOST_LEGEND * height
    figure.set_size_inches(breadth, height + max(0.0, growth))


def fitting_legend(owner: Axes | Figure, ncols: int, **options: Any) -> Legend:
    """Write a legend of a figure or of axes, in as many columns as fit its width."""
    for columns in range(ncols, 0, -1):
        legend: Legend = owner.legend(ncols=columns, **options)
        if legend.get_window_extent().width <= owner.get_window_extent().width or columns == 1:
            break
        legend.remove()
    return legend


@house_style
def save_figure(figure: Figure, out: Path) -> Path:
    """Write a figure to a path of `writable_path`."""
    written = io.BytesIO()
    figure.savefig(written, format=out.suffix[1:])
    return write_bytes(written.getvalue(), out)


def heating(conditions: Conditions) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk 25 °C"."""
    return " ".join(next(condition_rows(conditions)))


def plain_numbers(axes: Axes) -> None:
    """Write plain numbers at enough ticks of logarithmic axes."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        subs = range(1, 10) if high < 10 * low else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=tuple(map(float, subs))))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


def write_title(owner: Axes | Figure, words: str) -> None:
    """Write a title over axes or a figure, in lines of its width."""
    write = owner.set_title if isinstance(owner, Axes) else owner.suptitle
    write("" if _PLAIN.get() else words, wrap=True)


def title_of(data: Results) -> str:
    """Title of a sweep."""
    return as_text(data.sweep.title)


def entry_label(path: str) -> str:
    """Entry of a scene in words, in short lines, the table above the name."""
    *tables, name = (part.replace("_", " ") for part in path.split("."))
    words = f"{' '.join(tables)}: {name}" if tables else name
    return textwrap.fill(as_text(words), 22)


def as_text(words: str) -> str:
    """Escape words for a figure: shortened, without control characters and formulas."""
    printable = "".join(character for character in words[:1000] if character.isprintable())
    return textwrap.shorten(printable, 240, placeholder=" …").replace("$", r"\$")
