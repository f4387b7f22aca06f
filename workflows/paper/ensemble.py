"""Measured transitions over an ensemble of random surfaces, as Tables 4 and 6 have them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from matplotlib.axes import Axes

from pipeline.figures.style import BLACK, BLUE, GREEN, VERMILION
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Measurement, Sweep
from tribo import InputError
from workflows.paper.report import statistics
from workflows.paper.study import End, Study, WearPattern, end_of, with_wear

Values = list[list[float]]
"""Values by transition and surface."""

_SURFACES = 8
_LOOKS = {
    "swept": (BLUE, "o"),
    "local": (VERMILION, "s"),
    "unworn": (GREEN, "^"),
    "swept, bulk 25 °C": (GREEN, "o"),
}


@dataclass(frozen=True, slots=True)
class Ensemble:
    """Ends of the measured transitions on each surface.

    Attributes
    ----------
    measured : tuple of Measurement
        Measured transitions.
    conditions : tuple of Conditions
        Conditions of each, with its own friction.
    ends : dict
        Ends of points by kind of wear, transition and surface.
    """

    measured: tuple[Measurement, ...]
    conditions: tuple[Conditions, ...]
    ends: dict[str, list[list[End]]]

    def __add__(self, other: Ensemble) -> Ensemble:
        """Both sets of transitions, one after the other."""
        return Ensemble(
            self.measured + other.measured,
            self.conditions + other.conditions,
            {name: ends + other.ends[name] for name, ends in self.ends.items()},
        )

    def of(self, wear: str, quantity: Callable[[End, Conditions], float]) -> Values:
        """A quantity of the ends with a kind of wear."""
        pairs = zip(self.conditions, self.ends[wear], strict=True)
        return [[quantity(end, conditions) for end in column] for conditions, column in pairs]

    def widths(self, wear: str) -> Values:
        """Widths between the outermost elements in contact [µm]."""
        return self.of(wear, lambda end, _: 1e6 * end.contact_width)

    def of_all(self, quantity: Callable[[End, Conditions], float]) -> dict[str, Values]:
        """A quantity by the kind of wear."""
        return {wear: self.of(wear, quantity) for wear in self.ends}


def ensemble(
    study: Study, kinds: dict[str, Sweep], measured: Sequence[Measurement], what: str = "{}"
) -> Ensemble:
    """Simulate measured transitions on each surface, with each kind of wear."""
    (sweep, *_) = kinds.values()
    ends: dict[str, list[list[End]]] = {kind: [[] for _ in measured] for kind in kinds}
    for kind, scene in kinds.items():
        name = f"{what.format(kind)}, surface {{}}".format
        for seed in study.each(study.seeds(_SURFACES), name):
            surface = scene.on_surface(seed)
            for column, entry in zip(ends[kind], measured, strict=True):
                column.append(end_of(surface, entry.normal_load, entry.velocity))
    conditions = (sweep.conditions.at_friction(entry.friction) for entry in measured)
    return Ensemble(tuple(measured), tuple(conditions), ends)


def matching(sweep: Sweep, loads: Sequence[float]) -> list[Measurement]:
    """The scene's measured transitions at the loads of a table, in the table's order."""
    by_load = {entry.normal_load: entry for entry in sweep.measured}
    if set(loads) - set(by_load):
        raise InputError(f"the scene {sweep.name} must have measured transitions at {loads} N")
    return [by_load[load] for load in loads]


def worn(sweep: Sweep) -> dict[str, Sweep]:
    """The scene with its wear in each pattern."""
    return {pattern: with_wear(sweep, pattern) for pattern in get_args(WearPattern)}


def name_of(entry: Measurement) -> str:
    """Load and velocity, in words."""
    return f"{entry.normal_load:g} N, {entry.velocity:g} m/s"


def beside(
    axes: Axes,
    ticks: Sequence[str],
    printed: list[float] | None,
    values: dict[str, Values],
    title: str,
) -> None:
    """Mark the printed values, and beside each the mean and spread of ours."""
    places = np.arange(len(ticks))
    if printed is not None:
        axes.plot(places - 0.2, printed, "D", color=BLACK, ms=6, label="printed")
    for number, (name, columns) in enumerate(values.items()):
        colour, marker = _LOOKS[name]
        mean, spread = np.array([statistics(column) for column in columns]).T
        axes.errorbar(
            places + 0.14 * number - 0.06, mean, spread,
            color=colour, marker=marker, ls="none", capsize=3, label=f"computed, {name}",
        )  # fmt: skip
    axes.set_xticks(places, ticks)
    axes.set_xlim(-0.5, len(ticks) - 0.5)
    axes.set_title(title)
