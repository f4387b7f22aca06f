"""Boundary as tables: by load and by velocity, as numbers for files and shortened for reading."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from operator import itemgetter
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import variant_of
from pipeline.analysis.scenes import columns_of, joined, parts_of
from pipeline.analysis.tables import Column, Table
from pipeline.analysis.transition import CROSSES, in_words, outcomes

BOUNDARIES = (("critical_velocity", "load"), ("critical_load", "velocity"))
"""Variables of a boundary, each with the axis that it is found along."""

_AXES = {"load": Column("load", "load", "N"), "velocity": Column("velocity", "velocity", "m/s")}
_JUDGED = (
    Column("bulk_temperature", "bulk", "°C"),
    Column("disk_temperature", "disk bulk", "°C"),
    Column("critical_temperature", "critical", "°C"),
    Column("failing_share", "failing share"),
    Column("criterion", "criterion"),
)


def tables_of(boundaries: xr.Dataset) -> list[Table]:
    """Tables of `pipeline.boundary`: critical velocities by load, and critical loads by velocity.

    A row is for one load or velocity at one friction, with the conditions that it was judged by.
    """
    return _of_both_axes(boundaries, _crossings, _band)


def _crossings(boundaries: xr.Dataset, name: str, axis: str) -> Table:
    """Crossings of one surface."""
    other = name.removeprefix("critical_")
    unit = _AXES[other].unit
    columns = (
        Column(name, f"critical {other}", unit),
        Column(f"outcome_at_{axis}", "outcome"),
        Column(f"computed_from_at_{axis}", "computed from", unit),
        Column(f"computed_to_at_{axis}", "computed to", unit),
        Column(f"bridged_at_{axis}", "across points not done"),
    )

    def values(place: xr.Dataset) -> tuple[Any, ...]:
        crossing, outcome, *ends = (place[column.name].item() for column in columns)
        return crossing, outcomes(other)[outcome], *ends

    return _by_place(boundaries, axis, columns, values)


def _band(boundaries: xr.Dataset, name: str, axis: str) -> Table:
    """Median, ends of the band, mean and spread of several surfaces, and how many of them cross."""
    other, kind = name.removeprefix("critical_"), "surfaces"
    unit = _AXES[other].unit
    low, _, high = (f"{100 * share:g} %" for share in boundaries["quantile"].values)
    heads = ("median", low, high, "mean", "spread")
    others = {
        code: words
        for code, words in outcomes(other).items()
        if code != CROSSES and (boundaries[f"outcome_at_{axis}"] == code).any()
    }
    columns = (
        *(Column(f"{name}_{head}", head, unit) for head in heads),
        Column(kind, kind),
        Column("crosses", "cross"),
        *(Column(words, words) for words in others.values()),
    )
    if has_bridged := bool((boundaries[f"bridged_at_{axis}"] > 0).any()):
        columns += (Column("bridged", "of them across points not done"),)

    def values(place: xr.Dataset) -> tuple[Any, ...]:
        low, middle, high = place[f"{name}_quantile"].values.tolist()
        moments = (place[f"{name}_{moment}"].item() for moment in ("mean", "spread"))
        all_outcomes = place[f"outcome_at_{axis}"].values.tolist()
        counts = [all_outcomes.count(code) for code in (CROSSES, *others)]
        if has_bridged:
            counts.append(int((place[f"bridged_at_{axis}"] > 0).sum()))
        return middle, low, high, *moments, len(all_outcomes), *counts

    return _by_place(boundaries, axis, columns, values)


def _by_place(
    boundaries: xr.Dataset,
    axis: str,
    columns: tuple[Column, ...],
    values: Callable[[xr.Dataset], tuple[Any, ...]],
) -> Table:
    """Table with a row for each friction and each load or velocity."""
    attrs, film = boundaries.attrs, f"film_parameter_at_{axis}"
    judged = [attrs.get(column.name) for column in _JUDGED]
    rows = []
    for friction, part in by_friction(boundaries):
        for place in range(boundaries.sizes[axis]):
            here = part.isel({axis: place})
            films = here[film].values if film in here else math.nan
            parameter = None if np.isnan(films).all() else float(np.nanmedian(films))
            row = (friction, here[axis].item(), *values(here), parameter)
            rows.append((*row, *judged))
    heads = (Column("friction", "friction"), _AXES[axis], *columns)
    film_column = Column(film, "film parameter Λ", digits=3)
    return Table((*heads, film_column, *_JUDGED), tuple(rows))


def readable(boundaries: xr.Dataset) -> list[Table]:
    """The tables of `pipeline.boundary` without its conditions, outcomes in words."""
    return _of_both_axes(boundaries, _side_by_side, _band_in_short)


def _of_both_axes(
    boundaries: xr.Dataset, of_one: Callable[..., Table], of_several: Callable[..., Table]
) -> list[Table]:
    """Tables by load and by velocity of all scenes, made for one surface or for several."""
    table_of = of_one if variant_of(boundaries) is None else of_several
    columns, parts = columns_of(boundaries["critical_velocity"]), [*parts_of(boundaries)]
    return [
        joined(columns, ((values, table_of(part, *ends)) for values, part in parts))
        for ends in BOUNDARIES
    ]


def frictions_of(boundaries: xr.Dataset) -> list[float]:
    """Frictions that a boundary was found at, in the order in which they were given."""
    if "friction" in boundaries.attrs:
        return [boundaries.attrs["friction"]]
    return list(dict.fromkeys(boundaries["friction"].values.ravel().tolist()))


def by_friction(boundaries: xr.Dataset) -> Iterator[tuple[float, xr.Dataset]]:
    """The boundary at each friction."""
    if "friction" not in boundaries.sizes:
        yield boundaries.attrs["friction"], boundaries
        return
    for place, value in enumerate(boundaries["friction"].values.tolist()):
        yield value, boundaries.isel(friction=place)


def _side_by_side(boundaries: xr.Dataset, name: str, axis: str) -> Table:
    """Crossings of one surface, or outcomes in words, with a column for each friction."""
    other = name.removeprefix("critical_")
    crossing = Column(name, f"critical {other}", _AXES[other].unit)
    frictions = frictions_of(boundaries)
    heads = {friction: f"at friction {friction:g}" for friction in frictions}
    first = f" {heads[frictions[0]]}" if len(heads) > 1 else ""
    heads[frictions[0]] = f"{crossing.head}{first}"

    def cell(row: dict[str, Any]) -> str:
        if not math.isfinite(row[name]):
            ends = row[f"computed_from_at_{axis}"], row[f"computed_to_at_{axis}"]
            return in_words(row[f"outcome_at_{axis}"], ends, other)
        film, bridged = row[f"film_parameter_at_{axis}"], row[f"bridged_at_{axis}"]
        text = crossing.text(row[name]) + ("" if film is None else f"  film Λ {film:.2f}")
        if bridged:
            text += f"  across {bridged} point{'s' if bridged > 1 else ''} not done"
        return text

    table = _crossings(boundaries, name, axis)
    return table.crossed(_AXES[axis].head, itemgetter(axis), "friction", heads, cell)


def _band_in_short(boundaries: xr.Dataset, name: str, axis: str) -> Table:
    """The band of several surfaces, with the friction only where there are several."""
    table = _band(boundaries, name, axis)
    left_out = {column.name for column in _JUDGED}
    if len(set(table.as_dict()["friction"])) == 1:
        left_out.add("friction")
    title = f"critical {name.removeprefix('critical_')}, median"
    short = table.without(left_out).without_empty()
    columns = tuple(
        column._replace(title=title) if column.name == f"{name}_median" else column
        for column in short.columns
    )
    return Table(columns, short.rows)
