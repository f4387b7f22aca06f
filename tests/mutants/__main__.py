"""Change one operator, number, condition or statement at a time, and see whether a test turns red.

A mutant is compiled in memory, in a process that is forked from one with all libraries imported.
Its tests are those of the room (`tests/ROOM` and the examples) that run the changed line; of a line
outside functions all. Programs that a test starts run the code as it is; Dask's workers do not.
What no test notices in `--seconds` counts as not noticed. The exit code is 1 if a test fails on the
code as it is, or a room notices too few. `results/mutants.md` grows by a room at a time; of a room
that `--minutes` end it has the mutants until then.
"""

import argparse
import ast
import importlib
import json
import os
import pickle
import random
import shutil
import signal
import sys
import tempfile
import threading
import time
import traceback
from collections import defaultdict
from contextlib import contextmanager, suppress
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

from tests.helpers.campaigns import conclude, save, table
from tests.mutants.changes import changes

ROOT = Path(__file__).parents[2]
ROOMS = [
    str(init.parent.relative_to(ROOT))
    for package in ("tribo", "pipeline")
    for init in sorted((ROOT / package).glob("*/__init__.py"))
]
LIBRARIES = ("dask", "distributed", "matplotlib", "numpy", "pandas", "pint", "scipy", "xarray")
LIBRARIES += ("bokeh", "fsspec", "numcodecs", "PIL", "psutil", "tqdm", "zarr")
MUTANT = "MUTANT_OF_IRG"  # variable of the environment: module and number of the change
MEMORY = Path("/dev/shm")
QUIETLY = ["-q", "-p", "no:cacheprovider", "--tb", "no", "--timeout", "0"]
QUIETLY += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # libraries are imported already


def install(module, number):
    """Have the import system compile the mutant where it would read the module."""
    tree = ast.parse((ROOT / module).read_text())
    list(changes(tree))[number].make()
    usual = SourceFileLoader.get_code

    def get_code(loader, name):
        if loader.path == str(ROOT / module):
            return compile(tree, loader.path, "exec")
        return usual(loader, name)

    SourceFileLoader.get_code = get_code


if MUTANT in os.environ:  # here, or in a worker, which runs this file before all else
    install(*json.loads(os.environ[MUTANT]))


class Lines:
    """Plugin of pytest: the lines of a room that each test runs, and those of its fixtures."""

    def __init__(self, room):
        self.folder, self.now = str(ROOT / room), None
        self.lines, self.uses = defaultdict(set), defaultdict(set)
        self.seconds, self.red, self.places = {}, set(), {}
        usual = pytest.FixtureDef.execute

        def execute(fixture, request):
            self.uses[self.now].add(fixture)
            with self.noted(fixture):
                return usual(fixture, request)

        pytest.FixtureDef.execute = execute  # asked for a value that is there already, too
        sys.settrace(self.follow)
        threading.settrace(self.follow)

    @contextmanager
    def noted(self, key):
        before, self.now = self.now, key
        try:
            yield
        finally:
            self.now = before

    def follow(self, frame, event, argument):
        return self.note if frame.f_code.co_filename.startswith(self.folder) else None

    def note(self, frame, event, argument):
        place = frame.f_code.co_filename, frame.f_lineno
        self.lines[self.now].add(self.places.setdefault(place, place))
        return self.note

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        began = time.monotonic()
        with self.noted(item.nodeid):
            result = yield
        self.seconds[item.nodeid] = time.monotonic() - began
        return result

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.red.add(report.nodeid)

    def tests(self):
        """The lines of each test that passes, and its time [s]."""
        for test in [test for test in self.seconds if test not in self.red]:
            keys, found = [test], {test}
            for key in keys:
                keys += self.uses[key] - found
                found |= self.uses[key]
            yield test, set().union(*(self.lines[key] for key in keys)), self.seconds[test]


class Chosen:
    """Plugin of pytest: these tests alone, in this order."""

    def __init__(self, tests):
        self.rank = {test: number for number, test in enumerate(tests)}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if item.nodeid in self.rank]
        items.sort(key=lambda item: self.rank[item.nodeid])


def forked(function, *arguments, seconds=None):
    """What a function returns in a child, which ends with all that it started; None if late."""
    folder = tempfile.mkdtemp(dir=MEMORY if MEMORY.is_dir() else None)
    result, error = Path(folder, "result"), Path(folder, "error")
    pid = os.fork()
    if pid == 0:
        os.setsid()
        os.environ["PYTEST_DEBUG_TEMPROOT"] = folder
        for descriptor in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
        try:
            result.write_bytes(pickle.dumps(function(*arguments)))
        except Exception:
            error.write_text(traceback.format_exc())
        finally:
            os._exit(0)
    end = time.monotonic() + (seconds or 3600.0)
    while not (ended := os.waitpid(pid, os.WNOHANG)[0]) and time.monotonic() < end:
        time.sleep(0.01)
    with suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)
    if not ended:
        os.waitpid(pid, 0)
    if error.exists():
        sys.exit(error.read_text())
    found = pickle.loads(result.read_bytes()) if ended and result.exists() else None
    shutil.rmtree(folder, ignore_errors=True)
    return found


def mapped(room):
    """Tests of a room with their lines and times, those that fail, and the libraries they need."""
    lines = Lines(room)
    code = pytest.main([*QUIETLY, f"tests/{room}", room], plugins=[lines])
    sys.settrace(None)
    assert code in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED), code
    needed = [name for name in sys.modules if name.split(".")[0] in LIBRARIES]
    return list(lines.tests()), lines.red, needed


def is_noticed(module, number, tests):
    """True if one of the tests fails on a mutant, or cannot be collected."""
    os.environ[MUTANT] = json.dumps([module, number])
    install(module, number)
    files = [Path(test.split("::")[0]) for test in tests]
    # A module that is named itself would be read by pytest, which would know of no mutant.
    paths = dict.fromkeys(file if "tests" in file.parts else file.parent for file in files)
    return pytest.main([*QUIETLY, "-x", *map(str, paths)], plugins=[Chosen(tests)]) != 0


def judge(room, count, seed, seconds, end):
    """Number of mutants of a room, the changes that its tests do not notice, and red tests.

    At the time `end` [s] no other mutant is begun.
    """
    found = forked(mapped, room, seconds=max(1.0, end - time.monotonic()))
    if found is None:
        return 0, [], set()
    tests, red, needed = found
    for name in needed:
        with suppress(Exception):
            importlib.import_module(name)
    by_file = defaultdict(float)
    for test, _, took in tests:
        by_file[test.split("::")[0]] += took
    tests.sort(key=lambda test: by_file[test[0].split("::")[0]])
    choice = [
        (file, number, change)
        for file in sorted((ROOT / room).rglob("*.py"))
        for number, change in enumerate(changes(ast.parse(file.read_text())))
    ]
    drawn = random.Random(f"{seed} {room}").sample(choice, min(count, len(choice)))
    missed, judged = [], 0
    for file, number, change in drawn:
        if time.monotonic() > end:
            break
        judged += 1
        module, lines = str(file.relative_to(ROOT)), {(str(file), line) for line in change.lines}
        nearest = [test for test in tests if lines & test[1]]
        if not change.is_in_function:
            nearest += [test for test in tests if test not in nearest]
        affordable, total = [], 0.0
        for test, _, took in nearest:
            if total <= seconds:
                affordable.append(test)
                total += took
        arguments = module, number, affordable
        if not affordable or forked(is_noticed, *arguments, seconds=20.0 + 5.0 * total) is False:
            missed.append(f"{module}:{change.lines[0]} {change}")
    return judged, missed, red


def main():
    """Judge the rooms, and write their table."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--rooms", nargs="+", choices=ROOMS, default=ROOMS, metavar="ROOM")
    parser.add_argument("--mutants", type=int, default=60, help="number of each room")
    parser.add_argument("--seconds", type=float, default=30.0, help="of tests for each mutant")
    parser.add_argument("--least", type=float, default=0.7, help="share that each room notices")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=600.0, help="after which it ends")
    options = parser.parse_args()
    rows, notes, is_right, end = [], [], True, time.monotonic() + 60 * options.minutes
    for room in options.rooms:
        began = time.monotonic()
        count, missed, red = judge(room, options.mutants, options.seed, options.seconds, end)
        noticed = count - len(missed)
        share = f"{noticed / count:.0%}" if count else "not judged"
        rows.append((f"`{room}`", count, noticed, share, f"{time.monotonic() - began:.0f}"))
        print(*rows[-1], file=sys.stderr, flush=True)
        notes += [f"- fails on the code as it is: {test}" for test in sorted(red)]
        notes += [f"- not noticed: {change}" for change in missed]
        is_right &= not red and noticed >= options.least * count > 0
        head = "room", "mutants", "noticed", "share", "seconds"
        found = "\n".join([table(head, rows), "", *notes])
        save("mutants", found, is_right)
    return conclude("mutants", found, is_right)


if __name__ == "__main__":
    sys.exit(main())
