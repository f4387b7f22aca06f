"""Contact, wear and temperature of points as their load grows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pipeline.answers.scene_wording import governing_words, heating_words, warning_lines
from pipeline.figures import style
from pipeline.figures.fields_figure import (
    DrawnCase,
    PointIndex,
    QuantityLike,
    chosen_points,
    drawn_case,
)
from pipeline.figures.style import BLACK, GREY
from pipeline.quantities import in_unit
from tribo.types import Array

_SOLID: dict[str, Any] = {"ls": "-", "marker": "o"}
_DASHED: dict[str, Any] = {"ls": "--", "marker": "^"}
_CONTACT_PANEL = (
    ("contact width [µm]", "contact_width"),
    ("real contact area [% of window]", "contact_fraction"),
)
_WEAR_PANEL = ("maximum wear depth [µm]", "wear_depth_max"), ("worn volume [mm³]", "wear_volume")


@style.house_style
def ramp(
    ds: xr.Dataset,
    conditions: Mapping[str, Any],
    load: QuantityLike = None,
    velocity: QuantityLike = None,
    realization: int | None = None,
) -> Figure:
    """Draw temperature, contact and wear of points over time, as their load grows.

    The points nearest to each pair of `load` and `velocity` are drawn; both are in SI or text with
    a unit, and may have several values. By default the load is the highest with a computed point,
    and the velocity is the nearest to the transition. `realization` is the seed of the surface; by
    default the first one.
    """
    drawn = drawn_case(ds, conditions, realization)
    points, columns = chosen_points(drawn, load, velocity), drawn.columns()
    figure = style.Picture((8.0, 8.4))
    temperature_axes, *lower_axes = figure.subplots(3, sharex=True)
    _draw_temperatures(temperature_axes, drawn, columns, points)
    for axes, panel in zip(lower_axes, (_CONTACT_PANEL, _WEAR_PANEL), strict=True):
        handles = []
        # The right axis has more room, so that proportional curves do not coincide.
        for (label, name), look, headroom in zip(panel, (_SOLID, _DASHED), (1.2, 1.5), strict=True):
            side_axes = axes if look is _SOLID else axes.twinx()
            side_axes.grid(visible=look is _SOLID)
            quantity, unit = label.rstrip("]").split(" [")
            values = in_unit(columns[name].astype(float), unit.split()[0])
            _draw_curves(side_axes, columns, values, points, look)
            side_axes.ticklabel_format(axis="y", scilimits=(-2, 3))
            top = headroom * side_axes.get_ylim()[1]  # room for the legend
            side_axes.set(ylabel=label, ylim=(0, top))
            handles.append(Line2D([], [], color=BLACK, label=quantity, **look))
        style.fitting_legend(axes, 2, handles=handles, loc="upper left")
    lower_axes[-1].set_xlabel("time [s]")
    lower_axes[-1].set_xlim(left=0)
    _add_load_axis(temperature_axes, columns, max(points))
    style.write_title(figure, drawn.title())
    handles = [
        Line2D([], [], color=f"C{index}", lw=3, label=drawn.point_text(point))
        for index, point in enumerate(points)
    ]
    caption_lines = [heating_words(drawn.conditions)]
    caption_lines += warning_lines(drawn.case.sweep, max_count=1, answered=True)
    style.legend_below(figure, handles=handles, caption="\n".join(caption_lines))
    return figure


def _draw_curves(
    axes: Axes, columns: Mapping[str, Any], values: Array, points: list[PointIndex], look: Any
) -> None:
    """Draw `values` (load, velocity, step) over time, a line for each point, its end marked."""
    for index, point in enumerate(points):
        is_known = np.isfinite(values[point])
        time, known_values = columns["time"][point][is_known], values[point][is_known]
        axes.plot(time, known_values, color=f"C{index}", markevery=[-1], **look)


def _draw_temperatures(
    axes: Axes, drawn: DrawnCase, columns: Mapping[str, Any], points: list[PointIndex]
) -> None:
    """Draw the highest, the governing and the critical temperature of points over time."""
    conditions, handles = drawn.conditions, list[Line2D]()
    area_fractions = drawn.case.ds["area_fraction_below"].values
    highest = replace(conditions, critical_area_fraction=0.0)
    curves = [(highest, _DASHED)]
    if conditions != highest:
        curves.append((conditions, _SOLID))
    for curve_conditions, look in curves:
        rise = curve_conditions.governing_rise({**columns, "quantile": area_fractions})
        temperature = in_unit(conditions.contact_temperature(rise), "°C")
        _draw_curves(axes, columns, temperature, points, look)
        label = governing_words(curve_conditions.critical_area_fraction)
        handles.append(Line2D([], [], color=BLACK, label=label, **look))
    if conditions.critical_temperature is not None:
        critical = in_unit(conditions.critical_temperature, "°C")
        label = f"critical temperature, {critical:g} °C"
        handles.append(axes.axhline(critical, color=GREY, ls=":", label=label))
    axes.set_ylabel("contact temperature [°C]")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.17 * (top - bottom))  # room for the legend
    style.fitting_legend(axes, 3, handles=handles, loc="upper left")


def _add_load_axis(axes: Axes, columns: Mapping[str, Any], point: PointIndex) -> None:
    """Add an upper axis with the load of `point` at each time, if this load grows at every step."""
    time, load = (np.append(0.0, columns[name][point]) for name in ("time", "normal_load"))
    time, load = time[np.isfinite(time)], load[np.isfinite(time)]
    if (np.diff(load) > 0).all():
        time, load = np.append(time, 2 * time[-1]), np.append(load, 2 * load[-1])
        to_load: Callable[..., Any] = partial(np.interp, xp=time, fp=load)
        to_time: Callable[..., Any] = partial(np.interp, xp=load, fp=time)
        axes.secondary_xaxis("top", functions=(to_load, to_time)).set_xlabel("normal load [N]")
