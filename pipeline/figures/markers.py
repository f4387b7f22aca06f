"""Marks on figures: tests, open if wear stayed mild, and operating points that a user asks for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pipeline.answers.results import CaseResults
from pipeline.figures import style
from pipeline.figures.style import BLACK, FAINT, OPERATING
from pipeline.sweep.case import OperatingPoint

TESTS = {"mild": ("o", "white"), "severe": ("o", BLACK), "transition": ("D", BLACK)}
"""Marker and face colour of a test, by its outcome."""
_REACH = 1.5  # tests beyond this factor on the sweep's ends are not drawn
_SAME_BULK = 1.0  # bulk temperatures that differ less count as equal [K]
_OF_WORDS = 0.3  # of the width of a figure, for the numbers of an operating point
_OF_EDGE = 0.08  # of the height of a figure, where numbers would lie over an edge
_FEW = 6  # operating points up to which each has its numbers beside


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


def mark_places(axes: Axes, places: Sequence[OperatingPoint]) -> None:
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
