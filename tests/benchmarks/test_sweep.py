"""Cost of a sweep of the shipped scene beside its simulation, and the gain of a second worker.

Counted in CPU time, and in how many workers compute at the same time, so that it holds on a
machine that others use, too. Beside each the least that it could be here: files of the same sizes
that are only written, and processes that only simulate.
"""

import itertools
import multiprocessing
import os
import time
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline.run import sweep as execute
from pipeline.run import work
from pipeline.run.cluster import start_forkserver
from pipeline.sweep.sweep import Point
from tests.benchmarks.bare import shortest
from tests.benchmarks.scene import paper_scene
from tests.helpers.entries import changed
from tests.helpers.points import run_point
from tribo.simulation import RampCache


@pytest.fixture(scope="module")
def scene():
    return paper_scene()


class CountedPoints:
    """Replacement of `run_point` in a worker, which adds up the CPU time of points [s]."""

    def __init__(self):
        self.seconds = 0.0
        self._run_point, work.run_point = work.run_point, self

    def __call__(self, *arguments, **options):
        began = time.thread_time()
        try:
            return self._run_point(*arguments, **options)
        finally:
            self.seconds += time.thread_time() - began


def used():
    """CPU time of a worker so far, and the part of it that points took [s]."""
    return time.process_time(), work.run_point.seconds


def time_of_bare_files(store, folder):
    """CPU time [s] to create, sync and rename a file for each chunk of a store."""
    sizes = [file.stat().st_size for file in store.rglob("c.*")]
    folder.mkdir()
    numbers = itertools.count()

    def write():
        for size in sizes:
            name = folder / f"{next(numbers)}"
            with name.with_suffix(".partial").open("wb") as file:
                file.write(bytes(size))
                file.flush()
                os.fsync(file.fileno())
            name.with_suffix(".partial").rename(name)

    return shortest(write)


@pytest.mark.parametrize("preset", [None, "standard", "fine"])
def test_store_and_scheduling_take_a_small_share(benchmark, scene, tmp_path, monkeypatch, preset):
    """The time counts after the workers have started."""
    connected, seconds, points = execute.connected, [], []

    @contextmanager
    def counted(*arguments):
        with connected(*arguments) as link:
            link.run(CountedPoints)
            for sign in -1, 1:
                there = list(link.run(used).values())
                seconds.append(sign * (time.process_time() + sum(took for took, _ in there)))
                points.append(sign * sum(of_points for _, of_points in there))
                if sign < 0:
                    yield link

    monkeypatch.setattr(execute, "connected", counted)
    fidelity = tribo.PRESETS.get(preset, scene.fidelity)
    sweep = changed(scene, fidelity=fidelity, velocities=scene.velocities[2:14:2])
    out = tmp_path / "out.zarr"
    outcome = benchmark.pedantic(pipeline.run_sweep, (sweep, out), rounds=1)
    share = 1 - sum(points) / sum(seconds)
    least = time_of_bare_files(out, tmp_path / "bare") / sum(seconds)
    print(
        f"\n{preset or 'paper grid'}: store and scheduling take {100 * share:.0f} % of CPU time",
        end="; ",
    )
    print(f"its {1e3 * sum(points) / outcome.done:.0f} ms a point are simulation,", end=" ")
    print(f"the bare files would take {100 * least:.0f} %")
    assert share < 0.5


def simulate(sweep, velocities, core):
    os.sched_setaffinity(0, {core})
    began = time.perf_counter()
    ramp_cache = RampCache()
    for velocity in velocities:
        for load in sweep.loads:
            run_point(sweep, Point(load, velocity), ramp_cache)
    return time.perf_counter() - began


def time_of_bare(processes, sweep):
    """Wall time [s] of processes that share the velocities, without a store or messages."""
    start_forkserver()
    cores = sorted(os.sched_getaffinity(0))[:processes]
    with multiprocessing.get_context("forkserver").Pool(processes) as pool:
        work = [(sweep, sweep.velocities[i::processes], core) for i, core in enumerate(cores)]
        return max(pool.starmap(simulate, work, chunksize=1))


def test_two_workers_against_one(benchmark, scene, tmp_path):
    sweep = changed(scene, velocities=scene.velocities[2:14:2])

    def run():
        for workers in (1, 2):
            done = pipeline.run_sweep(sweep, tmp_path / f"{workers}.zarr", workers=workers)
            spans.append(done.wall_time)
            bare.append(time_of_bare(workers, sweep))

    bare, busy, spans = [], [], []
    benchmark.pedantic(run, rounds=1)
    for workers in (1, 2):
        with xr.open_zarr(tmp_path / f"{workers}.zarr", chunks=None) as ds:
            busy.append(ds["wall_time"].values.sum() / spans[workers - 1])
    print(f"\ntwo workers are {spans[0] / spans[1]:.2f} times as fast as one", end="; ")
    print(f"bare processes {bare[0] / bare[1]:.2f}", end="; ")
    print(f"on average {busy[0]:.2f} of 1 and {busy[1]:.2f} of 2 compute")
    assert busy[1] > 1.8 * np.clip(busy[0], None, 1.0)
