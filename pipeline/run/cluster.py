"""Dask clusters: worker processes on this machine, or those of the caller's client."""

from __future__ import annotations

import gc
import json
import logging
import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing import forkserver, resource_tracker
from pathlib import Path

import dask
from distributed import Client, LocalCluster, Security
from distributed.utils import silence_logging_cmgr
from distributed.versions import VersionMismatchWarning

from pipeline.paths import read_file
from pipeline.progress import Progress, Report, silent
from pipeline.run.work import ExecutionError

PATIENCE = 30.0
"""Time to wait for an answer of the scheduler, and for a worker if there is none [s]."""

ENVIRONMENT = {
    # Dask's own thresholds return the memory of each FFT to the kernel, which takes longer than
    # the FFT. These settings replace all of Dask's, so the threads are stated again.
    "MALLOC_TRIM_THRESHOLD_": "268435456",
    "MALLOC_MMAP_THRESHOLD_": "67108864",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
"""Environment of the workers."""

CONFIGURATION = {
    "distributed.scheduler.allowed-failures": 0,  # the driver counts the workers lost by a point
    "distributed.scheduler.worker-ttl": "30s",  # a worker that hangs so long is started again
    "distributed.worker.multiprocessing-method": "forkserver",
    "distributed.nanny.pre-spawn-environ": ENVIRONMENT,
    # A worker that keeps using 80 % of its memory would be paused, and the run would never end.
    "distributed.worker.memory.pause": False,
    # Dask looks after itself every few milliseconds. On a machine that is busy with other programs,
    # this was a fifth of the CPU time of 12 × 30 points at `standard` (34.6 s, 26.8 s before).
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    # Every user of the machine could give commands by these routes.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.nanny.http.routes": [],
}
"""Dask's configuration of a cluster that a run starts, for the driver and its workers."""

_PRELOAD = ["distributed", "scipy.fft", "scipy.linalg", "scipy.special", "pipeline.run.work"]
_STATIC_ROUTES = ["distributed.http.statics"]  # files of the dashboard; they take no commands
_START_TIMEOUT = 120.0  # time that workers may take to start [s]
_CLOSE_TIMEOUT = 60.0  # time after which the processes of an ending cluster are killed [s]


@contextmanager
def connected(
    client: Client | None, workers: int, progress: Report = silent, dashboard: bool = False
) -> Iterator[Client]:
    """Context manager: yield `client`; if it is None, start workers and yield their client.

    `dashboard` reports the link of Dask's page on the progress of the workers, and serves the page
    of workers that were started here.
    """
    with ExitStack() as stack:
        # An interrupt in the middle of a call to Dask leaves coroutines behind.
        stack.enter_context(warnings.catch_warnings())
        warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
        if client is None:
            cluster = stack.enter_context(processes(workers, dashboard))
            client = stack.enter_context(Client(cluster, set_as_default=False))
        else:  # Otherwise Dask logs tracebacks.
            stack.enter_context(silence_logging_cmgr(logging.CRITICAL))
        if dashboard:
            progress(Progress(f"dashboard: {client.dashboard_link}"))
        yield client


@contextmanager
def processes(workers: int, dashboard: bool = False) -> Iterator[LocalCluster]:
    """Context manager: start worker processes on this machine, and yield their cluster.

    The connections of scheduler and workers use keys that no other user has. Dask starts others
    for workers that die.
    """
    routes = {"distributed.scheduler.http.routes": _STATIC_ROUTES if dashboard else []}
    with dask.config.set(CONFIGURATION | routes):
        start_forkserver()
        with _no_interrupts():
            try:
                cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    security=Security.temporary(),
                    death_timeout=_START_TIMEOUT,
                    dashboard_address="127.0.0.1:0",  # a free port, for the little that is served
                    scheduler_kwargs={"dashboard": dashboard},
                    silence_logs=logging.CRITICAL,
                )
            except (OSError, RuntimeError, AssertionError) as error:
                raise ExecutionError(
                    f"the worker processes did not start: {str(error) or 'none connected'}; "
                    "memory, threads or processes may be limited (ulimit -a): use fewer workers. "
                    'In a script, call run_sweep under if __name__ == "__main__":, because '
                    "workers import it"
                ) from None
            cluster.adapt(minimum=workers, maximum=workers)  # for workers that are lost for good
        try:
            yield cluster
        finally:
            with _no_interrupts():
                try:
                    cluster.close(timeout=_CLOSE_TIMEOUT)
                except (OSError, AssertionError):  # not in time, or a worker was just starting
                    for process in multiprocessing.active_children():
                        process.kill()  # or Python would wait for them when it ends


def start_forkserver() -> None:
    """Start the process from which workers are forked, which imports their packages once."""
    main = vars(sys.modules["__main__"])
    if not Path(main.get("__file__", "")).is_file():
        main.pop("__file__", None)  # "<stdin>" of python -, which workers would try to import
    multiprocessing.set_forkserver_preload(_PRELOAD)
    environment = dict(os.environ)
    # It imports from the folders of this process, not from the current folder.
    os.environ.update(ENVIRONMENT, PYTHONSAFEPATH="1", PYTHONPATH=os.pathsep.join(sys.path))
    try:
        with _no_interrupts():
            forkserver.ensure_running()
    finally:
        os.environ.clear()
        os.environ.update(environment)


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Context manager: delay a Ctrl-C to the end of the block.

    A terminal sends Ctrl-C to every process in the foreground. Threads and processes begun in the
    block never receive it, so that it stops only the driver.
    """
    # Before Python 3.13, starting the tracker unblocks SIGINT: start it before SIGINT is blocked.
    resource_tracker.ensure_running()
    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)


def client_of(
    address: str | None = None, file: Path | None = None, patience: float = PATIENCE
) -> Client:
    """Connect to a scheduler by its address or scheduler file.

    Raises an `ExecutionError` if no scheduler answers within `patience` [s].
    """
    try:
        if file is not None:  # Dask would wait for a missing file without end
            address = str(json.loads(read_file(file))["address"])
        with silence_logging_cmgr(logging.CRITICAL), warnings.catch_warnings():
            # Differences that matter are reported as a worker is checked.
            warnings.simplefilter("ignore", VersionMismatchWarning)
            return Client(address, set_as_default=False, timeout=patience)
    # A TypeError means that certificates are missing.
    except (OSError, ValueError, KeyError, RuntimeError, TypeError) as error:
        reason = f"no Dask scheduler answers at {address or file}: {error}"
    # Collect the incomplete client now. If it is collected while another client starts, it waits
    # for a lock of Dask that the other client has, and both wait for ever.
    gc.collect()
    raise ExecutionError(reason)
