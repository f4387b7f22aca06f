"""The page's scripts, checked as the Python is: types by TypeScript, style by ESLint."""

import subprocess
from pathlib import Path

import pytest

from tests.helpers.browser import absent

ROOT = Path(__file__).parents[3]
TOOLS = ROOT / ".venv/javascript/node_modules/.bin"
HERE = Path(__file__).parent / "javascript"
CHECKS = {
    "tsc": ["--project", HERE / "tsconfig.json"],
    "eslint": ["--config", HERE / "eslint.config.mjs", "--max-warnings", "0", "pipeline"],
}


@pytest.mark.parametrize("tool", CHECKS)
def test_the_scripts_are_clean(tool):
    if not (TOOLS / tool).exists():
        absent(f"no {tool}: make javascript installs it, where there is npm")
    done = subprocess.run(
        [TOOLS / tool, *CHECKS[tool]], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
