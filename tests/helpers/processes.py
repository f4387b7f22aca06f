"""Python on the code of this checkout, in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def python(*arguments, variables=(), **options):
    """Run Python in a subprocess, with environment variables."""
    usual = {"capture_output": True, "text": True, "check": False, "timeout": 200}
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | dict(variables)
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(command, env=environment, **(usual | options))
