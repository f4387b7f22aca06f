"""The pages that a newcomer follows: each command and block runs in order, as typed."""

import re
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
    (tmp_path / "duty.csv").write_text("load [N],velocity [m/s]\n50,2\n60,3\n")
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
        if row:
            lines += re.findall(r"`(irg \w+ [^`]+)`", row)
        elif language == "python":
            lines += ["python - <<'EOF'", block, "EOF"]
        elif language == "" and re.match(r"irg |make |\. ", block):
            lines += [line for line in block.splitlines() if not line.startswith(LEFT_OUT)]
        else:
            name = re.findall(r"`(\w+\.(?:toml|csv))`", text[: match.start()])[-1]
            lines += [f"cat > {name} <<'EOF'", block, "EOF"]
    return "\n".join(lines)


def run(script, folder):
    """Run a script in bash, in the environment of the copy."""
    command = ["bash", "-c", f"export PATH={folder}/.venv/bin:$PATH\n{script}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    "page", ["README.md", "workflows/FIRST_HOUR.md", "workflows/YOUR_SYSTEM.md"]
)
def test_what_a_page_shows_runs_as_typed(page, copy):
    script = script_of((ROOT / page).read_text(encoding="utf-8"))
    assert script.count("\nirg ") >= 6
    run(script, copy)


@pytest.mark.slow
def test_the_diagram_of_the_first_screen_is_made(copy):
    assert f"\n{DIAGRAM} " in (ROOT / "README.md").read_text(encoding="utf-8")
    run(f"set -e\n{DIAGRAM}", copy)
    assert (copy / "results" / "irg_transition.png").stat().st_size > 10_000
