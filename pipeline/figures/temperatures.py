"""Temperatures of the contact at any velocity: at the transition itself, between the points."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.dataset import at_bulks, end_of_point, on_surface, values_of
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.interpolation import crossing, interpolated
from pipeline.figures.points import PendingError, index_of_load
from pipeline.figures.style import (
    BLUE,
    GREY,
    VERMILION,
    canvas,
    celsius,
    heating,
    in_house_style,
    legend_below,
    title_of,
)
from pipeline.scene.quantities import in_si
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import contact_temperature, rise_limit
from tribo import InputError
from tribo.types import Array

_BINS = 40


@in_house_style
def temperature(
    ds: xr.Dataset,
    load: float | str | None = None,
    realization: int | None = None,
    ax: Axes | None = None,
    **changed: Any,
) -> Figure:
    """Draw how the temperatures of the contact grow with the velocity at one load."""
    conditions = conditions_of(ds, **changed)
    row = _row(ds, load, realization)
    velocities = row["velocity"].values
    figure, axes = canvas(ax, (7.2, 5.0))
    highest = replace(conditions, criterion="highest")
    curves: list[tuple[Conditions, str, Any]] = [(highest, "highest", {"ls": "--", "marker": "^"})]
    if conditions.decisive.temperature != highest.decisive.temperature:
        curves.append((conditions, conditions.decisive.temperature, {"ls": "-", "marker": "o"}))
    for judged, name, look in curves:
        rises = decisive_rise(row, judged).values[0]
        computed = velocities[np.isfinite(rises)]
        if not computed.size:
            raise PendingError(
                f"no point at {float(row['load'][0]):g} N is done; "
                "give another load, or run the scene on"
            )
        between = np.linspace(computed[0], computed[-1], 200)
        curve = celsius(contact_temperature(interpolated(velocities, rises, between), conditions))
        axes.plot(between, curve, color=BLUE, ls=look["ls"])
        axes.plot(
            velocities, celsius(contact_temperature(rises, conditions)),
            color=BLUE, ls="none", marker=look["marker"],
        )  # fmt: skip
        axes.plot([], [], color=BLUE, label=name, **look)
    transition = _transition(row, conditions)
    if conditions.critical_temperature is not None:
        critical = celsius(conditions.critical_temperature)
        axes.axhline(critical, color=GREY, ls=":", label=f"critical, {critical:g} °C")
    if np.isfinite(transition):
        axes.axvline(transition, color=VERMILION, lw=1.2, label=f"transition, {transition:.3g} m/s")
    axes.set(xlabel="sliding velocity [m/s]", ylabel="contact temperature [°C]")
    axes.set_title(f"{title_of(row)}\n{float(row['load'][0]):g} N")
    legend_below(figure, ax, ncols=4, title=heating(conditions))
    return figure


@in_house_style
def histogram(
    ds: xr.Dataset,
    load: float | str | None = None,
    velocity: float | str | None = None,
    realization: int | None = None,
    ax: Axes | None = None,
    **changed: Any,
) -> Figure:
    """Draw the distribution of the temperature over the contact at the end of a point.

    Between the velocities of the sweep each quantile is interpolated.
    """
    conditions = conditions_of(ds, **changed)
    row = _row(ds, load, realization)
    newtons = float(row["load"][0])
    sliding = (
        _transition(row, conditions) if velocity is None else in_si("velocity", velocity, "1.5 m/s")
    )
    if not np.isfinite(sliding):
        raise InputError(f"there is no transition at {newtons:g} N; give a velocity")
    quantiles = _quantiles_at(at_bulks(row, conditions), sliding)
    if not np.isfinite(quantiles).all():
        ends = row["velocity"].values[[0, -1]]
        raise InputError(
            f"velocity is {sliding:g} m/s; at {newtons:g} N points are done from {ends[0]:g} to "
            f"{ends[1]:g} m/s at most"
        )
    temperatures = celsius(contact_temperature(quantiles, conditions))
    if temperatures[0] == temperatures[-1]:
        raise InputError(
            f"friction is {conditions.friction:g}, so the whole contact has the bulk temperature; "
            "give a friction above 0 for a histogram"
        )
    edges = np.linspace(temperatures[0], temperatures[-1], _BINS + 1)
    below = np.interp(edges, temperatures, row["quantile"].values)
    figure, axes = canvas(ax, (7.2, 5.0))
    centres, shares = (edges[1:] + edges[:-1]) / 2, 100 * np.diff(below)
    width = edges[1] - edges[0]
    if conditions.critical_temperature is None:
        axes.bar(centres, shares, width, color=BLUE)
    else:
        critical = celsius(conditions.critical_temperature)
        hot = centres > critical
        failed = 100 * (1 - np.interp(critical, temperatures, row["quantile"].values))
        axes.bar(centres[~hot], shares[~hot], width, color=BLUE)
        label = f"{failed:.3g} % above {critical:g} °C"
        axes.bar(centres[hot], shares[hot], width, color=VERMILION, label=label)
        axes.axvline(critical, color=GREY, ls=":", label=f"critical, {critical:g} °C")
    axes.set_xlabel("contact temperature [°C]")
    axes.set_ylabel(f"share of the contact per {width:.2g} K [%]")
    where = "at the transition, " if velocity is None else ""
    axes.set_title(f"{title_of(row)}\n{newtons:g} N, {where}{sliding:.3g} m/s")
    legend_below(figure, ax, ncols=3, title=heating(conditions))
    return figure


def _row(ds: xr.Dataset, load: float | str | None, realization: int | None) -> xr.Dataset:
    """The points at one load on one surface, the velocities ascending."""
    ds = on_surface(ds, realization)
    return ds.isel(load=[index_of_load(ds, load)])


def _transition(row: xr.Dataset, conditions: Conditions) -> float:
    """Velocity at which wear turns severe at the load of a row; NaN if it does not [m/s]."""
    if conditions.critical_temperature is None:
        return float("nan")
    rises = decisive_rise(row, conditions).values[0]
    return crossing(row["velocity"].values, rises, rise_limit(conditions))


def _quantiles_at(row: xr.Dataset, velocity: float) -> Array:
    """Rise that each share of the contact stays below, at any velocity between the points [K]."""
    stored = values_of(end_of_point(row), "rise_quantile")[0]
    place, velocities = np.array([velocity]), row["velocity"].values
    rises = np.apply_along_axis(lambda column: interpolated(velocities, column, place), 0, stored)
    quantiles: Array = np.maximum.accumulate(rises[0])
    return quantiles
