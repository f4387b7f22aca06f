"""The pages that a newcomer follows: each command and block runs in order, as typed."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.helpers import instruments

ROOT = Path(__file__).parents[2]
DIAGRAM = "make diagram"
LEFT_OUT = "make test", "pip install", DIAGRAM
"""Commands not run here: the suite itself, what needs a package index, and a test of its own."""
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
    (tmp_path / "scan.x3p").write_bytes(instruments.x3p(1e-6 * heights[:96, :64], (1e-6, 1e-6)))
    return tmp_path


def script_of(text):
    """Bash script of the blocks and tables of commands of a page, in order."""
    lines = ["set -ev"]
    for match in BLOCK.finditer(text):
        language, block, row = match.groups()
        saved = re.search(r"Save this as\s`(\S+)`[^`]*\Z", text[: match.start()])
        if row:
            lines += re.findall(r"`(irg \w+ [^`]+)`", row)
        elif saved or language == "toml":
            name = re.findall(r"`(\w+\.(?:toml|csv|py))`", text[: match.start()])[-1]
            lines += [f"cat > {name} <<'EOF'", block, "EOF"]
        elif language == "python":
            lines += ["python - <<'EOF'", block, "EOF"]
        elif language == "":
            assert re.match(r"irg |make |\. |python ", block), block
            lines += [line for line in block.splitlines() if not line.startswith(LEFT_OUT)]
    return "\n".join(lines)


def run(script, folder):
    """Run a script in bash, in the environment of the copy; return the lines that it prints."""
    command = ["bash", "-c", f"export PATH={Path(sys.executable).parent}:$PATH\n{script}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return [" ".join(line.split()) for line in done.stdout.splitlines()]


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("page", "commands"),
    [
        ("README.md", 6),
        ("workflows/FIRST_HOUR.md", 6),
        ("workflows/YOUR_SYSTEM.md", 6),
        ("workflows/OWN_LAWS.md", 1),
    ],
)
def test_what_a_page_shows_runs_as_typed_and_prints_what_it_shows(
    page, commands, copy, folder_with_results
):
    text = (ROOT / page).read_text(encoding="utf-8")
    script = script_of(text)
    script = script.replace("--accuracy 2%", "--accuracy 4%")  # of which pages have several
    assert len(re.findall(r"^(?:irg|python) \w", script, re.MULTILINE)) >= commands
    if "FIRST_HOUR" in page:  # README computes first_try from nothing, as typed
        shutil.copytree(folder_with_results / "results", copy / "results")
    printed = run(script, copy)
    for shown in re.findall(r"^```text\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        for line in filter(None, shown.splitlines()):
            assert " ".join(line.split()) in printed


@pytest.mark.slow
def test_the_diagram_of_the_first_screen_is_made(copy):
    assert f"\n{DIAGRAM} " in (ROOT / "README.md").read_text(encoding="utf-8")
    run(f"set -e\n{DIAGRAM}", copy)
    assert (copy / "results" / "irg_transition.png").stat().st_size > 10_000
