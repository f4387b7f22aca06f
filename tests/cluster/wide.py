"""What workers gain, and what share of a core the driver takes.

    python -m tests.cluster.wide --workers 1 2 16 --points 3000 --seconds 0.06 --for 10

The workers are threads of one process, and wait at each point in place of computing it; scheduler,
schedule, commits and network (without encryption) are real. Prints a JSON document.
"""

import argparse
import asyncio
import json
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from distributed import LocalCluster, Worker

import pipeline
from pipeline.run import work
from pipeline.run.cluster import client_of
from tests.crash.many import sweep_of

ROOT = Path(__file__).parents[2]


class EnoughError(Exception):
    """Ends a sweep when its time is over."""


class Waiting:
    """Replacement of `run_point` that waits, and returns data of the first point at each load."""

    def __init__(self, seconds):
        self._seconds, self._known, self._run_point = seconds, {}, work.run_point
        self._lock = threading.Lock()

    def __call__(self, scene, stored_steps, point, *_, **options):
        with self._lock:
            if point.load not in self._known:
                self._known[point.load] = self._run_point(scene, stored_steps, point, **options)
        time.sleep(self._seconds)
        return replace(self._known[point.load], point=point, wall_time=self._seconds)


async def host(address, number):
    """Workers, all in this process."""
    workers = [Worker(address, nthreads=1, memory_limit=0) for _ in range(number)]
    await asyncio.gather(*workers)
    await asyncio.gather(*(worker.finished() for worker in workers))


def driven(out, address, options):
    """Drive the workers for a while; return how many points a second they do, and the driver."""
    marks = []

    def note(now):
        if now.words or not now.done:
            return
        marks.append(np.array([now.done, time.monotonic(), time.process_time()]))
        if marks[-1][1] - marks[0][1] > options.duration:
            raise EnoughError

    with suppress(EnoughError), client_of(address) as client:
        sweep = sweep_of(options.points)
        pipeline.run_sweep(sweep, out, client=client, progress=note, patience=120.0)
    done, wall, cpu = marks[-1] - marks[0]
    return {
        "workers": options.workers,
        "done": int(done),
        "points_a_second": done / wall,
        "driver_share_of_a_core": cpu / wall,
    }


def measured(options):
    """Report of a run on so many workers."""
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as cluster,
    ):
        words = ["--host", cluster.scheduler_address, "--workers", str(options.workers)]
        workers = subprocess.Popen(
            [sys.executable, "-m", "tests.cluster.wide", *words, "--seconds", str(options.seconds)],
            cwd=ROOT,
        )
        try:
            return driven(Path(folder) / "out.zarr", cluster.scheduler_address, options)
        finally:
            workers.kill()
            workers.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="+", default=[200])
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=4.0, help="of a point")
    parser.add_argument("--for", dest="duration", type=float, default=60.0, help="seconds")
    parser.add_argument("--host", metavar="ADDRESS", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.host:
        work.run_point, work._one_at_a_time = Waiting(options.seconds), nullcontext()
        asyncio.run(host(options.host, *options.workers))
        return
    reports = [
        measured(argparse.Namespace(**vars(options) | {"workers": count}))
        for count in options.workers
    ]
    print(json.dumps(reports, indent=1))


if __name__ == "__main__":
    main()
