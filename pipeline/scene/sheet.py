"""Reader of tables: rows below headings, in text, in a workbook, or as columns in Python.

Every row and cell is used, left out with the reason, or refused. A column is found by the plain
name of a quantity, such as ``load [N]``. The extra ``laboratory`` adds names, reads workbooks, and
derives quantities from others, by its module ``tables``.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline import extras
from pipeline.paths import decoded, read_file, reason_of, user_path
from pipeline.scene.declare import table_of
from pipeline.scene.faults import (
    Fault,
    Faults,
    did_you_mean,
    fault_lines,
    listed_faults,
    quoted,
    row_text,
)
from pipeline.scene.kinds import OneOf
from pipeline.scene.names import Heading, Names
from pipeline.scene.units import as_entry, clock_time, is_unit, to_si, unit_of_table
from pipeline.sweep.limits import MOST_BYTES_OF_TEXT, MOST_ROWS
from tribo import InputError
from tribo.types import Array

BETWEEN = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", "  ": "wide blanks",
           " ": "blanks"}  # fmt: skip
"""Separators of cells, and their names; of equally good ones the first is taken."""
_GROUP = "'’\xa0\u202f"  # marks of thousands that never mark decimals
NUMBER = re.compile(rf"[<>]?[+-]?(?:\d[\d.,{_GROUP}]*|[.,]\d+)(?:[eE][+-]?\d+)?(?:\s\D*)?")
"""A number with decimal or thousands marks of any kind, and perhaps a unit."""
_ZERO = re.compile(r"[+-]?0*[.,]?0*(?:[eE][+-]?\d+)?(?:\s.*)?")
EMPTY = ("", "-", "–", "--", "---", "nan", "n/a", "na", "null", "none", "nat", "<na>")
"""Contents of cells without a value, in lower case."""
_MOST_ABOVE = 200  # rows that are searched for the row of headings
_WIDEST = 1000  # headings of a row, each of which is compared with all names
_SAMPLE = 150  # lines at each end from which the separator is found
_PLURAL = {"has": "have", "is": "are", "stands": "stand"}
_DAY = 86400.0  # [s]


class SheetRow(NamedTuple):
    """Row of a table: its number in the file, and its cells."""

    number: int
    cells: list[str]


class Lines(NamedTuple):
    """Rows of a text or a sheet that are not empty, and notes on how they were read."""

    rows: list[SheetRow]
    form: list[str]


@dataclass(slots=True)
class Sheet:
    """A table that was read: its rows, the columns of its quantities, and rows left out."""

    name: str  # of the file, in messages
    units: Mapping[str, str | None]  # SI units of quantities, None for text
    headings: list[Heading]
    places: dict[str, int]  # column of each quantity that was found
    faults: list[str]
    form: list[str]  # words on separators, decimals and the sheet
    above: list[str]  # cells above the headings
    rows: list[SheetRow] = field(default_factory=list)  # that are used, with decimal points
    left_out: dict[int, str] = field(default_factory=dict)  # reasons by the numbers of rows
    sources: set[int] = field(default_factory=set)  # columns from which others were derived

    @property
    def unused(self) -> list[str]:
        """Headings of the columns that are not used."""
        used = {*self.places.values(), *self.sources}
        return [one.text for k, one in enumerate(self.headings) if one.text and k not in used]

    @property
    def remarks(self) -> list[str]:
        """Notes on columns and sheets that were not used."""
        unused = ", ".join(self.unused)
        return [*filter(None, (unused and f"columns not used: {unused}", self.other_sheets))]

    @property
    def counted(self) -> str:
        """Numbers of rows used and left out, with reasons, in words; empty if all are used."""
        said = []
        for reason in dict.fromkeys(self.left_out.values()):
            numbers = sorted(row for row, why in self.left_out.items() if why == reason)
            verb, _, rest = reason.partition(" ")
            said.append(f"{row_text(numbers)} {_PLURAL[verb] if numbers[1:] else verb} {rest}")
        used, left = len(self.rows), len(self.left_out)
        return f"{used + left} rows: {used} used, {left} left out: {'; '.join(said)}" * bool(left)

    @property
    def other_sheets(self) -> str:
        """Note that names the sheet that was read, and the sheets left out; empty for one sheet."""
        return next((words for words in self.form if "(not read: " in words), "")

    def heading(self, name: str) -> Heading:
        """Heading of the column of a quantity."""
        return self.headings[self.places[name]]

    def add(self, name: str, unit: str, cells: Iterable[str]) -> None:
        """Append a column of `cells` in a unit for the quantity `name`."""
        self.places[name] = len(self.headings)
        self.headings.append(Heading(name, name, unit))
        for row, cell in zip(self.rows, cells, strict=True):
            row.cells.append(cell)

    def leave_out(self, reasons: Mapping[int, str]) -> None:
        """Leave out rows, with a reason for each row number."""
        self.left_out |= reasons
        self.rows = [row for row in self.rows if row.number not in reasons]

    def require(self, needed: Collection[str], moving: Collection[str] = ()) -> None:
        """Add a fault if columns are missing; leave out rows in which a `needed` cell is empty.

        Missing columns add no fault if the sheet has faults already. Rows in which a quantity of
        `moving` is 0 are left out, too.
        """
        missing = {name: self.units[name] for name in needed if name not in self.places}
        if missing and not self.faults:
            wanted = (f"{name} [{unit}]" if unit else name for name, unit in missing.items())
            near = "".join(did_you_mean(heading.name, missing) for heading in self.headings)
            heads = ", ".join(quoted(heading.text) for heading in self.headings) or "an empty file"
            self.faults.append(f"no column {', '.join(wanted)} in {heads}{near}")
        columns = {name: self.places[name] for name in needed if name in self.places}
        reasons = dict[int, str]()
        for number, cells in self.rows:
            if empty := [name for name, k in columns.items() if cells[k].lower() in EMPTY]:
                reasons[number] = f"has no {' and no '.join(empty)}"
            elif any(_ZERO.fullmatch(cells[k]) for name, k in columns.items() if name in moving):
                reasons[number] = "is at rest"
        self.leave_out(reasons)

    def numbers(self, name: str) -> Array:
        """Values (n_row,) of the quantity `name` in SI; NaN where a cell has no number.

        A cell that is neither empty nor a number adds a message to the sheet's `faults`. Times of
        day become seconds since the first row.
        """
        place, unit, like = self.places[name], self.heading(name).unit, self.units[name] or ""
        zero, one = 0.0, 0.01 if unit == "%" else 1.0
        if like and unit:
            zero, one = (to_si(f"{k} {unit}", f"1 {like}") for k in (0, 1))
        values, faults = np.full(len(self.rows), np.nan), list[Fault]()
        is_clock = name == "time" and any(":" in row.cells[place] for row in self.rows[:1])
        for k, (number, cells) in enumerate(self.rows):
            cell = cells[place]
            try:
                if is_clock:
                    values[k] = clock_time(cell)
                elif (unit or not like) and re.fullmatch(r"[-+.\deE]+", cell):
                    values[k] = zero + (one - zero) * float(cell)
                elif cell.lower() not in EMPTY:
                    values[k] = to_si(cell, f"1 {like}")
            except ValueError as error:  # a UnitError is one
                faults.append(Fault(name, str(error), row=number))
        self.faults += [one for one in listed_faults(faults) if one not in self.faults]
        days = np.cumsum(np.diff(values, prepend=values[:1]) < -_DAY / 2)  # midnights
        return values + _DAY * days - values[:1] if is_clock else values

    def entries(
        self, declared: type, words: Mapping[str, str] | None = None, may_lack: Collection[str] = ()
    ) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
        """Convert rows without faults to entries of a scene's table.

        Returns two lists with a dictionary for each row: the entries as written, and their values
        in SI. `declared` is the class of the table. `words` translates cells into allowed words. An
        empty cell is a fault, except in the columns `may_lack`. Faults are added to the sheet's.
        """
        row_of = table_of(declared)
        tables, read, faults = [], [], list[Fault]()
        for number, cells in self.rows:
            table, wrong = dict[str, Any](), Faults()
            for name in (name for name in row_of.keys if name in self.places):
                cell = cells[self.places[name]]
                if isinstance(row_of.keys[name].kind, OneOf):
                    table[name] = (words or {}).get(cell, cell)
                elif cell.lower() not in EMPTY:
                    table[name] = as_entry(cell, self.heading(name).unit)
                elif name not in may_lack:
                    wrong.refuse(name, "is empty; fill it, or leave out the row or the column")
            if "number" in row_of.keys:
                table.setdefault("number", f"row {number}")
            values = row_of.read(table, "", wrong)
            if not wrong:
                tables.append(table)
                read.append(vars(values))
            # A missing column is reported once, not for each row.
            own = (one for one in wrong if one.key in self.places)
            faults += [one._replace(row=number) for one in own]
        self.faults += listed_faults(faults)
        return tables, read

    def refuse_faults(self, first_line: str) -> None:
        """Raise an `InputError` if the sheet has faults or no rows; its message lists all faults.

        The message may show `first_line` as an example of a correct line of headings.
        """
        if not (self.rows or self.faults):
            self.faults.append(f'there are no rows; begin with a line "{first_line}"')
        if self.faults:
            hint = f'; write the unit in the heading, as in "{first_line}"'
            faults = [fault + hint * ("has no unit" in fault) for fault in self.faults]
            place = ", ".join(filter(None, [self.name, self.other_sheets]))
            raise InputError(fault_lines(place, faults))


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
        if content.startswith((b"PK", b"\xd0\xcf\x11\xe0", b"%PDF")) or sheet:
            tables: list[Lines] = extras.module("workbook").read_book(path, sheet)
            return tables
        text, form = decoded(content)
        _require_few(path, lines := text.splitlines(), most)
        mark = find_separator(lines, names)
        rows = [row for row in split_lines(lines, mark) if any(row.cells)]
    except (OSError, csv.Error) as error:
        reason = reason_of(error, path) if isinstance(error, OSError) else str(error)
        raise InputError(f"{path} cannot be read: {reason}") from error
    return [Lines(rows, [f"{BETWEEN[mark]} between cells", *form])]


def _require_few(path: Path, lines: Sequence[str], most: int) -> None:
    """Raise an `InputError` for more than `most` rows, before they are split into cells."""
    if len(lines) > most + _MOST_ABOVE:
        raise InputError(
            f"{path} has {len(lines)} rows, and at most {most} can be used here; keep fewer, such "
            f"as one of {math.ceil(len(lines) / most)}"
        )


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
        if 2 * sum(bool(NUMBER.fullmatch(cell)) for cell in row.cells) <= len(row.cells) < _WIDEST
    )
    named, start = max(counts, default=(0, 0))
    return named, -start


def sheet_of(name: str, tables: Sequence[Lines], names: Names, decimal: str | None = None) -> Sheet:
    """Make a `Sheet` from the table whose headings name the largest number of quantities.

    `name` is the name of the file, for messages. `names` are the quantities to look for, and
    `tables` the rows of each table of the file. `decimal` is the decimal mark, "," or "."; with
    None it is found from the cells.
    """
    tops = [find_headings(table.rows, names) for table in tables]
    best = max(range(len(tables)), key=lambda place: tops[place][0])
    (rows, form), (_, start) = tables[best], tops[best]
    headings, taken = headings_at(rows or [SheetRow(0, [""])], start)
    body = rows[start + taken :]
    while headings and not headings[-1].text:
        del headings[-1]
    first = [x.cells[0] for x in body if len(x.cells) == len(headings) + 1 and x.cells[-1]]
    if body and first in ([*map(str, range(k, k + len(body)))] for k in (0, 1)):
        headings.insert(0, Heading("", "", ""))  # the first column only counts the rows
    above = [cell for row in rows[:start] for cell in row.cells]
    places, faults = names.columns(headings)
    sheet = Sheet(name, names.units, headings, places, [*faults.values()], [*form], above)
    is_inside, width = True, len(headings)
    numeric = [k for name, k in sheet.places.items() if sheet.units[name] is not None]
    for number, cells in body:
        filled = [cell for cell in cells if cell]
        is_same, is_words = cells == rows[start].cells, not any(map(NUMBER.fullmatch, filled))
        if is_same or (is_words and len(filled) > 1):
            others = 0 if is_same else names.count(headings_at([SheetRow(0, cells)], 0)[0])
            is_inside = others < 2
            if others >= max(2, len({*places.values()})):
                sheet.faults.append(f"row {number} begins a second table; give it in its own file")
        if cells[0].startswith("#") and len(filled) == 1:
            sheet.left_out[number] = "is commented out"
        elif is_same or not is_inside:
            sheet.left_out[number] = "has the headings again" if is_same else "stands below others"
        elif numeric and not any(re.search(r"[\d#=]", cells[k]) for k in numeric if cells[k:]):
            sheet.left_out[number] = "has no number"
        elif any(cells[width:]):
            sheet.faults.append(f"row {number}: {len(cells)} cells below {width} headings")
        else:
            sheet.rows.append(SheetRow(number, [*cells, *[""] * width][:width]))
    _make_plain(sheet, decimal)
    return sheet


def _make_plain(sheet: Sheet, decimal: str | None) -> None:
    """Rewrite numbers with a decimal point, without thousands marks; `decimal` may be unknown."""
    cells = {cell.partition(" ")[0] for row in sheet.rows for cell in row.cells}
    commas = [cell for cell in cells if re.fullmatch(r"[+-]?[\d.]*,\d*([eE][+-]?\d+)?", cell)]
    # Between commas such numbers are quoted; a comma before three digits may mark thousands.
    is_sure = "commas between cells" not in sheet.form
    is_comma = any(is_sure or not re.search(r"[1-9],\d{3}$", cell) for cell in commas)
    mark, other = (",", ".") if decimal == "," or (is_comma and not decimal) else (".", ",")
    sheet.form.append(f"decimal {'commas' if mark == ',' else 'points'}")
    groups = re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:[{other}{_GROUP}]\d{{3}})+(?![\d{other}])")
    for row in sheet.rows:
        for k, cell in enumerate(row.cells):
            if match := groups.match(cell):
                plain, rest = re.sub(f"[{other}{_GROUP}]", "", match[0]), cell[match.end() :]
                is_plain = decimal or other not in match[0] or rest[:1] == mark
                # What may be read in two ways becomes a text that says so.
                both = f"{plain} or {cell.replace(',', '.')}"
                cell = plain + rest if is_plain else f"{cell}, {both} by the decimal mark"
            is_decimal = mark == "," and re.match(r"[+-]?\d*,\d*(?![\d,.])", cell)
            row.cells[k] = cell.replace(",", ".", 1) if is_decimal else cell


def read_sheet(
    source: Path | Lines, units: Mapping[str, str | None], needed: Collection[str],
    moving: Collection[str] = (), sheet: str | None = None, most: int = MOST_ROWS,
) -> Sheet:  # fmt: skip
    """Read a table from a file or from lines (`source`), and find the columns of quantities.

    `units` has the quantities to look for, with their SI units. Rows that lack a `needed` quantity,
    or in which a quantity of `moving` is 0, are left out and counted. `sheet` is the name of a
    sheet in a workbook, and `most` the largest number of rows of a text.
    """
    words: Any = next(extras.modules("tables"), None)
    names = words.WordNames(units) if words else Names(units)
    tables = (
        read_lines(user_path(source), names, sheet, most) if isinstance(source, Path) else [source]
    )
    found = sheet_of("points" if isinstance(source, Lines) else str(source), tables, names)
    if words:
        words.derive(found, needed)
    found.require(needed, moving)
    return found
