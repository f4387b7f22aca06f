"""Which stations the points of a sweep have, by the word of its scene."""

from __future__ import annotations

from pipeline.sweep.model import Sweep
from pipeline.sweep.stations import Stations, Steps
from tribo import Ramp


def choose_stations(sweep: Sweep) -> Stations:
    """Stations of a sweep, or those that its store has."""
    if sweep.stations:
        return sweep.stations
    tests = sweep.tests
    holds = {test.hold for test in tests if test.hold is not None}
    steps = sweep.plane.steps or _usual(sweep)
    return Stations(steps, _warms_in_hold(sweep), tuple(sorted(holds)))


def _usual(sweep: Sweep) -> Steps:
    """Default of a scene: the course, if it wears on a ramp with its own contacts."""
    scenes = [sweep.variant(name).scene for name in sweep.variants.given]
    are_ramps = all(isinstance(one.loading, Ramp) and not one.loading.hold for one in scenes)
    wears = any(scene.wears for scene in scenes)
    # Rows that share contacts would pay 2.9 to 4.4 times for the temperatures of each of them.
    are_alone = all(name == source.variant for name, source in sweep.contact_sources.items())
    return "course" if are_ramps and wears and are_alone else "end"


def _warms_in_hold(sweep: Sweep) -> bool:
    """The load is held, and a body of some variant keeps heat."""
    loading = sweep.scene.loading
    if not isinstance(loading, Ramp) or not loading.hold:
        return False
    several = (sweep.variant(name) for name in sweep.variants.given)
    kept = (one.conditions.corrections for one in several)
    return any(corrections.keeps_heat for corrections in kept if corrections)
