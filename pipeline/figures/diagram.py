"""The transition diagram: mild and severe wear in the plane of velocity and load.

All that it draws are variables of `pipeline.margin`, `pipeline.boundary` and `pipeline.points`.
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
from pipeline.answers import words
from pipeline.answers.results import CaseResults, cases_of, sweep_of
from pipeline.answers.scene_words import value_words
from pipeline.answers.verdict import MILD, OUTSIDE, SEVERE, UNDECIDED
from pipeline.constants import DECIDED
from pipeline.figures import style
from pipeline.figures.fields import QuantityLike, wanted_values
from pipeline.figures.style import BLACK, BLUE, GREY, OPERATING, TINTS, VERMILION
from pipeline.figures.tests import UNDECIDED_LABEL, mark_tests
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from pipeline.words import split_notes
from tribo import InputError, lubrication_regime
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array

_SIZE = 8.0, 5.6  # width and height of a diagram [in]
_LIGHTEST = 0.8  # end of the colour map used for several cases
_NODES = 96, 48  # least number of velocities and loads of the grid that is drawn
_STEEPEST = 50.0  # largest |y| of a figure
_BESIDE = 1e-6  # of a probability, beside the end of a region
_DOT = 0.6  # size of the mark of a simulated point over the usual one
_ERROR: dict[str, Any] = {"color": "#C8C8C8"}
_NAMES = (
    (MILD, "mild wear\n(I and II)", BLUE),
    (SEVERE, "severe adhesive wear\n(III* and III)", VERMILION),
)
"""Name of each region and its colour, by verdict."""
COMPUTED = "computed boundary, numerical error"
"""Label in legends."""
_OF_WORDS = 0.3  # of the width of a figure, for the numbers of an operating point
_OF_EDGE = 0.08  # of the height of a figure, where numbers would lie over an edge
_FEW = 6  # operating points up to which each has its numbers beside
_WIDE = 3.0  # width of a name over its height
_LEAST_ROOM = 0.1  # around a name, over the width of a usual figure

Legend = dict[str, Any]
"""Handle of each entry of a legend, by its label; several side by side are a tuple."""


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
    boundary with tests, if there are any; the computed boundary has a band of numerical error. Dots
    are simulated points. `realization`, the seed of a surface, chooses one of several surface
    realizations. Of several cases only the boundaries are drawn, each in its own colour. `log`
    makes both axes logarithmic. `load` and `velocity` of an operating point are
    marked, in SI or as text with a unit; lists of equal length are pairs.
    """
    places = _places(load, velocity)
    if not {*PLANE} <= {*ds["status"].dims}:
        raise InputError(
            "each row of the sweep has its own load and velocity, so there is no plane of them; "
            "irg margin prints its rows"
        )
    ds = ds if realization is None else ds.sel(realization=[realization])
    case = cases_of(ds)[0]
    is_plane = min(len(case.loads), len(case.velocities)) > 1
    figure, axes = style.canvas(_SIZE)
    found = pipeline.boundary(ds, **conditions)
    several = [str(dim) for dim in found["critical_velocity"].dims if dim not in PLANE]
    if several and not is_plane:
        raise InputError(
            "the diagram of several cases needs at least two loads and two velocities; irg "
            "boundary prints their transitions"
        )
    bulk = float(found["bulk_temperature"].values.flat[0])
    tests, entry, caption = mark_tests(axes, case, bulk)
    marked = [*tests, *places]
    each = [f"conditions: {one}" for one in words.attribute_texts(found, "conditions")]
    legend = Legend()
    if several:
        x, y, plane = _plane(ds, case, conditions)
        legend = _draw_cases(axes, plane, x, y, several)
        by = " and ".join(several).replace("_", " ")
        each = ["; ".join([f"boundary by {by}", *each * (len(each) == 1)])]
    elif is_plane:
        x, y, plane = _plane(ds, case, conditions)
        legend = _shade(axes, plane, x, y) | _draw_lines(axes, case, plane, x, y)
        _name_regions(axes, x, y, plane["verdict"].values, marked)
        each += _captions(case, found, x, y, bulk)
        caption[:0] = _mark_simulated(axes, ds, conditions)
    else:
        legend = _mark_points(axes, ds, case, conditions)
        caption[:0] = _mark_simulated(axes, ds, conditions, has_dots=False)
    _set_axes(axes, case, marked, log)
    _mark_places(axes, places)
    surface = f", of which surface sampling {realization}" * (realization is not None)
    style.write_title(axes, style.as_text(sweep_of(ds).title) + surface)
    legend |= entry
    notes = [*words.not_included_lines(found)][:1] + split_notes(
        words.attribute_texts(found, "notes")
    )[:1]
    style.legend_below(
        figure,
        2 if len(legend) == 4 else 3,
        handles=[*legend.values()],
        labels=[*legend] or None,
        caption="\n".join([*each, "; ".join(caption), *notes]),
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )
    return figure


def _places(load: QuantityLike, velocity: QuantityLike) -> list[OperatingPoint]:
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
    for limit, ends, at in (
        (axes.set_ylim, case.loads[[0, -1]], [place[0] for place in marked]),
        (axes.set_xlim, case.velocities[[0, -1]], [place[1] for place in marked]),
    ):
        if ends[0] < ends[1]:
            limit(min([ends[0], *at]), max([ends[1], *at]))
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")


def _plane(
    ds: xr.Dataset, case: CaseResults, conditions: Mapping[str, Any]
) -> tuple[Array, Array, xr.Dataset]:
    """Velocities, loads, and the answers on this grid."""
    x, y = map(_refined, (case.velocities, case.loads), _NODES)
    at = xr.DataArray(y, dims="load"), xr.DataArray(x, dims="velocity")
    return x, y, pipeline.margin(ds, *at, **conditions).transpose(..., *PLANE)


def _refined(points: Array, count: int) -> Array:
    """Fine axis with at least `count` values, equally many between any two `points`."""
    parts = max(2, math.ceil(count / (len(points) - 1)))
    return np.append(np.linspace(points[:-1], points[1:], parts, False, axis=1).ravel(), points[-1])


def _captions(
    case: CaseResults, found: xr.Dataset, x: Array, y: Array, bulk: float
) -> Iterable[str]:
    """Yield lines on errors, on the oil film, and on tests without a result."""
    yield from words.error_lines(found)
    if oil := find_lubrication(case.sweep.scene, case.sweep.lubricant):
        film = oil.film_parameter(y[:, None], x, bulk)
        ends = float(film.min()), float(film.max())
        regimes = " to ".join(dict.fromkeys(map(lubrication_regime, ends)))
        yield f"film parameter Λ {ends[0]:.2f} to {ends[1]:.2f}: {regimes}"
    yield from words.withheld_lines(found)


def _shade(axes: Axes, plane: xr.Dataset, x: Array, y: Array) -> Legend:
    """Shade the plane by verdict, and hatch what is outside the model."""
    verdict = plane["verdict"].values
    low, high = plane["probability_low"].values, plane["probability_high"].values
    mild, _, severe = DECIDED
    # Within a region its edge is where the probability passes; a test may cut it at a node.
    highest = np.where(verdict == MILD, high, np.maximum(high, mild + _BESIDE))
    lowest = np.where(verdict == SEVERE, low, np.minimum(low, severe - _BESIDE))
    outside, legend = (verdict == OUTSIDE).astype(float), Legend()
    for values, levels, gid in (
        (highest, (-1.0, mild), "mild"),
        (highest, (mild, 2.0), "undecided"),
        (lowest, (severe, 2.0), "severe"),  # upon what is undecided
    ):
        if ((values > levels[0]) & (values < levels[1])).any():
            filled = axes.contourf(x, y, values, levels, colors=[TINTS[gid]], zorder=0)
            filled.set_gid(f"{gid} region")
    if outside.any():
        look: dict[str, Any] = {"colors": ["white"], "hatches": ["///"], "zorder": 0.5}
        hatched = axes.contourf(x, y, outside, [0.5, 1.5], **look)
        hatched.set(gid="outside", edgecolor=GREY, linewidth=[0.0])
        legend["outside the model (oil film)"] = Patch(fc="none", ec=GREY, hatch="///")
    if (verdict == UNDECIDED).any():
        legend[UNDECIDED_LABEL] = Patch(**style.BAND)
    return legend


def _draw_lines(axes: Axes, case: CaseResults, plane: xr.Dataset, x: Array, y: Array) -> Legend:
    """Draw the boundary with tests, as computed with its numerical error, and by friction.

    The heavy line is the answer: with tests, if there are any.
    """
    legend, inside = Legend(), plane["verdict"] != OUTSIDE
    has_tests = False
    if plane.attrs["tests"]:
        above = plane["probability"].where(inside).values - DECIDED[1]
        has_tests = zero_line(axes, x, y, above, "boundary with tests", **style.BOUNDARY)
    if has_tests:
        legend["boundary with tests (50 %)"] = Line2D([], [], **style.BOUNDARY)
    severity = plane["log_rise_ratio"].clip(-_STEEPEST, _STEEPEST).where(inside).values
    look = style.BOUNDARY | ({"lw": style.THIN} if has_tests else {})
    if zero_line(axes, x, y, severity, "boundary", **look):
        apart = abs(plane["temperature_margin"]) - plane["temperature_error"].fillna(0.0)
        beside = apart.where(inside).values
        if (beside < 0).any():
            low = np.nanmin(beside) - 1.0
            axes.contourf(x, y, beside, [low, 0.0], colors=[_ERROR["color"]]).set_gid("error")
        band = [Stroke(linewidth=9, foreground=_ERROR["color"]), Normal()]
        legend[COMPUTED] = Line2D([], [], path_effects=band, **look)
    frictions = case.sweep.base.friction_band or (0.0, 0.0)
    look = {"color": GREY, "lw": style.THIN, "ls": "--"}
    critical = plane["critical_friction"].where(inside).values
    ends = frictions if frictions[0] < frictions[1] else ()
    drawn = [zero_line(axes, x, y, critical - one, "friction", **look) for one in ends]
    if any(drawn):
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
    """Write the name of each region where it is widest, beside marks; none without room."""
    free = np.ones(verdicts.shape, bool)
    for load, velocity in marked:
        free[np.abs(y - load).argmin(), np.abs(x - velocity).argmin()] = False
    least = _LEAST_ROOM * (_SIZE[0] / style.wanted_width(_SIZE[0])) ** 0.5
    for verdict, name, colour in _NAMES:
        padded = np.pad((verdicts == verdict) & free, 1)  # the edges of the diagram bound it, too
        room = distance_transform_edt(padded, sampling=(_WIDE / len(y), 1 / len(x)))[1:-1, 1:-1]
        row, column = np.unravel_index(int(room.argmax()), room.shape)
        if room[row, column] > least:
            axes.text(
                x[column], y[row], name, ha="center", va="center", fontweight="bold",
                color=colour, gid="region", path_effects=style.HALO, zorder=3,
            )  # fmt: skip


def _mark_points(
    axes: Axes, ds: xr.Dataset, case: CaseResults, conditions: Mapping[str, Any]
) -> Legend:
    """Mark the points of a single load or velocity, open where they are mild."""
    at = (xr.DataArray(case.loads, dims="load"), xr.DataArray(case.velocities, dims="velocity"))
    y = pipeline.margin(ds, *at, **conditions)["log_rise_ratio"].transpose(*PLANE).values
    legend = Legend()
    for gid, where, face in (("mild", y <= 0, "white"), ("severe", y > 0, VERMILION)):
        rows, columns = np.nonzero(where)
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
    lacking, done = (
        state.isin(kinds).any("realization").transpose(*PLANE).values
        for kinds in (("failed", "pending"), ("mild", "severe"))
    )
    simulated = done & ~lacking & has_dots
    size = _DOT * rcParams["lines.markersize"]
    looks: dict[str, tuple[Array, dict[str, Any]]] = {
        "simulated": (simulated, {"marker": ".", "ms": size, "zorder": 2.5}),
        "lacking": (lacking, {"marker": "x"}),
    }
    for gid, (where, look) in looks.items():
        rows, columns = np.nonzero(where)
        if rows.size:
            at = state["velocity"].values[columns], state["load"].values[rows]
            axes.plot(*at, ls="none", color=BLACK, mec=BLACK, gid=gid, clip_on=False, **look)
    yield from ["dots: simulated points"] * bool(simulated.any())
    if lacking.any():
        yield f"×: {lacking.sum()} points are pending or failed"


def _draw_cases(axes: Axes, plane: xr.Dataset, x: Array, y: Array, dims: Sequence[str]) -> Legend:
    """Draw the transition of each case in its own colour; return the entries of the legend."""
    planes = plane["log_rise_ratio"].clip(-_STEEPEST, _STEEPEST).stack(line=dims)
    planes = planes.transpose("line", *PLANE)
    shades = colormaps["viridis"](np.linspace(0.0, _LIGHTEST, planes.sizes["line"]))
    legend = Legend()
    for one, shade in zip(planes, shades, strict=True):
        name = ", ".join(_name(plane[dim], one[dim].item()) for dim in dims)
        look: dict[str, Any] = style.BOUNDARY | {"color": shade}
        if not zero_line(axes, x, y, one.values, f"boundary {name}", **look):
            name, look = f"{name}: no boundary in the sweep", {"ls": "none"}
        legend[name] = Line2D([], [], **look)
    return legend


def _name(axis: xr.DataArray, value: Any) -> str:
    """A value of a varied entry or condition, such as "1 mm" or "friction 0.1"."""
    shown = value_words(axis, value)
    return f"{axis.name} {shown}" if shown == f"{value:g}" else shown


def _mark_places(axes: Axes, places: Sequence[OperatingPoint]) -> None:
    """Mark operating points; few have their numbers beside, on the side away from the boundary."""
    look: dict[str, Any] = {"mfc": OPERATING, "mec": "white", "zorder": 5, "clip_on": False}
    for load, velocity in places:
        size = 2.4 * rcParams["lines.markersize"]
        axes.plot(velocity, load, "P", ms=size, gid="operating point", **look)
        if len(places) > _FEW:
            continue
        across, up = axes.transAxes.inverted().transform(axes.transData.transform((velocity, load)))
        is_low = across + up < 1  # boundaries fall from the upper left to the lower right
        to_left = across > _OF_WORDS if is_low else across > 1 - _OF_WORDS
        is_below = up > 1 - _OF_EDGE or (is_low and up > _OF_EDGE)
        axes.annotate(
            f"{load:.4g} N, {velocity:.4g} m/s", (velocity, load),
            (-8 if to_left else 8, -6 if is_below else 6), textcoords="offset points",
            color=OPERATING, ha="right" if to_left else "left", va="top" if is_below else "bottom",
            fontweight="bold", path_effects=style.HALO, zorder=5,
        )  # fmt: skip
