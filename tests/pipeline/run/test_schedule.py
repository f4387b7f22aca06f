"""Tasks of points, and the fate of lost ones (pipeline/run/schedule.py, tally.py and work.py).

Workers that really die are in test_sweep.py.
"""

from collections import Counter
from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from distributed.scheduler import KilledWorker

import pipeline
import tribo
from pipeline.run import schedule, work
from pipeline.run.cluster import Connection
from pipeline.run.schedule import STARTS, TRIALS, compute
from pipeline.run.work import ExecutionError
from pipeline.store.create import writing
from pipeline.store.progress import summarized
from pipeline.store.schema import COLUMNS, FAILED
from pipeline.store.write import Writer
from pipeline.sweep.plan import points, run_points, tasks
from pipeline.sweep.stages import silent
from tests.helpers import tiny
from tests.helpers.heard import Heard

SWEEP = tiny.sweep(velocities=tuple(np.linspace(0.5, 1.5, 4).tolist()))


class LocalClient:
    """The part of a client that a sweep needs, with a number of workers of one thread each.

    `is_deadly` tells if a worker dies of computing a point, `is_hit` if one is killed from outside
    before it begins with the task of a number. `tasks` has the points of each task that was
    submitted, `pinned` the worker to which it was pinned.
    """

    def __init__(self, workers=1, is_deadly=lambda _: False, is_hit=lambda _: False):
        self._workers, self._is_deadly, self._is_hit = workers, is_deadly, is_hit
        self.tasks, self.pinned, self.results = [], [], {}
        self.cancelled = []

    def sync(self, function, *arguments, callback_timeout=None, **options):
        return function(*arguments, **options)

    def run(self, function, *arguments, workers, **_):
        if function is not work.records_here:
            return {}
        there = SimpleNamespace(data=self.results)
        return {
            worker: self.answer(worker, work.records_here(*arguments, there)) for worker in workers
        }

    def answer(self, worker, report):
        """What a worker answers, of which tests make something else."""
        return report

    def nthreads(self, **_):
        return {f"here {number}": 1 for number in range(self._workers)}

    def submit(self, function, *arguments, key, workers, **options):
        ended = Ended()
        ended.key = key
        _, _, points = arguments
        self.tasks.append(points)
        self.pinned.append(None if options["allow_other_workers"] else workers)
        try:
            if self._is_hit(len(self.tasks) - 1) or any(map(self._is_deadly, points)):
                raise KilledWorker(key, None, 0)
            self.results[key] = function(*arguments)
            ended.status = "finished"
            ended.set_result(self.results[key])
        except Exception as error:
            ended.status = "error"
            ended.set_exception(error)
        return ended

    def cancel(self, futures):
        self.cancelled += futures


class Ended(Future):
    """A task that has ended, with what Dask's futures have besides."""

    key = ""
    status = "pending"


@pytest.fixture
def compute_sweep(tmp_path, monkeypatch):
    """A function that computes a sweep on a client without a cluster."""
    monkeypatch.setattr(schedule, "_POLL", 0.01)

    def compute_all(client=None, progress=silent):
        ended, learned = [], []
        tally = SimpleNamespace(learn=learned.extend, count=ended.extend)
        with writing(tmp_path / "out.zarr", SWEEP) as store, Writer(store) as writer:
            waiting = tasks(points(SWEEP), SWEEP)
            link = Connection(client or LocalClient(), 1.0, progress)
            compute(link, SWEEP, writer, waiting, tally)
        assert len(learned) < len(ended)  # the first point of a worker tells of its start, too
        return store, Counter("failed" if point.data is None else "done" for point in ended)

    return compute_all


def failing_at(bad):
    def run(sweep, places, trunks=None):
        if bad in places:
            raise tribo.ConvergenceError("the contact did not converge", solution=None)
        return run_points(sweep, places, trunks)

    return run


def assert_is_as_computed_alone(store, place):
    expected = run_points(SWEEP, [place])[0].columns
    with xr.open_zarr(store.place.path, chunks=None) as ds:
        point = ds.sel(load=place.load, velocity=place.velocity)
        for name in COLUMNS:
            stored = point[name].values[-len(expected[name]) :]
            assert stored.tobytes() == expected[name].tobytes()
        assert point["steps"] == len(expected["time"])


def test_a_point_that_fails_costs_no_other_of_its_ramp(compute_sweep, monkeypatch):
    bad = points(SWEEP)[10]
    monkeypatch.setattr(work, "run_points", failing_at(bad))
    store, ended = compute_sweep()
    assert ended == {"done": 11, "failed": 1}
    (failed,) = summarized(store).failed
    assert (failed.load, failed.velocity) == bad[:2]
    assert failed.message == "ConvergenceError: the contact did not converge"
    for place in (points(SWEEP)[9], points(SWEEP)[11]):
        assert_is_as_computed_alone(store, place)


def test_the_points_that_workers_die_of_fail_after_trials_alone_and_no_others(compute_sweep):
    deadly = {place for place in points(SWEEP) if place.load == 250.0}
    client = LocalClient(workers=2, is_deadly=deadly.__contains__)
    store, ended = compute_sweep(client=client)
    assert ended == {"done": 8, "failed": 4}
    assert set(store.points_at(np.nonzero(store.flags == FAILED))) == deadly
    alone = [task for task, worker in zip(client.tasks, client.pinned, strict=True) if worker]
    assert Counter(alone) == {(place,): TRIALS for place in deadly}
    for place in points(SWEEP)[:3:2]:
        assert_is_as_computed_alone(store, place)


def test_workers_that_are_killed_from_outside_cost_no_point(compute_sweep):
    client = LocalClient(workers=2, is_hit=lambda number: number % 3 == 0)
    store, ended = compute_sweep(client=client)
    assert ended == {"done": 12}
    for place in points(SWEEP)[::5]:
        assert_is_as_computed_alone(store, place)


def test_the_packages_of_workers_that_differ_are_told_once_and_stored(compute_sweep, monkeypatch):
    other = {**work.versions(), "numpy": "1.0"}
    monkeypatch.setattr(work, "versions", lambda: other)
    messages = Heard()
    store, ended = compute_sweep(client=LocalClient(workers=3), progress=messages.hear)
    assert ended == {"done": 12}
    (said,) = messages
    assert "has numpy 1.0 (here " in said
    with pipeline.open_sweep(store.place.path) as ds:
        (noted,) = store.root.facts.worker_versions.values()
        assert noted == {name: other[name] for name in ("python", "numpy", "scipy")}
        assert "some points computed by workers with python" in ds.attrs["history"]


class Forgetful(LocalClient):
    """A client whose workers have lost their results the first times that they are asked."""

    asked = 0

    def answer(self, worker, report):
        self.asked += 1
        return report if self.asked > 3 else report._replace(records={})


def test_results_that_were_lost_with_a_worker_are_waited_for(compute_sweep):
    client = Forgetful()
    _, ended = compute_sweep(client=client)
    assert ended == {"done": 12}
    assert client.asked > 3


class Bare(LocalClient):
    """A client whose workers have not what is to be computed the first times."""

    def run(self, function, keys, run, parcel, **options):
        self.sent = getattr(self, "sent", 0) + (parcel is not None)
        return super().run(function, keys, run, parcel if self.sent > 2 else None, **options)


def test_a_worker_that_a_task_comes_to_before_the_scene_is_sent_it_again(compute_sweep):
    client = Bare()
    _, ended = compute_sweep(client=client)
    assert ended == {"done": 12}
    assert client.sent == 3


class Dying(LocalClient):
    """A client whose workers die as they are asked, and answer nothing."""

    def answer(self, worker, report):
        return OSError("the worker has died")


class Foreign(LocalClient):
    """A client whose workers have not this program."""

    def answer(self, worker, report):
        return ModuleNotFoundError("No module named 'pipeline'")


def test_a_worker_without_this_program_is_refused(compute_sweep):
    with pytest.raises(ExecutionError, match="cannot run this program: No module named"):
        compute_sweep(client=Foreign())


class Stuck(LocalClient):
    """A client that never finishes a task; its worker computes for the first looks."""

    def __init__(self, busy=0):
        super().__init__()
        self._busy, self.asked = busy, 0

    def submit(self, *arguments, key, **options):
        ended = Ended()
        ended.key = key
        return ended

    def answer(self, worker, report):
        self.asked += 1
        return report._replace(now="another" if self.asked <= self._busy else None)


@pytest.mark.parametrize("busy", [0, 40])
def test_a_sweep_in_which_nothing_moves_says_so_and_ends(compute_sweep, monkeypatch, busy):
    """But it does not end while a worker computes."""
    monkeypatch.setattr(schedule, "_END", 0.2)
    monkeypatch.setattr(schedule, "_WORD", 0.1)
    messages, client = Heard(), Stuck(busy)
    with pytest.raises(ExecutionError, match=r"no worker computes any; finished points are safe"):
        compute_sweep(client=client, progress=messages.hear)
    assert client.asked > busy
    place = "waiting for 150 N, 0.5 m/s and 1 more"
    assert f"no point has been finished for 0 s; {place}" in messages[0]


def test_workers_that_do_not_answer_end_a_sweep_too(compute_sweep, monkeypatch):
    monkeypatch.setattr(schedule, "_END", 0.2)
    with pytest.raises(ExecutionError, match="no worker computes any"):
        compute_sweep(client=Dying())


class Retiring(LocalClient):
    """A client whose workers leave before they are done with one point, and others come."""

    def __init__(self, bad):
        super().__init__()
        self._bad, self.generation, self._on = bad, 0, None

    def nthreads(self, **_):
        return {f"worker {self.generation}": 1}

    def submit(self, function, name, run, points, **options):
        if self._bad not in points:
            return super().submit(function, name, run, points, **options)
        ended = Ended()
        self.endless, self._on = name, options["workers"]
        ended.key = name
        return ended

    def answer(self, worker, report):
        if worker == self._on:
            self.generation += 1
            return report._replace(now=self.endless)
        return report


def test_a_point_that_is_begun_on_workers_that_all_leave_fails_and_others_go_on(compute_sweep):
    bad = points(SWEEP)[9]
    client = Retiring(bad)
    store, ended = compute_sweep(client=client)
    assert ended == {"done": 11, "failed": 1}
    (failed,) = summarized(store).failed
    assert (failed.load, failed.velocity) == bad[:2]
    assert failed.message.startswith(f"begun on {STARTS} workers, and each left before")
    assert client.cancelled[-1].key == client.endless
    assert_is_as_computed_alone(store, points(SWEEP)[10])
