"""Cost of hundreds of workers and a million points for the driver: which wall comes first.

    python -m tests.cluster.wide --workers 200 --points 50000 --seconds 2 --for 120
    python -m tests.cluster.wide --workers 1 2 16 --points 3000 --seconds 0.06 --for 10

The workers are threads of one process, and wait at each point in place of computing it; scheduler,
schedule, commits and network (without encryption) are real. Prints a JSON document.
"""

import argparse
import asyncio
import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from unittest import mock

from distributed import Client, LocalCluster, Worker

import pipeline
from pipeline.run import work
from pipeline.run.cluster import client_of
from pipeline.store.store import Store
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
    """Drive the workers for a while; return what the start, points and commits cost."""
    marks, tasks, commits = [], [], []
    submit, commit = Client.map, Store.commit
    began = time.monotonic(), time.process_time()

    def counted(self, function, cases, *more, **options):
        tasks.extend(cases)
        return submit(self, function, cases, *more, **options)

    def timed(self, records):
        before = time.monotonic(), time.thread_time()
        commit(self, records)
        took = time.monotonic() - before[0], time.thread_time() - before[1]
        commits.append((len(records), *took))

    def note(now):
        if now.words:
            return
        mark = now.done, time.monotonic(), time.process_time(), len(tasks)
        marks.append(mark)
        if now.done and mark[1] - next(m[1] for m in marks if m[0]) > options.duration:
            raise EnoughError

    with (
        mock.patch.object(Client, "map", counted),
        mock.patch.object(Store, "commit", timed),
        suppress(EnoughError),
    ):
        sweep = sweep_of(options.points)
        with client_of(address) as client:
            pipeline.run_sweep(sweep, out, client=client, progress=note, patience=120.0)
    first = next(mark for mark in marks if mark[0])
    done, wall, cpu, number = (b - a for a, b in zip(first, marks[-1], strict=True))
    in_commits = sum(took for _, _, took in commits[1:])
    return {
        "workers": options.workers,
        "points": options.points,
        "until_the_first_point": [first[1] - began[0], first[2] - began[1]],
        "done": done,
        "points_a_second": done / wall,
        "driver_ms_a_task": 1e3 * cpu / max(number, 1),
        "of_them_commits": 1e3 * in_commits / max(number, 1),
        "driver_share_of_a_core": cpu / wall,
        "commits": len(commits),
        "longest_commit_s": max(took for _, took, _ in commits),
        "commit_ms_a_point": 1e3 * in_commits / max(sum(n for n, _, _ in commits[1:]), 1),
        "driver_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
        "files": sum(len(names) for _, _, names in os.walk(out)),
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
