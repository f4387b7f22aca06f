"""Elements of a page: tables, figures, lists and sentences."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

import pandas as pd
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.frames import cells_of, without_columns


class Table(NamedTuple):
    """A table of a page; the row with the index `bold` stands out."""

    caption: str
    headings: list[str]
    rows: list[list[str]]
    bold: int = -1


class PageFigure(NamedTuple):
    """A figure of a page, for usual and for narrow screens, as data URLs."""

    usual: str
    narrow: str
    alt: str
    caption: str


Section = tuple[str, list[str | Table | PageFigure | list[str]]]
"""Heading of a section, and its parts; a list of strings is printed as a list."""


def table_of(frame: pd.DataFrame, caption: str, bold: int = -1) -> Table:
    """Table with the values of a data frame; the row with the index `bold` stands out."""
    frame = without_columns(frame.replace("", None))
    headings = [str(column).replace("_", " ") for column in frame]
    return Table(caption, headings, cells_of(frame, "–", digits=3), bold)


def figure_of(draw: Callable[[], Figure], caption: str, description: str) -> PageFigure:
    """Draw a figure twice, for usual and for narrow screens; a table must stand below it."""
    urls = list[str]()
    for width in (None, 0.075):  # the second on a telephone [m]
        with style.fitted(width, plain=True):
            svg = io.BytesIO()
            draw().savefig(svg, format="svg", metadata={"Date": None})
        urls.append(f"data:image/svg+xml;base64,{base64.b64encode(svg.getvalue()).decode()}")
    usual, narrow = urls
    return PageFigure(usual, narrow, f"{description} The table below has the numbers.", caption)


def as_sentence(line: str) -> str:
    """Line of an answer with a capital letter and a full stop."""
    sentence = f"{line[:1].upper()}{line[1:]}"
    return sentence if line.endswith(".") else f"{sentence}."


def without_help(lines: Iterable[str]) -> list[str]:
    """Lines without references to `irg help`, which a reader of the report may not have."""
    return [re.sub(r" \(irg help [\w-]+\)", "", line) for line in lines]
