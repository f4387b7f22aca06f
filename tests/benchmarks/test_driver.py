"""What each worker costs the process that drives them, with points that take time and no core.

So as many workers as one likes run on a few cores, as on a cluster; what they commit is real.
"""

import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

import pipeline
from pipeline.run import schedule, work
from pipeline.run import sweep as execute
from tests.helpers import tiny

SECONDS = 12.0  # of work for each worker
LOADS = tuple(np.linspace(150.0, 600.0, 10).tolist())


class Waiting:
    """In a worker: a point that takes its time, with the data of the first at its load."""

    def __init__(self, seconds):
        self._seconds, self._known = seconds, {}
        self._run_point, work.run_point = work.run_point, self

    def __call__(self, sweep, load, velocity, *place, trunk=None):
        if load not in self._known:
            self._known[load] = self._run_point(sweep, load, velocity, *place)
        time.sleep(self._seconds)
        point = self._known[load].point._replace(velocity=velocity)
        return replace(self._known[load], point=point)


def wait_at_points(seconds):
    """Let a worker wait in place of computing."""
    Waiting(seconds)


@pytest.mark.parametrize("seconds", [0.25, 0.05])
@pytest.mark.parametrize("workers", [2, 4, 8, 16])
def test_cost_of_workers(benchmark, tmp_path, monkeypatch, workers, seconds):
    """Of the driver, once they have started; Dask's scheduler is a part of it."""
    connected, spans, started = execute.connected, [], []
    start = schedule._Run._start

    @contextmanager
    def waiting(*arguments):
        with connected(*arguments) as link:
            link.client.run(wait_at_points, seconds)
            began = time.process_time(), time.monotonic()
            yield link
            spans.append((time.process_time() - began[0], time.monotonic() - began[1]))

    def counted(self, *arguments):
        started.append(arguments)
        start(self, *arguments)

    monkeypatch.setattr(execute, "connected", waiting)
    monkeypatch.setattr(schedule._Run, "_start", counted)
    ramps = round(workers * SECONDS / seconds / len(LOADS))
    sweep = tiny.sweep(loads=LOADS, velocities=tuple(np.linspace(0.5, 4.0, ramps).tolist()))
    outcome = benchmark.pedantic(
        pipeline.run_sweep, (sweep, tmp_path / "out.zarr", workers), rounds=1
    )
    ((cpu, wall),) = spans
    print(
        f"\n{workers} workers, points of {seconds:g} s: the driver takes {100 * cpu / wall:.1f} % "
        f"of a core, {1e3 * cpu / len(started):.1f} ms a task, "
        f"{1e3 * cpu / outcome.done:.2f} ms a point ({outcome.done / len(started):.1f} a task); "
        f"{100 * outcome.done * seconds / workers / wall:.0f} % of the workers' time is work"
    )
    assert outcome.done == len(LOADS) * ramps
