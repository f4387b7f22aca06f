"""Sources of workers: processes of this machine, or a cluster that others run.

::

    TriboError
    └── ExecutionError   the workers do not start, are lost, or run other code
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pipeline.run.forkserver import WORKER_ENVIRONMENT
from tribo import TriboError

SAFE = "finished points are safe, run the sweep again to go on"
PATIENCE = 30.0
"""Time to wait for a scheduler, and for workers if there are none [s]."""

CONFIGURATION = {
    # `pipeline.run.schedule` tries again the points of a dead worker, and spares bystanders.
    "distributed.scheduler.allowed-failures": 0,
    "distributed.worker.multiprocessing-method": "forkserver",
    "distributed.nanny.pre-spawn-environ": WORKER_ENVIRONMENT,
    # A worker that goes on holding 80 % of its memory would be paused, and the run never end.
    "distributed.worker.memory.pause": False,
    # Dask looks after itself every few milliseconds. On a machine that is busy with other programs,
    # this was a fifth of the CPU time of 12 × 30 points at `standard` (34.6 s, 26.8 s before).
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.large-graph-warning-threshold": "1 TB",
    # Anybody on the machine could give commands there.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.nanny.http.routes": [],
    # Dask gives up a worker that is away at this time after a death, although its nanny may just
    # be starting it again: with its 15 s, sweeps with deadly points ended without any worker.
    "distributed.deploy.lost-worker-timeout": "1000 days",
    # Dask would take heavy shared content from all workers but one: 24 tasks of 0.3 s then took
    # 3.0 s in place of 2.4.
    "distributed.scheduler.active-memory-manager.start": False,
}
"""Dask's configuration of a cluster that a run starts, for the driver and its workers."""
THREADS = 1
"""Threads of a worker."""
Tell = Callable[[str], None]


def unheard(line: str) -> None:
    """Show a line to nobody."""


class ExecutionError(TriboError):
    """Workers that do not start, are lost, or run other code.

    Examples
    --------
    >>> from pipeline.run.cluster import client_of
    >>> try:
    ...     client_of("tcp://127.0.0.1:1", patience=1.0)
    ... except ExecutionError:
    ...     print("nobody answers there")
    nobody answers there
    """


@dataclass(slots=True)
class Source:
    """Workers that others start: nothing to do about lost ones. `cluster` of Dask's has ours."""

    cluster: Any = None

    def keep(self) -> None:
        """Replace lost workers."""
