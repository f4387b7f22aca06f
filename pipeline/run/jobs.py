"""Workers that are jobs of a batch system."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.run.batch import Batch
from pipeline.run.source import ExecutionError

if TYPE_CHECKING:
    from pipeline.run.slurm import SlurmJobs


def job_script(batch: Batch, out: str) -> str:
    """Script of a job of the sweep with this store, without its address and certificates."""
    slurm, folder = _library(), batch.folder(out)
    there = folder.exists()
    try:
        return str(slurm.script_of(batch.options(_name(out), folder)))
    finally:
        if not there:  # made by dask-jobqueue
            with suppress(OSError):
                folder.rmdir()


def _name(out: str) -> str:
    return "irg-" + re.sub(r"[^\w-]+", "-", Path(out).stem)


def _library() -> Any:
    try:
        from pipeline.run import slurm
    except ModuleNotFoundError as error:
        raise ExecutionError(
            f"{error}: jobs are submitted by dask-jobqueue; pip install 'irg-transition[cluster]'"
        ) from None
    return slurm


@contextmanager
def jobs_of(batch: Batch, out: str, most: int | None) -> Iterator[SlurmJobs]:
    """Submit the jobs of a sweep, keep up their number, and cancel them in the end.

    There are as many as `most` workers fill, if it is known how many can be kept busy.
    """
    slurm, cores = _library(), batch.site.cores
    number = min(batch.jobs, -(-most // cores)) if most else batch.jobs
    with slurm.submitted(batch, number, _name(out), batch.folder(out)) as jobs:
        yield jobs
