"""The Dask cluster of a sweep: started here, or given.

::

    TriboError
    └── ExecutionError   the cluster does not start, or is lost
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import time
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from typing import Any

import dask
from distributed import Client, Future, LocalCluster, Status, versions, wait
from distributed.nanny import WorkerProcess
from distributed.scheduler import KilledWorker

from pipeline.run import forkserver
from pipeline.run.certificate import private_security
from pipeline.run.forkserver import METHOD, UNGUARDED, WORKER_ENVIRONMENT, interrupts_put_off
from pipeline.run.work import same
from tribo import TriboError

SAFE = "finished points are safe, run the sweep again to go on"
LOST = f"the Dask scheduler is lost; {SAFE}"

CONFIGURATION = {
    # What a dead worker leaves is tried again by `pipeline.run.schedule`, which tells bystanders.
    "distributed.scheduler.allowed-failures": 0,
    "distributed.worker.multiprocessing-method": METHOD,
    "distributed.nanny.pre-spawn-environ": WORKER_ENVIRONMENT,
    # Nothing here is worth a spill to disk, and a worker that pauses never ends.
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    # Nobody looks at a profile. To look after itself as often as it would, Dask takes 3 % of the
    # time of two cores.
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.large-graph-warning-threshold": "1 TB",
}
_LOCAL: dict[str, object] = {
    # Dask would take commands there from whoever else is on the machine.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.nanny.http.routes": [],
    # A nanny starts its worker again. Dask would take off who is away at this time after a loss,
    # and so, where workers die again and again, one that is just coming back.
    "distributed.deploy.lost-worker-timeout": "1000 days",
    # What workers share stays with all of them.
    "distributed.scheduler.active-memory-manager.start": False,
}
_THREADS = 2  # of a worker: while one waits for the disk, the other computes
_WORD = 10.0  # [s] without a worker, after which the user is told
_ATTEMPTS = 3  # to start workers, or to reach one, which may be killed meanwhile
# [s] after which a nanny looks again whether its worker has started. With Dask's 0.05 s it takes a
# worker that has died by then for the next one, which it is about to start.
_LOOK = 0.002
_START = 120.0  # [s] that a worker may take to start, after which its nanny is given up
_LIGHT = 8000  # bytes, of which a scheduler has room for as many as there are tasks
_COPIED = 1.0  # [s] for which to wait until each worker has a copy of what they share
_END = 60.0  # [s] that the cluster may take to end, after which its processes are killed
_UNSTARTED = "the worker processes do not start"
PATIENCE = 30.0
"""Time to wait for a scheduler, and for workers if there are none [s]."""


class ExecutionError(TriboError):
    """A cluster that does not start, or is lost."""


@contextmanager
def connected(workers: int, scheduler: str | None, patience: float) -> Iterator[Client]:
    """Connect to a scheduler, or start one with workers, and end those that were started.

    Raises
    ------
    ExecutionError
        If there is no scheduler, or the workers do not start.
    """
    if scheduler is not None:
        try:
            client = Client(scheduler, set_as_default=False, timeout=patience)
        except (OSError, ValueError, RuntimeError) as error:
            raise ExecutionError(f"no Dask scheduler answers at {scheduler}: {error}") from error
        except TypeError as error:  # as Dask has it
            raise ExecutionError(
                f"{scheduler} needs certificates: name the files under distributed.comm.tls in "
                "Dask's configuration, as DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
                "…__CLIENT__CERT and …__CLIENT__KEY do"
            ) from error
        with client, client.as_current(), _quiet_if_interrupted():
            yield client
        return
    cluster = None
    with dask.config.set({**CONFIGURATION, **_LOCAL}):
        try:
            forkserver.start()
            with interrupts_put_off(), _nothing_imported_for_the_forkserver():
                cluster = _local_cluster(workers)
            with (
                Client(cluster, set_as_default=False) as client,
                client.as_current(),
                _quiet_if_interrupted(),
            ):
                yield client
        finally:
            if cluster is not None:
                with interrupts_put_off():
                    _end(cluster)


def _end(cluster: LocalCluster) -> None:
    forkserver.wake()
    try:
        cluster.close(timeout=_END)
    except (OSError, AssertionError):
        # Not in time; or a connection broke that Ctrl-C had reached the other end of; or a worker
        # had died as soon as it had started, and the next one was just about to start.
        forkserver.wake()  # or Python itself waits for these processes in the end
        for process in multiprocessing.active_children():
            process.kill()


@contextmanager
def _quiet_if_interrupted() -> Iterator[None]:
    """Keep Python from complaining about the call to Dask that Ctrl-C broke off."""
    try:
        yield
    except KeyboardInterrupt:
        warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
        raise


@contextmanager
def _nothing_imported_for_the_forkserver() -> Iterator[None]:
    """Spare this process the packages that Dask imports only to name them to the forkserver.

    That is pandas, and 0.2 s of CPU time. It may go once Dask sees that the forkserver runs.
    """
    listed = versions.optional_packages[:]
    versions.optional_packages.clear()
    try:
        yield
    finally:
        versions.optional_packages.extend(listed)


def _local_cluster(workers: int) -> LocalCluster:
    WorkerProcess._init_msg_interval = _LOOK
    attempts = _ATTEMPTS
    while True:
        try:
            return LocalCluster(
                n_workers=workers,
                protocol="tls",
                security=private_security(),
                threads_per_worker=_THREADS,
                death_timeout=_START,
                # As it is now, and not as it was when the forkserver started.
                env={**os.environ, **WORKER_ENVIRONMENT},
                memory_limit=1 / workers,  # of all there is; by default it goes by the threads
                # No dashboard; a port of its own for the little that is served in its place.
                dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": False},
                silence_logs=logging.CRITICAL,
            )
        except (TimeoutError, AssertionError):  # the latter if one does not even begin
            raise ExecutionError(f"{_UNSTARTED}: there is none after {_START:g} s") from None
        except (OSError, RuntimeError) as error:
            if forkserver.script_starts_sweeps():
                raise ExecutionError(UNGUARDED) from None
            attempts -= 1
            if not attempts:
                raise ExecutionError(
                    f"{_UNSTARTED}: {error}; memory, threads or processes "
                    "may be limited (ulimit -a), and fewer workers take less of each"
                ) from error


def dashboard_of(client: Client, patience: float) -> str | None:
    """Address of the dashboard of a cluster that was given, if it has one.

    Raises
    ------
    ExecutionError
        If the scheduler is lost or does not answer.
    """
    if client.cluster is not None:
        return None
    with _losses_told():
        # As client.scheduler_info(), which may wait for ever.
        found = client.sync(client.scheduler.identity, callback_timeout=patience)
    return str(client.dashboard_link) if "dashboard" in found["services"] else None


def share(client: Client, content: bytes, patience: float) -> bytes | Future:
    """What to give to many tasks in place of something that all of them need.

    What is light goes along with each of them. Else it is brought to the workers once, as the
    result of a task, which outlives the workers that hold it. Every worker gets a copy, since Dask
    gives a task to a worker that has what it takes, even if others have nothing to do.

    Raises
    ------
    ExecutionError
        If there is no worker to take it, or none that can.
    """
    for _ in range(_ATTEMPTS):
        try:
            shared = client.submit(same, content, pure=False)
            error = shared.exception(timeout=patience)
        except TimeoutError:
            raise ExecutionError(f"no Dask worker is ready within {patience:g} s") from None
        except CancelledError:
            raise ExecutionError(LOST) from None
        if error is None:
            if len(content) <= _LIGHT:
                return content
            _copy_to_all(client, shared, patience)
            return shared
        if not isinstance(error, KilledWorker):  # it would be raised again
            break
    raise ExecutionError(f"the Dask workers cannot run this program: {error}")


def _copy_to_all(client: Client, shared: Future, patience: float) -> None:
    """Have each worker fetch something; one that is too busy does so with its first task."""
    with _losses_told(), suppress(TimeoutError):
        workers = client.nthreads(callback_timeout=patience)
        copies = [
            client.submit(same, shared, workers=worker, allow_other_workers=True, pure=False)
            for worker in workers
        ]
        wait(copies, timeout=_COPIED)


def threads_of(
    client: Client, patience: float, tell: Callable[[str], None] | None = None
) -> Counter[str]:
    """Number of threads of each worker; if there is no worker, wait for one to come back.

    Raises
    ------
    ExecutionError
        If the scheduler is lost or does not answer, or no worker comes back.
    """
    end = time.monotonic() + patience
    word = min(_WORD, patience / 2)
    while True:
        with _losses_told():
            threads = Counter(client.nthreads(callback_timeout=patience))
        if client.cluster is not None:
            _replace_lost(client.cluster)
        if threads:
            return threads
        left = end - time.monotonic()
        if left < 0:
            raise ExecutionError(f"no Dask worker is left, and none has come back; {SAFE}")
        if tell and word and left < patience - word:
            tell(f"no Dask worker is left; waiting up to {patience:g} s for one to come back")
            word = 0.0
        time.sleep(0.1)


def _replace_lost(cluster: LocalCluster) -> None:
    """Start a worker in place of each whose nanny could not start it again."""
    lost = [
        name
        for name, nanny in list(cluster.workers.items())
        if nanny.status in (Status.closed, Status.failed)
    ]
    for name in lost:
        del cluster.workers[name]
    if lost:
        cluster.scale(len(cluster.worker_spec))


def is_processed(client: Client, keys: Collection[str], patience: float) -> bool:
    """Whether a live worker has been given any of these tasks.

    Raises
    ------
    ExecutionError
        If the scheduler is lost or does not answer.
    """
    with _losses_told():
        # As client.processing(), which may wait for ever.
        processing = client.sync(client.scheduler.processing, callback_timeout=patience)
        return any(key in keys for given in processing.values() for key in given)


def wait_for_any(futures: Collection[Future], seconds: float) -> None:
    """Wait until one of these tasks ends, or a time has passed [s].

    Raises
    ------
    ExecutionError
        If the scheduler is lost.
    """
    if futures and not any(future.done() for future in futures):
        with _losses_told(), suppress(TimeoutError):
            wait(futures, timeout=seconds, return_when="FIRST_COMPLETED")


def gathered(future: Future, seconds: float) -> Any:
    """Result of a task that has ended; None if it does not arrive within a time [s].

    Raises
    ------
    ExecutionError
        If the scheduler is lost.
    """
    with _losses_told():
        try:
            return future.result(timeout=seconds)
        except (TimeoutError, KilledWorker):
            return None


@contextmanager
def _losses_told() -> Iterator[None]:
    try:
        yield
    except (CancelledError, OSError) as error:
        raise ExecutionError(LOST) from error
