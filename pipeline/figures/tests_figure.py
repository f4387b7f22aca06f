"""The laboratory's tests: their marks, and the figure of the rise ratio of each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

import pipeline
from pipeline.answers.case_results import CaseResults
from pipeline.answers.readable import attribute_texts
from pipeline.answers.results import refuse_cases, sweep_of
from pipeline.figures import style
from pipeline.figures.style import BLACK, FAINT, GREY
from pipeline.sweep.case import OperatingPoint
from tribo import InputError

TESTS = {"mild": ("o", "white"), "severe": ("o", BLACK), "transition": ("D", BLACK)}
"""Marker and face colour of a test, by its outcome."""
UNDECIDED_LABEL = "undecided: severe wear 5 to 95 % probable"
"""Label in legends."""
_OPEN_SIZE = 1.4  # size of the mark of a test at the line's friction over that of a line's mark
_JOINING_LINE_WIDTH = 1.5  # of the line between both marks of a test [pt]; an axis may hide it
_FRICTION_TOLERANCE = 1e-3  # relative difference of frictions that count as equal
_MAX_AXIS_RATIO = 1.5  # factor on the sweep's ends beyond which tests are not drawn
_NODES = 65  # velocities between which that of a moved test is interpolated
_BULK_TOLERANCE = 1.0  # bulk temperatures that differ less count as equal [K]
_ROW_MARGIN = 0.3  # above and below the rows of tests
_AXIS_MARGIN = 1.15  # factor between the outermost values and the axis' ends


@style.house_style
def draw_tests(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Figure:
    """Draw the rise ratio of each test at its own conditions, and the band that stays undecided.

    A bar joins the mild and the severe end of a transition with a step. The caption counts tests
    without a result.
    """
    refuse_cases(ds)
    comparison = pipeline.compare_tests(ds, **conditions)
    if not comparison.sizes["test"]:
        raise InputError("the scene has no tests to draw; add [[tests]] to it")
    with_result = comparison.isel(test=comparison["reason"].values == "")
    if not with_result.sizes["test"]:
        reason = attribute_texts(comparison, "tests_without_result")[0]
        raise InputError(f"no test of the scene has a result yet: {reason}")
    low, middle, high = map(math.exp, comparison.attrs["levels"])
    figure, axes = style.canvas((8.0, 1.8 + 0.35 * with_result.sizes["test"]))
    legend: dict[str, Any] = {
        UNDECIDED_LABEL: axes.axvspan(low, high, **style.BAND),
        "boundary with tests (50 %)": axes.axvline(middle, **style.BOUNDARY),
        "computed boundary": axes.axvline(1.0, color=BLACK, lw=style.THIN),
    }
    pairs = np.exp(
        np.stack(
            [
                with_result["log_rise_ratio_mild"].values,
                with_result["log_rise_ratio_severe"].values,
            ],
            axis=1,
        )
    )
    outcomes = with_result["outcome"].values.tolist()
    for row, pair in enumerate(pairs):
        ends = pair[np.isfinite(pair)]
        axes.plot(ends, [row] * len(ends), color=GREY)
        position = float(ends.mean()), row
        draw_test_marker(axes, str(with_result["test"].values[row]), outcomes[row], position)
    legend |= tests_legend(outcomes)
    ends = np.array(
        [min(low, np.nanmin(pairs)) / _AXIS_MARGIN, max(high, np.nanmax(pairs)) * _AXIS_MARGIN]
    )
    axes.set(xscale="log", xlim=ends, ylim=(len(pairs) - 1 + _ROW_MARGIN, -_ROW_MARGIN))
    points = zip(with_result["load"].values, with_result["velocity"].values, strict=True)
    axes.set_yticks(range(len(pairs)), [f"{load:g} N, {speed:g} m/s" for load, speed in points])
    style.plain_numbers(axes)
    axes.set(xlabel="computed rise ratio of the test")
    title = style.as_text(sweep_of(ds).title)
    style.write_title(axes, f"{title}\ntests, each at its own conditions")
    caption = f"model error: {attribute_texts(comparison, 'model_error')[0]}"
    if missing := comparison.sizes["test"] - len(pairs):
        caption += f"\n{missing} of {comparison.sizes['test']} tests have no result"
    style.legend_below(
        figure,
        2,
        handles=[*legend.values()],
        labels=[*legend],
        caption=caption,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )
    return figure


def draw_test_marker(
    axes: Axes,
    number: str,
    outcome: str,
    position: tuple[float, float],
    faint: bool = False,
    label: tuple[float, float] | None = None,
) -> None:
    """Mark a test at its `position` (x, y), and write its number to the right of it.

    If `label` is given, the number is to the right of this position instead.
    """
    marker, face = TESTS[outcome]
    gid = f"test {outcome}, elsewhere" if faint else f"test {outcome}"
    look: dict[str, Any] = {"mfc": face, "mec": BLACK if face == "white" else "white"}
    axes.plot(
        *position, marker, ms=style.BIG * rcParams["lines.markersize"], clip_on=False, zorder=4,
        alpha=FAINT if faint else 1.0, gid=gid, **look,
    )  # fmt: skip
    axes.annotate(
        style.as_text(number), label or position, (8, 0), textcoords="offset points",
        fontsize="small",
        va="center", color=BLACK, gid="number of a test", path_effects=style.HALO, zorder=5,
    )  # fmt: skip


def tests_legend(outcomes: Iterable[str]) -> dict[str, Any]:
    """Entry of a legend with the marks of all kinds of tests among `outcomes`."""
    kinds = {*outcomes}
    looks = {outcome: look for outcome, look in TESTS.items() if outcome in kinds}
    marks = tuple(
        Line2D([], [], ls="none", marker=marker, mfc=face, mec=BLACK)
        for marker, face in looks.values()
    )
    return {f"test: {', '.join(looks)}": marks} if marks else {}


def mark_tests(
    axes: Axes, case: CaseResults, bulk: float, friction: float, moved: Mapping[int, float]
) -> tuple[list[OperatingPoint], dict[str, Any], list[str]]:
    """Mark the tests in or near the sweep's range, faint if their bulk temperature is not `bulk`.

    `moved` has velocities at which tests would lie at the `friction` of the line, by position in
    the list of tests. There, an open mark is joined to that of the test. Returns the operating
    points of the tests, their entries of the legend, and lines of the caption.
    """
    sweep_bulk = case.sweep.conditions.bulk_temperature
    has_moved = False
    points, kinds, omitted, has_faint = list[OperatingPoint](), list[Any](), list[str](), False
    for position, test in enumerate(case.sweep.tests, 1):
        number, point = test.number or str(position), (test.normal_load, abs(test.velocity))
        pairs = zip(point, (case.loads, case.velocities), strict=True)
        if not all(
            axis[0] / _MAX_AXIS_RATIO <= value <= _MAX_AXIS_RATIO * axis[-1]
            for value, axis in pairs
        ):
            omitted.append(number)
            continue
        faint = abs((test.bulk_temperature or sweep_bulk) - bulk) > _BULK_TOLERANCE
        kinds.append(test.outcome)
        ends = [point[1], *([moved[position - 1]] if position - 1 in moved and not faint else [])]
        if len(ends) > 1:
            marker, _ = TESTS[test.outcome]
            axes.plot(
                ends, [point[0]] * 2, color=BLACK, lw=_JOINING_LINE_WIDTH, zorder=3.5, clip_on=False
            )
            axes.plot(
                ends[1], point[0], marker, ms=_OPEN_SIZE * rcParams["lines.markersize"],
                mfc="white", mec=BLACK, clip_on=False, zorder=4, gid="test at the line's friction",
            )  # fmt: skip
            has_moved = True
        label = max(ends), point[0]
        draw_test_marker(axes, number, kinds[-1], (point[1], point[0]), faint, label)
        points.append(point)
        has_faint |= faint
    caption = ["faint: tests at another bulk temperature"] if has_faint else []
    if len(omitted) == 1:
        caption.append(f"not shown (outside the axes): test {omitted[0]}")
    elif omitted:
        caption.append(f"not shown (outside the axes): tests {', '.join(omitted)}")
    legend = tests_legend(kinds)
    if has_moved:
        legend[f"the same test at friction {friction:g}"] = Line2D(
            [], [], ls="none", marker="D", mfc="white", mec=BLACK
        )
    return points, legend, caption


def velocities_at_friction(
    ds: xr.Dataset, case: CaseResults, conditions: Mapping[str, Any], friction: float
) -> dict[int, float]:
    """Velocities [m/s] at which tests would lie at a friction, by position in the list of tests.

    There, the rise at this friction is that of the test at its own. Tests at this friction are left
    out, and tests without such a velocity within the sweep.
    """
    velocities, moved = case.velocities, dict[int, float]()
    nodes = np.geomspace(max(velocities[0], velocities[-1] / 1e3), velocities[-1], _NODES)
    for position, test in enumerate(case.sweep.tests):
        log_ratio = math.log(test.case.conditions.friction / friction)
        if abs(log_ratio) < _FRICTION_TOLERANCE:
            continue
        line_velocities = np.append(nodes, test.velocity)
        loads = np.full(line_velocities.shape, test.normal_load)
        y = pipeline.margin(ds, loads, line_velocities, **conditions)["log_rise_ratio"].values
        excess = y[:-1] - (y[-1] + log_ratio)
        crossings = np.flatnonzero(np.diff(np.sign(excess)) != 0)
        if np.isnan(y[-1]) or not crossings.size:
            continue
        k = crossings[np.abs(nodes[crossings] - test.velocity).argmin()]
        if np.isfinite(fraction := excess[k] / (excess[k] - excess[k + 1])):
            moved[position] = float(nodes[k] * (nodes[k + 1] / nodes[k]) ** fraction)
    return moved
