"""Sweeps in jobs of a real Slurm, and stores in a real Ceph object gateway, where there are such.

    python -m tests.cluster                    # all of it, in about fifteen minutes
    python -m tests.cluster losses walltime    # some of it

Jobs are lost in every way, and drivers are killed. Each store is compared, bit for bit, with a run
on this machine. Prints a JSON document.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, suppress
from pathlib import Path

import numpy as np

import pipeline
from pipeline.run.sweep import run_sweep
from pipeline.store.place import StoreError
from pipeline.store.schema import COLUMNS
from tests.cluster import objects
from tests.cluster.daemons import SLURM, missing, slurm
from tests.cluster.gateway import CEPH, gateway
from tests.crash import many
from tests.crash.sweeps import keep_one_thread
from tests.helpers import tiny
from tests.helpers.scenes import SCENE
from tests.pipeline.run.test_sweep import content
from tribo import TriboError

ROOT = Path(__file__).parents[2]
_JOBS = 4
_SHORT = 60.0  # [s] of a walltime, the shortest that Slurm knows
_PATIENCE = 400.0  # [s] for a driver
_CHEAP = 10_000  # points
_BETWEEN = 12.0  # [s] between two jobs that are cancelled
_INTERRUPTED, _REFUSED = 130, 2
DRIVERS = ExitStack()
"""Those that are killed in the end, if they go on."""


def sweep_of(velocities):
    """Points of a few tenths of a second, in which a worker mostly sleeps."""
    return tiny.full(
        loading=tiny.SlowRamp(150.0, 750.0), velocities=tuple(np.linspace(0.5, 1.5, velocities))
    )


def drive(path, velocities, walltime, is_cheap):
    """Run or resume a sweep in jobs; write what was told and what came of it beside it."""
    messages, counts = [], []
    outcome = run_sweep(
        many.sweep_of(many.LOADS * velocities) if is_cheap else sweep_of(velocities),
        path,
        cluster=pipeline.Batch("slurm", _JOBS, walltime, pipeline.Site(interface="lo")),
        progress=lambda now: counts.append((now.elapsed, now.done, now.time_to_go, now.jobs)),
        tell=messages.append,
    )
    document = {"done": outcome.done, "failed": list(map(str, outcome.failed))}
    path.with_suffix(".json").write_text(
        json.dumps({**document, "told": messages, "progress": counts[:: max(1, len(counts) // 20)]})
    )


class Driver:
    """A driver in a process of its own."""

    def __init__(self, path, velocities, walltime=7200.0, is_cheap=False):
        self.path = path
        options = ["--drive", path, "--velocities", str(velocities), "--walltime", str(walltime)]
        options += ["--cheap"] * is_cheap
        self._err = path.with_suffix(".err").open("a")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.cluster", *options],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stderr=self._err,
            start_new_session=True,
        )
        DRIVERS.callback(self.process.kill)

    def wait_for(self, points):
        """Wait until so many points are done."""
        end = time.monotonic() + _PATIENCE
        while self.done() < points:
            assert self.process.poll() is None, self.path.with_suffix(".err").read_text()
            assert time.monotonic() < end, f"{points} points take longer than {_PATIENCE:g} s"
            time.sleep(1.0)

    def done(self):
        """Points that are done."""
        with suppress(StoreError):  # until it is made
            return pipeline.summary(self.path).done
        return 0

    def result(self):
        assert self.process.wait(_PATIENCE) == 0, self.path.with_suffix(".err").read_text()
        return json.loads(self.path.with_suffix(".json").read_text())


def faults_of(path, velocities, result, expected, with_logs=True):
    """Faults of a run in jobs."""
    if result["failed"] or result["done"] != 3 * velocities:
        yield f"{result['done']} points are done; failed: {result['failed']}"
    if velocities not in expected:
        alone = path.with_name(f"alone-{velocities}.zarr")
        run_sweep(sweep_of(velocities), alone, workers=2)
        expected[velocities] = content(alone)
    if content(path) != expected[velocities]:
        yield f"{path.name} differs from a run on this machine"
    if (errors := path.with_suffix(".err").read_text()).strip():
        yield f"a driver says: {errors}"
    for log in path.with_name(f"{path.name}.jobs").glob("*.err"):
        if "TIME LIMIT" in log.read_text() or (with_logs and "Traceback" in log.read_text()):
            yield f"{log.name}: {log.read_text()[-1000:]}"


def losses(batch, folder, expected):
    """Jobs cancelled, a node drained, the controller restarted."""
    driver = Driver(folder / "losses.zarr", 80)
    driver.wait_for(10)
    first = batch.jobs("running")
    batch.ask("scancel", first[0])
    driver.wait_for(60)
    batch.restart_controller(pause=20.0)
    driver.wait_for(90)
    batch.ask("scontrol", "update", "nodename=n1", "state=drain", "reason=trial")
    batch.ask("scancel", *batch.jobs("running"))
    result = driver.result()
    batch.ask("scontrol", "update", "nodename=n1", "state=resume")
    yield result
    yield from faults_of(driver.path, 80, result, expected)


def walltime(batch, folder, expected):
    """A sweep that outlives its jobs more than once."""
    driver = Driver(folder / "walltime.zarr", 200, _SHORT)
    result = driver.result()
    logs = list(folder.glob("walltime.zarr.jobs/*.err"))
    yield {**result, "jobs": len(logs)}
    if len(logs) <= _JOBS:
        yield f"{len(logs)} jobs have run, and more were needed"
    # Dask logs a closed pool of connections where a worker retires.
    yield from faults_of(driver.path, 200, result, expected, with_logs=False)


def killed(batch, folder, expected):
    """A driver that is killed: its jobs end by themselves, and a second one goes on."""
    driver = Driver(folder / "killed.zarr", 80)
    driver.wait_for(30)
    driver.process.kill()
    driver.process.wait()
    began = time.monotonic()
    while batch.jobs() and time.monotonic() - began < 150.0:
        time.sleep(1.0)
    took, left = time.monotonic() - began, batch.jobs()
    before = pipeline.summary(driver.path).done
    result = Driver(driver.path, 80).result()
    yield {**result, "done_before": before, "jobs_ended_after": round(took, 1)}
    if left or before < 30:
        yield f"jobs of a killed driver go on: {left}; {before} points were done"
    yield from faults_of(driver.path, 80, result, expected, with_logs=False)


def crowd(batch, folder, expected):
    """Ten thousand cheap points, while jobs are lost every few seconds and the driver is once."""
    path, velocities, lost = folder / "crowd.zarr", _CHEAP // many.LOADS, 0
    driver, generator, half = Driver(path, velocities, is_cheap=True), random.Random(0), 0
    while driver.process.poll() is None:
        time.sleep(_BETWEEN)
        if not half and driver.done() > _CHEAP / 2:
            driver.process.kill()
            driver.process.wait()
            half, driver = driver.done(), Driver(path, velocities, is_cheap=True)
        elif driver.done() and (jobs := batch.jobs("running")):
            batch.ask("scancel", generator.choice(jobs))
            lost += 1
    result = driver.result()
    yield {**result, "jobs_lost": lost, "done_before": half}
    alone = folder / "alone-crowd.zarr"
    run_sweep(many.sweep_of(_CHEAP), alone, workers=2)
    names = (*COLUMNS, "message", "checksum", "status")
    if result["done"] != _CHEAP or content(path, names) != content(alone, names):
        yield f"{result['done']} points are done, failed: {result['failed']}; or they differ"
    if not (half and lost):
        yield f"{lost} jobs were lost, and the driver at {half} points: too few to tell"
    again = Driver(path, velocities, is_cheap=True).result()
    if again["done"] != _CHEAP or batch.jobs("running"):
        yield f"a run with nothing to do: {again}, jobs {batch.jobs('running')}"


def command(folder, *options, wait=True, site='interface = "lo"\n'):
    """``irg run`` of a small scene in jobs: its exit code and words."""
    (folder / "small.toml").write_text(SCENE)
    (folder / "site.toml").write_text(site)
    program = "import sys, pipeline.cli; sys.exit(pipeline.cli.main())"
    run = ["run", "small.toml", "--cluster", "slurm", "--site", "site.toml", *options]
    irg = subprocess.Popen(
        [sys.executable, "-c", program, *run],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    if not wait:
        return irg
    out, err = irg.communicate(timeout=_PATIENCE)
    return irg.returncode, out, err


def commands(batch, folder, expected):
    """The command: done, interrupted while it waits, refused, and without its package."""
    report = {}
    for name, site, options, code, words in (
        ("done", "cores = 2\n", ["--jobs", "2"], 0, "9 of 9 points done"),
        ("refused", 'queue = "none"\n', [], _REFUSED, "invalid partition"),
        ("unready", 'python = "/usr/bin/python3"\n', [], _REFUSED, "No module named"),
        ("prologue", 'prologue = ["exit 3"]\n', [], _REFUSED, "it left no word"),
    ):
        exit_code, out, err = command(
            folder, "-o", f"{name}.zarr", *options, site=f'interface = "lo"\n{site}'
        )
        report[name] = err
        if exit_code != code or words not in out + err or "Traceback" in err:
            yield f"{name}: ends with {exit_code}: {out}{err}"
    irg = command(folder, "-o", "interrupted.zarr", "--jobs", "30", wait=False)
    time.sleep(6.0)
    os.killpg(irg.pid, signal.SIGINT)
    _, report["interrupted"] = irg.communicate(timeout=_PATIENCE)
    if irg.returncode != _INTERRUPTED or "Traceback" in report["interrupted"]:
        yield f"interrupted: ends with {irg.returncode}: {report['interrupted']}"
    if left := batch.jobs("running,pending"):
        yield f"interrupted: jobs go on: {left}"
    yield report


TRIALS = {trial.__name__: trial for trial in (commands, losses, walltime, killed, crowd)}


def tried(trials, server, folder, expected, document):
    """Make trials, and note in the document what came of each."""
    for trial in trials:
        began, results = time.monotonic(), []
        try:
            results += trial(server, folder, expected)
        except (AssertionError, OSError, TriboError, subprocess.SubprocessError) as error:
            results += [{}, f"{type(error).__name__}: {error}"]
        took = {"took": round(time.monotonic() - began, 1)}
        reports = [report for report in results if isinstance(report, dict)]
        faults = [fault for fault in results if isinstance(fault, str)]
        document[trial.__name__] = {**took, **reports[0], "faults": faults}
        print(trial.__name__, took, faults, file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    names = ", ".join((*TRIALS, *objects.TRIALS))
    parser.add_argument("trials", nargs="*", metavar="TRIAL", help=names)
    for option, kind in (("--drive", Path), ("--velocities", int), ("--walltime", float)):
        parser.add_argument(option, type=kind, help=argparse.SUPPRESS)
    parser.add_argument("--cheap", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    keep_one_thread()
    if options.drive:
        drive(options.drive, options.velocities, options.walltime, options.cheap)
        return 0
    document, expected = {}, {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for server, trials, programs, packages in (
            (slurm, TRIALS, SLURM, "slurm-wlm munge"),
            (gateway, objects.TRIALS, CEPH, "radosgw ceph-mon ceph-osd ceph-common"),
        ):
            asked = [trials[name] for name in options.trials or trials if name in trials]
            if absent := missing(programs):
                said = f"there is no {', '.join(absent)}: apt-get install {packages}"
                print(f"not tried with a {server.__name__}, since {said}", file=sys.stderr)
            elif asked:
                (folder / server.__name__).mkdir()
                with server(folder / server.__name__) as running, DRIVERS:
                    tried(asked, running, folder, expected, document)
    print(json.dumps(document, indent=1))
    return 1 if any(report["faults"] for report in document.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
