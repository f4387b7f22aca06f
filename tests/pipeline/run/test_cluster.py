"""Local and remote clusters that lose workers, stop or die, and the messages of a run."""

import itertools
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import dask
import numpy as np
import psutil
import pytest
import xarray as xr
from distributed import Client, LocalCluster, SchedulerPlugin, Security
from distributed.scheduler import KilledWorker
from distributed.utils import CancelledError

from pipeline import ExecutionError, run_point, run_sweep, summary, verify_store
from pipeline.run import cluster as cluster_module
from pipeline.run import drive, work
from pipeline.run.cluster import CONFIGURATION, ENVIRONMENT, Watch, client_of, connected
from pipeline.run.work import PROGRAM, _hash_of_code
from tests.helpers import tiny
from tests.helpers.kept import refusal
from tests.helpers.reported import Heard
from tests.helpers.scenes import SCENE
from tests.pipeline.run.test_sweep import content

OWN_WORKERS = True
ROOT = Path(__file__).parents[3]
SWEEP = tiny.full()
SHORT = tiny.sweep(velocities=(1.0,))
SLOW = tiny.full(loading=tiny.SlowRamp(150.0, 750.0))
MANY = tiny.sweep(velocities=tuple(0.5 + 0.01 * number for number in range(60)))
SAVED = "finished points are saved; run the sweep again to continue$"
LOST = f"^the connection to the Dask scheduler is lost; {SAVED}"
INSTALL = f"install the same version on both sides and restart the workers; {SAVED}"
DEADLY = (
    "3 workers died with this point, the last one with no other; if the memory of a worker was too "
    "small, use fewer workers, or reduce window.pixels"
)


@contextmanager
def local_cluster(count, threads=1, **settings):
    """Cluster of workers, by default in this process, and its client, as a user starts them."""
    settings = {"processes": False, "dashboard_address": "127.0.0.1:0"} | settings
    with (
        LocalCluster(n_workers=count, threads_per_worker=threads, **settings) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield cluster, client


def when_done(act):
    """Progress function that calls `act` as soon as a point is done."""

    def report(progress):
        if progress.done:
            act()

    return report


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """Scheduler and worker started by Dask's commands, and the configuration to reach them."""
    security, tls = Security.temporary(), "distributed.comm.tls"
    folder = tmp_path_factory.mktemp("elsewhere")
    for file in ("ca_file", "client_cert", "client_key"):
        (folder / file).write_text(getattr(security, f"tls_{file}"))
    configured = {f"{tls}.ca-file": f"{folder}/ca_file"}
    for role in ("client", "scheduler", "worker"):
        configured[f"{tls}.{role}.cert"] = f"{folder}/client_cert"
        configured[f"{tls}.{role}.key"] = f"{folder}/client_key"
    variables = {
        f"DASK_{key}".replace(".", "__").replace("-", "_").upper(): file
        for key, file in configured.items()
    }
    variables |= os.environ | {"PYTHONPATH": os.fspath(ROOT)}
    file, words = folder / "scheduler.json", folder / "words.txt"
    usual = f"--scheduler-file={file}", "--host=127.0.0.1", "--dashboard-address=127.0.0.1:0"

    def start(role, *options):
        command = [sys.executable, "-m", f"distributed.cli.dask_{role}", *usual, *options]
        with words.open("a") as out:
            process = subprocess.Popen(command, env=variables, cwd=ROOT, stdout=out, stderr=out)
        stack.callback(process.wait)
        stack.callback(process.kill)
        return process

    with ExitStack() as stack:
        scheduler = start("scheduler", "--port=0", "--protocol=tls")
        # Several threads of a worker may not compute at the same time.
        start("worker", "--protocol=tls", "--no-nanny", "--nthreads=3")
        end = time.monotonic() + 120.0
        while not file.exists() or not file.read_text():
            assert scheduler.poll() is None, words.read_text()
            assert time.monotonic() < end, "the scheduler does not start"
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        remote = SimpleNamespace(scheduler=scheduler, address=address, file=file)
        yield remote, configured


@pytest.mark.timeout(300)
def test_a_cluster_elsewhere_sees_no_store_and_computes_the_same(
    elsewhere, tmp_path, tiny_store, irg
):
    cluster, configured = elsewhere
    with pytest.raises(ExecutionError, match=r"no Dask scheduler answers at"):
        client_of(cluster.address)
    (hidden := tmp_path / "hidden").mkdir(mode=0o700)
    with dask.config.set(configured):
        with client_of(cluster.address) as client:
            outcome = run_sweep(SWEEP, hidden / "tiny.zarr", client=client)
        assert (outcome.done, outcome.failed) == (9, ())
        assert content(hidden / "tiny.zarr") == content(tiny_store)

        (tmp_path / "small.toml").write_text(SCENE)
        point = '--set=sweep.loads=["200 N"]', '--set=sweep.velocities=["1 m/s"]'
        run = "run", tmp_path / "small.toml", *point, "-o", hidden / "small.zarr"
        run = (*run, "--scheduler-file")
        irg(*run, cluster.file)
        assert "no Dask scheduler answers at" in irg(*run, tmp_path / "missing.json", code=2)


def test_a_hash_of_the_code_tells_a_changed_line(tmp_path):
    for package in "tribo", "pipeline":
        shutil.copytree(ROOT / package, tmp_path / package)
    assert _hash_of_code(tmp_path) == PROGRAM.code
    hashes = {PROGRAM.code}
    for file in "tribo/thermal/factors.py", "pipeline/sweep/plan.py", "pipeline/run/work.py":
        with (tmp_path / file).open("a") as code:
            code.write("# changed\n")
        hashes.add(_hash_of_code(tmp_path))
    assert len(hashes) == 4


def test_a_worker_with_other_libraries_is_told_once_with_both_versions():
    watch = Watch(None, 1.0, (messages := Heard()).hear)
    for _ in range(2):
        watch.require_program(PROGRAM._replace(versions="NumPy 9"))
    words = f"a Dask worker computes with NumPy 9 instead of {PROGRAM.versions}"
    assert messages == [f"{words}; last digits may differ"]


@pytest.mark.timeout(300)
def test_a_cluster_with_other_code_or_none_is_refused_and_computes_nothing(elsewhere, tmp_path):
    cluster, configured = elsewhere
    missing_module = r"this program: .*pipeline\.run\.work"
    with dask.config.set(configured), client_of(cluster.address) as client:
        client.wait_for_workers(1)
        client.run(lambda: setattr(work, "PROGRAM", work.PROGRAM._replace(code="theirs")))
        words = (
            r"^tls://127\S+ has another version of tribo and pipeline \(hash theirs\) than this "
            rf"program \({PROGRAM.code}\); {INSTALL}"
        )
        with pytest.raises(ExecutionError, match=words):
            run_sweep(SHORT, tmp_path / "out.zarr", client=client)
        for ask, who in (
            (client.run, "a Dask worker cannot run"),
            (client.run_on_scheduler, "the Dask scheduler cannot read tasks of"),
        ):
            ask(lambda: sys.modules.update({"pipeline.run.work": None}))
            with pytest.raises(ExecutionError, match=f"^{who} {missing_module}.*; {INSTALL}"):
                run_sweep(SHORT, tmp_path / "out.zarr", client=client)
            ask(lambda: sys.modules.pop("pipeline.run.work"))
    assert summary(tmp_path / "out.zarr").done == 0


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "how", [pytest.param(signal.SIGSTOP, marks=pytest.mark.slow), signal.SIGKILL]
)
def test_a_scheduler_that_stops_or_dies_is_lost_and_its_finished_points_are_not(
    elsewhere, tmp_path, how
):
    cluster, configured = elsewhere
    path = tmp_path / "out.zarr"
    lose = when_done(lambda: cluster.scheduler.send_signal(how))
    lost = pytest.raises(ExecutionError, match=LOST)
    with dask.config.set(configured), client_of(cluster.address) as client, lost:
        run_sweep(SLOW, path, client=client, progress=lose, patience=5.0)
    assert summary(path).done
    cluster.scheduler.send_signal(signal.SIGCONT)


class Stop(SchedulerPlugin):
    """Scheduler plugin that suspends a worker that has a result not fetched yet."""

    name = "stop"

    def __init__(self, address, process):
        self.address, self.process = address, process

    def transition(self, key, start, finish, *_, worker=None, **__):
        if finish == "memory" and worker == self.address:
            self.address = None
            self.process.suspend()


@pytest.fixture(scope="module")
def link():
    """Client of a cluster of two workers, as a run starts them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("OMP_NUM_THREADS", "7")
        patch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)
        with connected(None, 2) as link:
            link.wait_for_workers(2, timeout=120)
            yield link


@pytest.mark.slow
@pytest.mark.timeout(100)
def test_a_worker_that_stands_still_holds_up_no_later_results_of_another(link, tmp_path):
    velocities = tuple(np.linspace(0.5, 1.5, 5).tolist())
    sweep = tiny.full(loading=tiny.SlowRamp(150.0, 750.0), velocities=velocities)
    address, number = next(iter(link.run(os.getpid).items()))
    worker = psutil.Process(number)
    link.cluster.scheduler.add_plugin(Stop(address, worker))

    def go_on(progress):
        if progress.done > 7:
            worker.resume()

    outcome = run_sweep(sweep, tmp_path / "tiny.zarr", client=link, progress=go_on)
    assert outcome.done == 15


class Tasks(SchedulerPlugin):
    """Scheduler plugin that records all tasks and their dependencies."""

    name = "tasks"

    def __init__(self):
        self.below = {}

    def transition(self, key, start, finish, *_, **__):
        if start == "released" and finish == "waiting":
            self.below[key] = [task.key for task in self.scheduler.tasks[key].dependencies]


def test_any_client_computes_the_same_a_task_for_each_point(tmp_path, tiny_store):
    tasks = Tasks()
    with local_cluster(2, threads=3) as (cluster, client):
        cluster.scheduler.add_plugin(tasks)
        tasks.scheduler = cluster.scheduler
        outcome = run_sweep(SWEEP, tmp_path / "out.zarr", client=client)
        dependencies = dict(tasks.below)
        for _ in range(2):  # workers are lost during the run, then missing from its start
            words = rf"^no Dask worker accepts tasks within 1 s \(.+\); {SAVED}"
            with pytest.raises(ExecutionError, match=words):
                run_sweep(
                    MANY,  # too many to be done meanwhile
                    tmp_path / "later.zarr",
                    client=client,
                    progress=when_done(lambda: cluster.scale(0)),
                    patience=1.0,
                )
            assert summary(tmp_path / "later.zarr").done
    assert (outcome.done, outcome.failed) == (9, ())
    assert content(tmp_path / "out.zarr") == content(tiny_store)
    dependencies_by_point = {key.rsplit("-", 2)[0]: below for key, below in dependencies.items()}
    coordinates = itertools.product(SWEEP.loads, SWEEP.velocities)
    assert dependencies_by_point.keys() == {
        f"point-{load:g}N-{velocity:g}ms" for load, velocity in coordinates
    }
    assert sum(map(len, dependencies_by_point.values())) == 0


def test_workers_that_do_not_start_are_one_error(path, monkeypatch):
    def refused(**settings):
        raise AssertionError

    monkeypatch.setattr(cluster_module, "LocalCluster", refused)
    assert refusal(partial(run_sweep, SHORT, path, workers=2)) == (
        "the worker processes did not start: none connected; memory, threads or processes may be "
        "limited (ulimit -a): use fewer workers. In a script, call run_sweep under "
        'if __name__ == "__main__":, because workers import it'
    )


def test_the_dashboard_of_a_local_cluster_is_told_and_answers(tmp_path):
    pytest.importorskip("bokeh")
    answers, before = [], multiprocessing.active_children()

    def look(progress):
        if progress.words:
            answers.append(progress.words)
        if progress.done and len(answers) == 1:
            with urllib.request.urlopen(answers[0].removeprefix("dashboard: ")) as page:
                answers.append(page.status)

    run_sweep(SHORT, tmp_path / "out.zarr", workers=1, progress=look, dashboard=True)
    assert answers[1] == 200
    assert {*multiprocessing.active_children()} <= {*before}


def test_a_cluster_here_talks_to_its_driver_only_with_its_settings(link):
    for began in link.run(lambda: psutil.Process().environ()).values():
        assert ENVIRONMENT.items() <= began.items()
    info = link.scheduler_info(n_workers=-1)
    scheduler, (address, worker) = link.scheduler.address, next(iter(info["workers"].items()))
    for end in (scheduler, address, worker["nanny"]):
        assert end.startswith("tls://127.0.0.1:")
    security = Security.temporary()
    with pytest.raises(OSError, match="certificate does not match"):
        Client(scheduler, security=security, set_as_default=False, timeout=120)
    for services in (info["services"], worker["services"]):
        for page in ("json/identity.json", "api/v1/retire_workers", "metrics"):
            with pytest.raises(urllib.error.HTTPError, match="404"):
                urllib.request.urlopen(f"http://127.0.0.1:{services['dashboard']}/{page}")


class Hungry(tiny.FaultyRamp):
    """A ramp that takes more and more memory at one load, until its process is killed."""

    def fault(self):
        blocks = []
        while True:
            blocks.append(bytearray(2**24))


Hungry.__name__ = "Ramp"
HUNGRY = tiny.sweep(loading=Hungry(150.0, 750.0, faulty_load=250.0), velocities=(0.5,))


def test_a_client_that_is_closed_ends_a_run_with_one_error(path):
    lost = pytest.raises(ExecutionError, match=LOST)
    with local_cluster(2) as (_, client), lost:
        run_sweep(MANY, path, client=client, progress=when_done(client.close), patience=5.0)
    assert 0 < summary(path).done < len(MANY.loads) * 60


def cancel(futures):
    """Fail as if all workers were restarted."""
    raise CancelledError


def lose(futures):
    """Fail as if a worker died before its result is fetched, and the one that computes it again."""
    worker = SimpleNamespace(address="tcp://127.0.0.1:1")
    error = KilledWorker(futures[0].key, worker, 0)
    futures[0]._state.set_error(error, None)
    raise error


@pytest.mark.parametrize("fail", [cancel, lose])
def test_results_whose_fetch_fails_are_computed_again(path, tiny_store, monkeypatch, fail):
    with local_cluster(2) as (_, client):
        gather, first = client._gather, iter([True])

        async def failing_once(futures, **options):
            if next(first, False):
                fail(futures)
            return await gather(futures, **options)

        monkeypatch.setattr(client, "_gather", failing_once)
        outcome = run_sweep(SWEEP, path, client=client)
    assert (outcome.done, outcome.failed, next(first, None)) == (9, (), None)
    assert content(path) == content(tiny_store)


def test_a_point_that_takes_all_memory_fails_alone(path, monkeypatch):
    monkeypatch.setattr(drive, "_MAX_LOSSES", 2)  # three are tried by points that crash
    limit = {"processes": True, "memory_limit": "500 MB"}
    with dask.config.set(CONFIGURATION), local_cluster(1, **limit) as (_, client):
        outcome = run_sweep(HUNGRY, path, client=client)
    (failed,) = outcome.failed
    assert (failed.load, outcome.done) == (250.0, 2)
    assert failed.message == DEADLY


def test_points_that_share_a_worker_with_a_deadly_one_are_done_after_all(path):
    deadly = tiny.DeadlyRamp(150.0, 750.0, faulty_load=250.0)
    outcome = run_sweep(tiny.sweep(loading=deadly, velocities=(1.0,)), path, workers=2)
    (failed,) = outcome.failed
    assert failed.message == DEADLY
    assert (failed.load, outcome.done) == (250.0, 2)
    assert verify_store(path).is_clean
    with xr.open_zarr(path, chunks=None) as ds:
        rises = ds["max_rise"].sel(load=150.0, velocity=1.0).values
    expected = run_point(tiny.sweep(), 150.0, 1.0).columns["max_rise"]
    assert rises[-len(expected) :].tobytes() == expected.tobytes()
