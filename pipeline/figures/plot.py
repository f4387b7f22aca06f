"""Figures of a sweep: the transition diagram, the ramp at a velocity, the fields of a point.

Each is a function that takes the dataset of `pipeline.open_sweep` and gives a matplotlib figure,
without touching pyplot's state; `plot` chooses one by name and writes it to a file.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pipeline.analysis.boundary import conditions_of, decisive_rise, rise_exceeded
from pipeline.analysis.dataset import on_surface, open_sweep, ordered
from pipeline.figures.diagram import diagram
from pipeline.figures.style import (
    BLACK,
    GREY,
    celsius,
    exceeding,
    figure_path,
    heating,
    in_house_style,
    save_figure,
    title_of,
)
from pipeline.store.variables import DONE
from pipeline.sweep.criterion import Conditions, contact_temperature, rise_limit
from pipeline.sweep.model import Point
from tribo import InputError
from tribo.types import Array

__all__ = ["diagram", "fields", "plot", "ramp"]


def plot(
    ds: xr.Dataset | str | Path, kind: str, out: str | Path | None = None, **options: Any
) -> Figure | Path:
    """Draw a figure of a sweep.

    Parameters
    ----------
    ds : Dataset or path
        Of `pipeline.open_sweep`, or where the store lies.
    kind : {"diagram", "ramp", "fields"}
    out : path, optional
        Where to write it; the suffix, one of .pdf, .png and .svg, decides the format.
    **options
        Of the function of that name: `diagram`, `ramp`, `fields`.

    Returns
    -------
    Figure or Path
        The figure, or where it was written.

    Raises
    ------
    InputError
        If the kind, an option or the suffix is unknown, or the file cannot be written.
    """
    draw = _KINDS.get(kind)
    if draw is None:
        raise InputError(f"kind is {kind!r}; allowed are {', '.join(_KINDS)}")
    allowed = list(inspect.signature(draw).parameters)[1:]
    for name in options:
        if name not in allowed:
            raise InputError(f"{kind} has no option {name!r}; it has {', '.join(allowed)}")
    path = None if out is None else figure_path(out)
    figure = draw(ds if isinstance(ds, xr.Dataset) else open_sweep(ds), **options)
    return figure if path is None else save_figure(figure, path)


@in_house_style
def ramp(
    ds: xr.Dataset,
    load: float | Iterable[float] | None = None,
    velocity: float | Iterable[float] | None = None,
    friction: float | None = None,
    bulk_temperature: float | str | None = None,
    critical_temperature: float | str | None = None,
    share: float | None = None,
    realization: int | None = None,
) -> Figure:
    """Draw what happens while the load grows.

    The temperature is known at the end of each point, and between where the scene asked for it.
    The ends of lower loads at the same velocity lie on the same ramp and are drawn too.

    Parameters
    ----------
    ds : Dataset
    load : float or several, optional
        Up to which to draw [N]; the highest if not given.
    velocity : float or several, optional
        [m/s]; the one nearest to the transition at that load if not given.
    friction, bulk_temperature, critical_temperature, share
        See `pipeline.boundary`.
    realization : int, optional
        Seed of the surface to draw; the first if not given.
    """
    conditions = conditions_of(ds, friction, bulk_temperature, critical_temperature, share)
    ds = on_surface(ordered(ds), realization).transpose("load", "velocity", "step", ...)
    points = _points(ds, load, velocity, conditions)

    figure = Figure(figsize=(7.2, 7.8))
    temperature, contact, wear = figure.subplots(3, 1, sharex=True, height_ratios=(1.4, 1, 1))
    _temperatures(temperature, ds, points, conditions)
    width, fraction = 1e6 * ds["contact_width"].values, 100 * ds["contact_fraction"].values
    _pair(contact, ds, points, "contact width [µm]", width, "in contact [% of window]", fraction)
    depth, volume = 1e6 * ds["wear_depth_max"].values, 1e9 * ds["wear_volume"].values
    power = _power_of_thousand(max(np.nanmax(volume[point]) for point in points))
    unit = f"$10^{{{round(math.log10(power))}}}$ mm³" if power != 1 else "mm³"
    worn = f"worn volume [{unit}]", volume / power
    _pair(wear, ds, points, "greatest wear depth [µm]", depth, *worn)
    wear.set_xlabel("time [s]")
    wear.set_xlim(0, 1.01 * max(float(np.nanmax(ds["time"].values[point])) for point in points))
    _load_axis(temperature, ds, points)
    figure.suptitle(title_of(ds))
    lines = [
        Line2D([], [], color=f"C{k}", lw=3, label=_name(ds, point))
        for k, point in enumerate(points)
    ]
    figure.legend(
        handles=lines,
        loc="outside lower center",
        ncols=3,
        title=heating(conditions),
        title_fontsize=9.5,
    )
    return figure


@in_house_style
def fields(
    ds: xr.Dataset,
    load: float | None = None,
    velocity: float | None = None,
    friction: float | None = None,
    bulk_temperature: float | str | None = None,
    critical_temperature: float | str | None = None,
    share: float | None = None,
    realization: int | None = None,
) -> Figure:
    """Draw pressure, temperature and wear depth over the contact at the end of one point.

    Parameters
    ----------
    ds : Dataset
    load : float, optional
        [N]; the highest if not given.
    velocity : float, optional
        [m/s]; the one nearest to the transition at that load if not given.
    friction, bulk_temperature, critical_temperature, share
        See `pipeline.boundary`.
    realization : int, optional
        Seed of the surface to draw; the first if not given.

    Raises
    ------
    InputError
        If the sweep holds no fields.
    """
    conditions = conditions_of(ds, friction, bulk_temperature, critical_temperature, share)
    ds = on_surface(ordered(ds), realization)
    if not {"pressure", "rise", "wear_depth"} <= set(ds.data_vars):
        raise InputError(
            "the sweep holds no fields; store them with 'fields = true' under [sweep] in the "
            "scene, and run it into a new store"
        )
    (i, j) = point = _points(ds, load, velocity, conditions)[0]
    here = ds.isel(load=i, velocity=j).transpose("x", "y", ...)
    temperature = celsius(contact_temperature(here["rise"].values, conditions))
    critical = conditions.critical_temperature
    limit = math.inf if critical is None else celsius(critical)
    outlined = temperature.min() < limit < temperature.max() and min(temperature.shape) > 1
    white = f", outlined at {limit:g}" if outlined else ""
    pressure = here["pressure"].values / 1e9
    panels = (
        ("contact pressure [GPa]", np.ma.masked_equal(pressure, 0.0), "viridis_r", 0.0),
        (f"contact temperature{white} [°C]", temperature, "inferno", None),
        ("wear depth of the pin [µm]", 1e6 * here["wear_depth"].values, "cividis", 0.0),
    )

    x, y = _edges(1e6 * here["x"].values), _edges(1e6 * here["y"].values)
    height = 3.3 * np.ptp(y) / np.ptp(x)
    figure = Figure(figsize=(11.0, 2.2 + float(np.clip(height, 1.0, 6.0))))
    row = figure.subplots(1, 3, sharex=True, sharey=True)
    for axes, (label, values, colours, lowest) in zip(row, panels, strict=True):
        image = axes.pcolormesh(x, y, values.T, cmap=colours, vmin=lowest, rasterized=True)
        axes.set_aspect("equal" if 0.5 < height < 12 else "auto")
        axes.grid(visible=False)
        axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
        axes.set_xlabel("x, along sliding [µm]")
        figure.colorbar(
            image, cax=axes.inset_axes((0, 1.04, 1, 0.035)), label=label, location="top"
        )
    if len(here["y"]) > 1:
        row[0].set_ylabel("y [µm]")
    else:
        row[0].set_yticks([])
    if outlined:
        centres = 1e6 * here["x"].values, 1e6 * here["y"].values
        row[1].contour(*centres, temperature.T, [limit], colors="white", linewidths=0.8)
    figure.suptitle(f"{title_of(ds)}\n{_name(ds, point)}, {heating(conditions)}")
    return figure


_KINDS: dict[str, Callable[..., Figure]] = {"diagram": diagram, "ramp": ramp, "fields": fields}


def _points(
    ds: xr.Dataset,
    load: float | Iterable[float] | None,
    velocity: float | Iterable[float] | None,
    conditions: Conditions,
) -> list[tuple[int, int]]:
    """Find the indices of the points asked for, or of the one nearest to the transition."""
    r = decisive_rise(ds, conditions.failing_share).values
    known = np.isfinite(r)
    if not known.any():
        raise InputError("no point of the sweep is done yet")
    loads = [_index(ds, "load", "N", value) for value in _several(load)]
    velocities = [_index(ds, "velocity", "m/s", value) for value in _several(velocity)]
    points = []
    for i in loads or [int(np.flatnonzero(known.any(axis=1))[-1])]:
        if not known[i].any():
            raise InputError(f"no point at {ds['load'].values[i]:g} N is done")
        judged = conditions.critical_temperature is not None
        limit = rise_limit(conditions) if judged else math.inf
        distance = np.abs(r[i] - min(limit, np.nanmax(r[i])))
        points += [(i, j) for j in velocities or [int(np.nanargmin(distance))]]
    for point in points:
        if not known[point]:
            reason = str(ds["message"].transpose("load", "velocity").values[point])
            raise InputError(f"the point {_name(ds, point)} is not done{reason and ': '}{reason}")
    return points


def _several(values: float | Iterable[float] | None) -> list[float]:
    if values is None:
        return []
    return [float(value) for value in np.atleast_1d(np.asarray(values))]


def _index(ds: xr.Dataset, axis: str, unit: str, value: float) -> int:
    available = ds[axis].values
    nearest = int(np.abs(available - value).argmin())
    if not math.isclose(available[nearest], value, rel_tol=1e-9):
        raise InputError(
            f"{axis} is {value:g} {unit}, which the sweep does not hold; the nearest is "
            f"{available[nearest]:g} {unit}"
        )
    return nearest


def _name(ds: xr.Dataset, point: tuple[int, int]) -> str:
    surface = int(ds["realization"]) if "realization" in ds.coords else None
    return str(Point(ds["load"].values[point[0]], ds["velocity"].values[point[1]], surface))


def _temperatures(
    axes: Axes, ds: xr.Dataset, points: list[tuple[int, int]], conditions: Conditions
) -> None:
    highest = ds["max_rise"].values
    rises: list[tuple[Array, str, Any]] = [(highest, "maximum", {"ls": "--", "marker": "^"})]
    if conditions.failing_share:
        rise = rise_exceeded(ds, conditions.failing_share).values
        rises.append((rise, exceeding(conditions), {"ls": "-", "marker": "o"}))
    for number, point in enumerate(points):
        for rise, _, look in rises:
            time, kelvin = _along_ramp(ds, rise, point)
            temperature = celsius(contact_temperature(kelvin, conditions))
            axes.plot(time, temperature, color=f"C{number}", zorder=_order(point), **look)
    key = [Line2D([], [], color=BLACK, label=label, **look) for _, label, look in rises]
    if conditions.critical_temperature is not None:
        critical = celsius(conditions.critical_temperature)
        axes.axhline(critical, color=GREY, ls=":", lw=1.4)
        key.append(Line2D([], [], color=GREY, ls=":", lw=1.4, label=f"critical, {critical:g} °C"))
    axes.set_ylabel("contact temperature [°C]")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.17 * (top - bottom))  # room for the legend
    axes.legend(handles=key, loc="upper left", ncols=3)
    for start in {start for point in points if (start := _held_from(ds, point)) is not None}:
        axes.axvline(start, color=GREY, lw=0.9)
        axes.text(start, bottom, " load held", va="bottom", color=GREY)


def _held_from(ds: xr.Dataset, point: tuple[int, int]) -> float | None:
    """When a point's load was reached, if it goes on after that [s]."""
    time, load = ds["time"].values[point], ds["normal_load"].values[point]
    reached = time[load >= ds["load"].values[point[0]]]
    return float(reached[0]) if len(reached) > 1 else None


def _order(point: tuple[int, int]) -> float:
    """Lay lower loads over higher ones, which they would vanish under."""
    return 2 + 1 / (1 + point[0])


def _along_ramp(ds: xr.Dataset, rise: Array, point: tuple[int, int]) -> tuple[Array, Array]:
    """Take the times and values of `rise` (load, velocity, step) on the ramp up to the point."""
    i, j = point
    done = ds["status"].values[: i + 1, j] == DONE
    time, rise = ds["time"].values[: i + 1, j][done].ravel(), rise[: i + 1, j][done].ravel()
    load = ds["normal_load"].values[: i + 1, j][done].ravel()
    known = np.isfinite(rise)
    # A lower load that is held, or that was reached in another way, lies elsewhere at that time.
    own = np.isfinite(ds["time"].values[point])
    times, loads = (np.append(0.0, ds[name].values[point][own]) for name in ("time", "normal_load"))
    known[known] = np.isclose(load[known], np.interp(time[known], times, loads), rtol=1e-9)
    time, first = np.unique(time[known], return_index=True)
    return time, rise[known][first]


def _pair(
    left: Axes,
    ds: xr.Dataset,
    points: list[tuple[int, int]],
    left_label: str,
    left_values: Array,
    right_label: str,
    right_values: Array,
) -> None:
    """Draw two quantities against time, solid on the left axis and dashed on the right one."""
    right = left.twinx()
    right.grid(visible=False)
    key = []
    for axes, label, values, style in (
        (left, left_label, left_values, "-"),
        (right, right_label, right_values, "--"),
    ):
        for number, point in enumerate(points):
            time, order = ds["time"].values[point], _order(point)
            axes.plot(time, values[point], color=f"C{number}", ls=style, zorder=order)
        axes.set_ylabel(label)
        axes.set_ylim(0, 1.2 * axes.get_ylim()[1])  # room for the legend
        key.append(Line2D([], [], color=BLACK, ls=style, label=label.partition(" [")[0]))
    left.legend(handles=key, loc="upper left", ncols=2)


def _load_axis(axes: Axes, ds: xr.Dataset, points: list[tuple[int, int]]) -> None:
    """Put the load that belongs to each time above `axes`, if no two times share one."""
    longest = max(points)
    time, load = ds["time"].values[longest], ds["normal_load"].values[longest]
    known = np.isfinite(time)
    time, load = np.append(0.0, time[known]), np.append(0.0, load[known])
    if not (np.diff(load) > 0).all():
        return
    time, load = np.append(time, 2 * time[-1]), np.append(load, 2 * load[-1])
    top = axes.secondary_xaxis(
        "top",
        functions=(
            lambda t: np.interp(np.asarray(t, dtype=float), time, load),
            lambda f: np.interp(np.asarray(f, dtype=float), load, time),
        ),
    )
    top.set_xlabel("normal load [N]")


def _power_of_thousand(value: float) -> float:
    """Give the power of 1000 by which to divide, for a value from 1 to 1000.

    Examples
    --------
    >>> _power_of_thousand(0.0028)
    0.001
    """
    return 1000.0 ** math.floor(math.log(value, 1000)) if value > 0 else 1.0


def _edges(centres: Array) -> Array:
    """Find the borders of the elements around evenly spaced centres."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    step = (centres[-1] - centres[0]) / (len(centres) - 1)
    edges: Array = np.append(centres - step / 2, centres[-1] + step / 2)
    return edges
