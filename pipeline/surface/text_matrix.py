"""Read a matrix of numbers from text, with any delimiter; a doubtful notation is refused."""

from __future__ import annotations

import itertools
import re

import numpy as np

from pipeline.messages import quoted
from pipeline.units import MAYBE_THOUSANDS
from tribo import InputError
from tribo.types import Array

_MISSING_WORDS = re.compile(
    r"(?<![\w.+-])(-?1\.#\w+|-{2,}|\*+|n/?a|no ?data|bad|void)(?![\w.])", re.IGNORECASE
)
"""Words for a missing height other than "nan" and an empty cell."""
_WITH_COMMA = re.compile(r"[-+]?\d+(,\d+)+(e[-+]?\d+)?", re.IGNORECASE)
"""A number with a comma, before decimals or thousands."""
_INTEGER = re.compile(r"[-+]?[1-9]\d*")
_SPLIT_DECIMAL = re.compile(r"(?:^|,) *(-0|0\d+) *(?=,|$)", re.MULTILINE)
"""Decimals that a decimal comma cut off: whole numbers have no leading zeros."""


def matrix_of(text: str) -> tuple[list[str], Array | None]:
    """Headings above the numbers of a text, and the matrix, a row for each y; None without one."""
    rows = text.splitlines()
    numbered_rows = [(k, row.strip(" ")) for k, row in enumerate(rows, 1) if row.strip()]
    numbered_rows = [(k, row) for k, row in numbered_rows if row.lstrip()[0] != "#"]
    lines, heading_count = [row for _, row in numbered_rows], 0
    for line in lines[:200]:  # more lines of headings are too many to search
        delimiter = delimiter_of(line)
        if numbers_of([line], delimiter) is not None:
            break
        cells = line.split(delimiter if delimiter != "," else None)
        if len(cells) > 1 and all(map(_WITH_COMMA.fullmatch, map(str.strip, cells))):
            raise InputError(_comma_problem(cells))
        heading_count += 1
    else:
        return lines, None
    _require_single_table([k for k, _ in numbered_rows[heading_count:]])
    _require_decimals(lines[heading_count:], delimiter)
    if delimiter == "," and (zeros := _SPLIT_DECIMAL.search("\n".join(lines[heading_count:]))):
        raise InputError(
            f"commas separate both numbers and decimals ({quoted(zeros[1])} is no whole "
            "number); write decimals with points"
        )
    try:
        return lines[:heading_count], numbers_of(lines[heading_count:], delimiter, strict=True)
    except InputError:
        raise
    except ValueError as error:
        reason = str(error).partition(";")[0].partition(", please")[0]
        raise InputError(
            f"not a matrix of numbers, with equally long rows: {reason}; write nan for a missing "
            "height, and decimals with a point"
        ) from error


def _comma_problem(cells: list[str]) -> str:
    """Why numbers with commas are refused, and how to write them."""
    if all(map(MAYBE_THOUSANDS.fullmatch, map(str.strip, cells))):
        return _thousands_problem(cells[0].strip())
    return f"decimals have commas ({quoted(cells[0])}); write them with points"


def _thousands_problem(number: str) -> str:
    plain, decimals = number.replace(",", "").replace(".", ""), number.replace(",", ".")
    return (
        f"{quoted(number)} may be {plain} or {decimals}, a thousand times less; write the heights "
        "without marks of thousands, and decimals with points"
    )


def _require_single_table(line_numbers: list[int]) -> None:
    """Raise an `InputError` if lines without numbers divide the rows into tables."""
    pairs = itertools.pairwise(line_numbers)
    starts = [k for k, (before, after) in enumerate(pairs, 1) if after > before + 1]
    if starts and len(starts) < len(line_numbers) - 1:  # else a line is empty below each row
        sizes = np.diff([0, *starts, len(line_numbers)])
        raise InputError(
            f"{len(sizes)} tables of {', '.join(map(str, sizes[:4]))} rows, the second from line "
            f"{line_numbers[starts[0]]} on; keep one of them"
        )


def _require_decimals(lines: list[str], delimiter: str | None) -> None:
    """Raise an `InputError` if points may divide thousands, as in 23.173 beside 476."""
    grouped_number, has_integer = "", False
    for cell in (cell.strip() for line in lines for cell in line.split(delimiter)):
        if "." in cell:
            if delimiter == "," or not MAYBE_THOUSANDS.fullmatch(cell):
                return
            grouped_number = grouped_number or cell
        has_integer |= _INTEGER.fullmatch(cell) is not None
    if grouped_number and has_integer:
        raise InputError(_thousands_problem(grouped_number))


def delimiter_of(line: str) -> str | None:
    """Delimiter of the numbers of a line; None for spaces."""
    return next((delimiter for delimiter in "\t;," if delimiter in line), None)


def numbers_of(lines: list[str], delimiter: str | None, strict: bool = False) -> Array | None:
    """Numbers of lines; None if there are other words, or a `ValueError` if `strict`."""
    if delimiter:
        while lines[0].endswith(delimiter) and all(line.endswith(delimiter) for line in lines):
            lines = [line[:-1] for line in lines]
        for k, first_cell in enumerate(lines[0].split(delimiter) if strict else ()):
            cells = ("".join(line.split(delimiter)[k : k + 1]) for line in lines)
            if not first_cell.strip() and not any(cell.strip() for cell in cells):
                raise InputError(f"column {k + 1} is empty, as between two tables; keep one table")
        empty_cell = re.compile(rf"(?:^|(?<={delimiter})) *(?={delimiter}|$)")
        lines = [empty_cell.sub("nan", line) for line in lines]
    lines = [_MISSING_WORDS.sub("nan", line) for line in lines]
    try:
        return np.loadtxt(lines, delimiter=delimiter, ndmin=2, comments=None)
    except ValueError:
        if strict:
            raise
        return None
