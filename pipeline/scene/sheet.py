"""Reader of tables: rows below headings, in text, in a workbook, or as columns in Python.

Every row and cell is used, left out with the reason, or refused. A column is found by the plain
name of a quantity, such as ``load [N]``. The extra ``laboratory`` adds names, reads workbooks, and
derives quantities from others, by its module ``tables``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from pipeline.scene.decimals import make_plain
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
from pipeline.scene.lines import NUMBER, WIDEST, Lines, SheetRow, find_headings, headings_at
from pipeline.scene.names import Heading, Names
from pipeline.scene.units import as_entry, clock_time, to_si
from tribo import InputError
from tribo.types import Array

_ZERO = re.compile(r"[+-]?0*[.,]?0*(?:[eE][+-]?\d+)?(?:\s.*)?")
EMPTY = ("", "-", "–", "--", "---", "nan", "n/a", "na", "null", "none", "nat", "<na>")
"""Contents of cells without a value, in lower case."""
_PLURAL = {"has": "have", "is": "are", "stands": "stand", "repeats": "repeat"}
_DAY = 86400.0  # [s]
Written = Literal["command", "scene", "Python"]
"""Where a user reads a table: by a command, from a scene file, or by a function."""
_ENTRIES = {"column": "columns", "word": "words"}
_PAIR = re.compile(r'--(column|given|where|skip|word) "([^"=]*)=((?:\\"|[^"])*)"')
_OF_FILE = re.compile(r"--(?!word)[a-z]+ \S")
_VALUE = re.compile(r"--(decimal|sheet) (names|[.,](?= or)|\S+?(?=[;,]? |$))")


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
    written: Written = "command"  # where the table is named, and so its options

    @property
    def told_faults(self) -> list[str]:
        """Faults, with options as they are written where the table is named."""
        return [in_words_of(self.written, fault) for fault in self.faults]

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
            given = (f"{name}=... {unit or ''}".strip() for name, unit in missing.items())
            options = " ".join(f'--given "{one}"' for one in given)
            self.faults.append(
                f"no column {', '.join(wanted)} in {heads}{near}; name it by "
                f'--column "{next(iter(missing))}=HEADING", or {options}'
            )
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

    def require_rows(self, first_line: str) -> None:
        """Add a fault if no row is used; without any row it shows `first_line` as an example."""
        if not (self.rows or self.faults):
            example = f'there are no rows; begin with a line such as "{first_line}"'
            self.faults.append(f"no row is left of {self.counted}" if self.counted else example)

    def refuse_faults(self, first_line: str) -> None:
        """Raise an `InputError` if the sheet has faults or no rows; its message lists all faults.

        The message may show `first_line` as an example of a correct line of headings.
        """
        self.require_rows(first_line)
        if self.faults:
            hint = f'; write the unit in the heading, as in "{first_line}"'
            faults = [fault + hint * ("has no unit" in fault) for fault in self.told_faults]
            place = ", ".join(filter(None, [self.name, self.other_sheets]))
            raise InputError(fault_lines(place, faults))


def sheet_of(name: str, tables: Sequence[Lines], names: Names, decimal: str | None = None) -> Sheet:
    """Make a `Sheet` from the table whose headings name the largest number of quantities.

    `name` is the name of the file, for messages. `names` are the quantities to look for, and
    `tables` the rows of each table of the file. `decimal` is the decimal mark, "," or "."; with
    None it is found from the cells.
    """
    tops = [find_headings(table.rows, names) for table in tables]
    best = max(range(len(tables)), key=lambda place: tops[place][0])
    (rows, form, between), (_, start) = tables[best], tops[best]
    if rows and len(rows[start].cells) > WIDEST:
        raise InputError(
            f"{name}, row {rows[start].number}: {len(rows[start].cells)} cells; at most {WIDEST} "
            "columns are read; give each row in a line, with the columns that are needed"
        )
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
    is_inside, width, more = True, len(headings), list[Fault]()
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
            more.append(Fault("", f"{len(cells)} cells below {width} headings", row=number))
        else:
            sheet.rows.append(SheetRow(number, [*cells, *[""] * width][:width]))
    mark, doubtful = make_plain(sheet.rows, numeric, decimal, between)
    sheet.faults += [*listed_faults(more), *doubtful]
    sheet.form.append(f"decimal {'commas' if mark == ',' else 'points'}")
    return sheet


def in_words_of(written: Written, message: str) -> str:
    """Rewrite the options in a message, such as ``--decimal ,``, as they are written elsewhere.

    Examples
    --------
    >>> in_words_of("scene", 'no load; name it by --column "load=HEADING", or --decimal ,')
    'no load; name it by columns = { load = "HEADING" }, or decimal = ",", in { path = "FILE" }'
    """
    if written == "command":
        return message
    pair = '{} = {{ {} = "{}" }}' if written == "scene" else '{}={{"{}": "{}"}}'
    one = '{} = "{}"' if written == "scene" else '{}="{}"'

    def pair_of(match: re.Match[str]) -> str:
        name, key, value = match.groups()
        is_bare = written != "scene" or re.fullmatch(r"\w+", key)
        return pair.format(_ENTRIES.get(name, name), key if is_bare else f'"{key}"', value)

    told = _VALUE.sub(
        lambda match: match[1] if match[2] == "names" else one.format(*match.groups()),
        _PAIR.sub(pair_of, message),
    )
    is_of_file = written == "scene" and bool(_OF_FILE.search(message))
    return told + ', in { path = "FILE" }' * is_of_file
