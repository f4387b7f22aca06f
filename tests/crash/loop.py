"""The loop that all campaigns share: a store is written to, disturbed, looked at, and resumed.

However it was disturbed, the store opens and is clean, no point is lost that was told as done, and
all points that are done are, bit for bit, what is computed alone. In the end a run completes it.
"""

import json
import os
import signal
import subprocess
import sys
import time
import traceback
from collections import Counter
from contextlib import suppress
from functools import cached_property
from pathlib import Path

import numpy as np

import pipeline
from pipeline import verify_store
from pipeline.paths import PARTIAL
from pipeline.store.create import find_sweep
from pipeline.store.dataset import store_dataset
from pipeline.store.schema import COLUMNS, DONE, ENDS, FAILED, FIELDS, PLANE
from pipeline.store.store import opened
from pipeline.sweep.sweep import Point
from tests.crash.driver import drive
from tests.crash.sweeps import EXPECTED, FAILING, REASON, STAGES

PATIENCE = 300.0
"""Time that a run may take, which takes less than 20 s on an idle machine [s]."""
_SOON, _LATEST = 0.1, 0.8  # when a disturbance comes, after the start or a done point [s]
_END = 60.0  # time in which processes of a dead driver must end [s]


class Report:
    """Counts of what a campaign did, and the faults that it found."""

    def __init__(self):
        self.counts, self.faults = Counter(), []

    def as_dict(self):
        return {**self.counts, "faults": self.faults[:20], "faults_in_all": len(self.faults)}


class Forked:
    """A driver without Dask in a process forked from this one, like `subprocess.Popen`.

    Parameters are those of `drive`.
    """

    def __init__(self, sweep, path, log, records, mistake=None, pace=0.0, **options):
        self.returncode = None
        # Not by multiprocessing: its children count as workers, which may not run a sweep.
        self.pid = os.fork()
        if not self.pid:
            code = 99
            try:
                with Path(log).with_suffix(".err").open("a") as sys.stderr:
                    code = drive(sweep, path, log, records, mistake, pace, **options)
            except BaseException:
                with Path(log).with_suffix(".err").open("a") as stream:
                    traceback.print_exc(file=stream)
            finally:
                os._exit(code)

    def poll(self):
        """Exit code of the driver; None if it still runs."""
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self.returncode = os.waitstatus_to_exitcode(status) if pid else None
        return self.returncode

    def wait(self, seconds=PATIENCE):
        """Wait until the driver has ended; raise as `subprocess.Popen.wait` does."""
        limit = time.monotonic() + seconds
        while self.poll() is None:
            if time.monotonic() > limit:
                raise subprocess.TimeoutExpired("a driver", seconds)
            time.sleep(0.002)
        return self.returncode

    def kill(self):
        """Kill the driver if it still runs."""
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


def started(log, *arguments, mistake=None):
    """Start a driver as a command, in a process group of its own."""
    wrong = ["--mistake", mistake] if mistake else []
    return subprocess.Popen(
        [sys.executable, "-m", "tests.crash.driver", log, *wrong, *map(str, arguments)],
        cwd=Path(__file__).parents[2],
        stdout=subprocess.DEVNULL,
        stderr=Path(log).with_suffix(".err").open("a"),
        start_new_session=True,
    )


def code_of(run, seconds=PATIENCE):
    """Exit code of a driver; None if it still runs after this time [s]."""
    with suppress(subprocess.TimeoutExpired):
        run.wait(seconds)
    return run.poll()


def end(run):
    """Kill a driver and its process group; return True if its processes had ended by themselves."""
    if not isinstance(run, subprocess.Popen):
        run.kill()
        run.wait()
        return True
    limit = time.monotonic() + (_END if run.poll() is not None else 0.0)
    while time.monotonic() < limit:
        try:
            os.killpg(run.pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    with suppress(ProcessLookupError):
        os.killpg(run.pid, signal.SIGKILL)
    return run.wait() is None


def indexed_points(ds):
    """Yield each index into the variables of a dataset, and the `Point` there."""
    dims = ds["status"].dims
    values = {name: ds[name].values for name in {*dims, *PLANE}}
    for index in np.ndindex(ds["status"].shape):
        at = dict(zip(dims, index, strict=True))
        # In rows, load and velocity are those of the row.
        load, velocity = (float(values[k][tuple(at[d] for d in ds[k].dims)]) for k in PLANE)
        case = tuple((d, values[d].tolist()[k]) for d, k in at.items() if d not in PLANE)
        yield index, Point(load, velocity, case)


def values_of_points(ds):
    """Values of all variables of a dataset as arrays, by name."""
    return {name: values.values for name, values in ds.variables.items()}


def _is_known(values):
    """True where there is a number or, for flags, where a flag is set."""
    return values if values.dtype == bool else np.isfinite(values)


def differing(arrays, index, result):
    """Yield names of variables of a point that are not, bit for bit, the computed result."""
    for name, values in result.record("pressure" in arrays).data.items():
        if name in ENDS and name not in arrays:  # the pin is computed without its ends
            continue
        stored, values = np.atleast_1d(arrays[name][index]), np.atleast_1d(values)
        if stored[-len(values) :].tobytes() != values.tobytes():
            yield name
        elif name in COLUMNS and _is_known(stored[: -len(values)]).any():
            yield f"{name} beyond its end"


def faults_of(datasets, expected, acknowledged):
    """Yield faults of the datasets of a store: lost points, wrong values, values of other points.

    A point may have failed as it is meant to in the first stage.
    """
    left = set(acknowledged)
    for ds in datasets:
        arrays = values_of_points(ds)
        for index, point in indexed_points(ds):
            status = int(arrays["status"][index])
            if status == DONE:
                left.discard(point)
                names = list(differing(arrays, index, expected(point)))
                yield from (f"{point}: {name} differs" for name in names)
                continue
            if status == FAILED and (point, arrays["message"][index]) != (FAILING, REASON):
                yield f"{point} has failed: {arrays['message'][index]}"
            for name in {*COLUMNS, *FIELDS} & set(arrays):
                if _is_known(arrays[name][index]).any():
                    yield f"{point} is not done, and has {name}"
    yield from (f"{point} was told as done, and is lost" for point in left)


def acknowledged(log):
    """Number of times that each point is noted as done in the log of drivers, by point."""
    lines = log.read_text().splitlines(keepends=True) if log.exists() else ()
    rows = (json.loads(line) for line in lines if line.endswith("\n"))
    return Counter(Point(*point, tuple(map(tuple, case))) for *point, case in rows)


def faults_of_files(verification):
    """Damage that `verify_store` names, as texts."""
    damaged = (*verification.damaged, *verification.shared)
    return [f"damaged: {fault}" for fault in damaged]


class Run:
    """A campaign: name, folder, number of trials, random generator, report, deliberate mistake."""

    def __init__(self, name, folder, count, chance, report, mistake):
        self.name, self.folder, self.count = name, folder, count
        self.chance, self.report, self.mistake = chance, report, mistake

    @cached_property
    def records(self):
        """Records of the points of all stages, as workers would return them, by point."""
        return EXPECTED.records(STAGES[-1])

    def trials(self):
        """Yield trials, each with its own folder, with drivers that run without Dask."""
        for number in range(self.count):
            folder = self.folder / str(number)
            folder.mkdir(parents=True)
            yield Trial(self, folder)
            done = f"{number + 1} of {self.count}, {len(self.report.faults)} faults"
            print(f"{self.name}: {done}", file=sys.stderr)


class Trial:
    """A store that drivers write to while they are disturbed.

    Attributes
    ----------
    folder, path, log : Path
        Its folder, the store, and the file in which drivers note points reported as done.
    expected : callable
        Function from a point to its result, computed alone.
    stages : sequence
        Sweeps to run one after the other; the last one is completed in the end.
    """

    def __init__(self, run, folder):
        self.run, self.folder = run, folder
        self.path, self.log = folder / "results" / "out.zarr", folder / "acknowledged"
        self.expected, self.stages = EXPECTED, STAGES

    def start(self, stage, path=None):
        """Start a driver on the sweep `stage`, by default in the store of this trial."""
        run = self.run
        return Forked(stage, path or self.path, self.log, run.records, run.mistake)

    @property
    def acknowledged(self):
        """Number of times that each point was reported to drivers as done, by point."""
        return acknowledged(self.log)

    def go(self, disturbances):
        """Disturb one driver after the other, then complete the sweep; add faults to the report."""
        for number, disturb in enumerate(disturbances):
            driver = self.start(self.stages[min(number, len(self.stages) - 1)])
            try:
                disturb(driver)
            finally:
                if not end(driver):
                    self.fault("processes of a dead driver go on")
            self.look()
        self.complete()
        self.run.report.counts["trials"] += 1

    def complete(self):
        """Run the sweep to its end without a disturbance, and check store and left-over files."""
        driver = self.start(self.stages[-1])
        code = code_of(driver)
        end(driver)
        if code != 0:
            word = "it hangs" if code is None else f"it ends with {code}"
            self.fault(f"resumed, {word}: {self.last_words()}")
        self.look()
        for summary in self._summaries() if code == 0 else ():
            if summary.pending:
                self.fault(f"resumed, {summary.pending} points are not done")
        left = [*self.path.parent.rglob(f"*{PARTIAL}")]
        self.run.report.faults += [f"left over: {file}" for file in left]
        acknowledged = self.acknowledged
        self.run.report.counts["acknowledged"] += len(acknowledged)
        for point in (point for point, times in acknowledged.items() if times > 1):
            self.fault(f"{point} was told as done, and computed again")

    def _summaries(self):
        """Summaries of the plane and of the points beside it, if there are any."""
        plane = pipeline.summary(self.path)
        return [plane, plane.tests] if plane.tests else [plane]

    def wait(self, driver):
        """Let a driver run for a random time, or until some further points are done."""
        chance = self.run.chance
        further = chance.choice((0, chance.randint(0, 20)))
        enough = len(self.acknowledged) + further if further else 0
        limit = time.monotonic() + PATIENCE
        while driver.poll() is None and time.monotonic() < limit:
            if len(self.acknowledged) >= enough:
                code_of(driver, chance.uniform(0.0, _SOON if further else _LATEST))
                return
            time.sleep(0.02)

    def look(self):
        """Check the store, and add its faults to the report."""
        acknowledged = self.acknowledged
        self.run.report.counts["looks"] += 1
        try:
            if find_sweep(self.path) is None:
                if acknowledged:
                    self.fault(f"{len(acknowledged)} were told as done, and there is no store")
                return
            for fault in faults_of_files(verify_store(self.path)):
                self.fault(fault)
            datasets = [store_dataset(group).load() for group in opened(self.path).groups]
            for fault in faults_of(datasets, self.expected, acknowledged):
                self.fault(fault)
        except Exception as error:
            self.fault(f"{type(error).__name__}: {error}")

    def fault(self, text):
        self.run.report.faults.append(f"{self.folder.name}: {text}")

    def last_words(self):
        """Last 400 characters that drivers have printed on stderr."""
        file = self.log.with_suffix(".err")
        return file.read_text()[-400:] if file.exists() else ""
