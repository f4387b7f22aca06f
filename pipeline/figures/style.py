"""Style of all figures, their titles, captions and legends."""

from __future__ import annotations

import functools
import io
import itertools
import math
import textwrap
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, NamedTuple, ParamSpec, TypeVar

from matplotlib import rc_params_from_file, rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.style import context
from matplotlib.text import Text
from matplotlib.ticker import Locator, LogLocator, MaxNLocator, NullLocator

from pipeline.frames import write_bytes
from tribo import InputError
from tribo.errors import require_number

BLACK, GREY = "#1A1A1A", "#777777"
BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
"""Okabe and Ito's palette, distinguishable with any colour vision."""
TINTS = {"mild": "#F1F7FB", "undecided": "#FBE3D2", "severe": "#F0BE9B"}
"""Shades of regions, which differ in grey, too: luminance 0.96, 0.90, 0.78."""
OPERATING = "#6A1B9A"  # marks of operating points
THIN, THICK = 0.9, 2.2  # width of thin and heavy lines [pt]
BIG, FAINT = 1.9, 0.35  # factor on the size of prominent marks; opacity of faint ones
BOUNDARY: dict[str, Any] = {"color": BLACK, "lw": THICK}
BAND: dict[str, Any] = {"fc": TINTS["undecided"], "ec": "none"}
HALO = [withStroke(linewidth=2.5, foreground="white")]
"""White outline for words over lines and marks; a box would hide these."""

_HOUSE_STYLE = rc_params_from_file(
    Path(__file__).with_name("irg.mplstyle"), use_default_template=False
)
_USUAL_WIDTH = 8.0  # width of a figure for which the style's sizes are meant [in]
_MIN_DPI, _MAX_DPI = 30, 1200  # limits of the resolution of a figure [dpi]

_style_lock = threading.RLock()  # Matplotlib's settings belong to all threads

P = ParamSpec("P")
R = TypeVar("R")


class Look(NamedTuple):
    """Options of a figure of any kind."""

    width: float | None = None  # [in]; None for the usual width of each
    plain: bool = False  # without title and caption
    dpi: float | None = None  # dots per inch


_LOOK = ContextVar("look", default=Look())  # noqa: B039, as a Look is immutable


@contextmanager
def fitted(
    width: float | None = None, plain: bool = False, dpi: float | None = None
) -> Iterator[None]:
    """Context manager: draw figures with a width [m] and a resolution.

    If `plain`, they have neither titles nor captions. Text and marks shrink less than the figure,
    at most to two thirds. So narrow figures are taller in proportion.
    """
    if dpi is not None:
        require_number(dpi=dpi)
        if not _MIN_DPI <= dpi <= _MAX_DPI:
            raise InputError(f"dpi is {dpi:g}; it must be from {_MIN_DPI} to {_MAX_DPI}")
    token = _LOOK.set(Look(None if width is None else width / 0.0254, plain, dpi))
    try:
        yield
    finally:
        _LOOK.reset(token)


def width_or(usual_width: float) -> float:
    """Width to draw a figure at [in]: the width set by `fitted`, else `usual_width`."""
    return _LOOK.get().width or usual_width


class Picture(Figure):
    """A Matplotlib figure that notebooks show with any backend; `fitted` sets its width."""

    def __init__(self, figsize: tuple[float, float]) -> None:
        width, height = figsize
        fitted_width = width_or(width)
        super().__init__(figsize=(fitted_width, height * (fitted_width / width) ** 0.5))

    def draw(self, renderer: Any) -> None:
        """Draw the figure, in the house's style, also where a notebook or window asks for it."""
        house_style(super().draw)(renderer)

    def savefig(self, *args: Any, **options: Any) -> None:
        """Write the figure to a file, with Matplotlib's arguments."""
        house_style(super().savefig)(*args, **options)

    def _repr_png_(self) -> bytes:
        """The figure as PNG bytes, for display in a notebook."""
        buffer = io.BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


def canvas(size: tuple[float, float]) -> tuple[Figure, Axes]:
    """New figure of a `size` [in], with a single set of axes."""
    figure = Picture(size)
    return figure, figure.add_subplot()


def house_style(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorator: draw in the style of the house."""

    @functools.wraps(draw)
    def styled(*args: P.args, **kwargs: P.kwargs) -> R:
        size_factor = min(max(width_or(_USUAL_WIDTH) / _USUAL_WIDTH, 0.66), 1.0)
        settings: dict[Any, Any] = {**_HOUSE_STYLE}
        for name, value in _HOUSE_STYLE.items():
            if name.endswith(("size", "width")) and isinstance(value, float):
                settings[name] = size_factor * value
        if dpi := _LOOK.get().dpi:
            settings |= {"figure.dpi": dpi, "savefig.dpi": dpi}
        with _style_lock, context(settings, after_reset=True):
            return draw(*args, **kwargs)

    return styled


def legend_below(figure: Figure, ncols: int = 3, caption: str = "", **options: Any) -> None:
    """Write legend and caption below a figure; the figure grows if they need much room.

    The legend has at most `ncols` columns. `options` are passed to Matplotlib's `Figure.legend`.
    """
    width, height = figure.get_size_inches()
    letter_width = 0.55 * rcParams["legend.title_fontsize"] / 72  # mean of a text [in]
    max_lines = math.ceil(8 * max(1.0, _USUAL_WIDTH / width))
    paragraphs = map(printable, caption.split("\n"))
    lines = [line for text in paragraphs for line in textwrap.wrap(text, int(width / letter_width))]
    title = "\n".join(lines[:max_lines])
    if len(lines) > max_lines:
        title = f"{title} …"
    if _LOOK.get().plain:
        title = ""
    handles = [axes.get_legend_handles_labels()[0] for axes in figure.axes]
    options = {"handles": [*itertools.chain(*handles)]} | options  # no warning if there are none
    if labels := options.get("labels"):
        texts = map(as_text, labels)  # Matplotlib leaves out labels that begin with "_"
        options["labels"] = [f" {text}" if text.startswith("_") else text for text in texts]
    for columns in range(ncols, 0, -1):  # as many as fit into the width
        legend = figure.legend(ncols=columns, title=title, loc="outside lower center", **options)
        if legend.get_window_extent().width <= figure.bbox.width or columns == 1:
            break
        legend.remove()
    legend.get_title().set_multialignment("center")
    growth = legend.get_window_extent().height / figure.dpi - 0.2 * height
    figure.set_size_inches(width, height + max(0.0, growth))


@house_style
def save_figure(figure: Figure, out: Path, scene: str = "") -> Path:
    """Write a figure to a path that `writable_path` has checked, and return the path.

    A PNG carries the texts of the figure as its description, and the digest of its `scene` as its
    source, so that a test compares them with those of today.
    """
    buffer, suffix = io.BytesIO(), out.suffix[1:]
    carried = {"Description": "\n".join(texts_of(figure)), "Source": scene}
    figure.savefig(buffer, format=suffix, metadata=carried if suffix == "png" else None)
    return write_bytes(buffer.getvalue(), out)


def texts_of(figure: Figure) -> list[str]:
    """All different texts of a figure, in one line each."""
    texts = (text for text in figure.findobj(Text) if text.get_visible())
    lines = (" ".join(text.get_text().split()) for text in texts)
    return [*dict.fromkeys(line for line in lines if line)]


def plain_numbers(axes: Axes) -> None:
    """Label logarithmic axes with plain numbers, at enough ticks."""
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() != "log":
            continue
        low, high = axis.get_view_interval()
        if high < 3 * low:  # hardly any power of ten, or half of it, lies between
            locator: Locator = MaxNLocator(7, steps=(1, 2, 5, 10))
        else:
            subs = range(1, 10) if high < 10 * low else (1, 2, 5)
            locator = LogLocator(subs=tuple(map(float, subs)))
        axis.set_major_locator(locator)
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


def write_title(owner: Axes | Figure, title: str) -> None:
    """Write a title over axes or a figure (`owner`), wrapped."""
    write = owner.set_title if isinstance(owner, Axes) else owner.suptitle
    write("" if _LOOK.get().plain else title, wrap=True)


def as_text(text: str) -> str:
    """Prepare text of a user for a figure: `printable`, and shortened to 240 letters."""
    return textwrap.shorten(printable(text[:1000]), 240, placeholder=" …")


def printable(text: str) -> str:
    """Prepare text for a figure: without control characters, and never set as a formula.

    For this, each $ is escaped, unless it is already.
    """
    without_controls = "".join(character for character in text if character.isprintable())
    return without_controls.replace(r"\$", "$").replace("$", r"\$")
