"""The time to go that a run tells (pipeline/run/tally.py)."""

import time

import numpy as np
import pytest

from pipeline.run.cluster import Connection
from pipeline.run.tally import Tally
from pipeline.run.work import ExecutionError
from pipeline.store.create import writing
from pipeline.store.schema import DONE
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord, chains, points
from tests.helpers import tiny

START, COUNT = 10.0, 100


@pytest.fixture
def tallied(tmp_path, monkeypatch):
    """A function that tells a tally of points that end at these times; the time to go."""

    def run(ends, absent=0.0, workers=1):
        now, reports, link = 0.0, [], Connection(None)
        monkeypatch.setattr(time, "monotonic", lambda: now)
        sweep = tiny.sweep(loads=(150.0,), velocities=tuple(np.linspace(0.5, 1.5, COUNT).tolist()))
        with writing(tmp_path / "out.zarr", sweep) as store:
            tally = Tally(store, reports.append, now)
            tally.begin(store, link, chains(points(sweep), sweep))
            link.absent, link.workers = absent, workers
            for now, velocity in zip(ends, sweep.plane.velocities, strict=False):  # noqa: B007
                point = Point(150.0, velocity)
                store.flags[store.index(point)] = DONE
                tally.learn([PointRecord(point, {}, wall_time=1.0)])
        return reports[-1].time_to_go

    return run


def test_the_start_of_the_workers_is_not_taken_for_the_pace_of_their_points(tallied):
    """Two workers begin after 10 s, and finish a point of 1 s each in every second."""
    to_go = tallied([START + 1 + number // 2 for number in range(20)], workers=2)
    assert to_go == pytest.approx((COUNT - 20) / 2, rel=0.15)


def test_the_first_point_tells_a_time_and_nothing_of_the_start_of_the_workers(tallied):
    assert tallied([60.0], workers=2) == pytest.approx((COUNT - 1) / 2)


def test_more_workers_than_chains_do_not_shorten_the_last_of_them(tallied):
    assert tallied([60.0], workers=1000) == pytest.approx(1.0)


def test_points_that_cost_the_schedule_more_than_themselves_tell_the_pace(tallied):
    """A worker finishes a point of 1 s in every 2 s."""
    assert tallied([START + 2.0 * number for number in range(20)]) == pytest.approx(
        2 * (COUNT - 20)
    )


def test_the_wait_in_the_queue_is_not_taken_for_the_pace_of_points(tallied):
    """The first worker comes after an hour, and finishes a point in each second."""
    assert tallied([3601.0, 3602.0], absent=3600.0) == pytest.approx(COUNT - 2)


def test_workers_that_come_later_count_with_the_time_to_go(tallied):
    """One worker for 20 s, ten from then on."""
    ends = [1.0 + number for number in range(20)] + [20.0 + number / 10 for number in range(40)]
    assert tallied(ends, workers=10) < 15.0  # 40 points are left, and take ten workers 4 s


def test_points_that_all_fail_alike_end_a_run(tmp_path):
    sweep = tiny.sweep(velocities=tuple(np.linspace(0.5, 1.5, 10).tolist()))
    places = points(sweep)
    with writing(tmp_path / "out.zarr", sweep) as store:
        tally = Tally(store, None, time.monotonic())
        tally.begin(store, Connection(None), ())
        failures = [PointRecord(point, None, f"OSError: no file at {point}") for point in places]
        other = [PointRecord(point, None, "MemoryError: ") for point in places]
        tally.note([*failures[:19], *other[:19]])
        with pytest.raises(ExecutionError, match=r"first 20 points failed alike, .*: OSError: no"):
            tally.note(failures[19:20])
        done = Tally(store, None, time.monotonic())
        done.begin(store, Connection(None), ())
        done.note([PointRecord(places[-1], {}, wall_time=1.0), *failures])
