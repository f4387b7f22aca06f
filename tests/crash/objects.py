"""Kills of a driver whose store lies in an object store, while the sweep grows."""

import os
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from unittest import mock

from tests.crash.loop import Trial, job, started
from tests.crash.sweeps import STAGES, Expected

TRIALS = 1
MISTAKE = "status first"
_KILLS = 3  # of a trial
_START = 60.0  # [s] that the server may take


@contextmanager
def served():
    """An S3 server on this machine, as the environment has it."""
    import boto3

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen(
        [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    environment = {
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
        "AWS_ACCESS_KEY_ID": "nobody",
        "AWS_SECRET_ACCESS_KEY": "secret",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    try:
        limit = time.monotonic() + _START
        while time.monotonic() < limit:
            with suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
                break
            time.sleep(0.1)
        with mock.patch.dict(os.environ, environment):
            boto3.client("s3").create_bucket(Bucket="irg")
            yield
    finally:
        server.kill()
        server.wait()


def campaign(folder, trials, chance, report, mistake=None):
    """Kill the drivers of so many stores."""
    expected = Expected(STAGES[-1])
    known = expected.records(STAGES[-1])
    with served():
        for number in range(trials):
            place = folder / str(number)
            place.mkdir()
            path, log = f"s3://irg/{os.getpid()}/{number}.zarr", place / "acknowledged"

            def start(sweep, path=path, log=log, place=place):
                return started(log, *job(place, sweep, path, log, known, mistake))

            trial = Trial(report, path, expected, log, start)

            def kill(run, trial=trial):
                trial.wait(run, chance)
                report.counts["kills" if run.poll() is None else "too late"] += 1
                run.kill()
                run.wait()

            trial.go([kill] * _KILLS)
            print(
                f"objects: {number + 1} of {trials}, {len(report.faults)} faults", file=sys.stderr
            )
