"""How a sweep scales with workers: the rule of the driver, replayed with the costs of real points.

    OMP_NUM_THREADS=1 python -m tests.cluster.scaling irg_transition standard

Points at four velocities are computed here, one after the other: what an increment of a ramp takes
with its heat, and what the end of each load takes, in CPU time [s]. From these the queue of tasks,
`pipeline.sweep.task_queue`, is replayed without any cluster, so that no cores are needed: what
Dask, the network and the store take is left out. Beside it stand chains of loads, one worker each.
Prints a table in Markdown.
"""

import time

from pipeline.sweep.plan import run_point

_WORKERS = (1, 2, 4, 8, 16, 64)
_VELOCITIES = (4, 19, 60)
_MEASURED = 4


def timed(sweep, point, trunks):
    """CPU time that a point takes [s]."""
    began = time.process_time()
    run_point(sweep, point, trunks)
    return time.process_time() - began


if __name__ == "__main__":
    main()
