"""Forecasts of `irg check`, against what then happens."""

import time
from dataclasses import replace

import pytest

from pipeline import load_scene
from pipeline.sweep import plan
from pipeline.sweep.plan import points, run_point, run_points, tasks
from pipeline.tradeoff import forecast
from pipeline.tradeoff.forecast import estimate, worker_bytes
from tests.helpers import tiny
from tests.helpers.accuracy_scenes import PAPER
from tests.helpers.entries import changed
from tribo import (
    PRESETS,
    QUANTILES,
    Corrections,
    Fidelity,
    Friction,
    Grid,
    Ramp,
    Wear,
    simulate,
)
from tribo.simulation import Trunks, contacts

SWEEP = changed(
    PAPER, loads=(250.0, 500.0, 750.0), velocities=(1.0, 2.0), pixels=Grid((64, 32), (6e-6, 6e-6))
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
    sweep = changed(SWEEP, **{"roughness": None} | changes)
    forecast = estimate(sweep, workers=1)
    assert (forecast.steps, forecast.temperatures) == counted(sweep, monkeypatch)


def test_workers_share_the_time_and_the_boundary_alone_takes_fewer_points(monkeypatch):
    # On two cores, where a contact takes 1 s and its temperature 9 s.
    timed = 1.0, 9.0, next(simulate(SWEEP.scene, 750.0, 0.0))
    monkeypatch.setattr(forecast, "time_steps", lambda *_: timed)
    monkeypatch.setattr(forecast, "cores", lambda: 2)
    sweep = changed(SWEEP, fidelity=Fidelity(increments=30), steps="end")
    # 29 increments below 750 N at each velocity, and the ends of three loads.
    ramp = 32 * 1.0 + 3 * 9.0
    assert estimate(sweep, 1).seconds == pytest.approx(2 * ramp, rel=0.02)
    assert estimate(sweep, 2).seconds == pytest.approx(ramp, rel=0.02)
    many = changed(sweep, velocities=VELOCITIES)
    whole, boundary = (estimate(many, 1, boundary_only=only) for only in (False, True))
    assert (whole.points, boundary.points) == (3 * 40, 3 * 2)
    assert (whole.tasks, boundary.tasks) == (120, 8)
    # Two of the loads at four of the velocities: 19 increments below 500 N, and the ends.
    assert (boundary.steps, boundary.temperatures) == (4 * 21, 8)
    assert boundary.seconds == pytest.approx(1.0 + 84 * 1.0 + 8 * 9.0 + 8 * 0.005)
    assert whole.seconds == pytest.approx(1.0 + 40 * ramp + 120 * 0.005)
    # More workers than cores take turns, and no more of them work than there are tasks.
    longest = 30 * 1.0 + 9.0 + 0.005  # that of the highest load from the start
    assert estimate(sweep, 50).seconds == pytest.approx(1.0 + 6 / 2 * longest)
    assert (estimate(sweep, 50).workers, estimate(sweep).workers) == (50, 2)
    # 4 increments and the ends of 4 loads, with a temperature each, whose contacts 4 samples share.
    shared = 128 * (4 * 9.0 + 8 * 1.0 / 4)
    assert estimate("uncertain", 1).seconds == pytest.approx(shared, rel=0.02)


def test_friction_by_temperature_takes_two_partitions_more_a_point(monkeypatch):
    timed = 1.0, 9.0, next(simulate(SWEEP.scene, 750.0, 0.0))
    monkeypatch.setattr(forecast, "time_steps", lambda *_: timed)
    law = Corrections(friction=Friction(by_temperature=((300.0, 1.0), (400.0, 0.8))))
    plain = changed(SWEEP, fidelity=Fidelity(increments=30), steps="end")
    table = changed(plain, conditions=replace(plain.conditions, corrections=law))
    more = estimate(table, 1).seconds - estimate(plain, 1).seconds
    moving = sum(1 for point in points(plain) if point.velocity)
    assert more == pytest.approx(2 * 9.0 * moving)


def test_samples_take_no_partition_more_since_their_friction_is_not_solved(monkeypatch):
    monkeypatch.setattr(forecast, "time_steps", lambda *_: (1.0, 9.0, None))
    monkeypatch.setattr(forecast, "_point_bytes", lambda *_: 0.0)
    rows = [{"temperature": f"{at} K", "coefficient": mu} for at, mu in ((300, 0.1), (400, 0.08))]
    table = load_scene("uncertain", overrides={"friction.by_temperature": rows})
    assert table.scene.solved_friction
    assert estimate(table, 1).seconds == estimate("uncertain", 1).seconds


def test_the_time_is_that_of_a_whole_run_within_its_factor():
    sweep = changed(SWEEP, fidelity=PRESETS["standard"])
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


def test_a_worker_has_memory_for_libraries_60_fields_and_the_ramps_that_it_keeps():
    """Of a ramp three arrays an increment, each of 8 bytes for 32 · 16 elements."""
    field = 8 * 32 * 16
    without, one, four = (
        worker_bytes(changed(SWEEP, wear=wear), tasks)
        for wear, tasks in ((None, 4), (Wear(1.2e-15), 1), (Wear(1.2e-15), 4))
    )
    assert without == 115e6 + 60 * field
    assert one - without == 100 * 3 * field
    assert four - without == 4 * 100 * 3 * field
    assert worker_bytes(SWEEP, 10**6) - without == 2**28  # no more than that of ramps
    large = changed(SWEEP, pixels=Grid((256, 256), (2e-6, 2e-6)))
    coarse = Fidelity(pixels_per_element=2, history_coarsening=2, increments=25)
    fields = 60 * 8 * 128**2
    of_history = worker_bytes(changed(large, fidelity=coarse)) - 115e6 - fields
    assert of_history == 25 * 3 * 8 * 64**2
    # Summits so narrow are computed on the pixels, however large elements may be.
    assert worker_bytes(changed(large, fidelity=PRESETS["standard"])) > 115e6 + 60 * 8 * 256**2


def test_the_room_of_a_store_grows_with_the_moments_that_it_has():
    """10 moments of each point up to 750 N, or its end alone, beside what each store takes."""
    few = changed(SWEEP, fidelity=Fidelity(increments=10))
    course, end = (estimate(changed(few, steps=steps)) for steps in ("course", "end"))
    assert course.disk_bytes - 0.36e6 == pytest.approx(10 * (end.disk_bytes - 0.36e6))
    assert end.disk_bytes > 0.36e6 + 6 * 8 * len(QUANTILES)
    one = estimate(changed(few, velocities=(1.0,))).disk_bytes - 0.36e6
    assert course.disk_bytes - 0.36e6 == pytest.approx(2 * one)


def test_the_time_of_a_step_is_taken_at_a_middle_velocity(monkeypatch):
    asked = []

    def noted(scene, load, velocity, trunks):
        asked.append((load, velocity))
        return contacts(scene, load, velocity, trunks)

    monkeypatch.setattr(forecast, "contacts", noted)
    few = changed(SWEEP, fidelity=Fidelity(increments=2), velocities=(0.0, 1.0, 2.0, 4.0))
    cost = estimate(few, 1)
    assert asked == [(load, 2.0) for load in few.plane.loads]
    assert (cost.points, cost.tasks, cost.workers) == (12, 12, 1)
    asked.clear()
    still = estimate(changed(few, velocities=(0.0,)), 1)
    assert asked == [(load, 0.0) for load in few.plane.loads]
    assert still.temperatures == 0


def test_a_store_takes_the_room_that_was_foretold_within_a_factor_of_two(alone):
    blocks = sum(512 * file.stat().st_blocks for file in alone.rglob("*"))
    assert 0.5 < estimate(tiny.full()).disk_bytes / blocks < 2.0


VELOCITIES = tuple(0.5 * k for k in range(1, 41))
RUN, FIELDS = "temperatures before the last step (up to {} a point)", "fields, since the scene does"
FIELDS += " not ask for them (up to {} MB)"
