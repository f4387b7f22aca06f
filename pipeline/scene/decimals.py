"""Numbers in tables: with decimal points or commas, perhaps with marks of thousands."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence

from pipeline.scene.faults import Fault, listed_faults, quoted

GROUP = "'’\xa0\u202f"
"""Marks of thousands that never mark decimals."""
_TOKEN = re.compile(rf"[+-]?((?:\d[\d.,{GROUP}]*|[.,]\d+))([eE][+-]?\d+)?(?![\d.,])")
_EITHER = "two readings"


class Typed(str):
    """Text of a cell that was typed as a number, so that its mark is a decimal point."""

    __slots__ = ()


def mark_of(cell: str) -> str:
    """Decimal mark that the number at the start of a cell must have; empty if it shows none.

    A number such as 1.200, whose mark may also be one of thousands, has two readings.

    Examples
    --------
    >>> mark_of("1.234,5 N"), mark_of("0,123"), mark_of("1,200,000"), mark_of("1.200 N")
    (',', ',', '.', 'two readings')
    """
    match = _TOKEN.match(cell) if "." in cell or "," in cell else None
    if match is None or isinstance(cell, Typed):
        return ""
    number, (points, commas) = match[1], (match[1].count(mark) for mark in ".,")
    last = "." if number.rfind(".") > number.rfind(",") else ","
    other = "," if last == "." else "."
    if points and commas:
        return last if number.count(last) == 1 and _is_grouped(number, other, last) else ""
    if points + commas > 1:
        return other if _is_grouped(number, last, other) else ""
    whole, _, part = number.partition(last)
    is_either = len(part) == 3 and whole.isdigit() and len(whole) < 4 and whole[0] != "0"
    return _EITHER if is_either and not match[2] else last


def _is_grouped(number: str, group: str, decimal: str) -> bool:
    return bool(re.fullmatch(rf"\d{{1,3}}([{group}{GROUP}]\d{{3}})+([{decimal}]\d*)?", number))


def make_plain(
    rows: Sequence[tuple[int, list[str]]],
    used: Collection[int],
    given: str | None,
    between: str,
) -> tuple[str, list[str]]:
    """Rewrite the numbers in `rows`, in place, with decimal points and without thousands marks.

    The decimal mark is `given`, or that of all other numbers of the file: of those in the columns
    `used`, else of any. `between` is the separator of cells, if this is a text. Returns the mark
    and faults: of numbers with two readings, and of those with another mark.
    """
    found = {
        (row, k): mark for row, cells in rows for k, cell in enumerate(cells)
        if (mark := mark_of(cell))
    }  # fmt: skip
    near = {mark for (_, k), mark in found.items() if k in used} - {_EITHER}
    sure = near or {*found.values()} - {_EITHER}
    if between == "," and not any("," in cell for _, cells in rows for cell in cells):
        sure = {"."}  # commas are taken
    decimal = given or (min(sure) if len(sure) == 1 else None)
    texts = dict(rows)
    asked = [
        (row, texts[row][k]) for (row, k), mark in found.items()
        if k in used and mark != decimal and (decimal is None or not _fits(texts[row][k], decimal))
    ]  # fmt: skip
    for row, cells in rows:
        own = [decimal or found.get((row, k)) for k in range(len(cells))]
        marks = ["," if mark == "," else "." for mark in own]
        cells[:] = [*map(_plain, cells, marks)]
    return decimal or ".", [*_faults(asked, decimal)]


def _fits(cell: str, decimal: str) -> bool:
    """True if the number in a cell may have this decimal mark."""
    match, other = _TOKEN.match(cell), "," if decimal == "." else "."
    number = match[1] if match else ""
    return other not in number or _is_grouped(number, other, decimal)


def _plain(cell: str, decimal: str) -> str:
    match = None if isinstance(cell, Typed) or cell.isdigit() else _TOKEN.match(cell)
    if match is None or not _fits(cell, decimal):
        return cell
    other, number = "," if decimal == "." else ".", cell[: match.end()]
    if re.search(rf"[{other}{GROUP}]", match[1]) and _is_grouped(match[1], other, decimal):
        number = re.sub(f"[{other}{GROUP}]", "", number)
    return number.replace(decimal, ".") + cell[match.end() :]


def _faults(asked: Iterable[tuple[int, str]], mark: str | None) -> Iterator[str]:
    """Yield a message on numbers that the decimal mark leaves open, or that contradict it."""
    faults = list[Fault]()
    for row, cell in asked:
        if mark is None and mark_of(cell) == _EITHER:
            both = f"{re.sub(r'[.,]', '', cell, count=1)} or {cell.replace(',', '.')}"
            why = f"{quoted(cell)} is {both}; say --decimal . or --decimal ,"
        elif mark is None:
            why = f"{quoted(cell)}, where others have another decimal mark; write all alike"
        else:
            why = f"{quoted(cell)} does not have the decimal mark {mark} of this table; write it so"
        faults.append(Fault("", why, row=row))
    yield from listed_faults(faults)
