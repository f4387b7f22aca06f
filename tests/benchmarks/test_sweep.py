"""What a sweep of the shipped scene costs beside its simulation, and what a second worker brings.

Counted in CPU time, and in how many workers compute at the same time, so that it holds on a
machine that others use, too.
"""

import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import execute
from pipeline.plan import chains, points, run_point

SCENE = Path(__file__).parents[2] / "workflows" / "irg_transition.toml"


@pytest.fixture(scope="module")
def scene():
    scene = pipeline.load_scene(SCENE)
    run_point(scene, 200.0, 1.0)  # kernels and roughness are made once
    return scene


def simulate(sweep):
    for chain in chains(points(sweep)):
        trunk = None
        for point in chain:
            trunk = run_point(sweep, *point, trunk=trunk).trunk


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run a sweep on one worker; what it takes of CPU time here and there [s]."""
    connected, there = execute.connected, []

    @contextmanager
    def counted(*arguments):
        with connected(*arguments) as client:
            yield client
            there.extend(client.run(time.process_time).values())

    def run(sweep):
        before = time.process_time()
        pipeline.run_sweep(sweep, tmp_path / f"{len(sweep.velocities)}.zarr", workers=1)
        return time.process_time() - before + there.pop()

    monkeypatch.setattr(execute, "connected", counted)
    return run


def test_store_and_scheduling_take_a_small_share(benchmark, scene, run):
    """Of a further ramp, which leaves out what it takes to start."""
    one, three = (replace(scene, velocities=scene.velocities[4:end:4]) for end in (5, 13))

    def share():
        both = run(three) - run(one)
        before = time.process_time()
        simulate(replace(three, velocities=three.velocities[1:]))
        return 1 - (time.process_time() - before) / both

    found = benchmark.pedantic(share, rounds=1)
    print(f"\nstore and scheduling: {100 * found:.1f} % of the CPU time of a ramp's 12 points")
    assert found < 0.5


def test_two_workers_compute_all_the_time(benchmark, scene, tmp_path):
    sweep = replace(scene, velocities=scene.velocities[2:14:2])

    def run():
        for workers in (1, 2):
            pipeline.run_sweep(sweep, tmp_path / f"{workers}.zarr", workers=workers)

    benchmark.pedantic(run, rounds=1)
    busy = []
    for workers in (1, 2):
        with xr.open_zarr(tmp_path / f"{workers}.zarr", chunks=None) as ds:
            took, ended = ds["wall_time"].values, ds["finished_at"].values
        busy.append(took.sum() / (ended.max() - (ended - took).min()))
    print(f"\nworkers that compute, on average: {busy[0]:.2f} of 1, {busy[1]:.2f} of 2")
    assert busy[1] > 1.8 * np.clip(busy[0], None, 1.0)
