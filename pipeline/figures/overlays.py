"""Lines and marks over the diagram: lift-off by the film, measurements."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.compared import own_conditions
from pipeline.analysis.transition import crossing
from pipeline.figures.style import BLACK, GREY
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.lubrication import Lubrication
from tribo import lubrication_regime
from tribo.material import BOUNDARY, FULL_FILM

_NEAR = 0.02  # relative difference of the limit that is not worth a mark of its own
_REACH = 1.5  # times the ends of the sweep, beyond which a test would shrink the figure
_RESOLUTION = 60
_DOTS = (0, (1, 2))


def film_lines(axes: Axes, ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Draw the beginnings of mixed lubrication and of the full film, if they lie in the figure."""
    lubrication = Lubrication.stored(attributes_of(ds))
    if lubrication is None:
        return []
    bulk = conditions.mean_bulk_temperature
    film = _over_figure(ds, lambda F, V: lubrication.film_parameter(F, V, bulk))
    look = {"linewidths": 1.0, "linestyles": [_DOTS], "zorder": 2.5}
    legend: list[Artist] = []
    for level, beyond in ((BOUNDARY, "mixed"), (FULL_FILM, "full film")):
        label = f"Λ = {level:g}, {beyond} beyond"
        if isoline(axes, film, level, label, colors=BLACK, **look):
            legend.append(Line2D([], [], color=BLACK, lw=1.0, ls=_DOTS, label=label))
    if not legend:
        regime = lubrication_regime(float(film.mean()))
        span = f"{film.min():.2f} to {film.max():.2f}"
        legend.append(Line2D([], [], ls="none", label=f"Λ {span}: {regime}"))
    return legend


def measured_transitions(axes: Axes, measured: Sequence[Mapping[str, Any]]) -> list[Artist]:
    """Mark the transitions that were measured."""
    if not measured:
        return []
    line = axes.plot(
        [point["velocity"] for point in measured],
        [point["normal_load"] for point in measured],
        ls="none", marker="D", ms=8, mfc=BLACK, mec="white", mew=1.3, zorder=4,
        label="measured transition", gid="measured",
    )  # fmt: skip
    return list(line)


def in_reach(
    ds: xr.Dataset, points: Sequence[Mapping[str, Any]]
) -> tuple[list[Mapping[str, Any]], list[Artist]]:
    """Tests within about half the sweep's range beyond it; a line of the legend on the others."""
    ends = {name: ds[name].values[[0, -1]] for name in ("load", "velocity")}

    def is_near(point: Mapping[str, Any]) -> bool:
        places = {"load": point["normal_load"], "velocity": abs(point["velocity"])}
        return all(
            low / _REACH <= places[name] <= _REACH * high for name, (low, high) in ends.items()
        )

    near = [point for point in points if is_near(point)]
    far = [point for point in points if not is_near(point)]
    if not far:
        return near, []
    first = f"{far[0]['normal_load']:g} N at {far[0]['velocity']:g} m/s"
    more = f" and {len(far) - 1} more" if len(far) > 1 else ""
    return near, [Line2D([], [], ls="none", label=f"beyond the figure: test of {first}{more}")]


def tested_points(axes: Axes, tested: Sequence[Mapping[str, Any]]) -> list[Artist]:
    """Mark the tests: open where wear stayed mild, filled where it turned severe."""
    legend: list[Artist] = []
    looks: dict[str, dict[str, Any]] = {
        "mild": {"mfc": "white", "mec": BLACK, "mew": 1.3, "ms": 8.5},
        "severe": {"mfc": BLACK, "mec": "white", "mew": 0.8, "ms": 9.5},
    }
    for outcome, look in looks.items():
        points = [point for point in tested if point["outcome"] == outcome]
        if points:
            legend += axes.plot(
                [point["velocity"] for point in points],
                [point["normal_load"] for point in points],
                ls="none", marker="^", zorder=4, label=f"test: {outcome} wear",
                gid=f"tested-{outcome}", **look,
            )  # fmt: skip
    return legend


def at_own_conditions(
    axes: Axes, plane: xr.DataArray, points: Sequence[Mapping[str, Any]], conditions: Conditions
) -> list[Artist]:
    """Mark the transition computed at each test's own friction and bulk temperature; join both.

    One at about the conditions of the diagram lies beside its line anyway, and is left out.
    """
    transitions = []
    loads, velocities = plane["load"].values, plane["velocity"].values
    limit = rise_limit(conditions)
    for point in points:
        if conditions.disk_temperature is not None and point.get("bulk_temperature"):
            continue  # another plane: the test had both bodies at one temperature
        own_limit = rise_limit(own_conditions(conditions, point))
        if abs(own_limit / limit - 1) < _NEAR or not math.isfinite(own_limit):
            continue
        if not loads[0] <= point["normal_load"] <= loads[-1]:
            continue
        row = plane.sel(load=point["normal_load"], method="nearest").values
        velocity = crossing(velocities, row, own_limit)
        if math.isfinite(velocity):
            transitions.append((velocity, point))
    for velocity, point in transitions:
        ends = [velocity, point["velocity"]], [point["normal_load"]] * 2
        axes.plot(*ends, color=GREY, lw=1.0, zorder=3.6, gid="to own conditions")
    if not transitions:
        return []
    line = axes.plot(
        [velocity for velocity, _ in transitions],
        [point["normal_load"] for _, point in transitions],
        ls="none", marker="D", ms=5.5, mfc="white", mec=BLACK, mew=1.1, zorder=3.9,
        label="computed at the test's own conditions", gid="at own conditions",
    )  # fmt: skip
    return list(line)


def _over_figure(ds: xr.Dataset, value: Callable[..., Any]) -> xr.DataArray:
    """A function of load and velocity over the figure."""
    ends = {name: ds[name].values[[0, -1]].tolist() for name in ("load", "velocity")}
    axes = {name: np.linspace(low, high, _RESOLUTION) for name, (low, high) in ends.items()}
    values = [[value(F, V) for V in axes["velocity"]] for F in axes["load"]]
    return xr.DataArray(values, axes, tuple(axes))


def isoline(axes: Axes, plane: xr.DataArray, level: float, gid: str, **look: Any) -> bool:
    """Draw a line at a level of a plane; False if the plane does not pass it."""
    if not plane.min() < level < plane.max():
        return False
    values = np.ma.masked_invalid(plane.values)
    look = {"zorder": 3, **look}
    axes.contour(plane["velocity"], plane["load"], values, [level], **look).set_gid(gid)
    return True
