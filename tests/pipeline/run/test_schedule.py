"""Tasks of points, and the fate of lost ones (pipeline/run/schedule.py, tally.py and work.py).

Workers that really die are in test_sweep.py.
"""

from collections import Counter
from concurrent.futures import CancelledError, Future
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from distributed.scheduler import KilledWorker

import pipeline
import tribo
from pipeline.run import schedule, work
from pipeline.run.cluster import Connection
from pipeline.run.schedule import STARTS, TRIALS, _Run, _Running, compute
from pipeline.run.work import ExecutionError, WorkerReport
from pipeline.store.create import writing
from pipeline.store.progress import summarized
from pipeline.store.schema import COLUMNS, FAILED
from pipeline.store.write import Writer
from pipeline.sweep.model import Point
from pipeline.sweep.plan import Task, points, run_points, tasks
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

    cluster, status = None, "running"

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
    """A task that has ended, with the other attributes of Dask's futures."""

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
        noted = ", ".join(f"{name} {other[name]}" for name in ("python", "numpy", "scipy"))
        assert f"some points computed by workers with {noted}" in ds.attrs["history"]


class Forgetful(LocalClient):
    """A client whose workers have lost their results at the first requests."""

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
    """A client whose workers die at each request, without an answer."""

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


def test_the_pace_is_learned_from_each_point_but_the_first_of_a_worker(tmp_path, monkeypatch):
    monkeypatch.setattr(schedule, "_POLL", 0.01)
    learned, counted = [], []
    tally = SimpleNamespace(learn=learned.extend, count=counted.extend)
    with writing(tmp_path / "out.zarr", SWEEP) as store, Writer(store) as writer:
        link = Connection(LocalClient(), 1.0, silent)
        compute(link, SWEEP, writer, tasks(points(SWEEP), SWEEP), tally)
        assert len(counted) == 12  # all, before the writer ends
    assert len(learned) == 11
    assert {record.point for record in counted} == set(points(SWEEP))


class Lost(LocalClient):
    """A client whose tasks end in this way, and whose scheduler is gone."""

    status = "closed"

    def __init__(self, status, error):
        super().__init__()
        self._status, self._error = status, error

    def submit(self, *arguments, key, **_):
        ended = Ended()
        ended.key, ended.status = key, self._status
        ended.set_exception(self._error)
        return ended


@pytest.mark.parametrize(
    ("status", "error", "words"),
    [
        ("cancelled", CancelledError(), "the Dask scheduler is lost; finished points are safe"),
        ("error", CancelledError(), "the Dask scheduler is lost"),
        ("error", ExecutionError("a worker cannot take the scene"), "a worker cannot take the"),
    ],
)
def test_a_lost_scheduler_or_a_worker_without_the_scene_ends_a_sweep(
    compute_sweep, status, error, words
):
    with pytest.raises(ExecutionError, match=words):
        compute_sweep(client=Lost(status, error))


class Breaking(LocalClient):
    """A client whose workers lose one point, for a reason that Dask gives."""

    def submit(self, function, name, run, points, **options):
        if points[0] != Point(250.0, 1.5):
            return super().submit(function, name, run, points, **options)
        return Lost("error", OSError("the result is too large")).submit(**options)


def test_a_point_whose_result_is_lost_each_time_fails_with_the_reason(compute_sweep):
    store, ended = compute_sweep(client=Breaking())
    assert ended == {"done": 11, "failed": 1}
    (failed,) = summarized(store).failed
    assert failed.message == "OSError: the result is too large"


# Steps of a run, at times that are given


class Stage(Connection):
    """What a run acts on: a connection with its clock, a writer, and requests to workers.

    Its workers have three threads each; all but a new one have what is to be computed.
    """

    def __init__(self, *workers):
        super().__init__(self, progress=lambda progress: self.said.append(progress.words))
        self.there, self.said, self.cancelled, self.written = workers, [], [], []
        self.placed, self.priorities, self.cancel = [], [], self.cancelled.extend
        self.now, self.asked = 0.0, []

    def clock(self):
        return self.now

    def nthreads(self, **_):
        return dict.fromkeys(self.there, 3)

    def submit(self, function, name, label, points, workers, allow_other_workers, **options):
        self.placed.append((workers, points, not allow_other_workers))
        self.priorities.append(options["priority"])
        future = Ended()
        future.key = options["key"]
        return future

    def run(self, waiting=()):
        writer = SimpleNamespace(add=self.written.extend)
        reports = SimpleNamespace(
            knows=lambda worker: worker != "new",
            wake=None,
            ask=lambda workers, keys: self.asked.append((self.now, keys)),
            answers=lambda: (),
            computes=lambda workers: False,
        )
        run = _Run(self, "label", writer, reports, None, waiting)
        run._workers = Counter(self.nthreads())
        return run


def test_each_worker_gets_a_task_before_any_gets_the_one_that_waits_for_it():
    stage = Stage("a", "new", "b")
    run = stage.run(tasks(points(SWEEP), SWEEP))
    run.submit()
    assert [worker for worker, *_ in stage.placed] == ["a", "b", "a", "b"]
    assert not any(is_alone for *_, is_alone in stage.placed)
    assert stage.priorities == sorted(stage.priorities, reverse=True)  # in this order
    run.submit()
    assert len(stage.placed) == 4


def test_threads_that_have_nothing_to_do_are_told_once():
    stage = Stage("a", "b")
    run = stage.run()
    run._tell_idle()
    run._tell_idle()
    (line,) = stage.said
    assert line.startswith("4 of 6 threads of the Dask workers stand idle, since each process")
    busy = Stage("a")
    busy.nthreads = lambda **_: {"a": 1}
    busy.run()._tell_idle()
    assert busy.said == []


def test_suspects_are_tried_alone_once_nothing_else_runs_those_that_were_lost_least_first():
    stage = Stage("a", "new", "b", "c")
    run = stage.run()
    often, once, tried, never = points(SWEEP)[:4]
    run._losses = {often: 3, once: 1, tried: 0, never: 0}
    run.running = [running("key", "c", point=tried)]
    run.submit()
    assert stage.placed == []  # what is not alone may die with them
    run.running = [running("key", "c", is_alone=True, point=tried)]
    run.submit()
    assert [points for _, points, _ in stage.placed] == [(never,), (once,)]
    assert {(worker, is_alone) for worker, _, is_alone in stage.placed} == {
        ("a", True),
        ("b", True),
    }
    waits = Stage("a")
    run = waits.run(tasks([often], SWEEP))
    run._losses = {once: 0}
    run.submit()
    assert [points for _, points, _ in waits.placed] == [(often,)]


PLACE = points(SWEEP)[0]


def running(key, worker, is_alone=False, begun=None, point=PLACE):
    future = Ended()
    future.key = key
    return _Running(Task((point,), (point.velocity,)), future, worker, is_alone, begun or {})


def test_a_task_has_the_times_when_each_worker_was_seen_at_it_first_and_last():
    stage = Stage("w")
    run = stage.run()
    run.running = [task, other] = [running("a", "w"), running("b", "w")]
    for now, key in ((5.0, "a"), (9.0, "a"), (11.0, "b"), (14.0, None)):
        run._take("w", WorkerReport(work.versions(), key, {}), now)
    run._take("x", WorkerReport(work.versions(), "a", {}), 20.0)
    assert task.begun == {"w": (5.0, 9.0), "x": (20.0, 20.0)}
    assert other.begun == {"w": (11.0, 11.0)}


def test_a_task_is_given_up_after_three_workers_have_left_it_and_says_how_long_each_had_it():
    stage = Stage("w")
    run = stage.run()
    begun = {"a": (100.0, 110.0), "b": (200.0, 320.0), "c": (400.0, 401.0)}
    task = running("key", "c", begun=begun)
    run._workers = Counter({"c": 1, "d": 1})
    assert not run._is_given_up(task)
    assert stage.written == stage.cancelled == []
    run._workers = Counter({"d": 1})
    assert run._is_given_up(task)
    (record,) = stage.written
    assert record.message == (
        "begun on 3 workers, and each left before it was done, after 10 s, 2 min, 1 s: let workers "
        "live longer, or take a coarser fidelity"
    )
    assert stage.cancelled == [task.future]


def test_a_point_that_is_tried_alone_is_lost_with_its_worker_and_fails_at_the_fifth_time():
    stage = Stage("w")
    run = stage.run()
    run._workers = Counter({"w": 1})
    assert not run._is_given_up(running("key", "w", is_alone=True))
    for lost in range(1, 6):
        assert run._is_given_up(running("key", "gone", is_alone=True))
        assert len(stage.written) == (lost == 5)
    assert stage.written[0].message.startswith("each worker process that computed it died, also")
    assert not run.is_under_way()


def test_a_task_whose_worker_is_gone_goes_to_another_and_its_points_are_suspected_at_the_fifth():
    stage = Stage("w")
    run = stage.run()
    task = running("key", "gone")
    for lost in range(1, 6):
        run._hand_out_again(task)
        assert len(stage.cancelled) == lost
        if lost < 5:
            assert run._waiting.take("w") is task.task
    assert not run._waiting
    assert run.is_under_way()  # it is to be tried alone
    run._hand_out_again(running("key", "gone", is_alone=True))
    assert len(stage.cancelled) == 5  # nothing: it is suspected as it is


@pytest.mark.parametrize(
    ("worker", "status", "is_back"),
    [("w", "pending", False), ("gone", "finished", False), ("gone", "pending", True)],
)
def test_a_result_that_has_gone_with_its_worker_is_computed_again(worker, status, is_back):
    stage = Stage("w")
    run, task = stage.run(), running("key", worker)
    task.future.status = status
    run.computed = {"key": task}
    run.look()
    assert run.computed == ({} if is_back else {"key": task})
    assert bool(run._waiting) == is_back


@pytest.mark.parametrize(
    ("worker", "is_alone", "state"),
    [
        ("w", False, (True, False, {})),
        ("w", True, (True, False, {})),
        ("gone", False, (False, True, {})),
        ("gone", True, (False, False, {PLACE: 1})),
    ],
)
def test_a_task_goes_on_with_its_worker_and_without_goes_to_another_or_is_lost(
    worker, is_alone, state
):
    run = Stage("w").run()
    run.running = [running("key", worker, is_alone)]
    assert not run.look()
    assert (bool(run.running), bool(run._waiting), run._losses) == state


def test_workers_are_asked_once_a_second_sooner_in_the_beginning_and_at_once_in_the_end():
    stage = Stage("w")
    stage.now = 100.0
    run, done = stage.run(), running("done", "w")
    run.running = [running("key", "w")]
    for stage.now in (100.0, 100.5, 100.54, 100.56, 120.0, 120.9, 121.0, 121.1):
        run.look()
    done.future.status = "finished"
    run.computed = {"done": done}
    stage.now = 121.2  # while another runs
    run.look()
    run.running = []
    done.future.status = "pending"
    stage.now = 121.3
    run.look()
    done.future.status = "finished"
    stage.now = 121.4
    run.look()
    usual = [(now, []) for now in (100.0, 100.5, 100.56, 120.0, 121.0)]
    assert stage.asked == [*usual, (121.4, ["done"])]
