"""The options of ``irg`` on jobs of a batch system."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli.output import show
from pipeline.cli.scenes import given
from pipeline.run.batch import Batch
from pipeline.run.jobs import job_script
from tribo import InputError


def batch_of(options: argparse.Namespace) -> Batch | None:
    """Jobs in which to compute; None without a batch system.

    Raises
    ------
    InputError
        If options on jobs are given without one.
    """
    asked = given(options, "jobs", "walltime", "site")
    if options.cluster is not None:
        return pipeline.Batch(options.cluster, **asked)
    if asked or options.dry_run:
        name = f"--{next(iter(asked), 'dry-run')}"
        raise InputError(f"{name} is an option of jobs: give --cluster slurm, too")
    return None


def show_script(options: argparse.Namespace, batch: Batch, out: object) -> None:
    """Print the script of a job."""
    script = job_script(batch, str(out))
    show(options, {"script": script, "jobs": batch.jobs}, script.splitlines())
