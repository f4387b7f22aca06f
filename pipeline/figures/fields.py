"""Which point of a sweep a figure shows; its pressure, temperature and wear over the contact."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pipeline.analysis.dataset import (
    corrected_field,
    drawn_row,
    messages,
    one_row,
    temperature_conditions,
)
from pipeline.analysis.decisive import decisive_rise
from pipeline.figures import style
from pipeline.quantities import UNITS, shown_in
from pipeline.scene.units import in_si
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Point
from pipeline.sweep.severity import rise_limit
from tribo import InputError
from tribo.types import Array, Mask

Wanted = float | str | Iterable[float | str] | None
"""Loads or velocities asked for, [SI] or text with a unit; None for those near the transition."""
Spot = tuple[int, int]
"""Indices of a point along load and velocity."""
_LIKE = {"load": "600 N", "velocity": "1.5 m/s"}


def chosen_points(
    ds: xr.Dataset, load: Wanted, velocity: Wanted, conditions: Conditions, nearest: bool = False
) -> list[Spot]:
    """Find the indices of the points asked for, or of the one nearest to the transition.

    A load or velocity that the sweep does not hold is refused, or stands for the nearest.
    """
    rises = decisive_rise(ds, conditions).values
    is_finite = np.isfinite(rises)
    loads, velocities = (
        indices_of(ds, axis, values, nearest)
        for axis, values in (("load", load), ("velocity", velocity))
    )
    points, reached = list[Spot](), np.flatnonzero(is_finite.any(axis=1))
    for i in loads or reached[-1:].tolist() or [0]:
        require_done_at(ds["load"].values[i], is_finite[i])
        judged = conditions.critical_temperature is not None
        limit = rise_limit(conditions) if judged else math.inf
        distance = np.abs(rises[i] - min(limit, np.nanmax(rises[i])))
        points += [(i, j) for j in velocities or [int(np.nanargmin(distance))]]
    for point in points:
        if not is_finite[point]:
            reason = str(messages(ds).transpose("load", "velocity").values[point])
            raise InputError(
                f"the point {point_name(ds, point)} is not done{reason and ': '}{reason}; "
                "give another load or velocity, or go on with irg run"
            )
    return points


def require_done_at(load: float, is_done: Mask) -> None:
    """Raise an `InputError` where no point at a load is done."""
    if not is_done.any():
        raise InputError(
            f"no point at {load:g} N is done; give another load, or go on with irg run"
        )


def indices_of(ds: xr.Dataset, axis: str, values: Wanted, nearest: bool = False) -> list[int]:
    """Find the indices of one load or velocity or several; none if none is given."""
    available, found = ds[axis].values, []
    for value in _places(axis, values):
        found.append(int(np.abs(available - value).argmin()))
        if not (nearest or math.isclose(available[found[-1]], value, rel_tol=1e-9)):
            raise InputError(
                f"{axis} is {value:g} {UNITS[axis]}, which the sweep does not hold; the nearest is "
                f"{available[found[-1]]:g} {UNITS[axis]}"
            )
    return found


def _places(axis: str, values: Wanted) -> list[float]:
    """Loads or velocities that were asked for [SI]."""
    several = [] if values is None else np.atleast_1d(np.asarray(values, dtype=object)).tolist()
    return [in_si(axis, value, _LIKE[axis]) for value in several]


def nearest_to(ds: xr.Dataset, **asked: Wanted) -> str:
    """Say which loads and velocities of those asked for the sweep does not hold; empty if none."""
    missing = [
        f"{value:g} {UNITS[axis]}"
        for axis, values in asked.items()
        for value in _places(axis, values)
        if not np.isclose(ds[axis].values, value, rtol=1e-9).any()
    ]
    return f", nearest to {' and '.join(missing)}" if missing else ""


def point_name(ds: xr.Dataset, point: Spot) -> str:
    """Name a point by its load, its velocity and its surface, from its indices."""
    return str(Point(ds["load"].values[point[0]], ds["velocity"].values[point[1]], drawn_row(ds)))


_COLOURS = "viridis_r", "inferno_r", "cividis_r"  # of which each is darker where there is more
_BAR = 0.12  # [inch] of a bar of colours, and of the gap below it
_HIGHEST_STACKED = 2.6  # [inch] of each of three panels, which fit a page at a column's width


def fields(
    ds: xr.Dataset,
    load: float | str | None = None,
    velocity: float | str | None = None,
    realization: int | None = None,
    stacked: bool = False,
) -> Figure:
    """Draw pressure, temperature and wear depth over the contact at the end of one point."""
    if "pressure" not in ds:
        raise InputError(
            "the sweep holds no fields; set 'fields = true' under [sweep] in the scene, and run it "
            "into another store"
        )
    ds = one_row(ds, realization)
    conditions = temperature_conditions(ds)
    point = chosen_points(ds, load, velocity, conditions)[0]
    return _contact(ds, point, conditions, stacked)


def _shown(ds: xr.Dataset, point: Spot, conditions: Conditions) -> tuple[Array, ...]:
    """Pressure [GPa], temperature [°C] and wear depth [µm] at the end of a point, by x and y."""
    here = ds.isel(load=point[0], velocity=point[1]).transpose("x", "y", ...)
    rise = here["rise"].values
    if conditions.bulk_ratio:
        rise = rise + conditions.bulk_ratio * here["bulk_response"].values
        rise += max(0.0, -conditions.bulk_ratio)  # above the colder body
    if conditions.corrections:
        rise = corrected_field(here, rise, conditions)
    return (
        shown_in(here["pressure"].values, "GPa"),
        shown_in(conditions.contact_temperature(rise), "°C"),
        shown_in(here["wear_depth"].values, "µm"),
    )


@style.house_style
def _contact(ds: xr.Dataset, point: Spot, conditions: Conditions, stacked: bool) -> Figure:
    """Draw the contact at the end of a point."""
    pressure, temperature, depth = _shown(ds, point, conditions)
    critical = conditions.critical_temperature
    limit = math.inf if critical is None else shown_in(critical, "°C")
    outlined = temperature.min() < limit < temperature.max() and min(temperature.shape) > 1
    labels = (
        "contact pressure [GPa]",
        f"contact temperature [°C]{f', outlined at {limit:g}' if outlined else ''}",
        "wear depth of the pin [µm]",
    )
    centres = [shown_in(ds[axis].values, "µm") for axis in "xy"]
    x, y = map(_edges, centres)
    height = 3.3 * np.ptp(y) / np.ptp(x)
    is_equal = 0.5 < height < 12
    room = float(np.clip(height, 0.5 if is_equal else 1.0, _HIGHEST_STACKED if stacked else 6.0))
    panel = 1.4 + room
    size = (4.6, 1.0 + 3 * panel) if stacked else (11.0, 0.5 + panel)
    figure = style.Picture(figsize=size)
    row = figure.subplots(*((3, 1) if stacked else (1, 3)), sharex=True, sharey=True)
    shown = np.ma.masked_equal(pressure, 0.0), temperature, np.ma.masked_equal(depth, 0.0)
    lowest = 0.0, temperature.min(), 0.0
    for axes, label, field, colours, low in zip(row, labels, shown, _COLOURS, lowest, strict=True):
        image = axes.pcolormesh(x, y, field.T, cmap=colours, vmin=low, rasterized=True)
        axes.set_aspect("equal" if is_equal else "auto")
        axes.grid(visible=False)
        if not stacked or axes is row[-1]:
            axes.set_xlabel("x, along sliding [µm]")
        figure.colorbar(
            image, cax=axes.inset_axes((0, 1 + _BAR / room, 1, _BAR / room)), label=label,
            location="top",
        )  # fmt: skip
    for axes in row if stacked else row[:1]:
        if len(ds["y"]) > 1:
            axes.set_ylabel("y [µm]")
        else:
            axes.set_yticks([])
    if outlined:
        row[1].contour(*centres, temperature.T, [limit], colors=style.SKY, linewidths=style.THIN)
    title = f"{style.title_of(ds)}\n{point_name(ds, point)}, {style.heating(conditions)}"
    style.write_title(figure, title)
    return figure


def _edges(centres: Array) -> Array:
    """Borders of the elements around evenly spaced centres."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    step = (centres[-1] - centres[0]) / (len(centres) - 1)
    edges: Array = np.append(centres - step / 2, centres[-1] + step / 2)
    return edges
