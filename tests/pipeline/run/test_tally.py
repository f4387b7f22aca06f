"""The time to go that a run tells (pipeline/run/tally.py)."""

import time

import numpy as np
import pytest

from pipeline.run.cluster import Connection
from pipeline.run.source import Source
from pipeline.run.tally import Tally
from pipeline.store.create import writing
from pipeline.store.schema import DONE
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord
from tests.helpers import tiny

START, COUNT = 10.0, 100


def test_the_start_of_the_workers_is_not_taken_for_the_pace_of_their_points(tmp_path, monkeypatch):
    """Two workers begin after 10 s, and finish a point of 1 s each in every second."""
    sweep = tiny.sweep(loads=(150.0,), velocities=tuple(np.linspace(0.5, 1.5, COUNT).tolist()))
    now, told = 0.0, []
    monkeypatch.setattr(time, "monotonic", lambda: now)
    with writing(tmp_path / "out.zarr", sweep) as store:
        tally = Tally(store, told.append, now)
        tally.begin(store, Connection(None, Source()))
        for number, velocity in enumerate(sweep.velocities[:20]):
            now = START + 1 + number // 2
            point = Point(150.0, velocity)
            store.flags[store.index(point)] = DONE
            tally.note([PointRecord(point, {}, wall_time=1.0)])
    assert told[-1].time_to_go == pytest.approx((COUNT - 20) / 2, rel=0.15)
