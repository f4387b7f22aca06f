"""Choice of the stations (times of the loading) at which results of a sweep's points are stored."""

from __future__ import annotations

from pipeline.sweep.model import Sweep
from pipeline.sweep.stations import Stations
from tribo import Ramp
from tribo.simulation import mechanics


def choose_stations(sweep: Sweep) -> Stations:
    """Stations (times of the loading) to store; an existing store keeps its own."""
    if sweep.stations:
        return sweep.stations
    steps, scenes = sweep.steps, [case.scene for case in sweep.given]
    if not steps:
        # Variants that share contacts would take 2.9 to 4.4 times as long with temperatures at all
        # steps of the course.
        are_ramps = all(isinstance(one.loading, Ramp) and not one.loading.hold for one in scenes)
        rows = [
            (mechanics(sweep.case(name).scene), row.labels.get("velocity"))
            for name, row in sweep.variants.by_name.items()
        ]
        are_alone = len({*rows}) == len(rows)
        wears = any(scene.wears for scene in scenes)
        steps = "course" if are_ramps and wears and are_alone else "end"
    # A disc or a track that keeps heat gets warmer while the load is held.
    loading, kept = sweep.scene.loading, [case.conditions.corrections for case in sweep.given]
    holds = isinstance(loading, Ramp) and bool(loading.hold)
    warms = holds and any(corrections.keeps_heat for corrections in kept if corrections)
    return Stations(steps, warms)
