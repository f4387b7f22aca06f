"""The look that the figures share, and the words in which they state their conditions."""

from __future__ import annotations

import functools
import io
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import xarray as xr
from cycler import cycler
from matplotlib import rc_context, rcParams, rcParamsDefault
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from pipeline.analysis.tables import FIGURES, writable_path, writing_to
from pipeline.sweep.conditions import Conditions
from tribo import InputError

BLACK, GREY = "#1A1A1A", "#777777"
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9",
)  # fmt: skip
"""Okabe and Ito's palette, told apart with any colour vision."""
TINTS = {"mild": "#EAF2F8", "severe": "#FCEEE4", "band": "#BBBBBB"}

_HOUSE_STYLE: Any = {
    "axes.axisbelow": True,
    "axes.edgecolor": "#444444",
    "axes.grid": True,
    "axes.labelcolor": BLACK,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": cycler(color=[BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY]),
    "axes.titlesize": 11,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
    "figure.titlesize": 12,
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "pdf.fonttype": 42,
    "savefig.dpi": 150,
    "svg.fonttype": "none",  # words stay words
    "xtick.color": "#444444",
    "ytick.color": "#444444",
}

SOFT_BREAK = " \n"
"""Break between lines of a title that goes where the figure gets another width."""

_NARROW = 40  # characters of a line below the axes of a caller

P = ParamSpec("P")
R = TypeVar("R")


class Picture(Figure):
    """A figure that shows itself in a notebook, whatever the backend of matplotlib is."""

    def _repr_png_(self) -> bytes:
        """Show the figure as a picture in a notebook, once: no backend knows of it."""
        return png_of(self)


def png_of(figure: Figure, dpi: float | None = None) -> bytes:
    """A figure as the content of a .png file."""
    written = io.BytesIO()
    figure.savefig(written, format="png", dpi=dpi)
    return written.getvalue()


def svg_of(figure: Figure) -> str:
    """A figure as an element of HTML, drawn with vectors, whose letters need no font."""
    written = io.StringIO()
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "irg"}):
        figure.savefig(written, format="svg", metadata={"Date": None})
    text = written.getvalue()
    return text[text.index("<svg") :]


def canvas(ax: Axes | None, size: tuple[float, float]) -> tuple[Figure, Axes]:
    """A figure and axes to draw on: those of the caller, or new ones of a size [in]."""
    if ax is None:
        figure = Picture(figsize=size)
        return figure, figure.add_subplot()
    present = ax.get_figure(root=True)
    if present is None:
        raise InputError("ax: these axes belong to no figure; give axes of a figure")
    return present, ax


def legend_below(figure: Figure, ax: Axes | None = None, **options: Any) -> None:
    """Write the legend below a figure, or below the caller's axes on one that has others."""
    if ax is None:
        figure.legend(loc="outside lower center", **options)
    else:
        title = textwrap.fill(options.pop("title"), _NARROW)
        narrow = {"ncols": 1, "fontsize": 8, "title_fontsize": 8, "title": title}
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), **options | narrow)


def in_house_style(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw in the house style, but for what the caller has set of matplotlib otherwise."""

    @functools.wraps(draw)
    def styled(*args: P.args, **kwargs: P.kwargs) -> R:
        unset = (name for name in _HOUSE_STYLE if rcParams[name] == rcParamsDefault[name])
        with rc_context({name: _HOUSE_STYLE[name] for name in unset}):
            return draw(*args, **kwargs)

    return styled


def figure_path(out: str | Path) -> Path:
    """Path of a figure to be written, examined before it is drawn.

    Raises
    ------
    InputError
        If the suffix is none of .pdf, .png and .svg, which decides the format; or if there is no
        folder to write it to.

    Examples
    --------
    >>> figure_path("diagram.svg").suffix
    '.svg'
    >>> figure_path("diagram.doc")
    Traceback (most recent call last):
        ...
    tribo.errors.InputError: cannot write diagram.doc: the suffix must be one of .pdf, .png, .svg
    """
    return writable_path(out, FIGURES)


@in_house_style
def save_figure(figure: Figure, out: Path, dpi: float | None = None) -> Path:
    """Write a figure to a path of `figure_path`, with so many dots per inch.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from matplotlib.figure import Figure
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_figure(Figure(), Path(folder, "empty.png")).name
    'empty.png'
    """
    with writing_to(out):
        figure.savefig(out, dpi=dpi)
    return out


def celsius(temperature: Any) -> Any:
    """A temperature [°C], of one in kelvin."""
    return temperature - 273.15


def criterion(conditions: Conditions) -> str:
    """Criterion of severe wear in words, such as "more than 10 % of the contact above 145 °C"."""
    critical = celsius(conditions.known_critical_temperature())
    return f"{conditions.decisive.severe} {critical:g} °C"


def heating(conditions: Conditions) -> str:
    """Friction and bulk temperature in words, such as "friction 0.1, bulk 25 °C"."""
    bulk = f"bulk {celsius(conditions.bulk_temperature):g} °C"
    if conditions.disk_temperature is not None:
        bulk += f" (pin) and {celsius(conditions.disk_temperature):g} °C (disk)"
    return f"friction {conditions.friction:g}, {bulk}"


def plain_numbers(axes: Axes) -> None:
    """Write plain numbers beside logarithmic axes, and enough of them."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        subs = range(1, 10) if high < 10 * low else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=tuple(map(float, subs))))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())


def title_of(ds: xr.Dataset) -> str:
    """Title of a sweep, in a few lines that fit a figure."""
    return as_title(str(ds.attrs.get("title") or ds.attrs.get("name") or ""))


def as_title(words: str, letters: int = 80) -> str:
    """Words as a title, in lines of so many letters until a figure is fitted to a width."""
    return SOFT_BREAK.join(textwrap.wrap(as_text(words), letters))


def entry_label(path: str, letters: int = 22) -> str:
    """Entry of a scene in words, the table above the name.

    Examples
    --------
    >>> print(entry_label("disk.roughness.correlation_length"))
    disk roughness:
    correlation length
    """
    *tables, name = (part.replace("_", " ") for part in path.split("."))
    words = f"{' '.join(tables)}: {name}" if tables else name
    return textwrap.fill(as_text(words), letters)


def as_text(words: str) -> str:
    r"""Write words as they are: shortened, without control characters, and not as a formula.

    Examples
    --------
    >>> print(as_text(r"worn by $\frac$" + chr(27)))
    worn by \$\frac\$
    """
    printable = "".join(character for character in words[:1000] if character.isprintable())
    return textwrap.shorten(printable, 240, placeholder=" …").replace("$", r"\$")
