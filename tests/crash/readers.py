"""Readers beside a driver that writes and makes its store longer.

Points that were told as done before a reader opens the store are whole in what it sees, all others
are whole or NaN. Every other reader reads only some time after it opened, also across a growth. No
reader has an error.
"""

import pipeline
from pipeline.store.create import find_sweep
from tests.crash.loop import code_of, faults_of, faults_of_files
from tests.crash.sweeps import FAILING, STAGES

TRIALS = 5
MISTAKE = "status first"
_PACE = 0.03  # time between commits [s]


def campaign(run):
    """Read `run.count` stores again and again while drivers write them."""
    for trial in run.trials(_PACE):

        def read(driver, trial=trial):
            while code_of(driver, run.chance.uniform(0.0, 0.15)) is None:
                try:
                    for fault in _read(trial, driver):
                        trial.fault(f"a reader: {fault}")
                except Exception as error:
                    trial.fault(f"a reader: {type(error).__name__}: {error}")
            if driver.returncode not in (0, 1):
                trial.fault(f"the driver ends with {driver.returncode}")

        trial.go([read] * len(STAGES))


def _may_have_failed(point, _):
    """True for the point that fails in the first stage; its message may already be replaced."""
    return point == FAILING


def _read(trial, driver):
    """Read a store in a randomly chosen way, and yield faults of what is seen."""
    acknowledged, chance = trial.acknowledged, trial.run.chance
    if find_sweep(trial.path) is None:
        return
    way = chance.choice(("status", "verify", "data", "data, later"))
    trial.run.report.counts[way] += 1
    if way == "status":
        summary = pipeline.summary(trial.path)
        if summary.done + summary.earlier < len(acknowledged):
            yield f"{len(acknowledged)} points were told as done, and summary counts {summary.done}"
    elif way == "verify":
        checked = pipeline.verify_store(trial.path)
        yield from faults_of_files(checked)
        if checked.done < len(acknowledged):
            yield f"{len(acknowledged)} points were told as done, and verify counts {checked.done}"
    else:
        with pipeline.open_sweep(trial.path) as ds:
            if way == "data, later":
                code_of(driver, chance.uniform(0.0, 0.3))
            yield from faults_of(ds, trial.expected, acknowledged, _may_have_failed)
