"""What a cheap point costs in CPU time, and what part of that is Dask's own.

    python -m tests.cluster.cheap --points 10000
    python -m tests.cluster.cheap --points 2000 --scan 1000

A sweep on smooth bodies, whose points take some milliseconds, and as many empty tasks. Both run on
two workers of this machine with encrypted connections. With ``--scan`` a tenth
of the points are also computed on a scan of so many heights squared, on as few elements. Prints a
JSON document.
"""

import argparse
import itertools
import json
import tempfile
import time
from functools import partial
from pathlib import Path

import dask
import numpy as np
from distributed import Client, as_completed

import pipeline
from pipeline.run.cluster import CONFIGURATION, processes
from pipeline.run.work import pickled
from pipeline.sweep.plan import CaseInputs, choose_stored_steps

_LOADS, _WORKERS, _AT_ONCE = 10, 2, 16
RANDOM = "ra", "hurst_exponent", "correlation_length", "seed"


def scene_of(points, scan=0, folder=Path()):
    """Scene of few loads and many velocities, on 24 × 1 elements.

    Bodies are smooth, or the disk is a scan of `scan` × `scan` heights in a file in `folder`.
    """
    overrides = {
        "without": ["disk.roughness"],
        "window.pixels": [96, 4],
        "window.pixel_size": ["4 um", "20 um"],
    }
    if scan:
        file, sides = folder / "scan.npy", [f"{384 / scan} um", f"{80 / scan} um"]
        np.save(file, np.random.default_rng(0).normal(scale=0.01, size=(scan, scan)))
        overrides = {
            "without": [f"disk.roughness.{key}" for key in RANDOM],
            "disk.roughness.file": str(file),
            "disk.roughness.height_unit": "um",
            "window.pixels": [scan, scan],
            "window.pixel_size": sides,
            "fidelity.pixels_per_element": scan // 20,
            "fidelity.fewest_elements": 0,  # so that elements have these pixels
        }
    return pipeline.load_scene(
        "first_try",
        "standard",
        overrides
        | {
            "sweep.fields": False,
            "sweep.loads": [f"{load} N" for load in range(200, 700, 50)],
            "sweep.velocities": [
                f"{velocity:.6g} m/s" for velocity in np.linspace(1.0, 4.0, points // _LOADS)
            ],
        },
    )


def carried(sweep):
    """What a task carries of its case."""
    case = sweep.base
    return pickled(CaseInputs(case.scene, choose_stored_steps(sweep), False, case.has_film))


def timed(client, compute):
    """CPU time of driver and workers by point [ms], number of points and wall time [s]."""
    before = time.monotonic(), time.process_time(), sum(client.run(time.process_time).values())
    points = compute()
    after = time.monotonic(), time.process_time(), sum(client.run(time.process_time).values())
    wall, driver, workers = (b - a for a, b in zip(before, after, strict=True))
    per_point = {"driver_ms": 1e3 * driver / points, "workers_ms": 1e3 * workers / points}
    return {"done": points, **per_point, "wall_s": wall}


def swept(client, sweep, out):
    """Compute a sweep; return the number of points done."""
    return pipeline.run_sweep(sweep, out, client=client).done


def empty_tasks(client, points):
    """Compute empty tasks on Dask, some at once for each worker; return their number."""
    left, ended = iter(range(points)), as_completed(loop=client.loop)
    for number in itertools.islice(left, _AT_ONCE * _WORKERS):
        ended.add(client.submit(bool, 0, key=f"empty-{number}"))
    for future in ended:
        future.release()
        for number in itertools.islice(left, 1):
            ended.add(client.submit(bool, 0, key=f"empty-{number}"))
    return points


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--scan", type=int, default=0, help="heights along a side of a scan")
    options = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        dask.config.set(CONFIGURATION),
        processes(_WORKERS) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        report = {
            "dask": dask.__version__,
            "empty": timed(client, lambda: empty_tasks(client, min(options.points, 2000))),
        }
        for name, scan in {"sweep": 0, "scan": options.scan}.items():
            if scan or name == "sweep":
                points = options.points // 10 if scan else options.points
                sweep = scene_of(points, scan, Path(folder))
                out = Path(folder) / f"{name}.zarr"
                compute = partial(swept, client, sweep, out)
                report[name] = timed(client, compute)
                report[name]["sent_mb"] = len(carried(sweep)) / 1e6
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
