"""Kills of a driver whose store lies in an object store, while the sweep grows at its ends."""

import os

from tests.crash.loop import job, started
from tests.helpers.s3 import served

TRIALS = 1
MISTAKE = "status first"
_KILLS = 3  # kills in a trial


def campaign(run):
    """Kill drivers of `run.count` stores in an object store, several times each."""
    with served():
        for trial in run.trials():
            trial.path = f"s3://irg/{os.getpid()}/{trial.place.name}.zarr"

            def start(sweep, trial=trial):
                arguments = (sweep, trial.path, trial.log, run.records, run.mistake)
                return started(trial.log, *job(trial.place, *arguments))

            def kill(driver, trial=trial):
                trial.wait(driver)
                run.report.counts["kills" if driver.poll() is None else "too late"] += 1
                driver.kill()
                driver.wait()

            trial.start = start
            trial.go([kill] * _KILLS)
