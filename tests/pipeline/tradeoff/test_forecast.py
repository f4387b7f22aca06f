"""Forecasts of `irg check`, against what then happens."""

import time

import pytest

from pipeline.sweep import plan
from pipeline.sweep.plan import points, run_point, run_points, tasks
from pipeline.tradeoff import forecast
from pipeline.tradeoff.forecast import estimate, savings
from tests.helpers import tiny
from tests.helpers.accuracy_scenes import PAPER
from tribo import PRESETS, Fidelity, Grid, Ramp, Wear, simulate
from tribo.simulation import Trunks, contacts

SWEEP = PAPER.changed(
    loads=(250.0, 500.0, 750.0), velocities=(1.0, 2.0), pixels=Grid((64, 32), (6e-6, 6e-6))
)


def counted(sweep, monkeypatch):
    """Steps and temperatures of a whole sweep."""
    steps = temperatures = heats = 0

    def counting(*arguments):
        nonlocal steps, temperatures
        for state in contacts(*arguments):
            steps += 1
            temperatures += state.is_asked or state.heat is not None
            yield state

    def noting(*arguments):
        nonlocal heats
        heats += not sweep.scene.remembers_heat
        return on_way(*arguments)

    on_way = plan._increment_values
    monkeypatch.setattr(plan, "_increment_values", noting)
    monkeypatch.setattr(plan, "contacts", counting)
    trunks = Trunks()
    for task in tasks(points(sweep), sweep):
        run_points(sweep, task.points, trunks)
    temperatures += heats
    if not sweep.scene.remembers_steps:  # one worker solves each contact once, for all velocities
        steps //= len(sweep.plane.velocities)
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
    ids=["ramp", "end", "history", "stations", "no wear", "hold"],
)
def test_steps_and_temperatures_are_foretold(changes, monkeypatch):
    sweep = SWEEP.changed(**{"roughness": None} | changes)
    forecast = estimate(sweep, workers=1)
    assert (forecast.steps, forecast.temperatures) == counted(sweep, monkeypatch)


def test_workers_share_the_time_and_the_boundary_alone_takes_fewer_points(monkeypatch):
    # On two cores, where a contact takes 1 s and its temperature 9 s.
    timed = 1.0, 9.0, next(simulate(SWEEP.scene, 750.0, 0.0))
    monkeypatch.setattr(forecast, "_timed", lambda *_: timed)
    monkeypatch.setattr(forecast.os, "cpu_count", lambda: 2)
    sweep = SWEEP.changed(fidelity=Fidelity(increments=30), steps="end")
    # 29 increments below 750 N at each velocity, and the ends of three loads.
    ramp = 32 * 1.0 + 3 * 9.0
    assert estimate(sweep, 1).seconds == pytest.approx(2 * ramp, rel=0.02)
    assert estimate(sweep, 2).seconds == pytest.approx(ramp, rel=0.02)
    many = sweep.changed(velocities=tuple(0.5 * k for k in range(1, 41)))
    whole, boundary = (estimate(many, 1, boundary_only=only) for only in (False, True))
    assert (whole.points, boundary.points) == (3 * 40, 3 * 2)
    assert boundary.seconds < whole.seconds / 5
    # 4 increments and the ends of 4 loads, with a temperature each, whose contacts 4 samples share.
    shared = 128 * (4 * 9.0 + 8 * 1.0 / 4)
    assert estimate("uncertain", 1).seconds == pytest.approx(shared, rel=0.02)


def test_the_time_is_that_of_a_whole_run_within_its_factor():
    sweep = SWEEP.changed(fidelity=PRESETS["standard"])
    for point in points(sweep)[:1]:
        run_point(sweep, *point)  # what is imported and computed once
    began = time.process_time()
    trunks = Trunks()
    for task in tasks(points(sweep), sweep):
        run_points(sweep, task.points, trunks)
    taken = time.process_time() - began
    foretold = estimate(sweep, 1).seconds - 1.0  # the start of a cluster
    assert taken / 3 < foretold < 3 * taken  # on a machine that is busy by turns


def test_fields_take_room_only_where_they_are_asked_for():
    grid = Grid((64, 32), (6.5e-6, 7.5e-6))
    without, with_fields = (
        estimate(tiny.sweep(fields=fields, pixels=grid)).disk_bytes for fields in (False, True)
    )
    of_fields = len(points(tiny.sweep())) * 3 * (0.35 * 4 * 64 * 32 + 2048)  # half a block of each
    assert with_fields - without == pytest.approx(of_fields)  # single, and compressed


def test_a_store_takes_the_room_that_was_foretold_within_a_factor_of_two(alone):
    blocks = sum(512 * file.stat().st_blocks for file in alone.rglob("*"))
    assert 0.5 < estimate(tiny.full()).disk_bytes / blocks < 2.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"wear": None}, "wear, since the scene has no table [wear]"),
        ({"wear": None}, "steps, since nothing wears between them"),
        ({"roughness": None}, "the axis y, since both bodies are smooth"),
        ({"velocities": (0.0, 1.0)}, "heat at 3 points, since nothing moves there"),
        ({}, "temperatures before the last step"),
        ({"fidelity": PRESETS["standard"]}, "wear before the last step on a coarser grid"),
        ({}, "fields, since the scene does not ask for them"),
    ],
)
def test_work_that_is_saved_is_named_with_its_reason(changes, said):
    kept = SWEEP.changed(
        fields=True, steps="end", wear=Wear(1.2e-15), pixels=Grid((256, 96), (2e-6, 2e-6))
    )
    if said.startswith("fields"):
        kept = kept.changed(fields=False)
    assert any(said in work for work in savings(kept.changed(**changes)))
