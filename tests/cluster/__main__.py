"""The recipe for a cluster on a real Slurm.

    python -m tests.cluster                    # all of it, where Slurm is installed
    python -m tests.cluster losses walltime    # some of it

Jobs are lost in every way, and drivers are killed. Each store is compared, bit for bit, with a run
on this machine. Prints a JSON document.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, closing, suppress
from pathlib import Path

import numpy as np

import pipeline
from pipeline import StoreError, run_sweep
from pipeline.store.schema import COLUMNS
from tests.cluster.daemons import Slurm, missing_programs
from tests.helpers.campaigns import conclude
from tests.pipeline.run.test_sweep import content
from tribo import TriboError

ROOT = Path(__file__).parents[2]
_RECIPE = ROOT / "workflows" / "on_a_cluster.py"
_SCENE = """\
extends = "first_try"
[sweep]
velocities = {velocities}
"""
_LOADS = 4
_JOBS = 4
_PATIENCE = 900.0  # [s] that a driver may take
_NAMES = (*COLUMNS, "message", "status")
DRIVERS = ExitStack()
"""Those that are killed in the end, if they go on."""


def scene_of(folder, velocities):
    """Write a scene file with four loads and this number of velocities; return its path."""
    file = folder / f"{velocities}.toml"
    values = [f"{velocity:.6g} m/s" for velocity in np.linspace(1.0, 4.0, velocities)]
    file.write_text(_SCENE.format(velocities=values))
    return file


class Driver:
    """A process that runs the recipe ``on_a_cluster.py``."""

    def __init__(self, path, velocities, walltime="2 h"):
        self.path = path
        scene = scene_of(path.parent, velocities)
        options = ["--jobs", str(_JOBS), "--walltime", walltime]
        with path.with_suffix(".err").open("a") as err:
            self.process = subprocess.Popen(
                [sys.executable, _RECIPE, scene, path, *options],
                cwd=path.parent,
                env={
                    **os.environ,
                    "PYTHONPATH": str(ROOT),
                    "DASK_JOBQUEUE__SLURM__INTERFACE": "lo",
                },
                stdout=err,
                stderr=err,
                start_new_session=True,
            )
        DRIVERS.callback(self.process.kill)

    def wait_for(self, points):
        """Wait until this number of points is done."""
        end = time.monotonic() + _PATIENCE
        while self.done() < points:
            assert self.process.poll() is None, self.path.with_suffix(".err").read_text()
            assert time.monotonic() < end, f"{points} points take longer than {_PATIENCE:g} s"
            time.sleep(1.0)

    def done(self):
        """Number of points that are done."""
        with suppress(StoreError):  # the store may not exist yet
            return pipeline.summary(self.path).done
        return 0

    def ended(self):
        """Wait for the end of the driver; raise an error with its output if it failed."""
        assert self.process.wait(_PATIENCE) == 0, self.path.with_suffix(".err").read_text()


def faults_of(path, velocities, expected):
    """Yield faults of a store computed in jobs; it is compared with a run on this machine."""
    state = pipeline.summary(path)
    if state.failed or state.done != _LOADS * velocities:
        yield f"{state.done} points are done; failed: {state.failed}"
    if velocities not in expected:
        local_path = path.with_name(f"alone-{velocities}.zarr")
        run_sweep(scene_of(path.parent, velocities), local_path, workers=2)
        expected[velocities] = content(local_path, _NAMES)
    if content(path, _NAMES) != expected[velocities]:
        yield f"{path.name} differs from a run on this machine"


def losses(batch, folder, expected):
    """Trial: cancel jobs, drain a node and restart the controller during a sweep."""
    driver = Driver(folder / "losses.zarr", 60)
    driver.wait_for(10)
    batch.ask("scancel", batch.jobs("running")[0])
    driver.wait_for(60)
    batch.restart_controller(pause=20.0)
    driver.wait_for(90)
    batch.ask("scontrol", "update", "nodename=n1", "state=drain", "reason=trial")
    batch.ask("scancel", *batch.jobs("running"))
    driver.ended()
    batch.ask("scontrol", "update", "nodename=n1", "state=resume")
    yield {"jobs": len(list(folder.glob("losses.zarr.jobs/*.err")))}
    yield from faults_of(driver.path, 60, expected)


def walltime(batch, folder, expected):
    """Trial: a sweep takes longer than the time limit of its jobs, several times."""
    driver = Driver(folder / "walltime.zarr", 300, "1 min")
    driver.ended()
    logs = list(folder.glob("walltime.zarr.jobs/*.err"))
    yield {"jobs": len(logs)}
    if len(logs) <= _JOBS:
        yield f"{len(logs)} jobs have run, and more were needed"
    yield from (f"{log.name}: over its time" for log in logs if "TIME LIMIT" in log.read_text())
    yield from faults_of(driver.path, 300, expected)


def killed(batch, folder, expected):
    """Trial: kill the driver; its jobs end by themselves, and a second driver goes on."""
    driver = Driver(folder / "killed.zarr", 60)
    driver.wait_for(30)
    driver.process.kill()
    driver.process.wait()
    began = time.monotonic()
    while batch.jobs() and time.monotonic() - began < 180.0:
        time.sleep(1.0)
    took, left = time.monotonic() - began, batch.jobs()
    before = pipeline.summary(driver.path).done
    Driver(driver.path, 60).ended()
    yield {"done_before": before, "jobs_ended_after": round(took, 1)}
    if left:
        yield f"jobs of a killed driver go on: {left}"
    yield from faults_of(driver.path, 60, expected)


TRIALS = {trial.__name__: trial for trial in (losses, walltime, killed)}


def tried(names, batch, folder):
    """Make the trials; return the report and the faults of each by name."""
    document, expected = {}, {}
    for name in names:
        began, results = time.monotonic(), []
        try:
            results += TRIALS[name](batch, folder, expected)
        except (AssertionError, OSError, TriboError, subprocess.SubprocessError) as error:
            results += [{}, f"{type(error).__name__}: {error}"]
        took = {"took": round(time.monotonic() - began, 1)}
        reports = [report for report in results if isinstance(report, dict)]
        faults = [fault for fault in results if isinstance(fault, str)]
        document[name] = {**took, **reports[0], "faults": faults}
        print(name, took, faults, file=sys.stderr)
    return document


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trials", nargs="*", metavar="TRIAL", help=", ".join(TRIALS))
    names = parser.parse_args().trials or [*TRIALS]
    if unknown := {*names} - {*TRIALS}:
        parser.error(f"no such trial: {', '.join(unknown)}; give some of {', '.join(TRIALS)}")
    if absent := missing_programs():
        parser.error(f"there is no {', '.join(absent)}: apt-get install slurm-wlm munge")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "slurm").mkdir()
        with closing(Slurm(folder / "slurm")) as batch, DRIVERS:
            document = tried(names, batch, folder)
    is_right = not any(report["faults"] for report in document.values())
    return conclude("cluster", json.dumps(document, indent=1), is_right)


if __name__ == "__main__":
    sys.exit(main())
