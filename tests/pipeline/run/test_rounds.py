"""Sweeps that this process computes: how many workers are started, and the rounds of a search."""

from contextlib import contextmanager

import numpy as np
import pytest
from distributed import Client, LocalCluster

from pipeline.run import sweep as execute
from pipeline.run.boundary_search import results_of
from pipeline.run.cluster import PATIENCE, Connection
from pipeline.run.sweep import run_sweep
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.stores import opened


@pytest.fixture
def asked(monkeypatch):
    """What is asked of a cluster, in place of which threads here compute, as if of two cores."""
    wanted = []
    with (
        LocalCluster(n_workers=1, processes=False, dashboard_address="127.0.0.1:0") as cluster,
        Client(cluster, set_as_default=False) as client,
    ):

        @contextmanager
        def connected(_, workers, patience, progress, dashboard):
            wanted.append((workers, patience, dashboard))
            yield Connection(client, patience, progress)

        monkeypatch.setattr(execute, "connected", connected)
        monkeypatch.setattr(execute, "cores", lambda: 2)
        yield wanted


def test_workers_are_one_for_each_core_but_no_more_than_points_and_none_for_no_point(path, asked):
    few = tiny.sweep(loads=(150.0,), increments=2)
    outcome = run_sweep(few, path)
    assert (outcome.total, outcome.done, outcome.computed) == (3, 3, 3)
    assert outcome.wall_time > 0.0
    assert run_sweep(few, path).computed == 0
    more = run_sweep(changed(few, velocities=(1.0, 2.0)), path, workers=9, patience=9.0)
    assert (more.total, more.done, more.computed) == (2, 2, 1)
    assert asked == [(2, PATIENCE, False), (1, 9.0, False)]


def test_a_boundary_is_computed_round_by_round_by_the_same_workers_and_then_known(path, asked):
    sweep = tiny.sweep(velocities=(0.5, 8.0), increments=2)
    outcome = run_sweep(sweep, path, boundary_only=0.05)
    assert outcome.done == outcome.total == outcome.computed > 3
    rises, _ = results_of(opened(path), sweep)
    for load in tiny.LOADS:
        row = sorted((point.velocity, rise) for point, rise in rises.items() if point.load == load)
        velocities, heat = np.transpose(row)
        severe = heat >= 1200.0  # 120 K at friction 0.1
        (crossing,) = np.flatnonzero(severe[1:] > severe[:-1])
        # A straight line errs by less than 5 % there, even at the least bend that is taken, 0.2.
        assert np.log(velocities[crossing + 1] / velocities[crossing]) < np.sqrt(8 * 0.05 / 0.2)
    assert run_sweep(sweep, path, boundary_only=0.05).computed == 0
    assert asked == [(2, PATIENCE, False)]  # more points may come than the first three
