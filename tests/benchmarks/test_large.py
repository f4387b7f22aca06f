"""What a sweep of many points costs beside its simulation: planned, stored, opened, gone on with.

Time and memory of the process, at 1 000 and at 10 000 points; one result stands for all of them.
"""

import itertools
import resource
import time
from dataclasses import replace

import numpy as np
import pytest

from pipeline.analysis.boundary import decisive_temperature
from pipeline.analysis.dataset import open_sweep
from pipeline.run import sweep as execute
from pipeline.store import compact_store, locked, prepare, summary
from pipeline.sweep.plan import chains, points, run_point
from tests.helpers import tiny

VELOCITIES = {100: 10, 1_000: 25, 10_000: 100}


def sweep_of(number):
    loads = tuple(np.linspace(150.0, 600.0, number // VELOCITIES[number]).tolist())
    velocities = tuple(np.linspace(0.5, 2.0, VELOCITIES[number]).tolist())
    return tiny.sweep(loads=loads, velocities=velocities)


class Clock:
    """Says what took how long."""

    def __init__(self, number):
        self._number, self.seconds, self.last = number, {}, time.process_time()

    def __call__(self, what):
        now = time.process_time()
        self.seconds[what], self.last = now - self.last, now
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
        print(f"{self._number} points: {what} {self.seconds[what]:.2f} s, up to {memory:.0f} MB")


def left_to_do(store):
    none = np.zeros(store.array("status").shape, bool)
    return execute._todo(store, retry_failed=False, checked=none)[0]


def costs(number, path):
    sweep = sweep_of(number)
    result = run_point(sweep, sweep.loads[-1], 1.0)
    clock = Clock(number)
    with locked(path):
        chains(points(sweep))
        clock("plan")
        store = prepare(path, sweep)
        clock("create")
        for point in points(sweep):
            store.commit(replace(result, point=point))
        clock("store")
        assert left_to_do(store) == []
        clock("resume")
    assert summary(path).done == number
    clock("status")
    for layout in ("", "compact "):
        with open_sweep(path) as ds:
            clock(f"open {layout}")
            assert np.isfinite(ds["time"].isel(step=0)).all()
            assert np.isfinite(decisive_temperature(ds)).any()
            clock(f"read {layout}")
        if not layout:
            compact_store(path)
            clock("compact")
    with locked(path):
        assert left_to_do(prepare(path, sweep)) == []
        clock("resume compact")
    return clock.seconds


@pytest.mark.parametrize("numbers", [(100, 1_000), (1_000, 10_000)])
def test_costs_grow_no_faster_than_points(benchmark, tmp_path, numbers):
    paths = (tmp_path / f"{number}.zarr" for number in itertools.cycle(numbers))
    few, many = benchmark.pedantic(
        lambda: [costs(number, next(paths)) for number in numbers], rounds=1
    )
    for what, seconds in many.items():
        assert seconds < 15 * max(few[what], 0.05), what
