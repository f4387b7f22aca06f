"""Sweeps in which one load kills its worker again and again, while other programs keep all cores.

Each ends by itself; that load fails at each velocity, and no other point does.
"""

import os
import subprocess
import sys
from contextlib import ExitStack

import numpy as np

from pipeline.store.read import open_store
from tests.crash.loop import code_of, end, faults_of, job, started
from tests.crash.sweeps import Expected
from tests.helpers import tiny
from tests.helpers.entries import changed

TRIALS = 2
MISTAKE = "all blamed"
_DEADLY = 250.0
_BUSY = "import os; driver = os.getppid()\nwhile os.getppid() == driver: pass"


def sweep_of(velocities):
    """Sweep with this number of velocities, in which one load in the middle kills its worker."""
    return tiny.full(
        loading=tiny.DeadlyRamp(150.0, 750.0, faulty_load=_DEADLY),
        velocities=tuple(np.linspace(0.5, 1.5, velocities).tolist()),
    )


def _has_killed(point, message):
    return point.load == _DEADLY and "died" in message


def campaign(run):
    """Run `run.count` sweeps to their end, half of them with one worker."""
    with ExitStack() as stack:
        for _ in range(os.cpu_count()):
            busy = subprocess.Popen([sys.executable, "-c", _BUSY])
            stack.callback(busy.wait)
            stack.callback(busy.kill)
        for number, trial in enumerate(run.trials()):
            sweep = sweep_of(run.chance.randint(3, 5))
            expected = Expected(changed(sweep, loading=tiny.SlowRamp(150.0, 750.0)))
            workers = 2 - number % 2
            arguments = (sweep, trial.path, trial.log, None, run.mistake, 0.0, workers)
            driver = started(trial.log, *job(trial.place, *arguments))
            code = code_of(driver)
            if not end(driver):
                trial.fault("processes of a driver that ended go on")
            if code != 1:
                trial.fault(f"it ends with {code}, not 1")
            with open_store(trial.path) as ds:
                for fault in faults_of(ds, expected, may_fail=_has_killed):
                    trial.fault(fault)
                failed = int((ds["status"] == 2).sum())
                pending = int((ds["status"] == 0).sum())
            if failed != len(sweep.velocities) or pending:
                trial.fault(f"{failed} points failed, {pending} are pending")
            run.report.counts["trials"] += 1
            run.report.counts["points that kill"] += failed
