"""Kill workers, the client or everything at random times during a real sweep on two workers.

What has been seen done must stay done and intact, nothing may be marked failed, and in the end
there is what an undisturbed sweep gives. Prints a JSON document.
"""

import argparse
import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from unittest import mock

import numpy as np

from pipeline.run import schedule
from pipeline.run.sweep import ExecutionError, run_sweep
from pipeline.store import DONE, Store, StoreError, summary, verify_store
from pipeline.sweep.plan import points, run_point
from tests.crash.bounded import add_seconds
from tests.crash.compared import differing
from tests.helpers import tiny

SWEEP = tiny.full(
    loading=tiny.SlowRamp(150.0, 750.0),
    velocities=tuple(np.linspace(0.5, 1.5, 12).tolist()),
)
TARGETS = ("worker", "everything", "client", "worker", "forkserver")
GIVEN_UP = 3
PATIENCE = 180.0  # [s] for a run that takes less than 20


def forked_from(parent):
    """Processes that are children of another and have to do with a forkserver."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            of = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            if of == parent and b"forkserver" in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
    return found


def workers_of(driver):
    """Worker processes of a driver, which the forkserver has started for it."""
    return [worker for server in forked_from(driver) for worker in forked_from(server)]


def is_gone(group, patience=30.0):
    """Whether no process of a group is left, after some patience."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def kill(driver, target):
    """Kill one of the workers, the client or all."""
    with suppress(ProcessLookupError):
        if target == "worker":
            os.kill(random.choice(workers_of(driver.pid)), signal.SIGKILL)
        elif target == "forkserver":
            os.kill(*forked_from(driver.pid), signal.SIGKILL)
        elif target == "client":
            driver.kill()
        else:
            os.killpg(driver.pid, signal.SIGKILL)


def drive(path):
    """Run or resume the sweep, with several points in a task, as if they were short."""
    try:
        with mock.patch.object(schedule, "_STRETCH", 10.0):
            return 1 if run_sweep(SWEEP, path, workers=2).failed else 0
    except ExecutionError as error:  # workers were killed so often that it gave up
        print(error, file=sys.stderr)
        return GIVEN_UP


class Sweeps:
    """One sweep after the other, each until it is done."""

    def __init__(self, folder):
        self._folder, self.finished, self.faults = folder, 0, []
        self._expected = {point: run_point(SWEEP, *point) for point in points(SWEEP)}
        self._seen = set()

    @property
    def path(self):
        return self._folder / f"{self.finished}.zarr"

    def start(self):
        self.end = time.monotonic() + PATIENCE
        return subprocess.Popen(
            [sys.executable, "-m", __spec__.name, "--drive", self.path],
            start_new_session=True,
            stdout=subprocess.DEVNULL,
        )

    def look(self):
        """Note what is wrong with the store."""
        try:
            store = Store(self.path)
        except StoreError:
            if self._seen:
                self.faults.append("the store does not open any more")
            return
        done = {point for point, flag in store.status().items() if flag == DONE}
        self.faults += [f"{point} was done and is not" for point in self._seen - done]
        self.faults += [f"damaged: {damage}" for damage in verify_store(self.path).damaged]
        self.faults += [f"failed: {failed}" for failed in summary(self.path).failed]
        self._seen = done

    def finish(self):
        """Compare a sweep that is done with what it should be; go on to the next."""
        self.look()
        store = Store(self.path)
        for point, expected in self._expected.items():
            self.faults += [f"{point}: {name} differs" for name in differing(store, expected)]
        shutil.rmtree(self.path)
        self.finished += 1
        self._seen = set()


class Campaign:
    """Kills at random times, through as many sweeps as that takes."""

    def __init__(self, sweeps, targets, seconds):
        self._sweeps, self._targets, self._end = sweeps, targets, time.monotonic() + seconds
        self.kills, self.given_up = Counter(), 0

    def run(self):
        """Go on until there is nothing left to kill and a sweep is complete, or a fault."""
        driver, complete = self._sweeps.start(), False
        try:
            while not (complete or self._sweeps.faults):
                if time.monotonic() > self._end:
                    self._targets.clear()
                self._disturb(driver)
                if driver.poll() is None:
                    self._sweeps.look()
                    continue
                complete = self._ended(driver) and not self._targets
                if not (complete or self._sweeps.faults):
                    driver = self._sweeps.start()
        finally:
            if driver.poll() is None:
                os.killpg(driver.pid, signal.SIGKILL)
                driver.wait()

    def _disturb(self, driver):
        """Kill something after a while, if the driver has workers by then."""
        with suppress(subprocess.TimeoutExpired):
            driver.wait(random.uniform(0.5, 4.0))
        if driver.poll() is None and self._targets and workers_of(driver.pid):
            target = self._targets.pop(0)
            self.kills[target] += 1
            kill(driver, target)
        with suppress(subprocess.TimeoutExpired):
            driver.wait(0.1)
        if driver.poll() is None and time.monotonic() > self._sweeps.end:
            self._sweeps.faults.append(f"a sweep has not ended within {PATIENCE:g} s")

    def _ended(self, driver):
        """Look at what a driver that has ended leaves; say whether its sweep is complete."""
        if not is_gone(driver.pid):
            self._sweeps.faults.append("processes are left over")
            os.killpg(driver.pid, signal.SIGKILL)
        if driver.returncode == GIVEN_UP:
            self.given_up += 1
        elif driver.returncode > 0:
            self._sweeps.faults.append(f"the driver ended with {driver.returncode}")
        complete = driver.returncode == 0
        if complete:
            self._sweeps.finish()
        self._sweeps.look()
        return complete


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--drive", metavar="OUT.zarr", help=argparse.SUPPRESS)
    add_seconds(parser)
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    if options.drive:
        return drive(options.drive)
    random.seed(options.seed)
    targets = list(itertools.islice(itertools.cycle(TARGETS), options.kills))
    random.shuffle(targets)
    with tempfile.TemporaryDirectory() as temporary:
        sweeps = Sweeps(Path(temporary))
        campaign = Campaign(sweeps, targets, options.seconds)
        campaign.run()
    report = {
        "kills": campaign.kills,
        "sweeps": sweeps.finished,
        "given_up": campaign.given_up,
        "faults": sweeps.faults,
    }
    print(json.dumps(report, indent=1))
    return 1 if sweeps.faults else 0


if __name__ == "__main__":
    sys.exit(main())
