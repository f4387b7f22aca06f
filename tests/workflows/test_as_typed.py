"""The pages that a newcomer follows: each command and block runs in order, as typed."""

import contextlib
import io
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tribo
from pipeline.cli import main

ROOT = Path(__file__).parents[2]
DIAGRAM = "make diagram"
LEFT_OUT = "make test", "pip install", DIAGRAM
"""Commands not run here: the suite itself, what needs a package index, and a test of its own."""
COARSE = replace(tribo.PRESETS["standard"], pixels_per_element=8, fewest_elements=0, increments=4)
"""Choices that the suite takes for the preset on pages, in which a point takes milliseconds."""
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```|^\| (`irg .*?) \|", re.DOTALL | re.MULTILINE)


@pytest.fixture
def copy(tmp_path):
    """A copy of the repository with its environment, and small files of the names on the pages."""
    for name in ("README.md", "Makefile", "pyproject.toml", "pipeline", "tribo", "workflows"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "bin").symlink_to(Path(sys.executable).parent)
    (tmp_path / ".venv" / "run").touch()
    log = "load [N],velocity [m/s],outcome\n50,2,mild\n60,5,severe\n"
    (tmp_path / "log.csv").write_text(log)
    (tmp_path / "points.csv").write_text("load [N],velocity [m/s]\n50,2\n60,3\n")
    rng = np.random.default_rng(0)
    heights = rng.normal(scale=0.3, size=(560, 640)) + np.linspace(0, 5, 560)[:, None]  # tilted
    np.save(tmp_path / "disk.npy", heights)
    return tmp_path


def steps_of(text):
    """Steps of a page in order: a file and its text, "python" and a block, or "" and a command."""
    for match in BLOCK.finditer(text):
        language, block, row = match.groups()
        saved = re.search(r"Save this as\s`(\S+)`[^`]*\Z", text[: match.start()])
        if row:
            yield from (("", line) for line in re.findall(r"`(irg \w+ [^`]+)`", row))
        elif saved or language == "toml":
            yield re.findall(r"`(\w+\.(?:toml|csv|py))`", text[: match.start()])[-1], block
        elif language == "python":
            yield "python", block
        elif language == "":
            assert re.match(r"irg |make |\. |python ", block), block
            lines = block.replace("\\\n", " ").splitlines()
            yield from (("", line) for line in lines if not line.startswith(LEFT_OUT))


def run(steps):
    """Run the steps in the working folder, commands in this process; return the printed lines."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        for name, text in steps:
            words = shlex.split(text, comments=True) if not name else []
            if name == "python":
                exec(text, {"__name__": "page"})
            elif name:
                Path(name).write_text(text, encoding="utf-8")
            elif words[:1] == ["irg"]:
                assert main(words[1:]) == 0, text
            elif words:
                print(called(text))
    return [" ".join(line.split()) for line in printed.getvalue().splitlines()]


def called(line):
    """What a line prints in bash, in the environment of the copy."""
    command = ["bash", "-c", f"export PATH={Path(sys.executable).parent}:$PATH\n{line}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


PAGES = {"README": 6, "FIRST_HOUR": 6, "YOUR_SYSTEM": 6, "OWN_LAWS": 2}
"""Pages, and how many commands each has at least."""


def run_page(name, left_out=None):
    """Run what a page shows in the working folder; return its text and the printed lines.

    `left_out` is a pattern of text that is not run.
    """
    page = ROOT / "README.md" if name == "README" else ROOT / "workflows" / f"{name}.md"
    text = page.read_text(encoding="utf-8")
    if left_out:
        text = re.sub(left_out, "", text)
    steps = [*steps_of(text)]
    typed = [step for name, step in steps if not name and step.startswith(("irg ", "python "))]
    assert len(typed) >= PAGES[name]
    return text, run(steps)


def test_what_the_first_page_shows_runs_on_coarse_elements(copy, monkeypatch):
    monkeypatch.setitem(tribo.PRESETS, "standard", COARSE)
    monkeypatch.chdir(copy)
    run_page("README", left_out=r"irg report[^\n]*\n")  # which takes the longest


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_shows_runs_as_typed_and_prints_what_it_shows(name, copy, monkeypatch):
    monkeypatch.chdir(copy)
    text, printed = run_page(name)
    for block in re.findall(r"^```text\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        for line in filter(None, block.splitlines()):
            assert " ".join(line.split()) in printed


@pytest.mark.slow
def test_the_diagram_of_the_first_screen_is_made(copy, monkeypatch):
    assert f"\n{DIAGRAM} " in (ROOT / "README.md").read_text(encoding="utf-8")
    monkeypatch.chdir(copy)
    called(DIAGRAM)
    assert (copy / "results" / "irg_transition.png").stat().st_size > 10_000
