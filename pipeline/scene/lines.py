"""Lines of tables: rows of cells in a text or a workbook, and the row of headings."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from pipeline import extras
from pipeline.paths import decoded, kind_of, read_file, reason_of
from pipeline.scene.decimals import GROUP
from pipeline.scene.names import Heading, Names
from pipeline.scene.units import is_unit, unit_of_table
from pipeline.sweep.limits import MOST_BYTES_OF_TEXT, MOST_ROWS
from tribo import InputError

BETWEEN = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", "  ": "wide blanks",
           " ": "blanks"}  # fmt: skip
"""Separators of cells, and their names; of equally good ones the first is taken."""
NUMBER = re.compile(rf"[<>]?[+-]?(?:\d[\d.,{GROUP}]*|[.,]\d+)(?:[eE][+-]?\d+)?(?:\s\D*)?")
"""A number with decimal or thousands marks of any kind, and perhaps a unit."""
_MOST_ABOVE = 200  # rows that are searched for the row of headings
WIDEST = 300
"""Most headings of a row, each of which is compared with all names."""
_SAMPLE = 150  # lines at each end from which the separator is found


class SheetRow(NamedTuple):
    """Row of a table: its number in the file, and its cells."""

    number: int
    cells: list[str]


class Lines(NamedTuple):
    """Rows of a text or a sheet that are not empty, and notes on how they were read."""

    rows: list[SheetRow]
    form: list[str]
    between: str = ""  # separator of cells in a text


def split_lines(lines: Iterable[str], separator: str) -> Iterator[SheetRow]:
    """Split lines into rows of cells; separators within quotes do not count."""
    if separator == "  ":
        yield from (SheetRow(k, re.split(r"\s{2,}|\t", x.strip())) for k, x in enumerate(lines, 1))
        return
    if separator == " ":  # a blank before a unit separates no cells
        lines = (re.sub(r"\s+(?=[\[(])", "", line.strip()) for line in lines)
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    yield from (SheetRow(reader.line_num, [*map(str.strip, cells)]) for cells in reader)


def find_separator(lines: Sequence[str], names: Names | None = None) -> str:
    """Find the separator that splits `lines` of text into the most cells with numbers.

    Only rows with about the usual number of cells count. If `names` of quantities are given, a
    separator that splits the headings into such names is preferred.
    """
    filled = [line for line in lines if line.strip()]
    sample = filled[:_SAMPLE] + filled[_SAMPLE:][-_SAMPLE:]

    def fitness(separator: str) -> float:
        rows = [row for row in split_lines(sample, separator) if len(row.cells) > 1]
        named, start = find_headings(rows, names) if names else (0, 0)
        widths = [len(row.cells) for row in rows[start:]]
        usual = widths[0] if named else max(widths, key=widths.count, default=0)
        body = [row.cells for row in rows[start:] if abs(len(row.cells) - usual) < 2]
        cells = [cell for row in body for cell in row if cell]
        numbers = sum(bool(NUMBER.fullmatch(cell)) for cell in cells)
        return ((named + 1) * numbers) ** 2 / max(len(cells), 1) + len(body) / 1e3

    return max(BETWEEN, key=fitness)


def read_lines(path: Path, names: Names, sheet: str | None, most: int = MOST_ROWS) -> list[Lines]:
    """Read the non-empty rows of a text file, at most `most`, or of each sheet of a workbook.

    Returns one `Lines` for a text file, or one for each sheet. `sheet` is the only sheet to read;
    None reads all sheets. `names` are the quantities that headings may name, which help to find the
    separator of cells in a text.
    """
    try:
        content = read_file(path, MOST_BYTES_OF_TEXT)
        if kind := kind_of(content):
            raise InputError(f"{path} is {kind}; save the table as .xlsx or CSV")
        if content.startswith(b"PK"):
            tables: list[Lines] = extras.module("workbook").read_book(path, sheet)
            return tables
        if sheet:
            raise InputError(f'{path} has no sheet "{sheet}", as it is a text; leave the sheet out')
        text, form = decoded(content)
        lines = text.splitlines()
        if len(lines) > most + _MOST_ABOVE:  # before they are split into cells
            fewer = f"keep fewer, such as one of {math.ceil(len(lines) / most)}"
            raise InputError(
                f"{path} has {len(lines)} rows, and at most {most} can be used here; {fewer}"
            )
        mark = find_separator(lines, names)
        rows = [row for row in split_lines(lines, mark) if any(row.cells)]
    except (OSError, csv.Error) as error:
        reason = reason_of(error, path) if isinstance(error, OSError) else str(error)
        raise InputError(f"{path} cannot be read: {reason}") from error
    return [Lines(rows, [f"{BETWEEN[mark]} between cells", *form], mark)]


def headings_at(rows: Sequence[SheetRow], k: int) -> tuple[list[Heading], int]:
    """Read row `k` as headings, with units from rows below it.

    Returns the headings, and the number of rows that they take.
    """
    first, *others = rows[k].cells
    is_mark = first in ("#", "%") and len(others) in [len(x.cells) for x in rows[k + 1 : k + 4]]
    heads = [*map(Heading.of, others if is_mark else [first.lstrip("#% "), *others])]
    for taken, row in enumerate(rows[k + 1 : k + 3], 2):
        if any(map(NUMBER.fullmatch, row.cells)):
            break
        cells = row.cells[is_mark and row.cells[0] == first :]
        units = [unit_of_table(cell.strip("[]")) for cell in cells[: len(heads)]]
        if any(units) and all(map(is_unit, filter(None, units))):
            for place, unit in enumerate(units):
                text, title, own = heads[place]
                if unit and not own:
                    heads[place] = Heading(f"{text} [{unit}]", title, unit)
            return heads, taken
    return heads, 1


def find_headings(rows: Sequence[SheetRow], names: Names) -> tuple[int, int]:
    """Find the row of headings that names the largest number of quantities.

    Returns this number, and the index of the row.
    """
    counts = (
        (names.count(headings_at(rows, k)[0]), -k)
        for k, row in enumerate(rows[:_MOST_ABOVE])
        if 2 * sum(bool(NUMBER.fullmatch(cell)) for cell in row.cells) <= len(row.cells) <= WIDEST
    )
    named, start = max(counts, default=(0, 0))
    return (named, -start) if named else (0, _row_above_numbers(rows))


def _row_above_numbers(rows: Sequence[SheetRow]) -> int:
    """Index of the last row of words above the first numbers, as wide as these; else 0."""
    widths = [len(row.cells) for row in rows[:_MOST_ABOVE]]
    usual = max(widths, key=widths.count, default=0)
    is_body = [
        len(cells) == usual and 2 * sum(map(bool, map(NUMBER.fullmatch, cells))) > usual
        for _, cells in rows[:_MOST_ABOVE]
    ]
    first = next((k for k in range(len(is_body)) if all(is_body[k : k + 5])), 0)
    return next((k for k in range(first - 1, -1, -1) if widths[k] == usual), 0)
