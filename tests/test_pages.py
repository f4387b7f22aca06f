"""The pages: a site whose links and references all hold, and the same in a terminal."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
WORKFLOWS = ROOT / "workflows"


def test_the_site_builds_without_a_warning(tmp_path):
    """As on Read the Docs, and by `make docs`."""
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", WORKFLOWS, tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=250)
    assert done.returncode == 0, done.stderr
    assert "pipeline.Sweep" in (tmp_path / "API.html").read_text(encoding="utf-8")


def test_every_page_is_in_the_contents():
    listed = re.findall(r"^(?:.*<)?(\w+)>?$", (WORKFLOWS / "index.md").read_text(), re.MULTILINE)
    assert {path.stem for path in WORKFLOWS.glob("*.md")} - {"index"} <= set(listed)


def test_the_front_shows_four_figures():
    front = (ROOT / "README.md").read_text() + (WORKFLOWS / "index.md").read_text()
    figures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", front)
    assert len(set(figures)) == 4
    assert all((WORKFLOWS / Path(name).name).exists() for name in figures)
