"""The transition diagram: mild and severe wear in the plane of velocity and load."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps, rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline import extras
from pipeline.analysis.boundary import BAND
from pipeline.analysis.dataset import (
    Kind,
    asked,
    drawn_row,
    entry_dims,
    read_conditions,
    scene_sweep,
    select_surface,
    stored_sweep,
    sweep_kind,
)
from pipeline.analysis.decisive import decisive_rise
from pipeline.analysis.field import PointField, point_field
from pipeline.analysis.laboratory import laboratory_tests, model_error
from pipeline.analysis.margin import DECIDED, verdict_plane
from pipeline.analysis.results import results
from pipeline.analysis.scenes import scenes, value_text
from pipeline.analysis.warned_points import warning_flags
from pipeline.figures import style
from pipeline.figures.overlays import (
    film_lines,
    mark_tests,
    name_regions,
    numbered,
    reachable_tests,
    zero_line,
)
from pipeline.figures.row_margins import draw_rows
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, TINTS, VERMILION
from pipeline.store.schema import PENDING, PLANE
from pipeline.sweep.about import judged_by
from pipeline.sweep.model import named
from pipeline.sweep.severity import rise_limit
from tribo import Criterion, InputError
from tribo.types import Array

_SIZE = 8.0, 5.6  # [in], of a diagram
_LIGHTEST = 0.85  # of the colours of several scenes
_MANY = 1500  # points, from which marks are small


@style.house_style
def diagram(
    ds: xr.Dataset, realization: int | None = None, log: bool = False, ax: Axes | None = None
) -> Figure:
    """Draw the transition diagram; of samples, the probability of severe wear; of rows, margins.

    Each place has the verdict of its margin. Over several surfaces the boundary is that of the
    median one, in a band from the tenth to the ninetieth of a hundred.
    """
    kind = sweep_kind(ds)
    if kind is Kind.SAMPLES:
        if realization is not None or ax is not None:
            raise InputError(
                "the diagram of samples shows probabilities; leave out the surface and ax"
            )
        drawn: Figure = extras.module("figures").draw_probability(ds, log)
        return drawn
    ds = select_surface(ds, realization)
    if kind is Kind.PLACES:
        if log:
            raise InputError(
                "each row has its own load and velocity, so there is no plane; leave out log"
            )
        return draw_rows(ds, ax)
    if log:
        ds = ds.sel(velocity=ds["velocity"] > 0)
    figure, axes = style.canvas(ax, _SIZE)
    several = [*scenes(ds)]
    conditions = read_conditions(several[0])
    draw = _draw_scenes if entry_dims(ds) else _draw_scene
    legend, caption = draw(axes, ds)
    tests, beyond = reachable_tests(ds, numbered(laboratory_tests(ds)))
    own_bulk = scene_sweep(several[0]).conditions.bulk_temperature
    legend += [*mark_tests(axes, tests, conditions.bulk_temperature, own_bulk), *beyond]
    axes.use_sticky_edges = False  # those of the regions would leave no margin
    axes.margins(0.04)
    if log:
        axes.set(xscale="log", yscale="log")
        style.plain_numbers(axes)
    style.write_title(axes, ", ".join([style.title_of(ds), *named(drawn_row(ds))]))
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")
    style.legend_below(figure, ax, handles=legend, caption=caption)
    return figure


def _draw_scene(axes: Axes, ds: xr.Dataset) -> tuple[list[Artist], str]:
    """Draw one scene, the boundary that of the median of its surfaces; its legend and caption."""
    field = point_field(ds)
    caption, legend = judged_by([field.conditions]), list[Artist]()
    sizes = {name: ds.sizes[name] for name in PLANE}
    if min(sizes.values()) > 1:
        x, y = _between(ds["velocity"].values, 96), _between(ds["load"].values, 48)
        excess = _excess(field, x, y)
        legend += _shade_verdicts(axes, ds, field, x, y, excess)
        if zero_line(axes, x, y, np.median(excess, axis=0), "boundary", **style.BOUNDARY):
            label = "computed transition" + ", median" * (len(excess) > 1)
            legend.append(Line2D([], [], label=label, **style.BOUNDARY))
        legend += _shade_surfaces(axes, x, y, excess)
        legend += _friction_lines(axes, ds, field, x, y)
        legend += film_lines(axes, ds, field.conditions)
        caption += f"\nthe model's own error: {model_error(ds, field).worded}"
    elif max(sizes.values()) > 1:
        legend += _mark_transition(axes, ds, field, "velocity" if sizes["velocity"] > 1 else "load")
    return [*legend, *_mark_points(axes, ds)], caption


def _draw_scenes(axes: Axes, ds: xr.Dataset) -> tuple[list[Artist], str]:
    """Draw the boundary of each scene of a sweep over entries, the median of its surfaces."""
    if min(ds.sizes["load"], ds.sizes["velocity"]) < 2:
        raise InputError(
            "the diagram of several scenes takes two loads and two velocities or more; irg "
            "boundary prints their transitions"
        )
    several, legend = [point_field(scene) for scene in scenes(ds)], list[Artist]()
    shades = colormaps["viridis"](np.linspace(0.0, _LIGHTEST, len(several)))
    x, y = _between(ds["velocity"].values, 96), _between(ds["load"].values, 48)
    for field, shade in zip(several, shades, strict=True):
        plane = np.median(_excess(field, x, y), axis=0)
        name = ", ".join(value_text(ds[path], field.shown[path]) for path in entry_dims(ds))
        look: dict[str, Any] = style.BOUNDARY | {"color": shade}
        if not zero_line(axes, x, y, plane, f"boundary {name}", **look):
            name, look = f"{name}: no transition computed", {"ls": "none"}
        legend.append(Line2D([], [], label=name, **look))
    entries = " and ".join(entry_dims(ds)).replace(".", " ").replace("_", " ")
    caption, conditions = f"transition by {entries}", {field.conditions for field in several}
    return legend, caption + (f"; {judged_by(conditions)}" if len(conditions) == 1 else "")


_INSIDE = 1e-4  # of an interval between points, at whose ends the error is smaller


def _between(points: Array, least: int) -> Array:
    """Places from the first point to the last, among them both sides of each point."""
    begins, ends = points[:-1], points[1:]
    inside, parts = _INSIDE * (ends - begins), max(2, math.ceil(least / len(begins)))
    return np.linspace(begins + inside, ends - inside, parts, axis=1).ravel()


def _excess(field: PointField, x: Array, y: Array) -> Array:
    """Deciding less critical temperature [K] by member, load and velocity; NaN if not known."""
    places = (axis.ravel() for axis in np.meshgrid(y, x, indexing="ij"))
    here = field.temperatures(*places)
    return np.reshape(here.values - here.critical, (-1, len(y), len(x)))


def _shade_verdicts(
    axes: Axes, ds: xr.Dataset, field: PointField, x: Array, y: Array, excess: Array
) -> list[Artist]:
    """Shade where the next run is mild, severe, or neither is decided, as a margin says it."""
    is_told = np.isfinite(excess).all(axis=0)
    bounds = verdict_plane(field, y, x, model_error(ds, field))
    lowest, highest = (np.where(is_told, bound, np.nan) for bound in bounds)
    legend, (mild, _, severe) = list[Artist](), DECIDED
    between = np.minimum(highest - mild, severe - lowest)
    for values, levels, gid, look in (
        (highest, [-1.0, mild], "mild region", {"colors": [TINTS["mild"]]}),
        (lowest, [severe, 2.0], "severe region", {"colors": [TINTS["severe"]]}),
        (between, [0.0, 1.0], "not decided", {"colors": [TINTS["band"]], "alpha": 0.6}),
    ):
        if ((values > levels[0]) & (values < levels[1])).any():
            axes.contourf(x, y, values, levels, zorder=0, **look).set_gid(gid)  # below the grid
            if gid == "not decided":
                legend.append(Patch(label="next run not decided", **style.BAND))
    name_regions(axes, x, y, highest <= mild, lowest >= severe)
    return legend


def _shade_surfaces(axes: Axes, x: Array, y: Array, excess: Array) -> list[Artist]:
    """Shade where wear is severe on some surfaces, but not on nearly all."""
    if len(excess) == 1:
        return []
    low, high = (np.quantile(excess, share, axis=0) for share in (BAND[0], BAND[-1]))
    inside = np.minimum(high, -low)
    if not (inside > 0).any():
        return []
    for edge in (low, high):
        zero_line(axes, x, y, edge, "surface band edge", GREEN, lw=style.THIN)
    look: dict[str, Any] = {"alpha": style.FAINT}
    axes.contourf(x, y, inside, [0.0, np.inf], colors=[GREEN], **look).set_gid("surface band")
    text = f"{100 * BAND[0]:g} to {100 * BAND[-1]:g} % of {len(excess)} surfaces"
    return [Patch(fc=GREEN, ec=GREEN, lw=style.THIN, label=text, **look)]


def _friction_lines(
    axes: Axes, ds: xr.Dataset, field: PointField, x: Array, y: Array
) -> list[Artist]:
    """Draw the boundaries at the lowest and the highest friction measured."""
    band = stored_sweep(ds).about.friction_band
    if not band or min(band) == max(band):
        return []
    look: dict[str, Any] = {"color": GREY, "lw": style.THIN, "ls": "--"}
    drawn = []
    for friction in (min(band), max(band)):
        under = field.under(replace(field.conditions, friction=float(friction)))
        plane = np.median(_excess(under, x, y), axis=0)
        drawn.append(zero_line(axes, x, y, plane, "band edge", **look))
    label = f"transition at friction {min(band):g} and {max(band):g}"
    return [Line2D([], [], label=label, **look)] * any(drawn)


def _mark_points(axes: Axes, ds: xr.Dataset) -> list[Artist]:
    """Mark the points; over several surfaces, by those on which the point is done."""
    conditions = read_conditions(ds)
    r, limit = decisive_rise(ds, conditions), rise_limit(conditions)
    hot, cold = (_any_surface(of(r, limit)) for of in (Criterion.is_severe, Criterion.is_mild))
    failed = ~(hot | cold) & _any_surface(ds["status"] != PENDING)
    pending = ~(hot | cold) & ~failed & _any_surface(asked(ds))
    usual = rcParams["lines.markersize"]
    kinds: list[tuple[str, xr.DataArray, dict[str, Any]]] = [
        ("mild wear, computed", cold & ~hot, {"marker": "o", "mfc": "white", "mec": BLUE}),
        ("severe wear, computed", hot & ~cold, {"marker": "s", "mfc": VERMILION, "mec": "none"}),
        ("severe on some surfaces", hot & cold, {"marker": "s", "mfc": "white", "mec": VERMILION}),
        ("failed", failed, {"marker": "x", "mec": BLACK}),
        ("pending", pending, {"marker": "o", "mfc": GREY, "mec": "none"}),
        ("carries a warning", _any_surface(r.copy(data=warning_flags(results(ds)) != 0)),
         {"marker": "o", "mfc": "none", "mec": BLACK, "ms": style.BIG * usual}),
    ]  # fmt: skip
    look_of_all = {"ls": "none", "ms": usual * (0.5 if failed.size > _MANY else 0.8)}
    legend = list[Artist]()
    for label, where, look in kinds:
        rows, columns = np.nonzero(where.values)
        if rows.size:
            places = ds["velocity"].values[columns], ds["load"].values[rows]
            legend += axes.plot(
                *places, label=label, gid=label, mew=style.THIN, **look_of_all | look
            )
    return legend


def _any_surface(holds: xr.DataArray) -> xr.DataArray:
    """Points by load and velocity at which something holds on any surface."""
    return holds.any([dim for dim in holds.dims if dim not in PLANE]).transpose(*PLANE)


def _mark_transition(axes: Axes, ds: xr.Dataset, field: PointField, axis: str) -> list[Artist]:
    """Mark the transition of a sweep with a single load or velocity, or say why there is none."""
    last = {name: ds[name].values[-1:] for name in PLANE}
    found = field.transitions(axis, last["load"], last["velocity"])
    crossings = found.first[np.isfinite(found.first)]
    (outcome,) = found.worded(axis)
    gid, label = ("boundary", "computed transition")
    if not crossings.size:
        gid, label = "no boundary", f"no transition: {outcome}"
    places = {name: np.full(crossings.size, end) for name, end in last.items()} | {axis: crossings}
    (mark,) = axes.plot(
        places["velocity"], places["load"], ls="none", marker="|" if axis == "velocity" else "_",
        color=BLACK, mew=style.THICK, ms=26, gid=gid, label=label,
    )  # fmt: skip
    return [mark]
