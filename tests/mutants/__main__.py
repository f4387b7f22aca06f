"""Change one operator, number, condition or statement at a time, and see whether a test turns red.

A mutant is compiled in memory, in a process that is forked from one with all libraries imported.
Asked are the tests that run the changed line, of a line outside functions all: first those of its
room (`tests/ROOM` and the examples), then those of all other rooms, each for `--seconds`. Programs
that a test starts run the code as it is; Dask's workers do not. What no test notices in that time
counts as not noticed. The exit code is 1 if a test fails on the code as it is, or a room notices
too few. `results/mutants.md` grows by a room at a time, or by part of one that `--minutes` end.
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
import time
import traceback
from collections import defaultdict
from contextlib import contextmanager, suppress
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest
from coverage import Coverage

from tests.helpers.campaigns import conclude, save, table
from tests.mutants.changes import changes

ROOT = Path(__file__).parents[2]
PACKAGES = "tribo", "pipeline"
ROOMS = [
    str(init.parent.relative_to(ROOT))
    for package in PACKAGES
    for init in sorted((ROOT / package).glob("*/__init__.py"))
]
OTHERS = "tests/*/test_*.py", "tests/workflows"
LIBRARIES = (
    "coverage",
    "dask",
    "distributed",
    "matplotlib",
    "numpy",
    "pandas",
    "pint",
    "scipy",
    "xarray",
)
LIBRARIES += ("bokeh", "fsspec", "numcodecs", "PIL", "psutil", "tqdm", "zarr")
MUTANT = "MUTANT_OF_IRG"  # environment variable: module and number of the change
MEMORY = Path("/dev/shm")
QUIETLY = ["-q", "-p", "no:cacheprovider", "--tb", "no", "--timeout", "0"]
QUIETLY += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # libraries are already imported


def install(module, number):
    """Make imports of `module` compile its mutant with change `number`, not its source."""
    tree = ast.parse((ROOT / module).read_text())
    list(changes(tree))[number].make()
    usual = SourceFileLoader.get_code

    def get_code(loader, name):
        if loader.path == str(ROOT / module):
            return compile(tree, loader.path, "exec")
        return usual(loader, name)

    SourceFileLoader.get_code = get_code


if MUTANT in os.environ:  # in this process, or in a worker, which runs this file first
    install(*json.loads(os.environ[MUTANT]))


class Lines:
    """Pytest plugin that records the lines of the packages that each test and its fixtures run."""

    def __init__(self):
        packages = [str(ROOT / package / "*") for package in PACKAGES]
        self.coverage = Coverage(data_file=None, config_file=False, include=packages)
        self.coverage.set_option("run:core", "ctrace")  # this tracer supports contexts
        self.now, self.uses = "none", defaultdict(set)
        self.seconds, self.red = {}, set()
        usual = pytest.FixtureDef.execute

        def execute(fixture, request):
            key = f"{fixture.baseid} {fixture.argname} {id(fixture)}"
            self.uses[self.now].add(key)
            with self.noted(key):
                return usual(fixture, request)

        pytest.FixtureDef.execute = execute  # called even if the fixture's value exists already
        self.coverage.start()

    @contextmanager
    def noted(self, key):
        before, self.now = self.now, key
        self.coverage.switch_context(key)
        try:
            yield
        finally:
            self.now = before
            self.coverage.switch_context(before)

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
        """Lines and duration [s] of each test that passes."""
        self.coverage.stop()
        data, lines = self.coverage.get_data(), defaultdict(set)
        for file in data.measured_files():
            for line, keys in data.contexts_by_lineno(file).items():
                for key in keys:
                    lines[key].add((file, line))
        for test in [test for test in self.seconds if test not in self.red]:
            keys, found = [test], {test}
            for key in keys:
                keys += self.uses[key] - found
                found |= self.uses[key]
            yield test, set().union(*(lines[key] for key in keys)), self.seconds[test]


class Chosen:
    """Pytest plugin that runs only these tests, in this order."""

    def __init__(self, tests):
        self.rank = {test: number for number, test in enumerate(tests)}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if item.nodeid in self.rank]
        items.sort(key=lambda item: self.rank[item.nodeid])


def forked(function, *arguments, seconds=None):
    """Result of a function in a forked child process, which is killed after it; None if late."""
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


def mapped(folder):
    """Tests of a folder with lines and times, those that fail, and the libraries they import."""
    lines = Lines()
    own = [f"tests/{folder}", folder] if folder in ROOMS else [*map(str, ROOT.glob(folder))]
    code = pytest.main([*QUIETLY, *own], plugins=[lines])
    assert code in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED), code
    tests = list(lines.tests())
    needed = [name for name in sys.modules if name.split(".")[0] in LIBRARIES]
    return tests, lines.red, needed


def is_noticed(module, number, tests):
    """True if one of the tests fails on a mutant of the module, or cannot be collected."""
    os.environ[MUTANT] = json.dumps([module, number])
    install(module, number)
    files = [Path(test.split("::")[0]) for test in tests]
    # A module named on the command line would be read by pytest itself, without the mutation.
    paths = dict.fromkeys(file if "tests" in file.parts else file.parent for file in files)
    return pytest.main([*QUIETLY, "-x", *map(str, paths)], plugins=[Chosen(tests)]) != 0


def judge(room, maps, count, seed, seconds, end):
    """Number of mutants of a package, and the changes that no test notices.

    At the time `end` [s] no other mutant is begun.
    """
    tests = [
        sorted((test for folder in folders for test in maps[folder]), key=lambda test: test[2])
        for folders in ([room], [folder for folder in maps if folder != room])
    ]
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
        lines = {(str(file), line) for line in change.lines}
        for part in tests:
            nearest = [test for test in part if lines & test[1]]
            if not change.is_in_function:
                nearest += [test for test in part if test not in nearest]
            affordable, total = [], 0.0
            for test, _, took in nearest:
                if total <= seconds:
                    affordable.append(test)
                    total += took
            affordable.sort(key=lambda test: test.split("::")[0])  # file by file, to share fixtures
            arguments = str(file.relative_to(ROOT)), number, affordable
            late = 20.0 + 5.0 * total
            if affordable and forked(is_noticed, *arguments, seconds=late) is not False:
                break
        else:
            missed.append(f"{file.relative_to(ROOT)}:{change.lines[0]} {change}")
    return judged, missed


def main():
    """Judge the packages, and print a table of the results."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--rooms", nargs="+", choices=ROOMS, default=ROOMS, metavar="ROOM")
    parser.add_argument("--mutants", type=int, default=60, help="number of each room")
    parser.add_argument("--seconds", type=float, default=30.0, help="of tests for each mutant")
    parser.add_argument("--least", type=float, default=0.7, help="share that each room notices")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=600.0, help="after which it ends")
    options = parser.parse_args()
    rows, notes, is_right, end = [], [], True, time.monotonic() + 60 * options.minutes
    maps = {}
    for folder in (*ROOMS, *OTHERS):
        began = time.monotonic()
        maps[folder], red, needed = forked(mapped, folder)
        print(
            folder, f"{time.monotonic() - began:.0f} s", *sorted(red), file=sys.stderr, flush=True
        )
        notes += [f"- fails on the code as it is: {test}" for test in sorted(red)]
        is_right &= not red
        for name in needed:
            with suppress(Exception):
                importlib.import_module(name)
    for room in options.rooms:
        began = time.monotonic()
        count, missed = judge(room, maps, options.mutants, options.seed, options.seconds, end)
        noticed = count - len(missed)
        share = f"{noticed / count:.0%}" if count else "not judged"
        rows.append((f"`{room}`", count, noticed, share, f"{time.monotonic() - began:.0f}"))
        print(*rows[-1], *missed, sep="\n  ", file=sys.stderr, flush=True)
        notes += [f"- not noticed: {change}" for change in missed]
        is_right &= noticed >= options.least * count > 0
        head = "room", "mutants", "noticed", "share", "seconds"
        found = "\n".join([table(head, rows), "", *notes])
        save("mutants", found, is_right)
    return conclude("mutants", found, is_right)


if __name__ == "__main__":
    sys.exit(main())
