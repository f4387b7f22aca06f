"""The transition diagram: where in the plane of velocity and load wear is mild or severe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.analysis.band import BAND
from pipeline.analysis.boundary import conditions_of, decisive_rise
from pipeline.analysis.dataset import asked_points, by_surface, on_surface, ordered
from pipeline.analysis.warned import has_warning
from pipeline.figures.regions import name_regions
from pipeline.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    TINTS,
    VERMILION,
    criterion,
    heating,
    in_house_style,
    title_of,
)
from pipeline.store.variables import PENDING
from pipeline.sweep.criterion import Conditions, rise_limit

_RESOLUTION = 240


@in_house_style
def diagram(
    ds: xr.Dataset,
    friction: float | Sequence[float] | None = None,
    bulk_temperature: float | str | None = None,
    critical_temperature: float | str | None = None,
    share: float | None = None,
    realization: int | None = None,
) -> Figure:
    """Draw the transition diagram.

    Over several surfaces the boundary is that of the median surface, and a band holds what lies
    between the tenth and the ninetieth of a hundred. The boundary is drawn on the plane
    interpolated between the computed points, on which `pipeline.boundary` lies for each load and
    each velocity. Where the sweep has a band of friction coefficients, the boundaries at its ends
    enclose a shaded area; where it has measured transitions, they are marked.

    Parameters
    ----------
    ds, bulk_temperature, critical_temperature, share
        See `pipeline.boundary`.
    friction : float or several, optional
        The lowest and highest of several make the band in place of the sweep's own, and the
        boundary is that of their median.
    realization : int, optional
        Seed of the only surface to draw; all of them if not given.
    """
    band = ds.attrs.get("friction_band")
    if isinstance(friction, Sequence):
        band = min(friction), max(friction)
        friction = float(np.median(friction))
    conditions = conditions_of(ds, friction, bulk_temperature, critical_temperature, share)
    ds = ordered(ds)
    if realization is not None:
        ds = on_surface(ds, realization)
    figure = Figure(figsize=(8.0, 6.4))
    axes = figure.add_subplot()
    legend: list[Artist] = []
    if min(ds.sizes["load"], ds.sizes["velocity"]) > 1:
        # A sweep that only follows the boundary knows the plane nowhere else.
        along_boundary = ds.attrs.get("chosen") is not None
        planes = decisive_rise(ds, conditions.failing_share, _RESOLUTION, along_boundary)
        plane = planes
        if "realization" in ds.dims:
            planes = planes.dropna("realization", how="all")
            plane = planes.quantile(0.5, "realization", skipna=False)
        _regions(axes, plane, rise_limit(conditions))
        legend += _boundary(axes, plane, conditions)
        if "realization" in ds.dims:
            legend += _surface_band(axes, planes, conditions)
        legend += _band(axes, plane, conditions, band)
    legend += _points(axes, ds, conditions)
    legend += _warnings(axes, ds)
    measured = ds.attrs.get("measured") or []
    legend += _measured(axes, measured)
    _limits(axes, ds, measured)
    if min(ds.sizes["load"], ds.sizes["velocity"]) > 1:
        name_regions(axes, plane, rise_limit(conditions), ds["load"].values, measured)

    axes.set_xlabel("sliding velocity [m/s]")
    axes.set_ylabel("normal load [N]")
    surface = "" if realization is None else f", surface {realization}"
    axes.set_title(title_of(ds) + surface, pad=10)
    figure.legend(
        handles=legend,
        loc="outside lower center",
        ncols=3,
        title=f"severe wear: {criterion(conditions)}; {heating(conditions)}",
        title_fontsize=9.5,
    )
    return figure


def _regions(axes: Axes, plane: xr.DataArray, limit: float) -> None:
    r = plane.values
    if np.isfinite(r).any():
        low, high = np.nanmin(r), np.nanmax(r)
        between = float(np.clip(limit, low - 1, high + 1))
        axes.contourf(
            plane["velocity"],
            plane["load"],
            np.ma.masked_invalid(r),
            levels=[low - 2, between, high + 2],
            colors=[TINTS["mild"], TINTS["severe"]],
            zorder=0.5,
        ).set_gid("regions")


def _boundary(axes: Axes, plane: xr.DataArray, conditions: Conditions) -> list[Artist]:
    if not _isoline(axes, plane, rise_limit(conditions), "boundary", colors=BLACK, linewidths=2.2):
        return []
    return [Line2D([], [], color=BLACK, lw=2.2, label="computed transition")]


def _band(
    axes: Axes, plane: xr.DataArray, conditions: Conditions, band: Sequence[float] | None
) -> list[Artist]:
    """Shade what lies between the boundaries at the ends of the band."""
    if not band or not np.isfinite(plane.values).any():
        return []
    limits = sorted(rise_limit(replace(conditions, friction=float(end))) for end in band)
    low, high = np.minimum(limits, float(np.nanmax(plane)) + 1)
    if not low < high:
        return []
    axes.contourf(
        plane["velocity"],
        plane["load"],
        np.ma.masked_invalid(plane.values),
        levels=[low, high],
        colors=[TINTS["band"]],
        alpha=0.6,
        zorder=0.8,
    ).set_gid("friction band")
    for end in limits:
        _isoline(axes, plane, end, "band edge", colors=GREY, linewidths=0.8, linestyles="--")
    text = f"transition at friction {min(band):g}–{max(band):g}"
    return [Patch(fc=TINTS["band"], ec=GREY, ls="--", lw=0.8, alpha=0.8, label=text)]


def _surface_band(axes: Axes, planes: xr.DataArray, conditions: Conditions) -> list[Artist]:
    """Shade where some surfaces are severe, but neither nearly none nor nearly all of them."""
    if planes.sizes["realization"] < 2:
        return []
    limit = rise_limit(conditions)
    low, high = planes.quantile([BAND[0], BAND[-1]], "realization", skipna=False)
    inside = ((low <= limit) & (high > limit)).values.astype(float)
    if not inside.any():
        return []
    for edge in (low, high):
        _isoline(axes, edge, limit, "surface band edge", colors=GREEN, linewidths=0.9)
    axes.contourf(
        planes["velocity"], planes["load"], inside, levels=[0.5, 1.5], colors=[GREEN],
        alpha=0.3, zorder=0.9,
    ).set_gid("surface band")  # fmt: skip
    text = (
        f"{100 * BAND[0]:g} to {100 * BAND[-1]:g} % of {planes.sizes['realization']} surfaces; "
        "line: their median"
    )
    return [Patch(fc=GREEN, ec=GREEN, lw=0.9, alpha=0.4, label=text)]


def _isoline(axes: Axes, plane: xr.DataArray, level: float, gid: str, **look: Any) -> bool:
    r = plane.values
    if not np.nanmin(r, initial=np.inf) < level < np.nanmax(r, initial=-np.inf):
        return False
    lines = axes.contour(
        plane["velocity"], plane["load"], np.ma.masked_invalid(r), [level], zorder=3, **look
    )
    lines.set_gid(gid)
    return True


def _points(axes: Axes, ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Mark the points; where there are several surfaces, by what those say that are done."""
    parts = by_surface(ds)
    r = np.array([decisive_rise(part, conditions.failing_share).values for part in parts])
    status = np.array([part["status"].transpose("load", "velocity").values for part in parts])
    asked = np.array([asked_points(part).values for part in parts]).any(axis=0)
    loads, velocities = np.meshgrid(ds["load"], ds["velocity"], indexing="ij")
    limit = rise_limit(conditions)
    hot, cold = np.any(r > limit, axis=0), np.any(r <= limit, axis=0)
    done = hot | cold
    failed = ~done & (status != PENDING).any(axis=0)
    pending = ~done & ~failed & asked
    kinds: list[tuple[str, Any, dict[str, Any]]] = [
        ("mild wear, computed", cold & ~hot, {"marker": "o", "mfc": "white", "mec": BLUE}),
        ("severe wear, computed", hot & ~cold, {"marker": "s", "mfc": VERMILION, "mec": "none"}),
        ("severe on some surfaces", hot & cold, {"marker": "s", "mfc": "white", "mec": VERMILION}),
        ("failed", failed, {"marker": "x", "mec": BLACK, "mew": 1.3, "ms": 5.5}),
        ("pending", pending, {"marker": ".", "mfc": GREY, "mec": "none", "ms": 6}),
    ]
    usual: dict[str, Any] = {"ls": "none", "ms": 4.0 if done.size < 1500 else 2.0, "mew": 0.9}
    return [
        axes.plot(
            velocities[where], loads[where], label=label, gid=label, zorder=3.5, **usual | look
        )[0]
        for label, where, look in kinds
        if where.any()
    ]


def _warnings(axes: Axes, ds: xr.Dataset) -> list[Artist]:
    """Ring the points that carry a warning on any surface."""
    told = has_warning(ds)
    rows = told.any(set(told.dims) - {"load", "velocity"}).transpose("load", "velocity").values
    if not rows.any():
        return []
    loads, velocities = np.meshgrid(ds["load"], ds["velocity"], indexing="ij")
    line = axes.plot(
        velocities[rows], loads[rows], ls="none", marker="o", ms=8.5, mfc="none", mec=BLACK,
        mew=0.8, zorder=3.4, label="carries a warning", gid="carries a warning",
    )  # fmt: skip
    return list(line)


def _measured(axes: Axes, measured: Sequence[dict[str, Any]]) -> list[Artist]:
    if not measured:
        return []
    line = axes.plot(
        [point["velocity"] for point in measured],
        [point["normal_load"] for point in measured],
        ls="none", marker="D", ms=8, mfc=BLACK, mec="white", mew=1.3, zorder=4,
        label="measured transition", gid="measured",
    )  # fmt: skip
    return list(line)


def _limits(axes: Axes, ds: xr.Dataset, measured: Sequence[dict[str, Any]]) -> None:
    for values, key, set_limits in (
        (ds["velocity"].values, "velocity", axes.set_xlim),
        (ds["load"].values, "normal_load", axes.set_ylim),
    ):
        shown = np.append(values, [point[key] for point in measured])
        margin = 0.04 * (np.ptp(shown) or shown[0] or 1.0)
        set_limits(shown.min() - margin, shown.max() + margin)
