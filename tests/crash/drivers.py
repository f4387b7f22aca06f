"""Two drivers at once by two paths to one store, whose lock may be deleted meanwhile.

Links, a path with dots, and a bind mount of the store itself, as containers have it. Nothing is
lost that either was told is done; one that finds the other at work ends with a word.
"""

import signal
import subprocess
import sys
from contextlib import contextmanager
from functools import partial

from pipeline.store.place import LOCK
from tests.crash.drive import GIVEN_UP
from tests.crash.loop import Forked, Trial, code_of, end
from tests.crash.sweeps import STAGES, Expected

TRIALS = 8
MISTAKE = "unlocked"
_PACE = 0.03  # [s] between commits
_MANNERS = ("together", "later", "lock deleted", "lock a link")


def _paths(out, mounted):
    """Paths to one store."""
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
    """Mount a store at another place, too, if this process may."""
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


class _Pair:
    """A second driver beside a first one."""

    def __init__(self, trial, other, chance, report):
        self._trial, self._other, self._chance, self._report = trial, other, chance, report

    def __call__(self, run):
        manner = self._chance.choice(_MANNERS)
        self._report.counts[f"pairs, {manner}"] += 1
        lock, precious = self._trial.path / LOCK, self._trial.path.parent / "precious"
        if manner != "together":
            code_of(run, self._chance.uniform(0.0, 0.6))
        if manner == "lock deleted":
            self._trial.may_repeat = True
            lock.unlink(missing_ok=True)
        if manner == "lock a link" and lock.parent.is_dir():
            precious.write_text("nothing to be emptied")
            lock.unlink(missing_ok=True)
            lock.symlink_to(precious)
        second = self._other(STAGES[-1])
        if self._chance.random() < 0.5:
            self._report.counts["pairs killed"] += 1
            self._trial.wait(second, self._chance)
            run.kill()
            second.kill()
        codes = code_of(run), code_of(second)
        second.kill()
        second.wait()
        if set(codes) - {0, 1, GIVEN_UP, -signal.SIGKILL}:
            self._trial.fault(f"{manner}: the drivers end with {codes}")
        if lock.is_symlink():
            if codes[1] in (0, 1) or precious.read_text() != "nothing to be emptied":
                self._trial.fault(f"{manner}: a lock that is a link was followed, {codes}")
            lock.unlink()
        self._report.counts["drivers that gave way"] += codes.count(GIVEN_UP)


def campaign(folder, trials, chance, report, mistake=None):
    """Start so many pairs of drivers."""
    expected = Expected(STAGES[-1])
    known = expected.records(STAGES[-1])
    for number in range(trials):
        place = folder / str(number)
        place.mkdir()
        path, log = place / "out.zarr", place / "acknowledged"

        def start(sweep, to=path, log=log):
            return Forked(sweep, to, log, known, mistake, _PACE)

        run = start(STAGES[0])
        while run.poll() is None and not path.exists():
            code_of(run, 0.01)
        end(run)
        with _bound(path) as mounted:
            report.counts["bind mounts"] += mounted is not None
            paths = list(_paths(path, mounted))
            trial = Trial(report, path, expected, log, start)
            trial.go([_Pair(trial, partial(start, to=chance.choice(paths)), chance, report)] * 3)
        print(f"drivers: {number + 1} of {trials}, {len(report.faults)} faults", file=sys.stderr)
