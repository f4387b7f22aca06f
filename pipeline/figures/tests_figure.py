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
    tests = comparison.isel(test=comparison["reason"].values == "")
    if not tests.sizes["test"]:
        reason = attribute_texts(comparison, "tests_without_result")[0]
        raise InputError(f"no test of the scene has a result yet: {reason}")
    ratio_at_5, ratio_at_50, ratio_at_95 = map(math.exp, comparison.attrs["levels"])
    figure, axes = style.canvas((8.0, 1.8 + 0.35 * tests.sizes["test"]))
    legend: dict[str, Any] = {
        UNDECIDED_LABEL: axes.axvspan(ratio_at_5, ratio_at_95, **style.BAND),
        "boundary with tests (50 %)": axes.axvline(ratio_at_50, **style.BOUNDARY),
        "computed boundary": axes.axvline(1.0, color=BLACK, lw=style.THIN),
    }
    log_ratios = [tests[f"log_rise_ratio_{end}"].values for end in ("mild", "severe")]
    ratios = np.exp(np.stack(log_ratios, axis=1))
    outcomes = tests["outcome"].values.tolist()
    for row, ratios_of_test in enumerate(ratios):
        ends = ratios_of_test[np.isfinite(ratios_of_test)]
        axes.plot(ends, [row] * len(ends), color=GREY)
        position = float(ends.mean()), row
        _draw_test(axes, str(tests["test"].values[row]), outcomes[row], position)
    legend |= _legend_of(outcomes)
    padding = 1.15  # factor from the outermost ratios to the ends of the axis
    lowest, highest = min(ratio_at_5, np.nanmin(ratios)), max(ratio_at_95, np.nanmax(ratios))
    axes.set(xscale="log", xlim=(lowest / padding, highest * padding))
    axes.set_ylim(len(ratios) - 0.7, -0.3)
    points = zip(tests["load"].values, tests["velocity"].values, strict=True)
    axes.set_yticks(range(len(ratios)), [f"{load:g} N, {speed:g} m/s" for load, speed in points])
    style.plain_numbers(axes)
    axes.set(xlabel="computed rise ratio of the test")
    title = style.as_text(sweep_of(ds).title)
    style.write_title(axes, f"{title}\ntests, each at its own conditions")
    caption = f"model error: {attribute_texts(comparison, 'model_error')[0]}"
    if missing := comparison.sizes["test"] - len(ratios):
        caption += f"\n{missing} of {comparison.sizes['test']} tests have no result"
    style.legend_below(
        figure, 2, handles=[*legend.values()], labels=[*legend], caption=caption,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )  # fmt: skip
    return figure


def _draw_test(
    axes: Axes,
    number: str,
    outcome: str,
    position: tuple[float, float],
    is_faint: bool = False,
    label_position: tuple[float, float] | None = None,
) -> None:
    """Mark a test at its `position` (x, y), and write its number to the right of it.

    If `label_position` is given, the number is to the right of this position instead.
    """
    marker, face = TESTS[outcome]
    axes.plot(
        *position, marker, ms=style.BIG * rcParams["lines.markersize"], clip_on=False, zorder=4,
        alpha=FAINT if is_faint else 1.0, mfc=face, mec=BLACK if face == "white" else "white",
        gid=f"test {outcome}, elsewhere" if is_faint else f"test {outcome}",
    )  # fmt: skip
    axes.annotate(
        style.as_text(number), label_position or position, (8, 0), textcoords="offset points",
        fontsize="small", va="center", color=BLACK, gid="number of a test", path_effects=style.HALO,
        zorder=5,
    )  # fmt: skip


def _legend_of(outcomes: Iterable[str]) -> dict[str, Any]:
    """Entry of a legend with the marks of all outcomes of tests."""
    present = {*outcomes}
    marks = {
        outcome: Line2D([], [], ls="none", marker=marker, mfc=face, mec=BLACK)
        for outcome, (marker, face) in TESTS.items()
        if outcome in present
    }
    return {f"test: {', '.join(marks)}": tuple(marks.values())} if marks else {}


def mark_tests(
    axes: Axes,
    case: CaseResults,
    bulk_temperature: float,
    friction: float,
    moved_velocities: Mapping[int, float],
) -> tuple[list[OperatingPoint], dict[str, Any], list[str]]:
    """Mark the tests in or near the sweep's range, faint if at another `bulk_temperature` [K].

    `moved_velocities` has velocities [m/s] at which tests would lie at the `friction` of the line,
    by position in the list of tests. There, an open mark is joined to that of the test. Returns the
    operating points of the tests, their entries of the legend, and notes for the caption.
    """
    sweep_bulk = case.sweep.conditions.bulk_temperature
    max_axis_ratio = 1.5  # factor on the ends of the sweep beyond which tests are not drawn
    points, outcomes, omitted = list[OperatingPoint](), list[str](), list[str]()
    has_moved = has_faint = False
    for index, test in enumerate(case.sweep.tests):
        number = test.number or str(index + 1)
        load, velocity = test.normal_load, abs(test.velocity)
        if not all(
            simulated[0] / max_axis_ratio <= value <= max_axis_ratio * simulated[-1]
            for value, simulated in ((load, case.loads), (velocity, case.velocities))
        ):
            omitted.append(number)
            continue
        bulk_difference = abs((test.bulk_temperature or sweep_bulk) - bulk_temperature)
        is_faint, label_velocity = bulk_difference > 1.0, velocity
        if index in moved_velocities and not is_faint:
            moved_velocity = moved_velocities[index]
            label_velocity = max(velocity, moved_velocity)
            axes.plot(
                [velocity, moved_velocity], [load, load], color=BLACK, lw=1.5, zorder=3.5,
                clip_on=False,
            )  # fmt: skip
            axes.plot(
                moved_velocity, load, TESTS[test.outcome][0],
                ms=1.4 * rcParams["lines.markersize"], mfc="white", mec=BLACK, clip_on=False,
                zorder=4, gid="test at the line's friction",
            )  # fmt: skip
            has_moved = True
        _draw_test(axes, number, test.outcome, (velocity, load), is_faint, (label_velocity, load))
        outcomes.append(test.outcome)
        points.append((load, velocity))
        has_faint |= is_faint
    notes = ["faint: tests at another bulk temperature"] if has_faint else []
    if len(omitted) == 1:
        notes.append(f"not shown (outside the axes): test {omitted[0]}")
    elif omitted:
        notes.append(f"not shown (outside the axes): tests {', '.join(omitted)}")
    legend = _legend_of(outcomes)
    if has_moved:
        legend[f"the same test at friction {friction:g}"] = Line2D(
            [], [], ls="none", marker="D", mfc="white", mec=BLACK
        )
    return points, legend, notes


def velocities_at_friction(
    ds: xr.Dataset, case: CaseResults, conditions: Mapping[str, Any], friction: float
) -> dict[int, float]:
    """Velocities [m/s] at which tests would lie at a friction, by position in the list of tests.

    There, the rise at this friction is that of the test at its own. Tests at this friction are left
    out, and tests without such a velocity within the sweep.
    """
    velocities, moved_velocities = case.velocities, dict[int, float]()
    nodes = np.geomspace(max(velocities[0], velocities[-1] / 1e3), velocities[-1], 65)
    for index, test in enumerate(case.sweep.tests):
        log_friction_ratio = math.log(test.case.conditions.friction / friction)
        if abs(log_friction_ratio) < 1e-3:
            continue
        line_velocities = np.append(nodes, test.velocity)
        loads = np.full(line_velocities.shape, test.normal_load)
        margins = pipeline.margin(ds, loads, line_velocities, **conditions)
        *line, at_test = margins["log_rise_ratio"].values
        excess = np.array(line) - (at_test + log_friction_ratio)
        crossings = np.flatnonzero(np.diff(np.sign(excess)) != 0)
        if np.isnan(at_test) or not crossings.size:
            continue
        k = crossings[np.abs(nodes[crossings] - test.velocity).argmin()]
        fraction = excess[k] / (excess[k] - excess[k + 1])
        if np.isfinite(fraction):
            moved_velocities[index] = float(nodes[k] * (nodes[k + 1] / nodes[k]) ** fraction)
    return moved_velocities
