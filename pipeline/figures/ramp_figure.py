"""Contact, wear and temperature of points as their load grows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
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
from pipeline.quantities import shown_in
from pipeline.sweep.condition_entries import Conditions
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
    top, *below = figure.subplots(3, sharex=True)
    _temperatures(top, drawn, columns, points)
    for axes, panel in zip(below, (_CONTACT_PANEL, _WEAR_PANEL), strict=True):
        handles = []
        # The right axis has more room, so that proportional curves do not coincide.
        for (label, name), look, headroom in zip(panel, (_SOLID, _DASHED), (1.2, 1.5), strict=True):
            panel_axes = axes if look is _SOLID else axes.twinx()
            panel_axes.grid(visible=look is _SOLID)
            words, unit = label.rstrip("]").split(" [")
            values = shown_in(columns[name].astype(float), unit.split()[0])
            _draw(panel_axes, columns, values, points, look)
            panel_axes.ticklabel_format(axis="y", scilimits=(-2, 3))
            panel_axes.set(
                ylabel=label, ylim=(0, headroom * panel_axes.get_ylim()[1])
            )  # room for the legend
            handles.append(Line2D([], [], color=BLACK, label=words, **look))
        style.fitting_legend(axes, 2, handles=handles, loc="upper left")
    below[-1].set_xlabel("time [s]")
    below[-1].set_xlim(left=0)
    _load_axis(top, columns, max(points))
    style.write_title(figure, drawn.title())
    names = [
        Line2D([], [], color=f"C{k}", lw=3, label=drawn.words(point))
        for k, point in enumerate(points)
    ]
    caption_lines = [heating_words(drawn.conditions)]
    caption_lines += warning_lines(drawn.case.sweep, max_count=1, answered=True)
    style.legend_below(figure, handles=names, caption="\n".join(caption_lines))
    return figure


def _draw(
    axes: Axes, columns: Mapping[str, Any], values: Array, points: list[PointIndex], look: Any
) -> None:
    """Draw `values` (load, velocity, step) over time, a line for each point, its end marked."""
    for index, point in enumerate(points):
        is_known = np.isfinite(values[point])
        time, known_values = columns["time"][point][is_known], values[point][is_known]
        axes.plot(time, known_values, color=f"C{index}", markevery=[-1], **look)


def _temperatures(
    axes: Axes, drawn: DrawnCase, columns: Mapping[str, Any], points: list[PointIndex]
) -> None:
    """Draw the highest, the governing and the critical temperature of points over time."""
    handles, conditions = [], drawn.conditions
    shares = drawn.case.ds["area_fraction_below"].values
    for line_conditions, look in _line_styles(conditions):
        rise = line_conditions.governing_rise({**columns, "quantile": shares})
        temperature = shown_in(conditions.contact_temperature(rise), "°C")
        _draw(axes, columns, temperature, points, look)
        words = governing_words(line_conditions.critical_area_fraction)
        handles.append(Line2D([], [], color=BLACK, label=words, **look))
    handles += _critical_line(axes, conditions)
    axes.set_ylabel("contact temperature [°C]")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.17 * (top - bottom))  # room for the legend
    style.fitting_legend(axes, 3, handles=handles, loc="upper left")


def _line_styles(conditions: Conditions) -> list[tuple[Conditions, dict[str, Any]]]:
    """Conditions and line style of the highest and, if different, the governing temperature."""
    highest = replace(conditions, critical_area_fraction=0.0)
    return [(highest, _DASHED), *[(conditions, _SOLID)] * (conditions != highest)]


def _critical_line(axes: Axes, conditions: Conditions) -> list[Line2D]:
    """Draw a line at the critical temperature, if known; return its legend entry."""
    if conditions.critical_temperature is None:
        return []
    critical = shown_in(conditions.critical_temperature, "°C")
    return [
        axes.axhline(critical, color=GREY, ls=":", label=f"critical temperature, {critical:g} °C")
    ]


def _load_axis(axes: Axes, columns: Mapping[str, Any], point: PointIndex) -> None:
    """Add an upper axis with the load of `point` at each time, if this load grows at every step."""
    time, load = (np.append(0.0, columns[name][point]) for name in ("time", "normal_load"))
    time, load = time[np.isfinite(time)], load[np.isfinite(time)]
    if (np.diff(load) > 0).all():
        time, load = np.append(time, 2 * time[-1]), np.append(load, 2 * load[-1])
        pairs = (time, load), (load, time)
        to_load, to_time = (lambda x, pair=pair: np.interp(x, *pair) for pair in pairs)
        axes.secondary_xaxis("top", functions=(to_load, to_time)).set_xlabel("normal load [N]")
