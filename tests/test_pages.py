"""The pages: a site whose links and references all hold, and the same in a terminal."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WORKFLOWS = ROOT / "workflows"


@pytest.mark.parametrize("has_reference", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_site_builds_without_a_warning(tmp_path, has_reference):
    """A short run leaves out the reference of names, which takes most of the time."""
    shutil.copy(ROOT / "README.md", tmp_path)
    (tmp_path / "pipeline").symlink_to(ROOT / "pipeline")
    pages = shutil.copytree(WORKFLOWS, tmp_path / "workflows")
    if not has_reference:
        api = (pages / "API.md").read_text(encoding="utf-8")
        without, count = re.subn(r"```{eval-rst}.*?```", "", api, flags=re.DOTALL)
        assert count == 5
        (pages / "API.md").write_text(without, encoding="utf-8")
    build = ["-q", "-W", "--keep-going", "-b", "dummy"]
    # This builder cannot show notebooks' pictures; conf.py also suppresses the other warning.
    build += ["-D", "suppress_warnings=myst.domains,mystnb.mime_priority"]
    command = [sys.executable, "-m", "sphinx", *build, pages, tmp_path / "site"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=250)
    assert done.returncode == 0, done.stderr


def test_every_page_is_in_the_contents():
    listed = re.findall(r"^(?:.*<)?(\w+)>?$", (WORKFLOWS / "index.md").read_text(), re.MULTILINE)
    assert {path.stem for path in WORKFLOWS.glob("*.md")} - {"index"} <= set(listed)


def test_the_front_shows_four_figures():
    front = (ROOT / "README.md").read_text() + (WORKFLOWS / "index.md").read_text()
    figures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", front)
    assert len(set(figures)) == 4
    assert all((WORKFLOWS / Path(name).name).exists() for name in figures)
