"""Which stations the points of a sweep have, by the word of its scene."""

from __future__ import annotations

from pipeline.sweep.model import Sweep
from pipeline.sweep.stations import Stations, even_places
from tribo import MeasuredLoad
from tribo.loading import Station


def choose_stations(sweep: Sweep) -> Stations:
    """Stations of a sweep at its present loads, or those that its store has."""
    if sweep.record.stations:
        return sweep.record.stations
    steps = sweep.record.steps or _usual(sweep)
    if steps == "end":
        return Stations(steps, judges_hold=_warms_in_hold(sweep))
    if steps == "loads":
        return Stations(steps, sweep.plane.loads)
    scene, highest = sweep.variant(sweep.variants.names[0]).scene, max(sweep.plane.loads)

    def way(load: float) -> list[Station]:
        return list(scene.loading.stations(load, scene.fidelity.increments))

    end = way(highest)[-1].time
    interval = 0.0 if steps == "all" else end / (int(steps) + 1)
    warms = _warms_in_hold(sweep)
    if isinstance(scene.loading, MeasuredLoad):
        return Stations(steps, interval=interval)
    loads = set[float]()
    for load in sweep.plane.loads if steps == "all" else (highest,):
        trunk = [step for step in way(load) if step.on_trunk and step.normal_load < highest]
        places = even_places([step.time for step in trunk], interval, end)
        loads |= {trunk[place].normal_load for place in places}
    return Stations(steps, tuple(sorted(loads)), interval, warms)


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
