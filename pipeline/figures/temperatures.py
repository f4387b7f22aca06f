"""Temperatures of the contact at any velocity: at the transition itself, between the points."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.dataset import on_surface
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.transition import crossing, interpolated
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
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import contact_temperature, rise_limit


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
