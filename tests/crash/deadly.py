"""Sweeps in which one load kills its worker again and again, while other programs keep all cores.

Each ends by itself; that load fails at each velocity, and no other point does.
"""

import os
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace

import numpy as np

import pipeline
from tests.crash.loop import code_of, end, faults_of, job, started
from tests.crash.sweeps import Expected
from tests.helpers import tiny

TRIALS = 2
MISTAKE = "all blamed"
_DEADLY = 250.0
_BUSY = "import os; driver = os.getppid()\nwhile os.getppid() == driver: pass"


def sweep_of(velocities):
    """A sweep of which one load in the middle is deadly."""
    return tiny.full(
        loading=tiny.DeadlyRamp(150.0, 750.0, at=_DEADLY),
        velocities=tuple(np.linspace(0.5, 1.5, velocities).tolist()),
    )


def _has_killed(point, message):
    return point.load == _DEADLY and "died" in message


def campaign(folder, trials, chance, report, mistake=None):
    """Run so many sweeps to their end, half of them on one worker."""
    with ExitStack() as stack:
        for _ in range(os.cpu_count()):
            busy = subprocess.Popen([sys.executable, "-c", _BUSY])
            stack.callback(busy.wait)
            stack.callback(busy.kill)
        for number in range(trials):
            place = folder / str(number)
            place.mkdir()
            sweep = sweep_of(chance.randint(3, 5))
            expected = Expected(replace(sweep, loading=tiny.SlowRamp(150.0, 750.0)))
            path, log = place / "out.zarr", place / "acknowledged"
            run = started(log, *job(place, sweep, path, log, None, mistake, 0.0, 2 - number % 2))
            code = code_of(run)
            if not end(run):
                report.faults.append(f"{number}: processes of a driver that ended go on")
            if code != 1:
                report.faults.append(f"{number}: it ends with {code}, not 1")
            with pipeline.open_sweep(path) as ds:
                wrong = list(faults_of(ds, expected, may_fail=_has_killed))
                failed = int((ds["status"] == 2).sum())
                pending = int((ds["status"] == 0).sum())
            report.faults += [f"{number}: {fault}" for fault in wrong]
            if failed != len(sweep.velocities) or pending:
                report.faults.append(f"{number}: {failed} points failed, {pending} are pending")
            report.counts["trials"] += 1
            report.counts["points that kill"] += failed
            print(f"deadly: {number + 1} of {trials}, {len(report.faults)} faults", file=sys.stderr)
