"""Ten thousand and a hundred thousand cheap points: what they cost, and what is seen on the way.

With 10 000 points: at a tenth of the time since the first of them, `irg plot` shows the whole
boundary, and the time to go that was told then is right within a third. With 100 000: the number of
files, and what it takes to run, open, go on with and verify them. Prints a JSON document.
"""

import argparse
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import pipeline
from pipeline import run_sweep
from pipeline.cli import main as irg
from pipeline.store.files import PARTIAL
from pipeline.store.place import ROOT
from tests.crash.loop import code_of, differing, places, values_of_points
from tests.crash.sweeps import Expected
from tests.helpers import tiny
from tests.helpers.campaigns import conclude

FEWER, MANY = 10_000, 100_000
LOADS = 20
COMPARED = 40  # points compared with those computed alone
MOST = {"files": 3000, "opened": 0.3, "resumed": 15.0}
"""Limits of 100 000 points: files, and times [s]."""
_STEPS = 12  # increments of each point of the first sweep, which takes minutes
_OFF = 1 / 3  # relative error allowed of the forecast of the remaining time
_NEAR = 0.02  # relative error of an early boundary, interpolated between few velocities
_PATIENCE = 3600.0  # time that a run may take [s]


def sweep_of(points, increments=3):
    """Sweep of points of a few milliseconds, on smooth bodies; each load has a transition."""
    return tiny.sweep(
        increments=increments,
        roughness=None,
        loads=tuple(np.linspace(375.0, 600.0, LOADS).tolist()),
        velocities=tuple(np.geomspace(1.0, 20.0, -(-points // LOADS)).tolist()),
    )


def drive(path, points, increments):
    """Run or resume the sweep; write progress reports and cost to a file beside the store."""
    reports = []

    def note(now):
        if not now.words:
            reports.append((now.elapsed, now.done, now.time_to_go))

    began = time.monotonic()
    outcome = run_sweep(
        sweep_of(points, increments),
        path,
        workers=2,
        progress=note,
    )
    cost = {
        "computed": outcome.computed,
        "failed": len(outcome.failed),
        "wall": round(time.monotonic() - began, 2),
        "driver_cpu": round(time.process_time(), 2),
        "driver_mb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3),
    }
    path.with_suffix(".json").write_text(json.dumps({"cost": cost, "told": reports}))


@contextmanager
def started(path, points, increments=3):
    """Context: a run in another process, which is killed on leaving."""
    command = [sys.executable, "-m", "tests.crash.many", "--drive", path, "--points", str(points)]
    command += ["--increments", str(increments)]
    options = {"cwd": Path(__file__).parents[2], "stdout": subprocess.DEVNULL}
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def driven(path, points):
    """Run or resume the sweep in another process; return its cost as a dictionary."""
    began = time.monotonic()
    with started(path, points) as process:
        code = code_of(process, _PATIENCE)
    if code != 0:
        raise SystemExit(f"a run of {points} points ends with {code}")
    cost = json.loads(path.with_suffix(".json").read_text())["cost"]
    return cost | {"with_its_start": round(time.monotonic() - began, 2)}


def copied(path, to):
    """Copy a store during a write: statuses first, as the data of done points are older."""
    to.mkdir()
    for name in ["zarr.json", "status"]:
        copy = shutil.copytree if (path / name).is_dir() else shutil.copy
        copy(path / name, to / name)
    left = shutil.ignore_patterns(f"*{PARTIAL}", "lock", "status", "zarr.json")
    shutil.copytree(path, to, ignore=left, dirs_exist_ok=True)
    for array in path.iterdir():
        if (array / "zarr.json").exists():
            shutil.copy(array / "zarr.json", to / array.name / "zarr.json")


def early(folder, points):
    """Yield faults of what is shown at a tenth of a run's time, then a report."""
    path, copies = folder / "early.zarr", []
    with started(path, points, _STEPS) as process:
        following = 0.0
        while process.poll() is None:
            time.sleep(0.2)
            if (path / ROOT).exists() and time.monotonic() > following:
                copies.append(folder / f"{len(copies)}.zarr")
                copied(path, copies[-1])
                following = time.monotonic() + max(1.0, 0.1 * len(copies))
    document = json.loads(path.with_suffix(".json").read_text())
    reports, whole = document["told"], pipeline.boundary(pipeline.open_sweep(path))
    # Time counts from the first points, as the start takes equally long for any number of points.
    began = next(elapsed for elapsed, done, _ in reports if done)
    tenth = began + (reports[-1][0] - began) / 10
    elapsed, done, to_go = min(reports[1:], key=lambda report: abs(report[0] - tenth))
    copy = min(copies, key=lambda copy: abs(pipeline.summary(copy).done - done))
    coarse = pipeline.boundary(pipeline.open_sweep(copy))
    off = np.abs(coarse["critical_velocity"] / whole["critical_velocity"] - 1).values
    plotted = irg(["plot", str(copy), "--kind", "diagram", "-o", str(folder / "a.png")])
    real = reports[-1][0] - elapsed
    report = {
        **document["cost"],
        "first_points_at": round(began, 2),
        "at": round(elapsed, 2),
        "done_then": done,
        "in_the_picture": pipeline.summary(copy).done,
        "time_to_go": round(to_go, 2),
        "it_took": round(real, 2),
        "loads_with_a_boundary": int(np.isfinite(off).sum()),
        "boundary_off_by": float(np.nanmax(off, initial=0.0)),
    }
    if abs(to_go / real - 1) > _OFF:
        yield f"{to_go:.1f} s to go were told at a tenth, and it took {real:.1f} s"
    if not np.all(off <= _NEAR) or plotted != 0:
        yield f"the boundary is not whole at a tenth: off by {off.tolist()}, plot ends in {plotted}"
    yield report


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
    for index, point in random.sample(list(places(ds)), COMPARED):
        for name in differing(arrays, index, expected(point)):
            yield f"{point}: {name} differs"
    took = {
        "files": report["files"],
        "opened": min(report["open"]),
        "resumed": report["resumed"]["wall"],
    }
    for name, most in MOST.items():
        if took[name] > most:
            yield f"{name}: {took[name]}, and at most {most} was promised"
    yield report


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name, kind in (("--drive", Path), ("--points", int), ("--increments", int)):
        parser.add_argument(name, type=kind, help=argparse.SUPPRESS)
    parser.add_argument("--many", type=int, default=MANY, help="so many, without the picture")
    options = parser.parse_args()
    if options.drive:
        drive(options.drive, options.points, options.increments)
        return 0
    np.seterr(all="raise", under="ignore")
    with tempfile.TemporaryDirectory() as temporary:
        folder, document = Path(temporary), {}
        faults = []
        if options.many == MANY:
            *faults, document["early"] = early(folder, FEWER)
        *further, document["large"] = large(folder, options.many)
    document["faults"] = faults + further
    return conclude("many", json.dumps(document, indent=1), not document["faults"])


if __name__ == "__main__":
    sys.exit(main())
