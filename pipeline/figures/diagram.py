"""The transition diagram: mild and severe wear in the plane of velocity and load."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib import colormaps, rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pipeline.analysis.caveats import doubt_lines
from pipeline.analysis.condition_words import judged_by
from pipeline.analysis.dataset import Layout, require_kind
from pipeline.analysis.film import OUTSIDE
from pipeline.analysis.judge import NOT_DECIDED, Judge, judge_of
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import SURFACE, totals, velocity_errors
from pipeline.analysis.rises import Rises, rises_of
from pipeline.analysis.scenes import value_text
from pipeline.analysis.warned_points import warning_flags
from pipeline.analysis.words import error_words
from pipeline.constants import DECIDED
from pipeline.figures import style
from pipeline.figures.overlays import (
    film_lines,
    mark_tests,
    name_regions,
    number_tests,
    reachable_tests,
    zero_line,
)
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, TINTS, VERMILION
from pipeline.store.schema import DONE, FAILED, PLANE
from pipeline.sweep.conditions import Conditions, rise_limit
from pipeline.sweep.sweep import variant_words
from tribo import Criterion, InputError
from tribo.types import Array, Mask

_SIZE = 8.0, 5.6  # width and height of a diagram [in]
_LIGHTEST = 0.85  # end of the colour map used for several scenes
_MANY = 1500  # points from which marks are small


@style.house_style
def diagram(data: Results, realization: int | None = None, log: bool = False) -> Figure:
    """Draw the transition diagram.

    The load–velocity plane is coloured by the verdict of `pipeline.margin`. The computed boundary
    is drawn, and that with tests where they differ, with its band from 5 to 95 %. Several surfaces
    are patches of one specimen; `realization`, the seed of a surface, chooses a single one. Of
    several scenes only the boundaries are drawn, each in its own colour. `log` makes both axes
    logarithmic, without velocity 0.
    """
    data = data.take_surface(realization)
    require_kind(data.kind, Layout.PLANE)
    if log:
        data = data.take_moving()
    figure, axes = style.canvas(_SIZE)
    conditions = next(data.scenes).conditions
    legend, caption = (_draw_scenes if data.entry_dims else _draw_scene)(axes, data)
    tests, beyond = reachable_tests(data, number_tests(data.sweep.tests))
    own_bulk = data.stored.conditions.bulk_temperature
    legend += [*mark_tests(axes, tests, conditions.bulk_temperature, own_bulk), *beyond]
    axes.use_sticky_edges = False  # the edges of filled regions would leave no margin
    axes.margins(0.04)
    if log:
        axes.set(xscale="log", yscale="log")
        style.plain_numbers(axes)
    style.write_title(axes, ", ".join([style.title_of(data), *variant_words(data.surface)]))
    axes.set(xlabel="sliding velocity [m/s]", ylabel="normal load [N]")
    caption = "\n".join([caption, *doubt_lines(data.sweep, most=1, answered=True)])
    style.legend_below(figure, handles=legend, caption=caption)
    return figure


def _draw_scene(axes: Axes, data: Results) -> tuple[list[Artist], str]:
    """Draw one scene; return the entries of the legend, and the caption."""
    judge = judge_of(data)
    caption, legend = judged_by([judge.conditions], data.told_tests), list[Artist]()
    if min(len(data.loads), len(data.velocities)) > 1:
        x, y = _refine_axis(data.velocities, 96), _refine_axis(data.loads, 48)
        plane = _plane(judge.rises, x, y)
        legend += _shade_verdicts(axes, judge, x, y, plane)
        places = [axis.ravel() for axis in np.meshgrid(y, x, indexing="ij")]
        plane = np.where(np.reshape(judge.outside(*places), plane.shape), np.nan, plane)
        if zero_line(axes, x, y, plane, "boundary", **style.BOUNDARY):
            legend.append(Line2D([], [], label="computed transition", **style.BOUNDARY))
        legend += _lines_with_tests(axes, judge, x, y, plane)
        legend += _friction_lines(axes, judge.rises, x, y)
        legend += film_lines(axes, data, judge.conditions)
        critical = judge.rises.turns("velocity", data.loads).critical
        errors = velocity_errors(judge.rises, data.loads, critical)
        caption += f"\nnumerical error: {error_words(totals(errors), errors[SURFACE])}"
        caption += f"\nthe model's own error: {judge.evidence.text}"
        if waiting := ", ".join(str(row.test.number) for row in judge.evidence.waiting):
            said = f"without a result, so not every verdict is given: test {waiting}"
            legend.append(Line2D([], [], ls="none", label=said))
    return [*legend, *_mark_points(axes, data, judge.conditions)], caption


def _draw_scenes(axes: Axes, data: Results) -> tuple[list[Artist], str]:
    """Draw the boundary of each scene of a sweep over entries; return legend and caption."""
    if min(len(data.loads), len(data.velocities)) < 2:
        raise InputError(
            "the diagram of several scenes needs at least two loads and two velocities; irg "
            "boundary prints their transitions"
        )
    several, legend = [rises_of(scene) for scene in data.scenes], list[Artist]()
    shades = colormaps["viridis"](np.linspace(0.0, _LIGHTEST, len(several)))
    x, y = _refine_axis(data.velocities, 96), _refine_axis(data.loads, 48)
    for rises, shade in zip(several, shades, strict=True):
        plane, labels = _plane(rises, x, y), rises.source.labels
        name = ", ".join(value_text(data.rows[path], labels[path]) for path in data.entry_dims)
        look: dict[str, Any] = style.BOUNDARY | {"color": shade}
        if not zero_line(axes, x, y, plane, f"boundary {name}", **look):
            name, look = f"{name}: no transition computed", {"ls": "none"}
        legend.append(Line2D([], [], label=name, **look))
    entries = " and ".join(data.entry_dims).replace("_", " ")
    caption, conditions = f"transition by {entries}", {rises.conditions for rises in several}
    return legend, caption + (
        f"; {judged_by(conditions, data.told_tests)}" if len(conditions) == 1 else ""
    )


_STEEPEST = 50.0  # largest |y| of a figure
_BESIDE = 1e-6  # of a probability, beside the end of a region
_INSIDE = 1e-4  # distance from a point, over the interval: at points the error is smaller


def _refine_axis(points: Array, count: int) -> Array:
    """Fine axis with at least `count` values, equally many between any two `points`."""
    begins, ends = points[:-1], points[1:]
    inside, parts = _INSIDE * (ends - begins), max(2, math.ceil(count / len(begins)))
    return np.linspace(begins + inside, ends - inside, parts, axis=1).ravel()


def _plane(rises: Rises, x: Array, y: Array) -> Array:
    """Y = ln(rise/limit) at loads y and velocities x (y, x), NaN where unknown."""
    places = (axis.ravel() for axis in np.meshgrid(y, x, indexing="ij"))
    found = np.reshape(rises.known(*places).y, (len(y), len(x)))
    return np.clip(found, -_STEEPEST, _STEEPEST)  # finite without friction


def _shade_verdicts(axes: Axes, judge: Judge, x: Array, y: Array, plane: Array) -> list[Artist]:
    """Shade regions by verdict where `plane` is known; return the undecided one's entry."""
    places = tuple(axis.ravel() for axis in np.meshgrid(y, x, indexing="ij"))
    verdicts = np.reshape(judge.verdicts(*places), plane.shape)
    low, _, high = (np.reshape(part, plane.shape) for part in judge.chances(places[0], places[1]))
    outside = verdicts == OUTSIDE
    is_known, (mild, _, severe) = np.isfinite(plane) & ~outside, DECIDED
    # Within a region its edge is where the probability passes; a test may cut it at a node.
    highest = np.where(verdicts == "mild", high, np.maximum(high, mild + _BESIDE))
    lowest = np.where(verdicts == "severe", low, np.minimum(low, severe - _BESIDE))
    highest, lowest = (np.where(is_known, part, np.nan) for part in (highest, lowest))
    between, legend = np.minimum(highest - mild, severe - lowest), list[Artist]()
    for values, levels, gid, look in (
        (highest, [-1.0, mild], "mild region", {"colors": [TINTS["mild"]]}),
        (lowest, [severe, 2.0], "severe region", {"colors": [TINTS["severe"]]}),
        (between, [0.0, 1.0], NOT_DECIDED, {"colors": [TINTS["band"]], "alpha": 0.6}),
    ):
        if ((values > levels[0]) & (values < levels[1])).any():
            axes.contourf(x, y, values, levels, zorder=0, **look).set_gid(gid)  # below the grid
            if gid == NOT_DECIDED:
                legend.append(Patch(label="next run not decided", **style.BAND))
    if outside.any():
        hatched = axes.contourf(
            x, y, outside.astype(float), [0.5, 1.5], colors="none", hatches=["///"], zorder=0
        )
        hatched.set_gid(OUTSIDE)
        legend.append(Patch(label="outside the model: oil film", fc="none", ec=GREY, hatch="///"))
    name_regions(axes, x, y, verdicts == "mild", verdicts == "severe")
    return legend


def _lines_with_tests(axes: Axes, judge: Judge, x: Array, y: Array, plane: Array) -> list[Artist]:
    """Draw where severe wear is 5, 50 and 95 % likely, if a test has a result."""
    if not judge.evidence.results:
        return []
    low, middle, high = judge.levels
    legend = list[Artist]()
    look: dict[str, Any] = {"color": GREEN, "lw": style.THIN}
    edges = [
        zero_line(axes, x, y, plane - level, "band with tests", **look) for level in (low, high)
    ]
    if any(edges):
        legend.append(Line2D([], [], label="5 and 95 % severe, with tests", **look))
    look = {"color": GREEN}
    if zero_line(axes, x, y, plane - middle, "boundary with tests", **look):
        legend.insert(0, Line2D([], [], label="transition with tests (50 %)", **look))
    return legend


def _friction_lines(axes: Axes, rises: Rises, x: Array, y: Array) -> list[Artist]:
    """Draw boundaries at the lowest and highest measured friction, at velocities x, loads y."""
    band = rises.source.sweep.friction_band
    if not band or min(band) == max(band):
        return []
    look: dict[str, Any] = {"color": GREY, "lw": style.THIN, "ls": "--"}
    drawn = []
    for friction in (min(band), max(band)):
        under = rises.under(replace(rises.conditions, friction=float(friction)))
        drawn.append(zero_line(axes, x, y, _plane(under, x, y), "band edge", **look))
    label = f"transition at friction {min(band):g} and {max(band):g}"
    return [Line2D([], [], label=label, **look)] * any(drawn)


def _mark_points(axes: Axes, data: Results, conditions: Conditions) -> list[Artist]:
    """Mark each point by its outcome on all surfaces, and by its warning; return legend entries."""
    r, limit = data.rises(conditions), rise_limit(conditions)
    severe, mild = (_any_surface(of(r, limit)) for of in (Criterion.is_severe, Criterion.is_mild))
    failed = ~(severe | mild) & _any_surface(np.isin(data.columns["status"], (DONE, FAILED)))
    pending = ~(severe | mild) & ~failed & _any_surface(data.asked)
    usual = rcParams["lines.markersize"]
    kinds: list[tuple[str, Mask, dict[str, Any]]] = [
        ("mild wear, computed", mild & ~severe, {"marker": "o", "mfc": "white", "mec": BLUE}),
        ("severe wear, computed", severe & ~mild, {"marker": "s", "mfc": VERMILION, "mec": "none"}),
        ("severe on some patches", mild & severe,
         {"marker": "s", "mfc": "white", "mec": VERMILION}),
        ("failed", failed, {"marker": "x", "mec": BLACK}),
        ("pending", pending, {"marker": "o", "mfc": GREY, "mec": "none"}),
        ("carries a warning", _any_surface(warning_flags(data) != 0),
         {"marker": "o", "mfc": "none", "mec": BLACK, "ms": style.BIG * usual}),
    ]  # fmt: skip
    look_of_all = {"ls": "none", "ms": usual * (0.5 if failed.size > _MANY else 0.8)}
    legend = list[Artist]()
    for label, where, look in kinds:
        rows, columns = np.nonzero(where)
        if rows.size:
            places = data.velocities[columns], data.loads[rows]
            legend += axes.plot(
                *places, label=label, gid=label, mew=style.THIN, **look_of_all | look
            )
    return legend


def _any_surface(holds: Mask) -> Mask:
    """Mask (load, velocity): True where `holds` (..., load, velocity) is on any surface."""
    return np.asarray(holds.any(axis=tuple(range(holds.ndim - len(PLANE)))))
