"""Tables of tests, operating points and loads: CSV or Excel, with headings such as "load [N]"."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from pipeline.paths import reason_of, user_path
from pipeline.units import as_entry
from pipeline.words import quoted
from tribo import InputError

_HEADING = re.compile(r"(.+?)\s*\[([^\[\]]*)\]")
_SAME = {"normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature"}
_MOST_SAID = 18  # faults that are named
_NUMBER = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?")
_ENDINGS = {".xlsx": pd.read_excel, ".xls": pd.read_excel}


class Column(NamedTuple):
    """A column: its heading, the name of its quantity or entry, its unit, and its cells as text."""

    head: str
    name: str
    unit: str
    cells: list[str]

    @classmethod
    def of(cls, head: str, cells: Sequence[Any]) -> Column:
        """A column by its heading, such as "load [N]"."""
        found = _HEADING.fullmatch(head.strip())
        name, unit = (found[1], found[2]) if found else (head.strip(), "")
        bare = name if "." in name else name.lower().replace(" ", "_")
        bare = _SAME.get(bare, bare)
        return cls(head.strip(), bare, unit, ["" if pd.isna(x) else str(x).strip() for x in cells])

    def entry(self, row: int) -> str | float:
        """The entry of a row; a cell without a unit of its own has that of the column."""
        cell = self.cells[row]
        return as_entry(cell, self.unit if _NUMBER.fullmatch(cell) else "")


_SI = {"load": "N", "velocity": "m/s", "bulk_temperature": "K", "critical_temperature": "K"}
"""Units of columns of numbers that are given in Python without one."""


def read_columns(source: str | Path | Mapping[str, Sequence[Any]], most: int) -> list[Column]:
    """Read a file, or columns by heading such as a data frame; numbers have decimal points."""
    if isinstance(source, str | Path):
        path = user_path(source)
        read = _ENDINGS.get(path.suffix.lower(), pd.read_csv)
        try:
            frame = read(path, dtype=str, comment="#", keep_default_na=False)
        except OSError as error:
            raise InputError(f"{path} cannot be read: {reason_of(error, path)}") from error
        except (ValueError, ImportError, pd.errors.ParserError) as error:
            raise InputError(f"{path} is no table with a row of headings: {error}") from error
    else:
        frame = pd.DataFrame({str(head): list(cells) for head, cells in source.items()})
        numeric = frame.select_dtypes("number")
        frame = frame.rename(columns={x: f"{x} [{_SI[x]}]" for x in numeric if x in _SI})
    if len(frame) > most:
        raise InputError(f"the table has {len(frame)} rows; at most {most} are read")
    return [Column.of(str(head), frame[head].tolist()) for head in frame]


def rows_of(
    columns: Sequence[Column],
    names: Collection[str],
    faults_in: Callable[[dict[str, Any]], Iterable[Sequence[Any]]],
    needed: Collection[str] = (),
) -> list[dict[str, Any]]:
    """Entries in each row, as a scene file has them, of the columns in `names`.

    Empty cells are left out. Raises an `InputError` with all faults: columns of `needed` that are
    missing, or pairs (name, reason) that `faults_in` finds in a row.
    """
    known = {one.name: one for one in columns}
    if missing := [name for name in needed if name not in known]:
        heads = ", ".join(quoted(one.head) for one in columns)
        raise InputError(f"no column {', '.join(missing)} in {heads}; give it, with its unit")
    rows, said = list[dict[str, Any]](), list[str]()
    for number in range(len(columns[0].cells) if columns else 0):
        own = [one for name, one in known.items() if name in names and one.cells[number]]
        row = {one.name: one.entry(number) for one in own}
        said += [f"row {number + 2}, {name}: {why}" for name, why, *_ in faults_in(row)]
        rows.append(row)
    if said:
        raise InputError("\n  ".join([f"the table: {len(said)} faults", *said[:_MOST_SAID]]))
    return rows
