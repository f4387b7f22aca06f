"""A type checker accepts the calls that the pages describe, and finds slips in them."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
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
