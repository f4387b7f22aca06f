"""The critical temperature of a scene's lubricant, from the transitions that were measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.sweep.model import Sweep
from pipeline.sweep.stages import staged
from tribo import Criterion, InputError, Transition, critical_temperature
from tribo.errors import require_positive


@dataclass(frozen=True, slots=True)
class CriticalTemperatures:
    """Critical temperatures from measured transitions, each on each random surface.

    Attributes
    ----------
    transitions : tuple of Transition
        Measured transitions, each with its friction.
    surfaces : tuple of int or None
        Seeds of the surfaces; None for a surface that is not random.
    temperatures : tuple of tuple of float
        Critical temperature by transition and surface [K].
    criterion : Criterion
        Criterion of severe wear by which they are found.

    Examples
    --------
    >>> from tribo import Criterion, Transition
    >>> measured = Transition(600.0, 1.5, 0.1), Transition(200.0, 3.75, 0.094)
    >>> kelvins = (418.0, 420.0), (412.0, 414.0)
    >>> inferred = CriticalTemperatures(measured, (0, 1), kelvins, Criterion())
    >>> inferred.means, inferred.mean
    ((419.0, 413.0), 416.0)
    """

    transitions: tuple[Transition, ...]
    surfaces: tuple[int | None, ...]
    temperatures: tuple[tuple[float, ...], ...]
    criterion: Criterion

    @property
    def means(self) -> tuple[float, ...]:
        """Mean over the surfaces, by transition [K]."""
        return tuple(float(np.mean(row)) for row in self.temperatures)

    @property
    def spreads(self) -> tuple[float | None, ...]:
        """Standard deviation over the surfaces, by transition [K]; None for a single one."""
        return tuple(_spread(row) for row in self.temperatures)

    @property
    def mean(self) -> float:
        """Mean over the transitions [K]."""
        return float(np.mean(self.means))

    @property
    def spread(self) -> float | None:
        """Standard deviation of the transitions' means [K]; None for a single one."""
        return _spread(self.means)

    def as_dict(self) -> dict[str, Any]:
        """Return all values as plain data."""
        rows = zip(self.transitions, self.temperatures, self.means, self.spreads, strict=True)
        return {
            "criterion": self.criterion.name,
            "share": self.criterion.share,
            "surfaces": list(self.surfaces),
            "transitions": [
                transition._asdict() | {"temperatures": list(row), "mean": mean, "spread": spread}
                for transition, row, mean, spread in rows
            ],
            "mean": self.mean,
            "spread": self.spread,
        }


def critical_temperatures(
    sweep: SceneLike,
    progress: Callable[[str], None] | None = None,
    own_laws: bool = False,
) -> CriticalTemperatures:
    """Find the temperature that the failing share exceeds at each measured transition.

    A good model gives the same at all of them: the critical temperature of the lubricant, where
    no rig can measure it (see `tribo.critical_temperature`).

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene, or its path or name, with measured transitions, simulated on each of its
        realizations if it has any. A transition without a friction, a bulk temperature or a hold
        of its own has the sweep's.
    progress : callable, optional
        Called with a line before each transition on each surface, and the time to go.
    own_laws : bool
        See `pipeline.load_scene`.

    Raises
    ------
    InputError
        If no transition was measured, or for a reason of `tribo.critical_temperature`.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> with_one_test = scene.changed(measured=scene.about.measured[:1])
    >>> inferred = pipeline.critical_temperatures(with_one_test)
    >>> f"{inferred.mean - 273.15:.0f} °C"
    '149 °C'
    """
    sweep = sweep_of(sweep, own_laws)
    if not sweep.about.measured:
        raise InputError(
            f"the scene {sweep.about.name} has no measured transition; give it a [[measured]] with "
            "load and velocity"
        )
    conditions = sweep.conditions
    transitions = tuple(
        Transition(
            entry.normal_load,
            entry.velocity,
            conditions.at_friction(entry.friction).friction_at(entry.velocity),
        )
        for entry in sweep.about.measured
    )
    seeds = tuple(map(int, sweep.variants.axes.get("realization", ())))
    surfaces: tuple[int | None, ...] = seeds or (getattr(sweep.scene.roughness, "seed", None),)
    for crossing in transitions:
        require_positive(friction=crossing.friction)
    stages = staged(
        [(seed, number) for seed in surfaces for number in range(len(transitions))],
        progress,
        lambda stage: _worded(sweep, transitions[stage[1]], stage[0]),
        lambda stage: transitions[stage[1]].normal_load,
    )
    temperatures: list[list[float]] = [[] for _ in transitions]
    for seed, number in stages:
        test = sweep.about.measured[number]
        bulk, on_surface = test.bulk_temperature, sweep.on_surface(seed)
        result = critical_temperature(
            (on_surface if test.hold is None else on_surface.held(test.hold)).scene,
            transitions[number : number + 1],
            conditions.bulk_temperature if bulk is None else bulk,
            conditions.decisive,
            conditions.bulk_difference if bulk is None else 0.0,
            conditions.corrections,
        )
        temperatures[number] += result.temperatures
    return CriticalTemperatures(
        transitions, surfaces, tuple(map(tuple, temperatures)), conditions.decisive
    )


def _worded(sweep: Sweep, transition: Transition, seed: int | None) -> str:
    surface = f", surface {seed}" if "realization" in sweep.variants.axes else ""
    return (
        f"{sweep.about.name}, {transition.normal_load:g} N at {transition.velocity:g} m/s{surface}"
    )


def _spread(values: tuple[float, ...]) -> float | None:
    return float(np.std(values, ddof=1)) if len(values) > 1 else None
