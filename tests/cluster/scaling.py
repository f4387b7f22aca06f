"""How a sweep scales with workers: the rule of the driver, replayed with the costs of real points.

    OMP_NUM_THREADS=1 python -m tests.cluster.scaling irg_transition standard

Points at four velocities are computed here, one after the other: what an increment of a ramp takes
with its heat, and what the end of each load takes, in CPU time [s]. From these the queue of tasks,
`pipeline.sweep.task_queue`, is replayed without any cluster, so that no cores are needed: what
Dask, the network and the store take is left out. Beside it stand chains of loads, one worker each.
Prints a table in Markdown.
"""

import sys
import time

import numpy as np

import pipeline
from pipeline.sweep.model import Point
from pipeline.sweep.plan import points, tasks
from pipeline.sweep.task_queue import makespan
from pipeline.tradeoff.forecast import _count_steps
from tests.helpers.entries import changed
from tests.helpers.points import run_point
from tribo.simulation import Trunks

_WORKERS = (1, 2, 4, 8, 16, 64)
_VELOCITIES = (4, 19, 60)
_MEASURED = 4


def timed(sweep, point, trunks):
    """CPU time that a point takes [s]."""
    began = time.process_time()
    run_point(sweep, point, trunks)
    return time.process_time() - began


def costs_at(sweep, velocity):
    """CPU time [s] of an increment, and of the end of each load, at a velocity [m/s]."""
    *_, highest = sweep.loads
    trunks = Trunks()
    whole = timed(sweep, Point(highest, velocity), trunks)
    ends = {}
    for load in sweep.loads:
        timed(sweep, Point(load, velocity), trunks)  # on the load's own ramp, if it has one
        ends[load] = timed(sweep, Point(load, velocity), trunks)
    increments, *_ = _count_steps(sweep, highest)
    return (whole - ends[highest]) / increments, ends


def main():
    sweep = pipeline.load_scene(*sys.argv[1:])
    axis, loads = np.array(sweep.velocities), sweep.loads
    run_point(sweep, Point(loads[0], float(axis[0])))  # makes kernels and surfaces
    places = np.linspace(0, len(axis) - 1, _MEASURED).round().astype(int)
    known = {float(axis[place]): costs_at(sweep, float(axis[place])) for place in places}
    for velocity, (increment, ends) in known.items():
        print(f"{velocity:g} m/s: {1e3 * increment:.1f} ms an increment, ", end="")
        print(f"{1e3 * np.mean(list(ends.values())):.0f} ms an end")
    shared = {load: _count_steps(sweep, load)[0] for load in loads}

    def cost(task, has):
        load, velocity, _ = task.point
        increment, ends = known[min(known, key=lambda one: abs(one - velocity))]
        before = has.get(task.ramp, 0)
        has[task.ramp] = max(before, shared[load])
        return ends[load] + increment * max(0, shared[load] - before)

    print("| velocities × loads | workers | wall | gain | efficiency | CPU | chains: gain |")
    print("|---|---|---|---|---|---|---|")
    for count in _VELOCITIES:
        wanted = changed(sweep, velocities=tuple(np.linspace(axis[0], axis[-1], count).tolist()))
        every = [*tasks(points(wanted), wanted)]
        alone, cpu = makespan(every, 1, cost)
        chain = alone / count
        for workers in _WORKERS:
            wall, total = makespan(every, workers, cost)
            rounds = -(-count // workers)
            row = (
                f"{count} × {len(loads)}", f"{workers}", f"{wall:.1f} s", f"{alone / wall:.1f}",
                f"{100 * alone / wall / workers:.0f} %", f"{total / cpu:.2f}",
                f"{alone / (rounds * chain):.1f}",
            )  # fmt: skip
            print(f"| {' | '.join(row)} |")


if __name__ == "__main__":
    main()
