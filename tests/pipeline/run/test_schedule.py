"""Which points share a task (pipeline/run/schedule.py); workers that die are in test_execute.py."""

from collections import Counter

import numpy as np
import pytest

import tribo
from pipeline.run import schedule
from pipeline.run.schedule import compute
from pipeline.store.points import Store, prepare
from pipeline.store.progress import summarized
from pipeline.store.variables import COLUMNS
from pipeline.sweep.model import Point
from pipeline.sweep.plan import chains, points, run_point
from tests.helpers import tiny
from tests.helpers.here import Here

SWEEP = tiny.sweep(velocities=tuple(np.linspace(0.5, 1.5, 8)))


@pytest.fixture
def given(tmp_path, monkeypatch):
    """A function that computes a sweep in tasks of some duration; gives the points of each task."""

    def compute_all(seconds=1e9):
        monkeypatch.setattr(schedule, "_STRETCH", seconds)
        store, client, ended = prepare(tmp_path / "out.zarr", SWEEP), Here(), Counter()
        compute(client, SWEEP, store, chains(points(SWEEP)), 1.0, lambda **one: ended.update(one))
        _, *tasks = client.tasks  # the first is to share the sweep
        return store, [task[2] for task in tasks], ended

    return compute_all


def assert_is_as_computed_alone(store, place):
    expected = run_point(SWEEP, *place).columns
    for name in COLUMNS:
        found = store.values(name)[store._index(place)][: len(expected[name])]
        assert found.tobytes() == expected[name].tobytes()


def test_a_point_that_takes_its_time_is_a_task_of_its_own(given):
    _, tasks, ended = given(seconds=1e-9)
    assert [len(task) for task in tasks] == [1] * 24
    assert sorted(sum(tasks, ())) == sorted(points(SWEEP))
    assert ended == {"done": 24}


def test_points_that_are_too_short_for_a_task_share_one_with_the_next_of_their_chain(given):
    store, tasks, ended = given()
    assert len(tasks) < 16
    assert max(len(task) for task in tasks) == 3
    assert sorted(sum(tasks, ())) == sorted(points(SWEEP))
    assert all(len({point.velocity for point in task}) == 1 for task in tasks)
    assert ended == {"done": 24}
    for place in points(SWEEP)[9:12]:
        assert_is_as_computed_alone(store, place)


def test_the_last_chains_are_cut_short_so_that_they_end_together(given):
    _, tasks, _ = given()
    assert len(tasks[-1]) == 1


def test_a_point_that_fails_costs_no_other_of_its_task(given, monkeypatch):
    bad = points(SWEEP)[10]

    def failing(sweep, load, velocity, realization, trunk=None):
        if Point(load, velocity) == bad:
            raise tribo.ConvergenceError("the contact did not converge", solution=None)
        return run_point(sweep, load, velocity, realization, trunk)

    monkeypatch.setattr(schedule, "run_point", failing)
    store, tasks, ended = given()
    assert any(bad in task and len(task) == 3 for task in tasks)
    assert ended == {"done": 23, "failed": 1}
    (failed,) = summarized(store).failed
    assert (failed.load, failed.velocity) == bad[:2]
    for place in (points(SWEEP)[9], points(SWEEP)[11]):
        assert_is_as_computed_alone(store, place)


def test_a_store_that_cannot_be_written_ends_it_all(given, monkeypatch):
    def full(*_):
        raise schedule.StoreError("no room")

    monkeypatch.setattr(Store, "commit", full)
    with pytest.raises(schedule.StoreError, match="no room"):
        given()
