"""Estimates of `irg check`, compared with measured costs."""

import time
from functools import partial

import numpy as np
import pytest

import tribo
from pipeline import Conditions, estimate
from pipeline.sweep.plan import points, tasks
from tests.helpers.entries import changed
from tests.helpers.points import run_point
from tests.helpers.scenes import STEEL
from tests.helpers.sweeps import sweep_of_fields
from tribo import Fidelity, Grid, Ramp
from tribo.simulation import RampCache

SWEEP = sweep_of_fields(
    pin=tribo.Cylinder(radius=2e-3, length=3.4e-3, material=STEEL),
    disk=STEEL,
    pixels=Grid((64, 32), (6e-6, 6e-6)),
    loading=Ramp(rate=150.0, reference_load=750.0),
    roughness=tribo.SelfAffineRoughness(0.27e-6, 0.8, (8e-6, 8e-6), seed=0),
    wear=tribo.Wear(1.2e-15),
    name="paper",
    title="The paper's system on a small window",
    loads=(250.0, 500.0, 750.0),
    velocities=(1.0, 2.0),
    conditions=Conditions(0.1, 298.15, 418.15),
)


@pytest.fixture
def clock(monkeypatch):
    """Clock of processor time [s] that advances by transforms only: 10 µs for each element."""
    seconds = [0.0]

    def counted(transform, array, *args, **options):
        seconds[0] += 1e-5 * array.size
        return transform(array, *args, **options)

    for kind in ("rfft", "irfft", "fft", "ifft"):
        monkeypatch.setattr(np.fft, kind, partial(counted, getattr(np.fft, kind)))
    monkeypatch.setattr(time, "process_time", lambda: seconds[0])
    return time.process_time


@pytest.mark.parametrize(
    "changes",
    [
        {"fidelity": Fidelity(increments=30)},
        {"fidelity": Fidelity(increments=6), "steps": "end"},
        {"fidelity": Fidelity(increments=9), "loading": Ramp(150.0, 750.0, 1.0)},
    ],
    ids=["ramp", "end", "hold"],
)
def test_the_time_of_a_sweep_is_estimated_within_a_factor_of_three(changes, clock):
    sweep = changed(SWEEP, **{"roughness": None} | changes)
    cost = estimate(sweep, workers=1)
    began, ramp_cache = clock(), RampCache()
    for task in tasks(points(sweep), sweep):
        run_point(sweep, task.point, ramp_cache)
    seconds = clock() - began
    assert (cost.points, cost.tasks) == (6, 6)
    assert 1 / 3 < (cost.seconds - 1.0) / seconds < 3  # one second starts the workers


def test_workers_share_the_time_but_no_more_than_there_are_cores(clock, monkeypatch):
    monkeypatch.setattr("dask.system.cpu_count", lambda: 2)
    sweep = changed(SWEEP, roughness=None, steps="end", loads=(250.0, 500.0))
    times = [estimate(sweep, workers).seconds - 1.0 for workers in (1, 1, 2, 8)]
    _, one, two, eight = times  # the first also transforms influences, which are kept
    assert (two, eight) == pytest.approx((one / 2, one / 2))
