"""What a user says of a table's file, such as columns, rows and sheet; and the table read by it."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated as A
from typing import Any

from pipeline import extras
from pipeline.paths import user_path
from pipeline.scene.declare import ByPath, Declared
from pipeline.scene.faults import did_you_mean, quoted
from pipeline.scene.kinds import OneOf, Scalar, Text
from pipeline.scene.lines import Lines, read_lines
from pipeline.scene.names import Heading, Names
from pipeline.scene.sheet import Sheet, Written, sheet_of
from pipeline.scene.units import UnitError, to_si
from pipeline.sweep.limits import MOST_ROWS
from tribo import InputError


# fmt: off
class Choices(Declared):
    """What a user says of the file of a table."""

    columns: A[dict[str, str] | None, ByPath(Text(), "quantities"),
        "Heading of the column of a quantity, if it is not recognised, and its unit."] = None
    given: A[dict[str, Any] | None, ByPath(Scalar(), "quantities"),
        "Quantities that the file does not say, the same in each row."] = None
    where: A[dict[str, Any] | None, ByPath(Scalar(), "headings or quantities"),
        "Rows to take: those with this value in a column, such as the name of one oil."] = None
    skip: A[dict[str, Any] | None, ByPath(Scalar(), "headings or quantities"),
        "Rows to leave out: those with this value in a column, such as an aborted run."] = None
    decimal: A[str | None, OneOf((".", ",")),
        "Decimal mark; by default as its numbers show."] = None
    sheet: A[str | None,
        "Sheet of a workbook; by default the first with columns that are needed."] = None


class TableFile(Choices):
    """File of a table in a scene, with what is said of it."""

    path: A[str, "File, relative to the scene's folder."]

    def __hash__(self) -> int:
        return hash(repr(self))  # its dictionaries have no hash
# fmt: on


NO_CHOICES = Choices()


def choices_of(file: str | TableFile) -> tuple[str, Choices]:
    """Path and choices of a scene's entry that names a file."""
    return (file, NO_CHOICES) if isinstance(file, str) else (file.path, file)


def choose(sheet: Sheet, choices: Choices, chosen: Mapping[str, str]) -> None:
    """Apply `choices` to a sheet: units of columns, rows to take and to leave out, given values.

    `chosen` has the headings that were chosen, by quantity. Faults are added to the sheet.
    """
    heads = [*sheet.above, *(one.text for one in sheet.headings)]
    for name, head in chosen.items():
        choose_unit(sheet, name, Heading.of(head).unit)
        is_there = head.partition(" [")[0] in " ".join(heads)
        if name not in sheet.places and (name in sheet.units or not is_there):
            every = ", ".join(quoted(one.text) for one in sheet.headings)
            sheet.faults.append(f"columns.{name}: no column {quoted(head)}; give one of {every}")
    _take_rows(sheet, choices.where or {}, is_kept=True)
    _take_rows(sheet, choices.skip or {}, is_kept=False)
    for name, value in (choices.given or {}).items():  # columns that the file lacks
        if name not in sheet.units:  # a log ignores what only traces need, and the reverse
            continue
        like = sheet.units[name]
        try:
            if like is not None and (like or not re.fullmatch(r"[\d.eE+-]+", str(value))):
                to_si(str(value), f"1 {like}")
        except UnitError as error:
            sheet.faults.append(f'given.{name}: {error}; give one such as "1 {like}"')
            continue
        sheet.add(name, "", [str(value)] * len(sheet.rows))


def require_known(choices: Choices, known: set[str]) -> None:
    """Raise an `InputError` if choices name another quantity than those `known`."""
    for option in ("columns", "given"):
        for name in (one for one in getattr(choices, option) or () if one not in known):
            near, every = did_you_mean(name, known), ", ".join(sorted(known))
            raise InputError(f"{option}.{name}: no such quantity{near}; give one of {every}")


def choose_unit(sheet: Sheet, name: str, unit: str) -> None:
    """Set the unit of the column of quantity `name`, if the heading does not state a unit."""
    if name in sheet.places and unit and not (heading := sheet.heading(name)).unit:
        text = f"{heading.text} [{unit}]"
        sheet.headings[sheet.places[name]] = Heading(text, heading.title, unit)


def _take_rows(sheet: Sheet, values: Mapping[str, Any], is_kept: bool) -> None:
    """Keep only rows with `values` by heading or quantity, or leave them out if not `is_kept`."""
    heads = [heading.text for heading in sheet.headings]
    for head, value in values.items():
        if head not in heads and head not in sheet.places:
            option, listed = "where" if is_kept else "skip", ", ".join(filter(None, heads))
            sheet.faults.append(f'{option}: there is no column "{head}"; give one of {listed}')
            continue
        place = heads.index(head) if head in heads else sheet.places[head]
        found = {row.number: row.cells[place] for row in sheet.rows}
        wanted = {number for number, cell in found.items() if cell == str(value)}
        if not wanted:
            listed = ", ".join(sorted({*filter(None, found.values())})[:20])
            sheet.faults.append(f'no row has "{value}" as {head}; give one of {listed}')
        left = found.keys() - wanted if is_kept else wanted
        reason = f"{'is not of' if is_kept else 'has'} {head} {value}"
        sheet.leave_out(dict.fromkeys(left, reason))


def read_sheet(
    source: Path | Lines, units: Mapping[str, str | None], needed: Collection[str],
    moving: Collection[str] = (), choices: Choices = NO_CHOICES, written: Written = "scene",
    most: int = MOST_ROWS,
) -> Sheet:  # fmt: skip
    """Read a table from a file or from lines (`source`), and find the columns of quantities.

    `units` has the quantities to look for, with their SI units. Rows that lack a `needed` quantity,
    or in which a quantity of `moving` is 0, are left out and counted. `choices` are those of the
    user, and messages name them as they are `written`. `most` is the largest number of rows of a
    text.
    """
    words: Any = next(extras.modules("tables"), None)
    chosen = choices.columns or {}
    names = words.WordNames(units, chosen) if words else Names(units, chosen)
    require_known(choices, {*names.units})
    name, tables = "points", [source] if isinstance(source, Lines) else []
    if isinstance(source, Path):
        name, tables = str(source), read_lines(user_path(source), names, choices.sheet, most)
    found = sheet_of(name, tables, names, choices.decimal)
    choose(found, choices, chosen)
    if words:
        words.derive(found, needed)
    found.require(needed, moving)
    found.written = written
    return found
