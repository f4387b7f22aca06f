"""A hundred thousand cheap points in one store, or as many as the command says.

Judged are the number of files, and what it takes to run, open, go on with and verify them. Prints a
JSON document.
"""

import argparse
import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import pipeline
from pipeline import run_sweep
from tests.crash.loop import differing, indexed_points, values_of_points
from tests.crash.sweeps import Expected
from tests.helpers import tiny
from tests.helpers.campaigns import conclude

MANY = 100_000
LOADS = 20
COMPARED = 40  # points compared with those computed alone
LIMITS = {"files": 3000, "opened": 0.3, "resumed": 15.0}
"""Limits of 100 000 points: files, and times [s]."""
_PATIENCE = 3600.0  # time that a run may take [s]


def sweep_of(points):
    """Sweep of points of a few milliseconds, on smooth bodies; each load has a transition."""
    return tiny.sweep(
        increments=3,
        roughness=None,
        loads=tuple(np.linspace(375.0, 600.0, LOADS).tolist()),
        velocities=tuple(np.geomspace(1.0, 20.0, -(-points // LOADS)).tolist()),
    )


def drive(path, points):
    """Run or resume the sweep; write what it cost to a file beside the store."""
    began = time.monotonic()
    outcome = run_sweep(sweep_of(points), path, workers=2)
    cost = {
        "computed": outcome.computed,
        "failed": len(outcome.failed),
        "wall": round(time.monotonic() - began, 2),
        "driver_cpu": round(time.process_time(), 2),
        "driver_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3),
    }
    path.with_suffix(".json").write_text(json.dumps(cost))


def driven(path, points):
    """Run or resume the sweep in another process; return its cost as a dictionary."""
    command = [sys.executable, "-m", "tests.crash.many", "--drive", path, "--many", str(points)]
    done = subprocess.run(
        command, cwd=Path(__file__).parents[2], stdout=subprocess.DEVNULL, timeout=_PATIENCE,
        check=False,
    )  # fmt: skip
    if done.returncode:
        raise SystemExit(f"a run of {points} points ends with {done.returncode}")
    return json.loads(path.with_suffix(".json").read_text())


def timed(function, *arguments):
    """Result of a function, and a list of its wall and CPU time [s]."""
    began = time.perf_counter(), time.process_time()
    result = function(*arguments)
    ended = time.perf_counter(), time.process_time()
    return result, [round(b - a, 2) for a, b in zip(began, ended, strict=True)]


def large(folder, points):
    """Run, resume, open and verify a large sweep; yield faults, then a report."""
    path, report = folder / "many.zarr", {}
    report["run"] = driven(path, points)
    report["files"] = sum(len(names) for _, _, names in os.walk(path))
    report["resumed"] = driven(path, points)
    pipeline.open_sweep(path)  # so that imports are not timed
    ds, report["open"] = timed(pipeline.open_sweep, path)
    summary, report["status"] = timed(pipeline.summary, path)
    _, report["boundary"] = timed(pipeline.boundary, ds)
    checked, report["verify"] = timed(pipeline.verify_store, path)
    if not (summary.done == checked.done == ds["status"].size and checked.is_clean):
        yield f"{summary.done} points are done, {checked.done} of them intact"
    expected, arrays = Expected(sweep_of(points)), values_of_points(ds)
    for index, point in random.sample(list(indexed_points(ds)), COMPARED):
        for name in differing(arrays, index, expected(point)):
            yield f"{point}: {name} differs"
    took = {
        "files": report["files"],
        "opened": min(report["open"]),
        "resumed": report["resumed"]["wall"],
    }
    for name, limit in LIMITS.items():
        if took[name] > limit:
            yield f"{name}: {took[name]}, and at most {limit} was promised"
    yield report


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drive", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--many", type=int, default=MANY, help="so many points")
    options = parser.parse_args()
    if options.drive:
        drive(options.drive, options.many)
        return 0
    np.seterr(all="raise", under="ignore")
    with tempfile.TemporaryDirectory() as folder:
        *faults, report = large(Path(folder), options.many)
    document = {"large": report, "faults": faults}
    return conclude("many", json.dumps(document, indent=1), not faults)


if __name__ == "__main__":
    sys.exit(main())
