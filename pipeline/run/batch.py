"""Jobs of a batch system that a run asks for."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.run.site import SAFE, Site, site_of
from pipeline.run.source import THREADS
from pipeline.scene.quantities import in_si, require_count
from tribo import InputError

SYSTEMS = ("slurm",)
"""Batch systems that a run can submit jobs to."""
_SHORTEST = 60.0  # [s] of a walltime
_STAGGER = 0.1  # of the walltime, by which jobs end sooner or later at random
_SPARE = 0.1, 300.0  # of the walltime, and [s] at most, for the start and the end of a job
_UNREACHED = 120  # [s] after which a job ends whose driver does not answer


@dataclass(frozen=True, slots=True, init=False)
class Batch:
    """Jobs of a batch system that compute a sweep.

    Parameters
    ----------
    system : str
        Batch system: slurm.
    jobs : int
        Number of jobs at the same time, at most.
    walltime : float or str
        Time that a job may take, at least a minute [s]; or text such as "2 h".
    site : Site, str or path, optional
        Options of the site, or the file that gives them.

    Raises
    ------
    InputError
        If any of these is not allowed.

    Examples
    --------
    >>> batch = Batch("slurm", jobs=50, walltime="2 h", site=Site(cores=4, queue="long"))
    >>> batch.walltime, batch.life, batch.stagger
    (7200.0, 6180.0, 720.0)
    """

    system: str
    jobs: int
    walltime: float
    site: Site

    def __init__(
        self,
        system: str = "slurm",
        jobs: int = 10,
        walltime: float | str = 3600.0,
        site: Site | str | os.PathLike[str] | None = None,
    ) -> None:
        if system not in SYSTEMS:
            raise InputError(f"the batch system is {system!r}; give {', '.join(SYSTEMS)}")
        require_count("jobs", jobs)
        seconds = in_si("walltime", walltime, "2 h")
        if not _SHORTEST <= seconds < float("inf"):
            raise InputError(f"walltime is {seconds:g} s; it must be at least 1 min")
        site = Site() if site is None else site
        fields = {
            "system": system,
            "jobs": jobs,
            "walltime": seconds,
            "site": site if isinstance(site, Site) else site_of(Path(site)),
        }
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    @property
    def stagger(self) -> float:
        """Time by which a job may end sooner or later than others [s]."""
        return _STAGGER * self.walltime

    @property
    def life(self) -> float:
        """Time for which a worker computes, in the mean [s]."""
        share, most = _SPARE
        return self.walltime - self.stagger - min(share * self.walltime, most)

    def folder(self, out: str) -> Path:
        """Folder of the logs and certificates of a sweep with this store."""
        if self.site.folder is None and "://" in out:
            raise InputError(f"{out} has no folder beside it: give one as folder in --site")
        folder = Path(self.site.folder or f"{out}.jobs").absolute()
        if not SAFE.fullmatch(str(folder)):
            raise InputError(
                f"the logs would go to {str(folder)!r}, and a job script takes letters, digits and "
                "@+=:,./_- alone: give another folder in --site"
            )
        return folder

    def options(self, name: str, folder: Path) -> dict[str, Any]:
        """Options of a job, by the names that dask-jobqueue gives them."""
        site, (seconds, minutes) = self.site, (int(self.walltime) % 60, int(self.walltime) // 60)
        python = shlex.quote(site.python or sys.executable)
        return {
            "job_name": name,
            "cores": site.cores,
            "processes": site.cores,
            "memory": site.memory or f"{site.cores} GiB",
            "queue": site.queue,
            "account": site.account,
            "walltime": f"{minutes // 60:02}:{minutes % 60:02}:{seconds:02}",
            "job_extra_directives": list(site.directives),
            "job_script_prologue": list(site.prologue),
            "interface": site.interface,
            "local_directory": site.scratch,
            "log_directory": str(folder),
            "death_timeout": _UNREACHED,
            "python": f"{python} -P",  # no module of the folder where a user happens to be
            "worker_command": "pipeline.run.job",
            "worker_extra_args": [
                *("--nworkers", str(site.cores), "--nanny", "--nthreads", str(THREADS)),
                "--no-dashboard",
                *("--lifetime", f"{self.life:.0f}s", "--lifetime-stagger", f"{self.stagger:.0f}s"),
            ],
        }
