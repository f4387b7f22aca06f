"""The transition diagram: mild and severe wear in the plane of velocity and load.

It draws only variables of `pipeline.margin`, `pipeline.boundary` and `pipeline.points`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps, rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke
from scipy.ndimage import distance_transform_edt

import pipeline
from pipeline.answers.answer_lines import not_included_lines, withheld_lines
from pipeline.answers.boundary_lines import error_lines, ruling_lines
from pipeline.answers.case_results import CaseResults
from pipeline.answers.readable import attribute_texts
from pipeline.answers.results import cases_of, sweep_of
from pipeline.answers.scene_wording import value_words
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.constants import DECIDED
from pipeline.figures import style
from pipeline.figures.fields_figure import QuantityLike, select_realization, wanted_values
from pipeline.figures.style import BLACK, BLUE, GREY, OPERATING, TINTS, VERMILION
from pipeline.figures.tests_figure import UNDECIDED_LABEL, mark_tests, velocities_at_friction
from pipeline.messages import split_notes
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from tribo import InputError, lubrication_regime
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array

_FIGURE_SIZE = 8.0, 5.6  # width and height of a diagram [in]
_COLOUR_MAP_END = 0.8  # end of the colour map used for several cases
_MIN_NODES = 96, 48  # least numbers of velocities and loads of the drawn grid
_MAX_LOG_RATIO = 50.0  # largest |y| of a figure
_EDGE_OFFSET = 1e-6  # distance of a probability from the limit of a region
_DOT_SIZE = 0.6  # size of the mark of a simulated point over that of other marks
_ERROR_COLOUR = "#C8C8C8"
_REGION_NAMES = (
    (MILD, "mild wear\n(I and II)", BLUE),
    (SEVERE, "severe adhesive wear\n(III* and III)", VERMILION),
)
"""Name of each region and its colour, by verdict."""
COMPUTED = "computed boundary, numerical error"
"""Label in legends."""
_LABEL_WIDTH = 0.3  # width of the numbers of an operating point over that of a figure
_EDGE_HEIGHT = 0.08  # distance from an edge within which numbers would cross it, over the height
_MAX_LABELLED = 6  # most operating points that are labelled with their numbers
_NAME_ASPECT = 3.0  # width of a name over its height
_MIN_CLEARANCE = 0.1  # least distance of a name from the edge of its region, over the width

Legend = dict[str, Any]
"""Handle of each entry of a legend, by its label; a tuple has several handles side by side."""


@style.house_style
def diagram(
    ds: xr.Dataset,
    conditions: Mapping[str, Any],
    realization: int | None = None,
    log: bool = False,
    load: QuantityLike = None,
    velocity: QuantityLike = None,
) -> Figure:
    """Draw the transition diagram.

    The load–velocity plane is shaded by the verdict of `pipeline.margin`. The heavy line is the
    boundary with tests, if there are any; the computed boundary has a band of numerical error.
    Dots are simulated points. Tests at another friction than that of the boundary are also drawn as
    they would lie at its friction, with open marks. `realization`, the seed of a surface, chooses
    one of several surface realizations. Of several cases only the boundaries are drawn, each in its
    own colour. `log` makes both axes logarithmic. The operating point of `load` and `velocity`, in
    SI or as text with a unit, is marked; lists of equal length are pairs.
    """
    operating_points = _operating_points(load, velocity)
    _require_plane(ds)
    ds = select_realization(ds, realization)
    case = cases_of(ds)[0]
    is_plane = min(len(case.loads), len(case.velocities)) > 1
    figure, axes = style.canvas(_FIGURE_SIZE)
    boundary = pipeline.boundary(ds, **conditions)
    case_dimensions = [str(dim) for dim in boundary["critical_velocity"].dims if dim not in PLANE]
    if case_dimensions and not is_plane:
        raise InputError(
            "the diagram of several cases needs at least two loads and two velocities; irg "
            "boundary prints their transitions"
        )
    bulk = float(boundary["bulk_temperature"].values.flat[0])
    friction = float(boundary["friction"].values.flat[0])
    has_line = is_plane and not case_dimensions and friction > 0
    moved = velocities_at_friction(ds, case, conditions, friction) if has_line else {}
    tests, tests_entry, caption = mark_tests(axes, case, bulk, friction, moved)
    marked = [*tests, *operating_points]
    lines = [f"conditions: {text}" for text in attribute_texts(boundary, "conditions")]
    if case_dimensions:
        x, y, plane = _plane(ds, case, conditions)
        legend = _draw_cases(axes, plane, x, y, case_dimensions)
        by = " and ".join(case_dimensions).replace("_", " ")
        lines = [f"boundary by {by}; {lines[0]}" if len(lines) == 1 else f"boundary by {by}"]
    elif is_plane:
        x, y, plane = _plane(ds, case, conditions)
        legend = _shade(axes, plane, x, y) | _draw_lines(axes, case, plane, x, y)
        _name_regions(axes, x, y, plane["verdict"].values, marked)
        lines += _captions(case, boundary, x, y, bulk)
        caption[:0] = _mark_simulated(axes, ds, conditions)
    else:
        legend = _mark_points(axes, ds, case, conditions)
        caption[:0] = _mark_simulated(axes, ds, conditions, has_dots=False)
    _set_axes(axes, case, marked, log)
    _mark_operating_points(axes, operating_points)
    title = style.as_text(sweep_of(ds).title)
    if realization is not None:
        title = f"{title}, surface realization {realization}"
    style.write_title(axes, title)
    legend |= tests_entry
    lines.append("; ".join(caption))
    lines += [*not_included_lines(boundary)][:1]
    lines += split_notes(attribute_texts(boundary, "notes"))[:1]
    style.legend_below(
        figure, 2 if len(legend) == 4 else 3, handles=[*legend.values()], labels=[*legend] or None,
        caption="\n".join(lines), handler_map={tuple: HandlerTuple(ndivide=None)},
    )  # fmt: skip
    return figure


def _require_plane(ds: xr.Dataset) -> None:
    """Raise an `InputError` if each row of a sweep has its own load and velocity."""
    if any(sweep_of(ds).case_table.column(name) for name in PLANE):
        raise InputError(
            "each row of the sweep has its own load and velocity, so there is no plane of them; "
            "irg margin prints its rows"
        )


def _operating_points(load: QuantityLike, velocity: QuantityLike) -> list[OperatingPoint]:
    """Operating points in SI, from loads and velocities that are pairs."""
    loads, velocities = wanted_values("load", load), wanted_values("velocity", velocity)
    if len(loads) != len(velocities):
        raise InputError(
            f"load and velocity go together, as pairs; {len(loads)} of load and "
            f"{len(velocities)} of velocity are given"
        )
    return [*zip(loads, velocities, strict=True)]


def _set_axes(axes: Axes, case: CaseResults, marked: Sequence[OperatingPoint], log: bool) -> None:
    """Scale the axes to the sweep and to what is marked, and label them."""
    if log:
        axes.set(xscale="log", yscale="log")
        style.plain_numbers(axes)
    for limit, ends, values in (
        (axes.set_ylim, case.loads[[0, -1]], [point[0] for point in marked]),
        (axes.set_xlim, case.velocities[[0, -1]], [point[1] for point in marked]),
    ):
        if ends[0] < ends[1]:
            limit(min([ends[0], *values]), max([ends[1], *values]))
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")


def _plane(
    ds: xr.Dataset, case: CaseResults, conditions: Mapping[str, Any]
) -> tuple[Array, Array, xr.Dataset]:
    """Velocities, loads, and the answers on this grid."""
    x, y = map(_refined, (case.velocities, case.loads), _MIN_NODES)
    grid_axes = xr.DataArray(y, dims="load"), xr.DataArray(x, dims="velocity")
    return x, y, pipeline.margin(ds, *grid_axes, **conditions).transpose(..., *PLANE)


def _refined(points: Array, count: int) -> Array:
    """Fine axis with at least `count` values, equally many between any two `points`."""
    division = max(2, math.ceil(count / (len(points) - 1)))
    return np.append(
        np.linspace(points[:-1], points[1:], division, False, axis=1).ravel(), points[-1]
    )


def _captions(
    case: CaseResults, boundary: xr.Dataset, x: Array, y: Array, bulk: float
) -> Iterable[str]:
    """Yield lines on errors, on the oil film, and on verdicts that tests rule out."""
    yield from error_lines(boundary)
    if oil := find_lubrication(case.sweep.scene, case.sweep.lubricant):
        film = oil.film_parameter(y[:, None], x, bulk)
        ends = float(film.min()), float(film.max())
        regimes = " to ".join(dict.fromkeys(map(lubrication_regime, ends)))
        yield f"film parameter Λ {ends[0]:.2f} to {ends[1]:.2f}: {regimes}"
    yield from ruling_lines(boundary)
    yield from withheld_lines(boundary)


def _shade(axes: Axes, plane: xr.Dataset, x: Array, y: Array) -> Legend:
    """Shade the plane by verdict, and hatch what is outside the model."""
    verdict = plane["verdict"].values
    low, high = plane["probability_low"].values, plane["probability_high"].values
    mild, _, severe = DECIDED
    # The edge of a region is the contour of its probability; a test may end the region at a node.
    highest = np.where(verdict == MILD, high, np.maximum(high, mild + _EDGE_OFFSET))
    lowest = np.where(verdict == SEVERE, low, np.minimum(low, severe - _EDGE_OFFSET))
    is_outside, legend = (verdict == OUTSIDE).astype(float), Legend()
    for values, levels, gid in (
        (highest, (-1.0, mild), "mild"),
        (highest, (mild, 2.0), "undecided"),
        (lowest, (severe, 2.0), "severe"),  # drawn over the undecided region
    ):
        if ((values > levels[0]) & (values < levels[1])).any():
            region = axes.contourf(x, y, values, levels, colors=[TINTS[gid]], zorder=0)
            region.set_gid(f"{gid} region")
    if is_outside.any():
        look: dict[str, Any] = {"colors": ["white"], "hatches": ["///"], "zorder": 0.5}
        hatched = axes.contourf(x, y, is_outside, [0.5, 1.5], **look)
        hatched.set(gid="outside", edgecolor=GREY, linewidth=[0.0])
        legend["outside the model (oil film)"] = Patch(fc="none", ec=GREY, hatch="///")
    if (verdict == UNDECIDED).any():
        legend[UNDECIDED_LABEL] = Patch(**style.BAND)
    return legend


def _draw_lines(axes: Axes, case: CaseResults, plane: xr.Dataset, x: Array, y: Array) -> Legend:
    """Draw the boundary with tests, as computed with its numerical error, and by friction.

    The heavy line is the answer: with tests, if there are any.
    """
    legend, is_inside = Legend(), plane["verdict"] != OUTSIDE
    has_tests = False
    if plane.attrs["tests"]:
        probability_excess = plane["probability"].where(is_inside).values - DECIDED[1]
        has_tests = zero_line(
            axes, x, y, probability_excess, "boundary with tests", **style.BOUNDARY
        )
    if has_tests:
        legend["boundary with tests (50 %)"] = Line2D([], [], **style.BOUNDARY)
    severity = plane["log_rise_ratio"].clip(-_MAX_LOG_RATIO, _MAX_LOG_RATIO).where(is_inside).values
    look = style.BOUNDARY | ({"lw": style.THIN} if has_tests else {})
    if zero_line(axes, x, y, severity, "boundary", **look):
        distance = abs(plane["temperature_margin"]) - plane["temperature_error"].fillna(0.0)
        drawn_distance = distance.where(is_inside).values
        if (drawn_distance < 0).any():
            low = np.nanmin(drawn_distance) - 1.0
            axes.contourf(x, y, drawn_distance, [low, 0.0], colors=[_ERROR_COLOUR]).set_gid("error")
        band = [Stroke(linewidth=9, foreground=_ERROR_COLOUR), Normal()]
        legend[COMPUTED] = Line2D([], [], path_effects=band, **look)
    frictions = case.sweep.base.friction_band or (0.0, 0.0)
    look = {"color": GREY, "lw": style.THIN, "ls": "--"}
    critical = plane["critical_friction"].where(is_inside).values
    ends = frictions if frictions[0] < frictions[1] else ()
    is_drawn = [zero_line(axes, x, y, critical - friction, "friction", **look) for friction in ends]
    if any(is_drawn):
        legend[f"computed at friction {frictions[0]:g} and {frictions[1]:g}"] = Line2D(
            [], [], **look
        )
    return legend


def zero_line(
    axes: Axes, x: Array, y: Array, plane: Array, gid: str, color: Any = BLACK, **look: Any
) -> bool:
    """Draw the contour on which `plane` (load, velocity) is 0; return False if it is empty.

    `x` are velocities [m/s], `y` loads [N]. `gid` is the contour's name in an SVG file, and `look`
    has properties of Matplotlib's lines.
    """
    if not ((plane < 0).any() and (plane > 0).any()):
        return False
    axes.contour(x, y, plane, [0.0], colors=[color]).set(gid=gid, **look)
    return True


def _name_regions(
    axes: Axes, x: Array, y: Array, verdicts: Array, marked: Iterable[OperatingPoint]
) -> None:
    """Write the name of each region where it is widest and unmarked; none if it is too narrow."""
    is_free = np.ones(verdicts.shape, bool)
    for load, velocity in marked:
        is_free[np.abs(y - load).argmin(), np.abs(x - velocity).argmin()] = False
    min_clearance = _MIN_CLEARANCE * (_FIGURE_SIZE[0] / style.wanted_width(_FIGURE_SIZE[0])) ** 0.5
    for verdict, name, colour in _REGION_NAMES:
        # The edges of the diagram are edges of its regions, too.
        padded = np.pad((verdicts == verdict) & is_free, 1)
        clearance = distance_transform_edt(padded, sampling=(_NAME_ASPECT / len(y), 1 / len(x)))[
            1:-1, 1:-1
        ]
        row, column = np.unravel_index(int(clearance.argmax()), clearance.shape)
        if clearance[row, column] > min_clearance:
            axes.text(
                x[column], y[row], name, ha="center", va="center", fontweight="bold",
                color=colour, gid="region", path_effects=style.HALO, zorder=3,
            )  # fmt: skip


def _mark_points(
    axes: Axes, ds: xr.Dataset, case: CaseResults, conditions: Mapping[str, Any]
) -> Legend:
    """Mark the points of a single load or velocity, open where they are mild."""
    plane_axes = (
        xr.DataArray(case.loads, dims="load"),
        xr.DataArray(case.velocities, dims="velocity"),
    )
    y = pipeline.margin(ds, *plane_axes, **conditions)["log_rise_ratio"].transpose(*PLANE).values
    legend = Legend()
    for gid, is_marked, face in (("mild", y <= 0, "white"), ("severe", y > 0, VERMILION)):
        rows, columns = np.nonzero(is_marked)
        if rows.size:
            look: dict[str, Any] = {"mfc": face, "mec": VERMILION, "gid": gid}
            (marks,) = axes.plot(case.velocities[columns], case.loads[rows], "o", **look)
            legend[f"{gid}, computed"] = marks
    return legend


def _mark_simulated(
    axes: Axes, ds: xr.Dataset, conditions: Mapping[str, Any], has_dots: bool = True
) -> Iterable[str]:
    """Mark simulated points (`has_dots`), and those that are pending or failed; yield captions."""
    state = pipeline.points(ds, **conditions)["state"]
    is_unfinished, is_done = (
        state.isin(kinds).any("realization").transpose(*PLANE).values
        for kinds in (("failed", "pending"), ("mild", "severe"))
    )
    is_simulated = is_done & ~is_unfinished & has_dots
    size = _DOT_SIZE * rcParams["lines.markersize"]
    looks: dict[str, tuple[Array, dict[str, Any]]] = {
        "simulated": (is_simulated, {"marker": ".", "ms": size, "zorder": 2.5}),
        "lacking": (is_unfinished, {"marker": "x"}),
    }
    for gid, (is_marked, look) in looks.items():
        rows, columns = np.nonzero(is_marked)
        if rows.size:
            coordinates = state["velocity"].values[columns], state["load"].values[rows]
            axes.plot(
                *coordinates, ls="none", color=BLACK, mec=BLACK, gid=gid, clip_on=False, **look
            )
    if is_simulated.any():
        yield "dots: simulated points"
    if is_unfinished.any():
        yield f"×: {is_unfinished.sum()} points are pending or failed"


def _draw_cases(axes: Axes, plane: xr.Dataset, x: Array, y: Array, dims: Sequence[str]) -> Legend:
    """Draw the boundary of each case in another colour; return the entries of the legend."""
    planes = plane["log_rise_ratio"].clip(-_MAX_LOG_RATIO, _MAX_LOG_RATIO).stack(line=dims)
    planes = planes.transpose("line", *PLANE)
    shades = colormaps["viridis"](np.linspace(0.0, _COLOUR_MAP_END, planes.sizes["line"]))
    legend = Legend()
    for case_plane, shade in zip(planes, shades, strict=True):
        name = ", ".join(_name(plane[dim], case_plane[dim].item()) for dim in dims)
        look: dict[str, Any] = style.BOUNDARY | {"color": shade}
        if not zero_line(axes, x, y, case_plane.values, f"boundary {name}", **look):
            name, look = f"{name}: no boundary in the sweep", {"ls": "none"}
        legend[name] = Line2D([], [], **look)
    return legend


def _name(axis: xr.DataArray, value: Any) -> str:
    """A value of a varied entry or condition, such as "1 mm" or "friction 0.1"."""
    text = value_words(axis, value)
    return f"{axis.name} {text}" if text == f"{value:g}" else text


def _mark_operating_points(axes: Axes, points: Sequence[OperatingPoint]) -> None:
    """Mark operating points; write the numbers of a few on the side away from the boundary."""
    look: dict[str, Any] = {"mfc": OPERATING, "mec": "white", "zorder": 5, "clip_on": False}
    for load, velocity in points:
        size = 2.4 * rcParams["lines.markersize"]
        axes.plot(velocity, load, "P", ms=size, gid="operating point", **look)
        if len(points) > _MAX_LABELLED:
            continue
        x_fraction, y_fraction = axes.transAxes.inverted().transform(
            axes.transData.transform((velocity, load))
        )
        # Boundaries fall from the upper left to the lower right.
        is_low = x_fraction + y_fraction < 1
        to_left = x_fraction > _LABEL_WIDTH if is_low else x_fraction > 1 - _LABEL_WIDTH
        is_below = y_fraction > 1 - _EDGE_HEIGHT or (is_low and y_fraction > _EDGE_HEIGHT)
        axes.annotate(
            f"{load:.4g} N, {velocity:.4g} m/s", (velocity, load),
            (-8 if to_left else 8, -6 if is_below else 6), textcoords="offset points",
            color=OPERATING, ha="right" if to_left else "left", va="top" if is_below else "bottom",
            fontweight="bold", path_effects=style.HALO, zorder=5,
        )  # fmt: skip
