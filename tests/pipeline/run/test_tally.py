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
from pipeline.sweep.plan import PointRecord, points
from pipeline.sweep.stages import silent
from tests.helpers import tiny

START, COUNT = 10.0, 100


@pytest.fixture
def tallied(tmp_path, monkeypatch):
    """A function that tells a tally of points that end at these times; the time to go."""

    def run(ends, absent=0.0, workers=1, since=0.0):
        now, reports, link = 0.0, [], Connection(None)
        monkeypatch.setattr(time, "monotonic", lambda: now)
        sweep = tiny.sweep(loads=(150.0,), velocities=tuple(np.linspace(0.5, 1.5, COUNT).tolist()))
        with writing(tmp_path / "out.zarr", sweep) as store:
            tally = Tally(store, reports.append, now)
            tally.begin(store, link)
            for now, velocity in zip(ends, sweep.plane.velocities, strict=False):
                link.workers, link.absent = (workers, absent) if now > since else (1, 0.0)
                point = Point(150.0, velocity)
                store.flags[store.index(point)] = DONE
                tally.learn([PointRecord(point, {}, wall_time=1.0)])
        return reports[-1].time_to_go

    return run


LATER = [1.0 + number for number in range(20)] + [20.0 + number / 10 for number in range(40)]


@pytest.mark.parametrize(
    ("ends", "options", "to_go"),
    [
        # Two workers begin after 10 s, and finish a point of 1 s each in every second.
        ([START + 1 + number // 2 for number in range(20)], {"workers": 2}, (COUNT - 20) / 2),
        # The first point tells nothing of the start of the workers.
        ([60.0], {"workers": 2}, (COUNT - 1) / 2),
        # The last point is done.
        ([60.0 + number for number in range(COUNT)], {}, 0.0),
        # More workers than points do not shorten the last of them.
        ([60.0], {"workers": 1000}, 1.0),
        # A worker finishes a point of 1 s in every 2 s: the schedule costs more than the point.
        ([START + 2.0 * number for number in range(20)], {}, 2 * (COUNT - 20)),
        # No worker for an hour after the first 20 points, each of which took a second.
        ([*range(1, 21), *range(3621, 3641)], {"absent": 3600.0, "since": 20.0}, COUNT - 40),
        # One worker for 20 s, ten from then on: 40 points are left.
        (LATER, {"workers": 10, "since": 20.0}, 4.0),
    ],
    ids=["start", "first point", "end", "last points", "schedule", "queue", "later workers"],
)
def test_the_time_to_go_is_told_by_the_pace_of_the_points_and_not_by_waits(
    tallied, ends, options, to_go
):
    assert tallied(ends, **options) == pytest.approx(to_go, rel=0.15)


def test_points_that_all_fail_alike_end_a_run(tmp_path):
    sweep = tiny.sweep(velocities=tuple(np.linspace(0.5, 1.5, 10).tolist()))
    places = points(sweep)
    with writing(tmp_path / "out.zarr", sweep) as store:
        tally = Tally(store, silent, time.monotonic())
        tally.begin(store, Connection(None))
        failures = [PointRecord(point, None, f"OSError: no file at {point}") for point in places]
        other = [PointRecord(point, None, "MemoryError: ") for point in places]
        tally.count([*failures[:19], *other[:19]])
        with pytest.raises(ExecutionError, match=r"first 20 points failed alike, .*: OSError: no"):
            tally.count(failures[19:20])
        done = Tally(store, silent, time.monotonic())
        done.begin(store, Connection(None))
        done.count([PointRecord(places[-1], {}, wall_time=1.0), *failures])


def test_progress_counts_the_points_that_are_asked_for_and_the_time_of_those_to_come(copy):
    sweep, reports = tiny.full(loads=(150.0, 250.0)), []
    with writing(copy, sweep) as store:
        store.commit([PointRecord(Point(150.0, 0.5), None, "out of memory")])
        store.forget([Point(250.0, velocity) for velocity in (0.5, 1.0, 1.5)])
        times = store.read("wall_time", ...)[store.flags == DONE]
        began = time.monotonic() - 7.0
        tally = Tally(store, reports.append, began)
        tally.begin(store, Connection(None, workers=2))
        tally.count([])
        tally.count([PointRecord(Point(150.0, 0.5), None, "out of memory")])
        point = Point(250.0, 0.5)
        tally.count([PointRecord(point, {}), PointRecord(point, {})])
    assert tally.computed == 2
    first, *_ = reports
    assert (first.done, first.total, first.failed, first.time_to_go) == (2, 6, 1, None)
    assert 7.0 <= first.elapsed <= time.monotonic() - began
    assert len(reports) == 3  # nothing was written once
    # Three points on two workers, each of the mean time of all points that are there.
    assert reports[-1].time_to_go == pytest.approx(1.5 * np.mean(times), rel=1e-9)
