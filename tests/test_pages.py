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


def test_make_scenes_draws_the_pictures_of_the_page_on_scenes():
    (names,) = re.findall(r"^SCENES = (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    pictures = re.findall(r"!\[[^\]]+\]\((\w+)\.png\)", (WORKFLOWS / "SCENES.md").read_text())
    assert pictures == names.split()
    assert all((WORKFLOWS / f"{name}.toml").exists() for name in pictures)
    sizes = [(WORKFLOWS / f"{name}.png").stat().st_size for name in pictures]
    assert 0 < min(sizes) <= max(sizes) < 60_000
