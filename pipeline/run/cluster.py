"""Dask clusters: worker processes on this machine, or those of a client that is given."""

from __future__ import annotations

import gc
import json
import logging
import math
import multiprocessing
import time
import warnings
from collections.abc import Collection, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import dask
from distributed import Client as Client
from distributed import LocalCluster, Security
from distributed.client import ClosedClientError
from distributed.scheduler import DEFAULT_EXTENSIONS
from distributed.utils import silence_logging_cmgr
from distributed.versions import VersionMismatchWarning

from pipeline.machine import oom_kills
from pipeline.paths import read_file
from pipeline.progress import Progress, Report, duration, silent
from pipeline.run import forkserver
from pipeline.run.forkserver import WORKER_ENVIRONMENT, block_interrupts
from pipeline.run.work import SAFE, ExecutionError

PATIENCE = 30.0
"""Time to wait for a scheduler, and for workers if there are none [s]."""

CONFIGURATION = {
    # `pipeline.run.schedule` itself tries the points of a dead worker again.
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
    # Anybody on the machine could give commands there.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.nanny.http.routes": [],
}
"""Dask's configuration of a cluster that a run starts, for the driver and its workers."""
POLL = 1.0
"""Time between two updates of the list of workers [s]."""
GONE = (CancelledError, OSError, ClosedClientError, AttributeError, RuntimeError)
"""Errors that Dask raises without a scheduler, the last three by a client that was closed."""
LOST = f"the Dask scheduler is lost; {SAFE}"

_START, _TRIES = 120.0, 3  # time that workers may take to start [s], and attempts
_END = 60.0  # time that the cluster may take to end [s], after which its processes are killed
WORD = 10.0
"""Time without a worker, or without news of any point, after which the user is told [s]."""
# The extension `spans` keeps 300 B for each task that has ever been.
_EXTENSIONS = {name: one for name, one in DEFAULT_EXTENSIONS.items() if name != "spans"}
_NO_WORKER = "there is no Dask worker"
_ADVICE = "take fewer workers, or fewer window.pixels"
_OF_DASHBOARD = ["distributed.http.statics"]  # files for its pages, and nothing that takes commands


@contextmanager
def processes(workers: int, dashboard: bool = False) -> Iterator[LocalCluster]:
    """Context manager: start worker processes on this machine, and yield their cluster.

    The connections of scheduler and workers use keys that no other user has. `dashboard` also
    serves Dask's page on the progress of the workers.
    """
    forkserver.start()
    with block_interrupts():
        cluster = _start_cluster(workers, dashboard)
    try:
        yield cluster
    finally:
        with block_interrupts():
            try:
                cluster.close(timeout=_END)
            except (OSError, AssertionError):  # not in time, or a worker was just starting
                for process in multiprocessing.active_children():
                    process.kill()  # or Python would wait for them when it ends


def _start_cluster(workers: int, dashboard: bool, tries: int = _TRIES) -> LocalCluster:
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            security=Security.temporary(),
            death_timeout=_START,
            dashboard_address="127.0.0.1:0",  # a free port, for the little that is served
            scheduler_kwargs={"dashboard": dashboard, "extensions": _EXTENSIONS},
            extensions={},
            silence_logs=logging.CRITICAL,
        )
    except (OSError, RuntimeError, AssertionError) as error:
        # If one worker is killed as it starts, all of them fail. If a worker has not even begun in
        # time, an assertion of Dask fails.
        if tries > 1 and not isinstance(error, TimeoutError | AssertionError):
            return _start_cluster(workers, dashboard, tries - 1)
        raise ExecutionError(
            f"the worker processes do not start within {_START:g} s: {str(error) or 'none came'}; "
            "memory, threads or processes may be limited (ulimit -a): take fewer workers; in a "
            'script, call run_sweep under if __name__ == "__main__":, since workers import it'
        ) from None


@dataclass
class Connection:
    """A Dask client, the list of its workers, and messages about them to the user.

    `patience` is how long to wait for an answer of the scheduler, or for a worker [s].
    """

    client: Client
    patience: float = PATIENCE  #: Time for answers, and for workers to come if there are none [s].
    progress: Report = silent
    cluster: LocalCluster | None = None  #: The cluster if it was started here.
    #: Number of threads of each worker that takes tasks, by address, at the last update.
    workers: dict[str, int] = field(default_factory=dict)
    _signs: dict[str, _Sign] = field(default_factory=dict)
    _reported: dict[str, float] = field(default_factory=dict)  # times of messages [s]
    _looked: float = -math.inf
    _seen: float = field(default_factory=time.monotonic)  # time when a worker last took tasks
    _kills: int = field(default_factory=oom_kills)

    def report(self, words: str, again: float = math.inf) -> None:
        """Report a message, unless it is empty or was reported in the last `again` seconds."""
        now = time.monotonic()
        if words and now - self._reported.get(words, -math.inf) >= again:
            self._reported[words] = now
            self.progress(Progress(words))

    @contextmanager
    def reached(self) -> Iterator[None]:
        """Context manager: turn errors of a lost scheduler into an `ExecutionError`.

        Before the block it waits, up to `patience`, for a client that is connecting again.
        """
        limit = time.monotonic() + self.patience
        while self.client.status == "connecting" and time.monotonic() < limit:
            time.sleep(0.1)  # the scheduler may be starting again
        try:
            yield
        except GONE as error:
            raise ExecutionError(LOST) from error

    def update(self) -> bool:
        """Update `workers`, at most once a second; return True if they were updated now.

        Raises an `ExecutionError` if the scheduler is lost, or no worker takes tasks for too long.
        """
        now = time.monotonic()
        if now - self._looked < POLL:
            return False
        self._looked = now
        self._look(now)
        if self.cluster:  # Dask replaces a worker only if asked, 15 s after its death
            self.cluster.scale(len(self.cluster.worker_spec))
        dask.utils.key_split.cache_clear()  # its cache has 240 B for each of the last 100 000 tasks
        patience, absent = duration(self.patience), now - self._seen
        wait = min(WORD, self.patience / 2)
        if not self.workers and absent >= self.patience:
            raise ExecutionError(f"{self._cause()}, and none has come within {patience}; {SAFE}")
        if not self.workers and absent >= wait:
            self.report(f"{self._cause()}; waiting up to {patience} for one")
        if self.workers and (idle := self._idle(now - wait)):
            self.report(f"{idle}; other workers compute on")
        return True

    def _look(self, now: float) -> None:
        """Ask the scheduler for its workers, and note which of them take tasks."""
        with self.reached():
            # Not by `Client.scheduler_info`, which waits without end for a scheduler that stands.
            asked = self.client.scheduler.identity
            found = self.client.sync(asked, n_workers=-1, callback_timeout=self.patience)["workers"]
        before, self._signs = self._signs, {}
        for address, one in found.items():
            sign = before.get(address)
            is_able = one["status"] == "running" and not (sign and sign.beat == one["last_seen"])
            since = now if is_able or sign is None else sign.since
            self._signs[address] = _Sign(one["status"], one["last_seen"], since)
        self.workers = {
            address: found[address]["nthreads"]
            for address, sign in self._signs.items()
            if sign.status == "running" and now - sign.since < WORD
        }
        self._seen = max([self._seen, *(sign.since for sign in self._signs.values())])

    def has(self, worker: str) -> bool:
        """True if a worker is there, and has not stood still or been paused for too long."""
        sign = self._signs.get(worker)
        return sign is not None and self._looked - sign.since < max(self.patience, 2 * WORD)

    def _cause(self) -> str:
        """Why no worker takes tasks, in words."""
        return f"no Dask worker takes tasks: {idle}" if (idle := self._idle()) else _NO_WORKER

    def _idle(self, since: float = math.inf) -> str:
        """Which workers take no tasks, from a time `since` or earlier on [s], and why, in words."""
        idle = {
            address: sign.status
            for address, sign in self._signs.items()
            if address not in self.workers and sign.since <= since
        }
        paused = {address for address, status in idle.items() if status == "paused"}
        causes = (
            (paused, "paused by Dask, for want of memory there"),
            (idle.keys() - paused, "silent, stopped or restarting"),
        )
        return ", ".join(f"{_named(some)} {why}" for some, why in causes if some)

    def report_wait(self, own: Collection[str]) -> None:
        """Report if tasks of others keep all threads of the workers; `own` are keys of this run."""
        with self.reached():
            asked = self.client.scheduler.processing
            found = self.client.sync(asked, workers=None, callback_timeout=self.patience)
        others = {address: len({*keys} - {*own}) for address, keys in found.items()}
        if all(others.get(address, 0) >= count for address, count in self.workers.items()):
            self.report(
                f"no Dask worker has a free slot: tasks of others ({sum(others.values())}) "
                "run or wait there, and points are computed after them"
            )

    def memory_cause(self, workers: Collection[str]) -> str:
        """Message that one of `workers` (addresses) was killed for lack of memory; else empty.

        Dask's nannies report which worker they killed. The kernel only counts the processes that it
        killed, so a new kill on this machine is taken for the cause.
        """
        with self.reached():
            events = self.client.get_events("worker-restart-memory")
        if any(event["worker"] in workers for _, event in events):
            return f"Dask ended it, since it held nearly all of its share of the memory; {_ADVICE}"
        if self.cluster and oom_kills() > self._kills:
            return f"the kernel has killed processes here for want of memory; {_ADVICE}"
        return ""


class _Sign(NamedTuple):
    """Last sign of life of a worker, and when it last was able to take tasks [s]."""

    status: str
    beat: float  # by the clock of the scheduler
    since: float


def _named(workers: Collection[str]) -> str:
    first = min(workers)
    return first + (f" and {len(workers) - 1} more are" if len(workers) > 1 else " is")


@contextmanager
def connected(
    client: Client | None,
    workers: int,
    patience: float = PATIENCE,
    progress: Report = silent,
    dashboard: bool = False,
) -> Iterator[Connection]:
    """Context manager: connect to the workers of a client, or start workers here.

    Workers that were started here are ended with the block. Raises an `ExecutionError` if they do
    not start. `patience` is how long to wait for an answer of the scheduler, or for a worker [s].
    `dashboard` reports the link of Dask's page on the progress of the workers, and serves the page
    of workers that were started here.
    """
    with ExitStack() as stack:
        cluster = None
        if client is None:
            routes = {"distributed.scheduler.http.routes": _OF_DASHBOARD if dashboard else []}
            stack.enter_context(dask.config.set(CONFIGURATION | routes))
            cluster = stack.enter_context(processes(workers, dashboard))
            client = stack.enter_context(Client(cluster, set_as_default=False))
        else:
            # Otherwise Dask logs tracebacks.
            stack.enter_context(silence_logging_cmgr(logging.CRITICAL))
        stack.enter_context(client.as_current())
        if dashboard:
            progress(Progress(f"dashboard: {client.dashboard_link}"))
        # An interrupt in the middle of a call to Dask leaves coroutines behind.
        warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
        yield Connection(client, patience, progress, cluster)


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
            # Differences that matter are reported with the first point of such a worker.
            warnings.simplefilter("ignore", VersionMismatchWarning)
            return Client(address, set_as_default=False, timeout=patience)
    # A TypeError means that certificates are missing.
    except (OSError, ValueError, KeyError, RuntimeError, TypeError) as error:
        reason = f"no Dask scheduler answers at {address or file}: {error}"
    # Collect now: a half-made client that is collected while the next one starts takes a lock of
    # Dask's that the next one holds, and both wait for ever.
    gc.collect()
    raise ExecutionError(reason)
