"""Lines, marks and names over the diagram: lift-off by the film, measurements, regions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from scipy.ndimage import distance_transform_edt

from pipeline.analysis.dataset import stored_sweep
from pipeline.analysis.field import point_field
from pipeline.analysis.laboratory import are_near, critical_velocity, own_conditions
from pipeline.figures import style
from pipeline.figures.style import BLACK, BLUE, FAINT, GREY, THIN, VERMILION
from pipeline.quantities import display
from pipeline.store.schema import PLANE
from pipeline.sweep.about import Measurement
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.surface import find_lubrication
from tribo import Criterion, InputError, lubrication_regime
from tribo.material import BOUNDARY, FULL_FILM
from tribo.types import Array, Mask

_REACH = 1.5  # times the ends of the sweep, beyond which a test would shrink the figure
_SAME_BULK = 1.0  # [K] between bulk temperatures
Place = tuple[float, float]
_LEVELS = (
    (BOUNDARY, "mixed", ":"),
    (FULL_FILM, "full film", "-."),
)
"""Levels of Λ, what begins there, and the dashes of their lines."""


def film_lines(axes: Axes, ds: xr.Dataset, conditions: Conditions) -> list[Artist]:
    """Draw the beginnings of mixed lubrication and of the full film, if they lie in the figure."""
    lubrication = find_lubrication(stored_sweep(ds))
    if lubrication is None:
        return []
    ends = {name: ds[name].values[[0, -1]].tolist() for name in PLANE}
    places = {name: np.linspace(low, high) for name, (low, high) in ends.items()}
    loads, velocities = np.meshgrid(places["load"], places["velocity"], indexing="ij")
    films = lubrication.film_parameter(loads, velocities, conditions.mean_bulk_temperature)
    film = xr.DataArray(films, places, PLANE)
    legend: list[Artist] = []
    for level, beyond, dashes in _LEVELS:
        label = f"Λ = {level:g}, {beyond} beyond"
        look: dict[str, Any] = {"color": BLACK, "lw": THIN, "ls": dashes}
        if isoline(axes, film, level, label, **look):
            legend.append(Line2D([], [], label=label, **look))
    if not legend:
        regime = lubrication_regime(float(film.mean()))
        span = f"{film.min():.2f} to {film.max():.2f}"
        legend.append(Line2D([], [], ls="none", label=f"Λ {span}: {regime}"))
    return legend


TESTS: dict[str | None, tuple[str, ...]] = {
    None: ("measured transition", "measured", "D", BLACK, "white"),
    "mild": ("test: mild wear", "tested-mild", "^", "white", BLACK),
    "severe": ("test: severe wear", "tested-severe", "^", BLACK, "white"),
}
"""Label, gid, marker, and colours of face and edge, by outcome of a test."""


def mark_tests(
    axes: Axes, tests: Sequence[Measurement], bulk: float, own_bulk: float
) -> list[Artist]:
    """Mark measured transitions, and tests: open where wear stayed mild, filled where severe.

    Those at another bulk temperature than that of the plane [K] are faint, and have it beside them;
    a test that gives none has the scene's own.
    """
    legend: list[Artist] = []
    warmer = [test.bulk_temperature or own_bulk for test in tests]
    for outcome, (label, gid, marker, mfc, mec) in TESTS.items():
        for is_other in (False, True):
            of_kind = [
                test
                for test, own in zip(tests, warmer, strict=True)
                if test.outcome == outcome and (abs(own - bulk) > _SAME_BULK) == is_other
            ]
            if of_kind:
                look = {"alpha": FAINT, "gid": f"{gid}-elsewhere"} if is_other else {"gid": gid}
                legend += axes.plot(
                    [test.velocity for test in of_kind],
                    [test.normal_load for test in of_kind],
                    ls="none", marker=marker, ms=style.BIG, mfc=mfc, mec=mec,
                    label=label + (", at another bulk temperature" if is_other else ""), **look,
                )  # fmt: skip
    for test, own in zip(tests, warmer, strict=True):
        if abs(own - bulk) > _SAME_BULK:
            axes.annotate(
                display(own, "°C", 3), (test.velocity, test.normal_load), (0, 7),
                textcoords="offset points", ha="center", fontsize="small", color=GREY,
                gid="bulk of a test",
            )  # fmt: skip
    return legend


def reachable_tests(
    ds: xr.Dataset, tests: Sequence[Measurement]
) -> tuple[list[Measurement], list[Artist]]:
    """Tests within about half the sweep's range beyond it; a line of the legend on the others."""
    ends = {name: ds[name].values[[0, -1]] for name in ("load", "velocity")}
    near, far = list[Measurement](), list[Measurement]()
    for test in tests:
        place = {"load": test.normal_load, "velocity": abs(test.velocity)}
        is_near = all(
            low / _REACH <= place[name] <= _REACH * high for name, (low, high) in ends.items()
        )
        (near if is_near else far).append(test)
    if not far:
        return near, []
    first = f"{far[0].normal_load:g} N at {far[0].velocity:g} m/s"
    more = f" and {len(far) - 1} more" if len(far) > 1 else ""
    return near, [Line2D([], [], ls="none", label=f"beyond the figure: test of {first}{more}")]


def mark_own_transitions(
    axes: Axes, ds: xr.Dataset, tests: Sequence[Measurement], conditions: Conditions
) -> list[Artist]:
    """Mark the transition computed at each test's own conditions, if others, and join both."""
    places, field = [], point_field(ds)
    for test in tests:
        try:
            own = own_conditions(ds, test)
            if are_near(own, conditions, test.velocity):
                continue
            velocity = critical_velocity(field.under(own), test)
        except InputError:  # beyond the sweep, or as warm as the critical temperature
            continue
        if 0 < velocity < math.inf:
            load = test.normal_load
            places.append((velocity, load))
            ends = [velocity, test.velocity], [load, load]
            axes.plot(*ends, color=GREY, lw=THIN, zorder=1.5, gid="to own conditions")
    if not places:
        return []
    line = axes.plot(
        *zip(*places, strict=True), ls="none", marker="D", mfc="white", mec=BLACK,
        label="computed at the test's own conditions", gid="at own conditions",
    )  # fmt: skip
    return list(line)


def isoline(
    axes: Axes, plane: xr.DataArray, level: float, gid: str, color: Any = BLACK, **look: Any
) -> bool:
    """Draw a line at a level of a plane; False if the plane does not pass it."""
    if not plane.min() < level < plane.max():
        return False
    lines = axes.contour(plane["velocity"], plane["load"], plane, [level], colors=[color])
    lines.set(gid=gid, **look)
    return True


MILD, SEVERE = "mild wear (I and II)", "severe adhesive wear (III* and III)"
_LETTER = 0.0115, 0.045  # share of the axes that a letter of a name takes, about
_CROSSED = "Λ", "band edge"  # what a line's mark begins with, over which no name stands
_LEAST_ROOM = 0.5  # share of a label's size, around its middle


def name_regions(
    axes: Axes, plane: xr.DataArray, limit: float, loads: Array, measured: Sequence[Measurement]
) -> None:
    """Name mild and severe wear where each has most room between two rows of points."""
    scale = np.log if axes.get_xscale() == "log" else np.asarray
    (left, right), (bottom, top) = scale(axes.get_xlim()), scale(axes.get_ylim())

    def across(velocity: Any) -> Any:
        return (scale(velocity) - left) / (right - left)

    def up(load: Any) -> Any:
        return (scale(load) - bottom) / (top - bottom)

    x, y = across(plane["velocity"].values), up(plane["load"].values)
    rows, apart = up(np.convolve(loads, [0.5, 0.5], "valid")), np.diff(up(loads))
    taken = [[point.velocity, point.normal_load] for point in measured]
    for line in axes.collections:
        if str(line.get_gid()).startswith(_CROSSED):
            taken += np.concatenate([path.vertices for path in line.get_paths()]).tolist()
    covered = [(across(velocity), up(load)) for velocity, load in taken]
    severe, mild = (of(plane.values, limit) for of in (Criterion.is_severe, Criterion.is_mild))
    for inside, name, colour in ((mild, MILD, BLUE), (severe, SEVERE, VERMILION)):
        for words in (name, name.replace(" (", "\n(")):
            parts = words.split("\n")
            width, height = _LETTER[0] * max(map(len, parts)), _LETTER[1] * len(parts)
            free = rows[apart > height]
            place = _roomiest(inside, x, y, free, covered, (width, height + _LETTER[1]))
            if place is not None:
                axes.text(
                    *place, words, transform=axes.transAxes, ha="center", va="center",
                    fontweight="bold", color=colour, gid=style.REGION, path_effects=style.HALO,
                )  # fmt: skip
                break


def _roomiest(
    inside: Mask, x: Array, y: Array, rows: Array, taken: Sequence[Place], size: Place
) -> Place | None:
    """Roomiest place of a label in a row, counted in sizes of labels; None if none fits."""
    inside = inside.copy()
    for point in taken:
        inside[np.abs(y - point[1]).argmin(), np.abs(x - point[0]).argmin()] = False
    if not rows.size:
        return None
    width, height = size
    steps = (np.ptp(y) / (len(y) - 1) / height, np.ptp(x) / (len(x) - 1) / width)
    # Padded, since the edges of the diagram count as edges of the region.
    room = distance_transform_edt(np.pad(inside, 1), sampling=steps)[1:-1, 1:-1]
    free = np.abs(y - rows[:, None]).argmin(axis=1)
    if room[free].max() < _LEAST_ROOM:
        return None
    row, column = np.unravel_index(int(room[free].argmax()), room[free].shape)
    return float(x[column]), float(y[free[row]])
