"""Estimates of `irg check`, against what then happens."""

import pytest

import tribo
from pipeline import Conditions, estimate
from pipeline.sweep import plan
from pipeline.sweep.plan import points, tasks
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.points import run_point
from tests.helpers.scenes import STEEL
from tests.helpers.sweeps import sweep_of_fields
from tribo import PRESETS, Fidelity, Grid, Ramp
from tribo.simulation import RampCache, contacts, heat

SWEEP = sweep_of_fields(
    pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
    disk=STEEL,
    pixels=Grid((64, 32), (6e-6, 6e-6)),
    loading=Ramp(rate=150.0, reference_load=750.0),
    roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (8e-6, 8e-6), seed=0),
    wear=tribo.Wear(1.2e-15),
    name="paper",
    title="The paper's system on a small window",
    loads=(250.0, 500.0, 750.0),
    velocities=(1.0, 2.0),
    conditions=Conditions(0.1, 298.15, 418.15),
)


def counted(sweep, monkeypatch):
    """Numbers of steps and temperatures of a whole sweep, counted while it runs."""
    steps = temperatures = 0

    def counting(*arguments):
        nonlocal steps, temperatures
        for state in contacts(*arguments):
            steps += 1
            temperatures += state.heat is not None
            yield state

    def heating(*arguments):
        nonlocal temperatures
        temperatures += 1
        return heat(*arguments)

    monkeypatch.setattr(plan, "heat", heating)
    monkeypatch.setattr(plan, "contacts", counting)
    ramp_cache = RampCache()
    for task in tasks(points(sweep), sweep):
        [run_point(sweep, task.point, ramp_cache)]
    if not sweep.scene.remembers_steps:  # one worker solves each contact once, for all velocities
        steps //= len(sweep.velocities)
    return steps, temperatures


@pytest.mark.parametrize(
    "changes",
    [
        {"fidelity": Fidelity(increments=30)},
        {"fidelity": Fidelity(increments=30), "steps": "end"},
        {"fidelity": Fidelity(increments=6, heat_model="history")},
        {"fidelity": PRESETS["standard"], "loads": (240.0, 250.0, 750.0), "steps": "end"},
        {"fidelity": Fidelity(increments=30), "wear": None},
        {"fidelity": Fidelity(increments=9), "loading": Ramp(150.0, 750.0, 1.0)},
    ],
    ids=["ramp", "end", "history", "stages", "no wear", "hold"],
)
def test_steps_and_temperatures_are_counted_before(changes, monkeypatch):
    sweep = changed(SWEEP, **{"roughness": None} | changes)
    cost = estimate(sweep, workers=1)
    assert (cost.steps, cost.temperatures) == counted(sweep, monkeypatch)


def test_a_store_takes_the_room_that_was_estimated_within_a_factor_of_two(alone):
    blocks = sum(512 * file.stat().st_blocks for file in alone.rglob("*"))
    assert 0.5 < estimate(tiny.full()).disk_bytes / blocks < 2.0
