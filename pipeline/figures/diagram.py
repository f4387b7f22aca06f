"""The transition diagram: mild and severe wear in the plane of velocity and load."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.ndimage import maximum_filter, minimum_filter

from pipeline import extras
from pipeline.analysis.boundary import BAND, boundary_under
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
from pipeline.analysis.decisive import decisive_rise, refined
from pipeline.analysis.field import point_field
from pipeline.analysis.laboratory import laboratory_tests, model_error
from pipeline.analysis.margin import DECIDED, verdict_plane
from pipeline.analysis.scenes import scenes, value_text
from pipeline.analysis.transition import BEYOND, in_words, outcomes
from pipeline.analysis.warned_points import warnings_of
from pipeline.figures import style
from pipeline.figures.overlays import (
    film_lines,
    isoline,
    mark_own_transitions,
    mark_tests,
    name_regions,
    reachable_tests,
)
from pipeline.figures.row_margins import draw_rows
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, TINTS, VERMILION
from pipeline.quantities import UNITS
from pipeline.store.schema import PENDING, PLANE
from pipeline.sweep.about import judged_by
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import named
from pipeline.sweep.severity import rise_limit
from tribo import Criterion, InputError
from tribo.types import Array, Mask

_OF_SAMPLES = "the diagram of samples shows probabilities; leave out the surface and ax"
_OF_A_PLANE = "each row has its own load and velocity, so there is no plane; leave out log"
_FAR = ", far"  # ends the mark (gid) of points whose neighbours are alike
_RESOLUTION = 240
_COLOURS, _LIGHTEST = colormaps["viridis"], 0.85


@style.house_style
def diagram(
    ds: xr.Dataset, realization: int | None = None, log: bool = False, ax: Axes | None = None
) -> Figure:
    """Draw the transition diagram; of samples, the probability of severe wear; of rows, margins.

    Over several surfaces the boundary is that of the median one, in a band from the tenth to the
    ninetieth of a hundred. It lies on the plane interpolated between the computed points.
    """
    kind = sweep_kind(ds)
    if kind is Kind.SAMPLES:
        if realization is not None or ax is not None:
            raise InputError(_OF_SAMPLES)
        drawn: Figure = extras.module("uncertain", "figures").draw_probability(ds, log)
        return drawn
    ds = select_surface(ds, realization)
    if kind is Kind.PLACES:
        if log:
            raise InputError(_OF_A_PLANE)
        return draw_rows(ds, ax)
    return _scenes_diagram(ds, log, ax) if entry_dims(ds) else _scene_diagram(ds, log, ax)


def _scene_diagram(ds: xr.Dataset, log: bool, ax: Axes | None) -> Figure:
    """Draw the diagram of one scene, the boundary that of the median of its surfaces."""
    conditions = read_conditions(ds)
    limit, beyond = rise_limit(conditions), _range_notes(ds, conditions)
    if log:
        ds = ds.sel(velocity=ds["velocity"] > 0)
    figure, axes = style.canvas(ax)
    legend: list[Artist] = []
    sizes = ds.sizes["load"], ds.sizes["velocity"]
    is_plane = min(sizes) > 1
    if is_plane:
        planes = _planes(ds, conditions)
        plane = _quantile(planes)
        legend += _regions(axes, ds)
        if isoline(axes, plane, limit, "boundary", **style.BOUNDARY):
            label = "computed transition" + (", median" if planes.sizes["row"] > 1 else "")
            legend.append(Line2D([], [], label=label, **style.BOUNDARY))
        legend += beyond
        legend += _surface_band(axes, planes, limit)
        legend += _friction_lines(axes, ds, conditions)
        legend += film_lines(axes, ds, conditions)
    elif max(sizes) > 1:
        legend += _line_transitions(axes, ds, conditions)
    legend += _points(axes, ds, conditions)
    tests, beyond_figure = reachable_tests(ds, laboratory_tests(ds))
    legend += mark_tests(axes, tests, conditions.bulk_temperature, _own_bulk(ds))
    if is_plane:
        legend += mark_own_transitions(axes, ds, tests, conditions)
    legend += beyond_figure
    _frame(axes, ds, log)
    title = judged_by([conditions])
    if is_plane:
        name_regions(axes, plane, limit, ds["load"].values, tests)
        title += f"\nthe model's own error: {model_error(ds, point_field(ds)).worded}"
    if any(str(mark.get_gid()).endswith(_FAR) for mark in axes.lines):
        title += "\npale: points whose neighbours have the same wear"
    style.legend_below(figure, ax, handles=legend, title=title)
    return figure


def _own_bulk(ds: xr.Dataset) -> float:
    """Bulk temperature of the scene [K], which tests have that give none."""
    return scene_sweep(ds).conditions.bulk_temperature


def _frame(axes: Axes, ds: xr.Dataset, log: bool) -> None:
    """Set the scales, margins, labels and title of a diagram."""
    axes.use_sticky_edges = False  # those of the regions would leave no margin
    axes.margins(0.04)
    if log:
        axes.set(xscale="log", yscale="log")
        style.plain_numbers(axes)
    style.write_title(axes, ", ".join([style.title_of(ds), *named(drawn_row(ds))]))
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")


def _scenes_diagram(ds: xr.Dataset, log: bool, ax: Axes | None) -> Figure:
    """Draw the boundary of each scene of a sweep over entries, the median of its surfaces."""
    if min(ds.sizes["load"], ds.sizes["velocity"]) < 2:
        raise InputError(
            "the diagram of several scenes takes two loads and two velocities or more; irg "
            "boundary prints their transitions"
        )
    figure, axes = style.canvas(ax)
    legend: list[Artist] = []
    several = [(scene, read_conditions(scene)) for scene in scenes(ds)]
    shades = _COLOURS(np.linspace(0.0, _LIGHTEST, len(several)))
    for (scene, judged), shade in zip(several, shades, strict=True):
        plane = _quantile(_planes(scene.sel(velocity=scene["velocity"] > 0), judged))
        name = ", ".join(value_text(ds[path], scene[path].item()) for path in entry_dims(ds))
        look, label = style.BOUNDARY | {"color": shade}, name
        if not isoline(axes, plane, rise_limit(judged), f"boundary {name}", **look):
            label, look = f"{name}: no transition computed", {"ls": "none"}
        legend.append(Line2D([], [], label=label, **look))
    tests, beyond_figure = reachable_tests(ds, laboratory_tests(ds))
    bulk = several[0][1].bulk_temperature
    legend += [*mark_tests(axes, tests, bulk, _own_bulk(several[0][0])), *beyond_figure]
    _frame(axes, ds, log)
    entries = " and ".join(entry_dims(ds)).replace(".", " ").replace("_", " ")
    title = f"transition to severe wear, by {entries}"
    if len({judged for _, judged in several}) == 1:
        title += f"; {judged_by([judged])}"
    errors = dict.fromkeys(model_error(scene, point_field(scene)).worded for scene, _ in several)
    title += f"\nthe model's own error: {' or '.join(errors)}"
    style.legend_below(figure, ax, handles=legend, title=title)
    return figure


def _planes(ds: xr.Dataset, conditions: Conditions) -> xr.DataArray:
    """Decisive rise over the plane, on each surface that has results."""
    # A sweep that only follows the boundary knows the plane elsewhere as mild or severe alone.
    boundary_parts = not asked(ds).all()
    planes = refined(
        decisive_rise(ds, conditions), _RESOLUTION, conditions, continued=boundary_parts
    )
    others = [dim for dim in planes.dims if dim not in PLANE]
    planes = planes.stack(row=others) if others else planes.expand_dims("row")
    finite_planes = planes.dropna("row", how="all")
    return finite_planes if finite_planes.size else planes


def _quantile(planes: xr.DataArray, share: float = 0.5) -> xr.DataArray:
    """The plane of the median surface, or of another quantile of the surfaces."""
    return planes.quantile(share, "row", skipna=False)


_ACROSS = {"load": 48, "velocity": 96}  # places at least at which a verdict is asked for
_INSIDE = 1e-4  # of an interval between points, at whose ends the error is smaller


def _regions(axes: Axes, ds: xr.Dataset) -> list[Artist]:
    """Shade where the next run is mild, severe, or neither is decided, as a margin says it."""
    field = point_field(ds)
    x, y = (_places_between(ds[name].values, _ACROSS[name]) for name in ("velocity", "load"))
    bounds = verdict_plane(field, y, x, model_error(ds, field))
    here = field.temperatures(*(axis.ravel() for axis in np.meshgrid(y, x, indexing="ij")))
    is_told = np.reshape([not reason for reason in here.reasons], bounds[0].shape)
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
    return legend


def _places_between(points: Array, least: int) -> Array:
    """Places from the first point to the last, among them both sides of each point."""
    begins, ends = points[:-1], points[1:]
    inside, parts = _INSIDE * (ends - begins), max(2, math.ceil(least / len(begins)))
    return np.linspace(begins + inside, ends - inside, parts, axis=1).ravel()


def _filled(
    axes: Axes, plane: xr.DataArray, levels: list[float], colours: list[str], gid: str, **look: Any
) -> None:
    """Fill what lies between levels of a plane."""
    x, y = plane["velocity"], plane["load"]
    axes.contourf(x, y, plane, levels, colors=colours, **look).set_gid(gid)


def _range_notes(ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Say at which loads transitions lie beyond what was computed."""
    field, loads = point_field(ds, conditions), ds["load"].values
    found = field.transitions("velocity", loads, field.ends["velocity"][1])
    is_beyond = np.isin(found.outcome, BEYOND).any(axis=0)
    loads = loads[is_beyond]
    if not loads.size:
        return []
    span = " to ".join(f"{load:g}" for load in dict.fromkeys((loads[0], loads[-1])))
    label = f"beyond what was computed: at {loads.size} of {is_beyond.size} loads, {span} N"
    return [Line2D([], [], ls="none", label=label)]


def _friction_lines(axes: Axes, ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Draw the boundaries at the lowest and the highest friction measured."""
    band = stored_sweep(ds).about.friction_band
    if not band or min(band) == max(band):
        return []
    look: dict[str, Any] = {"color": GREY, "lw": style.THIN, "ls": "--"}
    drawn = []
    for friction in (min(band), max(band)):
        judged = replace(conditions, friction=float(friction))
        plane = _quantile(_planes(ds, judged))
        drawn.append(isoline(axes, plane, rise_limit(judged), "band edge", **look))
    if not any(drawn):
        return []
    return [Line2D([], [], label=f"transition at friction {min(band):g} and {max(band):g}", **look)]


def _surface_band(axes: Axes, planes: xr.DataArray, limit: float) -> list[Artist]:
    """Shade where wear is severe on some surfaces, but not on nearly all."""
    if planes.sizes["row"] == 1:
        return []
    low, high = (_quantile(planes, share) for share in (BAND[0], BAND[-1]))
    inside = ((low <= limit) & (high > limit)).astype(float)
    if not inside.any():
        return []
    for edge in (low, high):
        isoline(axes, edge, limit, "surface band edge", GREEN, lw=style.THIN)
    _filled(axes, inside, [0.5, 1.5], [GREEN], "surface band", alpha=style.FAINT)
    text = f"{100 * BAND[0]:g} to {100 * BAND[-1]:g} % of {planes.sizes['row']} surfaces"
    return [Patch(fc=GREEN, ec=GREEN, lw=style.THIN, alpha=style.FAINT, label=text)]


def _points(axes: Axes, ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Mark the points; over several surfaces, by those on which the point is done."""
    r, limit = decisive_rise(ds, conditions), rise_limit(conditions)
    hot, cold = (_any_surface(of(r, limit)) for of in (Criterion.is_severe, Criterion.is_mild))
    done = hot | cold
    failed = ~done & _any_surface(ds["status"] != PENDING)
    pending = ~done & ~failed & _any_surface(asked(ds))
    kinds: list[tuple[str, xr.DataArray, dict[str, Any]]] = [
        ("mild wear, computed", cold & ~hot, {"marker": "o", "mfc": "white", "mec": BLUE}),
        ("severe wear, computed", hot & ~cold, {"marker": "s", "mfc": VERMILION, "mec": "none"}),
        ("severe on some surfaces", hot & cold, {"marker": "s", "mfc": "white", "mec": VERMILION}),
        ("failed", failed, {"marker": "x", "mec": BLACK}),
        ("pending", pending, {"marker": "o", "mfc": GREY, "mec": "none"}),
        ("carries a warning", _any_surface(warnings_of(ds) != 0),
         {"marker": "o", "mfc": "none", "mec": BLACK, "ms": style.BIG}),
    ]  # fmt: skip
    size = 4.0 if done.size < 1500 else 2.0
    usual: dict[str, Any] = {"ls": "none", "ms": size, "mew": style.THIN}
    far = _far_from_others(hot.values, cold.values)
    legend: list[Artist] = []
    for label, where, look in kinds:
        told = where.values & far if label.endswith("computed") else np.zeros_like(far)
        faint = told, label + _FAR, style.FAINT
        for shown, gid, alpha in ((where.values & ~told, label, 1.0), faint):
            rows, columns = np.nonzero(shown)
            if rows.size:
                places = ds["velocity"].values[columns], ds["load"].values[rows]
                marks = axes.plot(*places, label=label, gid=gid, alpha=alpha, **usual | look)
                legend += marks if gid == label else []
    return legend


def _far_from_others(hot: Mask, cold: Mask) -> Mask:
    """Points whose neighbours all have their kind of wear; none if there is only one kind."""
    if not (hot.any() and cold.any()):
        return np.zeros_like(hot)
    kind = hot.astype(int) - cold.astype(int)
    alike: Mask = maximum_filter(kind, 3) == minimum_filter(kind, 3)
    return alike


def _any_surface(holds: xr.DataArray) -> xr.DataArray:
    """Loads, or points by load and velocity, at which something holds on any surface."""
    return holds.any([dim for dim in holds.dims if dim not in PLANE])


def _line_transitions(axes: Axes, ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Mark the transition of a sweep with a single load or velocity, or say why there is none."""
    axis, other = ("velocity", "load") if ds.sizes["velocity"] > 1 else ("load", "velocity")
    boundaries = boundary_under(ds, conditions)
    crossings = boundaries[f"critical_{axis}"].values.ravel()
    crossings = crossings[np.isfinite(crossings)].tolist()
    if not crossings:
        parts = (f"{part}_at_{other}" for part in ("outcome", "computed_from", "computed_to"))
        lines = zip(*(boundaries[part].values.ravel() for part in parts), strict=True)
        reasons = dict.fromkeys(in_words(outcomes(axis)[c], ends, axis) for c, *ends in lines)
        return [Line2D([], [], ls="none", label=f"no transition: {', '.join(reasons)}")]
    places = {axis: crossings, other: [ds[other].item()] * len(crossings)}
    look: dict[str, Any] = {"ls": "none", "marker": "|" if axis == "velocity" else "_"}
    look |= {"color": BLACK, "mew": style.THICK}
    axes.plot(places["velocity"], places["load"], ms=26, gid="boundary", **look)
    text = f"{crossings[0]:.3g} {UNITS[axis]}" if len(crossings) == 1 else "by surface"
    return [Line2D([], [], ms=style.BIG, label=f"computed transition, {text}", **look)]
