"""Choice of the stations (times of the loading) at which results of a sweep's points are stored."""

from __future__ import annotations

from pipeline.sweep.model import Sweep
from pipeline.sweep.stations import Stations, Steps
from tribo import Ramp
from tribo.simulation import mechanics


def choose_stations(sweep: Sweep) -> Stations:
    """Stations (times of the loading) to store; an existing store keeps its own."""
    if sweep.stations:
        return sweep.stations
    steps = sweep.steps or _default_steps(sweep)
    return Stations(steps, _warms_in_hold(sweep))


def _default_steps(sweep: Sweep) -> Steps:
    """Default of ``sweep.steps``: which time steps of each point to store.

    The result is "course", for all steps, if the pin wears in some variant, the load is a ramp
    without a hold in all of them, and no variant reuses the contact solutions of another variant.
    Otherwise it is "end", for only the steps that verdicts use.
    """
    scenes = [case.scene for case in sweep.given]
    are_ramps = all(isinstance(one.loading, Ramp) and not one.loading.hold for one in scenes)
    wears = any(scene.wears for scene in scenes)
    # With temperatures at all steps, variants that share contacts would take 2.9 to 4.4 times as
    # long.
    rows = [
        (mechanics(sweep.case(name).scene), row.labels.get("velocity"))
        for name, row in sweep.variants.by_name.items()
    ]
    are_alone = len({*rows}) == len(rows)
    return "course" if are_ramps and wears and are_alone else "end"


def _warms_in_hold(sweep: Sweep) -> bool:
    """True if, in some variant, a body gets warmer while the load is held."""
    loading = sweep.scene.loading
    if not isinstance(loading, Ramp) or not loading.hold:
        return False
    kept = (case.conditions.corrections for case in sweep.given)
    return any(corrections.keeps_heat for corrections in kept if corrections)
