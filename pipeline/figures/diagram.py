"""The transition diagram: mild and severe wear in the plane of velocity and load.

It draws only variables of `pipeline.margin`, `pipeline.boundary` and `pipeline.points`, and the
regions of `pipeline.answers.verdict_limits`.
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

import pipeline
from pipeline.answers.answers import plane_margins
from pipeline.answers.case_results import CaseResults
from pipeline.answers.condition_values import argument_array
from pipeline.answers.facts import ERRORS, fact_lines
from pipeline.answers.results import cases_of, sweep_of
from pipeline.answers.scene_wording import named_value
from pipeline.answers.verdict_limits import Region, regions
from pipeline.answers.verdict_model import MILD, OUTSIDE, SEVERE, UNDECIDED, UNKNOWN, VERDICTS
from pipeline.constants import VERDICT_PROBABILITIES
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, GREY, OPERATING, TINTS, VERMILION
from pipeline.figures.tests_figure import UNDECIDED_LABEL, mark_tests
from pipeline.kinds import LOAD, VELOCITY
from pipeline.store.schema import PLANE
from pipeline.sweep.case import OperatingPoint
from tribo import InputError
from tribo.types import Array

_MIN_LOADS, _MIN_VELOCITIES = 48, 96  # least numbers of them on the drawn grid
_MAX_LOG_RATIO = 50.0  # larger sizes of ln(rise ratio), also infinite ones, are drawn as this
_ERROR_COLOUR = "#C8C8C8"  # band of the numerical error
COMPUTED = "computed boundary, numerical error"
"""Label in legends."""
_SAME_FRICTION = 0.006  # relative difference below which lines of two frictions lie on each other
_MAX_LABELLED = 6  # most operating points that are labelled with their numbers

QuantityLike = float | str | Iterable[float | str] | None
"""Loads or velocities to mark, in SI or as text with a unit."""
Legend = dict[str, Any]
"""Handle of each entry of a legend, by its label; a tuple has several handles side by side."""


@style.house_style
def diagram(
    ds: xr.Dataset,
    conditions: Mapping[str, Any],
    log: bool = False,
    load: QuantityLike = None,
    velocity: QuantityLike = None,
) -> Figure:
    """Draw the transition diagram.

    The load–velocity plane is shaded by verdict, up to the mild and severe limits. The heavy line
    is the boundary with tests, if there are any; the computed one has a band of numerical error.
    Dots are simulated points. Tests at another friction than that of the boundary are also drawn as
    they would lie at its friction, with open marks. Of several cases only the boundaries are drawn,
    each in its own colour. `log` makes both axes logarithmic. The operating point of `load` and
    `velocity`, in SI or as text with a unit, is marked; lists of equal length are pairs.
    """
    operating_points = _operating_points(load, velocity)
    case = _case_with_plane(ds)
    boundary = pipeline.boundary(ds, **conditions)
    axes_of_grid = _refined(case.loads, _MIN_LOADS), _refined(case.velocities, _MIN_VELOCITIES)
    margins = plane_margins(ds, *axes_of_grid, conditions)
    case_dimensions = [str(dim) for dim in boundary["critical_velocity"].dims if dim not in PLANE]
    figure, axes = style.canvas((8.0, 5.6))
    lines = fact_lines(boundary, "conditions")
    tests, notes = list[OperatingPoint](), list[str]()
    if case_dimensions:
        legend = _draw_cases(axes, margins, case_dimensions)
        names = " and ".join(case_dimensions).replace("_", " ")
        lines = [f"boundary by {names}; {lines[0]}"]
    else:
        legend = _shade(axes, case, regions(ds, conditions)) | _draw_lines(axes, case, margins)
        tests, tests_legend, notes = mark_tests(axes, case, conditions)
        legend |= tests_legend
        _name_regions(axes, margins)
        notes = [*_mark_simulated(axes, ds, conditions), *notes]
        lines += fact_lines(boundary, "hottest end of the pin", "ruling", "verdicts withheld")
    lines[1:1] = fact_lines(boundary, *ERRORS)
    _set_axes(axes, case, [*tests, *operating_points], log)
    _mark_operating_points(axes, operating_points)
    style.write_title(axes, style.as_text(sweep_of(ds).title))
    lines.append("; ".join(notes))
    lines += fact_lines(boundary, "not included")[:1] + fact_lines(boundary, "note")[:1]
    style.legend_below(
        figure, 2 if len(legend) == 4 else 3, handles=[*legend.values()], labels=[*legend] or None,
        caption="\n".join(lines), handler_map={tuple: HandlerTuple(ndivide=None)},
    )  # fmt: skip
    return figure


def _operating_points(load: Any, velocity: Any) -> list[OperatingPoint]:
    """Operating points in SI, from loads and velocities that are pairs."""
    loads, velocities = (
        argument_array(axis, values, kind.argument, axis).values.ravel().tolist()
        if values is not None and np.size(values)
        else []
        for axis, values, kind in (("load", load, LOAD), ("velocity", velocity, VELOCITY))
    )
    if len(loads) != len(velocities):
        raise InputError(
            f"loads ({len(loads)}) and velocities ({len(velocities)}) cannot be paired; give equal "
            "numbers of both"
        )
    return [*zip(loads, velocities, strict=True)]


def _case_with_plane(ds: xr.Dataset) -> CaseResults:
    """The first case of a dataset; raises an `InputError` if it has no plane to draw."""
    if any(sweep_of(ds).case_table.column(name) for name in PLANE):
        raise InputError(
            "each row of the sweep has its own load and velocity, so there is no plane of them; "
            "irg margin prints its rows"
        )
    case = cases_of(ds)[0]
    if min(len(case.loads), len(case.velocities)) < 2:
        raise InputError(
            "the diagram needs at least two loads and two velocities; irg boundary prints the "
            "transitions"
        )
    return case


def _set_axes(
    axes: Axes, case: CaseResults, marked_points: Sequence[OperatingPoint], log: bool
) -> None:
    """Scale the axes to the sweep and to the marked points, and label them."""
    if log:
        axes.set(xscale="log", yscale="log")
        style.plain_numbers(axes)
    for set_limits, axis_values, marked_values in (
        (axes.set_ylim, case.loads, [load for load, _ in marked_points]),
        (axes.set_xlim, case.velocities, [velocity for _, velocity in marked_points]),
    ):
        drawn_values = [axis_values[0], axis_values[-1], *marked_values]
        set_limits(min(drawn_values), max(drawn_values))
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")


def _refined(points: Array, min_count: int) -> Array:
    """Axis of at least `min_count` values, equally many between any two `points`."""
    division = max(2, math.ceil(min_count / (len(points) - 1)))
    return np.append(
        np.linspace(points[:-1], points[1:], division, False, axis=1).ravel(), points[-1]
    )


def _shade(axes: Axes, case: CaseResults, plane: Mapping[int, list[Region]]) -> Legend:
    """Shade the regions of each verdict, and hatch those outside the model.

    Points without a verdict stay white.
    """
    legend = Legend()
    if UNDECIDED in plane:  # below the others
        low, high = case.velocities[[0, -1]]
        axes.fill_betweenx(
            case.loads[[0, -1]],
            low,
            high,
            fc=TINTS["undecided"],
            lw=0,
            zorder=0,
            gid="undecided region",
        )
        legend[UNDECIDED_LABEL] = Patch(**style.BAND)
    looks: tuple[tuple[int, dict[str, Any]], ...] = (
        (MILD, {"fc": TINTS["mild"]}),
        (SEVERE, {"fc": TINTS["severe"]}),
        (UNKNOWN, {"fc": "white"}),
        (OUTSIDE, {"fc": "white", "ec": GREY, "hatch": "///"}),
    )
    for code, look in looks:
        for region in plane.get(code, ()):
            axes.fill_betweenx(*region, lw=0, zorder=0, gid=f"{VERDICTS[code]} region", **look)
    if OUTSIDE in plane:
        legend["outside the model (oil film)"] = Patch(fc="none", ec=GREY, hatch="///")
    return legend


def _draw_lines(axes: Axes, case: CaseResults, margins: xr.Dataset) -> Legend:
    """Draw the boundary with tests, as computed with its numerical error, and by friction.

    The heavy line is the answer: with tests, if there are any.
    """
    legend, has_tests, heavy_frictions = Legend(), False, np.array([])
    names = "probability", "log_rise_ratio", "temperature_margin", "temperature_error"
    in_model = margins[[*names, "critical_friction"]].where(margins["verdict"] != OUTSIDE)
    if margins.attrs["tests"]:
        excess = in_model["probability"] - VERDICT_PROBABILITIES[1]
        has_tests = _draw_zero(axes, excess, "boundary with tests", style.BOUNDARY)
        heavy_frictions = _at_zero(excess.values, in_model["critical_friction"].values)
    if has_tests:
        legend["boundary with tests (50 %)"] = Line2D([], [], **style.BOUNDARY)
    log_ratio = in_model["log_rise_ratio"].clip(-_MAX_LOG_RATIO, _MAX_LOG_RATIO)
    look = style.BOUNDARY | ({"lw": style.THIN} if has_tests else {})
    if _draw_zero(axes, log_ratio, "boundary", look):
        margin, error = in_model["temperature_margin"], in_model["temperature_error"]
        distance = (abs(margin) - error.fillna(0.0)).values  # negative within the error
        if (distance < 0).any():
            band = axes.contourf(
                margins["velocity"].values, margins["load"].values, distance,
                [np.nanmin(distance) - 1.0, 0.0], colors=[_ERROR_COLOUR],
            )  # fmt: skip
            band.set_gid("error")
        outline = [Stroke(linewidth=9, foreground=_ERROR_COLOUR), Normal()]
        legend[COMPUTED] = Line2D([], [], path_effects=outline, solid_capstyle="butt", **look)
    friction_band = case.sweep.base.friction_band
    if friction_band and friction_band[0] < friction_band[1]:
        look = {"color": GREY, "lw": style.THIN, "ls": "--"}
        drawn_friction = float(np.ravel(margins["friction"].values)[0])  # has its line already
        frictions = [
            x
            for x in friction_band
            if not math.isclose(x, drawn_friction, rel_tol=1e-3)
            and not (has_tests and np.median(abs(heavy_frictions / x - 1)) < _SAME_FRICTION)
        ]
        are_drawn = [
            _draw_zero(axes, in_model["critical_friction"] - friction, "friction", look)
            for friction in frictions
        ]
        if any(are_drawn):
            label = f"computed at friction {' and '.join(f'{x:g}' for x in frictions)}"
            legend[label] = Line2D([], [], **look)
    return legend


def _draw_zero(axes: Axes, field: xr.DataArray, gid: str, look: Mapping[str, Any]) -> bool:
    """Draw the contour on which `field` (load, velocity) is 0; return False if it is empty.

    `gid` is the contour's name in an SVG file, and `look` has properties of Matplotlib's lines.
    """
    values = field.values
    if not ((values < 0).any() and (values > 0).any()):
        return False
    line_properties = {name: value for name, value in look.items() if name != "color"}
    velocities, loads = field["velocity"].values, field["load"].values
    contour = axes.contour(velocities, loads, values, [0.0], colors=[look["color"]])
    contour.set(gid=gid, **line_properties)
    return True


def _at_zero(field: Array, values: Array) -> Array:
    """`values` on the contour on which `field` is 0, both (load, velocity), at each load."""
    before, after = field[:, :-1], field[:, 1:]
    is_crossing = before * after < 0
    fraction = (before / np.where(is_crossing, before - after, 1.0))[is_crossing]
    return values[:, :-1][is_crossing] * (1 - fraction) + values[:, 1:][is_crossing] * fraction


def _name_regions(axes: Axes, margins: xr.Dataset) -> None:
    """Write the name of each region at its centre, if the region is wide enough."""
    loads, velocities = margins["load"].values, margins["velocity"].values
    verdicts = margins["verdict"].values
    for verdict, name, colour in (
        (MILD, "mild wear\n(I and II)", BLUE),
        (SEVERE, "severe adhesive wear\n(III* and III)", VERMILION),
    ):
        is_region = verdicts == verdict
        if is_region.mean() > 0.1:
            row, column = np.argwhere(is_region).mean(axis=0).astype(int)
            axes.text(
                velocities[column], loads[row], name, ha="center", va="center", fontweight="bold",
                color=colour, gid="region", path_effects=style.HALO, zorder=3,
            )  # fmt: skip
        else:
            _name_side(axes, margins["log_rise_ratio"].values, verdict)


def _name_side(axes: Axes, log_ratios: Array, verdict: int) -> None:
    """Name the side of a line in its corner: slow and light, or fast and heavy.

    `log_ratios` (..., load, velocity) are those of one or several lines. Nothing is written if the
    corner is on the other side of any line.
    """
    is_severe = verdict == SEVERE
    at_corner = log_ratios[..., -1, -1] if is_severe else -log_ratios[..., 0, 0]
    if not (at_corner > 0).all():
        return
    text, colour = ("severe →", VERMILION) if is_severe else ("← mild", BLUE)
    axes.text(
        0.98 if is_severe else 0.02, 0.97 if is_severe else 0.03, text, transform=axes.transAxes,
        ha="right" if is_severe else "left", va="top" if is_severe else "bottom",
        fontsize="small", fontweight="bold", color=colour, gid="side", path_effects=style.HALO,
        zorder=3,
    )  # fmt: skip


def _mark_simulated(axes: Axes, ds: xr.Dataset, conditions: Mapping[str, Any]) -> list[str]:
    """Mark simulated points, and pending or failed ones; return notes on the marks."""
    state = pipeline.points(ds, **conditions)["state"]
    is_unfinished, is_done = (
        state.isin(kinds).any("realization").transpose(*PLANE).values
        for kinds in (("failed", "pending"), ("mild", "severe"))
    )
    dot_size, notes = 0.6 * rcParams["lines.markersize"], list[str]()
    for gid, is_marked, look, note in (
        ("simulated", is_done & ~is_unfinished, {"marker": ".", "ms": dot_size, "zorder": 2.5},
         "dots: simulated points"),
        ("lacking", is_unfinished, {"marker": "x"},
         f"×: {is_unfinished.sum()} points are pending or failed"),
    ):  # fmt: skip
        rows, columns = np.nonzero(is_marked)
        if rows.size:
            axes.plot(
                state["velocity"].values[columns], state["load"].values[rows], ls="none",
                color=BLACK, mec=BLACK, gid=gid, clip_on=False, **look,
            )  # fmt: skip
            notes.append(note)
    return notes


def _draw_cases(axes: Axes, margins: xr.Dataset, dimensions: Sequence[str]) -> Legend:
    """Draw the boundary of each case in another colour; return the entries of the legend."""
    log_ratios = margins["log_rise_ratio"].clip(-_MAX_LOG_RATIO, _MAX_LOG_RATIO)
    log_ratios = log_ratios.stack(line=dimensions).transpose("line", *PLANE)
    # The end of the colour map is too bright for lines.
    colours = colormaps["viridis"](np.linspace(0.0, 0.8, log_ratios.sizes["line"]))
    legend = Legend()
    for log_ratio, colour in zip(log_ratios, colours, strict=True):
        labels = [margins[dim].sel({dim: log_ratio[dim].item()}) for dim in dimensions]
        name = ", ".join(map(named_value, labels))
        look: dict[str, Any] = style.BOUNDARY | {"color": colour}
        if not _draw_zero(axes, log_ratio, f"boundary {name}", look):
            name, look = f"{name}: no boundary in the sweep", {"ls": "none"}
        legend[name] = Line2D([], [], **look)
    for verdict in (MILD, SEVERE):
        _name_side(axes, log_ratios.values, verdict)
    return legend


def _mark_operating_points(axes: Axes, points: Sequence[OperatingPoint]) -> None:
    """Mark operating points; write the numbers of a few on the inner side."""
    for load, velocity in points:
        axes.plot(
            velocity, load, "P", ms=2.4 * rcParams["lines.markersize"], gid="operating point",
            mfc=OPERATING, mec="white", zorder=5, clip_on=False,
        )  # fmt: skip
        if len(points) <= _MAX_LABELLED:
            position = axes.transData.transform((velocity, load))
            x, y = axes.transAxes.inverted().transform(position) > 0.5
            axes.annotate(
                f"{load:g} N, {velocity:g} m/s", (velocity, load),
                (-8 if x else 8, -6 if y else 6), textcoords="offset points", color=OPERATING,
                ha="right" if x else "left", va="top" if y else "bottom", fontweight="bold",
                path_effects=style.HALO, zorder=5,
            )  # fmt: skip
