"""Distances of many operating points from severe wear, as a data frame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.band import BAND
from pipeline.analysis.dataset import dataset_of
from pipeline.analysis.margin import NOT_DECIDED, Margin, rows_of
from pipeline.analysis.operating_points import OperatingPoints
from pipeline.analysis.scenes import frame_by_scene
from pipeline.analysis.tables import as_dict, frame_of
from pipeline.store.place import PathLike
from tribo import InputError


def margin_table(
    ds: xr.Dataset | PathLike,
    points: OperatingPoints | PathLike | Mapping[str, Sequence[Any]],
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
    read = points if isinstance(points, OperatingPoints) else OperatingPoints.read(points)

    def of_scene(scene: xr.Dataset) -> pd.DataFrame:
        rows = rows_of(scene, **conditions)
        if len(rows) == 1:
            return frame_of_points(read, _HEADS, lambda *place: _of_one(rows[0].at(*place)))
        return frame_of_points(
            read, _HEADS_OF_SEVERAL, lambda *place: _of_several([row.at(*place) for row in rows])
        )

    return frame_by_scene(dataset_of(ds), of_scene)


def frame_of_points(
    points: OperatingPoints,
    heads: Sequence[str],
    answer: Callable[[float, float], Sequence[Any]],
) -> pd.DataFrame:
    """Frame with the further columns of each operating point, its place, an answer, and a note.

    The answer ends with the note; where an `InputError` stands for it, the first of the columns, a
    verdict, is not known.
    """
    rows = []
    for place in points.places:
        try:
            rows.append((*place, *answer(*place)))
        except InputError as error:
            rows.append((*place, "not known", *[None] * (len(heads) - 1), str(error)))
    results = frame_of(["load [N]", "velocity [m/s]", *heads, "note"], rows)
    others = {
        f"{head} (given)" if head in {*results, *as_dict(results)} else head: values
        for head, values in points.others.items()
    }
    return pd.concat([pd.DataFrame(others, index=results.index), results], axis="columns")


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
