"""Changes of formulas, bounds, rules and sentences, which the tests of their room have to notice.

`make mutants` makes each change of `mutants.toml` in a copy of the tree, and runs the tests named
with it there. A change that they do not notice survives, and fails the run.
"""

import functools
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Mutant:
    """A change: in a `file` the text `old`, which occurs once, becomes `new`."""

    file: str
    old: str
    new: str
    tests: str

    def applied(self, root=ROOT):
        """Text of the file below `root` after the change."""
        text = (root / self.file).read_text(encoding="utf-8")
        if text.count(self.old) != 1 or self.old == self.new:
            raise ValueError(f"{self.file}: {self.old!r} occurs {text.count(self.old)} times")
        return text.replace(self.old, self.new)


def mutants():
    """All changes of the table."""
    table = tomllib.loads((ROOT / "tests/mutants.toml").read_text(encoding="utf-8"))
    return [
        Mutant(file, old, new, changes["tests"])
        for file, changes in table.items()
        for old, new in changes["changes"]
    ]


def run_tests(folder, tests):
    """Run tests of a copy of the tree until one fails; return the process that ended."""
    options = "-x", "-q", "-p", "no:cacheprovider", f"--basetemp={folder}/.tests", "--tb=line"
    variables = {"PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-m", "pytest", *options, *tests], cwd=folder,
        env=os.environ | variables, capture_output=True, text=True, check=False,
    )  # fmt: skip


def judge(copies, mutant):
    """Make a change in one of the copies, test it, and take it back; True if it is noticed."""
    folder = copies.get()
    file = folder / mutant.file
    before = file.read_text(encoding="utf-8")
    try:
        file.write_text(mutant.applied(folder), encoding="utf-8")
        ended = run_tests(folder, mutant.tests.split())
    finally:
        file.write_text(before, encoding="utf-8")
        copies.put(folder)
    failed = [line for line in ended.stdout.splitlines() if line.startswith("FAILED ")]
    words = failed[0].partition(" - ")[0] if failed else "SURVIVED"
    print(f"{mutant.file}: {mutant.old} -> {mutant.new}: {words}", flush=True)
    return bool(failed)


def main(chosen=""):
    """Judge all changes, or those of files whose name has a text in it; 1 if one survives."""
    changes = [change for change in mutants() if chosen in change.file]
    tracked = subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).split()
    copies = queue.Queue()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(os.cpu_count() or 1):
            copy = Path(folder) / str(number)
            for file in filter(Path.is_file, map(ROOT.joinpath, tracked)):
                (target := copy / file.relative_to(ROOT)).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(file, target)
            copies.put(copy)
        unchanged = run_tests(
            copy, sorted({test for change in changes for test in change.tests.split()})
        )
        if unchanged.returncode:
            sys.exit(f"{unchanged.stdout}\nthese tests fail without a change")
        with ThreadPoolExecutor(copies.qsize()) as pool:
            noticed = list(pool.map(functools.partial(judge, copies), changes))
    print(f"{sum(noticed)} of {len(noticed)} changes are noticed")
    sys.exit(not all(noticed))


if __name__ == "__main__":
    main(*sys.argv[1:])
