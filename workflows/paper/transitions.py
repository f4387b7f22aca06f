"""Ends of tests: of one, or of measured transitions on each of several surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes

from pipeline import Sweep, run_point
from pipeline.figures.style import BLACK, BLUE, GREEN, VERMILION
from pipeline.quantities import in_unit
from pipeline.sweep.case import allowable_rise
from tribo import InputError, State, measures, simulate
from tribo.simulation import state_rises
from tribo.simulation.lubrication import find_lubrication
from tribo.thermal import failed_share, rise_exceeded
from tribo.types import Array
from tribo.wear import Wear as ArchardWear

from .publication import ROOM_CELSIUS, TABLE_4, TABLE_6
from .recomputed import mean, spread
from .study import Study

HIGHEST = 0.0
"""Share of the contact that exceeds the highest temperature."""

WearPattern = Literal["swept", "local"]
Wear = WearPattern | Literal["unworn"]

Ends = Mapping[str, Any]
"""Quantities at the ends of tests, as `end_at` names them; numbers, or (transition, surface)."""

Tested = tuple[Sweep, Any]
"""A scene, and a transition of a printed table."""

SURFACES = 8
"""Number of random surfaces of an ensemble, if a study names none."""
_LOOKS = {
    "swept": (BLUE, "o"),
    "local": (VERMILION, "s"),
    "unworn": (GREEN, "^"),
    "swept, bulk 25 °C": (GREEN, "^"),
}

SPREAD = "computed: mean and standard deviation over the surfaces"
"""Title of the legend of what `draw_beside` draws."""


def white_oil(study: Study) -> list[Tested]:
    """Transitions of the paper's Table 4, each with its scene."""
    scene = study.scene("table4")
    return [(scene, row) for row in TABLE_4]


def oil_a(study: Study) -> list[Tested]:
    """Transitions of the paper's Table 6, each with the scene of its bulk temperature."""
    cold, hot = study.scene("oil_a"), study.scene("oil_a_hot")
    return [(cold if row.bulk_celsius == ROOM_CELSIUS else hot, row) for row in TABLE_6]


def end_at(sweep: Sweep, state: State, friction: float | None = None) -> Ends:
    """Quantities, by name, at the last state of a test.

    They are the rises at friction 1, those of `tribo.measures`, ``friction`` (the scene's or a
    measured one), ``bulk``, the bulk temperature [K], and ``bearing_width`` [m]. This is the width
    across sliding of rows of elements that carry at least 5 % of the most loaded row.
    """
    conditions, carried = sweep.conditions, state.pressure.mean(axis=1)
    bearing = np.count_nonzero(carried >= 0.05 * carried.max()) * sweep.scene.grid.spacing[0]
    return {
        **measures(sweep.scene, state),
        **state_rises(sweep.scene, state, None),
        "bulk": conditions.bulk_temperature,
        "friction": conditions.friction if friction is None else friction,
        "bearing_width": bearing,
    }


def end_of(sweep: Sweep, test: Any, factor: float = 1.0) -> Ends:
    """Simulate a test of a printed table, at its velocity × `factor`; return `end_at`."""
    *_, state = simulate(sweep.scene, test.normal_load, test.velocity * factor)
    return end_at(sweep, state, test.friction)


def around_transition(sweep: Sweep, test: Any, step: float) -> Ends:
    """Simulate a test and one at a velocity × exp(`step`); return quantities at the test.

    Adds to the quantities of `end_of`: ``rise``, the governing one at friction 1 [K], its
    ``exponent`` over the velocity, and ``velocity_off``, the relative error of the critical
    velocity at the scene's friction.
    """
    conditions, end = sweep.conditions, end_of(sweep, test)
    rise = float(conditions.governing_rise(end))
    above = float(conditions.governing_rise(end_of(sweep, test, math.exp(step))))
    exponent = math.log(above / rise) / step
    off = math.expm1(-math.log(rise / allowable_rise(conditions)) / exponent)
    return {**end, "rise": rise, "exponent": exponent, "velocity_off": off}


def on_surfaces(
    transitions: Sequence[Tested],
    seeds: Iterable[int],
    end: Callable[[Sweep, Any], Ends] = end_of,
) -> Ends:
    """Quantities at the end of transitions (transition, surface), by name; see `end_of`."""
    surfaces = [
        _stacked([end(scene.take_surface(seed), test) for scene, test in transitions])
        for seed in seeds
    ]
    return _stacked(surfaces, axis=1)


def ensemble(study: Study, wears: Sequence[Wear], transitions: Sequence[Tested]) -> dict[str, Ends]:
    """Quantities at the end of transitions (transition, surface), by kind of wear and name."""
    ends: dict[str, Ends] = {}
    for wear in wears:
        seeds = study.stages(study.seeds(SURFACES), f"{wear}, surface {{}}".format)
        ends[wear] = on_surfaces([(worn(scene, wear), test) for scene, test in transitions], seeds)
    return ends


def _stacked(ends: Sequence[Ends], axis: int = 0) -> Ends:
    return {name: np.stack([end[name] for end in ends], axis) for name in ends[0]}


def celsius_of(ends: Ends, share: float) -> Array:
    """Temperature [°C] that a share of the contact exceeds, from quantities of `end_at`."""
    rise = rise_exceeded(ends["rise_quantile"], share)
    return np.asarray(in_unit(ends["bulk"] + ends["friction"] * rise, "°C"))


def failed_percent(ends: Ends, critical: float, friction: float | None = None) -> Array:
    """Percentage of the contact above a critical temperature [K], from quantities of `end_at`."""
    limit = (critical - ends["bulk"]) / (friction or ends["friction"])
    share = np.vectorize(failed_share, signature="(n),()->()")
    return np.asarray(100 * share(ends["rise_quantile"], limit))


def history(sweep: Sweep, load: float, velocity: float, share: float) -> tuple[Array, Array, State]:
    """Simulate a point: times [s], temperatures that a share exceeds then [°C], the last state."""
    result = run_point(sweep.changed("sweep.steps", "course"), load, velocity)
    conditions, columns = sweep.conditions, result.columns
    warm = np.isfinite(columns["mean_rise"])
    rise = np.append(0.0, rise_exceeded(columns["rise_quantile"][warm], share))
    temperature: Array = in_unit(conditions.contact_temperature(rise), "°C")
    return np.append(0.0, columns["time"][warm]), temperature, result.state


def worn(sweep: Sweep, wear: Wear) -> Sweep:
    """Scene without wear, or with this pattern of wear."""
    if wear == "unworn":
        return sweep.changed("wear", None)
    if not isinstance(sweep.scene.wear, ArchardWear):
        raise InputError(f"the scene {sweep.name} must have a [wear] of a constant rate")
    return sweep.changed("wear.pattern", wear)


def film_parameter(sweep: Sweep, test: Any) -> float:
    """Film parameter Λ at a test: minimum film thickness over roughness."""
    lubrication, bulk = (
        find_lubrication(sweep.scene, sweep.lubricant),
        sweep.conditions.bulk_temperature,
    )
    if lubrication is None:
        raise InputError(f"the scene {sweep.name} must have an [oil]")
    return float(lubrication.film_parameter(test.normal_load, test.velocity, bulk))


def label_of(test: Any) -> str:
    """Load and velocity of a test in words."""
    return f"{test.normal_load:g} N, {test.velocity:g} m/s"


def draw_beside(
    axes: Axes,
    ticks: Sequence[str],
    printed: Array | None,
    values: Mapping[str, Array],
    title: str,
) -> None:
    """Draw printed values, and beside each the mean and standard deviation of computed ones."""
    abscissas = np.arange(len(ticks))
    if printed is not None:
        axes.plot(abscissas - 0.2, printed, "D", color=BLACK, ms=6, label="printed")
    for number, (name, row) in enumerate(values.items()):
        colour, marker = _LOOKS[name]
        axes.errorbar(
            abscissas + 0.14 * number - 0.06, mean(row), spread(row),
            color=colour, marker=marker, ls="none", capsize=3, label=f"computed, {name}",
        )  # fmt: skip
    axes.set_xticks(abscissas, ticks)
    axes.set(xlim=(-0.5, len(ticks) - 0.5), title="")
    axes.set_title(title, loc="left")
