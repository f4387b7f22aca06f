"""Rows that share contacts on a worker equal single simulations bit for bit."""

import random
from unittest import mock

import numpy as np
import pytest

import pipeline
from pipeline.store.schema import COLUMNS
from pipeline.sweep.plan import points, tasks
from tests.helpers.points import run_point
from tests.helpers.scenes import SCENE
from tests.helpers.stores import commit_all
from tribo.simulation import RampCache, loading_step
from tribo.simulation.cache import forget_kernels

CONDUCTIVITY, RATE = "materials.steel.thermal_conductivity", "wear.specific_wear_rate"
CONDUCTIVITIES = "20 W/(m K)", "45 W/(m K)"
RATES = "1.2e-6 mm^3/(N m)", "2.4e-6 mm^3/(N m)"
# The second rate at half the velocity wears the pin as fast as the first.
POINTS_BY_RATE = [
    (RATES[0], "300 N", "2 m/s"),
    (RATES[1], "300 N", "1 m/s"),
    (RATES[0], "600 N", "2 m/s"),
]
ROWS = [
    {CONDUCTIVITY: conductivity, RATE: rate, "load": load, "velocity": velocity}
    for conductivity in CONDUCTIVITIES
    for rate, load, velocity in POINTS_BY_RATE
]
PHYSICS = {
    "course": {"sweep.steps": "course"},
    "hold": {"loading.hold": "5 s"},
    "local wear": {"wear.pattern": "local", "sweep.steps": "end"},
    "no wear": {"without": ["wear"]},
}


@pytest.fixture
def scene(tmp_path):
    text = SCENE.replace("increments = 10", "increments = 2").replace("fields = true", "")
    (tmp_path / "scene.toml").write_text(text)
    return tmp_path / "scene.toml"


def table(scene, **overrides):
    """Sweep over all rows, in random order."""
    rows = random.Random(1).sample(ROWS, len(ROWS))
    if "without" in overrides:
        rows = [{name: value for name, value in row.items() if name != RATE} for row in rows]
        rows = list({tuple(row.items()): row for row in rows}.values())
    return pipeline.load_scene(scene, overrides=overrides | {"sweep.along": rows})


@pytest.mark.parametrize("physics", PHYSICS)
def test_a_row_that_shares_contacts_has_the_bits_that_it_has_alone(scene, physics):
    """With a cache of any size, in the order of the queue and in any other."""
    sweep = table(scene, **PHYSICS[physics])
    single_results = {point: run_point(sweep, point) for point in points(sweep)}
    every = [task.point for task in tasks(points(sweep), sweep)]
    mixed = random.Random(2).sample(every, len(every))
    for order, ramp_cache in ((mixed[:3], RampCache(0)), ((*every, *mixed[:3]), RampCache(2**28))):
        for point in order:
            shared = run_point(sweep, point, ramp_cache)
            assert shared.warnings == single_results[point].warnings
            for name, values in (
                single_results[point].columns | single_results[point].fields
            ).items():
                assert values.tobytes() == (shared.columns | shared.fields)[name].tobytes(), name


def test_rows_of_a_store_are_those_of_their_own_scenes_after_an_interruption(scene, tmp_path):
    sweep, path = table(scene), tmp_path / "a.zarr"
    commit_all(path, sweep, skip=points(sweep)[::2])
    assert pipeline.run_sweep(sweep, path, workers=2).computed == len(points(sweep)[::2])
    ds = pipeline.open_sweep(path)
    assert (ds["status"] == 1).all()
    assert len(np.unique(ds["max_rise"].sel(step=0).values)) == len(ROWS)
    for number in range(ds.sizes["case"]):
        row = ds.isel(case=number)
        entries = {
            entry: f"{row.coords[entry.replace('.', '_')].item()!r} {unit}"
            for entry, unit in ((CONDUCTIVITY, "W/(m K)"), (RATE, "m^2/N"))
        }
        row_scene = pipeline.load_scene(scene, overrides={"sweep.steps": "end"} | entries)
        single_result = pipeline.run_point(row_scene, row["load"].item(), row["velocity"].item())
        for name in COLUMNS.keys() & row.data_vars.keys():
            stored = row[name].transpose("step", ...).values[-len(single_result.columns["time"]) :]
            assert stored.tobytes() == single_result.columns[name].astype(stored.dtype).tobytes(), (
                name
            )


@pytest.mark.parametrize("physics", ["hold", "no wear"])
def test_two_conductivities_cost_the_contacts_of_one(scene, physics):
    few = PHYSICS[physics] | {"sweep.loads": ["300 N"], "sweep.velocities": ["1 m/s", "2 m/s"]}
    counts = []
    for more in ({}, {"sweep.over": {CONDUCTIVITY: [*CONDUCTIVITIES]}}):
        sweep, ramp_cache = pipeline.load_scene(scene, overrides=few | more), RampCache()
        forget_kernels()  # contacts, too
        solve = loading_step.solve_contact
        with mock.patch.object(loading_step, "solve_contact", wraps=solve) as counted:
            for task in tasks(points(sweep), sweep):
                run_point(sweep, task.point, ramp_cache)
        counts.append(counted.call_count)
    assert counts[0] == counts[1] > 0
