"""Ends of points: of one, or of all measured transitions on each of several surfaces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal, Self, get_args

import numpy as np
from matplotlib.axes import Axes

from pipeline.figures.style import BLACK, BLUE, GREEN, VERMILION, celsius
from pipeline.sweep.criterion import contact_temperature
from pipeline.sweep.model import Measurement, Sweep
from tribo import InputError, State, failed_share, measures, simulate
from tribo.criterion import Criterion, columns_of
from tribo.types import Array
from workflows.paper.publication import Row4
from workflows.paper.report import mean, spread
from workflows.paper.study import Study

HIGHEST = Criterion("highest")
"""The highest temperature of the contact."""

WearPattern = Literal["swept", "local"]
PATTERNS: tuple[WearPattern, ...] = get_args(WearPattern)
"""Patterns of wear."""

_SURFACES = 8
_LOOKS = {
    "swept": (BLUE, "o"),
    "local": (VERMILION, "s"),
    "unworn": (GREEN, "^"),
    "swept, bulk 25 °C": (GREEN, "o"),
}


@dataclass(frozen=True, slots=True)
class Ends:
    """Ends of points, each quantity of the shape (), or (transition, surface).

    Attributes
    ----------
    bulk, friction : ndarray
        Bulk temperature [K] and measured friction.
    contact_width : ndarray
        Distance between the outermost elements in contact [m].
    bearing_width : ndarray
        Width of the rows of elements across the sliding direction that carry at least 5 % of
        what the most loaded one carries [m].
    mean_rise, rise_quantile : ndarray
        Rises of the contact at friction 1 [K]; the latter with `tribo.QUANTILES` last.
    """

    bulk: Array
    friction: Array
    contact_width: Array
    bearing_width: Array
    mean_rise: Array
    rise_quantile: Array

    @classmethod
    def of(cls, scene: Sweep, state: State, friction: float | None = None) -> Self:
        """The end of one point, at the scene's friction or a measured one."""
        if state.heat is None:
            raise InputError("a point ended without a temperature")
        carried = state.pressure.mean(axis=1)
        bearing = np.count_nonzero(carried >= 0.05 * carried.max()) * scene.grid.spacing[0]
        width = measures(scene, state)["contact_width"]
        conditions, rises = scene.conditions.at_friction(friction), columns_of(state.heat)
        return cls(
            bulk=np.array(conditions.bulk_temperature),
            friction=np.array(conditions.friction),
            contact_width=np.array(width),
            bearing_width=np.array(bearing),
            mean_rise=np.array(rises["mean_rise"]),
            rise_quantile=rises["rise_quantile"],
        )

    @classmethod
    def stacked(cls, ends: Sequence[Self], axis: int = 0) -> Self:
        """Several ends along a new axis."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.stack([getattr(end, name) for end in ends], axis) for name in names))

    def rise(self, criterion: Criterion) -> Array:
        """Rise at friction 1 that decides by a criterion [K]."""
        columns = {"mean_rise": self.mean_rise, "rise_quantile": self.rise_quantile}
        return np.asarray(criterion.rise(columns))

    def celsius(self, criterion: Criterion) -> Array:
        """Temperature that decides by a criterion [°C]."""
        return np.asarray(celsius(self.bulk + self.friction * self.rise(criterion)))

    def failed_percent(self, critical: float, friction: float | None = None) -> Array:
        """Share of the contact above a critical temperature [K], in percent."""
        limit = (critical - self.bulk) / (friction or self.friction)
        share = np.vectorize(failed_share, signature="(n),()->()")
        return np.asarray(100 * share(self.rise_quantile, limit))


def end_of(scene: Sweep, test: Measurement | Row4) -> Ends:
    """Simulate a test."""
    *_, state = simulate(scene, test.normal_load, test.velocity)
    return Ends.of(scene, state, test.friction)


def history(
    scene: Sweep, load: float, velocity: float, criterion: Criterion
) -> tuple[Array, Array, State]:
    """Simulate a point: times [s] with the temperatures that decide [°C], and its last state."""
    times, temperatures = [0.0], [float(celsius(contact_temperature(0.0, scene.conditions)))]
    for state in simulate(scene, load, velocity):
        if state.heat is not None:
            times.append(state.time)
            temperatures.append(float(Ends.of(scene, state).celsius(criterion)))
    return np.array(times), np.array(temperatures), state


def exponent_of(scene: Sweep, entry: Measurement, rise: float, step: float) -> float:
    """Exponent of the deciding rise over the velocity, from a step of the latter's logarithm."""
    faster = replace(entry, velocity=entry.velocity * math.exp(step))
    other = float(end_of(scene, faster).rise(scene.conditions.decisive))
    return math.log(other / rise) / step


Transition = tuple[Sweep, Measurement]
"""A measured transition in its scene."""


def ensemble(
    study: Study,
    wears: Sequence[WearPattern | Literal["unworn"]],
    transitions: Sequence[Transition],
    what: str = "{}",
    surfaces: int = _SURFACES,
) -> dict[str, Ends]:
    """Simulate measured transitions with each kind of wear on each surface."""
    ends: dict[str, Ends] = {}
    for wear in wears:
        on_surfaces = []
        label = f"{what.format(wear)}, surface {{}}".format
        for seed in study.stages(study.seeds(surfaces), label):
            points = [end_of(worn(s.on_surface(seed), wear), test) for s, test in transitions]
            on_surfaces.append(Ends.stacked(points))
        ends[wear] = Ends.stacked(on_surfaces, axis=1)
    return ends


def matching(sweep: Sweep, loads: Sequence[float]) -> list[Measurement]:
    """The scene's measured transitions at the loads of a table, in the table's order."""
    by_load = {entry.normal_load: entry for entry in sweep.measured}
    if set(loads) - set(by_load):
        raise InputError(f"the scene {sweep.name} must have measured transitions at {loads} N")
    return [by_load[load] for load in loads]


def worn(sweep: Sweep, wear: WearPattern | Literal["unworn"]) -> Sweep:
    """The scene unworn, or with its wear in a pattern."""
    if wear == "unworn":
        return replace(sweep, wear=None)
    if sweep.wear is None:
        raise InputError(f"the scene {sweep.name} must have a [wear]")
    return replace(sweep, wear=replace(sweep.wear, pattern=wear))


def name_of(entry: Measurement) -> str:
    """Load and velocity, in words."""
    return f"{entry.normal_load:g} N, {entry.velocity:g} m/s"


def beside(
    axes: Axes,
    ticks: Sequence[str],
    printed: Array | None,
    values: Mapping[str, Array],
    title: str,
) -> None:
    """Mark the printed values, and beside each the mean and spread of ours."""
    places = np.arange(len(ticks))
    if printed is not None:
        axes.plot(places - 0.2, printed, "D", color=BLACK, ms=6, label="printed")
    for number, (name, row) in enumerate(values.items()):
        colour, marker = _LOOKS[name]
        axes.errorbar(
            places + 0.14 * number - 0.06, mean(row), spread(row),
            color=colour, marker=marker, ls="none", capsize=3, label=f"computed, {name}",
        )  # fmt: skip
    axes.set_xticks(places, ticks)
    axes.set(xlim=(-0.5, len(ticks) - 0.5), title=title)
