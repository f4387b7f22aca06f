"""The Dask cluster of a sweep: started here, or given.

::

    TriboError
    └── ExecutionError   the cluster does not start, or is lost
"""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker

import dask
from distributed import Client, Future, LocalCluster

from tribo import TriboError

__all__ = [
    "CONFIGURATION",
    "LOST",
    "PATIENCE",
    "WORKER_ENVIRONMENT",
    "ExecutionError",
    "connected",
    "dashboard_of",
    "share",
    "threads_of",
]

LOST = "the Dask scheduler is lost; finished points are safe, run the sweep again to go on"

WORKER_ENVIRONMENT = {
    # Dask's own thresholds return each FFT's memory to the kernel, which takes longer than the
    # FFT. What is set in Dask's configuration replaces all of it, so the threads are stated again.
    "MALLOC_TRIM_THRESHOLD_": 268435456,
    "MALLOC_MMAP_THRESHOLD_": 67108864,
    "OMP_NUM_THREADS": 1,
    "MKL_NUM_THREADS": 1,
    "OPENBLAS_NUM_THREADS": 1,
}
"""For workers that are started elsewhere, too."""

CONFIGURATION = {
    # A task is given up when a second worker has died of it.
    "distributed.scheduler.allowed-failures": 1,
    "distributed.nanny.pre-spawn-environ": WORKER_ENVIRONMENT,
    # Nothing here is worth a spill to disk, and a worker that pauses never ends.
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.admin.large-graph-warning-threshold": "1 TB",
}
_ATTEMPTS = 3  # to start workers, one of which may be killed before it is ready
PATIENCE = 30.0
"""For how long to wait for a scheduler, and for workers if there are none [s]."""


class ExecutionError(TriboError):
    """A cluster that does not start, or is lost."""


@contextmanager
def connected(workers: int, scheduler: str | None, patience: float) -> Iterator[Client]:
    """Connect to a scheduler, or start one with workers and see to it that all of them end.

    Raises
    ------
    ExecutionError
        If there is no scheduler, or the workers do not start.
    """
    if scheduler is not None:
        try:
            client = Client(scheduler, set_as_default=False, timeout=patience)
        except (OSError, ValueError) as error:
            raise ExecutionError(f"no Dask scheduler answers at {scheduler}: {error}") from error
        with client:
            yield client
        return
    cluster = None
    with dask.config.set(CONFIGURATION):
        try:
            with _interrupts_put_off():
                cluster = _local_cluster(workers)
            with Client(cluster, set_as_default=False) as client:
                yield client
        finally:
            if cluster is not None:
                with _interrupts_put_off():
                    cluster.close()


def _local_cluster(workers: int) -> LocalCluster:
    for _ in range(_ATTEMPTS - 1):
        with suppress(ExecutionError):
            return _started(workers)
    return _started(workers)


def _started(workers: int) -> LocalCluster:
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            # No dashboard; a port of its own for the little that is served in its place.
            dashboard_address="127.0.0.1:0",
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.CRITICAL,
        )
    except (OSError, RuntimeError) as error:
        raise ExecutionError(f"the worker processes do not start: {error}") from error


def dashboard_of(client: Client) -> str | None:
    """Address of the cluster's dashboard, if it has one."""
    has_one = "dashboard" in client.scheduler_info(n_workers=0)["services"]
    return str(client.dashboard_link) if has_one and client.cluster is None else None


def share(client: Client, content: bytes, patience: float) -> Future:
    """Bring something to the workers once, for many tasks to take as an argument.

    As the result of a task it outlives the workers that hold it.

    Raises
    ------
    ExecutionError
        If there is no worker to take it, or none that can.
    """
    try:
        client.wait_for_workers(1, timeout=patience)
        shared = client.submit(_same, content, pure=False)
        error = shared.exception(timeout=patience)
    except TimeoutError:
        raise ExecutionError(f"no Dask worker is ready within {patience:g} s") from None
    except CancelledError:
        raise ExecutionError(LOST) from None
    if error is not None:
        raise ExecutionError(f"the Dask workers cannot run this program: {error}")
    return shared


def _same(content: bytes) -> bytes:
    return content


def threads_of(client: Client, patience: float) -> Counter[str]:
    """Number of threads of each worker; if there is no worker, wait for one to come back.

    Raises
    ------
    ExecutionError
        If the scheduler is lost, or no worker comes back.
    """
    end = time.monotonic() + patience
    while True:
        try:
            threads = Counter(client.nthreads())
        except (OSError, CancelledError, TimeoutError) as error:
            raise ExecutionError(LOST) from error
        if threads:
            return threads
        if time.monotonic() > end:
            raise ExecutionError("no Dask worker is left, and none has come back")
        time.sleep(0.1)


@contextmanager
def _interrupts_put_off() -> Iterator[None]:
    """Let Ctrl-C wait until the end.

    Threads that begin in here, and the processes that these start, inherit that SIGINT is
    blocked. So a Ctrl-C in a terminal, which goes to every process of the foreground, stops the
    driver alone, and not a worker that may be just starting.
    """
    waiting: list[int] = []
    in_main_thread = threading.current_thread() is threading.main_thread()
    resource_tracker.ensure_running()  # unblocks SIGINT where it is started, before Python 3.13
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    if in_main_thread:
        handler = signal.signal(signal.SIGINT, lambda number, _: waiting.append(number))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if in_main_thread:
            signal.signal(signal.SIGINT, handler)
        if waiting:
            signal.raise_signal(signal.SIGINT)
