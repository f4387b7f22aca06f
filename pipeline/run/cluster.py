"""Dask clusters: worker processes on this machine, or those of the caller's client.

`Watch` looks after the workers of a run: which of them take tasks, and their program.
"""

from __future__ import annotations

import gc
import json
import logging
import multiprocessing
import os
import signal
import sys
import time
import warnings
from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import forkserver, resource_tracker
from pathlib import Path
from typing import Any

import dask
from distributed import Client, LocalCluster, Security
from distributed.client import ClosedClientError
from distributed.utils import silence_logging_cmgr
from distributed.versions import VersionMismatchWarning

from pipeline.paths import read_file
from pipeline.progress import Progress, Report, duration, silent
from pipeline.run.work import PROGRAM, ExecutionError, Program, program

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


SAFE = "finished points are saved; run the sweep again to continue"
POLL = 1.0
"""Time between two looks [s]."""
CANNOT = "a Dask worker cannot run this program"

_INSTALL = f"install the same version on both sides and restart the workers; {SAFE}"
_LOST = f"the connection to the Dask scheduler is lost; {SAFE}"
_ANSWER_TIMEOUT = 5.0  # time for a worker to send the identity of its program [s]
_NOTE_AFTER = 10.0  # time after which a note reports that there is no worker [s]
# Errors that Dask raises without a scheduler, the last three by a client that was closed.
_LOST_ERRORS = (CancelledError, OSError, ClosedClientError, AttributeError, RuntimeError)


class Watch:
    """Looks at the workers of a client, at most once a second.

    `patience` is how long to wait for an answer of the scheduler, or for a worker [s].
    """

    def __init__(
        self, client: Client, patience: float, report: Report, is_own: bool = False
    ) -> None:
        self._client, self._patience, self._report = client, patience, report
        self._reported: set[str] = set()
        self._next_look, self._last_running = 0.0, time.monotonic()
        self._workers: list[str] = []
        self._folders: dict[str, str] = {}
        self._checked: set[str] = set()
        self._is_own = is_own  # then workers run this program, on this machine

    def __call__(self) -> list[str]:
        """Addresses of the workers that take tasks.

        Raises an `ExecutionError` if the scheduler is lost, no worker takes tasks for too long, or
        one cannot run this program.
        """
        if (now := time.monotonic()) < self._next_look:
            return self._workers
        with self.reached():
            ask = self._client.scheduler.identity
            # `Client.scheduler_info` would wait without end for a scheduler that does not answer.
            infos = self._client.sync(ask, n_workers=-1, callback_timeout=self._patience)["workers"]
        self._folders = {worker: info["local_directory"] for worker, info in infos.items()}
        self._workers = [worker for worker, info in infos.items() if info["status"] == "running"]
        if self._workers:
            self._last_running = now
        else:
            self._wait_for_worker(infos, now - self._last_running)
        if not self._is_own:
            self._check(sorted({*self._workers} - self._checked))
        self._next_look = time.monotonic() + POLL
        return self._workers

    def _wait_for_worker(self, workers: Collection[str], waited: float) -> None:
        """Report that no worker takes tasks; `ExecutionError` if it `waited` too long [s]."""
        reason = f"{', '.join(sorted(workers)) or 'there is none'}"
        if waited > self._patience:
            limit = duration(self._patience)
            raise ExecutionError(f"no Dask worker accepts tasks within {limit} ({reason}); {SAFE}")
        if waited > min(_NOTE_AFTER, self._patience / 2):
            self.report_once(f"no Dask worker accepts tasks ({reason}); waiting for one")

    @property
    def processes(self) -> Mapping[str, str]:
        """Folder of each connected worker, by its address; a restarted worker has another one."""
        return self._folders

    def _check(self, workers: list[str]) -> None:
        """Require that workers can import this program; otherwise they drop all their tasks."""
        if not self._checked:
            self._check_scheduler()
        answers: dict[str, Any] = {}
        if workers:
            # After a TimeoutError a worker has died; the next call asks the others.
            with self.reached(), suppress(TimeoutError):
                answers = self._client.sync(
                    self._client.run,
                    program,
                    workers=workers,
                    on_error="return",
                    callback_timeout=_ANSWER_TIMEOUT,
                )
        for worker, answer in answers.items():
            if isinstance(answer, OSError):
                continue
            if isinstance(answer, Exception):
                raise ExecutionError(f"{CANNOT}: {answer} ({worker}); {_INSTALL}")
            self.require_program(answer, worker)
            self._checked.add(worker)

    def _check_scheduler(self) -> None:
        """Require that the scheduler can import this program: it reads the tasks."""
        with self.reached():
            try:
                ask = self._client.run_on_scheduler
                self._client.sync(ask, program, callback_timeout=self._patience)
            except (ImportError, AttributeError) as error:
                if self._client.status != "running":  # the error is that of a closed client
                    raise
                where = f"the Dask scheduler cannot read tasks of this program: {error}"
                raise ExecutionError(f"{where}; {_INSTALL}") from None

    def require_program(self, answer: Program, worker: str = "a Dask worker") -> None:
        """Raise an `ExecutionError` if a worker has other code; tell of other versions."""
        if answer.code != PROGRAM.code:
            raise ExecutionError(
                f"{worker} has another version of tribo and pipeline (hash {answer.code}) than "
                f"this program ({PROGRAM.code}); {_INSTALL}"
            )
        if answer != PROGRAM:
            self.report_once(
                f"{worker} computes with {answer.versions} instead of {PROGRAM.versions}; "
                "last digits may differ"
            )

    def cpu_time(self) -> float:
        """Processor time of the connected workers [s]; 0 if they do not answer."""
        with suppress(TimeoutError, *_LOST_ERRORS):
            times = self._client.sync(
                self._client.run,
                time.process_time,
                on_error="ignore",
                callback_timeout=_ANSWER_TIMEOUT,
            )
            return float(sum(times.values()))
        return 0.0

    def look_again(self) -> None:
        """Make the next call ask the scheduler, whenever the last one did."""
        self._next_look = 0.0

    def report_once(self, words: str) -> None:
        """Report a message to the user once."""
        if words not in self._reported:
            self._reported.add(words)
            self._report(Progress(words))

    @contextmanager
    def reached(self) -> Iterator[None]:
        """Context manager: turn errors of a lost scheduler into an `ExecutionError`.

        Before the block it waits, up to `patience`, for a client that is connecting again.
        """
        limit = time.monotonic() + self._patience
        while self._client.status == "connecting" and time.monotonic() < limit:
            time.sleep(0.1)  # the scheduler may be starting again
        try:
            yield
        except _LOST_ERRORS as error:
            raise ExecutionError(_LOST) from error
