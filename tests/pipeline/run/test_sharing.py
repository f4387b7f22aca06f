"""Rows share contacts on a worker, and each has the bits that it has alone."""

import random

import numpy as np
import pytest

import pipeline
from pipeline.store.schema import COLUMNS
from pipeline.sweep.plan import points, tasks
from tests.helpers.points import run_point
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all
from tribo.simulation import RampCache, loading_step
from tribo.simulation.cache import forget_kernels

CONDUCTIVITY, RATE = "materials.steel.thermal_conductivity", "wear.specific_wear_rate"
CONDUCTIVITIES = "20 W/(m K)", "45 W/(m K)"
RATES = "1.2e-6 mm^3/(N m)", "2.4e-6 mm^3/(N m)"
# The second rate at half the velocity wears the pin as fast as the first.
PLACES = ("300 N", "1 m/s"), ("300 N", "2 m/s"), ("600 N", "1 m/s")
ROWS = [
    {CONDUCTIVITY: conductivity, RATE: rate, "load": load, "velocity": velocity}
    for conductivity in CONDUCTIVITIES
    for rate in RATES
    for load, velocity in PLACES
]
PHYSICS = {
    "end": {"sweep.steps": "end"},
    "course": {"sweep.steps": "course"},
    "hold": {"loading.hold": "5 s"},
    "local wear": {"wear.pattern": "local", "sweep.steps": "end"},
    "no wear": {"without": ["wear"]},
    "heat of the past": {"fidelity.heat_model": "history"},
}


@pytest.fixture
def scene(tmp_path):
    text = SCENE.replace("increments = 10", "increments = 4").replace("fields = true", "")
    (tmp_path / "scene.toml").write_text(text)
    return tmp_path / "scene.toml"


def table(scene, **overrides):
    """Sweep over all rows, in an order that is none."""
    rows = random.Random(1).sample(ROWS, len(ROWS))
    if "without" in overrides:
        rows = [{name: value for name, value in row.items() if name != RATE} for row in rows]
        rows = list({tuple(row.items()): row for row in rows}.values())
    return pipeline.load_scene(scene, overrides=overrides | {"sweep.along": rows})


def assert_each_row_is_as_alone(ds, scene, **overrides):
    """Assert that each row of a store has the bits of a scene with the entries of that row."""
    assert (ds["status"] == 1).all()
    steps = "course" if overrides.get("sweep.steps") == "course" else "end"
    for number in range(ds.sizes["case"]):
        row = ds.isel(case=number)
        units = {CONDUCTIVITY: "W/(m K)", RATE: "m^2/N"}
        named = {entry: row.coords.get(entry.replace(".", "_")) for entry in units}
        entries = {
            entry: f"{value.item()!r} {units[entry]}"
            for entry, value in named.items()
            if value is not None
        }
        own = pipeline.load_scene(scene, overrides=overrides | {"sweep.steps": steps} | entries)
        alone = pipeline.run_point(own, row["load"].item(), row["velocity"].item())
        for name in COLUMNS.keys() & row.data_vars.keys():
            stored = row[name].transpose("step", ...).values[-len(alone.columns["time"]) :]
            assert stored.tobytes() == alone.columns[name].astype(stored.dtype).tobytes(), name


@pytest.mark.parametrize("physics", PHYSICS)
def test_a_row_that_shares_contacts_has_the_bits_that_it_has_alone(scene, physics):
    """With a cache of any size, in the order of the queue and in any other."""
    sweep = table(scene, **PHYSICS[physics])
    alone = {point: run_point(sweep, point) for point in points(sweep)}
    every = [task.point for task in tasks(points(sweep), sweep)]
    mixed = random.Random(2).sample(every, len(every))
    for order, ramp_cache in ((mixed[:6], RampCache(0)), ((*every, *mixed[:6]), RampCache(2**28))):
        for point in order:
            shared = run_point(sweep, point, ramp_cache)
            assert shared.warnings == alone[point].warnings
            for name, values in (alone[point].columns | alone[point].fields).items():
                assert values.tobytes() == (shared.columns | shared.fields)[name].tobytes(), name


@pytest.mark.parametrize("physics", ["end", "course"])
def test_rows_of_a_store_are_those_of_their_own_scenes(scene, tmp_path, physics):
    commit_all(tmp_path / "a.zarr", table(scene, **PHYSICS[physics]))
    assert_each_row_is_as_alone(pipeline.open_sweep(tmp_path / "a.zarr"), scene, **PHYSICS[physics])


def test_two_workers_and_an_interruption_change_no_bit(scene, tmp_path):
    sweep = table(scene)
    commit_all(tmp_path / "a.zarr", sweep, skip=points(sweep)[::2])
    outcome = pipeline.run_sweep(sweep, tmp_path / "a.zarr", workers=2)
    assert outcome.computed == len(points(sweep)[::2])
    assert_each_row_is_as_alone(pipeline.open_sweep(tmp_path / "a.zarr"), scene)


def solutions(sweep, monkeypatch):
    """Number of contact solutions of a sweep on one worker, in the order of its queue."""
    solve, count = loading_step.solve_contact, 0

    def counting(*arguments, **options):
        nonlocal count
        count += 1
        return solve(*arguments, **options)

    forget_kernels()
    ramp_cache = RampCache()
    with monkeypatch.context() as patch:
        patch.setattr(loading_step, "solve_contact", counting)
        for task in tasks(points(sweep), sweep):
            run_point(sweep, task.point, ramp_cache)
    return count


@pytest.mark.parametrize("physics", [name for name in PHYSICS if name != "heat of the past"])
def test_two_conductivities_cost_the_contacts_of_one(scene, physics, monkeypatch):
    one = pipeline.load_scene(scene, overrides=PHYSICS[physics])
    over = {"sweep.over": {CONDUCTIVITY: [*CONDUCTIVITIES]}}
    two = pipeline.load_scene(scene, overrides=PHYSICS[physics] | over)
    assert len(points(two)) == 2 * len(points(one))
    assert solutions(two, monkeypatch) == solutions(one, monkeypatch) > 0
    assert pipeline.estimate(two).steps == pipeline.estimate(one).steps


def test_rows_of_one_mechanics_rate_and_velocity_are_one_ramp(scene):
    """Equal wear rate × velocity is no reason to share: its contacts would differ by rounding."""
    sweep = table(scene)
    ramps = {}
    for task in tasks(points(sweep), sweep):
        labels = dict(sweep.case_table.by_name[task.point.case])
        ramps.setdefault(task.ramp[:2], set()).add(
            (labels[RATE.replace(".", "_")], task.point.velocity)
        )
    assert all(len(found) == 1 for found in ramps.values())
    assert len(ramps) == len({*map(frozenset, ramps.values())}) == 4


def test_numbers_are_not_those_of_another_row(scene, tmp_path):
    commit_all(tmp_path / "a.zarr", table(scene))
    ds = pipeline.open_sweep(tmp_path / "a.zarr")
    assert len(np.unique(ds["max_rise"].sel(step=0).values)) == len(ROWS)
