"""The import rules of pyproject.toml, each broken on purpose in a copy, and types of calls."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
VIOLATIONS = {
    "Imports run downwards": ("tribo/contact/solver.py", "import tribo.wear"),
    "No circles": ("tribo/contact/elasticity.py", "import tribo.contact.solver"),
    "Closed forms import no solver": ("tribo/analytic/heat.py", "import tribo.numerics"),
    "Only pipeline.store knows zarr": ("pipeline/analysis/boundary.py", "import zarr"),
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
ds = pipeline.at("a.zarr", [0.1, 0.12], {"pin": "60 degC", "disk": 300.0}, "150 degC", "10%")
pipeline.at(Path("a.zarr"), np.array([0.1, 0.15, 0.2]), **{"pin.radius": "2 mm"})
pipeline.boundary(Path("a.zarr"))
pipeline.temperatures(ds)
pipeline.margin(ds, "400 N", 1.5)
pipeline.margin("a.zarr", {"load": ["400 N"], "velocity": [2.0]})["verdict"]
"""


def test_a_type_checker_accepts_the_calls_that_the_pages_describe(tmp_path):
    (tmp_path / "calls.py").write_text(CALLS)
    command = [sys.executable, "-m", "mypy", str(tmp_path / "calls.py")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
