"""Velocities of a sweep that answers for several wear rates."""

from __future__ import annotations

import math

from pipeline.scene.quantities import display
from pipeline.sweep.model import Sweep
from tribo import Wear

_RATIO = 1.3  # of neighbouring velocities beyond those of the scene, at most


def with_velocities_for_rates(sweep: Sweep, notes: list[str]) -> Sweep:
    """Add velocities at which contacts are as worn as at other rates and the scene's velocities.

    A contact at the velocity V and the scene's own rate k is that at V' and another rate k' where
    kV = k'V'. So the scene's velocities are covered at every rate where they are from k₁/k times
    the lowest to k₂/k times the highest; a note names the velocities that are added.
    """
    moving = [velocity for velocity in sweep.plane.velocities if velocity > 0]
    wear = sweep.scene.wear
    if not isinstance(wear, Wear) or sweep.record.wear_rates is None or not moving:
        return sweep
    rate, (low, high) = wear.specific_wear_rate, sweep.record.wear_rates
    further = [*_beyond(moving[0], low / rate), *_beyond(moving[-1], high / rate)]
    if further:
        ends = " and ".join(display(end, "m/s", 4) for end in (min(further), max(further)))
        notes.append(
            f"sweep.wear_rates: {len(further)} velocities down and up to {ends} are added, so that "
            "every wear rate has the scene's velocities"
        )
    return sweep.changed(velocities=tuple(sorted({*sweep.plane.velocities, *further})))


def _beyond(velocity: float, factor: float) -> list[float]:
    """Velocities from one, without it, to a multiple of it [m/s].

    Examples
    --------
    >>> _beyond(4.0, 2.0), _beyond(1.0, 0.9), _beyond(1.0, 1.0)
    ([5.04, 6.35, 8.0], [0.9], [])
    """
    count = math.ceil(abs(math.log(factor)) / math.log(_RATIO) - 1e-9)
    return [float(f"{velocity * factor ** (n / count):.4g}") for n in range(1, count + 1)]
