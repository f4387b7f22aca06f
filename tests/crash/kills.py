"""Kills of drivers, workers and everything at random moments, while a sweep grows.

A quarter of the trials computes on Dask's workers: by `run_sweep`, by ``irg run``, by
``irg run --boundary-only`` and with samples of unknown inputs. The others do without Dask: there
half of the time is spent in commits.
"""

import itertools
import os
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil

import pipeline
from tests.crash.loop import PATIENCE, Forked, Trial, code_of, job, started
from tests.crash.sweeps import STAGES, Expected

TRIALS = 16
MISTAKE = "status first"
_EVERY = (1.0, 4.0)  # [s] between kills of one with workers
_KILLS = 4  # of a trial with workers
_TARGETS = ("worker", "worker", "everything", "driver", "any")
_SCENE = Path(__file__).parents[2] / "workflows" / "{}.toml"
_COARSE = ["fidelity.pixels_per_element=8", "fidelity.increments=6", "sweep.fields=true"]
_FASTER = 'sweep.velocities={from="0.5 m/s",to="4 m/s",step="0.25 m/s"}'
# Scene and options of a command, and its settings from stage to stage.
_COMMANDS = {
    "command": (
        ["irg_transition"],
        [
            ['sweep.loads=["200 N","400 N"]'],
            ['sweep.loads=["200 N","400 N","750 N"]'],
            ['sweep.loads=["200 N","400 N","750 N"]', _FASTER],
        ],
    ),
    "boundary": (
        ["irg_transition", "--boundary-only"],
        [['sweep.loads=["200 N","400 N","750 N"]']],
    ),
    "samples": (["uncertain"], [[f"sweep.samples={count}"] for count in (8, 16, 24)]),
}
WAYS = ("sweep", *_COMMANDS)


def _processes(driver):
    """Live processes that a driver has started, and those that these have."""
    with suppress(psutil.NoSuchProcess):
        return psutil.Process(driver).children(recursive=True)
    return []


def _is_worker(process):
    """Whether a process was forked or spawned to compute, and is not the one that forks."""
    with suppress(psutil.NoSuchProcess):
        words = " ".join(process.cmdline())
        return "spawn_main" in words or ("forkserver" in words and not process.children())
    return False


def _kill(run, target, chance):
    """Kill a process; return whether there was one."""
    processes = _processes(run.pid)
    workers = [process for process in processes if _is_worker(process)]
    if not workers:
        return False
    with suppress(ProcessLookupError, psutil.NoSuchProcess):
        if target == "everything":
            os.killpg(run.pid, signal.SIGKILL)
        elif target == "driver":
            run.kill()
        else:
            chance.choice(workers if target == "worker" else processes).kill()
    return True


class _Campaign:
    def __init__(self, folder, chance, report, mistake):
        self._folder, self._chance, self._report = folder, chance, report
        self._mistake = mistake
        self._expected = Expected(STAGES[-1])
        self._known = self._expected.records(STAGES[-1])

    def fast(self, number):
        """Kill a driver without Dask, time after time."""
        log, path = self._paths(number)

        def start(sweep):
            return Forked(sweep, path, log, self._known, self._mistake)

        def disturb(run):
            trial.wait(run, self._chance)
            self._report.counts["kills of everything"] += run.returncode is None

        trial = Trial(self._report, path, self._expected, log, start)
        trial.go([disturb] * 5)

    def with_workers(self, number, way):
        """Kill processes of a driver on Dask."""
        log, path = self._paths(number)
        expected, stages, start = self._expected, STAGES, None
        if way in _COMMANDS:
            (name, *options), stages = _COMMANDS[way]
            scene = str(_SCENE).format(name)
            coarse = _COARSE if way != "samples" else []
            settings = [word for entry in coarse for word in ("--set", entry)]
            expected = Expected(pipeline.load_scene(scene, overrides=dict(map(_entry, coarse))))
            if way == "samples":
                most = dict(map(_entry, stages[-1]))
                expected = Expected(pipeline.load_scene(scene, overrides=most))
            command = ["run", scene, *options, "-o", path, "--workers", "2", *settings]

            def start(stage):
                further = [word for entry in stage for word in ("--set", entry)]
                return started(log, *command, *further, mistake=self._mistake)
        else:

            def start(sweep):
                arguments = job(log.parent, sweep, path, log, None, self._mistake)
                return started(log, *arguments)

        targets = itertools.cycle(self._chance.sample(_TARGETS, len(_TARGETS)))
        trial = Trial(self._report, path, expected, log, start, stages)
        trial.go([lambda run: self._disturb(trial, run, targets)] * 3)

    def _disturb(self, trial, run, targets):
        """Kill one process after the other until the driver ends."""
        limit, killed = time.monotonic() + PATIENCE, []
        while code_of(run, self._chance.uniform(*_EVERY)) is None:
            if time.monotonic() > limit:
                trial.fault(f"it hangs after kills of {killed}")
                return
            if len(killed) < _KILLS and _kill(run, target := next(targets), self._chance):
                killed.append(target)
                self._report.counts[f"kills of {target}"] += 1
        self._report.counts["given up"] += run.returncode > 0
        if run.returncode > 0 and set(killed) <= {"worker"}:
            words = trial.last_words()
            trial.fault(f"it ends with {run.returncode} after kills of {killed}: {words}")

    def _paths(self, number):
        folder = self._folder / str(number)
        folder.mkdir()
        return folder / "acknowledged", folder / "results" / "out.zarr"


def _entry(text):
    """Path and value of a setting, as Python takes it."""
    name, _, value = text.partition("=")
    return name, {"true": True}.get(value) or int(value)


def campaign(folder, trials, chance, report, mistake=None, ways=WAYS):
    """Disturb so many sweeps, every fourth of them with workers."""
    tried = _Campaign(folder, chance, report, mistake)
    following = itertools.cycle(ways)
    for number in range(trials):
        if number % 4 == 3 and ways:
            way = next(following)
            report.counts[f"by {way}"] += 1
            tried.with_workers(number, way)
        else:
            tried.fast(number)
        print(f"kills: {number + 1} of {trials}, {len(report.faults)} faults", file=sys.stderr)
