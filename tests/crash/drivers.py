"""Two drivers at once by two paths to one store, whose lock may be deleted meanwhile.

Links, a path with dots, and a bind mount of the store itself, as containers have it. Nothing is
lost that either was told is done; one that finds the other at work ends with a word.
"""

import signal
import subprocess
from contextlib import contextmanager

from pipeline.store.place import LOCK, ROOT
from tests.crash.drive import GIVEN_UP
from tests.crash.loop import code_of, end
from tests.crash.sweeps import STAGES

TRIALS = 8
MISTAKE = "unlocked"
_PACE = 0.03  # time between commits [s]
_MANNERS = ("together", "later", "lock deleted", "lock a link")


def _paths(out, mounted):
    """Yield different paths to the store `out`: links, a path with dots, and a bind mount."""
    (out.parent / "alias.zarr").symlink_to(out)
    (out.parent / "linked").symlink_to(out.parent)
    yield out
    yield out.parent / "alias.zarr"
    yield out.parent / "linked" / out.name
    yield out.parent / "linked" / ".." / out.parent.name / out.name
    if mounted:
        yield mounted


@contextmanager
def _bound(out):
    """Context: bind-mount a store at a second path, and yield it; None without permission."""
    target = out.parent / "container" / "store"
    target.mkdir(parents=True)
    done = subprocess.run(
        ["mount", "--bind", out, target], stderr=subprocess.DEVNULL, check=False
    ).returncode
    try:
        yield None if done else target
    finally:
        if not done:
            subprocess.run(["umount", target], check=True)


def _beside(trial, driver, path):
    """Start a second driver while a first one runs, by another path to the same store."""
    chance, counts = trial.run.chance, trial.run.report.counts
    manner = chance.choice(_MANNERS)
    counts[f"pairs, {manner}"] += 1
    lock, precious = trial.path / LOCK, trial.place / "precious"
    if manner != "together":
        code_of(driver, chance.uniform(0.0, 0.6))
    if manner == "lock deleted":
        trial.may_repeat = True
        lock.unlink(missing_ok=True)
    if manner == "lock a link" and lock.parent.is_dir():
        precious.write_text("nothing to be emptied")
        lock.unlink(missing_ok=True)
        lock.symlink_to(precious)
    second = trial.start(STAGES[-1], path)
    if chance.random() < 0.5:
        counts["pairs killed"] += 1
        trial.wait(second)
        driver.kill()
        second.kill()
    codes = code_of(driver), code_of(second)
    end(second)
    if set(codes) - {0, 1, GIVEN_UP, -signal.SIGKILL}:
        trial.fault(f"{manner}: the drivers end with {codes}")
    if lock.is_symlink():
        if codes[1] in (0, 1) or precious.read_text() != "nothing to be emptied":
            trial.fault(f"{manner}: a lock that is a link was followed, {codes}")
        lock.unlink()
    counts["drivers that gave way"] += codes.count(GIVEN_UP)


def campaign(run):
    """Start `run.count` pairs of drivers on one store each."""
    for trial in run.trials(_PACE):
        first = trial.start(STAGES[0])
        while first.poll() is None and not (trial.path / ROOT).exists():
            code_of(first, 0.01)
        end(first)
        with _bound(trial.path) as mounted:
            run.report.counts["bind mounts"] += mounted is not None
            path = run.chance.choice(list(_paths(trial.path, mounted)))
            trial.go([lambda driver, t=trial, path=path: _beside(t, driver, path)] * 3)
