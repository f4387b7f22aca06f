"""Contact, wear and temperature while the load grows, and temperatures at any velocity."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.analysis.dataset import one_row, sweep_at_bulks, temperature_conditions
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.field import along_friction, places_of, point_field
from pipeline.figures import style
from pipeline.figures.fields import (
    Spot,
    Wanted,
    chosen_points,
    indices_of,
    nearest_to,
    point_name,
    require_done_at,
)
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION
from pipeline.quantities import shown_in
from pipeline.sweep.conditions import Conditions
from tribo import Criterion, InputError
from tribo.types import Array

_DASHED: dict[str, Any] = {"ls": "--", "marker": "^"}
_SOLID: dict[str, Any] = {"ls": "-", "marker": "o"}
_TALL = 8.0, 8.4  # [in], of three panels
_COARSE_RAMP = "\nmarks: end of the ramp, on smaller elements than the lines"


@style.house_style
def ramp(
    ds: xr.Dataset,
    load: Wanted = None,
    velocity: Wanted = None,
    realization: int | None = None,
    show: str | None = None,
) -> Figure:
    """Draw contact, wear and temperature, or one variable, of points while their load grows.

    Those nearest to a load or velocity that the sweep does not hold, which their names then say.
    Steps on the grid of the history and on the point's own are not joined.
    """
    ds = one_row(ds, realization)
    conditions = temperature_conditions(ds)
    points = chosen_points(ds, load, velocity, conditions, nearest=True)
    ds = sweep_at_bulks(ds, conditions).transpose("load", "velocity", "step", ...)

    volume = ds["wear_volume"].values
    is_worn = show is None and any(np.nanmax(volume[point]) > 0 for point in points)
    figure = style.Picture(figsize=_TALL if is_worn else None)
    ratios = (1.4, 1, 1) if is_worn else (1.4, 1)
    temperature, contact, *wear = figure.subplots(len(ratios), sharex=True, height_ratios=ratios)
    _temperatures(temperature, ds, points, conditions)
    if show is None:
        width = "contact width [µm]", "contact_width"
        _pair(contact, ds, points, width, ("in contact [% of window]", "contact_fraction"))
    else:
        _shown(contact, ds, points, show)
    for axes in wear:
        depth = "greatest wear depth [µm]", "wear_depth_max"
        _pair(axes, ds, points, depth, ("worn volume [mm³]", "wear_volume"))
    lowest = [contact, *wear][-1]
    lowest.set_xlabel("time [s]")
    lowest.set_xlim(0, 1.01 * max(float(np.nanmax(ds["time"].values[point])) for point in points))
    _load_axis(temperature, ds, points)
    style.write_title(figure, style.title_of(ds))
    said = nearest_to(ds, load=load, velocity=velocity)
    lines = [
        Line2D([], [], color=f"C{k}", lw=3, label=point_name(ds, point) + said)
        for k, point in enumerate(points)
    ]
    title = style.heating(conditions)
    time, own = ds["time"].values, ds["own_grid"].values
    if any((np.isfinite(time[point]) & ~own[point]).any() for point in points):
        title += _COARSE_RAMP
    style.legend_below(figure, handles=lines, title=title)
    return figure


def _temperatures(axes: Axes, ds: xr.Dataset, points: list[Spot], conditions: Conditions) -> None:
    decisive, rises = conditions.decisive, [ds["max_rise"].values]
    looks = [{"label": "highest", **_DASHED}]
    if decisive.temperature != Criterion("highest").temperature:
        columns = {name: ds[name].values for name in (decisive.column, "cooler_share")}
        rises.append(decisive.rise(columns | {"quantile": columns["cooler_share"]}))
        looks.append({"label": decisive.temperature, **_SOLID})
    for number, point in enumerate(points):
        for rise, look in zip(rises, looks, strict=True):
            temperature = shown_in(conditions.contact_temperature(rise), "°C")
            look = look | {"color": f"C{number}", "zorder": _order(point)}
            _draw(axes, ds, temperature, point, **look)
    key = [Line2D([], [], color=BLACK, **look) for look in looks]
    if conditions.critical_temperature is not None:
        critical = shown_in(conditions.critical_temperature, "°C")
        label = f"critical, {critical:g} °C"
        key.append(axes.axhline(critical, color=GREY, ls=":", label=label))
    axes.set_ylabel("contact temperature [°C]")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.17 * (top - bottom))  # room for the legend
    axes.legend(handles=key, loc="upper left", ncols=3)
    for start in {start for point in points if (start := _held_from(ds, point)) is not None}:
        axes.axvline(start, color=GREY, lw=style.THIN)
        axes.text(start, bottom, " load held", va="bottom", color=GREY)


def _held_from(ds: xr.Dataset, point: Spot) -> float | None:
    """Time at which a point's load was reached, if the point goes on after that [s]."""
    time, load = ds["time"].values[point], ds["normal_load"].values[point]
    reached = time[load >= ds["load"].values[point[0]]]
    return float(reached[0]) if len(reached) > 1 else None


def _order(point: Spot) -> float:
    """Lay lower loads over higher ones, which they would vanish under."""
    return 2 + 1 / (1 + point[0])


def _draw(axes: Axes, ds: xr.Dataset, values: Array, point: Spot, **look: Any) -> None:
    """Draw values (load, velocity, step) at the steps of a point, its end as a mark."""
    time, own, marker = ds["time"].values[point], ds["own_grid"].values[point], look.pop("marker")
    known = np.isfinite(values[point])
    for part, marks in ((known & ~own, {}), (known & own, {"marker": marker, "markevery": [-1]})):
        if part.any():
            axes.plot(time[part], values[point][part], **look, **marks)


def _pair(
    left: Axes,
    ds: xr.Dataset,
    points: list[Spot],
    solid: tuple[str, str],
    dashed: tuple[str, str],
) -> None:
    """Draw two variables below labels against time: solid on the left axis, dashed on the right."""
    right = left.twinx()
    right.grid(visible=False)
    key = []
    # The right axis has more room, so that quantities in proportion do not lie on each other.
    drawn = ((left, solid, _SOLID, 1.2), (right, dashed, _DASHED, 1.5))
    for axes, (label, name), look, room in drawn:
        words, unit = label.rstrip("]").split(" [")
        values = shown_in(ds[name].values, unit.split()[0])
        for number, point in enumerate(points):
            own = {"color": f"C{number}", "zorder": _order(point)}
            _draw(axes, ds, values, point, **look | own)
        axes.set_ylabel(label)
        axes.ticklabel_format(axis="y", scilimits=(-2, 3))
        axes.set_ylim(0, room * axes.get_ylim()[1])  # with room for the legend
        key.append(Line2D([], [], color=BLACK, label=words, **look))
    left.legend(handles=key, loc="upper left", ncols=2)


def _shown(axes: Axes, ds: xr.Dataset, points: list[Spot], name: str) -> None:
    """Draw a stored variable at each step against time, in its unit."""
    usual = ("load", "velocity", "step")
    names = sorted(str(one) for one in ds.data_vars if ds[one].dims == usual)
    if name not in names:
        raise InputError(f"show is {name!r}; stored at each step are {', '.join(names)}")
    for number, point in enumerate(points):
        look = {"color": f"C{number}", "zorder": _order(point), "marker": "o"}
        _draw(axes, ds, ds[name].values.astype(float), point, **look)
    axes.set_ylabel(f"{name} [{ds[name].attrs.get('units', '1')}]")


def _load_axis(axes: Axes, ds: xr.Dataset, points: list[Spot]) -> None:
    """Put the load that belongs to each time above `axes`, if no two times share one."""
    longest = max(points)
    time, load = ds["time"].values[longest], ds["normal_load"].values[longest]
    is_finite = np.isfinite(time)
    time, load = np.append(0.0, time[is_finite]), np.append(0.0, load[is_finite])
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


@style.house_style
def temperature(
    ds: xr.Dataset,
    load: float | str | None = None,
    realization: int | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Draw how the temperatures of the contact grow with the velocity at one load."""
    ds = one_row(ds, realization)
    conditions = temperature_conditions(ds)
    row = ds.isel(load=indices_of(ds, "load", load) or [-1])
    velocities, load_here = row["velocity"].values, float(row["load"][0])
    figure, axes = style.canvas(ax)
    highest = replace(conditions, criterion="highest")
    curves = [(highest, "highest", _DASHED)]
    if conditions.decisive.temperature != highest.decisive.temperature:
        curves.append((conditions, conditions.decisive.temperature, _SOLID))
    for judged, name, look in curves:
        rises = decisive_rise(row, judged).values[0]
        require_done_at(load_here, np.isfinite(rises))
        between, fine = along_friction(velocities, rises, conditions.friction_factor)
        for places, values, part in (
            (between, fine, {"ls": look["ls"]}),
            (velocities, rises, {"ls": "none", "marker": look["marker"]}),
        ):
            curve = shown_in(conditions.contact_temperature(values), "°C")
            axes.plot(places, curve, color=BLUE, **part)
        axes.plot([], [], color=BLUE, label=name, **look)
    if conditions.critical_temperature is not None:
        critical = shown_in(conditions.critical_temperature, "°C")
        axes.axhline(critical, color=GREY, ls=":", label=f"critical, {critical:g} °C")
        (line,) = point_field(row).lines("velocity", *places_of(load_here, velocities[-1]))
        for transition in line.places[np.isfinite(line.places)]:
            label = f"transition, {transition:.3g} m/s"
            axes.axvline(transition, color=VERMILION, label=label)
    axes.set(xlabel="sliding velocity [m/s]", ylabel="contact temperature [°C]")
    style.write_title(axes, f"{style.title_of(row)}\n{load_here:g} N")
    style.legend_below(figure, ax, title=style.heating(conditions))
    return figure
