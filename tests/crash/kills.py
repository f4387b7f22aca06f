"""Kills of drivers, workers and everything at random moments, while a sweep grows.

A quarter of the trials computes on Dask's workers, by ``irg run``: with fields, with
``--accuracy``, and with uncertain inputs, whose points follow in a larger store once the plane is
done. The others do without Dask: there half of the time is spent in commits.
A quarter takes over the points of another store.
"""

import itertools
import os
import signal
import time
import tomllib
from contextlib import suppress
from pathlib import Path

import psutil

import pipeline
from pipeline.run.search import MOST_REALIZATIONS
from pipeline.store.store import opened
from pipeline.sweep.plan import TEST_POINT
from tests.crash.loop import PATIENCE, Forked, code_of, started
from tests.crash.sweeps import STAGES, Expected
from tests.helpers.entries import changed

TRIALS = 16
MISTAKE = "status first"
_EVERY = (1.0, 4.0)  # time between kills of a driver with workers [s]
_KILLS = 4  # kills in a trial with workers
_TARGETS = ("worker", "worker", "everything", "driver", "any")
_SCENE = Path(__file__).parents[2] / "workflows" / "{}.toml"
_PLAIN = 'without=["tests"]'  # whose points are beside the plane
_COARSE = ["fidelity.pixels_per_element=8", "fidelity.increments=6", "sweep.fields=true", _PLAIN]
_FASTER = 'sweep.velocities={from="0.5 m/s",to="4 m/s",step="0.25 m/s"}'
_INPUTS = '"disk.roughness.ra"="10 %","wear.specific_wear_rate"="40 %"'
_MORE_INPUTS = '"pin.radius"="1 %"'
# Scene and options of each command, its settings, and more settings at each stage.
_COMMANDS = {
    "command": (
        ["irg_transition"],
        _COARSE,
        [
            ['sweep.loads=["200 N","400 N"]'],
            ['sweep.loads=["200 N","400 N","750 N"]'],
            ['sweep.loads=["200 N","400 N","750 N"]', _FASTER],
        ],
    ),
    "goal": (
        ["irg_transition", "--accuracy", "3%"],
        ["sweep.fields=false", _PLAIN],  # only the first realization has fields
        [['sweep.loads=["200 N","400 N","750 N"]']],
    ),
    "uncertain": (
        ["irg_transition"],
        _COARSE,
        [
            ['sweep.loads=["200 N","400 N"]', f"uncertainty={{{_INPUTS}}}"],
            ['sweep.loads=["200 N","400 N","750 N"]', f"uncertainty={{{_INPUTS}}}"],
            ['sweep.loads=["200 N","400 N","750 N"]', f"uncertainty={{{_INPUTS},{_MORE_INPUTS}}}"],
        ],
    ),
}


class _AsStored:
    """Expected results of points, computed at the load steps that the store has kept.

    Points of uncertain inputs, which the run chooses, are computed as the store describes them.
    """

    def __init__(self, sweep, path):
        self._sweep, self._path, self._expected = sweep, path, None
        self._of_inputs = {}

    def __call__(self, point):
        if TEST_POINT in dict(point.case):
            if point not in self._of_inputs:
                _, group = opened(self._path).groups
                self._of_inputs[point] = Expected(group.sweep)(point)
            return self._of_inputs[point]
        if self._expected is None:
            stored_steps = opened(self._path).sweep.stored_steps
            self._expected = Expected(changed(self._sweep, stored_steps=stored_steps))
        return self._expected(point)


def _processes(driver):
    """All living descendant processes of the driver with process id `driver`."""
    with suppress(psutil.NoSuchProcess):
        return psutil.Process(driver).children(recursive=True)
    return []


def _is_worker(process):
    """True if a process computes points: forked or spawned, but not the fork server."""
    with suppress(psutil.NoSuchProcess):
        words = " ".join(process.cmdline())
        return "spawn_main" in words or ("forkserver" in words and not process.children())
    return False


def _kill(run, target, chance):
    """Kill a process of kind `target`; return False if there is no worker yet."""
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


def _fast(trial):
    """Kill a driver that runs without Dask, several times."""

    def disturb(driver):
        trial.wait(driver)
        trial.run.report.counts["kills of everything"] += driver.returncode is None

    trial.go([disturb] * 5)


def _from_another(trial):
    """Kill a driver that takes points from another store, whose axes end elsewhere."""
    run, old = trial.run, trial.folder / "old.zarr"
    code_of(trial.start(run.chance.choice(STAGES[:2]), old))
    trial.log = trial.folder / "noted later"
    trial.start = lambda stage: Forked(
        STAGES[-1], trial.path, trial.log, run.records, run.mistake, source=old
    )
    _fast(trial)


def _with_workers(trial, key):
    """Kill processes of a driver that runs on Dask."""
    (name, *options), always, trial.stages = _COMMANDS[key]
    scene = str(_SCENE).format(name)
    overrides = dict(map(_entry, always))
    overrides |= {"sweep.realizations": MOST_REALIZATIONS} if options else {}
    sweep = pipeline.load_scene(scene, overrides=overrides)
    trial.expected = _AsStored(sweep, trial.path)
    command = ["run", scene, *options, "-o", trial.path, "--workers", "2"]

    def by_command(stage):
        settings = [word for entry in (*always, *stage) for word in ("--set", entry)]
        return started(trial.log, *command, *settings, mistake=trial.run.mistake)

    trial.start = by_command
    targets = itertools.cycle(trial.run.chance.sample(_TARGETS, len(_TARGETS)))
    trial.go([lambda driver: _disturb(trial, driver, targets)] * 3)


def _disturb(trial, driver, targets):
    """Kill processes of a driver, one after the other, until the driver ends."""
    chance, counts = trial.run.chance, trial.run.report.counts
    limit, killed = time.monotonic() + PATIENCE, []
    while code_of(driver, chance.uniform(*_EVERY)) is None:
        if time.monotonic() > limit:
            trial.fault(f"it hangs after kills of {killed}")
            return
        if len(killed) < _KILLS and _kill(driver, target := next(targets), chance):
            killed.append(target)
            counts[f"kills of {target}"] += 1
    counts["given up"] += driver.returncode > 0
    words = trial.last_words()
    if driver.returncode > 0 and set(killed) <= {"worker"}:
        trial.fault(f"it ends with {driver.returncode} after kills of {killed}: {words}")


def _entry(text):
    """Path and value, as Python reads it, of a setting such as "fidelity.increments=6"."""
    name, _, value = text.partition("=")
    return name, tomllib.loads(f"value = {value}")["value"]


def campaign(run):
    """Disturb `run.count` sweeps, every fourth of them with workers."""
    following = itertools.cycle(_COMMANDS)
    for number, trial in enumerate(run.trials()):
        if number % 4 == 3:
            key = next(following)
            run.report.counts[f"by {key}"] += 1
            _with_workers(trial, key)
        elif number % 4 == 2:
            run.report.counts["by points of another store"] += 1
            _from_another(trial)
        else:
            _fast(trial)
