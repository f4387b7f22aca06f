"""Run the tests of the core in a copy that has no extra: they need none of them.

    python -m tests.core                                 # all rooms of the core and `tribo`
    python -m tests.core tests/pipeline/sweep/test_plan.py

A test that asks for an extra stands in `NEEDS` and fails there; every other one passes. The exit
code is 1 if that is not so.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from pipeline.extras import EXTRAS

ROOT = Path(__file__).parents[1]
CORE = ("analysis", "cli", "figures", "run", "scene", "store", "sweep", "tradeoff")
NEEDS = {
    "uncertain": """
        figures.plot.plot$ figures/test_(fit|marks|plot|refusals) run/test_samples
        scene/test_(reference|scenefile).*uncertain scene/test_reference.*writes_and_lists
        scene/test_refusals.*(distribution|row.samples) scene/test_wear_laws.*(unknown|of_another)
        scene/test_kept store/test_create analysis/test_refusals
        sweep/test_(correlation|descriptions|refusals|words)
        tradeoff/test_forecast.*share_the_time
    """,
    "laboratory": """
        cli/test_commands.*duty.csv cli/test_points.*(German|xlsx|each_row|not_used|rotation)
        cli/test_refusals.*(word|every_refusal)
        scene/test_along.*rotation scene/test_extends.*beside
        scene/test_refusals.*(measured.seeds|scan|points.decimals|every_refusal)
        scene/test_scenefile.*realizations
    """,
    "page": """
        analysis/test_friction_curve analysis/test_soundness.*(explore|large_store)
    """,
}
"""Tests of the core that ask for an extra: patterns of their names."""


def copied(folder):
    """A copy of the tree without its extras and their tests."""
    left_out = shutil.ignore_patterns(*EXTRAS, "*.pyc.*", "*.png", "*.ipynb")
    for name in ("tribo", "pipeline", "workflows", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=left_out)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def failed(folder, tests):
    """Names of the tests that fail in a copy, and what pytest says in the end."""
    command = [sys.executable, "-m", "pytest", "-q", "--tb=line", "-rfE", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [*command, "--continue-on-collection-errors", *tests],
        cwd=folder, env=os.environ | {"PYTHONPATH": str(folder)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        sys.exit(done.stdout + done.stderr)
    found = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, flags=re.MULTILINE)
    return found, done.stdout.splitlines()[-1:] + done.stderr.splitlines()


def main(tests=()):
    """Run the tests; return the exit code."""
    patterns = [word for words in NEEDS.values() for word in words.split()]
    with tempfile.TemporaryDirectory() as folder:
        names, end = failed(
            copied(Path(folder)),
            tests or ["tribo", "pipeline", *(f"tests/pipeline/{room}" for room in CORE)],
        )
    wrong = [name for name in names if not any(re.search(one, name) for one in patterns)]
    stale = [one for one in patterns if not tests and not any(re.search(one, n) for n in names)]
    lines = [f"fails without extras: {name}" for name in wrong]
    lines += [f"needs no extra: {pattern}" for pattern in stale]
    print("\n".join([*lines, *end]))
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
