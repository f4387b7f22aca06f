"""Operating points, read from a table."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pipeline.scene.faults import Faults
from pipeline.scene.format import LOAD, SPEED
from pipeline.scene.headings import (
    columns_for,
    heading_of,
    missing_columns,
    with_units_below,
)
from pipeline.scene.rows import may_be_thousands, read_rows
from pipeline.store.place import PathLike
from tribo import InputError

_KINDS = {"load": LOAD, "velocity": SPEED}
_MOST_FAULTS = 20  # that are written out


class Place(NamedTuple):
    """Operating point: load [N] and velocity [m/s].

    Examples
    --------
    >>> place = Place(load=400.0, velocity=2.2)
    >>> f"friction heat at friction 0.1: {0.1 * place.load * place.velocity:.0f} W"
    'friction heat at friction 0.1: 88 W'
    """

    load: float
    velocity: float


@dataclass(frozen=True, slots=True)
class OperatingPoints:
    """Operating points of a table, and its further columns.

    Attributes
    ----------
    places : tuple of Place
        Loads and velocities.
    others : mapping of str to sequence
        Further columns, by their headings.

    Examples
    --------
    >>> OperatingPoints((Place(500.0, 2.0),), {"gear": [3]}).places[0].velocity
    2.0
    """

    places: tuple[Place, ...]
    others: Mapping[str, Sequence[Any]]

    @classmethod
    def read(cls, source: PathLike | Mapping[str, Sequence[Any]]) -> OperatingPoints:
        """Read operating points.

        Parameters
        ----------
        source : path or mapping of str to sequence
            A file as CSV or Excel, or columns by heading, such as a data frame: ``load`` and
            ``velocity``, or such as ``Normalkraft / N``, with units in the heading or in each
            cell; bare numbers of a mapping are in N and m/s. Further columns are passed on.

        Raises
        ------
        InputError
            If the file cannot be read, or for all of its faults at once, by row and column.

        Examples
        --------
        >>> points = OperatingPoints.read({"load [kN]": [0.5], "velocity": ["2 m/s"], "gear": [3]})
        >>> points.places, dict(points.others)
        ((Place(load=500.0, velocity=2.0),), {'gear': [3]})
        """
        faults: list[str] = []
        if isinstance(source, Mapping) or not isinstance(source, str | os.PathLike):
            cells = _cells_of(source)
        else:
            cells = _read_file(Path(source), faults)
        quantities = {name: _quantity(cells, name, faults) for name in _KINDS}
        if faults:
            listed = [f"  {fault}" for fault in faults[:_MOST_FAULTS]]
            if more := len(faults) - len(listed):
                listed.append(f"  and {more} more")
            count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
            raise InputError("\n".join([f"{cells.name} has {count}:", *listed]))
        if not cells.rows:
            raise InputError(f"{cells.name} has no rows; give a load and a velocity in each")
        places = zip(*(values for _, values in quantities.values()), strict=True)
        others = dict(cells.columns)
        for head, _ in quantities.values():
            del others[head]
        return cls(tuple(Place(*place) for place in places), others)


class _Cells(NamedTuple):
    """Cells of a table by heading, the number of each row in its file, and its decimal mark."""

    name: str
    rows: Sequence[int]
    columns: Mapping[str, Sequence[Any]]
    decimal: str = "."


def _read_file(path: Path, faults: list[str]) -> _Cells:
    """Cells of a file, without its empty lines; faults are added to the list."""

    def is_heading(cells: list[str]) -> bool:
        places, wrong = columns_for(cells, _KINDS)
        return not wrong and _KINDS.keys() == places.keys()

    read = read_rows(path, is_heading)
    if not read.heads:
        raise InputError(f'{path} is empty; begin it with a line "load [N],velocity [m/s]"')
    twice = dict.fromkeys(head for head in read.heads if read.heads.count(head) > 1)
    faults += [f'column "{head}" stands there twice; name each once' for head in twice]
    faults += read.faults
    heads, rows = with_units_below(read.heads, read.rows)
    columns = {head: [row.cells[place] for row in rows] for place, head in enumerate(heads)}
    return _Cells(str(path), [row.number for row in rows], columns, read.decimal)


def _cells_of(columns: Any) -> _Cells:
    """Cells of a mapping or a data frame."""
    if not hasattr(columns, "keys"):
        raise InputError(
            f"points are of type {type(columns).__name__}; give a .csv or .xlsx file, or columns "
            'by heading such as {"load": ["500 N"], "velocity": ["2 m/s"]}'
        )
    listed = {str(head): list(np.atleast_1d(columns[head]).tolist()) for head in columns}
    lengths = {head: len(cells) for head, cells in listed.items()}
    if len(set(lengths.values())) > 1:
        counts = ", ".join(f"{head} {count}" for head, count in lengths.items())
        raise InputError(f"points: columns of unlike lengths: {counts}; give one of each in a row")
    return _Cells("points", range(1, 1 + max(lengths.values(), default=0)), listed)


def _quantity(cells: _Cells, name: str, faults: list[str]) -> tuple[str, list[float]]:
    """Heading and values in SI of a quantity; faults are added to the list."""
    kind = _KINDS[name]
    usual = kind.example.split()[1]
    places, ambiguous = columns_for([*cells.columns], [name])
    if name not in places:
        named = f'; name one as in "{name} [{usual}]"'
        faults += [f"{problem}{named}" for problem in ambiguous]
        faults += [] if ambiguous else [missing_columns([*cells.columns], [name])]
        return "", []
    head = [*cells.columns][places[name]]
    unit, wrong, values = heading_of(head).unit, Faults(), list[float]()
    heading = "" if unit else f', or the heading "{name} [{usual}]"'
    if unit:
        kind.read(f"1 {unit}", f'column "{head}"', wrong)
    for row, cell in zip(cells.rows, cells.columns[head], strict=True) if not wrong else ():
        in_si = not unit and not isinstance(cell, str)
        place, text = f'row {row}, column "{head}"', f"{cell} {usual if in_si else unit}".strip()
        if cells.decimal == "," and may_be_thousands(str(cell)):
            wrong.note(place, f'"{cell}" beside decimal commas may be thousands; write it plainly')
        elif str(cell).strip():
            values.append(kind.read(text, place, wrong))
        else:
            wrong.note(place, f"empty; give {kind}")
    faults += [f"{place}: {problem}{heading}" for place, problem, *_ in wrong]
    return head, values
