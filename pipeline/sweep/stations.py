"""Stations of a point: the moments on its way that are kept besides those that decide.

On a ramp they are the ends of points at lower loads, bit for bit, else steps of its own.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from pipeline.sweep.model import Sweep
from pipeline.sweep.plain import made
from tribo import MeasuredLoad, Scene
from tribo.loading import Station

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

    @classmethod
    def of(cls, sweep: Sweep) -> Self:
        """Stations of a sweep at its present loads."""
        if sweep.record.stations:
            stations: Self = made(cls, sweep.record.stations)
            return stations
        steps = sweep.record.steps or _usual(sweep)
        if steps == "end":
            return cls(steps, judges_hold=_warms_in_hold(sweep))
        if steps == "loads":
            return cls(steps, sweep.plane.loads)
        scene, highest = sweep.variant(sweep.variants.names[0]).scene, max(sweep.plane.loads)

        def way(load: float) -> list[Station]:
            return list(scene.loading.stations(load, scene.fidelity.increments))

        end = way(highest)[-1].time
        interval = 0.0 if steps == "all" else end / (int(steps) + 1)
        warms = _warms_in_hold(sweep)
        if isinstance(scene.loading, MeasuredLoad):
            return cls(steps, interval=interval)
        loads = set[float]()
        for load in sweep.plane.loads if steps == "all" else (highest,):
            trunk = [step for step in way(load) if step.on_trunk and step.normal_load < highest]
            places = _even([step.time for step in trunk], interval, end)
            loads |= {trunk[place].normal_load for place in places}
        return cls(steps, tuple(sorted(loads)), interval, warms)

    def as_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

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
        kept = set[int]() if self.interval is None else {*_even(times, self.interval, times[-1])}
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


def _usual(sweep: Sweep) -> str:
    """The word of a scene that gives none: loads of a plane on one ramp, else the end."""
    loading, plane = sweep.scene.loading, sweep.plane
    is_ramp = not isinstance(loading, MeasuredLoad) and not loading.hold
    is_plane = plane.chosen is None and not plane.independent and sweep.variants.has_plane
    return "loads" if is_ramp and is_plane else "end"


def _warms_in_hold(sweep: Sweep) -> bool:
    """The load is held, and a body of some variant has a heat capacity."""
    loading = sweep.scene.loading
    if isinstance(loading, MeasuredLoad) or not loading.hold:
        return False
    several = (sweep.variant(name) for name in sweep.variants.names)
    bulks = (
        bulk
        for one in several
        if (held := one.conditions.corrections)
        for bulk in (held.pin_bulk, held.disk_bulk)
    )
    return any(bulk.capacity for bulk in bulks if bulk)


def _growing(count: int) -> set[int]:
    """Places of all steps of a hold; of very many those at times that grow by a ratio."""
    if count <= _MOST_OF_HOLD:
        return {*range(count)}
    return {*(np.geomspace(1, count, _MOST_OF_HOLD).round().astype(int) - 1).tolist()}


def _even(times: list[float], interval: float, end: float) -> list[int]:
    """Places of the times nearest to multiples of an interval before an end [s]; all if it is 0."""
    if interval == 0 or not times:
        return list(range(len(times)))
    first = max(1, np.ceil(times[0] / interval - 0.5))
    moments = interval * np.arange(first, np.ceil(end / interval - 1e-9))
    return sorted({int(np.argmin(np.abs(np.array(times) - moment))) for moment in moments})
