"""Distances of many operating points from severe wear, as a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.band import BAND
from pipeline.analysis.dataset import dataset_of, entry_dims, plane_of
from pipeline.analysis.margin import NOT_DECIDED, Margin, judge_of
from pipeline.analysis.operating_points import OperatingPoints
from pipeline.analysis.scenes import columns_of, joined, scenes
from pipeline.analysis.tables import Column, Table
from pipeline.store.place import PathLike
from tribo import InputError


def margin_table(
    ds: xr.Dataset | PathLike,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]],
    **conditions: Any,
) -> Table:
    r"""Table of the distances of operating points from severe wear, without a new simulation.

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
    Table
        A row for each operating point, mild or severe beyond the error of its temperature; over
        several surfaces the medians, and the number of surfaces with severe wear. A point that the
        sweep says nothing about has a note instead.

    Raises
    ------
    InputError
        If the table has faults, all of which are named, or a condition lies outside its range.

    Examples
    --------
    >>> import pipeline
    >>> points = {"load": ["500 N", "600 N"], "velocity": ["1.6 m/s", "2 m/s"]}
    >>> table = pipeline.margin_table("results/first_try.zarr", points)
    >>> print(*table.without(table.as_dict().keys() - {"load", "verdict"}).lines(), sep="\n")
    load [N]   verdict
    500        mild
    600        severe
    """
    read = points if isinstance(points, OperatingPoints) else OperatingPoints.read(points)
    ds = dataset_of(ds)
    names = entry_dims(ds)
    parts = (
        ([scene[name].item() for name in names], _table_of(scene, read, conditions))
        for scene in scenes(ds)
    )
    return joined(columns_of(ds["status"]), parts)


def _table_of(ds: xr.Dataset, points: OperatingPoints, conditions: Mapping[str, Any]) -> Table:
    """Table of one scene."""
    judge = judge_of(plane_of(ds), **conditions)
    if ds.sizes.get("realization", 1) == 1:
        return table_of_points(points, _COLUMNS, lambda *place: _of_one(*judge(*place)))
    return table_of_points(points, _COLUMNS_OF_SEVERAL, lambda *place: _of_several(judge(*place)))


def table_of_points(
    points: OperatingPoints,
    columns: Sequence[Column],
    answer: Callable[[float, float], Sequence[Any]],
) -> Table:
    """Table with the further columns of each operating point, its place, an answer, and a note.

    The answer ends with the note; where an `InputError` stands for it, the first of the columns, a
    verdict, is not known.
    """
    rows = []
    for number, place in enumerate(points.places):
        try:
            values = answer(*place)
        except InputError as error:
            values = ("not known", *[None] * (len(columns) - 1), str(error))
        passed = (cells[number] for cells in points.others.values())
        rows.append((*passed, *place, *values))
    results = (*_PLACE, *columns, Column("note", "note"))
    taken = {word for column in results for word in (column.name, column.head)}
    others = (f"{head} (given)" if head in taken else head for head in points.others)
    return Table((*(Column(head, head) for head in others), *results), tuple(rows))


def notes_of(table: Table) -> list[str]:
    """Notes of a table of operating points, each with its place in words."""
    columns = table.as_dict()
    noted = zip(columns["load"], columns["velocity"], columns["note"], strict=True)
    return [f"{load:g} N at {velocity:g} m/s: {note}" for load, velocity, note in noted if note]


_PLACE = Column("load", "load", "N", 6), Column("velocity", "velocity", "m/s", 6)
_COLUMNS = (
    Column("verdict", "verdict"),
    Column("decisive_temperature", "deciding temperature", "°C"),
    Column("temperature_error", "error", "K", 2),
    Column("distance", "below the critical", "K", 3),
    Column("velocity_factor", "velocity factor", digits=3),
    Column("critical_velocity", "critical velocity", "m/s"),
    Column("velocity_outcome", "along the velocity"),
    Column("load_factor", "load factor", digits=3),
    Column("critical_load", "critical load", "N"),
    Column("load_outcome", "along the load"),
)
_COLUMNS_OF_SEVERAL = (
    Column("verdict", "verdict"),
    Column("severe", "severe"),
    Column("undecided", NOT_DECIDED),
    Column("variants", "of"),
    Column("decisive_temperature", "deciding temperature", "°C"),
    Column("temperature_error", "largest error", "K", 2),
    Column("distance", "below the critical", "K", 3),
    Column("distance_low", f"below it, {100 * BAND[0]:g} %", "K", 3),
    Column("distance_high", f"below it, {100 * BAND[-1]:g} %", "K", 3),
    Column("velocity_factor", "velocity factor", digits=3),
    Column("load_factor", "load factor", digits=3),
)


def _note(margins: Sequence[Margin]) -> str | None:
    """Note on critical values that are interpolated across points that are not done."""
    names = ("velocity", "load")
    bridged = {name: max(getattr(one, f"{name}_bridged") for one in margins) for name in names}
    if not any(bridged.values()):
        return None
    listed = ", ".join(f"{count} along the {name}" for name, count in bridged.items() if count)
    return f"points not done next to the transition: {listed}"


def _of_one(margin: Margin) -> tuple[Any, ...]:
    return *(getattr(margin, column.name) for column in _COLUMNS), _note([margin])


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
