"""Operating points, read from a table, and their distances from severe wear as a data frame."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.boundary import BAND
from pipeline.analysis.dataset import dataset_of, require_plane
from pipeline.analysis.margin import NOT_DECIDED, Margin, Row
from pipeline.analysis.margins import rows_of
from pipeline.analysis.scenes import frame_by_scene, heads_of
from pipeline.analysis.tables import as_dict, frame_of
from pipeline.scene.bodies import LOAD, SPEED
from pipeline.scene.faults import Faults
from pipeline.scene.headings import Sheet, read_sheet, sheet_of
from pipeline.scene.rows import may_be_thousands
from pipeline.store.place import PathLike
from pipeline.sweep.variants import PLACE, VARIANT
from tribo import InputError


def margin_table(
    ds: xr.Dataset | PathLike,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]] | None = None,
    **conditions: Any,
) -> pd.DataFrame:
    """Distances of operating points from severe wear, without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store.
    points : path or mapping of str to sequence
        A .csv file with columns ``load [N]`` and ``velocity [m/s]``, or in other units; or columns
        by heading, such as a data frame. Further columns are passed on, with "(given)" after the
        heading where a result has the same.
    **conditions
        Friction, temperatures, share and criterion; see `pipeline.boundary`.

    Returns
    -------
    DataFrame
        A row for each operating point: ``load [N]``, ``velocity [m/s]``, the ``verdict`` beyond the
        error of its temperature, ``decisive temperature [°C]``, ``temperature error [K]``, the
        ``distance [K]`` below the critical temperature, ``velocity factor``, ``critical velocity
        [m/s]``, ``load factor``, ``critical load [N]``, and the outcome along each axis. Over
        several surfaces it has medians, the numbers of ``variants`` and of those that are
        ``severe`` and ``undecided``, and the ends of the band, ``distance low [K]`` and ``high``. A
        point that the sweep says nothing about has a ``note`` instead.

    Raises
    ------
    InputError
        If the table has faults, all of which are named, or a condition lies outside its range.

    Examples
    --------
    >>> import pipeline
    >>> points = {"load": ["500 N", "600 N"], "velocity": ["1.6 m/s", "2 m/s"]}
    >>> pipeline.margin_table("results/first_try.zarr", points)[["load [N]", "verdict"]]
       load [N] verdict
    0     500.0    mild
    1     600.0  severe
    """
    if points is None:
        ds = dataset_of(ds)
        return frame_of_rows(ds, rows_of(ds, **conditions))
    read = points if isinstance(points, OperatingPoints) else OperatingPoints.read(points)
    ds = dataset_of(ds)
    require_plane(ds)

    def of_scene(scene: xr.Dataset) -> pd.DataFrame:
        rows = rows_of(scene, **conditions)
        if len(rows) == 1:
            return frame_of_points(read, _HEADS, lambda *place: _of_one(rows[0].at(*place)))
        return frame_of_points(
            read, _HEADS_OF_SEVERAL, lambda *place: _of_several([row.at(*place) for row in rows])
        )

    return frame_by_scene(ds, of_scene)


def frame_of_points(
    points: OperatingPoints,
    heads: Sequence[str],
    answer: Callable[[float, float], Sequence[Any]],
) -> pd.DataFrame:
    """Frame with the further columns of each operating point, its place, an answer, and a note.

    The answer ends with the note. Where a point raises an `InputError`, that is the note, and its
    verdict is not known.
    """
    results = _results(heads, [(place, partial(answer, *place)) for place in points.places])
    others = {
        f"{head} (given)" if head in {*results, *as_dict(results)} else head: values
        for head, values in points.others.items()
    }
    return pd.concat([pd.DataFrame(others, index=results.index), results], axis="columns")


def _results(
    heads: Sequence[str],
    asked: Iterable[tuple[tuple[float, float], Callable[[], Sequence[Any]]]],
) -> pd.DataFrame:
    """Frame of answers at places; where an `InputError` stands for one it is the note."""
    rows = []
    for place, answer in asked:
        try:
            rows.append((*place, *answer()))
        except InputError as error:
            rows.append((*place, "not known", *[None] * (len(heads) - 1), str(error)))
    return frame_of(["load [N]", "velocity [m/s]", *heads, "note"], rows)


def frame_of_rows(ds: xr.Dataset, rows: Iterable[Row]) -> pd.DataFrame:
    """Frame of the rows of the table of variants that have places of their own, with margins."""
    rows = [row for row in rows if row.place]
    held = [name for row in rows[:1] for name in row.shown]
    names = [name for name in held if name not in (PLACE, VARIANT)] or held
    heads = heads_of(ds, names)
    labels = frame_of([*heads.values()], [[row.shown[name] for name in heads] for row in rows])
    asked = [(row.place or (np.nan, np.nan), lambda row=row: _of_one(row.here())) for row in rows]
    return pd.concat([labels, _results(_HEADS, asked)], axis="columns")


def labels_of_rows(frame: pd.DataFrame) -> list[str]:
    """Heads of the labels of rows, their loads and their velocities, before those of answers."""
    return [*map(str, frame)][: frame.columns.get_loc("verdict")]


LONG = ("critical velocity [m/s]", "critical load [N]", "velocity outcome", "load outcome", "note")
"""Columns for which a terminal or a page is too narrow."""
_HEADS = (
    "verdict", "decisive temperature [°C]", "temperature error [K]", "distance [K]",
    "velocity factor", "critical velocity [m/s]", "velocity outcome",
    "load factor", "critical load [N]", "load outcome",
)  # fmt: skip
_FIELDS = [*as_dict(pd.DataFrame(columns=[*_HEADS]))]
_HEADS_OF_SEVERAL = (
    "verdict", "severe", "undecided", "variants", "decisive temperature [°C]",
    "temperature error [K]", "distance [K]", "distance low [K]", "distance high [K]",
    "velocity factor", "load factor",
)  # fmt: skip


def in_counts(frame: pd.DataFrame) -> str:
    """Numbers of operating points by verdict in words, and which of them is the nearest.

    Examples
    --------
    >>> heads = "load [N]", "velocity [m/s]", "verdict", "distance [K]"
    >>> in_counts(frame_of(heads, [(300.0, 1.0, "mild", 30.0), (600.0, 2.0, "severe", -4.0)]))
    '1 mild, 1 severe; the least margin is -4 K, at 600 N and 2 m/s'
    """
    counts = Counter(frame["verdict"])
    said = ", ".join(f"{number} {verdict}" for verdict, number in sorted(counts.items()))
    if len(frame) == 1 or frame["distance [K]"].isna().all():
        return said
    least = frame.loc[frame["distance [K]"].astype(float).idxmin()]
    place = f"{least['load [N]']:g} N and {least['velocity [m/s]']:g} m/s"
    return f"{said}; the least margin is {least['distance [K]']:.3g} K, at {place}"


def notes_of(frame: pd.DataFrame) -> list[str]:
    """Notes of a frame of operating points, each with its place in words."""
    noted = frame[["load [N]", "velocity [m/s]", "note"]].dropna()
    rows = noted.itertuples(index=False, name=None)
    return [f"{load:g} N at {velocity:g} m/s: {note}" for load, velocity, note in rows if note]


def _note(margins: Sequence[Margin]) -> str | None:
    """Note on critical values that are interpolated across points that are not done."""
    names = ("velocity", "load")
    bridged = {name: max(getattr(one, f"{name}_bridged") for one in margins) for name in names}
    if not any(bridged.values()):
        return None
    listed = ", ".join(f"{count} along the {name}" for name, count in bridged.items() if count)
    return f"points not done next to the transition: {listed}"


def _of_one(margin: Margin) -> tuple[Any, ...]:
    return *(getattr(margin, name) for name in _FIELDS), _note([margin])


def _of_several(margins: Sequence[Margin]) -> tuple[Any, ...]:
    """Medians over surfaces, and the band of the distance; factors only if all surfaces cross."""
    counts = Counter(margin.verdict for margin in margins)
    severe, undecided = counts["severe"], counts[NOT_DECIDED]
    verdict = NOT_DECIDED if undecided else "severe on some"
    if len(counts) == 1:
        (verdict,) = counts
    errors = [margin.temperature_error for margin in margins]
    error = None if None in errors else max(filter(None, errors), default=0.0)
    low, middle, high = np.quantile([margin.distance for margin in margins], BAND).tolist()
    temperature = float(np.median([margin.decisive_temperature for margin in margins]))
    factors = (
        float(np.median([getattr(margin, name) for margin in margins]))
        for name in ("velocity_factor", "load_factor")
    )
    values = severe, undecided, len(margins), temperature, error, middle, low, high, *factors
    return verdict, *values, _note(margins)


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
        if isinstance(source, Mapping) or not isinstance(source, str | os.PathLike):
            name, sheet = "points", _sheet_of(source)
        else:
            name, sheet = str(source), read_sheet(Path(source), _KINDS, _KINDS)
            if not sheet.heads:
                raise InputError(f'{name} is empty; begin it with a line "load [N],velocity [m/s]"')
        heads = sheet.labelled
        twice = dict.fromkeys(head for head in sheet.heads if sheet.heads.count(head) > 1)
        faults = [f'column "{head}" stands there twice; name each once' for head in twice]
        faults += [*sheet.faults, *sheet.of_rows]
        values = {name: _quantity(sheet, name, faults) for name in sheet.places}
        if faults:
            listed = [f"  {fault}" for fault in faults[:_MOST_FAULTS]]
            if more := len(faults) - len(listed):
                listed.append(f"  and {more} more")
            count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
            raise InputError("\n".join([f"{name} has {count}:", *listed]))
        if not sheet.rows:
            raise InputError(f"{name} has no rows; give a load and a velocity in each")
        others = {
            head: [row.cells[place] for row in sheet.rows]
            for place, head in enumerate(heads)
            if place not in sheet.places.values()
        }
        places = zip(values["load"], values["velocity"], strict=True)
        return cls(tuple(Place(*place) for place in places), others)


def _sheet_of(columns: Any) -> Sheet:
    """Columns of a mapping or a data frame as those of a file."""
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
    return sheet_of(listed, _KINDS)


def _quantity(sheet: Sheet, name: str, faults: list[str]) -> list[float]:
    """Values of a quantity in SI; faults are added to the list."""
    kind, head, unit = _KINDS[name], sheet.labelled[sheet.places[name]], sheet.heading(name).unit
    usual, wrong, values = kind.example.split()[1], Faults(), list[float]()
    if unit:
        kind.read(f"1 {unit}", f'column "{head}"', wrong)
    for row in sheet.rows if not wrong else ():
        cell: Any = row.cells[sheet.places[name]]
        in_si = not unit and not isinstance(cell, str)
        place, text = f'row {row.number}, column "{head}"', f"{cell} {usual if in_si else unit}"
        if sheet.decimal == "," and may_be_thousands(str(cell)):
            wrong.note(place, f'"{cell}" beside decimal commas may be thousands; write it plainly')
        elif str(cell).strip():
            values.append(kind.read(text.strip(), place, wrong))
        else:
            wrong.note(place, f"empty; give {kind}")
    heading = "" if unit else f', or the heading "{name} [{usual}]"'
    faults += [f"{place}: {problem}{heading}" for place, problem, *_ in wrong]
    return values
