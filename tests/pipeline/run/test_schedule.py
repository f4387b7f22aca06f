"""Results of a task, and the fate of lost ones (pipeline/run/schedule.py and work.py).

Workers that really die are in test_sweep.py.
"""

import pickle
from collections import Counter, deque

import numpy as np
import pytest
import xarray as xr

import pipeline
import tribo
from pipeline.analysis.attributes import attributes_of
from pipeline.run import order, schedule, work
from pipeline.run.cluster import Connection
from pipeline.run.schedule import TRIALS, compute
from pipeline.run.source import ExecutionError, Source, unheard
from pipeline.run.writer import Writer
from pipeline.store.create import writing
from pipeline.store.progress import summarized
from pipeline.store.schema import COLUMNS, FAILED
from pipeline.sweep.plan import chains, points, run_point, run_points
from tests.helpers import tiny
from tests.helpers.local_client import Ended, LocalClient

SWEEP = tiny.sweep(velocities=tuple(np.linspace(0.5, 1.5, 8).tolist()))


@pytest.fixture
def compute_sweep(tmp_path, monkeypatch):
    """A function that computes a sweep in tasks of some duration, on a client without a cluster."""

    def compute_all(seconds=1e9, client=None, tell=None):
        monkeypatch.setattr(schedule, "_STRETCH", seconds)
        monkeypatch.setattr(schedule, "_POLL", 0.01)
        ended = []
        with writing(tmp_path / "out.zarr", SWEEP) as store, Writer(store) as writer:
            waiting = chains(points(SWEEP), SWEEP)
            link = Connection(client or LocalClient(), Source(), 1.0, tell or unheard)
            compute(link, SWEEP, writer, waiting, ended.extend)
        return store, Counter("failed" if point.data is None else "done" for point in ended)

    return compute_all


def failing_at(bad):
    def run(sweep, places, trunk=None):
        if bad in places:
            raise tribo.ConvergenceError("the contact did not converge", solution=None)
        return run_points(sweep, places, trunk)

    return run


def assert_is_as_computed_alone(store, place):
    expected = run_point(SWEEP, *place).columns
    with xr.open_zarr(store.place.path, chunks=None) as ds:
        point = ds.sel(load=place.load, velocity=place.velocity)
        for name in COLUMNS:
            stored = point[name].values[: len(expected[name])]
            assert stored.tobytes() == expected[name].tobytes()


def test_short_points_share_a_task_with_the_next_of_their_chain_and_with_other_chains(
    compute_sweep,
):
    """As long as enough chains are left for other workers."""
    client = LocalClient(workers=2)
    store, ended = compute_sweep(client=client)
    assert [len(task[1]) for task in client.tasks] == [15, 3, 3, 3]
    assert ended == {"done": 24}
    for place in points(SWEEP)[9:12]:
        assert_is_as_computed_alone(store, place)


def test_a_point_that_fails_costs_no_other_of_its_task(compute_sweep, monkeypatch):
    bad = points(SWEEP)[10]
    monkeypatch.setattr(work, "run_points", failing_at(bad))
    client = LocalClient()
    store, ended = compute_sweep(client=client)
    assert len(client.tasks) == 2
    assert ended == {"done": 23, "failed": 1}
    (failed,) = summarized(store).failed
    assert (failed.load, failed.velocity) == bad[:2]
    assert failed.message == "ConvergenceError: the contact did not converge"
    for place in (points(SWEEP)[9], points(SWEEP)[11]):
        assert_is_as_computed_alone(store, place)


@pytest.mark.parametrize("number", [1, 2])
def test_a_trunk_from_any_task_gives_the_same_numbers(number):
    """As when Dask runs a task again for its trunk, and that comes less far or farther."""
    parcel, (first, second, third) = pickle.dumps((SWEEP, False)), points(SWEEP)[:3]
    before = work.compute_points(parcel, (first, second)[:number], None, 1e9)
    (*_, record) = work.compute_points(parcel, (third,), before, 1e9).records
    for name, values in run_point(SWEEP, *third).columns.items():
        assert record.data[name].tobytes() == values.tobytes()


def test_the_points_that_workers_die_of_fail_after_trials_alone_and_no_others(compute_sweep):
    deadly = {place for place in points(SWEEP) if place.load == 250.0}
    client = LocalClient(workers=2, is_deadly=deadly.__contains__)
    store, ended = compute_sweep(client=client)
    assert ended == {"done": 16, "failed": 8}
    assert set(store.points_at(np.nonzero(store.flags == FAILED))) == deadly
    alone = [task[1] for task, worker in zip(client.tasks, client.pinned, strict=True) if worker]
    assert Counter(alone) == {(place,): TRIALS for place in deadly}
    for place in points(SWEEP)[:3:2]:
        assert_is_as_computed_alone(store, place)


def test_workers_that_are_killed_from_outside_cost_no_point(compute_sweep):
    client = LocalClient(workers=2, is_hit=lambda number: number % 3 == 0)
    _, ended = compute_sweep(seconds=0.0, client=client)
    assert ended == {"done": 24}


def test_the_packages_of_workers_that_differ_are_stored(compute_sweep, monkeypatch):
    other = {**work.versions(), "numpy": "1.0"}
    monkeypatch.setattr(work, "versions", lambda: other)
    store, ended = compute_sweep()
    assert ended == {"done": 24}
    with pipeline.open_sweep(store.place.path) as ds:
        (noted,) = attributes_of(ds)["worker_versions"]
        assert noted["versions"] == {name: other[name] for name in ("python", "numpy", "scipy")}
        assert "some points computed by workers with python" in ds.attrs["history"]


class Lossy(LocalClient):
    """A client of which finished tasks are lost with their worker, and then finished again."""

    class Lost(Ended):
        looks = 0

        def done(self):
            self.looks += 1
            return self.looks > 3

    def submit(self, *arguments, **options):
        ended = super().submit(*arguments, **options)
        ended.__class__ = self.Lost
        return ended


def test_a_task_that_was_lost_after_it_had_finished_is_waited_for(compute_sweep, monkeypatch):
    monkeypatch.setattr(schedule, "wait_for_any", lambda *_: None)
    _, ended = compute_sweep(client=Lossy())
    assert ended == {"done": 24}


class Stuck(LocalClient):
    """A client that never finishes a task; workers have been given the first `busy` of them."""

    def __init__(self, busy=0):
        super().__init__()
        self._busy, self._asked = busy, 0

    def submit(self, function, *arguments, **options):
        if len(arguments) == 1 and not isinstance(arguments[0], Ended):
            return super().submit(function, *arguments, **options)
        ended = Ended()
        ended.key = "stuck"
        return ended

    def processing(self):
        self._asked += 1
        return {"here 0": ("stuck",) if self._asked <= self._busy else ()}


@pytest.mark.parametrize("busy", [0, 40])
def test_a_sweep_in_which_nothing_moves_says_so_and_ends(compute_sweep, monkeypatch, busy):
    """But it does not end while a worker computes."""
    monkeypatch.setattr(schedule, "wait_for_any", lambda *_: None)
    monkeypatch.setattr(schedule, "_END", 0.2)
    monkeypatch.setattr(schedule, "_WORD", 0.1)
    messages, client = [], Stuck(busy)
    with pytest.raises(ExecutionError, match=r"no worker computes any; finished points are safe"):
        compute_sweep(client=client, tell=messages.append)
    assert client._asked > busy
    assert "no point has been finished for 0 s; waiting for 150 N, 0.5 m/s" in messages[0]


def test_velocities_that_show_the_whole_boundary_early_are_tasks_of_their_own():
    sweep = tiny.sweep(velocities=tuple(np.geomspace(0.5, 5.0, 400).tolist()))
    run = object.__new__(schedule._Run)
    run._sweep, run.running = sweep, []
    in_order = order.coarse_first(chains(points(sweep), sweep), sweep.plane.velocities)
    run.waiting = deque(map(schedule._Chain, in_order))
    first, second = ({point.velocity for point in run._next(threads=2).points} for _ in range(2))
    assert len(first) == len(second) == 1
    while len(run.waiting) > 300:
        neighbours = {point.velocity for point in run._next(threads=2).points}
    assert len(neighbours) > 1
