"""Sweeps whose workers die: of the same load again and again, or by chance every second or two.

Every sweep must end by itself; the load that workers die of fails at each velocity, and all other
points are done and what they should be, bit for bit. Prints a JSON document.
"""

import argparse
import itertools
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

from pipeline.run.sweep import run_sweep
from pipeline.store import Store, summary
from pipeline.sweep.plan import points, run_point
from tests.crash.bounded import add_seconds, until
from tests.crash.compared import differing
from tests.crash.kills import workers_of
from tests.helpers import tiny

DEADLY = 250.0
_BUSY = "import os; driver = os.getppid()\nwhile os.getppid() == driver: pass"
PATIENCE = 180.0  # [s] for a sweep that takes less than 20


def sweep_of(kind, velocities):
    """A sweep with a load that is deadly, or one with time to be killed in."""
    axis = tuple(np.linspace(0.5, 1.5, velocities).tolist())
    at = {"deadly": DEADLY, "random": float("nan")}[kind]
    ramp = {"deadly": tiny.DeadlyRamp, "random": tiny.SlowRamp}[kind](150.0, 750.0, at=at)
    return tiny.full(loading=ramp, velocities=axis)


def faults_of(path, sweep, expected):
    """What is wrong with a store that should be complete."""
    failed = {(at.load, at.velocity) for at in summary(path).failed}
    store = Store(path)
    for point in points(sweep):
        if point.load == sweep.loading.at:
            if (point.load, point.velocity) not in failed:
                yield f"{point} is not called failed"
        elif not store.is_done(point):
            how = "has failed" if (point.load, point.velocity) in failed else "is still pending"
            yield f"{point} {how}"
        else:
            yield from (f"{point}: {name} differs" for name in differing(store, expected(point)))


def driven(kind, velocities, path, workers):
    """Run one sweep, and kill its workers by chance; how many were killed, or None if it hangs."""
    command = [sys.executable, "-m", __spec__.name, "--drive", path, "--kind", kind]
    options = ["--velocities", str(velocities), "--workers", str(workers)]
    driver = subprocess.Popen([*command, *options], start_new_session=True)
    end, killed = time.monotonic() + PATIENCE, 0
    try:
        while time.monotonic() < end:
            with suppress(subprocess.TimeoutExpired):
                driver.wait(random.uniform(1.0, 2.0))
                return killed
            if kind == "random" and (there := workers_of(driver.pid)):
                with suppress(ProcessLookupError):
                    os.kill(random.choice(there), signal.SIGKILL)
                    killed += 1
        return None
    finally:
        with suppress(ProcessLookupError):
            os.killpg(driver.pid, signal.SIGKILL)
        driver.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sweeps", type=int, default=20, help="of each kind")
    parser.add_argument("--velocities", type=int, default=20, help="at each of three loads")
    parser.add_argument("--kind", choices=["deadly", "random"], action="append")
    parser.add_argument("--busy", action="store_true", help="keep all cores busy meanwhile")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--drive", metavar="OUT.zarr", help=argparse.SUPPRESS)
    add_seconds(parser)
    options = parser.parse_args()
    kinds = options.kind or ["deadly", "random"]
    np.seterr(all="raise", under="ignore")
    if options.drive:
        run_sweep(sweep_of(*kinds, options.velocities), options.drive, workers=options.workers)
        return 0
    random.seed(options.seed)
    alone = sweep_of("random", options.velocities)
    known = {point: run_point(alone, *point) for point in points(alone)}
    report = {"sweeps": 0, "kills": 0, "hung": 0, "faults": []}
    with ExitStack() as stack:
        for _ in range(os.cpu_count() if options.busy else 0):
            loop = subprocess.Popen([sys.executable, "-c", _BUSY])
            stack.callback(loop.wait)
            stack.callback(loop.kill)
        cases = itertools.product(range(options.sweeps), kinds)
        for number, kind in until(options.seconds, cases, options.seed):
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            path = Path(folder) / "out.zarr"
            killed = driven(kind, options.velocities, path, 2 - number % 2)
            report["sweeps"] += 1
            report["hung"] += killed is None
            report["kills"] += killed or 0
            sweep = sweep_of(kind, options.velocities)
            report["faults"] += faults_of(path, sweep, known.__getitem__)
    print(json.dumps(report, indent=1))
    return 1 if report["hung"] or report["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
