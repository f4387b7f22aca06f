"""Tests of a laboratory's log: rows of a CSV file in place of tables of the scene.

A heading names an entry, with the unit of its column in brackets, such as ``load [N]``; a cell that
is empty leaves the entry out. Columns of other names, as of dates and operators, are not used.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline.scene.document import Document
from pipeline.scene.faults import Faults
from pipeline.scene.format import TEST, TRANSITION
from pipeline.scene.kinds import Kind, Number
from pipeline.scene.rows import quantity_and_unit, read_rows
from pipeline.scene.schema import Table


def with_rows(entries: dict[str, Any], document: Document, faults: Faults) -> dict[str, Any]:
    """Entries with the rows of log files in the place of the tests that name them.

    Faults are named by row and column; columns that are not used are noted.
    """
    for key, row_of in (("measured", TRANSITION), ("tested", TEST)):
        listed = entries.get(key)
        if not isinstance(listed, list) or not listed:
            continue
        rows: list[Any] = []
        for number, entry in enumerate(listed):
            if isinstance(entry, dict) and isinstance(entry.get("file"), str):
                place, folder = f"{key}[{number}].file", document.file_of(key).parent
                rows += _rows(entry, place, folder, row_of, faults)
            else:
                rows.append(entry)
        entries = {name: value for name, value in entries.items() if name != key}
        if rows:  # otherwise all are faulty, which is said already
            entries[key] = rows
    return entries


def _rows(
    entry: dict[str, Any], place: str, folder: Path, row_of: Table, faults: Faults
) -> list[dict[str, Any]]:
    """Rows of a file as tables of a scene; faults are named by row and column."""
    if others := [f'"{name}"' for name in entry if name != "file"]:
        problem = f"stands beside {', '.join(others)}; give these as columns of the file"
        faults.note(place, problem)
    path = folder / entry["file"]
    try:
        heads, numbered, wrong_rows = read_rows(path)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not in UTF-8"
        faults.note(place, f"{path} cannot be read: {reason}; give a CSV file in UTF-8")
        return []
    if not numbered:
        problem = f'{path} has no rows; begin it with a line such as "load [N],velocity [m/s]"'
        faults.note(place, problem)
    for problem in wrong_rows:
        faults.note(place, f"{path.name}, {problem}")
    columns = [quantity_and_unit(head) for head in heads]
    if unused := [name for name, _ in columns if name not in row_of.keys]:
        faults.notes.append(f"{place}: columns not used: {', '.join(unused)}")
    rows = []
    for number, cells in numbered:
        if len(cells) != len(columns):
            continue
        row = {
            name: _value(cell, unit, row_of.keys[name].kind)
            for (name, unit), cell in zip(columns, cells, strict=True)
            if name in row_of.keys and cell
        }
        wrong = Faults()
        row_of.read(row, "", wrong)
        for key, problem, _ in wrong:
            if "has no unit" in problem:
                problem += f"; or the unit of the column in its heading, such as {key} [...]"
            faults.note(place, f"{path.name}, row {number}, {key or 'row'}: {problem}")
        if not wrong:
            rows.append(row)
    return rows


def _value(cell: str, unit: str, kind: Kind) -> Any:
    """A cell as a scene file has it: a number, or text with a unit."""
    if unit in ("", "1", "-") and isinstance(kind, Number):
        try:
            return float(cell)
        except ValueError:
            return cell
    return f"{cell} {unit}".strip()
