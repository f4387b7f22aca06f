"""What Tables 4 and 6 share: measured transitions over an ensemble of random surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
from matplotlib.axes import Axes

from pipeline.figures.style import BLACK, BLUE, GREEN, VERMILION
from pipeline.sweep.model import Measurement, Sweep
from tribo import InputError
from workflows.paper.report import statistics
from workflows.paper.study import End, Study, end_of

WearPattern = Literal["swept", "local"]
PATTERNS: tuple[WearPattern, ...] = get_args(WearPattern)
Values = list[list[float]]
"""Values by transition and surface."""
Variants = dict[str, list[list[End]]]
"""Ends of points by kind of wear, transition and surface."""

_SURFACES = 8
_LOOKS = {
    "swept": (BLUE, "o"),
    "local": (VERMILION, "s"),
    "unworn": (GREEN, "^"),
    "swept, bulk 25 °C": (GREEN, "o"),
}


def matching(sweep: Sweep, loads: Sequence[float]) -> list[Measurement]:
    """The scene's measured transitions at the loads of a table, in the table's order."""
    by_load = {entry.normal_load: entry for entry in sweep.measured}
    if set(loads) - set(by_load):
        raise InputError(f"the scene {sweep.name} must have measured transitions at {loads} N")
    return [by_load[load] for load in loads]


def with_wear(sweep: Sweep, pattern: WearPattern) -> Sweep:
    """The scene with its wear in another pattern."""
    if sweep.wear is None:
        raise InputError(f"the scene {sweep.name} must have a [wear]")
    return replace(sweep, wear=replace(sweep.wear, pattern=pattern))


def over_surfaces(
    study: Study, sweep: Sweep, measured: Sequence[Measurement], what: str
) -> list[list[End]]:
    """Simulate the measured transitions on each surface; their ends by transition and surface."""
    found: list[list[End]] = [[] for _ in measured]
    for seed in study.each(study.seeds(_SURFACES), lambda seed: f"{what}, surface {seed}"):
        surface = sweep.on_surface(seed)
        for column, entry in zip(found, measured, strict=True):
            column.append(end_of(surface, entry.normal_load, entry.velocity))
    return found


def name_of(entry: Measurement) -> str:
    """Load and velocity, in words."""
    return f"{entry.normal_load:g} N, {entry.velocity:g} m/s"


def means(values: Values) -> list[float]:
    """Mean over the surfaces of each transition."""
    return [statistics(column)[0] for column in values]


def range_of(values: Sequence[float], digits: int = 0) -> str:
    """Lowest and highest value, in words."""
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}"


def beside(
    axes: Axes,
    ticks: Sequence[str],
    printed: list[float] | None,
    values: dict[str, Values],
    title: str,
) -> None:
    """Mark the printed values, and beside each the mean and spread of ours."""
    at = np.arange(len(ticks))
    if printed is not None:
        axes.plot(at - 0.2, printed, "D", color=BLACK, ms=6, label="printed")
    for number, (name, columns) in enumerate(values.items()):
        colour, marker = _LOOKS[name]
        mean, spread = np.array([statistics(column) for column in columns]).T
        axes.errorbar(
            at + 0.14 * number - 0.06, mean, spread,
            color=colour, marker=marker, ls="none", capsize=3, label=f"computed, {name}",
        )  # fmt: skip
    axes.set_xticks(at, ticks)
    axes.set_xlim(-0.5, len(ticks) - 0.5)
    axes.set_title(title)
