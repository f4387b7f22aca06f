"""Parts of a page: tables, lists, and pictures as addresses that hold all data."""

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

_NARROW = 0.075  # width of figures on a telephone [m]


class Grid(NamedTuple):
    """A table of a page; the row number `bold` stands out."""

    caption: str
    heads: list[str]
    rows: list[list[str]]
    bold: int = -1


class Picture(NamedTuple):
    """A figure of a page, for usual and for narrow screens, as addresses that hold all data."""

    usual: str
    narrow: str
    alt: str
    caption: str


class Items(NamedTuple):
    """Lines of a list."""

    lines: list[str]


Section = tuple[str, list[str | Grid | Picture | Items]]
"""Heading of a section, and its parts."""


def without_help(lines: Iterable[str]) -> list[str]:
    """Lines without references to pages of help, which a reader of the report may not have."""
    return [re.sub(r" \(irg help [\w-]+\)", "", line) for line in lines]


def as_sentence(line: str) -> str:
    """Line of an answer with a capital letter and a full stop."""
    return f"{line[:1].upper()}{line[1:]}" + "." * (not line.endswith("."))


def table_of(frame: pd.DataFrame, caption: str, bold: int = -1) -> Grid:
    """Table with the values of a data frame; the row number `bold` stands out."""
    frame = without_columns(frame.replace("", None))
    heads = [str(head).replace("_", " ") for head in frame]
    return Grid(caption, heads, cells_of(frame, "–", digits=3), bold)


def picture_of(draw: Callable[[], Figure], caption: str, alt: str) -> Picture:
    """Draw a figure twice, for usual and for narrow screens."""
    drawn = []
    for width in (None, _NARROW):
        with style.fitted(width, plain=True):
            written = io.BytesIO()
            draw().savefig(written, format="svg", metadata={"Date": None})
        text = base64.b64encode(written.getvalue()).decode()
        drawn.append(f"data:image/svg+xml;base64,{text}")
    return Picture(drawn[0], drawn[1], alt, caption)
