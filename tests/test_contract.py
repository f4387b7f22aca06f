"""The import rules of pyproject.toml, each broken on purpose in a copy, and types of calls."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
VIOLATIONS = {
    "Imports run downwards": ("tribo/contact/solver.py", "import tribo.wear"),
    "No circles": ("tribo/contact/elasticity.py", "import tribo.contact.solver"),
    "Closed forms import no solver": ("tribo/analytic/heat.py", "import tribo.numerics"),
    "Answers know no scenes": ("pipeline/answers/pchip.py", "import pipeline.scene.entries"),
    "Only pipeline.store knows zarr": ("pipeline/answers/answers.py", "import zarr"),
    "Only pipeline.run knows dask": ("pipeline/store/lock.py", "import distributed"),
}


def test_each_contract_is_broken_by_its_violation(tmp_path):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for package in ("tribo", "pipeline", "workflows"):
        shutil.copytree(ROOT / package, tmp_path / package)
    for file, statement in VIOLATIONS.values():
        with (tmp_path / file).open("a") as module:
            module.write(f"\n{statement}\n")
    done = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    assert done.returncode == 1
    assert {contract["name"] for contract in settings["contracts"]} == set(VIOLATIONS)
    assert set(re.findall("^(.*) BROKEN$", done.stdout, re.MULTILINE)) == set(VIOLATIONS)


CALLS = """
from pathlib import Path
import numpy as np
import pipeline
ds = pipeline.open_sweep("a.zarr")
pipeline.boundary(Path("a.zarr"), friction=np.array([0.1, 0.15, 0.2]))
pipeline.temperatures(ds)
pipeline.margin(ds, "400 N", 1.5)["verdict"].item()
pipeline.margin("a.zarr", {"load": ["400 N"], "velocity": [2.0]})["verdict"]
pipeline.margin(ds, "400 N", 1.5, friction=0.12)["probability"]
pipeline.plot(ds, "ramp", load="400 N", out="a.png")
"""
SLIPS = """
import pipeline
ds = pipeline.open_sweep("a.zarr")
pipeline.margin(ds, "400 N", 1.5, frction=0.12)
pipeline.plot(ds, "diagramm")
pipeline.plot(ds, "ramp", lod="400 N")
pipeline.load_scene("first_try", preset="drat")
pipeline.run_sweep("first_try", "a.zarr", workers="4")
"""


@pytest.fixture(scope="module")
def refused(tmp_path_factory):
    """Numbers of the lines of both scripts that mypy refuses, by name of the script."""
    folder = tmp_path_factory.mktemp("calls")
    for name, text in (("calls", CALLS), ("slips", SLIPS)):
        (folder / f"{name}.py").write_text(text)
    command = [sys.executable, "-m", "mypy", "--hide-error-context", *folder.glob("*.py")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    found = re.findall(r"(\w+)\.py:(\d+): error", done.stdout)
    return {name: {int(line) for one, line in found if one == name} for name in ("calls", "slips")}


def test_a_type_checker_finds_slips_of_a_user(refused):
    lines = SLIPS.splitlines()
    right = 'ds = pipeline.open_sweep("a.zarr")'
    assert refused["slips"] == {
        number for number, line in enumerate(lines, 1) if "(" in line and line != right
    }


def test_a_type_checker_accepts_the_calls_that_the_pages_describe(refused):
    assert refused["calls"] == set()
