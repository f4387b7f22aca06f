"""The Dask scheduler of a sweep and its workers, as the driver deals with them.

The workers are processes of this machine, or those of a scheduler that is given. A worker on
another machine, or one that was started before the code changed, may run other code than its
driver. Its numbers must not enter the same store, so versions are compared.
"""

from __future__ import annotations

import gc
import hashlib
import json
import logging
import multiprocessing
import os
import platform
import time
import warnings
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import dask
import numpy as np
import scipy
from distributed import Client, Future, LocalCluster, Security, Status
from distributed.utils import silence_logging_cmgr

import tribo
from pipeline.run import forkserver
from pipeline.run.forkserver import UNGUARDED, interrupts_put_off
from pipeline.run.source import (
    CONFIGURATION,
    PATIENCE,
    SAFE,
    THREADS,
    ExecutionError,
    Source,
    Tell,
    unheard,
)
from pipeline.sweep.stages import duration

Versions = Mapping[str, str]

_FOLDERS = (Path(tribo.__file__).parent, Path(__file__).parents[1])
_PACKAGES = ("python", "numpy", "scipy")


def hash_of_code(folders: Iterable[Path] = _FOLDERS) -> str:
    """Hash of the source files of packages, by their names and contents."""
    digest = hashlib.sha256()
    for folder in folders:
        for file in sorted(folder.rglob("*.py")):
            name = os.fspath(file.relative_to(folder.parent))
            digest.update(f"{name} {file.stat().st_size}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


# Taken as this module is imported, so that a process that runs on after its files have changed
# names the code that it runs, and not the files.
_HERE: Versions = {
    "code": hash_of_code(),
    "numpy": np.__version__,
    "scipy": scipy.__version__,
    "python": platform.python_version(),
    "folder": os.fspath(_FOLDERS[1].parent),
}


def versions() -> Versions:
    """Versions of this process, and the folder that its code was loaded from."""
    return _HERE


def packages_of(theirs: Versions) -> dict[str, str]:
    """Versions of Python, NumPy and SciPy alone."""
    return {name: theirs[name] for name in _PACKAGES}


def other_packages(theirs: Versions) -> str:
    """Differences in Python, NumPy and SciPy between a worker and this process, in words."""
    return ", ".join(
        f"{name} {version} (here {_HERE[name]})"
        for name, version in packages_of(theirs).items()
        if version != _HERE[name]
    )


_UNSTARTED = "the worker processes do not start"
_STARTS = 3  # to start workers, one of which may be killed meanwhile
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


def _started(workers: int, dashboard: bool, attempts: int = _STARTS) -> LocalCluster:
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


LOST = f"the Dask scheduler is lost; {SAFE}"
_INSTALL = f"install the same version in both places and restart the workers; {SAFE}"
_WORD = 10.0  # [s] without a worker, after which the user is told
_ATTEMPTS = 3  # to share content with workers, which may be killed meanwhile
_ANSWER = 10.0  # [s] that a worker may take to tell its versions
_OF_DASHBOARD = ["distributed.http.statics"]  # beside its pages, and nothing that gives commands
_LIGHT = 8000  # bytes, of which a scheduler has room for as many as there are tasks


@dataclass(slots=True, eq=False)
class Connection:
    """A client of a scheduler, the source of its workers, and the user, who is told in lines.

    `patience` is the time to wait for answers, and for a worker if there is none [s]. `asked` are
    the workers that were asked for their versions, `noted` the versions that the user was told of,
    `absent` is the time in which there was no worker [s], and `workers` how many there are.
    """

    client: Client
    source: Source
    patience: float = PATIENCE
    tell: Tell = unheard
    asked: set[str] = field(default_factory=set)
    noted: set[str] = field(default_factory=set)
    absent: float = 0.0
    workers: int = 1

    def clock(self) -> float:
        """Time that does not go on while there is no worker [s]."""
        return time.monotonic() - self.absent


@contextmanager
def connected(
    client: Client | None,
    workers: int,
    patience: float = PATIENCE,
    tell: Tell = unheard,
    dashboard: bool = False,
) -> Iterator[Connection]:
    """Use a client, or start a scheduler here with so many workers, and end these.

    Raises
    ------
    ExecutionError
        If the workers do not start.
    """
    with ExitStack() as stack:
        source = Source()
        if client is None:
            routes = {"distributed.scheduler.http.routes": _OF_DASHBOARD if dashboard else []}
            stack.enter_context(dask.config.set(CONFIGURATION | routes))
            source = stack.enter_context(processes(workers, dashboard))
            client = stack.enter_context(Client(source.cluster, set_as_default=False))
        else:
            stack.enter_context(silence_logging_cmgr(logging.CRITICAL))  # it logs tracebacks
        stack.enter_context(client.as_current())
        if dashboard:
            tell(f"dashboard: {client.dashboard_link}")
        try:
            yield Connection(client, source, patience, tell)
        except KeyboardInterrupt:  # in the middle of a call to Dask
            warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
            raise


def require_dashboard() -> None:
    """Refuse a dashboard of a cluster here without the library that draws it."""
    if find_spec("bokeh") is None:
        raise ExecutionError(
            'the dashboard needs bokeh; get it with "pip install bokeh", or leave the dashboard out'
        )


def client_of(
    address: str | None = None, file: Path | None = None, patience: float = PATIENCE
) -> Client:
    """Client of a running scheduler, by its address or by the file that it has written.

    Raises
    ------
    ExecutionError
        If no scheduler answers.
    """
    if file is not None:  # which Dask would wait for without end
        try:
            address = str(json.loads(file.read_text())["address"])
        except (OSError, ValueError, KeyError, TypeError):
            raise ExecutionError(
                f"{file} cannot be read as the file of a Dask scheduler; give one that it wrote"
            ) from None
    try:
        with silence_logging_cmgr(logging.CRITICAL):
            return Client(address, set_as_default=False, timeout=patience)
    except (OSError, ValueError, RuntimeError) as error:
        reason = f"no Dask scheduler answers at {address}: {error}"
    except TypeError:  # as Dask has it
        reason = (
            f"{address} needs certificates: name the files under distributed.comm.tls in "
            "Dask's configuration, as DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
            "…__CLIENT__CERT and …__CLIENT__KEY do"
        )
    # Now: a client that was only half made, and is collected while the next one starts, takes a
    # lock of Dask's that this one holds, and both wait for ever.
    gc.collect()
    raise ExecutionError(reason)


def sent_once(connection: Connection, content: bytes) -> bytes | Future:
    """Content for many tasks: itself if it is light, else a result that every worker holds.

    Light content goes along with each task. Heavy content is the result of a task, which Dask
    computes again if the workers that hold it die. It is copied to every worker, since Dask
    prefers workers that hold a task's inputs and would leave the others idle.

    Raises
    ------
    ExecutionError
        If workers die of it.
    """
    if len(content) <= _LIGHT:
        return content
    for _ in range(_ATTEMPTS):
        shared = connection.client.submit(bytes, content, pure=False)
        with _losses_named(), suppress(TimeoutError, ValueError):  # the latter without any worker
            connection.client.replicate([shared], callback_timeout=connection.patience)
        if shared.status != "error":
            return shared
    raise ExecutionError(f"the Dask workers cannot run this program: {shared.exception()}")


def threads_of(connection: Connection) -> Counter[str]:
    """Number of threads of each worker; if there is no worker, wait for one to come.

    Raises
    ------
    ExecutionError
        If the scheduler is lost or does not answer, no worker comes back, or a worker that has
        joined runs other code.
    """
    client, source, began = connection.client, connection.source, time.monotonic()
    patience, is_told = connection.patience, False
    while True:
        with _losses_named():
            threads = Counter(client.nthreads(callback_timeout=patience))
        source.keep()
        waited = time.monotonic() - began
        if threads:
            connection.absent += waited
            connection.workers = len(threads)
            _ask(connection, sorted(set(threads) - connection.asked))
            return threads
        if waited >= patience:
            raise ExecutionError(
                f"there is no Dask worker, and none has come within {duration(patience)}; {SAFE}"
            )
        if waited >= min(_WORD, patience / 2) and not is_told:
            connection.tell(f"there is no Dask worker; waiting up to {duration(patience)} for one")
            is_told = True
        time.sleep(0.1)


def _ask(connection: Connection, workers: Collection[str]) -> None:
    """Ask workers that have joined for their versions; refuse those with other code."""
    if not workers:
        return
    connection.asked.update(workers)
    client, answers = connection.client, dict[str, Any]()
    with _losses_named(), suppress(TimeoutError):  # of one that is frozen, results are refused
        answers = client.sync(
            client.run, versions, workers=workers, on_error="return", callback_timeout=_ANSWER
        )
    for worker, answer in answers.items():
        if isinstance(answer, OSError):  # it has died meanwhile
            continue
        if isinstance(answer, Exception):
            raise ExecutionError(
                f"the Dask worker {worker} cannot run this program: {answer}; {_INSTALL}"
            )
        require_same_code(answer, worker)
        difference = other_packages(answer)
        if difference and difference not in connection.noted:
            connection.noted.add(difference)
            connection.tell(
                f"the Dask worker {worker} has {difference}: last digits may differ there"
            )


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


@contextmanager
def _losses_named() -> Iterator[None]:
    """Raise an `ExecutionError` where the scheduler is lost."""
    try:
        yield
    except (CancelledError, OSError) as error:
        raise ExecutionError(LOST) from error
