"""Workers that are processes of this machine."""

from __future__ import annotations

import logging
import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager

from distributed import LocalCluster, Security, Status

from pipeline.run import forkserver
from pipeline.run.forkserver import UNGUARDED, interrupts_put_off
from pipeline.run.source import THREADS, ExecutionError, Source

_UNSTARTED = "the worker processes do not start"
_ATTEMPTS = 3  # to start workers, one of which may be killed meanwhile
_START = 120.0  # [s] that the workers may take to start
_END = 60.0  # [s] that the cluster may take to end, after which its processes are killed


class Processes(Source):
    """Processes of this machine, each with a nanny that starts it again."""

    def keep(self) -> None:
        """Start a worker in place of each whose nanny could not start it again."""
        lost = [
            name
            for name, nanny in list(self.cluster.workers.items())
            if nanny.status in (Status.closed, Status.failed)
        ]
        for name in lost:
            del self.cluster.workers[name]
        if lost:
            self.cluster.scale(len(self.cluster.worker_spec))


@contextmanager
def processes(workers: int, dashboard: bool = False) -> Iterator[Processes]:
    """Start worker processes, which talk on loopback and to this user alone, and end them."""
    forkserver.start()
    with interrupts_put_off():
        cluster = _started(workers, dashboard)
    try:
        yield Processes(cluster)
    finally:
        with interrupts_put_off():
            try:
                cluster.close(timeout=_END)
            except (OSError, AssertionError):  # not in time, or a worker was just starting
                for process in multiprocessing.active_children():
                    process.kill()  # or Python would wait for them in the end


def _started(workers: int, dashboard: bool, attempts: int = _ATTEMPTS) -> LocalCluster:
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=THREADS,
            security=Security.temporary(),
            death_timeout=_START,
            dashboard_address="127.0.0.1:0",  # a free port, for the little that is served
            scheduler_kwargs={"dashboard": dashboard},
            silence_logs=logging.CRITICAL,
        )
    except (TimeoutError, AssertionError):  # the latter if a process has not even begun
        raise ExecutionError(f"{_UNSTARTED}: none has after {_START:g} s") from None
    except (OSError, RuntimeError) as error:
        if attempts > 1:  # one that is killed as it starts fails all of them
            return _started(workers, dashboard, attempts - 1)
        raise ExecutionError(
            f"{_UNSTARTED}: {error}; memory, threads or processes may be limited (ulimit -a): "
            f"take fewer workers; {UNGUARDED}"
        ) from None
