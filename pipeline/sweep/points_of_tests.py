"""Points of the tests of a scene: a sweep of their own."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from pipeline.sweep.measurement import TEST
from pipeline.sweep.model import Sweep
from pipeline.sweep.stations import Stations
from pipeline.sweep.variants import PLACE_UNITS, Column, Row, Variants
from tribo import Ramp, Scene

TEST_POINT = "test_point"
"""Dimension of the points of tests."""
SCENE_HASH = "scene_hash"
"""Column with the hash of the scene that each point is of."""
NO_TEST = -1
"""Number of the test of a point that only an earlier run asked for."""


class Slot(NamedTuple):
    """A point of a test in a store: what is simulated there, and the test that asks for it."""

    scene_hash: str
    load: float  # [N]
    velocity: float  # [m/s]
    test: int  # number of the test in the scene, from 0

    @property
    def is_wanted(self) -> bool:
        """True if the present scene asks for this point."""
        return self.test != NO_TEST


def wanted_slots(sweep: Sweep) -> list[Slot]:
    """The points of a scene's tests, in their order."""
    return [
        Slot(sweep._hash_scene(one.simulated.scene), *place, number)
        for number, one in enumerate(sweep.tests)
        for place in one.places
    ]


def grown_slots(before: Iterable[Slot], sweep: Sweep) -> list[Slot]:
    """Slots of a store that takes the tests of `sweep`; those it has stay where they are.

    A test that simulates what a slot has takes this slot; for others slots are added.
    """
    slots = [slot._replace(test=NO_TEST) for slot in before]
    held = defaultdict[tuple[str, float, float], deque[int]](deque)
    for place, slot in enumerate(slots):
        held[slot[:3]].append(place)
    for slot in wanted_slots(sweep):
        if held[slot[:3]]:
            slots[held[slot[:3]].popleft()] = slot
        else:
            slots.append(slot)
    return slots


def sweep_of_tests(sweep: Sweep, slots: Sequence[Slot], judges_hold: bool) -> Sweep:
    """The sweep of the points of tests, a row for each of `slots`.

    A slot that no test asks for has the scene itself.
    """
    columns = (
        Column(TEST_POINT, meaning="number of the point of a test"),
        Column(TEST, "1", TEST_POINT, meaning=f"number of the test or input, {NO_TEST} for none"),
        Column(SCENE_HASH, None, TEST_POINT, meaning="SHA-256 of the scene that is simulated"),
        *(
            Column(k, unit, TEST_POINT, meaning=f"{k} of the test")
            for k, unit in PLACE_UNITS.items()
        ),
    )
    rows = tuple(Row({TEST_POINT: k, **slot._asdict()}, {}) for k, slot in enumerate(slots))
    cases = (sweep.tests[slot.test].simulated if slot.is_wanted else sweep.base for slot in slots)
    return replace(
        sweep,
        cases=tuple(replace(case, name=((TEST_POINT, k),)) for k, case in enumerate(cases)),
        variants=Variants(columns, rows),
        loads=tuple(sorted({slot.load for slot in slots})),
        velocities=tuple(sorted({slot.velocity for slot in slots})),
        fields=False,
        tests=(),
        stations=Stations("end", judges_hold),
    )


def judges_holds(sweep: Sweep) -> bool:
    """True if the holds of tests are judged at each step, since a body gets warmer in them."""
    kept = (one.simulated.conditions.corrections for one in sweep.tests)
    return any(corrections.keeps_heat for corrections in kept if corrections)


def most_steps(sweep: Sweep, slots: Sequence[Slot], judges_hold: bool) -> int:
    """Room for the stored steps of the points of tests, also if they are held."""
    stations = Stations("end", judges_hold)
    places = {
        (sweep.tests[slot.test].simulated.scene, slot.load, slot.velocity)
        for slot in slots
        if slot.is_wanted
    }
    return max(len(stations.kept(_held(scene), *place)) for scene, *place in places)


def _held(scene: Scene) -> Scene:
    """The scene with a hold, so that a test with a hold has room later."""
    if not isinstance(scene.loading, Ramp) or scene.loading.hold:
        return scene
    return replace(scene, loading=replace(scene.loading, hold=1.0))
