"""Cost of a sweep of many points beside its simulation: planned, stored, opened, gone on with.

Time and memory of the process, at 1 000 and at 10 000 points; one result stands for all of them.
"""

import itertools
import resource
import time
from dataclasses import replace

import numpy as np
import pytest

from pipeline.analysis.dataset import open_sweep
from pipeline.analysis.decisive import decisive_temperature
from pipeline.store.create import writing
from pipeline.store.progress import summary
from pipeline.store.verify import examined
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


def costs(number, path):
    sweep = sweep_of(number)
    result = run_point(sweep, sweep.plane.loads[-1], 1.0)
    clock = Clock(number)
    chains(points(sweep), sweep)
    clock("plan")
    with writing(path, sweep) as store:
        clock("create")
        records = (replace(result, point=point).record(False) for point in points(sweep))
        while several := list(itertools.islice(records, 40)):
            store.commit(several)
        clock("store")
    with writing(path, sweep) as store:
        assert examined(store, repair=True).is_clean
        assert store.pending() == []
    clock("resume")
    assert summary(path).done == number
    clock("status")
    with open_sweep(path) as ds:
        clock("open")
        assert np.isfinite(ds["time"].sel(step=0)).all()
        assert np.isfinite(decisive_temperature(ds)).any()
        clock("read")
    return clock.seconds


@pytest.mark.parametrize("numbers", [(100, 1_000), (1_000, 10_000)])
def test_costs_of_many_points_beside_few(benchmark, tmp_path, numbers):
    paths = (tmp_path / f"{number}.zarr" for number in itertools.cycle(numbers))
    few, many = benchmark.pedantic(
        lambda: [costs(number, next(paths)) for number in numbers], rounds=1
    )
    print({what: seconds / max(few[what], 0.05) for what, seconds in many.items()})
