"""The wheel works alone, and the source archive has no stray files."""

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Folder with the content of the wheel, without the source."""
    folder = tmp_path_factory.mktemp("wheel")
    wheel = next(WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"]))
    zipfile.ZipFile(wheel).extractall(folder / "site")
    return folder / "site"


def run(installed, tmp_path, *command):
    done = subprocess.run(
        [sys.executable, *command],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_shipped_scenes_come_with_the_wheel(installed, tmp_path):
    program = """if True:
        from pipeline.cli import main
        from pipeline.shipped import WORKFLOWS

        print(WORKFLOWS)
        main(["new", "record.toml", "--from", "fig8"])
    """
    where, *_ = run(installed, tmp_path, "-c", program).splitlines()
    assert where == str(installed / "pipeline/workflows")
    names = {path.name for path in (ROOT / "workflows").glob("*.toml")}
    assert {path.name for path in (installed / "pipeline/workflows").glob("*.toml")} == names
    assert (tmp_path / "fig8_load_record.csv").exists()


def test_the_page_of_a_package_index_has_no_link_that_leads_nowhere(installed):
    (metadata,) = installed.glob("*.dist-info/METADATA")
    text = metadata.read_text(encoding="utf-8")
    assert "# IRG transition diagrams, computed" in text
    assert not re.findall(r"\]\((?!https?:)[^)]*\)", text)


def test_the_wheel_holds_all_of_both_packages_and_of_the_paper(installed):
    files = {path.relative_to(installed).as_posix() for path in installed.rglob("*")}
    assert {name for name in tracked() if name.startswith(("tribo/", "pipeline/"))} <= files
    paper = {name for name in tracked() if name.startswith("workflows/paper/")}
    assert {f"pipeline/{name}" for name in paper} <= files


def tracked():
    """Files that git tracks; empty outside a checkout."""
    done = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False, timeout=60
    )
    if not (ROOT / ".git").exists() or done.returncode:
        pytest.skip("no checkout of git")
    return set(done.stdout.split())
