"""Distances of operating points from severe wear, along whatever stands in front, and as frames."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.boundary import BAND
from pipeline.analysis.dataset import (
    dataset_of,
    has_plane,
    is_emulated,
    require_plane,
    stored_sweep,
    taken_entries,
)
from pipeline.analysis.decisive import (
    at_one_friction,
    conditions_of,
    decisive_rise,
    require_all_sound,
)
from pipeline.analysis.margin import NOT_DECIDED, JudgedRow, Margin
from pipeline.analysis.margin_error import RisePlane, grids_of
from pipeline.analysis.scenes import frame_by_scene, heads_of, scenes
from pipeline.analysis.tables import as_dict, frame_of
from pipeline.analysis.transition import range_of
from pipeline.scene.along import OperatingPoints, Place
from pipeline.scene.doubts import doubts_of_row
from pipeline.scene.units import in_si
from pipeline.store.place import PathLike
from pipeline.store.schema import COORDINATES, PLANE
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.variants import PLACE, VARIANT
from tribo import InputError

_USUAL = COORDINATES.keys() - {VARIANT, "realization"}


def margins(
    ds: xr.Dataset | PathLike,
    load: float | str | None = None,
    velocity: float | str | None = None,
    **conditions: Any,
) -> tuple[Margin, ...]:
    """Distance of an operating point from severe wear, without a new simulation.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or the path of a store. Points that are pending or failed
        are skipped.
    load : float or str
        Normal load on the whole pin [N], or text such as ``"500 N"``, within those of the sweep.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit, above 0 and within those of the sweep. Both
        are left out where rows have places of their own (``[sweep] along``).
    **conditions
        Friction, temperatures, share and criterion; see `pipeline.boundary`.

    Returns
    -------
    tuple of Margin
        One for each random surface of the sweep, and each value of entries with several; or for
        each row, at its own place.

    Raises
    ------
    InputError
        If the operating point lies outside the sweep, too little of the sweep is done, or a
        condition lies outside its range.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> (margin,) = pipeline.margins(ds, "500 N", "1.6 m/s", friction=0.12)
    >>> margin.verdict, f"{margin.distance:.0f} K"
    ('severe', '-13 K')
    """
    if load is None or velocity is None:
        return tuple(row.here() for row in rows_of(ds, **conditions))
    place = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
    ds = dataset_of(ds)
    require_plane(ds)
    return tuple(row.at(*place) for row in rows_of(ds, **conditions))


def margins_at(
    ds: xr.Dataset, points: OperatingPoints | None, **conditions: Any
) -> Iterator[tuple[Conditions, Margin]]:
    """Margins at points, or the rows' own if none are given, where the sweep tells."""
    rows = rows_of(ds, **conditions)
    places: list[tuple[Place | None, Mapping[str, float]]] = [(None, {})]
    for place, own in places if points is None else points.rows:
        with suppress(InputError):
            for row in rows_with(ds, rows, own, conditions):
                with suppress(InputError):
                    if at := place or row.place:
                        yield row.conditions, row.at(*at)


def rows_of(
    ds: xr.Dataset | PathLike, own: Mapping[str, float] | None = None, **given: Any
) -> tuple[JudgedRow, ...]:
    """The planes of a sweep along whatever stands in front, each judged by its conditions.

    Own conditions are those of a row of a table; see `Conditions.of_row`.
    """
    ds = dataset_of(ds)
    if is_emulated(ds):
        require_plane(ds)
    if not has_plane(ds):  # at once, for a read of each row by itself takes ten times as long
        require_all_sound(ds)
        ds = ds.drop_dims(["x", "y"], errors="ignore").compute()
    rows = (
        row
        for one in scenes(ds)
        for row in rows_under(one, conditions_of(one, **given).of_row(own or {}))
    )
    return tuple(_about_places(rows))


def rows_under(scene: xr.Dataset, conditions: Conditions) -> Iterator[JudgedRow]:
    """The planes of one scene, each judged by some conditions."""
    placed = [name for name in PLANE if name not in scene.dims]
    place = tuple(scene[name].item() for name in PLANE) if placed else None
    coords = {str(name): label for name, label in scene.coords.items() if name not in _USUAL}
    shown = {name: label.item() for name, label in coords.items() if not label.ndim}
    scene, sweep = scene.expand_dims(placed), stored_sweep(scene)
    rise = decisive_rise(scene, conditions)
    ends = {
        name: (at, at) if place else range_of(scene, name)
        for name, at in zip(PLANE, place or (np.nan, np.nan), strict=True)
    }
    entries = {path: scene[path].item() for path in taken_entries(scene)}
    front = {str(name): rise[name].values.tolist() for name in rise.dims[:-2]}
    grids = grids_of(scene, at_one_friction(rise, conditions))
    for grid, row in zip(grids, itertools.product(*front.values()), strict=True):
        labels = dict(zip(front, row, strict=True))
        yield JudgedRow(
            grid=grid,
            conditions=conditions,
            promised=velocity_error(sweep),
            ends=ends,
            realization=labels.get("realization"),
            entries=entries,
            shown=shown | labels,
            place=place,
            source=scene.sel(labels),
        )


def rows_with(
    ds: xr.Dataset, rows: Sequence[JudgedRow], own: Mapping[str, float], given: Mapping[str, Any]
) -> Sequence[JudgedRow]:
    """Planes judged by what a row of a table has of its own, too; see `Conditions.of_row`."""
    judged = [row.conditions.of_row(own) for row in rows]
    if all(a.bulk_ratio == b.conditions.bulk_ratio for a, b in zip(judged, rows, strict=True)):
        # Rises at friction 1 are the same.
        return [replace(row, conditions=one) for row, one in zip(rows, judged, strict=True)]
    return rows_of(ds, own, **given)


def _about_places(rows: Iterable[JudgedRow]) -> Iterator[JudgedRow]:
    """Rows, those that lie about one place as one; the first of these is the place itself."""
    about = dict[Any, list[JudgedRow]]()
    for row in rows:
        labels = [label for label in row.shown.items() if label[0] != VARIANT]
        about.setdefault((*labels,) if PLACE in row.shown else id(row), []).append(row)
    for first, *others in about.values():
        if others:
            grid = RisePlane.joined([row.grid for row in (first, *others)])
            axes = {"load": grid.loads, "velocity": grid.velocities}
            ends = {name: (float(x[0]), float(x[-1])) for name, x in axes.items()}
            first = replace(first, grid=grid, ends=ends)
        yield first


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
        A .csv or .xlsx file with columns ``load [N]`` and ``velocity [m/s]``, or in other units; or
        columns by heading, such as a data frame. Columns ``friction``, ``bulk_temperature`` and
        ``critical_temperature`` are the conditions of their row. Further columns are passed on,
        with "(given)" after the heading where a result has the same.
    **conditions
        Friction, temperatures, share and criterion; see `pipeline.boundary`.

    Returns
    -------
    DataFrame
        For each operating point its place, the ``verdict`` beyond the error of its temperature,
        ``decisive temperature [°C]``, ``temperature error [K]``, the ``distance [K]`` below the
        critical temperature and, along velocity and load, the factor to the critical value, that
        value and the outcome. Over several surfaces it has medians, the numbers of ``variants`` and
        of those that are ``severe`` and ``undecided``, and the ends of the band of the distance. A
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
        is_one = len(rows) == 1

        def answer(place: Place, own: Mapping[str, float]) -> Sequence[Any]:
            judged = rows_with(scene, rows, own, conditions)
            return (_of_one if is_one else _of_several)(judged, *place)

        return frame_of_points(read, _HEADS if is_one else _HEADS_OF_SEVERAL, answer)

    return frame_by_scene(ds, of_scene)


def frame_of_points(
    points: OperatingPoints,
    heads: Sequence[str],
    answer: Callable[[Place, Mapping[str, float]], Sequence[Any]],
) -> pd.DataFrame:
    """Frame of operating points with an answer that ends with a note; an error is the note."""
    answers = [partial(answer, place, own) for place, own in points.rows]
    results = _results(heads, points.places, answers)
    doubts = ["; ".join(doubts_of_row(own)) for _, own in points.rows]
    told = [note if isinstance(note, str) else "" for note in results["note"]]
    both = zip(told, doubts, strict=True)
    results["note"] = ["; ".join(filter(None, pair)) or None for pair in both]
    others = {
        f"{head} (given)" if head in {*results, *as_dict(results)} else head: values
        for head, values in points.others.items()
    }
    return pd.concat([pd.DataFrame(others, index=results.index), results], axis="columns")


def _results(
    heads: Sequence[str],
    places: Iterable[tuple[float, float]],
    answers: Iterable[Callable[[], Sequence[Any]]],
) -> pd.DataFrame:
    """Frame of answers at places; where an `InputError` stands for one it is the note."""
    rows = []
    for place, answer in zip(places, answers, strict=True):
        try:
            rows.append((*place, *answer()))
        except InputError as error:
            rows.append((*place, "not known", *[None] * (len(heads) - 1), str(error)))
    return frame_of(["load [N]", "velocity [m/s]", *heads, "note"], rows)


def frame_of_rows(ds: xr.Dataset, rows: Iterable[JudgedRow]) -> pd.DataFrame:
    """Frame of the rows of the table of variants that have places of their own, with margins."""
    placed = {row: row.place for row in rows if row.place}
    held = [name for row in [*placed][:1] for name in row.shown]
    heads = heads_of(ds, [name for name in held if name not in (PLACE, VARIANT)] or held)
    labels = frame_of([*heads.values()], [[row.shown[name] for name in heads] for row in placed])
    answers = [partial(_of_one, [row], *place) for row, place in placed.items()]
    return pd.concat([labels, _results(_HEADS, placed.values(), answers)], axis="columns")


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
    """Numbers of operating points by verdict in words, and which of them is the nearest."""
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
    bridged = {
        "velocity": max(margin.velocity_bridged for margin in margins),
        "load": max(margin.load_bridged for margin in margins),
    }
    listed = [f"{count} along the {name}" for name, count in bridged.items() if count]
    return f"points not done next to the transition: {', '.join(listed)}" if listed else None


def _of_one(rows: Sequence[JudgedRow], load: float, velocity: float) -> tuple[Any, ...]:
    (row,) = rows
    margin = row.at(load, velocity)
    return *(getattr(margin, name) for name in _FIELDS), _note([margin])


def _of_several(rows: Sequence[JudgedRow], load: float, velocity: float) -> tuple[Any, ...]:
    """Medians over surfaces, and the band of the distance; factors only if all surfaces cross."""
    margins = [row.at(load, velocity) for row in rows]
    counts = Counter(margin.verdict for margin in margins)
    severe, undecided = counts["severe"], counts[NOT_DECIDED]
    verdict = NOT_DECIDED if undecided else "severe on some"
    if len(counts) == 1:
        (verdict,) = counts
    errors = [margin.temperature_error for margin in margins]
    error = None if None in errors else max(filter(None, errors), default=0.0)
    low, middle, high = np.quantile([margin.distance for margin in margins], BAND).tolist()
    temperature, *factors = (
        float(np.median([getattr(margin, name) for margin in margins]))
        for name in ("decisive_temperature", "velocity_factor", "load_factor")
    )
    values = severe, undecided, len(margins), temperature, error, middle, low, high, *factors
    return verdict, *values, _note(margins)
