"""Overlays on the plane of load and velocity: lines, tests and names of regions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from scipy.ndimage import distance_transform_edt

from pipeline.analysis.results import Results
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, FAINT, THIN, VERMILION
from pipeline.sweep.case import Test
from pipeline.sweep.conditions import Conditions
from tribo import lubrication_regime
from tribo.material import BOUNDARY, FULL_FILM
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array, Mask

_REACH = 1.5  # tests beyond this factor on the sweep's ends are not drawn
_SAME_BULK = 1.0  # bulk temperatures that differ less count as equal [K]
_LEVELS = ((BOUNDARY, "mixed", ":"), (FULL_FILM, "full film", "-."))
"""Film parameters Λ, the regime above each, and the dashes of its line."""


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


def film_lines(axes: Axes, data: Results, conditions: Conditions) -> list[Artist]:
    """Draw the limits of mixed and full-film lubrication in a figure; return legend entries."""
    lubrication = find_lubrication(data.sweep.scene, data.sweep.lubricant)
    if lubrication is None:
        return []
    y, x = (np.linspace(*axis[[0, -1]]) for axis in (data.loads, data.velocities))
    film = lubrication.film_parameter(y[:, None], x, conditions.mean_bulk_temperature)
    legend: list[Artist] = []
    for level, beyond, dashes in _LEVELS:
        label = f"Λ = {level:g}, {beyond} beyond"
        look: dict[str, Any] = {"color": BLACK, "lw": THIN, "ls": dashes}
        if zero_line(axes, x, y, film - level, label, **look):
            legend.append(Line2D([], [], label=label, **look))
    if not legend:
        label = f"Λ {film.min():.2f} to {film.max():.2f}: {lubrication_regime(float(film.mean()))}"
        legend.append(Line2D([], [], ls="none", label=label))
    return legend


TESTS: dict[str | None, tuple[str, ...]] = {
    None: ("measured transition", "measured", "D", BLACK, "white"),
    "mild": ("test: mild wear", "tested-mild", "^", "white", BLACK),
    "severe": ("test: severe wear", "tested-severe", "^", BLACK, "white"),
}
"""Label, SVG id, marker, face colour and edge colour of a test, by its outcome."""


def mark_test(
    axes: Axes, number: str, test: Test, place: tuple[float, float], beside: str = ""
) -> Line2D:
    """Mark a test at its `place` (x, y) with its number: open if wear stayed mild, else filled.

    `beside` is a remark that follows the name of the test's outcome in the legend. With a remark
    the mark is faint.
    """
    name, gid, marker, mfc, mec = TESTS[test.outcome]
    label, present = name + beside, axes.get_legend_handles_labels()[1]
    (mark,) = axes.plot(
        *place, ls="none", marker=marker, ms=style.BIG * rcParams["lines.markersize"], mfc=mfc,
        mec=mec, alpha=FAINT if beside else 1.0, gid=f"{gid}-elsewhere" if beside else gid,
        label="" if label in present else label,
    )  # fmt: skip
    axes.annotate(
        number, place, (6, 3), textcoords="offset points", fontsize="small", color=BLACK,
        gid="number of a test", path_effects=style.HALO,
    )  # fmt: skip
    return mark


def mark_tests(axes: Axes, tests: Mapping[str, Test], bulk: float, own_bulk: float) -> list[Artist]:
    """Mark tests, faint if their bulk temperature is not `bulk` [K]; return the legend.

    `own_bulk` [K] is the bulk temperature of tests that give none.
    """
    marks = list[Line2D]()
    for number, test in tests.items():
        is_other = abs((test.bulk_temperature or own_bulk) - bulk) > _SAME_BULK
        beside = ", at another bulk temperature" * is_other
        marks.append(mark_test(axes, number, test, (test.velocity, test.normal_load), beside))
    return [mark for mark in marks if not str(mark.get_label()).startswith("_")]  # one of each kind


def number_tests(tests: Iterable[Test]) -> dict[str, Test]:
    """Tests by number; a test without a number gets its position in the scene."""
    return {test.number or str(place): test for place, test in enumerate(tests, 1)}


def reachable_tests(
    data: Results, tests: Mapping[str, Test]
) -> tuple[dict[str, Test], list[Artist]]:
    """Tests in or near the sweep's range, by number, and a legend line that lists the rest."""
    ends = {"load": data.loads[[0, -1]], "velocity": data.velocities[[0, -1]]}

    def is_near(test: Test) -> bool:
        place = {"load": test.normal_load, "velocity": abs(test.velocity)}
        return all(low / _REACH <= place[k] <= _REACH * high for k, (low, high) in ends.items())

    near = {number: test for number, test in tests.items() if is_near(test)}
    if not (far := [number for number in tests if number not in near]):
        return near, []
    words = f"outside the figure: test{'s' * (len(far) > 1)} {', '.join(far)}"
    return near, [Line2D([], [], ls="none", label=words)]


MILD, SEVERE = "mild wear (I and II)", "severe adhesive wear (III* and III)"
REGION = "region"
"""SVG id of the names of regions."""
_WIDE = 3.0  # width of a name over its height
_LEAST_ROOM = 0.1  # least room around a name, as a share of the figure's width


def name_regions(axes: Axes, x: Array, y: Array, mild: Mask, severe: Mask) -> None:
    """Write "mild" and "severe" where the regions of these masks (load, velocity) are widest.

    A region without room has no name. `x` are velocities [m/s], `y` loads [N].
    """
    for inside, name, colour in ((mild, MILD, BLUE), (severe, SEVERE, VERMILION)):
        padded = np.pad(inside, 1)  # the edges of the diagram bound the region, too
        room = distance_transform_edt(padded, sampling=(_WIDE / len(y), 1 / len(x)))[1:-1, 1:-1]
        row, column = np.unravel_index(int(room.argmax()), room.shape)
        if room[row, column] > _LEAST_ROOM:
            axes.text(
                x[column], y[row], name.replace(" (", "\n("), ha="center", va="center",
                fontweight="bold", color=colour, gid=REGION, path_effects=style.HALO,
            )  # fmt: skip
