"""Readers beside a driver that writes and makes its store longer.

Points that were told as done before a reader opens the store are whole in what it sees, all others
are whole or NaN; no reader has an error. Every other reader reads only some time after it opened.
"""

import sys

import pipeline
from pipeline.store.place import place_of
from tests.crash.loop import Forked, Trial, code_of, faults_of
from tests.crash.sweeps import STAGES, Expected

TRIALS = 5
MISTAKE = "status first"
_PACE = 0.03  # [s] between commits


def campaign(folder, trials, chance, report, mistake=None):
    """Read so many sweeps from their beginning to their end."""
    expected = Expected(STAGES[-1])
    known = expected.records(STAGES[-1])
    for number in range(trials):
        place = folder / str(number)
        place.mkdir()
        path, log = place / "out.zarr", place / "acknowledged"

        def start(sweep, path=path, log=log):
            return Forked(sweep, path, log, known, mistake, _PACE)

        trial = Trial(report, path, expected, log, start)

        def read(run, trial=trial):
            while code_of(run, chance.uniform(0.0, 0.05)) is None:
                try:
                    _read(trial, run, chance, report)
                except Exception as error:
                    trial.fault(f"a reader: {type(error).__name__}: {error}")
            if run.returncode not in (0, 1):
                trial.fault(f"the driver ends with {run.returncode}")

        trial.go([read] * len(STAGES))
        print(f"readers: {number + 1} of {trials}, {len(report.faults)} faults", file=sys.stderr)


def _read(trial, run, chance, report):
    """Read a store in one of the ways, if there is one."""
    told = trial.acknowledged
    if not place_of(trial.path).exists():
        return
    way = chance.choice(("status", "verify", "data", "data, later"))
    report.counts[way] += 1
    if way == "status":
        summary = pipeline.summary(trial.path)
        if summary.done + summary.earlier < len(told):
            trial.fault(f"{len(told)} points were told as done, and summary counts {summary.done}")
    elif way == "verify":
        checked = pipeline.verify_store(trial.path)
        for each in (*checked.damaged, *checked.records, *checked.shared):
            trial.fault(f"verify beside the driver: {each}")
        if checked.done < len(told):
            trial.fault(f"{len(told)} points were told as done, and verify counts {checked.done}")
    else:
        with pipeline.open_sweep(trial.path) as ds:
            if way == "data, later":
                code_of(run, chance.uniform(0.0, 0.3))
            for fault in faults_of(ds, trial.expected, told):
                trial.fault(f"a reader: {fault}")
