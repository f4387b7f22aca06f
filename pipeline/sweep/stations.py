"""Stations of a point: the moments on its way that are kept besides those that decide.

On a ramp they are the ends of points at lower loads, bit for bit, else steps of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tribo import MeasuredLoad, Scene

_MOST_OF_HOLD = 60  # moments of a hold at which a wearing contact and a warming body are judged


@dataclass(frozen=True, slots=True)
class Stations:
    """Stations of all points of a sweep, by the word of its scene."""

    steps: str | int = "end"  # or "loads", "all" or a number
    loads: tuple[float, ...] = ()  # that are stations of all higher ones, ascending [N]
    # Time between stations of a recorded load, or of one that is held [s]: 0 for every step, None
    # for those alone that decide.
    interval: float | None = None
    # A body warms as a whole while a hold wears the contact away: the worst moment lies inside.
    judges_hold: bool = False

    def below(self, load: float) -> tuple[float, ...]:
        """Loads that are stations of the points at a load [N]."""
        return tuple(station for station in self.loads if station < load)

    def asked(self, scene: Scene, load: float) -> frozenset[int]:
        """Indices of the steps on the point's own way at which a temperature is asked for."""
        if self.interval is None and not self.judges_hold:
            return frozenset()
        is_record = isinstance(scene.loading, MeasuredLoad)
        way = list(scene.loading.stations(load, scene.fidelity.increments))
        own = [step for step in way if is_record or step.holding]
        if not own:
            return frozenset()
        reached = [step.index for step in way if step.normal_load == load and not step.holding]
        times = [step.time for step in own]
        kept = (
            set[int]() if self.interval is None else {*even_places(times, self.interval, times[-1])}
        )
        if self.judges_hold:
            kept |= _growing(len(own))
        return frozenset([*reached, *(own[number].index for number in kept)])

    def count(self, scene: Scene, load: float) -> int:
        """Most stations that a point at a load may have, its end included."""
        asked = self.asked(scene, load)
        steps = list(scene.stations(load, asked=asked))
        keeps_heat = scene.remembers_heat and not scene.fidelity.fewest_elements
        own = sum(
            step is steps[-1]
            or step.index in asked
            or (step.normal_load >= load and (not step.holding or keeps_heat))
            for step in steps
        )
        return len(self.below(load)) + own


def _growing(count: int) -> set[int]:
    """Places of all steps of a hold; of very many those at times that grow by a ratio."""
    if count <= _MOST_OF_HOLD:
        return {*range(count)}
    return {*(np.geomspace(1, count, _MOST_OF_HOLD).round().astype(int) - 1).tolist()}


def even_places(times: list[float], interval: float, end: float) -> list[int]:
    """Places of the times nearest to multiples of an interval before an end [s]; all if it is 0."""
    if interval == 0 or not times:
        return list(range(len(times)))
    first = max(1, np.ceil(times[0] / interval - 0.5))
    moments = interval * np.arange(first, np.ceil(end / interval - 1e-9))
    return sorted({int(np.argmin(np.abs(np.array(times) - moment))) for moment in moments})
