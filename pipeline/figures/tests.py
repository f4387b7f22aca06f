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
from pipeline.answers import words
from pipeline.answers.results import CaseResults, refuse_cases, sweep_of
from pipeline.figures import style
from pipeline.figures.style import BLACK, FAINT, GREY
from pipeline.sweep.case import OperatingPoint
from tribo import InputError

TESTS = {"mild": ("o", "white"), "severe": ("o", BLACK), "transition": ("D", BLACK)}
"""Marker and face colour of a test, by its outcome."""
UNDECIDED_LABEL = "undecided: severe wear 5 to 95 % probable"
"""Label in legends."""
_REACH = 1.5  # tests beyond this factor on the sweep's ends are not drawn
_SAME_BULK = 1.0  # bulk temperatures that differ less count as equal [K]
_ROOM = 0.3  # above and below the rows of tests
_Y = "log_rise_ratio"
_BESIDE = 1.15  # factor between the outermost values and the axis' ends


@style.house_style
def draw_tests(ds: xr.Dataset, conditions: Mapping[str, Any]) -> Figure:
    """Draw rise ratio of each test, at its own conditions, and the band that they leave.

    A bar joins the mild and the severe end of a transition with a step. The caption counts tests
    without a result.
    """
    refuse_cases(ds)
    found = pipeline.compare_tests(ds, **conditions)
    if not found.sizes["test"]:
        raise InputError("the scene has no tests to draw; add [[tests]] to it")
    known = found.isel(test=found["reason"].values == "")
    if not known.sizes["test"]:
        why = found.attrs["tests_without_result"]
        raise InputError(f"no test of the scene has a result yet: {why}")
    low, middle, high = map(math.exp, found.attrs["levels"])
    figure, axes = style.canvas((8.0, 1.8 + 0.35 * known.sizes["test"]))
    legend: dict[str, Any] = {
        UNDECIDED_LABEL: axes.axvspan(low, high, **style.BAND),
        "boundary with tests (50 %)": axes.axvline(middle, **style.BOUNDARY),
        "computed boundary": axes.axvline(1.0, color=BLACK, lw=style.THIN),
    }
    pairs = np.exp(np.stack([known[f"{_Y}_mild"].values, known[f"{_Y}_severe"].values], axis=1))
    outcomes = known["outcome"].values.tolist()
    for place, pair in enumerate(pairs):
        ends = pair[np.isfinite(pair)]
        axes.plot(ends, [place] * len(ends), color=GREY)
        at = float(ends.mean()), place
        draw_test_marker(axes, str(known["test"].values[place]), outcomes[place], at)
    legend |= legend_of_tests(outcomes)
    ends = np.array([min(low, np.nanmin(pairs)) / _BESIDE, max(high, np.nanmax(pairs)) * _BESIDE])
    axes.set(xscale="log", xlim=ends, ylim=(len(pairs) - 1 + _ROOM, -_ROOM))
    places = zip(known["load"].values, known["velocity"].values, strict=True)
    axes.set_yticks(range(len(pairs)), [f"{load:g} N, {speed:g} m/s" for load, speed in places])
    style.plain_numbers(axes)
    axes.set(xlabel="computed rise ratio of the test")
    title = style.as_text(sweep_of(ds).title)
    style.write_title(axes, f"{title}\ntests, each at its own conditions")
    caption = f"model error: {words.attribute_texts(found, 'model_error')[0]}"
    if missing := found.sizes["test"] - len(pairs):
        caption += f"\n{missing} of {found.sizes['test']} tests have no result"
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
    axes: Axes, number: str, outcome: str, place: tuple[float, float], faint: bool = False
) -> None:
    """Mark a test at its `place` (x, y), with its number beside."""
    marker, face = TESTS[outcome]
    look: dict[str, Any] = {"mfc": face, "mec": BLACK if face == "white" else "white"}
    axes.plot(
        *place, marker, ms=style.BIG * rcParams["lines.markersize"], clip_on=False, zorder=4,
        alpha=FAINT if faint else 1.0, gid=f"test {outcome}{', elsewhere' * faint}", **look,
    )  # fmt: skip
    axes.annotate(
        number, place, (6, 4), textcoords="offset points", fontsize="small", color=BLACK,
        gid="number of a test", path_effects=style.HALO,
    )  # fmt: skip


def legend_of_tests(outcomes: Iterable[str]) -> dict[str, Any]:
    """One entry of a legend for all kinds of tests among `outcomes`, side by side."""
    found = {*outcomes}
    shown = {outcome: look for outcome, look in TESTS.items() if outcome in found}
    marks = tuple(
        Line2D([], [], ls="none", marker=marker, mfc=face, mec=BLACK)
        for marker, face in shown.values()
    )
    return {f"test: {', '.join(shown)}": marks} if marks else {}


def mark_tests(
    axes: Axes, case: CaseResults, bulk: float
) -> tuple[list[OperatingPoint], dict[str, Any], list[str]]:
    """Mark the tests in or near the sweep's range, faint if their bulk temperature is not `bulk`.

    Returns their places, their entry of the legend, and lines of the caption.
    """
    own = case.sweep.conditions.bulk_temperature
    places, kinds, far, others = list[OperatingPoint](), list[Any](), list[str](), False
    for position, test in enumerate(case.sweep.tests, 1):
        number, place = test.number or str(position), (test.normal_load, abs(test.velocity))
        pairs = zip(place, (case.loads, case.velocities), strict=True)
        if not all(axis[0] / _REACH <= at <= _REACH * axis[-1] for at, axis in pairs):
            far.append(number)
            continue
        faint = abs((test.bulk_temperature or own) - bulk) > _SAME_BULK
        kinds.append(test.outcome)
        draw_test_marker(axes, number, kinds[-1], (place[1], place[0]), faint)
        places.append(place)
        others |= faint
    caption = ["faint: tests at another bulk temperature"] * others
    caption += [
        f"not shown (outside the axes): test{'s' * (len(far) > 1)} {', '.join(far)}"
    ] * bool(far)
    return places, legend_of_tests(kinds), caption
