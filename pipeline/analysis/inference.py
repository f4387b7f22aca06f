"""The critical temperature of a scene's lubricant, from the transitions that were measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.sweep.model import Measurement, Sweep
from tribo import InputError, Transition, critical_temperature


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
    share : float
        Share of the contact area that exceeds the critical temperature.
    """

    transitions: tuple[Transition, ...]
    surfaces: tuple[int | None, ...]
    temperatures: tuple[tuple[float, ...], ...]
    share: float

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
            "share": self.share,
            "surfaces": list(self.surfaces),
            "transitions": [
                at._asdict() | {"temperatures": list(row), "mean": mean, "spread": spread}
                for at, row, mean, spread in rows
            ],
            "mean": self.mean,
            "spread": self.spread,
        }


def critical_temperatures(
    sweep: Sweep, progress: Callable[[str], None] | None = None
) -> CriticalTemperatures:
    """Find the temperature that the failing share exceeds at each measured transition.

    A good model gives the same at all of them: the critical temperature of the lubricant, where
    no rig can measure it (see `tribo.critical_temperature`).

    Parameters
    ----------
    sweep : Sweep
        Scene with measured transitions, simulated on each of its realizations if it has any. A
        transition without a friction of its own has that of the sweep.
    progress : callable, optional
        Called with a line before each surface.

    Raises
    ------
    InputError
        If no transition was measured, or for a reason of `tribo.critical_temperature`.
    """
    if not sweep.measured:
        raise InputError(
            f"the scene {sweep.name} has no measured transition; give it a [[measured]] with "
            "load and velocity"
        )
    conditions = sweep.conditions

    def transition(entry: Measurement) -> Transition:
        friction = conditions.friction if entry.friction is None else entry.friction
        return Transition(entry.normal_load, entry.velocity, friction)

    transitions = tuple(transition(entry) for entry in sweep.measured)
    surfaces = sweep.realizations or (getattr(sweep.roughness, "seed", None),)
    found = []
    for number, seed in enumerate(surfaces, 1):
        if progress:
            progress(f"{sweep.name}: surface {number} of {len(surfaces)}")
        result = critical_temperature(
            sweep.on_surface(seed),
            transitions,
            conditions.bulk_temperature,
            conditions.failing_share,
        )
        found.append(result.temperatures)
    return CriticalTemperatures(
        transitions, surfaces, tuple(zip(*found, strict=True)), conditions.failing_share
    )


def _spread(values: tuple[float, ...]) -> float | None:
    return float(np.std(values, ddof=1)) if len(values) > 1 else None
