"""Crash the real command in the middle of its writes, and run it twice at once by every path.

A driver or worker of ``irg run`` is killed with all of its group before its n-th change to a file,
each write being torn in two. The store must open, hold what was seen done, and go on to what an
undisturbed run gives. Then two runs are started at once by different paths to one store: just one
goes on. Prints a JSON document.
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
from contextlib import suppress
from pathlib import Path

import xarray as xr
from pipeline.store.variables import COLUMNS

from pipeline.store import StoreError, summary, verify_store
from tests.crash.bounded import add_seconds, until

ROOT = Path(__file__).parents[2]
PATIENCE = 120.0  # [s] for a run that takes less than 10
SCENE = """
extends = "{shipped}"
[fidelity]
pixels_per_element = 8
increments = 6
history_coarsening = 1
[sweep]
loads = ["200 N", "400 N", "750 N"]
velocities = ["0.5 m/s", "1 m/s", "2 m/s", "4 m/s"]
"""
# Python runs this module in every process, workers included, before anything else.
SITE = """
import os, signal, sys
if "IRG_CRASH" in os.environ:
    folder, last = os.environ["IRG_CRASH"].split(":")
    sys.path.insert(0, {root!r})
    from tests.crash import countdown
    class All(countdown.Countdown):
        def change(self):
            self.changes += 1
            if self.changes == self._last:
                os.killpg(os.getpgid(0), signal.SIGKILL)
    All(folder, int(last))
"""


def started(scene, out, crash=None, site=None):
    """A run of the command, in a group of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    if crash:
        environment["PYTHONPATH"] = f"{site}{os.pathsep}{ROOT}"
        environment["IRG_CRASH"] = f"{out.parent}:{crash}"
    return subprocess.Popen(
        [sys.executable, "-m", "pipeline", "run", scene, "-o", out, "--workers", "2"],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )


def told_by(run):
    """What a run says until it ends; it is killed if it does not."""
    try:
        return run.communicate(timeout=PATIENCE)[1]
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)
        return f"Traceback: it has not ended within {PATIENCE:g} s\n{run.communicate()[1]}"


def content(path):
    with xr.open_zarr(path, chunks=None) as ds:
        ds = ds.load()
        return {name: ds[name].values.tobytes() for name in (*COLUMNS, "status")}


def crashed(scene, folder, site, last, expected):
    """Faults after a crash, and whether there was one."""
    out = folder / "out.zarr"
    run = started(scene, out, last, site)
    told = told_by(run)
    faults = []
    if "Traceback" in told:
        faults.append(f"crash {last}: {told[-300:]}")
    if out.exists():
        with suppress(StoreError):
            done = summary(out).done
            found = verify_store(out)
            faults += [f"crash {last}: {each}" for each in (*found.damaged, *found.shared)]
            if found.done != done:
                faults.append(f"crash {last}: {done} done, {found.done} intact")
    told = told_by(again := started(scene, out))
    if again.returncode or content(out) != expected:
        faults.append(f"crash {last}: gone on with it ends with {again.returncode}: {told[-300:]}")
    if any(out.rglob("*.partial")):
        faults.append(f"crash {last}: partial files are left over")
    return faults, run.returncode == -signal.SIGKILL


def paths_to(out):
    """Paths to one store."""
    for link, target in ((out.parent / "alias.zarr", out), (out.parent / "linked", out.parent)):
        if not link.is_symlink():
            link.symlink_to(target)
    yield out
    yield out.parent / "alias.zarr"
    yield out.parent / "linked" / out.name
    yield out.parent / "linked" / ".." / out.parent.name / out.name
    yield Path(os.path.relpath(out))


def together(scene, folder, one, other):
    """Faults of two runs at once, by two of the paths to a store."""
    paths = list(paths_to(folder / "out.zarr"))
    runs = [started(scene, paths[one]), started(scene, paths[other])]
    told = [told_by(run) for run in runs]
    codes = sorted(run.returncode for run in runs)
    in_use = sum("is in use by process" in each for each in told)
    if (codes, in_use) not in (([0, 2], 1), ([0, 0], 0)):  # or one after the other
        yield f"{paths[one]} and {paths[other]}: {codes}, {told}"
    if not verify_store(folder / "out.zarr").is_clean:
        yield f"{paths[one]} and {paths[other]}: the store is damaged"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--crashes", type=int, default=20)
    add_seconds(parser)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    report = {"runs": 0, "crashes": 0, "pairs": 0, "faults": []}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        scene = folder / "scene.toml"
        shipped = ROOT / "workflows" / "irg_transition.toml"
        scene.write_text(SCENE.format(shipped=shipped))
        (site := folder / "site").mkdir()
        (site / "sitecustomize.py").write_text(SITE.format(root=str(ROOT)))
        whole = folder / "whole.zarr"
        told_by(started(scene, whole))
        expected = content(whole)
        pairs = list(itertools.combinations(range(5), 2))
        for one, other in until(options.seconds / 2, pairs, options.seed):
            (own := folder / f"{one} and {other}").mkdir()
            report["pairs"] += 1
            report["faults"] += together(scene, own, one, other)
        for _ in until(options.seconds / 2, range(options.crashes)):
            (own := folder / f"crash {report['runs']}").mkdir()
            faults, was_killed = crashed(scene, own, site, chance.randint(1, 700), expected)
            report["runs"] += 1
            report["crashes"] += was_killed
            report["faults"] += faults
    print(json.dumps(report, indent=1))
    return 1 if report["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
