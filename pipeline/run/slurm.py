"""Jobs of Slurm that are workers, by dask-jobqueue. Imported only where jobs are asked for."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from distributed import Security, Status

from pipeline.run.batch import Batch
from pipeline.run.forkserver import interrupts_put_off
from pipeline.run.source import SAFE, ExecutionError, JobCounts, Source, Tell

_sigint = signal.getsignal(signal.SIGINT)
from dask_jobqueue.slurm import SLURMCluster, SLURMJob  # noqa: E402

signal.signal(signal.SIGINT, _sigint)  # dask-jobqueue 0.9 exits with 0 on Ctrl-C once imported

_FIRST, _LOOK = 1.0, 15.0  # [s] between two looks at the queue, at first and later
_ANSWER = 60.0  # [s] that a command of Slurm may take
_END = 60.0  # [s] that the jobs may take to be cancelled
_AT_ONCE = 8  # jobs that are submitted at the same time
_EARLY = 3, 10  # jobs in a row that end before their workers start: before any has, and later
_OF_SLURM, _INFO = "slurmstepd", " - INFO - "  # in lines of a log
_CANCELLED, _TIME_LIMIT = "CANCELLED AT", "TIME LIMIT"  # in lines of Slurm
_REFUSALS = 20  # looks at the queue in a row with jobs refused and none left


class Job(SLURMJob):  # type: ignore[misc]
    """A job of Slurm, which notes that it was refused."""

    refusal = ""
    """Words in which it was refused; empty if it was not."""

    async def start(self) -> None:
        """Submit the job."""
        try:
            await super().start()
        except (OSError, RuntimeError, ValueError) as error:
            self.refusal = _words(error)
        self.status = Status.running

    async def close(self) -> None:
        """Cancel the job."""
        await super().close()
        self.status = Status.closed


def _words(error: Exception) -> str:
    """Words of Slurm in an error of dask-jobqueue."""
    if isinstance(error, FileNotFoundError):
        return f"there is no command {error.filename} here: run it where jobs can be submitted"
    lines = str(error).partition("stderr:\n")[2].split("\n")
    said = (line.removeprefix("sbatch: ").removeprefix("error: ").strip() for line in lines)
    return "; ".join(filter(None, said)) or str(error)


class SlurmJobs(Source):
    """Jobs of Slurm, whose number is kept up; their workers live for a time [s]."""

    def __init__(
        self, cluster: SLURMCluster, name: str, number: int, life: float, folder: Path
    ) -> None:
        super().__init__(cluster, True, life, JobCounts(0, number, ""))
        self.name, self.number, self._folder = name, number, folder
        self._joined: set[str] = set()
        self._early = self._refusals = 0
        self._notes: list[str] = []
        self._noted: set[str] = set()
        self._error = ""

    def keep(self, tell: Tell) -> None:
        """Report the end of jobs; they are replaced meanwhile."""
        if self._error:
            raise ExecutionError(f"{self._error}; {SAFE}")
        while self._notes:
            note = self._notes.pop(0)
            if note not in self._noted:
                tell(note)
            self._noted.add(note)

    def submit(self) -> None:
        """Submit one job, and the others once it is accepted."""
        self.cluster.scale(jobs=1)
        end = time.monotonic() + _ANSWER
        while not (jobs := list(self.cluster.workers.values())):
            if time.monotonic() > end:
                raise ExecutionError(
                    f"sbatch has not answered within {_ANSWER:g} s; try it by hand, and run again"
                )
            time.sleep(0.02)
        if jobs[0].refusal:
            raise ExecutionError(f"Slurm refuses the jobs: {jobs[0].refusal}")
        self.cluster.loop.add_callback(self._look_on)

    async def _look_on(self) -> None:
        pause = _FIRST
        while self.cluster.status == Status.running and not self._error:
            try:
                await self._fill()
                await self._look()
            except Exception as error:  # it would be lost in this loop
                self._error = f"the jobs cannot be followed: {type(error).__name__}: {error}"
            await asyncio.sleep(pause)
            pause = min(2 * pause, _LOOK)

    async def _fill(self) -> None:
        """Submit jobs, some at a time, until there are enough or any is refused."""
        cluster, end = self.cluster, time.monotonic() + _ANSWER
        while len(cluster.worker_spec) < self.number and time.monotonic() < end:
            cluster.scale(jobs=min(len(cluster.worker_spec) + _AT_ONCE, self.number))
            while len(cluster.workers) < len(cluster.worker_spec) and time.monotonic() < end:
                await asyncio.sleep(0.05)
            if any(job.refusal for job in cluster.workers.values()):
                return

    async def _look(self) -> None:
        """Look at the queue, and forget jobs that have left it."""
        before = dict(self.cluster.workers)
        queue = await self._queue()
        if queue is None:
            return
        self._note_joined(before)
        for name, job in before.items():
            if job.job_id in queue:
                continue
            if not job.refusal and job.job_id not in self._joined:
                self._note_early(job.job_id)
            job.status = Status.closed
            self.cluster.workers.pop(name, None)
            self.cluster.worker_spec.pop(name, None)
        self._note_refusals({job.refusal for job in before.values()} - {""}, bool(queue))
        states = [queue[job.job_id] for job in before.values() if job.job_id in queue]
        waiting = [reason for state, reason in states if state == "PENDING"]
        reason = next((reason for reason in waiting if reason != "None"), "")
        self.jobs = JobCounts(len(states) - len(waiting), len(waiting), reason)

    async def _queue(self) -> dict[str, tuple[str, str]] | None:
        """State and reason of each job by its number; None if Slurm does not answer."""
        command = ("squeue", "--noheader", f"--name={self.name}", "--format=%A %T %r")
        with suppress(OSError, TimeoutError):
            process = await asyncio.create_subprocess_exec(
                *command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
            out, _ = await asyncio.wait_for(process.communicate(), _ANSWER)
            if process.returncode == 0:
                lines = [line.split(maxsplit=2) for line in out.decode().splitlines()]
                return {number: (state, reason) for number, state, reason in lines}
        self._notes.append("Slurm does not answer; jobs that run go on")
        return None

    def _note_joined(self, jobs: dict[str, Job]) -> None:
        names = {worker["name"] for worker in self.cluster.scheduler_info["workers"].values()}
        names |= {str(name).rpartition("-")[0] for name in names}  # one of several of a job
        joined = {job.job_id for name, job in jobs.items() if name in names}
        if joined - self._joined:
            self._joined |= joined
            self._early = 0

    def _note_refusals(self, refusals: set[str], any_left: bool) -> None:
        self._refusals = self._refusals + 1 if refusals and not any_left else 0
        for refusal in refusals:
            self._notes.append(f"Slurm refuses further jobs: {refusal}; it is asked again")
            if self._refusals >= _REFUSALS:
                self._error = f"Slurm refuses the jobs: {refusal}"

    def _note_early(self, number: str) -> None:
        """Take note of a job that has ended before its workers started."""
        logs = sorted(self._folder.glob(f"*-{number}.err"))
        lines = [line for log in logs for line in log.read_text(errors="replace").splitlines()]
        if any("Registered to:" in line for line in lines):
            return
        said = [line.strip() for line in lines if line.strip() and _INFO not in line]
        of_slurm = [line for line in said if line.startswith(_OF_SLURM)]
        faults = [line for line in said if line not in of_slurm]
        # Such as for urgent jobs of others: what its workers say then follows from that.
        cancelled = [line for line in of_slurm if _CANCELLED in line and _TIME_LIMIT not in line]
        words = (cancelled or faults or said or ["it left no word"])[-1]
        if words in of_slurm:
            words = words.partition(" error: ")[2].strip("* ") or words
        log = f" ({logs[0]})" if logs else ""
        first, later = _EARLY
        if not (cancelled and self._joined):
            self._early += 1
        most = later if cancelled or self._joined else 1 if faults else first
        if self._early >= most:
            self._error = f"workers do not start in the jobs: {words}{log}"
        self._notes.append(f"a job has ended before its workers started: {words}{log}")


@contextmanager
def submitted(batch: Batch, out: str, most: int | None) -> Iterator[SlurmJobs]:
    """Start a scheduler here and the workers of a sweep in jobs, and cancel these in the end.

    There are as many jobs as `most` workers fill, if it is known how many can be kept busy.
    """
    folder, number = batch.folder(out), batch.jobs
    if most:
        number = min(number, -(-most // batch.site.cores))
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    name = f"{_name(out)}-{secrets.token_hex(3)}"  # jobs of other runs are none of ours
    with ExitStack() as stack:
        stack.callback(_remove_if_empty, folder)
        private = TemporaryDirectory(prefix=".", dir=folder, ignore_cleanup_errors=True)
        security = _security(Path(stack.enter_context(private)))
        with interrupts_put_off():
            cluster = _started(batch, batch.options(name, folder), security)
        stack.callback(_end, cluster, name)
        jobs = SlurmJobs(cluster, name, number, batch.life, folder)
        jobs.submit()
        yield jobs


def script_of(batch: Batch, out: str) -> str:
    """Script of a job of the sweep with this store, without its address and certificates."""
    folder = batch.folder(out)
    options = batch.options(_name(out), folder)
    try:
        return str(Job("ADDRESS", name="NAME", protocol="tls://", **options).job_script())
    finally:
        _remove_if_empty(folder)  # which dask-jobqueue makes


def _name(out: str) -> str:
    return "irg-" + re.sub(r"[^\w-]+", "-", Path(out).stem)


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def _security(folder: Path) -> Security:
    """Certificates of this run, those of its workers in files that only this user may read."""
    security = Security.temporary()
    for name in ("tls_ca_file", "tls_worker_cert", "tls_worker_key"):
        file = folder / name
        file.touch(mode=0o600)
        file.write_text(getattr(security, name))
        setattr(security, name, str(file))
    return security


def _started(batch: Batch, options: dict[str, Any], security: Security) -> SLURMCluster:
    try:
        return SLURMCluster(
            job_cls=Job,
            security=security,
            scheduler_options={
                "dashboard": False,
                "dashboard_address": "127.0.0.1:0",
                "port": batch.site.port or 0,
            },
            silence_logs=logging.CRITICAL,
            **options,
        )
    except (OSError, RuntimeError, ValueError) as error:
        raise ExecutionError(f"the Dask scheduler does not start: {error}") from None


def _end(cluster: SLURMCluster, name: str) -> None:
    with interrupts_put_off():
        try:
            cluster.close(timeout=_END)
        except (OSError, AssertionError):  # not in time
            with suppress(OSError, subprocess.TimeoutExpired):
                subprocess.run(["scancel", f"--name={name}"], timeout=_ANSWER, check=False)
