"""Tables of results: one description from which text, JSON, CSV, Markdown and HTML are written."""

from __future__ import annotations

import csv
import html
import io
import math
import os
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.scene.quantities import shown_in
from tribo import InputError

TABLES = (".csv", ".md")
FIGURES = (".pdf", ".png", ".svg")
"""Endings of the files that a table, or a figure, may be written to."""


class Column(NamedTuple):
    """Column of a table.

    Attributes
    ----------
    name : str
        Key of its values, in SI, in a JSON document.
    title : str
        Heading, without the unit.
    unit : str
        Unit in which values are shown; empty for numbers without one, and for words.
    digits : int
        Significant digits in text.
    write : callable, optional
        Writes a number in SI with its unit in text, in place of the digits.

    Examples
    --------
    >>> column = Column("bulk", "bulk temperature", "°C")
    >>> column.head, column.text(298.15)
    ('bulk temperature [°C]', '25')
    """

    name: str
    title: str
    unit: str = ""
    digits: int = 4
    write: Callable[[float], str] | None = None

    @property
    def head(self) -> str:
        """Heading with the unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def shown(self, value: Any) -> Any:
        """Value in the unit of the column; numbers that are missing are None."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            return value
        if not math.isfinite(value):
            return None
        return shown_in(value, self.unit) if self.unit else value

    def text(self, value: Any) -> str:
        """Value as it stands in text, without its unit."""
        if self.write is not None and isinstance(value, int | float):
            return self.write(value)
        value = self.shown(value)
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, float):
            return f"{value:.{self.digits}g}"
        return "" if value is None else str(value)


@dataclass(frozen=True, slots=True)
class Table:
    r"""Result as columns and rows.

    Attributes
    ----------
    columns : tuple of Column
        Names, headings and units.
    rows : tuple of tuple
        Values by column, quantities in SI; None or NaN where there is none.

    Examples
    --------
    >>> columns = Column("load", "load", "N"), Column("bulk", "bulk temperature", "°C")
    >>> table = Table(columns, ((400.0, 298.15), (600.0, None)))
    >>> print(*table.lines(), sep="\n")
    load [N]   bulk temperature [°C]
    400        25
    600        -
    >>> table.as_dict()
    {'load': [400.0, 600.0], 'bulk': [298.15, None]}
    >>> next(table.records())
    {'load [N]': 400.0, 'bulk temperature [°C]': 25.0}
    """

    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]

    def as_dict(self) -> dict[str, list[Any]]:
        """Values in SI by the names of the columns."""
        return {
            column.name: [row[place] for row in self.rows]
            for place, column in enumerate(self.columns)
        }

    def records(self) -> Iterator[dict[str, Any]]:
        """Rows as they are written to files: values in the units of the headings."""
        for row in self.rows:
            pairs = zip(self.columns, row, strict=True)
            yield {column.head: column.shown(value) for column, value in pairs}

    def without(self, names: Container[str]) -> Table:
        """The table without columns of these names."""
        kept = [place for place, column in enumerate(self.columns) if column.name not in names]
        columns = tuple(self.columns[place] for place in kept)
        return Table(columns, tuple(tuple(row[place] for place in kept) for row in self.rows))

    def without_empty(self) -> Table:
        """The table without columns that hold nothing."""
        columns = zip(self.columns, zip(*self.rows, strict=True), strict=True)
        return self.without(
            [column.name for column, values in columns if not any(map(column.text, values))]
        )

    def crossed(
        self,
        title: str,
        name: Callable[[dict[str, Any]], Any],
        across: str,
        heads: Mapping[Any, str],
        cell: Callable[[dict[str, Any]], str],
    ) -> Table:
        """Cells of rows with the same name beside each other, a column for each value of another.

        The function `name` gives the first cell of a row, below the title, `cell` the text of one
        value.
        """
        rows: dict[Any, dict[Any, str]] = {}
        for row in self.rows:
            values = {column.name: value for column, value in zip(self.columns, row, strict=True)}
            rows.setdefault(name(values), {})[values[across]] = cell(values)
        columns = (Column(title, title), *(Column(head, head) for head in heads.values()))
        lines = ((first, *(cells.get(key) for key in heads)) for first, cells in rows.items())
        return Table(columns, tuple(lines))

    def cells(self) -> list[list[str]]:
        """Values as text, without the headings."""
        return [
            [column.text(value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

    def lines(self) -> Iterator[str]:
        """Lines of text with aligned columns, the headings first."""
        rows = [[column.title if column.write else column.head for column in self.columns]]
        rows += [[cell or "-" for cell in row] for row in self.cells()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True))
            yield "   ".join(cells).rstrip()

    def html(self) -> str:
        """The table as HTML."""
        heads = "".join(f"<th>{html.escape(column.head)}</th>" for column in self.columns)
        rows = (
            "".join(f"<td>{html.escape(cell) or '–'}</td>" for cell in row) for row in self.cells()
        )
        body = "".join(f"<tr>{row}</tr>\n" for row in rows)
        return f"<table><thead><tr>{heads}</tr></thead>\n<tbody>{body}</tbody></table>"

    _repr_html_ = html  # in a notebook

    def write(self, out: str | Path) -> Path:
        """Write the table to a file, .csv or .md."""
        return write_tables([self], writable_path(out, TABLES))


def write_tables(tables: Sequence[Table], out: Path) -> Path:
    """Write the rows of tables below each other; a column that a table lacks stays empty there."""
    rows = [record for table in tables for record in table.records()]
    heads = list(dict.fromkeys(column.head for table in tables for column in table.columns))
    cells = [heads, *([_written(row.get(head)) for head in heads] for row in rows)]
    if out.suffix.lower() == ".md":
        lines = [f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in cells]
        lines.insert(1, "|---" * len(heads) + "|")
        return write_text("\n".join([*lines, ""]), out)
    file = io.StringIO()
    csv.writer(file, lineterminator="\n").writerows([*map(_harmless, line)] for line in cells)
    return write_text(file.getvalue(), out)


def write_text(text: str, out: Path) -> Path:
    """Write text to a file in UTF-8, and raise an `InputError` if that fails."""
    with writing_to(out):
        out.write_text(text, encoding="utf-8")
    return out


@contextmanager
def writing_to(out: Path) -> Iterator[None]:
    """Raise an `InputError` that names a file if writing it fails."""
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror or error}") from error


def writable_path(out: str | Path, suffixes: Sequence[str]) -> Path:
    """Path of a file with one of some suffixes, examined before the work that it is to hold."""
    path = Path(out)
    if path.suffix.lower() not in suffixes:
        allowed = suffixes[0] if len(suffixes) == 1 else f"one of {', '.join(suffixes)}"
        raise InputError(f"cannot write {out}: the suffix must be {allowed}")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {out}: there is no folder {path.parent}")
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise InputError(f"cannot write {out}: it is a folder, or its folder is not writable")
    return path


def is_table(out: str | Path | None) -> bool:
    """True if a file is to hold a table, by its suffix."""
    return out is not None and Path(out).suffix.lower() in TABLES


def _harmless(cell: str) -> str:
    """A cell that a spreadsheet takes for text where it would compute it, as ``=1+1``."""
    return f"'{cell}" if cell.startswith(("=", "@")) else cell


def _written(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
