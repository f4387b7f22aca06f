"""Drivers of sweeps: clusters that change, workers that die, and what the user is told."""

import sys

import dask
import pytest
from distributed import Client, LocalCluster

import pipeline
from pipeline.run.cluster import CONFIGURATION
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.pipeline.run.test_cluster import when_done
from tests.pipeline.run.test_sweep import content

OWN_WORKERS = True
SWEEP = tiny.full()
MANY = tiny.sweep(velocities=tuple(0.5 + 0.01 * number for number in range(60)))


class Hungry(tiny.FaultyRamp):
    """A ramp that takes more and more memory at one load, until its process is killed."""

    def fault(self):
        held = []
        while True:
            held.append(bytearray(2**24))


Hungry.__name__ = "Ramp"
HUNGRY = tiny.sweep(loading=Hungry(150.0, 750.0, faulty_load=250.0), velocities=(0.5,))


@pytest.fixture
def threads():
    """A cluster of two workers in this process, and its client."""
    dashboard = {"dashboard_address": "127.0.0.1:0"}
    with (
        LocalCluster(n_workers=2, processes=False, threads_per_worker=1, **dashboard) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield cluster, client


@pytest.fixture
def processes():
    """Function that starts workers with a memory limit [B] and returns their client."""
    clusters = []

    def start(workers, memory):
        clusters.append(
            LocalCluster(None, workers, 1, memory_limit=memory, dashboard_address="127.0.0.1:0")
        )
        clusters.append(Client(clusters[-1], set_as_default=False))
        return clusters[-1]

    with dask.config.set(CONFIGURATION):
        yield start
        for one in reversed(clusters):
            one.close()


def test_tasks_are_there_before_workers_so_that_an_adaptive_cluster_starts_them(
    threads, path, alone
):
    cluster, client = threads
    cluster.scale(0)
    cluster.adapt(minimum=0, maximum=2, interval="50ms")
    outcome = pipeline.run_sweep(SWEEP, path, client=client, patience=60.0)
    assert (outcome.done, outcome.failed) == (9, ())
    assert content(path) == content(alone)


def test_a_client_that_is_closed_ends_a_run_with_one_error(threads, path):
    client, lost = threads[1], "scheduler is lost; finished points are"
    with pytest.raises(pipeline.ExecutionError, match=lost):
        pipeline.run_sweep(
            MANY, path, client=client, progress=when_done(client.close), patience=5.0
        )
    assert 0 < pipeline.summary(path).done < len(MANY.loads) * 60


def test_a_run_goes_on_with_a_scheduler_that_was_started_again(path):
    def start(port):
        settings = {"protocol": "tcp://", "dashboard_address": "127.0.0.1:0"}
        return LocalCluster(None, 1, 1, processes=False, scheduler_port=port, **settings)

    began = start(0)
    port = int(began.scheduler_address.rpartition(":")[2])
    others = []

    def restart():
        if not others:
            began.close()
            others.append(start(port))

    sweep = changed(MANY, loads=(150.0,))
    with Client(began.scheduler_address, set_as_default=False) as client:
        outcome = pipeline.run_sweep(
            sweep, path, client=client, progress=when_done(restart), patience=60.0
        )
    others[0].close()
    assert (outcome.done, outcome.computed, outcome.failed) == (60, 60, ())


def test_a_run_goes_on_after_its_workers_were_restarted(processes, path, alone):
    client, restarts = processes(2, "auto"), iter([True])

    def restart():
        if next(restarts, False):
            client.restart()

    outcome = pipeline.run_sweep(SWEEP, path, client=client, progress=when_done(restart))
    assert (outcome.done, outcome.failed) == (9, ())
    assert content(path) == content(alone)


def test_a_point_that_takes_all_memory_fails_alone(processes, path):
    outcome = pipeline.run_sweep(HUNGRY, path, client=processes(1, "500 MB"))
    (failed,) = outcome.failed
    assert (failed.load, outcome.done) == (250.0, 2)
    assert "its worker reached its memory limit" in failed.message


def test_a_worker_without_this_program_is_named(processes, path):
    client = processes(1, "auto")
    client.run(lambda: sys.modules.update({"pipeline.run.work": None}))
    with pytest.raises(
        pipeline.ExecutionError,
        match=r"a Dask worker cannot run this program: .*pipeline\.run\.work",
    ):
        pipeline.run_sweep(SWEEP, path, client=client)
