"""The import rules of pyproject.toml, each broken on purpose in a copy."""

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
