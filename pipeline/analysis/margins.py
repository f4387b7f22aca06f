"""Distances of operating points from severe wear, along whatever stands in front."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import Any

import xarray as xr

from pipeline.analysis.conditions import Bulk, conditions_of
from pipeline.analysis.dataset import (
    asked,
    attributes_of,
    dataset_of,
    has_plane,
    require_plane,
    with_wear_rates,
)
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.margin import Margin, Row
from pipeline.analysis.margin_error import grids_of
from pipeline.analysis.scenes import scenes
from pipeline.analysis.transition import range_of
from pipeline.scene.units import in_si
from pipeline.store.place import PathLike
from pipeline.store.schema import COORDINATES, PLANE
from pipeline.sweep.selection import velocity_error
from pipeline.sweep.variants import PLACE, VARIANT
from tribo import InputError

_USUAL = COORDINATES.keys() - {VARIANT, "realization"}


def margins(
    ds: xr.Dataset | PathLike,
    load: float | str | None = None,
    velocity: float | str | None = None,
    friction: float | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
    criterion: str | None = None,
    own_laws: bool = False,
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
    friction, bulk_temperature, critical_temperature, share, criterion, own_laws
        See `pipeline.boundary`.

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
    others = friction, bulk_temperature, critical_temperature, share, criterion, own_laws
    if load is None or velocity is None:
        return tuple(row.here() for row in rows_of(ds, *others))
    place = in_si("load", load, "500 N"), in_si("velocity", velocity, "2 m/s")
    ds = dataset_of(ds)
    require_plane(ds)
    return tuple(row.at(*place) for row in rows_of(ds, *others))


def margins_at(
    ds: xr.Dataset, places: Iterable[tuple[float, float]] | None, **conditions: Any
) -> Iterator[Margin]:
    """Margins at loads [N] and velocities [m/s], or at places of the rows' own if none are given.

    None where the sweep does not tell.
    """
    listed = None if places is None else list(places)
    for row in rows_of(ds, **conditions):
        for place in [row.place] if listed is None else listed:
            with suppress(InputError):
                yield row.here() if place is None else row.at(*place)


def rows_of(ds: xr.Dataset | PathLike, *others: Any, **given: Any) -> tuple[Row, ...]:
    """The planes of a sweep along whatever stands in front, each judged by its conditions."""
    ds, rows = with_wear_rates(ds), list[Row]()
    if not has_plane(ds):  # at once, for a read of each row by itself takes ten times as long
        ds = ds.drop_dims(["x", "y"], errors="ignore").compute()
    for scene in scenes(ds):
        is_placed = any(name not in scene.dims for name in PLANE)
        coords = {str(name): label for name, label in scene.coords.items() if name not in _USUAL}
        shown = {name: label.item() for name, label in coords.items() if not label.ndim}
        scene = scene.expand_dims([name for name in PLANE if name not in scene.dims])
        conditions, about = conditions_of(scene, *others, **given), attributes_of(scene)
        rise = decisive_rise(scene, conditions)
        labels = {path: scene[path].item() for path in about.get("entries", {})}
        place = tuple(scene[name].item() for name in PLANE) if is_placed else None
        front = {str(name): rise[name].values.tolist() for name in rise.dims[:-2]}
        is_missing = (rise.isnull() & asked(scene)).values.reshape(-1, *rise.shape[-2:])
        drawn = itertools.product(*front.values())
        rows += [
            Row(
                labels=labels,
                drawn=dict(zip(front, values, strict=True)),
                grid=grid,
                is_missing=missing,
                conditions=conditions,
                promised=velocity_error(about),
                ends={name: _ends(scene, name, is_placed) for name in PLANE},
                shown=shown | dict(zip(front, values, strict=True)),
                place=place,
            )
            for grid, missing, values in zip(grids_of(scene, rise), is_missing, drawn, strict=True)
        ]
    return tuple(_about_places(rows))


def _ends(scene: xr.Dataset, name: str, is_placed: bool) -> tuple[float, float]:
    """Lowest and highest load [N] or velocity [m/s] that a row is asked for at."""
    if not is_placed:
        return range_of(scene, name)
    here = float(scene[name].item())
    return here, here


def _about_places(rows: Iterable[Row]) -> Iterator[Row]:
    """Rows, those that lie about one place as one; the first of these is the place itself."""
    about = dict[Any, list[Row]]()
    for row in rows:
        labels = [label for label in row.shown.items() if label[0] != VARIANT]
        about.setdefault((*labels,) if PLACE in row.shown else id(row), []).append(row)
    for first, *others in about.values():
        yield first.with_others(others) if others else first
