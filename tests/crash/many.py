"""Store very many cheap points, killing workers, the driver or all on the way; resume and read.

What has been seen done must stay done, and in the end all of it must be intact, and at points taken
by chance be what is computed there alone. Prints a JSON document with what that cost.
"""

import argparse
import itertools
import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

import pipeline
from pipeline.run.sweep import run_sweep
from pipeline.store import DONE, Store, StoreError, summary, verify_store
from pipeline.sweep.plan import run_point
from tests.crash.compared import differing
from tests.crash.kills import is_gone, kill, workers_of
from tests.helpers import tiny

LOADS = 10
TARGETS = ("everything", "worker", "client")
COMPARED = 40  # points
_PATIENCE = 200.0  # [s] for a run that has nothing to compute


def sweep_of(points):
    """Points of a few milliseconds each, on smooth bodies."""
    return tiny.sweep(
        increments=3,
        roughness=None,
        loads=tuple(np.linspace(150.0, 600.0, LOADS).tolist()),
        velocities=tuple(np.linspace(0.5, 4.0, -(-points // LOADS)).tolist()),
    )


def drive(path, points):
    """Run or resume the sweep; write what it cost beside it."""
    began = time.monotonic()
    first = []

    def noted(progress):
        if progress.done > (first[0][0] if first else -1):
            first.append((progress.done, time.monotonic() - began, time.process_time()))
            del first[2:]

    outcome = run_sweep(sweep_of(points), path, workers=2, progress=noted)
    told = {
        "computed": outcome.computed,
        "failed": len(outcome.failed),
        "wall": time.monotonic() - began,
        "cpu": time.process_time(),
        "mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
        "until_the_first_point": first[1][1] if len(first) > 1 else None,
    }
    path.with_suffix(".json").write_text(json.dumps(told))
    return 1 if outcome.failed else 0


def done(path):
    try:
        return Store(path).flags()[0] == DONE
    except StoreError:
        return np.zeros((LOADS, 0), bool)


def start(path, points):
    return subprocess.Popen(
        [sys.executable, "-m", __spec__.name, "--drive", path, "--points", str(points)],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
    )


def disturbed(path, points, kills, every, end):
    """Run and resume the sweep with so many kills; what happened, and what was wrong."""
    targets = list(itertools.islice(itertools.cycle(TARGETS), kills))
    told = {"killed": [], "starts": 0, "faults": []}
    seen, code = done(path), None
    while code != 0 and time.monotonic() < end:
        driver, following = start(path, points), time.monotonic() + random.uniform(*every)
        told["starts"] += 1
        try:
            while driver.poll() is None and time.monotonic() < end:
                with suppress(subprocess.TimeoutExpired):
                    driver.wait(0.1)
                if not targets or time.monotonic() < following:
                    continue
                at_work = np.count_nonzero(done(path)) > np.count_nonzero(seen)
                if at_work and workers_of(driver.pid):
                    told["killed"].append(targets[0])
                    kill(driver, targets.pop(0))
                    following = time.monotonic() + random.uniform(*every)
        finally:
            with suppress(ProcessLookupError):
                if driver.poll() is None:
                    os.killpg(driver.pid, signal.SIGKILL)
            code = driver.wait()
        if not is_gone(driver.pid):
            told["faults"].append("processes are left over")
            os.killpg(driver.pid, signal.SIGKILL)
        now = done(path)
        if seen.size and not now[seen].all():
            told["faults"].append(f"{np.count_nonzero(seen & ~now)} points were done and are not")
        seen = now
    if code != 0:
        told["faults"].append(f"it ended with {code}, or not in time")
    return told


def timed(function):
    """Result of a function, and what it took: wall and CPU time [s]."""
    began = time.perf_counter(), time.process_time()
    found = function()
    return found, {
        "wall": round(time.perf_counter() - began[0], 2),
        "cpu": round(time.process_time() - began[1], 2),
    }


def read(path, points):
    """Read a finished store in every way; what that took, and what is wrong."""
    pipeline.open_sweep(path)  # so that what is imported for it does not count
    (found, status), (ds, opened) = (
        timed(lambda: summary(path)),
        timed(lambda: pipeline.open_sweep(path)),
    )
    told = {"status": status, "open": opened}
    _, told["boundary"] = timed(lambda: pipeline.boundary(ds))
    checked, told["verify"] = timed(lambda: verify_store(path))
    total = len(sweep_of(points).velocities) * LOADS
    faults = [f"damaged: {damage}" for damage in checked.damaged[:9]]
    if not found.done == checked.done == total:
        faults.append(f"{found.done} of {total} points are done, {checked.done} of them intact")
    store, sweep = Store(path), sweep_of(points)
    for point in random.sample(store.asked(), min(COMPARED, total)):
        with np.errstate(all="raise", under="ignore"):
            names = differing(store, run_point(sweep, *point))
        faults += [f"{point}: {name} differs" for name in names]
    told["mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return told, faults


def resumed(path, points):
    """What it costs to find that nothing is left to do."""
    driver = start(path, points)
    try:
        code = driver.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        os.killpg(driver.pid, signal.SIGKILL)
        code = driver.wait()
    return json.loads(path.with_suffix(".json").read_text()) | {"code": code}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--kills", type=int, default=6)
    parser.add_argument("--every", nargs=2, type=float, default=[20.0, 60.0], metavar="S")
    parser.add_argument("--patience", type=float, default=3600.0, help="for all of it [s]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--drive", metavar="OUT.zarr", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.drive:
        return drive(options.drive, options.points)
    random.seed(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "many.zarr"
        end = time.monotonic() + options.patience
        told = disturbed(path, options.points, options.kills, options.every, end)
        if not told["faults"]:
            told["last_run"] = json.loads(path.with_suffix(".json").read_text())
            told["files"] = sum(len(names) for _, _, names in os.walk(path))
            told["resumed"] = resumed(path, options.points)
            told["read"], faults = read(path, options.points)
            told["faults"] += faults
    print(json.dumps(told, indent=1))
    return 1 if told["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
