"""Points in threads of one process, and in processes, against one after the other.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.threads irg_transition standard

All loads at one velocity are a piece of work. As many pieces as there are threads are done in them,
and as many in processes, in turns. Prints the median gain in wall time over one at a time; on a
machine that others use both lose, and their ratio says what threads cost.
"""

import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pipeline
from pipeline.sweep.model import Point
from pipeline.sweep.plan import run_points
from tests.helpers.entries import changed
from tribo.simulation import Trunks

_ROUNDS = 3


def piece(sweep, velocity):
    """Compute all loads at a velocity."""
    trunks = Trunks()
    for load in sweep.plane.loads:
        run_points(sweep, (Point(load, velocity),), trunks)


def seconds(pool, sweep, count):
    """Wall time of so many pieces, all at once [s]."""
    began = time.perf_counter()
    for work in [pool.submit(piece, sweep, 1.0 + 0.1 * number) for number in range(count)]:
        work.result()
    return time.perf_counter() - began


def main():
    name, preset = sys.argv[1:]
    sweep = pipeline.load_scene(name, preset)
    sweep = changed(sweep, loads=sweep.plane.loads[::3])
    for count in (2, 4):
        gains = {"threads": [], "processes": []}
        with ThreadPoolExecutor(count) as threads, ProcessPoolExecutor(count) as processes:
            for pool in (threads, processes):  # kernels and surfaces are made once
                seconds(pool, sweep, count)
            for _ in range(_ROUNDS):
                alone = seconds(threads, sweep, 1)
                for words, pool in (("threads", threads), ("processes", processes)):
                    gains[words].append(count * alone / seconds(pool, sweep, count))
        said = ", ".join(f"{words} {statistics.median(g):.2f}" for words, g in gains.items())
        print(f"{name}, {preset}, {count} at a time: {said}", flush=True)


if __name__ == "__main__":
    main()
