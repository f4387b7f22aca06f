"""What hundreds of workers and a million points cost the driver: which wall comes first.

    python -m tests.cluster.wide --workers 200 --points 1000000 --seconds 2 --for 120

The workers are threads of one process, and wait at each point in place of computing it; scheduler,
schedule, commits and network are real. Prints a JSON document.
"""

import argparse
import asyncio
import json
import os
import resource
import stat
import sys
import tempfile
import threading
import time
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from distributed import Security, Worker

import pipeline
from pipeline.run import schedule, work
from pipeline.run import sweep as execute
from tests.crash.sweeps import keep_one_thread
from tests.helpers import tiny
from tests.helpers.slurm import write_commands

_LOADS = 10
ROOT = Path(__file__).parents[2]


class EnoughError(Exception):
    """The time is over."""


class Waiting:
    """A point that takes its time, with the data of the first at its load."""

    def __init__(self, seconds):
        self._seconds, self._known, self._run_point = seconds, {}, work.run_point
        self._lock = threading.Lock()

    def __call__(self, sweep, load, velocity, *place, trunk=None):
        with self._lock:
            if load not in self._known:
                self._known[load] = self._run_point(sweep, load, velocity, *place)
        time.sleep(self._seconds)
        point = self._known[load].point._replace(velocity=velocity)
        return replace(self._known[load], point=point)


async def host(number, address, name, certificates):
    """Workers of one job, all in this process."""
    security = Security(require_encryption=True, **certificates)
    workers = [
        Worker(address, nthreads=2, name=f"{name}-{i}", security=security, memory_limit=0)
        for i in range(number)
    ]
    await asyncio.gather(*workers)
    await asyncio.gather(*(worker.finished() for worker in workers))


def hosted(words):
    parser = argparse.ArgumentParser()
    for option in ("--nworkers", "--name", "--tls-ca-file", "--tls-cert", "--tls-key"):
        parser.add_argument(option)
    options, rest = parser.parse_known_args(words)
    address = next(word for word in rest if word.startswith("tls://") and word != "tls://")
    work.run_point = Waiting(float(os.environ["WIDE_SECONDS"]))
    work._one_at_a_time = nullcontext()
    certificates = {
        "tls_ca_file": options.tls_ca_file,
        "tls_worker_cert": options.tls_cert,
        "tls_worker_key": options.tls_key,
    }
    asyncio.run(host(int(options.nworkers), address, options.name, certificates))


def sweep_of(points):
    """A plane of few loads and many velocities, on smooth bodies."""
    return tiny.sweep(
        increments=3,
        roughness=None,
        loads=tuple(np.linspace(375.0, 600.0, _LOADS).tolist()),
        velocities=tuple(np.geomspace(0.5, 20.0, points // _LOADS).tolist()),
    )


def driven(folder, options):
    """Drive the workers for a while; what each point and the start cost."""
    write_commands(folder / "slurm")
    os.environ["PATH"] = f"{folder / 'slurm'}:{os.environ['PATH']}"
    python = folder / "python"
    python.write_text(f'#!/bin/sh\nexec {sys.executable} -m tests.cluster.wide --host "$@"\n')
    python.chmod(stat.S_IRWXU)
    os.environ |= {"PYTHONPATH": str(ROOT), "WIDE_SECONDS": str(options.seconds)}
    marks, tasks, start = [], [], schedule._Run._start
    began = time.monotonic(), time.process_time()

    def counted(self, *arguments):
        tasks.append(None)
        start(self, *arguments)

    def note(now):
        mark = now.done, time.monotonic(), time.process_time(), len(tasks)
        marks.append(mark)
        if now.done and mark[1] - next(m[1] for m in marks if m[0]) > options.duration:
            raise EnoughError

    schedule._Run._start = counted
    site = pipeline.Site(cores=options.workers, python=str(python), interface="lo")
    commits = []
    commit = execute.Store.commit

    def timed(self, records):
        records = list(records)
        before = time.monotonic(), time.thread_time()
        commit(self, records)
        after = time.monotonic(), time.thread_time()
        commits.append((len(records), after[0] - before[0], after[1] - before[1]))

    execute.Store.commit = timed
    with suppress(EnoughError):
        pipeline.run_sweep(
            sweep_of(options.points),
            folder / "out.zarr",
            cluster=pipeline.Batch("slurm", 1, "2 h", site),
            progress=note,
            tell=lambda line: print(line, file=sys.stderr),
        )
    first = next(mark for mark in marks if mark[0])
    last = marks[-1]
    done, wall, cpu, number = (b - a for a, b in zip(first, last, strict=True))
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
        "files": sum(len(names) for _, _, names in os.walk(folder / "out.zarr")),
    }


def main():
    if "--host" in sys.argv:
        hosted(sys.argv[sys.argv.index("--host") + 1 :])
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=200)
    parser.add_argument("--points", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=4.0, help="of a point")
    parser.add_argument("--for", dest="duration", type=float, default=60.0, help="seconds")
    options = parser.parse_args()
    keep_one_thread()
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(driven(Path(folder), options), indent=1))


if __name__ == "__main__":
    main()
