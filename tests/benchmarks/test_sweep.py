"""Cost of a sweep of the shipped scene beside its simulation.

Counted in CPU time, so that it holds on a machine that others use, too. Beside it the least that it
could be here: files of the same sizes that are only written.
"""

import itertools
import os
import time
from contextlib import contextmanager

import pytest

import pipeline
from pipeline.run import sweep as execute
from pipeline.run import work
from tests.benchmarks.bare import shortest
from tests.helpers.entries import changed


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


@pytest.mark.parametrize("preset", ["standard", "fine"])
def test_store_and_scheduling_take_a_small_share(benchmark, tmp_path, monkeypatch, preset):
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
    scene = pipeline.load_scene("irg_transition", preset)
    sweep = changed(scene, velocities=scene.velocities[2:14:2])
    out = tmp_path / "out.zarr"
    outcome = benchmark.pedantic(pipeline.run_sweep, (sweep, out), rounds=1)
    share = 1 - sum(points) / sum(seconds)
    least = time_of_bare_files(out, tmp_path / "bare") / sum(seconds)
    print(
        f"\n{preset}: store and scheduling take {100 * share:.0f} % of CPU time",
        end="; ",
    )
    print(f"its {1e3 * sum(points) / outcome.done:.0f} ms a point are simulation,", end=" ")
    print(f"the bare files would take {100 * least:.0f} %")
    assert share < 0.5
