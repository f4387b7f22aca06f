"""Python on the code of this checkout, in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def python(*arguments, variables=(), before=(), **options):
    """Run Python in a subprocess, with environment variables and a command prefix ``before``."""
    usual = {"capture_output": True, "text": True, "check": False, "timeout": 200}
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | dict(variables)
    command = [*before, sys.executable, *map(str, arguments)]
    return subprocess.run(command, env=environment, **(usual | options))
