"""What a sweep of the shipped scene costs beside its simulation, and what a second worker brings.

Counted in CPU time, and in how many workers compute at the same time, so that it holds on a
machine that others use, too.
"""

import resource
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.plan import chains, points, run_point

SCENE = Path(__file__).parents[2] / "workflows" / "irg_transition.toml"


@pytest.fixture(scope="module")
def scene():
    scene = pipeline.load_scene(SCENE)
    run_point(scene, 200.0, 1.0)  # kernels and roughness are made once
    return scene


def cpu():
    """CPU time of this process and of those that it has started and seen end [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def simulate(sweep):
    for chain in chains(points(sweep)):
        trunk = None
        for point in chain:
            trunk = run_point(sweep, *point, trunk=trunk).trunk


def spent(function, *arguments, **options):
    before = cpu()
    function(*arguments, **options)
    return cpu() - before


def test_store_and_scheduling_take_a_small_share(benchmark, scene, tmp_path):
    """Of a further ramp, which leaves out what it takes to start."""
    one, three = (replace(scene, velocities=scene.velocities[4:end:4]) for end in (5, 13))

    def share():
        run = [
            spent(pipeline.run_sweep, sweep, tmp_path / f"{len(sweep.velocities)}.zarr", workers=1)
            for sweep in (one, three)
        ]
        alone = [spent(simulate, sweep) for sweep in (one, three)]
        return 1 - (alone[1] - alone[0]) / (run[1] - run[0])

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
