"""The points of a sweep that a figure is drawn of."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr

from pipeline.analysis.dataset import drawn_row
from pipeline.analysis.decisive import decisive_rise
from pipeline.scene.quantities import in_si
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Point
from tribo import InputError


class PendingError(InputError):
    """A point that a figure shows is not done."""


def chosen_points(
    ds: xr.Dataset,
    load: float | str | Iterable[float | str] | None,
    velocity: float | str | Iterable[float | str] | None,
    conditions: Conditions,
) -> list[tuple[int, int]]:
    """Find the indices of the points asked for, or of the one nearest to the transition."""
    r = decisive_rise(ds, conditions).values
    is_finite = np.isfinite(r)
    if not is_finite.any():
        raise PendingError(
            "no point of the sweep is done yet; run the scene on, "
            "with --retry-failed if points failed"
        )
    loads = [_index(ds, "load", "N", value) for value in _several("load", load, "600 N")]
    velocities = [
        _index(ds, "velocity", "m/s", value) for value in _several("velocity", velocity, "1.5 m/s")
    ]
    points = []
    for i in loads or [int(np.flatnonzero(is_finite.any(axis=1))[-1])]:
        if not is_finite[i].any():
            raise PendingError(
                f"no point at {ds['load'].values[i]:g} N is done; "
                "give another load, or run the scene on"
            )
        judged = conditions.critical_temperature is not None
        limit = rise_limit(conditions) if judged else math.inf
        distance = np.abs(r[i] - min(limit, np.nanmax(r[i])))
        points += [(i, j) for j in velocities or [int(np.nanargmin(distance))]]
    for point in points:
        if not is_finite[point]:
            reason = str(ds["message"].transpose("load", "velocity").values[point])
            raise PendingError(
                f"the point {point_name(ds, point)} is not done{reason and ': '}{reason}; "
                "give another load or velocity, or run the scene on"
            )
    return points


def index_of_load(ds: xr.Dataset, load: float | str | None) -> int:
    """Find the index of a load; of the highest if none is given."""
    if load is None:
        return int(ds.sizes["load"]) - 1
    return _index(ds, "load", "N", in_si("load", load, "600 N"))


def _several(
    name: str, values: float | str | Iterable[float | str] | None, like: str
) -> list[float]:
    """Read one quantity or several."""
    if values is None:
        return []
    several = np.atleast_1d(np.asarray(values, dtype=object)).tolist()
    return [in_si(name, value, like) for value in several]


def _index(ds: xr.Dataset, axis: str, unit: str, value: float) -> int:
    available = ds[axis].values
    nearest = int(np.abs(available - value).argmin())
    if not math.isclose(available[nearest], value, rel_tol=1e-9):
        raise InputError(
            f"{axis} is {value:g} {unit}, which the sweep does not hold; the nearest is "
            f"{available[nearest]:g} {unit}"
        )
    return nearest


def point_name(ds: xr.Dataset, point: tuple[int, int]) -> str:
    """Name a point by its load, its velocity and its surface, from its indices."""
    return str(Point(ds["load"].values[point[0]], ds["velocity"].values[point[1]], drawn_row(ds)))
