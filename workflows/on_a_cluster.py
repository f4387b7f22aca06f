"""Run a sweep in the jobs of a batch system, or resume it there.

::

    pip install dask-jobqueue
    python workflows/on_a_cluster.py SCENE.toml OUT.zarr --system slurm --jobs 50

Start it where jobs can be submitted and reached, such as a login node, inside `tmux` or in a job
of its own. It needs little more than a core. Jobs come and go as the queue has it; what is
finished is in OUT.zarr, which this program alone writes. Whatever ends it, start it again in the
same way to go on.

Settings of the site, such as its account and queue, are read from ``~/.config/dask/jobqueue.yaml``;
see https://jobqueue.dask.org. ``--system local`` tries everything out on this machine.
"""

import argparse
import importlib
import sys

import dask

import pipeline
from pipeline.run.cluster import CONFIGURATION, WORKER_ENVIRONMENT

SYSTEMS = {
    "slurm": "dask_jobqueue.SLURMCluster",
    "pbs": "dask_jobqueue.PBSCluster",
    "sge": "dask_jobqueue.SGECluster",
    "lsf": "dask_jobqueue.LSFCluster",
    "htcondor": "dask_jobqueue.HTCondorCluster",
    "local": "dask_jobqueue.local.LocalCluster",
}
A_DAY = 86400.0  # [s]


def cluster_of(system):
    """A cluster whose workers are jobs of one core each."""
    module, name = SYSTEMS[system].rsplit(".", 1)
    environment = " ".join(f"{key}={value}" for key, value in WORKER_ENVIRONMENT.items())
    return getattr(importlib.import_module(module), name)(
        cores=1, processes=1, memory="1 GB", python=f"env {environment} {sys.executable}"
    )


def main():
    """Run the sweep; exit with 1 if points failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", metavar="SCENE.toml")
    parser.add_argument("store", metavar="OUT.zarr")
    parser.add_argument("--system", choices=SYSTEMS, default="slurm")
    parser.add_argument("--jobs", type=int, default=10, help="at the same time, at most")
    options = parser.parse_args()
    sweep = pipeline.load_scene(options.scene)
    with dask.config.set(CONFIGURATION), cluster_of(options.system) as cluster:
        # As many as are asked for: fewer tasks wait than would make Dask start more jobs.
        cluster.adapt(minimum_jobs=options.jobs, maximum_jobs=options.jobs)
        outcome = pipeline.run_sweep(
            sweep,
            options.store,
            scheduler=cluster.scheduler_address,
            tell=print,
            patience=A_DAY,  # in the queue
        )
    print(f"{options.store}: {outcome.done} of {outcome.total} points done")
    for failed in outcome.failed:
        print(f"failed: {failed}")
    return 1 if outcome.failed else 0


if __name__ == "__main__":
    sys.exit(main())
