"""The laboratory's tests: their marks in the diagram, and the figure of the rise ratio of each."""

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
from pipeline.answers.condition_values import override_conditions
from pipeline.answers.facts import fact_lines
from pipeline.answers.results import refuse_cases, sweep_of
from pipeline.answers.value_text import attribute_texts
from pipeline.answers.verdict_model import VerdictModel, verdict_model
from pipeline.figures import style
from pipeline.figures.style import BLACK, FAINT, GREY
from pipeline.sweep.case import OperatingPoint, SpecimenTest
from tribo import InputError

TESTS = {"mild": ("o", "white"), "severe": ("o", BLACK), "transition": ("D", BLACK)}
"""Marker and face colour of a test, by its outcome."""
UNDECIDED_LABEL = "undecided: neither mild nor severe wear is sure"
"""Label in legends."""
_MAX_AXIS_RATIO = 1.5  # factor on the ends of the sweep beyond which tests are not drawn


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
    ratios, outcomes = np.exp(np.stack(log_ratios, axis=1)), tests["outcome"].values.tolist()
    for row, (number, outcome) in enumerate(zip(tests["test"].values, outcomes, strict=True)):
        ends = ratios[row][np.isfinite(ratios[row])]
        axes.plot(ends, [row] * len(ends), color=GREY)
        _draw_test(axes, str(number), outcome, (float(ends.mean()), row))
    legend |= _legend_of(outcomes)
    axes.set(xscale="log", ylim=(len(ratios) - 0.7, -0.3))
    axes.margins(x=0.1)
    points = zip(tests["load"].values, tests["velocity"].values, strict=True)
    axes.set_yticks(range(len(ratios)), [f"{load:g} N, {speed:g} m/s" for load, speed in points])
    style.plain_numbers(axes)
    axes.set(xlabel="← mild    computed rise ratio    severe →")
    title = style.as_text(sweep_of(ds).title)
    style.write_title(axes, f"{title}\ntests, each at its own conditions")
    (caption,) = fact_lines(comparison, "model error")
    if missing := comparison.sizes["test"] - len(ratios):
        caption += f"\n{missing} of {comparison.sizes['test']} tests have no result"
    style.legend_below(
        figure, 2, handles=[*legend.values()], labels=[*legend], caption=caption,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )  # fmt: skip
    return figure


def _draw_test(
    axes: Axes, number: str, outcome: str, position: tuple[float, float], is_faint: bool = False,
    label_x: float = -math.inf,
) -> None:  # fmt: skip
    """Mark a test at its `position` (x, y), its number at the right, also of `label_x`."""
    marker, face = TESTS[outcome]
    axes.plot(
        *position, marker, ms=style.BIG * rcParams["lines.markersize"], clip_on=False, zorder=4,
        alpha=FAINT if is_faint else 1.0, mfc=face, mec=BLACK if face == "white" else "white",
        gid=f"test {outcome}, elsewhere" if is_faint else f"test {outcome}",
    )  # fmt: skip
    axes.annotate(
        style.as_text(number), (max(position[0], label_x), position[1]), (8, 0),
        textcoords="offset points", fontsize="small", va="center", color=BLACK,
        gid="number of a test", path_effects=style.HALO, zorder=5,
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
    axes: Axes, case: CaseResults, conditions: Mapping[str, Any]
) -> tuple[list[OperatingPoint], dict[str, Any], list[str]]:
    """Mark the tests in or near the sweep's range, faint if at another bulk temperature.

    A test at another friction than that of the line is joined to an open mark, at the velocity at
    which the rise at the line's friction is that of the test. Returns the operating points of the
    tests, their entries of the legend, and notes for the caption.
    """
    points, outcomes, omitted = list[OperatingPoint](), list[str](), list[str]()
    if not case.sweep.tests:
        return [], {}, []
    model = verdict_model(case, override_conditions(case.conditions, conditions))
    if model.omitted_tests:
        return [], {}, []
    legend, has_faint = dict[str, Any](), False
    for index, test in enumerate(case.sweep.tests):
        number = test.number or str(index + 1)
        load, velocity = test.normal_load, test.velocity
        if not all(
            simulated[0] / _MAX_AXIS_RATIO <= value <= _MAX_AXIS_RATIO * simulated[-1]
            for value, simulated in ((load, case.loads), (velocity, case.velocities))
        ):
            omitted.append(number)
            continue
        bulk = test.case.conditions.bulk_temperature
        is_faint = abs(bulk - model.conditions.bulk_temperature) > 1.0
        has_faint |= is_faint
        moved = -math.inf if is_faint else _velocity_at_friction(model, test)
        _draw_test(axes, number, test.outcome, (velocity, load), is_faint, label_x=moved)
        if math.isfinite(moved):
            axes.plot(
                [velocity, moved], [load, load], color=BLACK, lw=1.5, zorder=3.5, clip_on=False
            )
            axes.plot(
                moved, load, TESTS[test.outcome][0], ms=1.4 * rcParams["lines.markersize"],
                mfc="white", mec=BLACK, clip_on=False, zorder=4, gid="test at the line's friction",
            )  # fmt: skip
            label = f"the same test at friction {model.conditions.friction:g}"
            legend[label] = Line2D(
                [], [], ls="none", marker=TESTS[test.outcome][0], mfc="white", mec=BLACK
            )
        outcomes.append(test.outcome)
        points.append((load, velocity))
    notes = ["faint: tests at another bulk temperature"] if has_faint else []
    if omitted:
        notes.append(f"not shown (outside the axes): tests {', '.join(omitted)}")
    return points, _legend_of(outcomes) | legend, notes


def _velocity_at_friction(model: VerdictModel, test: SpecimenTest) -> float:
    """Velocity [m/s] at which a test would lie at the model's friction; −inf if there is none.

    There, the rise at this friction is that of the test at its own.
    """
    friction, test_friction = model.conditions.friction, test.case.conditions.friction
    if math.isclose(friction, test_friction, rel_tol=1e-3) or not friction * test_friction:
        return -math.inf
    load, field = np.array([test.normal_load]), model.field
    log_rise = field(load, np.array([test.velocity])) + math.log(test_friction / friction)
    return float(np.nan_to_num(field.along_velocity(load, log_rise).critical[0], nan=-math.inf))
