"""Compute a sweep in jobs of Slurm by dask-jobqueue, which knows PBS, LSF and others alike.

``pip install dask-jobqueue``, then
``python on_a_cluster.py scene.toml results/scene.zarr --jobs 50 --walltime "2 h" --dry-run``
What else a site needs stands in ``~/.config/dask/jobqueue.yaml``: interface, directives, prologue.
"""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import dask
from dask_jobqueue import SLURMCluster
from distributed import Client, Status

import pipeline
from tribo import TriboError

parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
parser.add_argument("scene")
parser.add_argument("store")
parser.add_argument("--jobs", type=int, default=10, help="at a time")
parser.add_argument("--cores", type=int, default=1, help="workers of a job, one a core")
parser.add_argument("--memory", default="2 GB", help="of a job")
parser.add_argument("--walltime", default="1 h", help="longer than any point takes: 2 h, 02:00:00")
parser.add_argument("--queue")
parser.add_argument("--account")
parser.add_argument("--dry-run", action="store_true", help="print the script of a job")


def seconds_of(walltime):
    """Read a duration such as 2 h or 02:00:00 in seconds; at least one minute."""
    if parts := re.fullmatch(r"(\d+):(\d\d):(\d\d)", walltime):
        hours, minutes, seconds = map(int, parts.groups())
        walltime_seconds = 3600 * hours + 60 * minutes + seconds
    else:
        walltime_seconds = round(pipeline.to_si(walltime, "2 h"))
    if walltime_seconds < 60:
        raise TriboError(f"--walltime {walltime}: a job takes at least 1 min")
    return walltime_seconds


def cluster_of(options):
    """Dask cluster with its scheduler in this process; workers are jobs, connections use TLS."""
    seconds = seconds_of(options.walltime)
    logs = Path(f"{options.store}.jobs")  # also holds certificates, so nodes must see it
    logs.mkdir(mode=0o700, parents=True, exist_ok=True)
    os.chdir(logs)  # as a blank in a path would break the script of a job
    # Workers retire before their job ends, each at another time, and hand on what they hold.
    working = seconds - 30  # [s]; a worker takes long to start on a busy node
    lifetime = ["--lifetime", f"{0.8 * working}s", "--lifetime-stagger", f"{0.1 * working}s"]
    return SLURMCluster(
        queue=options.queue, account=options.account, memory=options.memory,
        cores=options.cores, processes=options.cores,
        walltime=f"{seconds // 60}:{seconds % 60:02}", worker_extra_args=lifetime,
        security=True, protocol="tls://", shared_temp_directory=".", log_directory=".",
        python=shlex.quote(sys.executable), job_script_prologue=[f"cd {shlex.quote(str(logs))}"],
        death_timeout=120,  # [s] after which workers without a driver end
    )  # fmt: skip


def keep_up(cluster, jobs):
    """Submit a new job for each that has left the queue, until the cluster is closed."""
    while cluster.status == Status.running:
        known = {name: job.job_id for name, job in cluster.workers.items() if job.job_id}
        failed, queue = subprocess.getstatusoutput("squeue --noheader --me --format=%A")
        for name in [name for name in known if not failed and known[name] not in queue.split()]:
            cluster.workers.pop(name, None)
        cluster.scale(jobs=jobs)
        time.sleep(15.0)


def main(options):
    """Compute the sweep; return the exit status for the shell, or a message for a failure."""
    sweep = pipeline.load_scene(options.scene)
    if "://" not in options.store:
        options.store = Path(options.store).absolute()
    if not options.dry_run and not shutil.which("sbatch"):
        return "on_a_cluster.py: there is no Slurm here, no sbatch; --dry-run prints the job script"
    settings = {"distributed.scheduler.allowed-failures": 0}  # the run repeats lost points itself
    with dask.config.set(settings), cluster_of(options) as cluster, Client(cluster) as client:
        if options.dry_run:
            return print(cluster.job_script())
        threading.Thread(target=keep_up, args=(cluster, options.jobs), daemon=True).start()
        patience = 30 * 86400.0  # [s] that jobs may wait in the queue while there is no worker
        outcome = pipeline.run_sweep(
            sweep, options.store, client=client, progress=print, patience=patience
        )
    print(f"{outcome.done} of {outcome.total} points done", *outcome.failed, sep="\n")
    return bool(outcome.failed)


if __name__ == "__main__":
    try:
        sys.exit(main(parser.parse_args()))
    except TriboError as error:
        sys.exit(f"on_a_cluster.py: {error}")
