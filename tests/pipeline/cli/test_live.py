"""The rate at which a sweep goes, as its store tells it."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cli import main
from pipeline.store.create import writing
from pipeline.store.progress import pace, summary
from pipeline.sweep.plan import points
from tests.helpers import tiny
from tests.helpers.stores import commit, record

SWEEP = tiny.full(loads=(150.0, 250.0, 600.0), velocities=(0.5, 1.0))


def commit_at(path, times):
    with writing(path, SWEEP) as store:
        first = zip(points(SWEEP), times, strict=False)
        store.commit(replace(record(point), finished_at=time) for point, time in first)


def test_the_rate_and_the_time_to_go_are_known_from_the_store(tmp_path):
    path = tmp_path / "tiny.zarr"
    commit(path, SWEEP, ())
    assert summary(path).rate is None
    commit_at(path, (100.0, 7000.0, 7002.0, 7004.0))
    now = summary(path)
    assert now.rate == 0.5
    assert now.time_to_go == 4.0
    assert now.running is None
    with writing(path, SWEEP):
        assert summary(path).running.startswith("process ")


def test_status_says_how_long_it_takes(tmp_path, capsys):
    commit_at(tmp_path / "tiny.zarr", (0.0, 40.0, 80.0))
    assert main(["status", str(tmp_path / "tiny.zarr")]) == 0
    assert "1.5 points a minute the last time, 2 min to go" in capsys.readouterr().out


def test_an_interruption_does_not_slow_the_rate_down():
    steady = np.arange(0.0, 100.0, 2.0)
    assert pace(steady) == pytest.approx(0.5)
    assert pace(np.concatenate([steady, 1e5 + np.arange(0.0, 10.0, 1.0)])) == pytest.approx(1.0)
    assert pace(np.array([])) is pace(np.array([5.0, 6.0])) is pace(np.full(9, 7.0)) is None
