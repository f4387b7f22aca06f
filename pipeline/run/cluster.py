"""The Dask cluster of a sweep: started here, or already running elsewhere.

::

    TriboError
    └── ExecutionError   the cluster does not start, is lost, or runs other code
"""

from __future__ import annotations

import gc
import logging
import multiprocessing
import time
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from typing import Any
from weakref import WeakKeyDictionary

import dask
from distributed import Client, Future, LocalCluster, Security, Status, wait
from distributed.scheduler import KilledWorker
from distributed.utils import silence_logging_cmgr

from pipeline.run import forkserver
from pipeline.run.forkserver import UNGUARDED, WORKER_ENVIRONMENT, interrupts_put_off
from pipeline.run.versions import Versions, other_packages, versions
from tribo import TriboError

SAFE = "finished points are safe, run the sweep again to go on"
LOST = f"the Dask scheduler is lost; {SAFE}"
_INSTALL = f"install the same version in both places and restart the workers; {SAFE}"
_UNSTARTED = "the worker processes do not start"
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
}
_LOCAL: dict[str, object] = {
    # Anybody on this machine could give commands there.
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
_THREADS = 2  # of a worker: while one waits, the other computes
_WORD = 10.0  # [s] without a worker, after which the user is told
_ATTEMPTS = 3  # to start workers, or to reach one, which may be killed meanwhile
_START = 120.0  # [s] that the workers may take to start
_END = 60.0  # [s] that the cluster may take to end, after which its processes are killed
_ANSWER = 10.0  # [s] that a worker may take to tell its versions
_LIGHT = 8000  # bytes, of which a scheduler has room for as many as there are tasks
_COPIED = 1.0  # [s] to wait until each worker has a copy of the shared content
_asked: WeakKeyDictionary[Client, dict[str, Versions | None]] = WeakKeyDictionary()


class ExecutionError(TriboError):
    """A cluster that does not start, is lost, or runs other code."""


@contextmanager
def connected(workers: int, scheduler: str | None, patience: float) -> Iterator[Client]:
    """Connect to a scheduler, or start one with workers, and end those that were started.

    Raises
    ------
    ExecutionError
        If there is no scheduler, or the workers do not start.
    """
    with ExitStack() as stack:
        if scheduler is None:
            stack.enter_context(dask.config.set({**CONFIGURATION, **_LOCAL}))
            cluster = stack.enter_context(_local_cluster(workers))
            client = Client(cluster, set_as_default=False)
        else:
            stack.enter_context(silence_logging_cmgr(logging.CRITICAL))  # it logs tracebacks
            client = _client_of(scheduler, patience)
        stack.enter_context(client)
        stack.enter_context(client.as_current())
        try:
            yield client
        except KeyboardInterrupt:  # in the middle of a call to Dask
            warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
            raise


def _client_of(scheduler: str, patience: float) -> Client:
    try:
        return Client(scheduler, set_as_default=False, timeout=patience)
    except (OSError, ValueError, RuntimeError) as error:
        reason = f"no Dask scheduler answers at {scheduler}: {error}"
    except TypeError:  # as Dask has it
        reason = (
            f"{scheduler} needs certificates: name the files under distributed.comm.tls in "
            "Dask's configuration, as DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
            "…__CLIENT__CERT and …__CLIENT__KEY do"
        )
    # Now: a client that was only half made, and is collected while the next one starts, takes a
    # lock of Dask's that this one holds, and both wait for ever.
    gc.collect()
    raise ExecutionError(reason)


@contextmanager
def _local_cluster(workers: int) -> Iterator[LocalCluster]:
    forkserver.start()
    with interrupts_put_off():
        cluster = _started(workers)
    try:
        yield cluster
    finally:
        with interrupts_put_off():
            try:
                cluster.close(timeout=_END)
            except (OSError, AssertionError):  # not in time, or a worker was just starting
                for process in multiprocessing.active_children():
                    process.kill()  # or Python would wait for them in the end


def _started(workers: int, attempts: int = _ATTEMPTS) -> LocalCluster:
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=_THREADS,
            security=Security.temporary(),
            death_timeout=_START,
            dashboard_address="127.0.0.1:0",  # a free port, for the little that is served
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.CRITICAL,
        )
    except (TimeoutError, AssertionError):  # the latter if a process has not even begun
        raise ExecutionError(f"{_UNSTARTED}: none has after {_START:g} s") from None
    except (OSError, RuntimeError) as error:
        if attempts > 1:  # one that is killed as it starts fails all of them
            return _started(workers, attempts - 1)
        raise ExecutionError(
            f"{_UNSTARTED}: {error}; memory, threads or processes may be limited (ulimit -a): "
            f"take fewer workers; {UNGUARDED}"
        ) from None


def dashboard_of(client: Client, patience: float) -> str | None:
    """Address of the dashboard of a cluster that runs elsewhere, if it has one.

    Raises
    ------
    ExecutionError
        If the scheduler is lost or does not answer.
    """
    if client.cluster is not None:
        return None
    with _losses_told():
        # As client.scheduler_info(), which may wait for ever.
        identity = client.sync(client.scheduler.identity, callback_timeout=patience)
    return str(client.dashboard_link) if "dashboard" in identity["services"] else None


def share(client: Client, content: bytes, patience: float) -> bytes | Future:
    """Content for many tasks: itself if it is light, else a result that every worker holds.

    Light content goes along with each task. Heavy content is the result of a task, which Dask
    computes again if the workers that hold it die.

    Raises
    ------
    ExecutionError
        If no worker is ready, or none can run this program.
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


def same(content: bytes) -> bytes:
    """The argument, as the result of a task."""
    return content


def _copy_to_all(client: Client, shared: Future, patience: float) -> None:
    """Copy it to every worker: Dask prefers workers that hold a task's inputs."""
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
        If the scheduler is lost or does not answer, no worker comes back, or a worker that has
        joined runs other code.
    """
    end = time.monotonic() + patience
    word = min(_WORD, patience / 2)
    while True:
        with _losses_told():
            threads = Counter(client.nthreads(callback_timeout=patience))
        if client.cluster is not None:
            _replace_lost(client.cluster)
        if threads:
            _ask(client, threads, tell)
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


def _ask(
    client: Client, workers: Collection[str], tell: Callable[[str], None] | None = None
) -> None:
    """Ask workers that have joined for their versions, once; refuse those with other code."""
    asked = _asked.setdefault(client, {})
    if not (new := [worker for worker in workers if worker not in asked]):
        return
    asked.update(dict.fromkeys(new))
    answers: dict[str, Any] = {}
    with _losses_told(), suppress(TimeoutError):  # of one that is frozen, results are refused
        answers = client.sync(
            client.run, versions, workers=new, on_error="return", callback_timeout=_ANSWER
        )
    differences = {other_packages(theirs) for theirs in asked.values() if theirs}
    for worker, answer in answers.items():
        if isinstance(answer, OSError):  # it has died meanwhile
            continue
        if isinstance(answer, Exception):
            raise ExecutionError(
                f"the Dask worker {worker} cannot run this program: {answer}; {_INSTALL}"
            )
        require_same_code(answer, worker)
        asked[worker] = answer
        difference = other_packages(answer)
        if tell and difference and difference not in differences:
            tell(f"the Dask worker {worker} has {difference}: last digits may differ there")
        differences.add(difference)


def require_same_code(theirs: Versions, worker: str) -> None:
    """Refuse a worker with other code than this process.

    Raises
    ------
    ExecutionError
        If the code differs.
    """
    if theirs["code"] != (ours := versions())["code"]:
        raise ExecutionError(
            f"the Dask worker {worker} runs code {theirs['code']} of tribo and pipeline from "
            f"{theirs['folder']}, and this program code {ours['code']} from {ours['folder']}; "
            f"{_INSTALL}"
        )


def is_processed(client: Client, keys: Collection[str], patience: float) -> bool:
    """Presence of any of these tasks on a live worker.

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
