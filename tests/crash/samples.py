"""Kill a sweep over samples again and again, at any process of it, and resume it to its end.

In the end every sample has its boundary, the store is clean, and the first samples have, bit for
bit, the points of a sweep of these alone that nobody disturbed, and no others. Prints a JSON
document, with the most memory that a driver or a worker took.
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
from contextlib import suppress
from pathlib import Path

import numpy as np

import pipeline
from pipeline.run.follow import follow_boundary
from pipeline.store import DONE, Store, verify_store
from tests.crash.kills import is_gone, kill, workers_of

SCENE = Path(__file__).parents[2] / "workflows" / "uncertain.toml"
TARGETS = ("everything", "worker", "client", "worker", "forkserver")
UNDISTURBED = 48  # samples; as many are searched before more are learnt from
COMPARED = ("time", "rise_quantile", "max_rise", "wear_volume", "contact_width")


def scene(samples):
    return pipeline.load_scene(SCENE, overrides={"sweep.samples": samples})


def peak(process):
    """Most memory that a process had at a time [MB]; 0 if it is gone."""
    with suppress(OSError, StopIteration):
        lines = (Path("/proc") / str(process) / "status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1000
    return 0.0


def disturbed(path, samples, kills, patience, every):
    """Run and resume the sweep, killed so often; what it took."""
    command = ["run", str(SCENE), "-o", str(path), "--set", f"sweep.samples={samples}", "-q"]
    targets = list(itertools.islice(itertools.cycle(TARGETS), kills))
    told = {
        "starts": 0,
        "given_up": 0,
        "killed": [],
        "driver_mb": 0.0,
        "worker_mb": 0.0,
        "faults": [],
    }
    end, code = time.monotonic() + patience, None
    while code != 0 and told["given_up"] <= len(told["killed"]) and time.monotonic() < end:
        driver = subprocess.Popen(
            [Path(sys.executable).with_name("irg"), *command, "--workers", "2"],
            start_new_session=True,
            stdout=subprocess.DEVNULL,
        )
        told["starts"] += 1
        following = time.monotonic() + random.uniform(*every)
        try:
            while driver.poll() is None and time.monotonic() < end:
                with suppress(subprocess.TimeoutExpired):
                    driver.wait(0.5)
                there = workers_of(driver.pid)
                told["driver_mb"] = max(told["driver_mb"], peak(driver.pid))
                told["worker_mb"] = max(told["worker_mb"], *map(peak, there), 0.0)
                if targets and there and time.monotonic() > following:
                    told["killed"].append(targets[0])
                    kill(driver, targets.pop(0))
                    following = time.monotonic() + random.uniform(*every)
        finally:
            with suppress(ProcessLookupError):
                if driver.poll() is None:
                    os.killpg(driver.pid, signal.SIGKILL)
            code = driver.wait()
        told["given_up"] += code > 0  # as it may, where workers are killed
        if not is_gone(driver.pid):
            told["faults"].append("processes are left over")
            os.killpg(driver.pid, signal.SIGKILL)
    if code != 0:
        told["faults"].append(f"it ended with {code}, or not within {patience:g} s")
    return told


def faults_of(path, samples, alone):
    """What is wrong with a store that should be complete."""
    found = verify_store(path)
    yield from (f"damaged: {each}" for each in found.damaged)
    ds = pipeline.open_sweep(path)
    if missing := pipeline.Ensemble.of(ds).missing:
        yield f"{missing} of {samples} samples have no boundary"
    store, other = Store(path), Store(alone)
    few = len(other.axes["sample"])
    done, alike = (
        {at for at, flag in each.status().items() if flag == DONE and at.sample < few}
        for each in (store, other)
    )
    yield from (f"{point}: in one of two stores alone" for point in sorted(done ^ alike))
    for point in done & alike:
        names = list(COMPARED)
        mine, theirs = store.at(point, names), other.at(point, names)
        yield from (
            f"{point}: {name} differs"
            for name in names
            if not np.array_equal(mine[name], theirs[name], equal_nan=True)
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1000)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--every", nargs=2, type=float, default=[10.0, 40.0], metavar="S")
    parser.add_argument("--patience", type=float, default=3600.0, help="for all of it [s]")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    random.seed(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        path, alone = Path(folder) / "killed.zarr", Path(folder) / "alone.zarr"
        few = min(options.samples, UNDISTURBED)
        follow_boundary(scene(few), alone, workers=2)
        told = disturbed(path, options.samples, options.kills, options.patience, options.every)
        if path.exists():
            told["faults"] += faults_of(path, options.samples, alone)
            told["points"] = sum(flag == DONE for flag in Store(path).status().values())
    print(json.dumps(told, indent=1))
    return 1 if told["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
