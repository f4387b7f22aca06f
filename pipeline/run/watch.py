"""The workers of a run: which of them take tasks, their program, and messages on them."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from typing import Any

from distributed import Client
from distributed.client import ClosedClientError

from pipeline.progress import Progress, Report, duration
from pipeline.run.work import PROGRAM, ExecutionError, Program, program

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
